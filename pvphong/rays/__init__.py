"""What blocks light between vertices and lights, or the sky, and where it bounces: arrays in, arrays out.

In reading order: `embree` is a library that tests rays, by its C interface; `casting` asks whether rays are blocked;
`rays` says where a vertex's rays begin and end, and which need not be cast; `sampling` how many are cast, and with what
error; `visibility` puts them together for a scene. Rays themselves are made by `pvphong.shading.kernel.rays`, or by
`rays` as arrays where nothing is compiled. `paths` follows light that bounces.
"""
