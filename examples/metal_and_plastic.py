"""
Metal and plastic
=================

Why Phong's gold looks like plastic, and what makes it metal.

Plastic scatters light in its own colour, and its highlights are white. Metal scatters almost no light. Its highlights
have its colour, and turn white where light grazes the surface. A gold diffuse colour with a highlight is therefore gold
plastic.
"""

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# A knot between softboxes
# ------------------------
# Metal shows its surroundings, so the lights have a size. :class:`pvphong.RectangleLight` is a softbox.

t = np.linspace(0.0, 2.0 * np.pi, 500) + np.pi / 6.0  # from here another part lies in front
radius = 1.0 + 0.45 * np.cos(3.0 * t)
curve = np.column_stack([radius * np.cos(2.0 * t), radius * np.sin(2.0 * t), -0.42 * np.sin(3.0 * t)])
knot = pv.Spline(curve, 1200).tube(radius=0.23, n_sides=72, capping=False)


def softbox(position: tuple[float, float, float], strength: float, color: str = "white") -> ph.RectangleLight:
    """Return a square lamp that faces the knot and has this strength there."""
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

# %%
# Four finishes
# -------------
# The first two are Phong's. :class:`pvphong.Metal` and :class:`pvphong.GGX` are reflectances: they replace the
# formula, and have their own colour of the highlight.

GOLD = (1.0, 0.72, 0.29)
DIM = tuple(0.2 * channel for channel in GOLD)
DULL = tuple(0.8 * channel for channel in GOLD)
finishes = {
    "Phong, white highlight: plastic": ph.Material(ambient=GOLD, diffuse=DULL, specular=1.0, shininess=25),
    "Phong, gold highlight: gold plastic": ph.Material(ambient=GOLD, diffuse=DULL, specular=GOLD, shininess=25),
    "Metal: a dark base under a gold highlight": ph.Material(ambient=DIM, diffuse=DIM, reflectance=ph.Metal(GOLD, 12)),
    "GGX: small gold mirrors": ph.Material(ambient=DIM, diffuse=0, reflectance=ph.GGX(0.4, GOLD)),
}

plotter = pv.Plotter(shape=(2, 2), border=False, window_size=(1100, 920))
for number, (name, material) in enumerate(finishes.items()):
    plotter.subplot(*divmod(number, 2))
    plotter.set_background("#17181b", all_renderers=False)
    plotter.add_mesh(knot.phong.shade(scene, material), scalars="phong", rgb=True, lighting=False)
    plotter.add_text(name, position=(20, 12), font_size=11, color="white")
    plotter.camera_position = [eye.position, (0, 0, 0), (0, 1, 0)]
    plotter.camera.view_angle = eye.view_angle
plotter.enable_anti_aliasing("ssaa")
plotter.show()
