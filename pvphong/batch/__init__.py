"""Lighting of many files by many processes.

Reading order: `pieces` (input files, output paths, and index files), `culling` (pieces of one surface that touch, or
that may block each other's light), `seams` (normals across pieces), `worker` (lighting of one piece, and the receipt
by which the next run skips it), `cluster` (Dask's processes), and `shading` (`shade_files`: the order of the tasks, and
the results).
"""
