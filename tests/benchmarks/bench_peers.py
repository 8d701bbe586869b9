"""Lit vertices, by pvphong and by what one would take instead: time against error, for seven jobs and three sizes.

    python tests/benchmarks/bench_peers.py [--vertices 10000 100000 1000000] [--figure FILE] [--blender PYTHON]

Time is that of processors, two threads together. Preparation (trees, textures, compiling what a scene needs) stands
apart. Errors are RMS over the vertices of the smallest size, as a share of the mean: how far rays are off does not
depend on how many vertices there are. Judges are `mesh.phong.truth`, our own visibility with many and other rays, and
float64 where no rays are needed. Those who place the same vertices a little elsewhere (Mitsuba, which needs a point
within a face, Blender, libigl) are judged by a truth of their own, with many rays, and left out if that is another
picture than ours. Ways that take long are measured on fewer vertices, and their times multiplied.

Others are compared if they are there: `pip install mitsuba libigl`, Mitsuba with LLVM's library; and with `--blender`
a Python that has `pip install bpy`. Those that are missing, crash, or draw black are named.
"""

import platform
import subprocess
import time
from argparse import ArgumentParser
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache, partial
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
import pyvista as pv
from rich.console import Console

import pvphong as ph
from pvphong.vtk.oracle import vtk_shade

try:
    from benchmarks import bench_transport, bench_visibility, ray_peers, scene_peers
    from benchmarks.common import Caster, begin_on, equal_error_seconds, table, textbook, timed
except ImportError:
    import bench_transport
    import bench_visibility
    import ray_peers
    import scene_peers
    from common import Caster, begin_on, equal_error_seconds, table, textbook, timed

SIZES, TURNS, QUICK, VERY_QUICK, TIMES_A_TURN = (10_000, 100_000, 1_000_000), 5, 3.0, 0.1, 10
"""Ways that take less than `QUICK` seconds have so many turns more, one after the other, so that a busy machine slows
all of them down; below `VERY_QUICK` they run so many times in each. The least counts."""
OURS, MITSUBA, BLENDER, LIBIGL = "pvphong", "Mitsuba 3", "Blender's bake", "libigl"
TEXTBOOK, SHADER = "textbook, NumPy", "VTK's shader"
LEAST_ERROR, WANTED = 1e-8, 1e-3
"""Errors below the first count as it; times are compared at ours, or at the second where that is larger."""
ALIKE = 0.05
"""A truth of another's own that is farther from ours, relative to the mean, is another picture."""
STYLES = {OURS: ("#1b6ca8", "o"), MITSUBA: ("#c2571a", "s"), BLENDER: ("#6b4c9a", "D"), LIBIGL: ("#2a7f3f", "^")}
STYLES |= {TEXTBOOK: ("#8a8a8a", "v"), SHADER: ("#c9a227", "P")}
CONSOLE = Console(width=180)


@dataclass
class Way:
    """One way to do a job.

    Parameters
    ----------
    prepare : callable
        Of a job, what casts so many rays and gives seconds and an array.
    rays : tuple of int
        Numbers of rays that are measured; one number where none are needed.
    most : int
        On more vertices it is not measured.
    own_truth : int
        So many rays judge it; 0 for the judge of the job.
    """

    name: str
    prepare: Callable[[Any], Caster]
    rays: tuple[int, ...] = (1,)
    most: int = 10**9
    own_truth: int = 0
    obstacle: str = ""
    preparing: float = 0.0
    seconds: dict[int, list[float]] = field(default_factory=dict)
    errors: list[float] = field(default_factory=list)

    def curve(self, size: int) -> list[tuple[float, float]]:
        return list(zip(self.seconds[size], self.errors, strict=True))

    def seconds_to(self, error: float, size: int) -> float:
        """Infinite if no number of rays gets there."""
        curve = self.curve(size)
        if len(curve) == 1 or curve[0][1] <= error:
            return curve[0][0] if curve[0][1] <= error else np.inf
        return equal_error_seconds(curve, error)


