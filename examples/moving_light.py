"""
A light that moves
==================

Set a light's position, write a frame, and the shadows of a stone circle sweep over the ground.

``plotter.phong.add_light`` returns a handle. Each field of the light is an attribute of the handle: set it, and the
next frame shows the change. GIFs need the extra ``gif``; the extra ``rays`` makes each frame many times faster.
"""

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# The stage
# ---------
# Ten stones, a pearl and the ground. The lamp is a small sphere, so its shadows are soft.

FRAMES, STONES = 24, 10
CIRCLE = np.linspace(0, 2 * np.pi, STONES, endpoint=False) + np.pi / STONES

stones = [
    pv.Cylinder(center=(2.7 * np.cos(angle), 2.7 * np.sin(angle), 0.65), direction=(0, 0, 1), radius=0.24, height=1.3)
    for angle in CIRCLE
]
stones = pv.merge([each.triangulate().subdivide(1) for each in stones])
ground = pv.Disc(inner=0, outer=5.2, r_res=60, c_res=240).triangulate()
pearl = pv.Sphere(radius=0.6, center=(0, 0, 0.6), theta_resolution=60, phi_resolution=40)

# %%
# The lamp goes round
# -------------------
# Set ``lamp.position`` and write a frame. The meshes are lit again before it is drawn.

plotter = pv.Plotter(window_size=(480, 300), lighting="none", off_screen=True)
plotter.set_background("#06070c")
plotter.phong.light_model = ph.LightModel(ambient=0, shadows=True)
plotter.phong.add_light(ph.PointLight(frame="headlight", diffuse=(0.05, 0.07, 0.13), name="night"))
lamp = plotter.phong.add_light(ph.SphereLight(radius=0.14, diffuse=(1.0, 0.6, 0.28), intensity=4.5, name="lamp"))
glow = plotter.add_mesh(pv.Sphere(radius=0.14), color="#ffe9c9", lighting=False)

stone = ph.Material(ambient=0, diffuse=0.85)
plotter.phong.add_mesh(stones, stone, feature_angle=40)
plotter.phong.add_mesh(ground, stone)
plotter.phong.add_mesh(pearl, ph.Material(ambient=0, diffuse=0.45, specular=0.8, shininess=50))

plotter.camera_position = [(0, -7.6, 7.0), (0, 0.1, 0), (0, 0, 1)]
plotter.camera.view_angle = 28
plotter.enable_anti_aliasing("msaa", multi_samples=8)
plotter.open_gif("stone_circle.gif", fps=12)
for angle in np.linspace(0, 2 * np.pi, FRAMES, endpoint=False):
    lamp.position = (1.5 * np.cos(angle), 1.5 * np.sin(angle), 1.15 + 0.25 * np.sin(2 * angle))
    glow.position = lamp.position
    plotter.write_frame()
plotter.close()
