"""
Shadows as data
===============

The part of each light that every vertex sees, as arrays that are computed once and kept. Dimming, tinting and switching
lights afterwards needs no rays.

The extra ``rays`` makes it many times faster.
"""

import time
from dataclasses import replace

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# A knot under a sun and a glowing sphere
# ---------------------------------------
# The sun's shadow is hard, the lamp's is soft. Ambient occlusion darkens places that see little of the sky; only
# geometry up to a distance of 6 counts.

t = np.linspace(0, 2 * np.pi, 400)
curve = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), -np.sin(3 * t), np.cos(t) - 2 * np.cos(2 * t)])
knot = pv.Spline(curve, 260).tube(radius=0.5, n_sides=30, capping=False).triangulate()
knot.points[:, 2] -= knot.points[:, 2].min()
ground = pv.Plane(i_size=16, j_size=16, i_resolution=100, j_resolution=100)
stage = pv.MultiBlock({"ground": ground, "knot": knot})

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

# %%
# Cut triangles along the hard shadow
# -----------------------------------
# ``refine`` cuts triangles where the sun's shadow ends, so that its edge is crisp.

start = time.perf_counter()
sunlight = replace(scene, lights=[sun], light_model=replace(scene.light_model, ambient_occlusion=False))
crisp = stage.phong.refine(sunlight, materials, tolerance=0.05)
print(f"{time.perf_counter() - start:.2f} s; {sum(block.n_points for block in crisp):,} points")

# %%
# Cast rays to the lamp and the sky
# ---------------------------------
# ``visibility`` returns, for each block, a row for each light and one for the sky, with their standard errors. The
# sun's row is there already: ``refine`` left it.

start = time.perf_counter()
soft = crisp.phong.visibility(replace(scene, lights=[lamp]))
seen = {name: np.vstack([crisp[name]["phong_visibility_sun"], soft[name].per_light, soft[name].sky]) for name in soft}
lit = crisp.phong.shade(scene, materials, visibility=seen)
print(f"{time.perf_counter() - start:.2f} s with rays")
penumbra = (seen["ground"][1] > 0) & (seen["ground"][1] < 1)
error = soft["ground"].standard_error
print(f"{np.mean(penumbra):.1%} of the ground's points are in the lamp's penumbra")
print(f"largest standard errors on the ground: lamp {error.per_light.max():.4f}, sky {error.sky.max():.4f}")

# %%
# Light again without a ray
# -------------------------
# In the evening the sun is dim and red. It stands where it stood, so the same visibility holds.

evening = replace(scene, lights=[replace(sun, intensity=0.15, diffuse=(1.0, 0.4, 0.2)), lamp])
start = time.perf_counter()
dim = crisp.phong.shade(evening, materials, visibility=seen)
print(f"{time.perf_counter() - start:.3f} s without rays")

# %%
# Six arrays
# ----------
# The first row shows the light of the sun and of the lamp on white paper, and the visible part of the sky. The second
# row shows the colours without shadows, with them, and in the evening.

paper = crisp.phong.shade(scene, ph.Material(), components=True, visibility=seen)
plain = crisp.phong.shade(replace(scene, light_model=scene.light_model.without_rays()), materials)


def share(light: str) -> dict[str, np.ndarray]:
    """Return what arrives of a light, the most as white, encoded for the display."""
    shares = {name: paper[name][f"phong_light_{light}"] for name in seen}
    most = max(each.max() for each in shares.values())
    return {name: np.sqrt(each / most) for name, each in shares.items()}


pictures = {
    "the sun": share("sun"),
    "the lamp": share("lamp"),
    "the sky": {name: np.tile(seen[name][2, :, None], 3) for name in seen},
    "without shadows": {name: plain[name]["phong"] for name in seen},
    "lit": {name: lit[name]["phong"] for name in seen},
    "evening, no new ray": {name: dim[name]["phong"] for name in seen},
}
plotter = pv.Plotter(shape=(2, 3), window_size=(1200, 720), border=False)
for pane, (title, arrays) in enumerate(pictures.items()):
    plotter.subplot(*divmod(pane, 3))
    plotter.set_background("#20242c")
    for name, colors in arrays.items():
        plotter.add_mesh(crisp[name].copy(), scalars=colors, rgb=True, lighting=False)
    plotter.add_text(title, position=(12, 326), font_size=12, color="white")
    plotter.camera_position = [scene.viewer.position, scene.viewer.focal_point, scene.viewer.up]
plotter.enable_anti_aliasing("ssaa")
plotter.show()
