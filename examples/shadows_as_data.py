"""Shadows as data: which part of each light every vertex sees, as arrays that are computed once and kept.

A knot stands under a sun and a glowing sphere. The sun's shadow is hard, and `refine` cuts triangles along its edge;
`visibility` casts the rays to the sphere and the sky. Dimming, tinting and switching lights afterwards is lighting
again, without a ray. With the extra `rays` (embreex) it takes a fraction of the time.
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


ground = pv.Plane(i_size=16, j_size=16, i_resolution=140, j_resolution=140)
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

sunlight = replace(scene, lights=[sun], light_model=replace(scene.light_model, ambient_occlusion=False))

start = time.perf_counter()
crisp = stage.phong.refine(sunlight, materials, tolerance=0.05)  # cut along the edge of the sun's shadow, which is hard
sides = sum(int(block.field_data["phong_refinement_cut"][0]) for block in crisp)
print(f"cut: {time.perf_counter() - start:.2f} s; {sides} sides of triangles")

start = time.perf_counter()
soft = crisp.phong.visibility(replace(scene, lights=[lamp]))
seen = {  # a row for each light, and one for the sky
    name: np.vstack([crisp[name]["phong_visibility_sun"], soft[name].per_light, soft[name].sky]) for name in soft
}
lit = crisp.phong.shade(scene, materials, visibility=seen)
print(f"with rays: {time.perf_counter() - start:.2f} s; {', '.join(f'{k}: {v}' for k, v in soft.items())}")

evening = replace(scene, lights=[replace(sun, intensity=0.15, diffuse=(1.0, 0.4, 0.2)), lamp])
start = time.perf_counter()
dim = crisp.phong.shade(evening, materials, visibility=seen)
print(f"again, with a dim red sun and no ray: {time.perf_counter() - start:.3f} s")

penumbra = (seen["ground"][1] > 0) & (seen["ground"][1] < 1)
print(f"{np.mean(penumbra):.1%} of the ground's points are in the lamp's penumbra")
error = soft["ground"].standard_error
print(f"largest standard errors on the ground: lamp {error.per_light.max():.4f}, sky {error.sky.max():.4f}")

paper = crisp.phong.shade(scene, ph.Material(), components=True, visibility=seen)


def share(light: str) -> dict[str, np.ndarray]:
    """What arrives of a light on white paper, by blocks: the most as white, encoded as for a display."""
    shares = {name: paper[name][f"phong_light_{light}"] for name in seen}
    most = max(each.max() for each in shares.values())
    return {name: np.sqrt(each / most) for name, each in shares.items()}


plotter = pv.Plotter(shape=(2, 3), off_screen=OFF_SCREEN, window_size=(1200, 720), border=False)
plain = crisp.phong.shade(replace(scene, light_model=scene.light_model.without_rays()), materials)
pictures = {
    "the sun": share("sun"),
    "the lamp": share("lamp"),
    "the sky": {name: np.tile(seen[name][2, :, None], 3) for name in seen},
    "without shadows": {name: plain[name]["phong"] for name in seen},
    "lit": {name: lit[name]["phong"] for name in seen},
    "evening: no new ray": {name: dim[name]["phong"] for name in seen},
}
for pane, (title, arrays) in enumerate(pictures.items()):
    plotter.subplot(*divmod(pane, 3))
    plotter.set_background("#20242c")
    for name, colors in arrays.items():
        plotter.add_mesh(crisp[name].copy(), scalars=colors, rgb=True, lighting=False)
    plotter.add_text(title, position=(12, 326), font_size=12, color="white")
    plotter.camera_position = [scene.viewer.position, scene.viewer.focal_point, scene.viewer.up]
plotter.enable_anti_aliasing("ssaa")

picture = FOLDER / "shadows_as_data.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
