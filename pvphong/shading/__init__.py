"""From a scene to colours.

In reading order: `equation` is the lighting equation of a scene and a material, `limits` are bounds on reflectances,
`vertices` the data of the vertices, `visibility` the interface to shadows and occlusion. `plan/` simplifies the
equation. `kernel/` (compiled) evaluates it, or `reference` (NumPy, written to be read) if the kernel declines.
`interreflection` sums the series of bounced light. `Plan.of(...)` and `plan.run(vertices)` are the entry points;
`evaluation` is `pvphong.evaluate` for NumPy arrays, and `inside/` compares colours between vertices.

The calls from `mesh.phong.shade` to a formula: the accessor's method, `meshes.lit.shade_mesh`, `Plan.run`,
`reference.shade`, its `_shade_block` and `lobe_factors`, then the reflectance's `factors`. In compiled code, after
`Plan.run`: `kernel.evaluation.shade` and its `work` on a range of vertices, `kernel.driver.shade` and its `_add_light`,
a stage of `kernel.stages`, and the same `factors`.
"""
