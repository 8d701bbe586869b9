"""What accuracy costs in time, measured on one's own mesh and scene.

Read `rows` first: what a row of the report says. `measure` has `tradeoff` and what it measures, in which order, and
as long as there is time; `variants` are ways to light a mesh at its vertices and to cast rays from them,
`interpolation` the meshes that are refined, `peers` what others wrote, `timing` runs them in turns. `report` has the
result for its reader, `figure` draws it.
"""
