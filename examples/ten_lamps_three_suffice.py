"""
Ten lamps of which three suffice
================================

The contributions of lights add up, so a list of lamps is a list of columns. ``max_lights`` chooses the fewest that come
within a tolerance of a target, and solves for their intensities. Needs the extra ``fit``.
"""

import time

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# A knot under ten softboxes
# --------------------------
# They stand around the knot in two rings, and all shine a little.

t = np.linspace(0, 2 * np.pi, 400)
curve = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])
knot = pv.Spline(curve, 300).tube(radius=0.55, n_sides=36, capping=False).triangulate()
floor = pv.Plane(center=(0, 0, -1.7), i_size=14, j_size=14, i_resolution=90, j_resolution=90)
stage = pv.MultiBlock({"knot": knot, "floor": floor})
lamps = []
for k in range(10):
    turn, height = 2 * np.pi * k / 10 + 0.3, (3.0, 6.5)[k % 2]
    place = np.array([6 * np.cos(turn), 6 * np.sin(turn), height])
    hue = (1.0, 0.82, 0.62) if k % 3 else (0.65, 0.8, 1.0)
    lamps.append(ph.DiskLight(place, -place, radius=0.6, intensity=8.0, diffuse=hue, name=f"lamp {k}"))
viewer = ph.Viewer(position=(4, -23, 15), focal_point=(0, 0, 0.9), up=(0, 0, 1))
scene = ph.Scene(lamps, viewer, ph.LightModel(ambient=0.05, shadows=True))
materials = {
    "knot": ph.Material(ambient=1.0, diffuse=(0.75, 0.72, 0.68), specular=0.25, shininess=30),
    "floor": ph.Material(ambient=1.0, diffuse=0.6),
}
seen = stage.phong.visibility(scene)

# %%
# A mood
# ------
# The knot should be as bright as if three of the lamps were strong and the others weak.

strong = {1: 28.0, 4: 7.0, 8: 16.0}
mood = [ph.DiskLight(each.position, each.direction, each.radius, intensity=strong.get(k, 0.35), diffuse=each.diffuse)
        for k, each in enumerate(lamps)]  # fmt: skip
asked = stage.phong.shade(ph.Scene(mood, viewer, scene.light_model), materials)
target = {name: asked[name]["phong"] for name in seen}

# %%
# From one lamp to ten
# --------------------
# Each fit uses the visibility from above, so no new rays are cast.

start, fits = time.perf_counter(), []
for count in range(1, 11):
    fits.append(stage.phong.fit(scene, materials, target, "intensity", max_lights=count, visibility=seen))
    print(f"{count:2} lamps: error {fits[-1].error.rms:.4f}")
print(f"{(time.perf_counter() - start) / 10:.3f} s each")

enough = stage.phong.fit(scene, materials, target, "intensity", max_lights=10, tolerance=0.02, visibility=seen)
print(enough)

# %%
# What they show
# --------------
# Three lamps cannot be told from ten. One lamp, the best of all, misses the shadows.

pictures = {"asked for: ten lamps": (asked, mood)}
for fit in (enough, fits[0]):
    on = [light for light in fit.scene.lights if light.on]
    pictures[f"{len(on)} of ten: error {fit.error.rms:.3f}"] = fit.lit, on
plotter = pv.Plotter(shape=(1, 3), window_size=(1380, 520), border=False)
for pane, (title, (blocks, shining)) in enumerate(pictures.items()):
    plotter.subplot(0, pane)
    plotter.set_background("#16181c")
    for block in blocks:
        plotter.add_mesh(block.copy(), scalars=np.sqrt(block["phong"]), rgb=True, lighting=False)
    for lamp in shining:
        disk = pv.Disc(center=lamp.position, normal=lamp.direction, inner=0, outer=lamp.radius, c_res=40)
        plotter.add_mesh(disk, color=lamp.diffuse, opacity=1.0 if lamp.intensity > 1.0 else 0.35, lighting=False)
    plotter.add_text(title, position=(16, 474), font_size=13, color="white")
    plotter.camera_position = [(4, -23, 15), (0, 0, 0.9), (0, 0, 1)]
plotter.enable_anti_aliasing("ssaa")
plotter.show()
