"""Shadows as data: which part of each light every vertex sees, as arrays that are computed once and kept.

A knot stands under a sun and a glowing sphere. `visibility` casts the rays; dimming, tinting and switching lights
afterwards is lighting again, without a ray. With the extra `rays` (embreex) it takes a fraction of the time.
"""

import time
from dataclasses import replace

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph


def knot() -> pv.PolyData:
    """A tube along a trefoil, standing upright on z = 0."""
    t = np.linspace(0, 2 * np.pi, 400)
    curve = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), -np.sin(3 * t), np.cos(t) - 2 * np.cos(2 * t)])
    tube = pv.Spline(curve, 360).tube(radius=0.5, n_sides=36, capping=False).triangulate()
    tube.points[:, 2] -= tube.points[:, 2].min()
    return tube


ground = pv.Plane(i_size=16, j_size=16, i_resolution=160, j_resolution=160)
stage = pv.MultiBlock({"ground": ground, "knot": knot()})
sun = ph.DirectionalLight(direction=(-2, 1, -1.5), intensity=0.5, diffuse=(1.0, 0.9, 0.75), name="sun")
lamp = ph.SphereLight(position=(-4.5, -4.5, 7), radius=1.0, intensity=38, diffuse=(0.75, 0.85, 1.0), name="lamp")
scene = ph.Scene(
    lights=[sun, lamp],
    viewer=ph.Viewer(position=(1, -17, 11), focal_point=(-0.3, 0, 1.8), up=(0, 0, 1)),
    light_model=ph.LightModel(ambient=0.35, shadows=True, ambient_occlusion=6.0),
)
materials = {
    "ground": ph.Material(ambient=0.8, diffuse=0.7),
    "knot": ph.Material(ambient=(0.9, 0.5, 0.35), diffuse=(0.9, 0.45, 0.3), specular=0.25, shininess=40),
}

start = time.perf_counter()
seen = stage.phong.visibility(scene)
lit = stage.phong.shade(scene, materials, visibility=seen)  # the rays are cast when they are first needed
print(f"with rays: {time.perf_counter() - start:.2f} s; {', '.join(f'{k}: {v}' for k, v in seen.items())}")

evening = replace(scene, lights=[replace(sun, intensity=0.15, diffuse=(1.0, 0.4, 0.2)), lamp])
start = time.perf_counter()
dim = stage.phong.shade(evening, materials, visibility=seen)
print(f"again, with a dim red sun and no ray: {time.perf_counter() - start:.3f} s")

penumbra = (seen["ground"].per_light[1] > 0) & (seen["ground"].per_light[1] < 1)
print(f"{np.mean(penumbra):.1%} of the ground is in the lamp's penumbra")
error = seen["ground"].standard_error
print(f"largest standard errors on the ground: lamp {error.per_light[1].max():.4f}, sky {error.sky.max():.4f}")

plotter = pv.Plotter(shape=(2, 3), off_screen=OFF_SCREEN, window_size=(1200, 720), border=False)
grey = {"cmap": "gray", "clim": (0, 1), "show_scalar_bar": False}
pictures = {
    "the sun": ({name: v.per_light[0] for name, v in seen.items()}, grey),
    "the lamp": ({name: v.per_light[1] for name, v in seen.items()}, grey),
    "the sky": ({name: v.sky for name, v in seen.items()}, grey),
    "without shadows": (
        {
            name: stage[name].phong.shade(
                replace(scene, light_model=scene.light_model.without_rays()), materials[name]
            )["phong"]
            for name in seen
        },
        {"rgb": True},
    ),
    "lit": ({name: lit[name]["phong"] for name in seen}, {"rgb": True}),
    "evening: no new ray": ({name: dim[name]["phong"] for name in seen}, {"rgb": True}),
}
for pane, (title, (arrays, options)) in enumerate(pictures.items()):
    plotter.subplot(*divmod(pane, 3))
    plotter.set_background("#20242c")
    for name, values in arrays.items():
        plotter.add_mesh(stage[name].copy(), scalars=values, lighting=False, **options)
    plotter.add_text(title, position=(12, 326), font_size=12, color="white")
    plotter.camera_position = [scene.viewer.position, scene.viewer.focal_point, scene.viewer.up]
plotter.enable_anti_aliasing("ssaa")

picture = FOLDER / "shadows_as_data.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
