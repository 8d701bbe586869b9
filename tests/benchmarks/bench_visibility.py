"""What rays cost for the same error, here and by other programs; and hard shadows, adaptive rays, a light that moves.

    python tests/benchmarks/bench_visibility.py [vertices] [--figure FILE] [--blender PYTHON]

Two scenes: the penumbra of a torus on a plane of 100,000 vertices, or as many as are given, and the sky as a knot of
half as many sees it. All have two threads; time is that of processors, both threads together, for on a busy machine
that of a clock says nothing. So what keeps one thread busy, as VTK does, looks up to twice as fast as it is. Hard
shadows and updates per second are by the clock. Preparation (trees of triangles, compiling) does not count, and of some
turns in one run the least does.

Errors are RMS over all vertices, against 4096 rays of ours that are chosen with other numbers, or a truth of their own
(`ray_peers` says whose and why). What takes long looks from some of the vertices, and its time is multiplied: VTK,
libigl, and Blender, which bakes a coarser mesh.

Others that are compared if they are there: `pip install mitsuba libigl`, Mitsuba with LLVM's library; and with
`--blender` a Python that has `pip install bpy`. Those that are missing are named.
"""

import subprocess
import time
from argparse import ArgumentParser
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from unittest.mock import patch

import numpy as np
import pyvista as pv
from rich.console import Console

import pvphong as ph
from pvphong.meshes.visibility import KnownOccluders, world_faces
from pvphong.rays import casting
from pvphong.rays.casting import Embree, Embreex, Locator, Occluders, ray_backend
from pvphong.studio.lit_mesh import LitMesh

try:
    from benchmarks import ray_peers as peers
    from benchmarks.common import Caster, begin_on, equal_error_seconds, slope, table, timed
    from benchmarks.ray_peers import Job
except ImportError:
    import ray_peers as peers
    from common import Caster, begin_on, equal_error_seconds, slope, table, timed
    from ray_peers import Job

TURNS, QUICK, RAYS, TRUTH, BLENDERS_TRUTH = 3, 5.0, (16, 64, 256), 4096, 2048
"""Ways that take less than `QUICK` seconds have so many turns, others one after their first answers."""
JUDGED_AT = RAYS.index(256)
"""Seconds are compared at the error that we have with so many rays."""
SLOW, VERTICES_OF_BLENDER, PREVIEW = 64, 1200, 16
LIGHTS = [
    ph.DirectionalLight(direction=(1, 0, -1), name="sun"),
    ph.PointLight(position=(0, 0, 3), name="lamp"),
    ph.PointLight(position=(3, 0, 1), name="bulb"),
]
STYLES = [
    ("#1b6ca8", "o"),
    ("#6fa8d6", "o"),
    ("#b3cde3", "o"),
    ("#c2571a", "s"),
    ("#e3ab85", "s"),
    ("#2a7f3f", "^"),
    ("#6b4c9a", "D"),
    ("#9a9a9a", "v"),
]
"""Colours and markers of the ways, in their order."""
CONSOLE = Console(width=160)


def penumbra(count: int) -> Job:
    """A plane that looks at a sphere light past a torus."""
    cells = max(round(count**0.5) - 1, 1)
    ground = pv.Plane(i_size=6, j_size=6, i_resolution=cells, j_resolution=cells).triangulate()
    ground.point_data.active_normals = np.tile(np.float32([0, 0, 1]), (ground.n_points, 1))
    torus = pv.ParametricTorus(ringradius=0.9, crosssectionradius=0.3, u_res=120, v_res=60).triangulate()
    lamp = ph.SphereLight(position=(1.5, -1, 4), radius=0.5, intensity=16, name="lamp")
    return Job(ground, (torus.rotate_x(50).translate((0, 0, 1.2)),), lamp)


