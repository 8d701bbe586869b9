"""What visibility costs: hard shadows of three lights, the sky adaptive beside plain random rays, a light that moves.

    python tests/benchmarks/bench_visibility.py [points]

All in one run, so that ratios hold on a busy machine too. Errors are those against all 4096 nodes, of which the
adaptive rays are a part: at 500 rays a vertex that makes them look smaller by 6 %.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace

import numpy as np
import pyvista as pv

import pvphong as ph
from pvphong.rays.casting import has_embree
from pvphong.rays.faces import Faces
from pvphong.rays.occluders import Occluders

LIGHTS = [
    ph.DirectionalLight(direction=(1, 0, -1), name="sun"),
    ph.PointLight(position=(0, 0, 3), name="lamp"),
    ph.PointLight(position=(3, 0, 1), name="bulb"),
]


def torus(count: int) -> pv.PolyData:
    side = round(count**0.5)
    mesh = pv.ParametricTorus(u_res=side, v_res=side)
    mesh.point_data.active_normals = ph.vertex_normals(mesh)
    return mesh


def seconds(work) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def plain_sky(mesh: pv.PolyData, occluders: Occluders, rays: int) -> np.ndarray:
    """The sky by random directions."""
    random, normals = np.random.default_rng(1), np.asarray(mesh.point_data.active_normals, np.float64)
    begins, seen = mesh.points + 1e-5 * normals, np.zeros(mesh.n_points)
    for _ in range(rays):
        ways = normals + (sphere := random.normal(size=normals.shape)) / np.linalg.norm(sphere, axis=1)[:, None]
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        seen += ~occluders.blocked(begins, ways, np.full(len(begins), np.inf))
    return seen / rays


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    print(f"rays by {'Embree' if has_embree() else 'VTK'}")
    mesh = torus(count)
    seen = mesh.phong.visibility(LIGHTS)
    first = seconds(lambda: seen.channels((0,), sky=False))
    rest = seconds(lambda: seen.per_light)
    print(f"{mesh.n_points} vertices: one light with building {first:.2f} s, two more {rest:.2f} s; {seen.rays} rays")

    small = torus(10_000)
    triangles = small.faces.reshape(-1, 4)[:, 1:]
    occluders = Occluders([Faces(small.points.astype(np.float64), triangles)])
    occluders.blocked(small.points[:1].astype(np.float64), np.array([[0, 0, 1.0]]), np.ones(1))
    truth = small.phong.visibility([], samples=4096).sky
    bright = ph.Scene([], light_model=ph.LightModel(ambient=1.0))
    for tolerance in (0.02, 1 / 255):
        adaptive = small.phong.visibility(bright, tolerance=tolerance)
        ours = seconds(lambda now=adaptive: now.sky)
        error = float(np.sqrt(np.mean((adaptive.sky - truth) ** 2)))
        plain = float(np.mean(truth * (1 - truth)) / error**2)
        per_ray = seconds(lambda: plain_sky(small, occluders, 16)) / 16
        print(
            f"sky to {tolerance:.4f}: RMS error {error:.4f}, {adaptive.rays / small.n_points:.0f} rays a vertex, "
            f"{ours:.2f} s; as exact by plain rays: {plain:.0f} a vertex, {plain * per_ray:.2f} s"
        )

    middle = torus(100_000)
    record = middle.phong.visibility(LIGHTS)
    record.channels(range(3), sky=False)
    times = []
    for step in range(10):
        moved = [LIGHTS[0], replace(LIGHTS[1], position=(0.1 * step, 0, 3)), LIGHTS[2]]
        now = record.for_lights(moved, record.lights)
        times.append(seconds(lambda now=now: now.channels(range(3), sky=False)))
    print(f"{middle.n_points} vertices, one of three lights moves: {1e3 * np.median(times):.0f} ms")


if __name__ == "__main__":
    main()
