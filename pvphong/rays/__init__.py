"""What blocks light between vertices and lights, or the sky, and where it bounces: arrays in, arrays out.

In reading order: `embree` is a library that tests rays, by its C interface; `casting` asks whether rays are blocked,
and by what; `rays` says where a vertex's rays begin and end, and which need not be cast; `sampling` how many are cast,
and with what error; `visibility` puts them together for a scene. `transport` says how light goes from vertices to
vertices; `paths` follows it wherever it goes. Rays themselves are made by `pvphong.shading.kernel`, or by `rays` as
arrays where nothing is compiled.
"""