def open_sky(count: int) -> Job:
    """A knot, which hides a part of the sky from itself."""
    t, sides = np.linspace(0, 2 * np.pi, 400), max(round((count / 10) ** 0.5), 3)
    curve = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), -np.sin(3 * t), np.cos(t) - 2 * np.cos(2 * t)])
    knot = pv.Spline(curve, count // sides).tube(radius=0.5, n_sides=sides, capping=False).triangulate()
    knot.point_data.active_normals = ph.vertex_normals(knot)
    return Job(knot)


# --- time against error


def seen_by(visibility: ph.Visibility) -> np.ndarray:
    return visibility.per_light[0] if visibility.lights else visibility.sky


def ours(job: Job, *, backend: type | None = None) -> Caster:
    """By pvphong, with one of its backends, or with what casts rays here."""
    if backend is Embree and ray_backend()[0] is not Embree:
        raise ImportError(ray_backend()[1])
    with patch.object(casting, "ray_backend", lambda: (backend or ray_backend()[0], "")):
        visibility = job.mesh.phong.visibility(job.scene, occluders=job.occluders)
        seen_by(visibility.afresh(samples=1))  # what it is built of is shared
    return timed(lambda rays: seen_by(visibility.afresh(samples=rays)))


def truth_of(job: Job) -> np.ndarray:
    """With the vertices in reverse order, so that each has other rays."""
    last = job.mesh.n_points - 1
    turned = pv.PolyData.from_regular_faces(np.array(job.mesh.points[::-1]), last - job.mesh.regular_faces)
    turned.point_data.active_normals = np.array(job.mesh.point_data.active_normals[::-1])
    return ours(replace(job, mesh=turned))(TRUTH).found[::-1]


@dataclass
class Way:
    """One way to cast rays, and what came of it."""

    name: str
    prepare: Callable[[Job], Caster]
    job: Job
    truth: np.ndarray | int
    """Shape (n,); or so many rays of its own."""
    rays: tuple[int, ...] = RAYS
    share: float = 1.0
    """The share of the vertices that it looks from."""
    obstacle: str = ""

    def begin(self) -> None:
        """Prepare, and have first answers."""
        self.seconds = dict.fromkeys(self.rays, np.inf)
        try:
            self.cast = self.prepare(self.job)
            truth = self.cast(self.truth).found if isinstance(self.truth, int) else self.truth
            parts = self.measure()
            self.errors = {rays: float(np.sqrt(np.mean((part - truth) ** 2))) for rays, part in parts.items()}
        except NotImplementedError as reason:
            self.obstacle = str(reason)
        except (ImportError, OSError, RuntimeError, subprocess.SubprocessError) as reason:
            self.obstacle = f"missing: {str(reason).splitlines()[0]}"

    def measure(self) -> dict[int, np.ndarray]:
        """What is seen, by rays."""
        casts = {rays: self.cast(rays) for rays in self.rays}
        self.seconds = {rays: min(self.seconds[rays], cast.seconds / self.share) for rays, cast in casts.items()}
        self.takes = sum(cast.seconds for cast in casts.values())
        return {rays: cast.found for rays, cast in casts.items()}

    @property
    def curve(self) -> list[tuple[float, float]]:
        """Seconds and error, by rays."""
        return [(self.seconds[rays], self.errors[rays]) for rays in self.rays]


def measured(make: Callable[[int], Job], count: int, blender: str | None) -> list[Way]:
    job = make(count)
    truth, few, coarse = truth_of(job), job.some(SLOW), make(VERTICES_OF_BLENDER)
    share = len(few.points) / len(job.points)
    ways = [
        Way("pvphong: compiled code, Embree", partial(ours, backend=Embree), job, truth, (*RAYS, 1024)),
        Way("pvphong: embreex's run", partial(ours, backend=Embreex), job, truth),
        Way("pvphong: VTK's locator", partial(ours, backend=Locator), few, truth[::SLOW], share=share),
        Way("Mitsuba 3", peers.mitsuba, job, truth),
        Way("Mitsuba 3 as it comes", peers.mitsuba_as_it_comes, job, truth),
        Way("libigl", peers.libigl, job.some(8), TRUTH, share=len(job.points[::8]) / len(job.points)),
        Way(
            "Blender's bake",
            partial(peers.blender, python=blender),
            coarse,
            BLENDERS_TRUTH,
            share=len(coarse.points) / len(job.points),
        ),
        Way("plain random rays, embreex's run", peers.plain_rays, job, truth),
    ]
    for way in ways:
        way.begin()
    for turn in range(TURNS):
        for way in ways:
            if not way.obstacle and (turn == 0 or way.takes < QUICK):
                way.measure()
    return ways


def error_table(name: str, ways: list[Way]):
    best = ways[0] if not ways[0].obstacle else next(way for way in ways if not way.obstacle)
    error, seconds = best.curve[JUDGED_AT][::-1]
    headings = [f"{rays} rays" for rays in (*RAYS, 1024)]
    made = table(name, "cast by", *headings, "slope", f"seconds to {error:.1e}", "times the first")
    for way in ways:
        if way.obstacle:
            made.add_row(way.name, way.obstacle)
            continue
        cells = [f"{taken:.3g} s, {off:.1e}" for taken, off in way.curve] + [""] * (len(headings) - len(way.curve))
        same = equal_error_seconds(way.curve, error)
        falls = slope(way.rays, list(way.errors.values()))
        made.add_row(way.name, *cells, f"{falls:.2f}", f"{same:.3g}", f"{same / seconds:.3g}")
    return made


def adaptive_table(scenes: dict[str, list[Way]]):
    """As many rays as the tolerance asks for, beside as many for all vertices."""
    headings = "scene", "tolerance", "seconds", "RMS error", "rays a vertex", "fixed over adaptive, same error"
    made = table("Adaptive", *headings)
    for name, (fixed, *_) in scenes.items():
        for tolerance in (0.02, 1 / 255) if not fixed.obstacle else ():
            job, seconds = fixed.job, []
            known = job.mesh.phong.visibility(job.scene, occluders=job.occluders, tolerance=tolerance)
            seen_by(known)
            for _ in range(TURNS):
                again = known.afresh()
                seconds.append(timed(lambda _, again=again: seen_by(again))(0).seconds)
            error = float(np.sqrt(np.mean((seen_by(known) - fixed.truth) ** 2)))
            over = equal_error_seconds(fixed.curve, error) / min(seconds)
            numbers = f"{min(seconds):.3g}", f"{error:.1e}", f"{known.rays / len(job.points):.0f}", f"{over:.2f}"
            made.add_row(name, f"{tolerance:.4f}", *numbers)
    return made


def figure(scenes: dict[str, list[Way]], path: str) -> None:
    """Seconds against error of all ways, a panel for each scene."""
    from matplotlib.figure import Figure

    drawn = Figure(figsize=(12.0, 6.0), layout="constrained", facecolor="white")
    styles = dict(zip((way.name for way in next(iter(scenes.values()))), STYLES, strict=True))
    panels, handles = drawn.subplots(1, len(scenes), sharey=True), {}
    for panel, (name, ways) in zip(panels, scenes.items(), strict=True):
        for way in ways:
            if not way.obstacle:
                color, marker = styles[way.name]
                is_first = way is ways[0]
                looks = {
                    "linewidth": 3.0 if is_first else 1.6,
                    "markersize": 8 if is_first else 6,
                    "zorder": 3 if is_first else 2,
                }
                (handles[way.name],) = panel.loglog(*zip(*way.curve, strict=True), marker, color=color, ls="-", **looks)
        panel.set_title(f"{name}, {len(ways[0].job.points):,} vertices", fontsize=13)
        panel.set_xlabel("processor seconds, two threads together")
        panel.grid(which="major", color="#e4e4e4")
        panel.spines[["top", "right"]].set_visible(False)
        for rays, at in zip(ways[0].rays, ways[0].curve if not ways[0].obstacle else (), strict=False):
            color = styles[ways[0].name][0]
            panel.annotate(f"{rays} rays", at, (9, 3), textcoords="offset points", color=color, fontsize=9)
    panels[0].set_ylabel("RMS error of the part that is seen")
    drawn.legend(handles.values(), handles, loc="outside lower center", ncols=4, frameon=False)
    drawn.savefig(path, dpi=100)


# --- hard shadows, and a light that moves


def hard_shadows(count: int) -> str:
    """Three lights, with all that is built for them, beside embreex's calls alone."""
    side, taken, alone = round(count**0.5), [], []
    mesh = pv.ParametricTorus(u_res=side, v_res=side).triangulate()
    mesh.point_data.active_normals = ph.vertex_normals(mesh)
    for _ in range(TURNS):
        seen = mesh.phong.visibility(LIGHTS)
        start = time.perf_counter()
        seen.per_light  # noqa: B018  rays are cast when it is first read
        taken.append(time.perf_counter() - start)
        with suppress(ImportError):
            alone.append(sum(peers.embreex_alone(mesh, LIGHTS).values()))
    told = (
        f"Three hard lights, {mesh.n_points:,} vertices, {mesh.n_cells:,} triangles, building too: {min(taken):.2f} s"
    )
    return f"{told}; embreex's calls alone {min(alone):.2f} s" if alone else f"{told}; embreex is missing"


def drags(count: int) -> str:
    """Updates of a window's colours while a light moves: its rays, and lighting with what they find."""
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


def main() -> None:
    parser = ArgumentParser()
    parser.add_argument("vertices", nargs="?", default=100_000, type=int)
    parser.add_argument("--figure", help="where curves are drawn")
    parser.add_argument("--blender", help="a Python that imports bpy")
    given = parser.parse_args()
    begin_on(peers.THREADS)
    CONSOLE.print(hard_shadows(10 * given.vertices))
    CONSOLE.print(drags(given.vertices))
    scenes = {}
    for name, make, count in (("A penumbra", penumbra, given.vertices), ("The sky", open_sky, given.vertices // 2)):
        ways = scenes[name] = measured(make, count, given.blender)
        CONSOLE.print(error_table(f"{name}, {len(ways[0].job.points):,} vertices: processor seconds, RMS error", ways))
    CONSOLE.print(adaptive_table(scenes))
    if given.figure:
        figure(scenes, given.figure)


if __name__ == "__main__":
    main()
