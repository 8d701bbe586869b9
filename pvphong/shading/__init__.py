"""From a scene to colours.

In this order: `assembly.py` makes the `equation.py` of a scene and a material, `origin.py` moves it to where the mesh
is, `plan/` leaves out what is not needed, `parts.py` takes lights with a size apart, and what is left runs in
`kernel/` (compiled) or, where that declines, in `reference.py` (NumPy, to be read). `Plan.of(...)` and
`plan.run(vertices)` are the way in; `evaluation.py` is `pvphong.evaluate` of NumPy's arrays.
"""
