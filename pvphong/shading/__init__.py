"""From a scene to colours.

In this order: `equation` is what a scene and a material come to, `limits` how much a reflectance can reflect,
`vertices` what is known where it is evaluated, `visibility` what runs before that; `plan/` leaves out what is not
needed, and what is left runs in `kernel/` (compiled) or, where that declines, in `reference` (NumPy, to be read); light
that bounces is a series of what they give, by `interreflection`. `Plan.of(...)` and `plan.run(vertices)` are the way
in; `evaluation` is `pvphong.evaluate` of NumPy's arrays, and `inside/` computes what happens between vertices.
"""
