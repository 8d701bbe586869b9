"""Many files, lit by many processes.

In reading order: `pieces` (input files, lit files, and the indices that name them), `culling` (pieces of one surface
that touch, or that may block each other's light), `seams` (normals across such pieces), `worker` (tasks on a piece, and
the receipt of a finished one), `cluster` (Dask's processes), and `shading` (`shade_files`: order of tasks, and
results).
"""
