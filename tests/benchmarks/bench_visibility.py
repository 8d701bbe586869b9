"""Cost of rays for the same error, by pvphong and other programs; and hard shadows, adaptive rays, a moving light.

    python tests/benchmarks/bench_visibility.py [vertices] [--figure FILE] [--blender PYTHON]

The scenes are the penumbra of a torus on a plane of 100,000 vertices, or as many as are given, and the sky above a knot
with half as many. `ways.py` describes the measurement and what to install. Programs that use one thread, such as VTK,
appear up to twice as fast as they are. Hard shadows and updates per second are wall-clock times.

Errors are relative to 4096 different rays of ours, or to a program's own truth (see `ray_peers`). VTK and libigl run on
some of the vertices, and Blender bakes a coarser mesh.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import chain
from unittest.mock import patch

import cyclopts
import numpy as np
import pyvista as pv
import ray_peers as peers
from common import CONSOLE, THREADS, Caster, begin_on, equal_error_seconds, grid, show, timed
from ray_peers import Job
from ways import BLENDER, LIBIGL, MITSUBA, Row, Way, draw, relative, show_row

import pvphong as ph
from pvphong.meshes.visibility import KnownOccluders, world_faces
from pvphong.rays import casting
from pvphong.rays.casting import Embree, Embreex, Locator, Occluders, ray_backend
from pvphong.studio.lit_mesh import LitMesh

TURNS, RAYS, TRUTH, PREVIEW = 3, (16, 64, 256), 4096, 16
LIGHTS = [
    ph.DirectionalLight(direction=(1, 0, -1), name="sun"),
    ph.PointLight(position=(0, 0, 3), name="lamp"),
    ph.PointLight(position=(3, 0, 1), name="bulb"),
]
COLORS = "#1b6ca8", "#6fa8d6", "#b3cde3", "#c2571a", "#e3ab85", "#2a7f3f", "#6b4c9a", "#9a9a9a"  # of the ways


def penumbra(count: int) -> Job:
    """Return a plane under a sphere light, with a torus between them."""
    torus = pv.ParametricTorus(ringradius=0.9, crosssectionradius=0.3, u_res=120, v_res=60).triangulate()
    lamp = ph.SphereLight(position=(1.5, -1, 4), radius=0.5, intensity=16, name="lamp")
    return Job(grid(max(round(count**0.5) - 1, 1), 6.0), (torus.rotate_x(50).translate((0, 0, 1.2)),), lamp)


def open_sky(count: int) -> Job:
    """Return a knot, which occludes part of its own sky."""
    t, sides = np.linspace(0, 2 * np.pi, 400), max(round((count / 10) ** 0.5), 3)
    curve = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), -np.sin(3 * t), np.cos(t) - 2 * np.cos(2 * t)])
    knot = pv.Spline(curve, count // sides).tube(radius=0.5, n_sides=sides, capping=False).triangulate()
    knot.point_data.active_normals = ph.pipeline.vertex_normals(knot)
    return Job(knot)


# --- time against error


def seen_by(visibility: ph.Visibility) -> np.ndarray:
    return visibility.per_light[0] if visibility.lights else visibility.sky


def ours(job: Job, *, backend: type | None = None) -> Caster:
    """Return a caster of pvphong with a backend; by default the one that is installed."""
    if backend is Embree and ray_backend()[0] is not Embree:
        raise ImportError(ray_backend()[1])
    with patch.object(casting, "ray_backend", lambda: (backend or ray_backend()[0], "")):
        visibility = job.mesh.phong.visibility(job.scene, occluders=job.occluders)
        seen_by(visibility.afresh(samples=1))  # builds the shared trees
    return timed(lambda rays: seen_by(visibility.afresh(samples=rays)))


def truth_of(job: Job) -> np.ndarray:
    """Return our result with many rays; the vertices are in reverse order so that each has different rays."""
    last = job.mesh.n_points - 1
    turned = pv.PolyData.from_regular_faces(np.array(job.mesh.points[::-1]), last - job.mesh.regular_faces)
    turned.point_data.active_normals = np.array(job.mesh.point_data.active_normals[::-1])
    return ours(replace(job, mesh=turned))(TRUTH).found[::-1]


def row(name: str, make: Callable[[int], Job], blender: str | None) -> Row:
    ways = [
        Way("pvphong: compiled code, Embree", partial(ours, backend=Embree), (*RAYS, 1024)),
        Way("pvphong: embreex's run", partial(ours, backend=Embreex), RAYS),
        Way("pvphong: VTK's locator", partial(ours, backend=Locator), RAYS, step=64),
        Way(MITSUBA, peers.mitsuba, RAYS),
        Way("Mitsuba 3 as it comes", peers.mitsuba_as_it_comes, RAYS),
        Way(LIBIGL, peers.libigl, RAYS, step=8, own_truth=TRUTH),
        Way(BLENDER, partial(peers.blender, python=blender), RAYS, most=1200, own_truth=2048),
        Way("plain random rays, embreex's run", peers.plain_rays, RAYS),
    ]
    return Row(name, make, truth_of, ways, judged_at=RAYS.index(256), wanted=0.0)


def adaptive(row: Row, size: int) -> Iterator[list[str]]:
    """Yield table rows that compare adaptive rays with a fixed number of rays per vertex."""
    job = row.make(size)
    truth = row.judge(job)
    for tolerance in (0.02, 1 / 255) if row.first is row.ways[0] else ():
        known = job.mesh.phong.visibility(job.scene, occluders=job.occluders, tolerance=tolerance)
        error = relative(seen_by(known), truth)
        afresh = [known.afresh() for _ in range(TURNS)]
        seconds = min(timed(lambda _, each=each: seen_by(each))(0).seconds for each in afresh)
        over = equal_error_seconds(row.first.curve(size), error) / seconds
        rays = known.rays / len(job.points)
        yield [row.name, f"{tolerance:.4f}", f"{seconds:.3g}", f"{error:.1e}", f"{rays:.0f}", f"{over:.2f}"]


# --- hard shadows, and a light that moves


def hard_shadows(count: int) -> str:
    """Measure hard shadows of three lights, including construction, and embreex's calls alone."""
    side, taken, alone = round(count**0.5), [], []
    mesh = pv.ParametricTorus(u_res=side, v_res=side).triangulate()
    mesh.point_data.active_normals = ph.pipeline.vertex_normals(mesh)
    for _ in range(TURNS):
        seen = mesh.phong.visibility(LIGHTS)
        start = time.perf_counter()
        seen.per_light  # noqa: B018  the first access casts the rays
        taken.append(time.perf_counter() - start)
        with suppress(ImportError):
            alone.append(peers.embreex_alone(mesh, LIGHTS))
    beside = f"embreex's calls alone {min(alone):.2f} s" if alone else "embreex is missing"
    whole = f"{mesh.n_points:,} vertices, {mesh.n_cells:,} triangles, including construction: {min(taken):.2f} s"
    return f"Three hard lights, {whole}; {beside}"


