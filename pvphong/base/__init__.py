"""What every other package stands on, in the order in which to read it.

`types` and `check` (types of arguments, and the one form of their error messages), `handles` (objects whose unknown
attributes raise), `vectors` (arithmetic over the whole range of floats), `formulas` (operations for arrays and for
compiled numbers alike), `sobol` (points spread evenly), `color`, `threads` (ranges of vertices on all cores), `files`
and `documents` (files that are whole or not at all, and JSON), `processes` (one that watches another), `text` (reports
and progress), and `host` (what the core asks of PyVista and VTK without importing them).
"""
