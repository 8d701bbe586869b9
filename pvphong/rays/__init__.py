"""What blocks light between vertices and lights, or the sky: arrays in, arrays out.

In reading order: `casting` asks whether rays are blocked; `rays` says where a vertex's rays begin and end, and which
need not be cast; `sampling` how many are cast, and with what error; `visibility` puts them together for a scene.
"""
