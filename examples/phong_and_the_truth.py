"""Phong and the truth: what the constant ambient light hides, and what each step towards the rendering equation costs.

A room of coloured walls is lit by models from the textbook's to light that bounces until nothing changes, and by paths
of light, which are the judge. Needs the extra `rays`.
"""

import numpy as np
import pyvista as pv
from arguments import FOLDER

import pvphong as ph


def wall(center: tuple[float, float, float], inward: tuple[float, float, float], paint: object) -> pv.PolyData:
    """A square of side 2, of which the side that looks inward sends light."""
    plane = pv.Plane(center=center, direction=inward, i_size=2, j_size=2, i_resolution=30, j_resolution=30)
    return painted(plane, np.tile(np.array(inward, np.float32), (plane.n_points, 1)), paint)


def painted(mesh: pv.PolyData, normals: object, paint: object) -> pv.PolyData:
    """With normals and an albedo, and nothing else."""
    mesh.clear_data()
    mesh.point_data.active_normals = normals
    mesh.point_data["paint"] = np.tile(np.array(paint, np.float32), (mesh.n_points, 1))
    return mesh


WHITE, RED, BLUE = (0.75, 0.73, 0.7), (0.7, 0.08, 0.06), (0.08, 0.16, 0.6)
ball = pv.Sphere(radius=0.45, center=(0.35, -0.2, -0.53), theta_resolution=60, phi_resolution=60)
ring = pv.ParametricTorus(ringradius=0.42, crosssectionradius=0.14, u_res=80, v_res=40)
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

physics = room.phong.tradeoff(scene, material, seconds=5, truth=True).physics
print(physics.sentence())
for each in physics.models:
    print(f"{each.name:45} {each.seconds * 1e3:8.1f} ms, RMS error {each.rms:.4f}, at most {each.largest:.3f}")
print(f"{'paths of light':45} {physics.truth.seconds * 1e3:8.1f} ms, known to {physics.noise:.4f}")

picture = FOLDER / "phong_and_the_truth.png"
physics.plot(picture)
print(f"wrote {picture}")
