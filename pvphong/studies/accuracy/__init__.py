"""Accuracy against time, measured on a given mesh and scene.

Read `measure` first: `tradeoff` and the order of its measurements. `result` holds the rows and the choice among them.
`variants` light a mesh at its vertices and cast rays from them; `interpolation` measures errors inside triangles and
refined meshes; `peers` are other implementations. `timing` runs all of them in turns. `physics` compares light models
with path tracing. `report` formats the result as text, tables and files, and `figure` draws it.
"""
