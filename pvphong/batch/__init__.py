"""Many files, lit by many processes, in the order in which to read it.

`pieces` (which files are lit, where the lit ones go, and the indices that name them), `culling` (which pieces of
one surface touch each other, and which may block light for which), `seams` (normals across such pieces), `worker` (what
a process does with a piece, and the receipt by which the next run knows that it is done), `cluster` (the processes:
Dask's), and `shading` (`shade_files`: what is asked of them in which order, and the results).
"""
