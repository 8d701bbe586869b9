"""Accuracy against time, measured on a given mesh and scene.

Read `measure` first: `tradeoff`, and what it measures, in which order, as long as there is time. `result` is what a row
says, and the choice among the rows. `variants` light a mesh at its vertices and cast rays from them,
`interpolation` the meshes that are refined, `peers` other implementations; `timing` runs all of them in turns.
`physics` sets models of light beside paths of it. `report` has the result for its reader, and `figure` draws it.
"""
