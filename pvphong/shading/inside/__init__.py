"""Errors of colours that are interpolated inside triangles, and the refinement that reduces them.

In reading order:

- `lighting`: interpolated and exact colours
- `places`: samples in triangles
- `interpolation`: errors of the interpolated colours at the samples
- `triangles`: bisection and cuts of triangles as index arrays
- `surface`: triangles with lit vertices, which are added by bisection and cuts
- `cutting`: cuts along the edges of shadows and cones
- `splitting`: rounds of bisections, until the interpolated colours are accurate
"""
