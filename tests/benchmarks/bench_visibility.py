"""What visibility costs: hard shadows of three lights, the sky beside plain random rays and libigl, a light that moves.

    python tests/benchmarks/bench_visibility.py [points]

All in one run, so that ratios hold on a busy machine too; the least of three runs counts. Hard shadows are compared
with embreex's own calls: making its mesh, building its tree, one query for each light. Errors of the sky are those
against all 4096 nodes, of which the adaptive rays are a part: at 500 rays a vertex that makes them look smaller by 6 %.
libigl's (pip install libigl), which weights its directions evenly, are those against 4096 rays of its own.
"""

import importlib.util
import sys
import time
from dataclasses import replace
from functools import partial

import numpy as np
import pyvista as pv

import pvphong as ph
from pvphong.rays.casting import BlockingFaces, Locator, Occluders, ray_backend

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


def least(make_work, repeats: int = 3) -> float:
    """The least seconds of what is made anew for each run."""
    return min(seconds(make_work()) for _ in range(repeats))


def triangles_of(mesh: pv.PolyData) -> np.ndarray:
    return mesh.faces.reshape(-1, 4)[:, 1:].astype(np.int64)


def by_embreex_alone(mesh: pv.PolyData) -> dict[str, float]:
    """Seconds of embreex's calls for the same rays, ready to be cast, on one thread."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    points, normals = np.asarray(mesh.points, np.float32), np.asarray(mesh.point_data.active_normals, np.float32)
    corners, scene, taken = triangles_of(mesh).astype(np.int32), EmbreeScene(robust=True), {}
    taken["mesh"] = seconds(lambda: TriangleMesh(scene, points, corners))
    one = np.ones((1, 3), np.float32)
    taken["tree"] = seconds(lambda: scene.run(one, one, dists=one[:, 0], query="OCCLUDED"))
    taken["rays"] = 0.0
    for light in LIGHTS:
        direction = getattr(light, "direction", None)
        directions = (
            light.position - points if direction is None else -np.broadcast_to(np.array(direction), points.shape)
        )
        facing = (directions * normals).sum(axis=1) > 0.0
        directions = np.array(directions[facing], np.float32)
        lengths = np.linalg.norm(directions, axis=1) if direction is None else np.full(len(directions), 9.0, np.float32)
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        rays = points[facing] + np.float32(1e-5) * normals[facing], directions
        taken["rays"] += seconds(
            lambda now=rays, ends=lengths: scene.run(*now, dists=ends.astype(np.float32), query="OCCLUDED")
        )
    return taken


def hard_shadows(count: int) -> None:
    mesh = torus(count)
    ours, building, rays, alone = [], [], 0, []
    for _ in range(3):
        seen = mesh.phong.visibility(LIGHTS)
        building.append(seconds(lambda now=seen: now.channels((0,), sky=False)))
        ours.append(building[-1] + seconds(lambda now=seen: now.per_light))
        rays = seen.rays
        if ray_backend()[0] is not Locator:
            alone.append(by_embreex_alone(mesh))
    print(
        f"{mesh.n_points} vertices, three lights, {rays} rays: "
        f"{min(ours):.2f} s, {min(building):.2f} s of it for the first"
    )
    if alone:
        parts = {name: min(each[name] for each in alone) for name in alone[0]}
        whole = min(sum(each.values()) for each in alone)
        said = ", ".join(f"{name} {value:.2f}" for name, value in parts.items())
        print(f"  embreex's calls alone: {whole:.2f} s ({said}); ours is {min(ours) / whole:.2f} times that")


def plain_sky(mesh: pv.PolyData, occluders: Occluders, rays: int) -> np.ndarray:
    """The sky by random directions."""
    random, normals = np.random.default_rng(1), np.asarray(mesh.point_data.active_normals, np.float64)
    begins, seen = mesh.points + 1e-5 * normals, np.zeros(mesh.n_points)
    for _ in range(rays):
        directions = normals + (sphere := random.normal(size=normals.shape)) / np.linalg.norm(sphere, axis=1)[:, None]
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        seen += ~occluders.blocked(begins, directions, np.full(len(begins), np.inf))
    return seen / rays


def by_libigl(mesh: pv.PolyData, rays: int) -> np.ndarray:
    import igl.embree

    points, normals = (np.asarray(a, np.float64) for a in (mesh.points, mesh.point_data.active_normals))
    return igl.embree.ambient_occlusion(points, triangles_of(mesh), points, normals, rays)


def the_sky(count: int) -> None:
    mesh = torus(count)
    occluders = Occluders([BlockingFaces(mesh.points.astype(np.float64), triangles_of(mesh))])
    occluders.blocked(mesh.points[:1].astype(np.float64), np.array([[0, 0, 1.0]]), np.ones(1))
    truth = mesh.phong.visibility([], samples=4096).sky
    bright = ph.Scene([], light_model=ph.LightModel(ambient=1.0))
    has_libigl = importlib.util.find_spec("igl") is not None
    if has_libigl:
        apart = float(np.sqrt(np.mean((by_libigl(mesh, 64) - by_libigl(mesh, 4096)) ** 2)))
    else:
        print("libigl is not installed (pip install libigl): not compared")
    for tolerance in (0.02, 1 / 255):
        adaptive = mesh.phong.visibility(bright, tolerance=tolerance)
        error = float(np.sqrt(np.mean((adaptive.sky - truth) ** 2)))
        ours = least(lambda now=adaptive: partial(getattr, now.afresh(), "sky"))
        plain = float(np.mean(truth * (1 - truth)) / error**2)
        per_ray = least(lambda: lambda: plain_sky(mesh, occluders, 16)) / 16
        print(
            f"{mesh.n_points} vertices, sky to {tolerance:.4f}: RMS error {error:.4f}, "
            f"{adaptive.rays / mesh.n_points:.0f} rays a vertex, {ours:.2f} s"
        )
        print(
            f"  as exact by plain rays: {plain:.0f} a vertex, {plain * per_ray:.2f} s, "
            f"{plain * per_ray / ours:.1f} times ours"
        )
        if has_libigl:
            rays = max(round(64 * (apart / error) ** 2), 1)
            theirs = least(lambda now=rays: lambda: by_libigl(mesh, now), 2)
            print(f"  as exact by libigl: {rays} a vertex, {theirs:.2f} s, {theirs / ours:.1f} times ours")


def a_drag(count: int) -> None:
    mesh = torus(count)
    record = mesh.phong.visibility(LIGHTS)
    record.channels(range(3), sky=False)
    times = []
    for step in range(10):
        moved = [LIGHTS[0], replace(LIGHTS[1], position=(0.1 * step, 0, 3)), LIGHTS[2]]
        now = record.for_lights(moved, record.lights)
        times.append(seconds(lambda now=now: now.channels(range(3), sky=False)))
    print(f"{mesh.n_points} vertices, one of three lights moves: {1e3 * np.median(times):.0f} ms")


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    print(f"rays by {'Embree' if ray_backend()[0] is not Locator else 'VTK'}")
    hard_shadows(count)
    the_sky(count // 20)
    a_drag(count // 10)


if __name__ == "__main__":
    main()
