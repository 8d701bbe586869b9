"""Lighting, and daylight, of many files by many processes. In reading order:

- `pieces`: input files, their lit files, and index files that name them.
- `culling`: pieces of one surface that touch, or that may block each other's light.
- `seams`: normals across pieces that touch.
- `worker`: tasks for a piece, and the receipt of a lit file.
- `cluster`: Dask's worker processes.
- `run`: orders the tasks of a call and collects their results.
- `shading`: `shade_files`.
- `daylight`: `daylight_files`.
"""
