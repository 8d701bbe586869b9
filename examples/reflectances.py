"""Every reflectance on the same ball, from rough on the left to smooth on the right.

A warm lamp, a cool one behind, and a weak one on the viewer's head, which road signs send back.
"""

from dataclasses import replace

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph

COLUMNS, ROWS, STEP, BLOCK = 5, 5, 1.08, 7.6
GOLD, COPPER, STEEL = (1.0, 0.78, 0.34), (0.95, 0.64, 0.54), (0.56, 0.57, 0.58)
SHININESS = np.geomspace(2.0, 100.0, COLUMNS)
ROUGHNESS = np.linspace(0.8, 0.15, COLUMNS)
BLUE, GREEN, WHITE, RED = (0.08, 0.2, 0.55), (0.1, 0.4, 0.16), (0.85, 0.82, 0.76), (0.5, 0.02, 0.03)


def one(color, reflectance, specular=0.0):
    """A material of one colour."""
    return ph.Material(ambient=color, diffuse=color, specular=specular, reflectance=reflectance)


def dim(color):
    """What metal scatters."""
    return tuple(0.08 * channel for channel in color)


FAMILIES = {
    "Oren-Nayar": [one(WHITE, ph.OrenNayar(sigma)) for sigma in (60, 35, 20, 10, 0)],
    "Phong": [one(BLUE, ph.Phong(s), 0.6) for s in SHININESS],
    "Blinn-Phong": [one(BLUE, ph.BlinnPhong(4 * s), 0.6) for s in SHININESS],
    "modified Phong": [one(BLUE, ph.ModifiedPhong(s), 0.12) for s in SHININESS],
    "retro": [one(GREEN, ph.Retro(s), 3.0 / (s + 2)) for s in SHININESS],
    "metal": [one(dim(GOLD), ph.Metal(GOLD, s)) for s in SHININESS],
    "GGX, copper": [one((0, 0, 0), ph.GGX(r, COPPER)) for r in ROUGHNESS],
    "GGX, paint": [one(RED, ph.GGX(r, 0.06)) for r in ROUGHNESS],
    "Ward, brushed": [one(dim(STEEL), ph.Ward(a, 0.45), STEEL) for a in np.geomspace(0.45, 0.06, COLUMNS)],
    "PBR, VTK's": [one(GOLD, ph.PBR(m, r)) for m, r in zip(np.linspace(0, 1, COLUMNS), ROUGHNESS, strict=True)],
}

ball = pv.Sphere(theta_resolution=260, phi_resolution=260, direction=(0, 1, 0))
around = np.cross((0.0, 1.0, 0.0), ball.points)
around[~around.any(axis=1)] = (1, 0, 0)

lights = [
    ph.PointLight((-4, 5, 6), diffuse=(1.0, 0.93, 0.82), intensity=0.85),
    ph.PointLight((6, 2, -1.5), diffuse=(0.6, 0.75, 1.0), intensity=0.9),
    ph.PointLight((0, -6, 4), diffuse=(1.0, 0.85, 0.7), intensity=0.35),
    ph.PointLight(frame="headlight", intensity=0.25),
]
scene = ph.Scene(lights, ph.Viewer(position=(0, 0, 8), focal_point=(0, 0, 0)), ph.LightModel(ambient=0.06))

plotter = pv.Plotter(off_screen=OFF_SCREEN, window_size=(1500, 560))
plotter.set_background("#1b1d21")
places = []
for number, materials in enumerate(FAMILIES.values()):
    block, row = divmod(number, ROWS)
    for column, material in enumerate(materials):
        lit = ball.phong.shade(scene, replace(material, tangents=around))
        place = np.array([block * BLOCK + column * STEP, -row * STEP, 0.0])
        plotter.add_mesh(lit.translate(place), scalars="phong", rgb=True, lighting=False)
    places.append((block * BLOCK - 0.72, -row * STEP, 0.0))
plotter.add_point_labels(
    places, list(FAMILIES), font_size=20, text_color="white", shape=None, show_points=False,
    justification_horizontal="right", justification_vertical="center", always_visible=True,
)  # fmt: skip
plotter.view_xy()
plotter.camera.parallel_projection = True
middle = (0.5 * (BLOCK + (COLUMNS - 1) * STEP) - 0.95, -0.5 * (ROWS - 1) * STEP)
plotter.camera.focal_point, plotter.camera.position = (*middle, 0.0), (*middle, 10.0)
plotter.camera.parallel_scale = 0.5 * STEP * ROWS + 0.12
plotter.enable_anti_aliasing("ssaa")

picture = FOLDER / "reflectances.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
