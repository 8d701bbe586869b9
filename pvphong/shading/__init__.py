"""From a scene to colours.

In this order: `equation` is what a scene and a material come to, `limits` how much a reflectance can reflect,
`vertices` what is known where it is evaluated, `visibility` what runs before that; `plan/` leaves out what is not
needed, and what is left runs in `kernel/` (compiled) or, where that declines, in `reference` (NumPy, to be read); light
that bounces is a series of what they give, by `interreflection`. `Plan.of(...)` and `plan.run(vertices)` are the way
in; `evaluation` is `pvphong.evaluate` of NumPy's arrays, and `inside/` computes what happens between vertices.

The walk from `mesh.phong.shade` to a formula: the accessor's method, `meshes.lit.shade_mesh`, `Plan.run`,
`reference.shade`, its `_shade_block` and `lobe_factors`, then the reflectance's `factors`. Compiled, after `Plan.run`:
`kernel.shade`, `kernel.evaluation.shade`, `base.threads.run` and the ranges that it gives out, `kernel.driver.shade`
and its `_add_light`, a stage of `kernel.stages`, and the same `factors`.
"""
