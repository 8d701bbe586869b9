"""Diagnosis of meshes: faults that spoil the lighting.

- `diagnosis`: `diagnose` and its result. Read it first.
- `kinds`: the kinds of fault, and when they spoil the lighting.
- `remedies`: code that repairs faults.
- `checks`: checks of faces, edges, duplicates and the model matrix.
- `shells`: closed parts that are inside out.
- `orientation`: neighbours that face opposite ways.
"""
