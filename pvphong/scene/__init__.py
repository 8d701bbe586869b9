"""Scenes: lights, viewer and light model as one value.

`viewer.py`, `light_model.py`, then `scene.py`, which combines them and stores them in files; `presets.py` has
ready-made lights, and `options.py` the errors for options that belong to a scene or a material.
"""