@dataclass
class Row:
    """One job, at any size, and its ways; the first is ours."""

    name: str
    make: Callable[[int], Any]
    judge: Callable[[Any], np.ndarray]
    ways: list[Way]
    judged_at: int = 0
    """Which of our numbers of rays says at what error times are compared."""

    @property
    def error(self) -> float:
        return max(self.ways[0].errors[self.judged_at], WANTED)

    def measure(self, sizes: tuple[int, ...]) -> None:
        jobs, truth = cache(self.make), cache(lambda size: self.judge(self.make(size)))
        for size in sizes:
            again = list[Callable[[], None]]()
            for way in self.ways:
                if not way.obstacle:
                    try:
                        most = min(size, way.most)
                        again.append(self._measure(way, size, jobs(most), partial(truth, most)))
                    except NotImplementedError as reason:
                        way.obstacle = str(reason)
                    except (ImportError, OSError, RuntimeError, subprocess.SubprocessError) as reason:
                        way.obstacle = f"missing: {str(reason).splitlines()[0][:70]}"
            for _ in range(TURNS):
                for run in again:
                    run()

    def _measure(self, way: Way, size: int, job: Any, truth: Callable[[], np.ndarray]) -> Callable[[], None]:
        """Measure it once; what measures it again is given."""
        share = min(way.most / size, 1.0)
        known = next(((before, times) for before, times in way.seconds.items() if before >= way.most), None)
        if known:
            way.seconds[size] = [taken * size / known[0] for taken in known[1]]
            return lambda: None
        start = time.process_time()
        cast = way.prepare(job)
        way.preparing = time.process_time() - start
        if not way.errors:
            cast(way.rays[0])  # compiles
        first = [cast(rays) for rays in way.rays]
        if not way.errors:
            way.errors = _errors([found for _, found in first], way, cast, truth())
        way.seconds[size] = [seconds / share for seconds, _ in first]
        taken = sum(seconds for seconds, _ in first)
        times = 0 if taken > QUICK else TIMES_A_TURN if taken < VERY_QUICK else 1

        def again() -> None:
            for _ in range(times):
                least = zip(way.seconds[size], way.rays, strict=True)
                way.seconds[size] = [min(before, cast(rays)[0] / share) for before, rays in least]

        return again


def _errors(found: list[np.ndarray], way: Way, cast: Caster, truth: np.ndarray) -> list[float]:
    """Relative RMS errors."""
    if way.own_truth:
        own = cast(way.own_truth)[1]
        if not own.any():
            raise NotImplementedError("draws black")
        if way.name != LIBIGL:  # which weights all directions alike
            off = float(np.sqrt(np.square(own - truth).mean()) / truth.mean())
            if off > ALIKE:
                raise NotImplementedError(f"draws another picture: {off:.0%} off")
        truth = own
    return [max(float(np.sqrt(np.square(one - truth).mean()) / truth.mean()), LEAST_ERROR) for one in found]


# --- jobs


EYE = (2.0, -3.0, 1.5)


def ball(size: int, lights: list[ph.Light], material: ph.Material, *, is_cap: bool = False) -> scene_peers.Job:
    """Nothing that is convex blocks its own light: who can do without rays does. Of a cap the eye sees every vertex."""
    side = max(round(size**0.5), 4)
    angles = {"theta_resolution": side, "phi_resolution": side, "end_phi": 60.0 if is_cap else 180.0}
    mesh = pv.Sphere(radius=1.0, direction=EYE, **angles)
    mesh.point_data.active_normals = np.array(mesh.points / np.linalg.norm(mesh.points, axis=1)[:, None])
    model = ph.LightModel(ambient=0.0, clamp=False)
    scene = ph.Scene(lights, ph.Viewer(EYE, (0, 0, 0), (0, 0, 1)), model)
    return scene_peers.Job(pv.MultiBlock({"ball": mesh}), scene, {"ball": material})


def lamps(count: int) -> list[ph.Light]:
    """Evenly around, as far away as three radii; together as bright for all numbers."""
    number = np.arange(count) + 0.5
    height, turn = 1.0 - 2.0 * number / count, np.pi * (1.0 + 5.0**0.5) * number
    around = np.sqrt(1.0 - height**2)
    places = 3.0 * np.column_stack([around * np.cos(turn), around * np.sin(turn), height])
    return [ph.PointLight(tuple(place), (0, 0, 1), intensity=40.0 / count) for place in places.tolist()]


def sky_image() -> np.ndarray:
    """A smooth sky with a bright spot."""
    rows, columns = np.meshgrid(np.linspace(0, 1, 64), np.linspace(0, 1, 128), indexing="ij")
    spot = np.exp(-((rows - 0.3) ** 2 + (columns - 0.4) ** 2) / 0.01)
    return 0.3 + 0.4 * rows[..., None] * np.array([0.4, 0.6, 1.0]) + 6.0 * spot[..., None] * np.array([1.0, 0.9, 0.7])


def shade(job: scene_peers.Job) -> Caster:
    """The whole call; `precision` is float32, its default."""

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
    """Drawn in software where there is no graphics card, and read back."""
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
    """The judge is paths of light: what `shade` looks up for a lobe under a sky of many colours is no integral."""
    mirror = ph.Material(ambient=0.0, diffuse=0.0, specular=0.0, reflectance=ph.GGX(0.4, (1.0, 1.0, 1.0)))
    ways = [
        Way(OURS, shade),
        Way(MITSUBA, scene_peers.mitsuba, (16, 64, 256), 100_000, own_truth=4096),
        Way(BLENDER, blender),
    ]
    sky = [ph.EnvironmentLight(sky_image())]
    return Row("A mirror of GGX under a sky", lambda size: ball(size, sky, mirror, is_cap=True), _by_paths, ways)


