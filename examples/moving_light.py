"""A light that moves: its handle is set, a frame is written, and the shadows of a stone circle sweep over the ground.

`plotter.phong.add_light` returns a handle. Each field of the light is one of its attributes, and the next frame shows
what has been set. `plotter.open_gif` needs imageio, which the extra `gif` brings; with the extra `rays` the frames
take a fraction of the time.
"""

from importlib.util import find_spec

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph

if find_spec("imageio") is None:
    raise SystemExit("A GIF needs imageio: pip install imageio.")

FRAMES, STONES = 30, 10
CIRCLE = np.linspace(0, 2 * np.pi, STONES, endpoint=False) + np.pi / STONES

plotter = pv.Plotter(off_screen=OFF_SCREEN, window_size=(400, 250), lighting="none")
plotter.set_background("#06070c")
plotter.phong.light_model = ph.LightModel(ambient=0, shadows=True)
plotter.phong.add_light(ph.PointLight(frame="headlight", diffuse=(0.05, 0.07, 0.13), name="night"))
lamp = plotter.phong.add_light(ph.SphereLight(radius=0.14, diffuse=(1.0, 0.6, 0.28), intensity=4.5, name="lamp"))
glow = plotter.add_mesh(pv.Sphere(radius=0.14), color="#ffe9c9", lighting=False)

stone = ph.Material(ambient=0, diffuse=0.85)
stones = [
    pv.Cylinder(center=(2.7 * np.cos(angle), 2.7 * np.sin(angle), 0.65), direction=(0, 0, 1), radius=0.24, height=1.3)
    for angle in CIRCLE
]
plotter.phong.add_mesh(pv.merge([each.triangulate().subdivide(1) for each in stones]), stone, feature_angle=40)
plotter.phong.add_mesh(pv.Disc(inner=0, outer=5.2, r_res=72, c_res=280).triangulate(), stone)
pearl = ph.Material(ambient=0, diffuse=0.45, specular=0.8, shininess=50)
plotter.phong.add_mesh(pv.Sphere(radius=0.6, center=(0, 0, 0.6), theta_resolution=70, phi_resolution=50), pearl)

plotter.camera_position = [(0, -7.6, 7.0), (0, 0.1, 0), (0, 0, 1)]
plotter.camera.view_angle = 28
plotter.enable_anti_aliasing("msaa", multi_samples=8)
picture = FOLDER / "moving_light.gif"
plotter.open_gif(picture, fps=15)
for angle in np.linspace(0, 2 * np.pi, FRAMES, endpoint=False):
    lamp.position = (1.5 * np.cos(angle), 1.5 * np.sin(angle), 1.15 + 0.25 * np.sin(2 * angle))
    glow.position = lamp.position
    plotter.write_frame()
plotter.close()
print(f"wrote {picture}")
