"""
OpenGL's defaults
=================

The classic teaching materials under the light that an OpenGL program starts with.
"""

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# OpenGL's light
# --------------
# :meth:`pvphong.LightModel.opengl` has OpenGL's defaults: ambient light 0.2, a viewer at infinity, half-way
# reflection. In OpenGL, positions of lights are homogeneous coordinates; with w = 0 they are directions. The light here
# is that of the *Programming Guide*. OpenGL's own default, (0, 0, 1, 0), shines from the eye, so that no side is dark.

scene = ph.Scene(
    lights=[ph.pipeline.light_from_homogeneous((0, 3, 3, 0), frame="camera", name="light 0")],
    viewer=ph.Viewer(position=(0, 0, 10), focal_point=(0, 0, 0), up=(0, 1, 0)),
    light_model=ph.LightModel.opengl(),
)

# %%
# The materials
# -------------
# ``Material.named`` returns them by name. Materials with a reflectance of their own are not OpenGL's and are left out.
# The first ball has OpenGL's default material.

named = {name: ph.Material.named(name) for name in ph.Material.names()}
materials = {"default": ph.Material()} | {name: each for name, each in named.items() if each.reflectance is None}
sphere = pv.Sphere(theta_resolution=80, phi_resolution=80)

COLUMNS, STEP = 6, 1.35
plotter = pv.Plotter(window_size=(1200, 1010))
plotter.set_background("#2a2d33")
places = []
for number, material in enumerate(materials.values()):
    row, column = divmod(number, COLUMNS)
    place = np.array([(column - (COLUMNS - 1) / 2) * STEP, -row * STEP, 0])
    lit = sphere.translate(place).phong.shade(scene, material)
    plotter.add_mesh(lit, scalars="phong", rgb=True, lighting=False)
    places.append(place - (0, 0.6, 0))
plotter.add_point_labels(
    places, list(materials), font_size=15, text_color="white", shape=None, show_points=False,
    justification_horizontal="center", always_visible=True,
)  # fmt: skip
plotter.view_xy()
plotter.camera.parallel_projection = True
plotter.camera.parallel_scale = 0.5 * STEP * len(materials) / COLUMNS
plotter.enable_anti_aliasing("ssaa")
plotter.show()
