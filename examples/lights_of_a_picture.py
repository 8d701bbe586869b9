"""
Lights of a picture
===================

A picture that VTK drew, or a photograph with a known camera, shows where its lights were. ``ph.colors_from_image``
reads the colours at the points that the camera sees; ``fit`` finds the lights. Needs the extra ``fit``.
"""

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# A picture
# ---------
# VTK's own shader draws a knot under two lights, with 8 bits for each channel.

t = np.linspace(0, 2 * np.pi, 400)
curve = np.column_stack([(2 + np.cos(3 * t)) * np.cos(2 * t), (2 + np.cos(3 * t)) * np.sin(2 * t), np.sin(3 * t)])
knot = pv.Spline(curve, 500).tube(radius=0.42, n_sides=48, capping=False).triangulate().compute_normals()
true = [
    ph.DirectionalLight(direction=(1.0, 0.7, -1.2), intensity=0.55, diffuse=(1.0, 0.75, 0.5), name="warm"),
    ph.DirectionalLight(direction=(-1.0, 0.8, -0.1), intensity=0.45, diffuse=(0.45, 0.65, 1.0), name="cool"),
]
look = {"ambient": 0.05, "diffuse": 0.85, "specular": 0.35, "specular_power": 25}
camera = [(0.5, -9.5, 6.0), (0, 0, -0.1), (0, 0, 1)]
photographer = pv.Plotter(off_screen=True, window_size=(700, 560), lighting="none")
photographer.set_background("#16181c")
for light in true:
    photographer.add_light(light.to_pyvista())
photographer.add_mesh(knot, color="white", smooth_shading=True, **look)
photographer.camera_position = camera
picture = photographer.screenshot(return_img=True)
viewer = ph.Viewer.from_camera(photographer.camera)
photographer.close()

# %%
# The colours at the points
# -------------------------
# Points that are hidden, or at the edge of a silhouette, have no colour.

seen = ph.colors_from_image(knot, picture, viewer)
print(f"{np.isfinite(seen).all(axis=1).mean():.0%} of the points have a colour")

# %%
# The lights
# ----------
# The search begins with two white lights from above. The light model is VTK's.

begin = [ph.DirectionalLight(name="first"), ph.DirectionalLight(name="second")]
scene = ph.Scene(begin, viewer, ph.LightModel.vtk())
plastic = ph.Material(ambient=0.05, diffuse=0.85, specular=0.35, shininess=25)
fit = knot.phong.fit(scene, plastic, seen, "intensity diffuse direction")
print(fit)
for light in true:
    ways = [np.array(each.direction) / np.linalg.norm(each.direction) for each in (light, *fit.scene.lights)]
    cosines = [ways[0] @ way for way in ways[1:]]
    found = fit.scene.lights[int(np.argmax(cosines))]
    off = found.intensity * np.array(found.diffuse) / (light.intensity * np.array(light.diffuse)) - 1
    print(f"{light.name}: {np.degrees(np.arccos(max(cosines))):.3f}° off, colours within {np.abs(off).max():.2%}")

# %%
# The other side
# --------------
# With the lights known, the knot can be shown from a side that the picture does not show.

other = (-1.0, 12.0, 5.0)
from_there = ph.Scene(fit.scene.lights, ph.Viewer(position=other, up=(0, 0, 1)), ph.LightModel.vtk())
points = np.where(np.isnan(seen), (0.16, 0.17, 0.22), seen)
panes = {
    "read back": (points, camera),
    "read back, from behind": (points, [other, camera[1], camera[2]]),
    "lit by the lights found": (knot.phong.shade(from_there, plastic)["phong"], [other, camera[1], camera[2]]),
}
plotter = pv.Plotter(shape=(2, 2), window_size=(1200, 960), border=False)
sheet = pv.Plane(i_size=700, j_size=560)
plotter.add_mesh(sheet, texture=pv.Texture(picture), lighting=False)
plotter.view_xy()
plotter.camera.zoom(1.35)
plotter.set_background("#16181c")
plotter.add_text("the picture", position=(16, 436), font_size=13, color="white")
for pane, (title, (colors, place)) in enumerate(panes.items(), 1):
    plotter.subplot(*divmod(pane, 2))
    plotter.set_background("#16181c")
    plotter.add_mesh(knot.copy(), scalars=colors, rgb=True, lighting=False)
    plotter.add_text(title, position=(16, 436), font_size=13, color="white")
    plotter.camera_position = place
plotter.enable_anti_aliasing("ssaa")
plotter.show()
