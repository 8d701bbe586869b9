"""Many files, lit by many processes: what to do, what is done already, what a worker does, and what came of it."""
