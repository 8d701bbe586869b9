"""
A city in the sun
=================

Hours with sun on streets, walls and roofs, light in W/m², and a film of a day's shadows, from one set of rays.

The sun's positions and the clear sky are those of pvlib, in the extra ``sun``. The extra ``rays`` makes it many times
faster; the film needs the extra ``gif``.
"""

import numpy as np
import pandas as pd
import pyvista as pv
from matplotlib.colors import LinearSegmentedColormap

import pvphong as ph

# %%
# A city
# ------
# Sixty houses around a square. East is +x, north is +y, up is +z, and the unit is a metre. Results are at vertices, so
# walls and streets need vertices every few metres.

RANDOM = np.random.default_rng(11)
parts = [pv.Plane(i_size=420, j_size=420, i_resolution=170, j_resolution=170).triangulate()]
for x in np.linspace(-175, 175, 8):
    for y in np.linspace(-175, 175, 8):
        if abs(x) + abs(y) < 60:
            continue  # the square
        width, depth = RANDOM.uniform(11, 19, 2)
        height = RANDOM.choice([12, 15, 18, 22, 45], p=[0.3, 0.3, 0.2, 0.14, 0.06])
        house = pv.Box((x - width, x + width, y - depth, y + depth, 0, height), level=9)
        parts.append(house.triangulate())
city = pv.merge(parts, merge_points=False)
munich = ph.Place(latitude=48.14, longitude=11.58, altitude=520)

# %%
# Sun hours of a day in March
# ---------------------------
# Each time stands for the ten minutes around it. ``sun_hours`` is an array in hours, one number for each vertex.

day = pd.date_range("2026-03-21T06:05", "2026-03-21T18:55", freq="10min", tz="Europe/Berlin")
light = city.phong.daylight(day, munich, feature_angle=30)
print(light.expected_cost())
print(f"{light.sun_hours.max():.1f} h at most, {np.mean(light.sun_hours < 2):.0%} of the vertices have less than 2 h")
light.plot("sun_hours")

# %%
# A cloudy day takes no more rays
# -------------------------------
# Weather is a product with what the rays have found: an EPW file, arrays, or a clear sky. Here clouds come at noon.

clear = ph.daylight_scene("2026-03-21T12:00+01:00", munich)
print([f"{each.name}: {each.intensity:.0f}" for each in clear.lights[:1]], "W/m² at noon under a clear sky")
cloudy = day.hour >= 12
direct, diffuse = np.where(cloudy, 0.0, 600.0), np.where(cloudy, 180.0, 90.0)
light.with_weather((direct, diffuse)).plot("total")

# %%
# A day's shadows
# ---------------
# A weather in which the sun shines at one moment only gives the picture of that moment.

plotter = pv.Plotter(window_size=(560, 340), off_screen=True)
plotter.set_background("#1b2433")
shown = light.mesh
shown["W/m²"] = np.zeros(shown.n_points)
dusk = LinearSegmentedColormap.from_list("dusk", ["#101a30", "#35507a", "#a9a79c", "#f2dcae", "#fffaf0"])
plotter.add_mesh(shown, scalars="W/m²", clim=(0, 750), cmap=dusk, lighting=False, show_scalar_bar=False)
plotter.camera_position = [(230, -640, 470), (-12, -25, 0), (0, 0, 1)]
plotter.camera.view_angle = 27
plotter.enable_anti_aliasing("ssaa")
plotter.open_gif("shadows_of_a_day.gif", fps=10)
for now in range(4, len(day) - 4, 2):
    only = np.arange(len(day)) == now
    shown["W/m²"] = light.with_weather((700.0 * only, 110.0 * only)).total / light.hours
    plotter.write_frame()
plotter.close()
