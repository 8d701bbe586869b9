"""What is seen: lights, viewer and light model as one value.

`viewer.py`, `light_model.py`, then `scene.py`, which puts them together and keeps them in files; `presets.py` has
ready-made lights, `options.py` tells who gives a call what belongs into one of these.
"""
