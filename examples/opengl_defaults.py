"""OpenGL's own defaults, and the classic teaching materials under them.

Light model and light 0 are what an OpenGL program starts with: ambient 0.2, viewer at infinity, half-way
reflection, a white light. Only the light's place is that of the Programming Guide's teapots.c, (0, 3, 3, 0),
because OpenGL's (0, 0, 1, 0) shines from the eye and leaves no shadow side. The first sphere has OpenGL's
default material.
"""

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph

COLUMNS, STEP = 6, 1.35

scene = ph.Scene(
    lights=[ph.pipeline.light_from_homogeneous((0, 3, 3, 0), frame="camera", name="light 0")],
    viewer=ph.Viewer(position=(0, 0, 10), focal_point=(0, 0, 0), up=(0, 1, 0)),
    light_model=ph.LightModel.opengl(),
)
named = {name: ph.Material.named(name) for name in ph.Material.names()}
materials = {"default": ph.Material()} | {name: one for name, one in named.items() if one.reflectance is None}
sphere = pv.Sphere(theta_resolution=80, phi_resolution=80)

plotter = pv.Plotter(off_screen=OFF_SCREEN, window_size=(1200, 1010))
plotter.set_background("#2a2d33")
places, names = [], []
for number, (name, material) in enumerate(materials.items()):
    row, column = divmod(number, COLUMNS)
    place = np.array([(column - (COLUMNS - 1) / 2) * STEP, -row * STEP, 0])
    lit = sphere.translate(place).phong.shade(scene, material)
    plotter.add_mesh(lit, scalars="phong", rgb=True, lighting=False)
    places.append(place - (0, 0.6, 0))
    names.append(name)
plotter.add_point_labels(
    places, names, font_size=15, text_color="white", shape=None, show_points=False, justification_horizontal="center",
    always_visible=True,
)  # fmt: skip
plotter.view_xy()
plotter.camera.parallel_projection = True
plotter.camera.parallel_scale = 0.5 * STEP * len(materials) / COLUMNS
plotter.enable_anti_aliasing("ssaa")

picture = FOLDER / "opengl_defaults.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
