"""PyVista data in and out. In reading order:

`lit` is what `mesh.phong.shade`, `plan`, `visibility` and `normals` run. It takes a mesh's surface, its faces and their
normals, and splits its sharp edges, by `surfaces` (with `cells`, which reads cell arrays and refuses what would crash
VTK); what is given for each point, textures too, by `point_data`, and scalars through `colormaps`; a scene where none
is given by `default_scene`; what blocks the light by `visibility`, and how it goes on between vertices by `transport`.
`glance` warns of normals that look the wrong way. `truth` makes meshes and materials what paths of light meet. `blocks`
does things to meshes of several blocks, `files` reads and writes them (`whole_files` says whether a file is whole),
`pictures` draws lit meshes, and `saving` writes them for other programs (`gltf` for those that read that).
"""
