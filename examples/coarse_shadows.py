"""
Shadows of a coarse ball
========================

Where does light stop reaching a ball with few triangles? Rays that start inside the faces answer with a black
staircase. Rays that start at the vertices answer with a smooth edge.

This is the *shadow terminator problem* of renderers. It arises because smooth normals describe a round ball, and the
triangles are flat: a face that the normals call lit may lie in the shadow of its neighbours.
"""

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# Two balls with the same triangles
# ---------------------------------
# ``coarse`` has 11 × 14 points. ``dense`` has many points inside the same flat faces, with normals blended across
# them: that is what a renderer sees when it casts a ray for each pixel.

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
