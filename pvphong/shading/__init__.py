"""From a scene to colours: the equation, its plan, and the evaluators that run it."""
