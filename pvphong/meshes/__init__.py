"""Conversion of PyVista data to inputs of lighting, and of results to PyVista data. In reading order:

`lit` implements `mesh.phong.shade`, `plan`, `visibility` and `normals`. `surfaces` extracts a mesh's surface, faces and
normals, and splits sharp edges (with `cells`, which reads cell arrays and refuses meshes that would crash VTK).
`point_data` reads data per point, including textures, and `colormaps` maps scalars to colours. `default_scene` makes a
scene if none is given. `visibility` finds what blocks the light, and `transport` how light travels between vertices.
`glance` warns of normals that point the wrong way. `truth` converts meshes and materials for the path tracer. `blocks`
applies operations to meshes of several blocks. `files` reads and writes meshes (`whole_files` checks for truncated
files), `pictures` draws lit meshes, and `saving` exports them for other programs (`gltf` as glTF).
"""
