"""
Light that bounces
==================

In Phong's model, a constant ambient light stands for all light that bounces. Here each bounce is computed, as an array
of its own, and other lights reuse the same rays.

It needs the extra ``rays``.
"""

import time
from dataclasses import replace

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# A room with a red and a green wall
# ----------------------------------
# Seven blocks, which exchange light. A rectangle in the ceiling is the lamp.


def wall(center: tuple[float, float, float], inward: tuple[float, float, float]) -> pv.PolyData:
    """Return a square of side 2 whose normals point inward."""
    plane = pv.Plane(center=center, direction=inward, i_size=2, j_size=2, i_resolution=56, j_resolution=56)
    plane.point_data.active_normals = np.tile(np.array(inward, np.float32), (plane.n_points, 1))
    return plane


ball = pv.Sphere(radius=0.42, center=(0.42, -0.25, -0.58), theta_resolution=80, phi_resolution=80)
block = pv.Cube(center=(0, 0, 0), x_length=0.6, y_length=0.6, z_length=1.2).triangulate().subdivide(5)
block = block.compute_normals(split_vertices=True).rotate_z(20).translate((-0.4, 0.35, -0.398))
room = pv.MultiBlock(
    {
        "floor": wall((0, 0, -1), (0, 0, 1)),
        "ceiling": wall((0, 0, 1), (0, 0, -1)),
        "back": wall((0, 1, 0), (0, -1, 0)),
        "left": wall((-1, 0, 0), (1, 0, 0)),
        "right": wall((1, 0, 0), (-1, 0, 0)),
        "ball": ball,
        "block": block,
    }
)
colors = (0.73, 0.71, 0.68), (0.65, 0.06, 0.05), (0.12, 0.45, 0.1)
white, red, green = (ph.Material(ambient=color, diffuse=color) for color in colors)
materials = {"default": white, "left": red, "right": green}
lamp = ph.RectangleLight(position=(0, 0, 0.99), direction=(0, 0, -1), width=0.6, height=0.6, intensity=1.0, name="lamp")
scene = ph.Scene(
    lights=[lamp],
    viewer=ph.Viewer(position=(0, -4.9, 0), focal_point=(0, 0, 0), up=(0, 0, 1)),
    light_model=ph.LightModel(ambient=0.0, shadows=True, bounces=12),
)

# %%
# Cast the rays once
# ------------------
# ``transport`` has the paths of light between surfaces, ``visibility`` the part of the lamp that each vertex sees.
# ``shares_by_bounce=True`` adds one array for each bounce.

start = time.perf_counter()
transport, seen = room.phong.transport(samples=256), room.phong.visibility(scene)
shares = {"components": True, "shares_by_bounce": True}
lit = room.phong.shade(scene, materials, transport=transport, visibility=seen, **shares)
print(f"{time.perf_counter() - start:.2f} s with rays; {transport}")

first, later, direct = {}, {}, {}
for name in room.keys():  # noqa: SIM118 a MultiBlock iterates over its blocks
    arrays = lit[name].point_data
    direct[name] = arrays["phong_diffuse"]
    first[name] = arrays["phong_bounce_1"]
    later[name] = arrays["phong_bounced"] - first[name]
    means = ", ".join(f"{arrays[f'phong_bounce_{bounce}'].mean():.3f}" for bounce in range(1, 5))
    print(f"{name:8} direct {direct[name].mean():.3f}, bounces {means}, …")

# %%
# Other lights, no new rays between surfaces
# ------------------------------------------
# In the evening the lamp is dim and blue, and a small orange sphere glows. Its shadows need new rays; light between
# surfaces does not.

sunset = ph.SphereLight(position=(0.45, -0.65, 0.3), radius=0.08, intensity=0.3, diffuse=(1.0, 0.5, 0.2), name="sunset")
evening = replace(scene, lights=[replace(lamp, intensity=0.12, diffuse=(0.5, 0.7, 1.0)), sunset])
relit = room.phong.shade(evening, materials, transport=transport, visibility=room.phong.visibility(evening))

# %%
# The textbook's constant
# -----------------------
# For comparison, a constant ambient light that adds the same amount of light in total.

bounced = sum(float(np.sum(first[name] + later[name])) for name in first)
reflected = sum(float(np.sum(np.broadcast_to(materials.get(name, white).ambient, first[name].shape))) for name in first)
constant = replace(scene, light_model=ph.LightModel(ambient=bounced / reflected, shadows=True))
textbook = room.phong.shade(constant, materials, visibility=seen)
print(f"the constant that adds as much light in total: {bounced / reflected:.3f}")

# %%
# The shares, and their sum
# -------------------------
# Colours are linear, so they are raised to the power 1/2.2 for the display. The constant has no colour from the
# walls, and leaves the ceiling flat.

pictures = {
    "direct light": direct,
    "first bounce": first,
    "all later bounces": later,
    "direct light and a constant": {name: textbook[name]["phong"] for name in first},
    "direct light and all bounces": {name: lit[name]["phong"] for name in first},
    "evening, the same transport": {name: relit[name]["phong"] for name in first},
}
plotter = pv.Plotter(shape=(2, 3), window_size=(1200, 840), border=False)
for pane, (title, arrays) in enumerate(pictures.items()):
    plotter.subplot(*divmod(pane, 3))
    plotter.set_background("#14161a")
    for name, values in arrays.items():
        shown = np.clip(values, 0.0, 1.0) ** (1 / 2.2)
        plotter.add_mesh(room[name].copy(), scalars=shown, rgb=True, lighting=False)
    plotter.add_text(title, position=(12, 388), font_size=11, color="white")
    plotter.camera_position = [scene.viewer.position, scene.viewer.focal_point, scene.viewer.up]
plotter.enable_anti_aliasing("ssaa")
plotter.show()
