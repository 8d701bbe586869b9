"""
Normals under shear
===================

Why normals are multiplied by the inverse-transpose: a sheared sphere, lit with right and with wrong normals.

A normal is not an arrow that moves along with the surface. It is the direction perpendicular to it. If points are
multiplied by a matrix M, normals have to be multiplied by the transpose of M's inverse.
"""

import warnings

import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# Shear a sphere
# --------------
# :mod:`pvphong.pipeline` has the transformations of points, vectors and normals. Normals that are transformed as
# vectors are wrong.

shear = np.array([[1, 1.2, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])  # x grows with y
sphere = pv.Sphere(theta_resolution=90, phi_resolution=91)
normals = np.asarray(sphere.point_normals)
right = ph.pipeline.transform_normals(normals, shear)
wrong = ph.pipeline.transform_vectors(normals, shear)
wrong /= np.linalg.norm(wrong, axis=1, keepdims=True)

angles = np.degrees(np.arccos(np.clip((right * wrong).sum(axis=1), -1, 1)))
print(f"multiplied by M itself, normals are wrong by up to {angles.max():.0f}°, {angles.mean():.0f}° on average")

# %%
# The light seems to move
# -----------------------
# The light comes from the top left. With wrong normals it seems to come from elsewhere, and the arrows are not
# perpendicular to the surface. pvphong warns of such normals; here they are wrong on purpose.

warnings.simplefilter("ignore", ph.NormalsWarning)
scene = ph.Scene(
    lights=[ph.DirectionalLight(direction=(1, -1.2, -1), intensity=0.9)],
    viewer=ph.Viewer(position=(0, 0, 6), parallel=True, parallel_scale=0.95),
)
clay = ph.Material(ambient=0.6, diffuse=(0.85, 0.5, 0.35), specular=0.5, shininess=25)
outline = np.flatnonzero(np.abs(sphere.points[:, 2]) < 1e-6)[::3]

plotter = pv.Plotter(shape=(1, 2), window_size=(1200, 560), border=False)
for pane, (title, turned) in enumerate({"inverse-transpose of M": right, "M itself: wrong": wrong}.items()):
    mesh = sphere.copy()
    mesh.points = ph.pipeline.transform_points(sphere.points, shear)
    mesh.point_data.active_normals = turned
    plotter.subplot(0, pane)
    plotter.set_background("white")
    plotter.add_mesh(mesh.phong.shade(scene, clay), scalars="phong", rgb=True, lighting=False)
    plotter.add_arrows(mesh.points[outline], turned[outline], mag=0.2, color="#30343c", lighting=False)
    plotter.add_text(title, position="upper_edge", font_size=14, color="black")
    plotter.camera_position = [scene.viewer.position, scene.viewer.focal_point, scene.viewer.up]
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = scene.viewer.parallel_scale
plotter.enable_anti_aliasing("ssaa")
plotter.show()
