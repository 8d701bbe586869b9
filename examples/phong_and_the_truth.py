"""
Phong and the truth
===================

The errors of light models, from constant ambient light to all bounces, against the rendering equation, and their cost.

It needs the extra ``rays``.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pyvista as pv

import pvphong as ph

# %%
# A room of coloured walls
# ------------------------
# All surfaces are one mesh, with their colours as the array ``"paint"``.


def painted(mesh: pv.PolyData, normals: object, paint: tuple[float, float, float]) -> pv.PolyData:
    """Return the mesh with these normals and this albedo, and no other arrays."""
    mesh.clear_data()
    mesh.point_data.active_normals = normals
    mesh.point_data["paint"] = np.tile(np.array(paint, np.float32), (mesh.n_points, 1))
    return mesh


def wall(center: tuple, inward: tuple, paint: tuple) -> pv.PolyData:
    """Return a square of side 2 whose normals point inward."""
    plane = pv.Plane(center=center, direction=inward, i_size=2, j_size=2, i_resolution=22, j_resolution=22)
    return painted(plane, np.tile(np.array(inward, np.float32), (plane.n_points, 1)), paint)


WHITE, RED, BLUE = (0.75, 0.73, 0.7), (0.7, 0.08, 0.06), (0.08, 0.16, 0.6)
ball = pv.Sphere(radius=0.45, center=(0.35, -0.2, -0.53), theta_resolution=44, phi_resolution=44)
ring = pv.ParametricTorus(ringradius=0.42, crosssectionradius=0.14, u_res=60, v_res=30)
ring = ring.compute_normals().rotate_x(70).rotate_z(-20).translate((-0.42, 0.3, -0.42))
room = pv.merge(
    [
        wall((0, 0, -1), (0, 0, 1), WHITE),
        wall((0, 0, 1), (0, 0, -1), WHITE),
        wall((0, 1, 0), (0, -1, 0), WHITE),
        wall((-1, 0, 0), (1, 0, 0), RED),
        wall((1, 0, 0), (-1, 0, 0), BLUE),
        painted(ball, ball.point_normals, WHITE),
        painted(ring, ring.point_normals, WHITE),
    ],
    merge_points=False,
)
lamp = ph.RectangleLight(position=(0, 0, 0.99), direction=(0, 0, -1), width=0.7, height=0.7, intensity=1.0, name="lamp")
scene = ph.Scene(
    lights=[lamp],
    viewer=ph.Viewer(position=(0, -4.7, 0), focal_point=(0, 0, 0), up=(0, 0, 1)),
    light_model=ph.LightModel(ambient=0.1),
)
material = ph.Material(ambient=1.0, diffuse=1.0, specular=0.0, albedo="paint")

# %%
# From a constant to all bounces
# ------------------------------
# With ``truth=True``, ``tradeoff`` also lights the mesh with shadows, with occlusion, and with one or more bounces, and
# compares each with path tracing. Paths are random, so that the truth itself has some noise.

physics = room.phong.tradeoff(scene, material, seconds=1, truth=True).physics
print(physics.sentence())
for model in physics.models:
    print(f"{model.name:30} {model.seconds * 1e3:8.1f} ms, RMS error {model.rms:.4f}, at most {model.largest:.3f}")
print(f"{'path tracing':30} {physics.truth.seconds * 1e3:8.1f} ms, noise {physics.noise:.4f}")

# %%
# Where each model is wrong
# -------------------------
# Above, the room by each model; below, its difference from the truth. Red is too bright, blue too dark. Constant
# ambient light is too bright under the ball and too dark on the ceiling.

with tempfile.TemporaryDirectory() as folder:
    physics.plot(Path(folder) / "physics.png")
    image = plt.imread(Path(folder) / "physics.png")
figure = plt.figure(figsize=(image.shape[1] / 100, image.shape[0] / 100), dpi=100)
figure.figimage(image)
plt.show()
