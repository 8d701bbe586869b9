"""Errors of colours that are interpolated inside triangles, and the refinement that reduces them.

In reading order: `lighting` computes interpolated and exact colours, `places` selects the samples in triangles, and
`interpolation` measures errors there. `triangles` bisects and cuts triangles as index arrays, and `surface` adds lit
vertices. `cutting` finds the edges of shadows and cones and cuts along them; `splitting` bisects the other triangles.
"""
