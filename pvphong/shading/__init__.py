"""Lighting: from a scene to the colours of vertices.

The entry points are `Plan.of(...)` and `plan.run(vertices)`. In reading order:

- `equation`: the lighting equation of a scene and a material
- `limits`: bounds on the factors of reflectances
- `vertices`: data per vertex
- `visibility`: the interface to shadows, ambient occlusion and light transport
- `plan/`: the simplified equation, with reasons
- `kernel/`: the compiled evaluator
- `reference`: the evaluator in NumPy, written to be read; it also evaluates what the kernel does not support
- `interreflection`: the series of bounced light
- `evaluation`: `pvphong.evaluate` for NumPy arrays
- `inside/`: colours between the vertices, and the refinement of meshes whose interpolated colours are inaccurate

The calls from `mesh.phong.shade` to a formula: the accessor's method, `meshes.lit.shade_mesh`, `Plan.run`,
`reference.shade`, its `_shade_block` and `lobe_factors`, then the reflectance's `factors`. In compiled code, after
`Plan.run`: `kernel.evaluation.shade` and its `work` on a range of vertices, `kernel.driver.shade` and its `_add_light`,
a stage of `kernel.stages`, and the same `factors`.
"""
