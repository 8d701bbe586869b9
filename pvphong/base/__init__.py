"""Shared helpers that every other package uses, in reading order.

`types` and `check` (types of arguments, checks and their error messages), `handles` (objects whose unknown attributes
raise), `vectors` (arithmetic over the whole range of floats), `formulas` (operations for NumPy arrays and compiled
code), `sobol` (evenly distributed points), `color`, `threads` (ranges of vertices on all cores), `files` and
`documents` (atomic writes, and JSON), `processes` (a process that monitors a worker), `text` (reports and progress),
and `host` (functions of PyVista and VTK that the core calls without importing them).
"""
