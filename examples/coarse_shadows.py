"""Where light ends to reach a coarse ball: by rays from inside its faces, and by rays from its vertices.

Both balls have the same few corners and the same smooth normals. Rays that begin inside a face, as a renderer casts
them for every pixel, are blocked by the next faces where the normals still face the sun: a black staircase. Rays from
vertices, which are on the smooth surface that the corners were taken from, end to reach the sun where the normals say.
"""

import numpy as np
import pyvista as pv
from arguments import FOLDER, OFF_SCREEN

import pvphong as ph

SUN = ph.DirectionalLight(direction=(-1, 0.3, -0.45), name="sun")
CLAY = ph.Material(ambient=(0.9, 0.6, 0.4), diffuse=(0.9, 0.6, 0.4))
EARTH = ph.Material(ambient=0.6, diffuse=0.6)
VIEWER = ph.Viewer(position=(-1.0, -7.0, 2.6), focal_point=(-0.9, 0, -0.15), up=(0, 0, 1))
SCENE = ph.Scene([SUN], VIEWER, ph.LightModel(ambient=0.15, shadows=True))

ball = pv.Sphere(theta_resolution=14, phi_resolution=11, radius=1.0)
inside = ball.subdivide(5, "linear")  # points in the same coarse faces, with normals blended across them
ground = pv.Plane(center=(-1, 0, -1), i_size=9, j_size=7, i_resolution=450, j_resolution=350)
meshes = {"rays from inside the faces": inside, "rays from the vertices": ball}
seen = {name: mesh.phong.visibility(SCENE, occluders=[ground]) for name, mesh in meshes.items()}
balls = {name: mesh.phong.shade(SCENE, CLAY, visibility=seen[name]) for name, mesh in meshes.items()}
earth = ground.phong.shade(SCENE, EARTH, occluders=[ball])

facing = {name: np.asarray(lit.point_normals) @ -np.array(SUN.direction) > 0.01 for name, lit in balls.items()}
for name in balls:
    dark = np.mean(seen[name].per_light[0][facing[name]] == 0)
    print(f"{name}: {dark:.1%} of what faces the sun is black")

plotter = pv.Plotter(shape=(1, 2), off_screen=OFF_SCREEN, window_size=(1200, 520), border=False)
for pane, (name, lit) in enumerate(balls.items()):
    plotter.subplot(0, pane)
    plotter.set_background("#20242c")
    for mesh in (lit, earth):
        plotter.add_mesh(mesh.copy(), scalars="phong", rgb=True, lighting=False)
    plotter.add_text(name, position=(14, 484), font_size=13, color="white")
    plotter.camera_position = [VIEWER.position, VIEWER.focal_point, VIEWER.up]
    plotter.camera.zoom(1.3)
plotter.enable_anti_aliasing("ssaa")

picture = FOLDER / "coarse_shadows.png"
plotter.show(screenshot=picture)
print(f"wrote {picture}")
