"""Lights, reflectances and materials: the light that arrives at a surface, and the light that leaves it.

In reading order:

- `roles.py`: meanings of a light's fields.
- `attenuation.py`: falloff of light with distance.
- `light.py`: the base class of lights; `lights/` has a file for each kind.
- `photometry.py`: intensities of lamps as measured; `photometric_files.py` reads them.
- `area/`: integrals over area lights; `panorama.py`: equirectangular images; `sky.py`: the sky's radiance.
- `directions.py`: directions of light that a highlight reflects, sampled.
- `reflectance.py`: the base class of reflectances; `reflectances/` has a file for each kind.
- `surface.py`: the input of a reflectance for a block of vertices.
- `maps.py`: surface parameters that vary per vertex; `colormap.py`: colours of a scalar array.
- `material.py`: materials; `named_materials.py`: ready-made ones.
"""