def _by_paths(job: scene_peers.Job) -> np.ndarray:
    return bench_transport.judged(job, 4096)[0]


def bouncing(name: str, bounces: int, blender: Callable) -> Row:
    def make(size: int) -> scene_peers.Job:
        return bench_transport.room(max(round((size / 6.1) ** 0.5) - 1, 2), bounces)

    ways = [
        Way(OURS, bench_transport.ours, (16, 64, 256), 100_000),
        Way(MITSUBA, scene_peers.mitsuba, (16, 64, 256), 10_000, own_truth=2048),
        Way(BLENDER, blender, (16, 64), 1200, own_truth=1024),
    ]
    return Row(name, make, lambda job: bench_transport.judged(job, 1024)[0], ways, judged_at=1)


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
        bouncing("One bounce", 1, bake),
        bouncing("All bounces", scene_peers.ALL_BOUNCES, bake),
        glossy(bake),
    ]


# --- what is told


def shown(rows: list[Row], sizes: tuple[int, ...]):
    """A star marks times that are multiplied from those of fewer vertices."""
    headings = "job", "by", "error, by rays", *(f"{size:,} vertices, s" for size in sizes), "times ours", "prepared, s"
    made = table("At equal error, processor seconds", *headings, texts=3)
    for row in rows:
        for way in row.ways:
            job = f"{row.name}, to {row.error:.1e}" if way is row.ways[0] else ""
            if way.obstacle:
                made.add_row(job, way.name, way.obstacle)
                continue
            errors = ", ".join(f"{rays}: {error:.0e}" for rays, error in zip(way.rays, way.errors, strict=True))
            taken = {size: way.seconds_to(row.error, size) for size in sizes}
            times = [taken[size] / row.ways[0].seconds_to(row.error, size) for size in sizes]
            cells = [
                f"{seconds:.3g}{'' if size <= way.most else ' *'}" if np.isfinite(seconds) else "never"
                for size, seconds in taken.items()
            ]
            ratio = " / ".join(f"{each:.3g}" if 0.0 < each < np.inf else "-" for each in times)
            made.add_row(job, way.name, errors, *cells, ratio, f"{way.preparing:.2g}")
        made.add_section()
    return made


def figure(rows: list[Row], size: int, path: str) -> None:
    """Seconds against error, a panel for each job; marks alone are ways that need no rays."""
    from matplotlib.figure import Figure

    drawn = Figure(figsize=(13.0, 6.6), layout="constrained", facecolor="white")
    panels, handles = drawn.subplots(2, 4).ravel(), {}
    for panel, row in zip(panels, rows, strict=False):
        for way in row.ways:
            if way.obstacle:
                continue
            color, marker = STYLES[way.name]
            looks = {"color": color, "marker": marker, "linewidth": 2.6 if way.name == OURS else 1.6}
            (handles[way.name],) = panel.loglog(*zip(*way.curve(size), strict=True), **looks)
        panel.axhline(row.error, color="#999999", linewidth=0.8, linestyle=":")
        panel.set_title(row.name, fontsize=12)
        panel.grid(which="major", color="#e4e4e4")
        panel.spines[["top", "right"]].set_visible(False)
    for panel in panels[4:]:
        panel.set_xlabel("processor seconds")
    for panel in panels[::4]:
        panel.set_ylabel("relative RMS error")
    panels[-1].set_axis_off()
    panels[-1].legend(handles.values(), handles, loc="center", frameon=False, title=f"{size:,} vertices, two threads")
    drawn.savefig(path, dpi=100)


def machine() -> str:
    def of(name: str) -> str:
        with suppress(PackageNotFoundError):
            return f"{name} {version(name)}"
        return f"no {name}"

    names = "numpy", "pyvista", "vtk", "numba", "embreex", "mitsuba", "libigl"
    return (
        f"{platform.processor() or platform.machine()}, Python {platform.python_version()}, {', '.join(map(of, names))}"
    )


def main() -> None:
    parser = ArgumentParser()
    parser.add_argument("--vertices", nargs="+", type=int, default=SIZES)
    parser.add_argument("--figure", help="where curves are drawn")
    parser.add_argument("--blender", help="a Python that imports bpy")
    given = parser.parse_args()
    begin_on(scene_peers.THREADS)
    CONSOLE.print(machine())
    rows, sizes = rows_of(given.blender), tuple(sorted(given.vertices))
    for row in rows:
        row.measure(sizes)
        CONSOLE.print(shown([row], sizes))
    if given.figure:
        figure(rows, sizes[min(1, len(sizes) - 1)], given.figure)


if __name__ == "__main__":
    main()