def drags(count: int) -> str:
    """Measure updates of a window's colours while a light moves, including its rays."""
    job, told = penumbra(count), []
    among = KnownOccluders(Occluders([world_faces(each) for each in (job.mesh, *job.occluders)]), 0)
    for name, light in (("hard", ph.PointLight(job.light.position)), (f"soft, {PREVIEW} rays", job.light)):
        live, seconds = LitMesh(job.mesh, ph.Material()), []
        for step in range(16):
            moved = replace(light, position=(1.5 + 0.02 * step, -1, 4))
            scene = ph.Scene([moved], ph.Viewer(), light_model=ph.LightModel(shadows=True))
            start = time.perf_counter()
            live.refresh(scene, among, samples=PREVIEW)
            seconds.append(time.perf_counter() - start)
        told.append(f"{name} {1 / np.median(seconds[1:]):.0f}")
    return f"A light dragged over {len(job.points):,} vertices with shadows, updates per second: {', '.join(told)}"


def main(vertices: float = 100_000, *, figure: str = "", blender: str | None = None) -> None:
    begin_on(THREADS)
    count = int(vertices)
    CONSOLE.print(hard_shadows(10 * count))
    CONSOLE.print(drags(count))
    sizes = count, count // 2
    rows = row("A penumbra", penumbra, blender), row("The sky", open_sky, blender)
    for each, size in zip(rows, sizes, strict=True):
        each.measure([size])
        show_row(each, [size])
    headings = "scene", "tolerance", "seconds", "RMS error", "rays per vertex", "fixed over adaptive, same error"
    show("Adaptive", headings, chain(*map(adaptive, rows, sizes)))
    if figure:
        draw(rows, sizes, figure, {way.name: (color, "o") for way, color in zip(rows[0].ways, COLORS, strict=True)})


if __name__ == "__main__":
    cyclopts.run(main)
