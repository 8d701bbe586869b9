"""
A year on a terrain
===================

The light of a year on hills in kWh/m²: of sun and sky together, and what the hills take away from each other.

The sun's positions and the clear sky are those of pvlib, in the extra ``sun``. The extra ``rays`` makes it many times
faster.
"""

import numpy as np
import pandas as pd
import pyvista as pv

import pvphong as ph

# %%
# Hills
# -----
# A square of four kilometres with ridges some 600 m high. East is +x, north is +y, and the unit is a metre.

RANDOM, COUNT, SIZE = np.random.default_rng(5), 256, 4000.0
waves = np.hypot(*np.meshgrid(np.fft.fftfreq(COUNT), np.fft.rfftfreq(COUNT), indexing="ij")) * COUNT
phases = np.exp(2j * np.pi * RANDOM.random(waves.shape))
height = np.fft.irfft2(phases * (2.0 + waves) ** -2.7 * (waves > 0), (COUNT, COUNT))
height = 190.0 * np.abs(height / height.std())
x, y = np.meshgrid(np.linspace(0, SIZE, COUNT), np.linspace(0, SIZE, COUNT), indexing="ij")
terrain = pv.StructuredGrid(x, y, height.max() - height).extract_surface(algorithm="dataset_surface")

# %%
# A year of hours
# ---------------
# Each time stands for the hour around it. The rays are cast once; the light of any weather is a product after that.

year = pd.date_range("2026-01-01T00:30", "2026-12-31T23:30", freq="h", tz="Etc/GMT-1")
alps = ph.Place(latitude=46.5, longitude=10.5, altitude=1500)
light = terrain.phong.daylight(year, alps)
print(light.expected_cost())
light.plot("total")
print(light)

# %%
# What the hills take away
# ------------------------
# The same points and normals without faces are an open terrain: nothing hides the sun and the sky.

surface = light.mesh
points = pv.PolyData(surface.points)
points.point_data.active_normals = surface.phong.normals()
open_air = points.phong.daylight(year, alps)
surface["lost (%)"] = 100.0 * (1.0 - (light.direct + light.diffuse) / (open_air.direct + open_air.diffuse))
print(f"{surface['lost (%)'].mean():.1f} % of the light are lost on average, {surface['lost (%)'].max():.0f} % at most")

plotter = pv.Plotter()
bar = {"title": "light lost (%)", "vertical": True, "position_x": 0.86, "position_y": 0.1, "height": 0.7, "fmt": "%.0f"}
plotter.add_mesh(surface, scalars="lost (%)", cmap="magma_r", clim=(0, 40), lighting=False, scalar_bar_args=bar)
plotter.view_vector((0.35, -1.0, 0.9), viewup=(0, 0, 1))
plotter.camera.zoom(1.3)
plotter.show()
