"""Lighting of vertices by pvphong and by alternatives: time against error, for seven jobs and three sizes.

    python tests/benchmarks/bench_peers.py [10000 100000 1000000] [--figure FILE] [--blender PYTHON]

`ways.py` describes the measurement and what to install. Errors are computed on the vertices of the smallest size,
because the error of rays does not depend on the number of vertices. The truth is `mesh.phong.truth`, our own visibility
with many different rays, or float64 if no rays are needed. Mitsuba (which needs a point within a face), Blender and
libigl place the vertices slightly differently. They are compared with their own results with many rays, and excluded
if these differ from ours.
"""

import platform
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from importlib.metadata import PackageNotFoundError, version

import bench_transport
import bench_visibility
import cyclopts
import numpy as np
import pyvista as pv
import ray_peers
import scene_peers
from common import CONSOLE, THREADS, Caster, begin_on, textbook, timed
from ways import BLENDER, LIBIGL, MITSUBA, OURS, Row, Way, draw, show_row

import pvphong as ph
from pvphong.vtk.oracle import vtk_shade

SIZES = (10_000, 100_000, 1_000_000)
TEXTBOOK, SHADER = "textbook, NumPy", "VTK's shader"
STYLES = {OURS: ("#1b6ca8", "o"), MITSUBA: ("#c2571a", "s"), BLENDER: ("#6b4c9a", "D"), LIBIGL: ("#2a7f3f", "^")}
STYLES |= {TEXTBOOK: ("#8a8a8a", "v"), SHADER: ("#c9a227", "P")}
EYE = (2.0, -3.0, 1.5)


def ball(size: int, lights: list[ph.Light], material: ph.Material, *, is_cap: bool = False) -> scene_peers.Job:
    """Return a ball, which needs no rays because it is convex, or a cap, of which the eye sees every vertex."""
    side = max(round(size**0.5), 4)
    angles = {"theta_resolution": side, "phi_resolution": side, "end_phi": 60.0 if is_cap else 180.0}
    mesh = pv.Sphere(radius=1.0, direction=EYE, **angles)
    mesh.point_data.active_normals = np.array(mesh.points / np.linalg.norm(mesh.points, axis=1)[:, None])
    model = ph.LightModel(ambient=0.0, clamp=False)
    scene = ph.Scene(lights, ph.Viewer(EYE, (0, 0, 0), (0, 0, 1)), model)
    return scene_peers.Job(pv.MultiBlock({"ball": mesh}), scene, {"ball": material})


def lamps(count: int) -> list[ph.Light]:
    """Return lamps evenly around, at a distance of three radii; their total brightness is independent of `count`."""
    number = np.arange(count) + 0.5
    height, turn = 1.0 - 2.0 * number / count, np.pi * (1.0 + 5.0**0.5) * number
    around = np.sqrt(1.0 - height**2)
    places = 3.0 * np.column_stack([around * np.cos(turn), around * np.sin(turn), height])
    return [ph.PointLight(tuple(place), (0, 0, 1), intensity=40.0 / count) for place in places.tolist()]


def sky_image() -> np.ndarray:
    """Return the image of a smooth sky with a bright spot."""
    rows, columns = np.meshgrid(np.linspace(0, 1, 64), np.linspace(0, 1, 128), indexing="ij")
    spot = np.exp(-((rows - 0.3) ** 2 + (columns - 0.4) ** 2) / 0.01)
    return 0.3 + 0.4 * rows[..., None] * np.array([0.4, 0.6, 1.0]) + 6.0 * spot[..., None] * np.array([1.0, 0.9, 0.7])


def shade(job: scene_peers.Job) -> Caster:
    """Return a caster that times the whole call in float32, the default."""

    def work(_rays: int) -> np.ndarray:
        lit = job.blocks.phong.shade(job.scene, job.materials)
        return np.concatenate([block["phong"] for block in lit])

    work(1)
    return timed(work)


def exactly(job: scene_peers.Job) -> np.ndarray:
    (block,), (material,) = job.blocks, job.materials.values()
    how = {"precision": "float64", "backend": "numpy"}
    return ph.evaluate(block.points, block.point_data.active_normals, job.scene, material, **how).rgb


