"""Lighting of many files by many processes. In reading order:

- `pieces`: input files, their lit files, and index files that name them.
- `culling`: pieces of one surface that touch, or that may block each other's light.
- `seams`: normals across pieces that touch.
- `worker`: tasks for a piece, and the receipt of a lit file.
- `cluster`: Dask's worker processes.
- `shading`: `shade_files`, which orders the tasks and collects their results.
"""
