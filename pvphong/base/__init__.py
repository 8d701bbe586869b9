"""Shared helpers that every other package uses.

In reading order:

- `types`: types of arguments.
- `check`: checks of arguments, and their error messages.
- `handles`: objects that raise an error when an unknown attribute is set.
- `vectors`: arithmetic on vectors of any length that floats can represent.
- `formulas`: operations that run both on NumPy arrays and in compiled code.
- `sobol`: evenly distributed points.
- `color`: conversions between colour spaces.
- `display`: linear colours to the bytes that a screen shows.
- `threads`: work on ranges of vertices, divided among all cores.
- `files`: atomic writes of files.
- `documents`: JSON files.
- `processes`: a process that monitors a worker process.
- `text`: reports and progress.
- `host`: functions of PyVista and VTK that the core calls without importing them.
"""
