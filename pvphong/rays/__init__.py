"""Ray casting: visibility of lights and the sky, and bounced light, on arrays.

In reading order: `embree` calls Embree's C interface; `casting` tests rays for occlusion and finds their first hits;
`rays` sets the origins and targets of rays, and rules out rays that need not be cast; `sampling` chooses the number of
rays by their error; `visibility` combines these for a scene. `transport` is diffuse light transport between vertices;
`paths` is path tracing. Compiled code in `pvphong.shading.kernel` generates the rays, or `rays` with arrays if nothing
is compiled.
"""
