"""
Shadows of a coarse ball
========================

On a ball with few triangles, the border between light and shade depends on where shadow rays start. With rays from
inside the faces it is a black staircase. With rays from the vertices, as pvphong casts them, it is smooth.

Renderers know this as the *shadow terminator problem*. Smooth normals describe a round ball, but the triangles are
flat: a face that is lit according to its normals may be in the shadow of its neighbours.
"""

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# Two balls with the same triangles
# ---------------------------------
# ``coarse`` has 11 × 14 points. ``dense`` has many points inside the same flat faces, with normals blended across
# them. A renderer that casts a ray for each pixel has the same rays.

SUN = ph.DirectionalLight(direction=(-1, 0.3, -0.45), name="sun")
CLAY = ph.Material(ambient=(0.9, 0.6, 0.4), diffuse=(0.9, 0.6, 0.4))
EARTH = ph.Material(ambient=0.6, diffuse=0.6)
VIEWER = ph.Viewer(position=(-1.0, -7.0, 2.6), focal_point=(-0.9, 0, -0.15), up=(0, 0, 1))
SCENE = ph.Scene([SUN], VIEWER, ph.LightModel(ambient=0.15, shadows=True))

coarse = pv.Sphere(theta_resolution=14, phi_resolution=11, radius=1.0)
dense = coarse.subdivide(5, "linear")
ground = pv.Plane(center=(-1, 0, -1), i_size=9, j_size=7, i_resolution=360, j_resolution=280)

# %%
# Visibility, then colours
# ------------------------
# ``visibility`` casts the rays and returns, for each light, the part of it that each vertex sees. ``shade`` takes it.

balls, facing = {}, {}
for name, mesh in {"rays from inside the faces": dense, "rays from the vertices": coarse}.items():
    seen = mesh.phong.visibility(SCENE, occluders=[ground])
    balls[name] = mesh.phong.shade(SCENE, CLAY, visibility=seen)
    faces_sun = np.asarray(balls[name].point_normals) @ -np.array(SUN.direction) > 0.01
    dark = np.mean(seen.per_light[0][faces_sun] == 0)
    print(f"{name}: {dark:.1%} of the points that face the sun are black")
earth = ground.phong.shade(SCENE, EARTH, occluders=[coarse])

# %%
# The staircase, and the smooth edge
# ----------------------------------

plotter = pv.Plotter(shape=(1, 2), window_size=(1200, 520), border=False)
for pane, (name, lit) in enumerate(balls.items()):
    plotter.subplot(0, pane)
    plotter.set_background("#20242c")
    for mesh in (lit, earth):
        plotter.add_mesh(mesh.copy(), scalars="phong", rgb=True, lighting=False)
    plotter.add_text(name, position=(14, 484), font_size=13, color="white")
    plotter.camera_position = [VIEWER.position, VIEWER.focal_point, VIEWER.up]
    plotter.camera.zoom(1.3)
plotter.enable_anti_aliasing("ssaa")
plotter.show()
