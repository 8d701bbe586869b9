"""Scenes: lights, viewer and light model as one value.

- `viewer.py`: the viewer.
- `light_model.py`: the model that combines the contributions of lights.
- `scene.py`: combines lights, viewer and light model, and stores them in files.
- `presets.py`: ready-made lights.
- `sun.py`: places on the Earth, and the sun there; `weather.py`: irradiances.
- `daylight.py`: the sun and the sky of a moment; `sun_by_date.py`: by place, day and hour.
- `options.py`: errors for options that belong to a scene or a material.
"""
