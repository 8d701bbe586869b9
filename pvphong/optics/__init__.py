"""Lights, reflectances and materials: the light that arrives at a surface, and the light that leaves it.

Reading order: `roles.py`, meanings of a light's fields; `attenuation.py`, falloff with distance; `light.py`, the base
class of lights, and `lights/`, one file each; `area/`, integrals over area lights, and `panorama.py`, equirectangular
images; `reflectance.py`, the base class of reflectances, and `reflectances/`, one file each; `surface.py`, their view
of a block of vertices; `maps.py`, surface parameters per vertex, and `colormap.py`, colour maps; `material.py` and
`named_materials.py`.
"""
