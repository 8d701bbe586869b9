"""Light that bounces: what each surface sees of the others, made once by rays, and then lit as often as one likes.

A room with a red and a green wall, under a lamp in its ceiling. The constant ambient light of the textbook stands for
all that bounces; here each bounce is an array of its own, and other lights take no ray. Needs the extra `rays`.
"""

import time
from dataclasses import replace

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph


def wall(center: tuple[float, float, float], inward: tuple[float, float, float]) -> pv.PolyData:
    """A square of side 2, of which the side that looks inward sends light."""
    plane = pv.Plane(center=center, direction=inward, i_size=2, j_size=2, i_resolution=68, j_resolution=68)
    plane.point_data.active_normals = np.tile(np.array(inward, np.float32), (plane.n_points, 1))
    return plane


ball = pv.Sphere(radius=0.42, center=(0.42, -0.25, -0.58), theta_resolution=90, phi_resolution=90)
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

start = time.perf_counter()
transport, seen = room.phong.transport(samples=256), room.phong.visibility(scene)
shares = {"components": True, "shares_by_bounce": True}
lit = room.phong.shade(scene, materials, transport=transport, visibility=seen, **shares)
print(f"with rays: {time.perf_counter() - start:.2f} s; {transport}")

sunset = ph.SphereLight(position=(0.45, -0.65, 0.3), radius=0.08, intensity=0.3, diffuse=(1.0, 0.5, 0.2), name="sunset")
evening = replace(scene, lights=[replace(lamp, intensity=0.12, diffuse=(0.5, 0.7, 1.0)), sunset])
shadows = room.phong.visibility(evening)
for part in shadows.values():
    part.per_light  # noqa: B018  the new lamp's shadows take rays; how light goes between surfaces does not
start = time.perf_counter()
relit = room.phong.shade(evening, materials, transport=transport, visibility=shadows)
print(f"again, by other lights, without a ray: {time.perf_counter() - start:.2f} s")

first, later, direct = {}, {}, {}
for name in (*room.keys(),):
    arrays = lit[name].point_data
    first[name] = arrays["phong_bounce_1"]
    later[name] = arrays["phong_bounced"] - first[name]
    direct[name] = arrays["phong_diffuse"]
    mean = [arrays[f"phong_bounce_{bounce}"].mean() for bounce in range(1, 13)]
    print(f"{name:8} direct {direct[name].mean():.3f}, bounces {', '.join(f'{each:.3f}' for each in mean[:4])}, …")
fitted = sum(map(np.sum, first.values())) + sum(map(np.sum, later.values()))
fitted /= sum(float(np.sum(np.broadcast_to(materials.get(name, white).ambient, first[name].shape))) for name in first)
constant = replace(scene, light_model=ph.LightModel(ambient=fitted, shadows=True))
textbook = room.phong.shade(constant, materials, visibility=seen)
print(f"the constant that has as much light in all: {fitted:.3f}")

pictures = {
    "direct light": direct,
    "what bounces once": first,
    "what bounces again and again": later,
    "the textbook: a constant in its place": {name: textbook[name]["phong"] for name in first},
    "all of it": {name: lit[name]["phong"] for name in first},
    "evening: no new ray": {name: relit[name]["phong"] for name in first},
}
plotter = pv.Plotter(shape=(2, 3), off_screen=OFF_SCREEN, window_size=(1200, 840), border=False)
for pane, (title, arrays) in enumerate(pictures.items()):
    plotter.subplot(*divmod(pane, 3))
    plotter.set_background("#14161a")
    for name, values in arrays.items():
        shown = np.clip(values, 0.0, 1.0) ** (1 / 2.2)
        plotter.add_mesh(room[name].copy(), scalars=shown, rgb=True, lighting=False)
    plotter.add_text(title, position=(12, 388), font_size=11, color="white")
    plotter.camera_position = [scene.viewer.position, scene.viewer.focal_point, scene.viewer.up]
plotter.enable_anti_aliasing("ssaa")

picture = FOLDER / "light_that_bounces.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
