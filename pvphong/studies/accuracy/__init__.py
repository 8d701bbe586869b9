"""Accuracy against time, measured on a given mesh and scene. A variant is one way to light the mesh.

A row of the report has the errors and the time of one variant. A peer is a row for another implementation.

- `measure`: `tradeoff`, which makes all measurements, the most important ones first. Read it first.
- `result`: the rows, with their errors and times, and the choice of a row.
- `variants`: ways to light a mesh at its vertices, and to cast rays from them.
- `interpolation`: errors inside triangles, for the original mesh and for refined ones.
- `peers`: other implementations, for comparison.
- `timing`: time budgets, and interleaved timing of all variants.
- `physics`: light models compared with path tracing.
- `report`: the result as text, tables and files.
- `figure`: the result as a figure.
"""
