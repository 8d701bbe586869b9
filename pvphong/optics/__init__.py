"""Lights, reflectances and materials: what arrives at a surface, and what leaves it.

In the order in which to read it: `roles.py`, what follows from a light's fields; `attenuation.py`, how light weakens
with distance; `light.py`, what every light must and may answer, and `lights/`, a file each; `area/`, integrals over
lights with a size, and `panorama.py`, images all around; `reflectance.py`, what every reflectance must and may answer,
and `reflectances/`, a file each; `surface.py`, what they see of a block of vertices; `maps.py`, what of a surface
differs from vertex to vertex, and `colormap.py`, one of these; `material.py` and `named_materials.py`.
"""
