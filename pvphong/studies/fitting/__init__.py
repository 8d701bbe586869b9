"""Lights found from the colours that a mesh should have.

The colours are linear in the lights' intensities and colours, so these are a bounded least-squares problem. Directions,
positions, cones and sizes are searched outside of it, by variable projection (Golub and Pereyra 1973).

- `target`: `ph.target`, which makes a target from selections, and the target as the solver reads it.
- `variation`: the fields of lights that vary, and their coordinates in the search.
- `columns`: the colours that a light gives for one unit of each unknown.
- `linear`: bounded least squares for intensities and colours, with colours clamped at 1.
- `search`: starts, and the nonlinear search from each.
- `choosing`: the fewest lights of a list.
- `result`: the `Fit`, its errors, standard deviations and report.
- `figure`: target, result and difference side by side.
- `image`: `ph.colors_from_image`, which reads colours at vertices from a picture.
- `fitting`: `mesh.phong.fit` and `blocks.phong.fit`, which use all of these.
"""
