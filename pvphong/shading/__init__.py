"""From a scene to colours.

`equation.py` puts scene and material together, `plan/` leaves out what is not needed, and what is left runs in
`reference.py` (NumPy, to be read) or `kernel/` (compiled). `Plan.of(...)` and `plan.run(vertices)` are the way in;
`evaluation.py` is `pvphong.evaluate`.
"""
