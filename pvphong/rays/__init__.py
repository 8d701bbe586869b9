"""Ray casting: visibility of lights and the sky, and bounced light, on arrays.

In reading order:

- `embree`: Embree's C interface
- `casting`: occlusion tests and first hits of rays
- `rays`: origins and targets of rays, and tests that rule out rays before they are cast
- `sampling`: the number of rays per vertex, chosen by their error
- `visibility`: shadows and ambient occlusion of a scene
- `transport`: diffuse light transport between vertices
- `paths`: path tracing
- `daylight`: visible parts of the sky's patches, and of the sun at many positions

Compiled code in `pvphong.shading.kernel` generates the rays. If nothing is compiled, `rays` generates them with NumPy.
"""
