"""Lights, reflectances and materials: what arrives at a surface, and what leaves it.

A new light is one file in `lights/` and its entry there, a new reflectance one in `reflectances/`. `light.py` and
`reflectance.py` say what each must and may answer, `roles.py` what follows from a light's fields. `attenuation.py` is
attenuation with distance, its bounds and what could stand in for it; compiled, it is `shading/kernel/ways.attenuate`.
"""