def by_textbook(job: scene_peers.Job) -> Caster:
    (block,), (material,) = job.blocks, job.materials.values()
    points, normals = np.array(block.points, float), np.array(block.point_data.active_normals, float)
    return timed(lambda _: textbook(points, normals, job.scene, material))


def by_shader(job: scene_peers.Job) -> Caster:
    """Return a caster that renders with VTK, in software without a graphics card, and reads the colours back."""
    (block,), (material,) = job.blocks, job.materials.values()
    return timed(lambda _: vtk_shade(block, job.scene.lights, material, job.scene.viewer))


def direct(name: str, count: int, blender: Callable) -> Row:
    matt = ph.Material(ambient=0.0, diffuse=0.7, specular=0.0)
    several = (1,) if count == 1 else (16, 64, 256)
    ways = [
        Way(OURS, shade),
        Way(TEXTBOOK, by_textbook),
        Way(SHADER, by_shader),
        Way(MITSUBA, scene_peers.mitsuba, several, 100_000, own_truth=4 if count == 1 else 4096),
        Way(BLENDER, blender, several if count == 1 else (16, 64), 1200, own_truth=4 if count == 1 else 2048),
    ]
    return Row(name, lambda size: ball(size, lamps(count), matt), exactly, ways)


def glossy(blender: Callable) -> Row:
    """Return a row that is judged by path tracing, because `shade` approximates a lobe under a sky with an image."""
    mirror = ph.Material(ambient=0.0, diffuse=0.0, specular=0.0, reflectance=ph.GGX(0.4, (1.0, 1.0, 1.0)))
    ways = [
        Way(OURS, shade),
        Way(MITSUBA, scene_peers.mitsuba, (16, 64, 256), 100_000, own_truth=4096),
        Way(BLENDER, blender),
    ]
    sky, by_paths = [ph.EnvironmentLight(sky_image())], partial(bench_transport.judged, paths=4096)
    return Row("A mirror of GGX under a sky", lambda size: ball(size, sky, mirror, is_cap=True), by_paths, ways)


def seen(name: str, make: Callable[[int], ray_peers.Job], blender: str | None) -> Row:
    ways = [
        Way(OURS, bench_visibility.ours, (16, 64, 256)),
        Way(MITSUBA, ray_peers.mitsuba, (16, 64, 256), 100_000),
        Way(LIBIGL, ray_peers.libigl, (16, 64, 256), 10_000, own_truth=4096),
        Way(BLENDER, partial(ray_peers.blender, python=blender), (16, 64), 1200, own_truth=2048),
    ]
    return Row(name, make, bench_visibility.truth_of, ways, judged_at=1)


def rows_of(blender: str | None) -> list[Row]:
    bake = partial(scene_peers.blender, python=blender)
    return [
        direct("One lamp", 1, bake),
        direct("64 lamps", 64, bake),
        seen("A penumbra", bench_visibility.penumbra, blender),
        seen("The sky, with occlusion", bench_visibility.open_sky, blender),
        bench_transport.row("One bounce", 1, blender),
        bench_transport.row("All bounces", scene_peers.ALL_BOUNCES, blender),
        glossy(bake),
    ]


def machine() -> str:
    packages = []
    for name in ("numpy", "pyvista", "vtk", "numba", "embreex", "mitsuba", "libigl"):
        packages.append(f"no {name}")
        with suppress(PackageNotFoundError):
            packages[-1] = f"{name} {version(name)}"
    processor = platform.processor() or platform.machine()
    return f"{processor}, Python {platform.python_version()}, {', '.join(packages)}"


def main(*vertices: float, figure: str = "", blender: str | None = None) -> None:
    begin_on(THREADS)
    CONSOLE.print(machine())
    rows, sizes = rows_of(blender), sorted(map(int, vertices or SIZES))
    for row in rows:
        row.measure(sizes)
        show_row(row, sizes)
    if figure:
        draw(rows, [sizes[min(1, len(sizes) - 1)]] * len(rows), figure, STYLES)


if __name__ == "__main__":
    cyclopts.run(main)
