"""Why Phong's metal looks like plastic, and what makes it metal.

Plastic scatters colour and mirrors white; a gold-coloured diffuse part under a highlight is still gold plastic. Metal
scatters next to nothing, and its highlight has its colour, but is white where light grazes the surface.
"""

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph

GOLD = (1.0, 0.72, 0.29)
DIM = tuple(0.2 * channel for channel in GOLD)
DULL = tuple(0.8 * channel for channel in GOLD)

t = np.linspace(0.0, 2.0 * np.pi, 500) + np.pi / 6.0  # where it starts, another part is in front
radius = 1.0 + 0.45 * np.cos(3.0 * t)
curve = np.column_stack([radius * np.cos(2.0 * t), radius * np.sin(2.0 * t), -0.42 * np.sin(3.0 * t)])
knot = pv.Spline(curve, 1500).tube(radius=0.23, n_sides=90, capping=False)


def softbox(position, strength, color="white"):
    """A square lamp that faces the knot, and is so strong there."""
    place = np.array(position, float)
    return ph.RectangleLight(place, -place, (0, 1, 0.3), 3, 3, diffuse=color, intensity=strength * (place @ place))


lights = [
    softbox((-4, 4, 5), 0.55, color="#fff4e0"),
    softbox((5, 1, 3), 0.4),
    softbox((0, -5, 4), 0.3, color="#dfeaff"),
    softbox((-1, 6, -1), 0.5),
    ph.PointLight((-6, -2, -3), intensity=0.9),
    ph.PointLight((6, 3, -3.5), intensity=0.9),
]
eye = ph.Viewer(position=(0.0, -1.6, 8.2), up=(0, 1, 0), view_angle=26)
scene = ph.Scene(lights, eye, ph.LightModel(ambient=0.08))

finishes = {
    "Phong, white highlight: plastic": ph.Material(ambient=GOLD, diffuse=DULL, specular=1.0, shininess=25),
    "Phong, gold highlight: gold plastic": ph.Material(ambient=GOLD, diffuse=DULL, specular=GOLD, shininess=25),
    "Metal: a dark base under a gold highlight": ph.Material(ambient=DIM, diffuse=DIM, reflectance=ph.Metal(GOLD, 12)),
    "GGX: small gold mirrors": ph.Material(ambient=DIM, diffuse=0, reflectance=ph.GGX(0.4, GOLD)),
}

plotter = pv.Plotter(off_screen=OFF_SCREEN, shape=(2, 2), border=False, window_size=(1200, 1000))
for number, (name, material) in enumerate(finishes.items()):
    plotter.subplot(*divmod(number, 2))
    plotter.set_background("#17181b", all_renderers=False)
    plotter.add_mesh(knot.phong.shade(scene, material), scalars="phong", rgb=True, lighting=False)
    plotter.add_text(name, position=(20, 12), font_size=11, color="white")
    plotter.camera.position, plotter.camera.focal_point, plotter.camera.up = eye.position, (0, 0, 0), (0, 1, 0)
    plotter.camera.view_angle = eye.view_angle
plotter.enable_anti_aliasing("ssaa")

picture = FOLDER / "metal_and_plastic.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
