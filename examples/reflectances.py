"""
Reflectances
============

Every reflectance on the same ball, from rough on the left to smooth on the right.

A reflectance is the formula for the light that leaves a surface in each direction. Phong's is one of ten families here.
"""

from dataclasses import replace

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# Ten families
# ------------
# ``Material(reflectance=...)`` replaces Phong's formula. Metal, GGX and PBR have their own colour of the highlight; the
# others use the material's ``specular``.

COLUMNS, ROWS = 5, 5
SHININESS = np.geomspace(2.0, 100.0, COLUMNS)
ROUGHNESS = np.linspace(0.8, 0.15, COLUMNS)
GOLD, COPPER, STEEL = (1.0, 0.78, 0.34), (0.95, 0.64, 0.54), (0.56, 0.57, 0.58)
BLUE, GREEN, WHITE, RED = (0.08, 0.2, 0.55), (0.1, 0.4, 0.16), (0.85, 0.82, 0.76), (0.5, 0.02, 0.03)


def of(color, reflectance, specular=0.0):
    """Return a material of one colour."""
    return ph.Material(ambient=color, diffuse=color, specular=specular, reflectance=reflectance)


def dim(color):
    """Return the little that a metal scatters."""
    return tuple(0.08 * channel for channel in color)


families = {
    "Oren-Nayar": [of(WHITE, ph.OrenNayar(sigma)) for sigma in (60, 35, 20, 10, 0)],
    "Phong": [of(BLUE, ph.Phong(s), 0.6) for s in SHININESS],
    "Blinn-Phong": [of(BLUE, ph.BlinnPhong(4 * s), 0.6) for s in SHININESS],
    "modified Phong": [of(BLUE, ph.ModifiedPhong(s), 0.12) for s in SHININESS],
    "retro": [of(GREEN, ph.Retro(s), 3.0 / (s + 2)) for s in SHININESS],
    "metal": [of(dim(GOLD), ph.Metal(GOLD, s)) for s in SHININESS],
    "GGX, copper": [of((0, 0, 0), ph.GGX(r, COPPER)) for r in ROUGHNESS],
    "GGX, paint": [of(RED, ph.GGX(r, 0.06)) for r in ROUGHNESS],
    "Ward, brushed": [of(dim(STEEL), ph.Ward(a, 0.45), STEEL) for a in np.geomspace(0.45, 0.06, COLUMNS)],
    "PBR, VTK's": [of(GOLD, ph.PBR(m, r)) for m, r in zip(np.linspace(0, 1, COLUMNS), ROUGHNESS, strict=True)],
}

# %%
# Tangents
# --------
# Brushed steel reflects differently along and across its grooves. ``tangents`` is the direction of the grooves at
# each point: here around the ball's axis.

ball = pv.Sphere(theta_resolution=150, phi_resolution=150, direction=(0, 1, 0))
around = np.cross((0.0, 1.0, 0.0), ball.points)
around[~around.any(axis=1)] = (1, 0, 0)

# %%
# The balls
# ---------
# A warm lamp, a cool one behind, and a weak light at the viewer's eye, which a road sign (*retro*) sends back.

lights = [
    ph.PointLight((-4, 5, 6), diffuse=(1.0, 0.93, 0.82), intensity=0.85),
    ph.PointLight((6, 2, -1.5), diffuse=(0.6, 0.75, 1.0), intensity=0.9),
    ph.PointLight((0, -6, 4), diffuse=(1.0, 0.85, 0.7), intensity=0.35),
    ph.PointLight(frame="headlight", intensity=0.25),
]
scene = ph.Scene(lights, ph.Viewer(position=(0, 0, 8), focal_point=(0, 0, 0)), ph.LightModel(ambient=0.06))

STEP, BLOCK = 1.08, 7.6
plotter = pv.Plotter(window_size=(1400, 523))
plotter.set_background("#1b1d21")
labels = []
for number, materials in enumerate(families.values()):
    block, row = divmod(number, ROWS)
    for column, material in enumerate(materials):
        lit = ball.phong.shade(scene, replace(material, tangents=around))
        place = np.array([block * BLOCK + column * STEP, -row * STEP, 0.0])
        plotter.add_mesh(lit.translate(place), scalars="phong", rgb=True, lighting=False)
    labels.append((block * BLOCK - 0.72, -row * STEP, 0.0))
plotter.add_point_labels(
    labels, list(families), font_size=19, text_color="white", shape=None, show_points=False,
    justification_horizontal="right", justification_vertical="center", always_visible=True,
)  # fmt: skip
plotter.view_xy()
plotter.camera.parallel_projection = True
middle = (0.5 * (BLOCK + (COLUMNS - 1) * STEP) - 0.95, -0.5 * (ROWS - 1) * STEP)
plotter.camera.focal_point, plotter.camera.position = (*middle, 0.0), (*middle, 10.0)
plotter.camera.parallel_scale = 0.5 * STEP * ROWS + 0.12
plotter.enable_anti_aliasing("ssaa")
plotter.show()
