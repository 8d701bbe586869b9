"""From a scene to colours.

`assembly.py` makes the `equation.py` of a scene and a material, `plan/` leaves out what is not needed, `parts.py` takes
lights with a size apart, and what is left runs in `reference.py` (NumPy, to be read) or `kernel/` (compiled).
`Plan.of(...)` and `plan.run(vertices)` are the way in; `evaluation.py` is `pvphong.evaluate`.
"""
