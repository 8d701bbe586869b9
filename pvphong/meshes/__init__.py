"""Conversion of PyVista data to inputs of lighting, and of results to PyVista data. In reading order:

- `lit`: implements `mesh.phong.shade`, `plan`, `visibility` and `normals`.
- `surfaces`: a mesh's surface, faces and normals; splitting of sharp edges, and the default feature angle.
- `cells`: cell arrays of a mesh; refuses meshes that would crash VTK.
- `point_data`: values of a material's maps per point, also from textures.
- `colormaps`: colours for scalars.
- `default_scene`: a scene for a mesh if none is given.
- `stages`: surfaces on which meshes stand.
- `visibility`: triangles of meshes that block light, and visibility of the lights from a mesh's vertices.
- `transport`: transport of light between the vertices of meshes.
- `sky_study`: times and a place, and what the sun, the sky and the ground send then.
- `daylight`: implements `mesh.phong.daylight`: light of sun and sky, summed over many times.
- `irradiance`: implements `mesh.phong.irradiance`: light that arrives, in the unit of the lights.
- `glance`: a quick warning of normals that point the wrong way.
- `truth`: implements `mesh.phong.truth`; converts meshes and materials for the path tracer.
- `blocks`: operations on the blocks of a MultiBlock, and their names.
- `files`: reads and writes meshes; `whole_files` checks that files are complete.
- `pictures`: pictures of lit meshes, and other colour spaces.
- `saving`: export for other programs; `gltf` writes glTF files.
"""
