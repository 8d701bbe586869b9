"""Lights, reflectances and materials: what arrives at a surface, and what leaves it.

A new light is one file in `lights/` and its entry there, a new reflectance one in `reflectances/`. `light.py` and
`reflectance.py` say what each must and may answer; `attenuation.py` is all there is about attenuation.
"""
