"""Ways to do one job, by time against error, for bench_peers, bench_transport and bench_visibility.

Times are processor times, summed over two threads. Preparation (trees, textures, compilation for a scene) is separate.
Errors are RMS, relative to the truth's mean. Slow ways are measured on fewer vertices, and their times are
extrapolated; a star marks them.

Other programs are optional: `pip install mitsuba libigl`, with LLVM's library for Mitsuba; and `--blender` with a
Python that has `pip install bpy`. The table names programs that are missing, crash, or render black.
"""

import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any

import numpy as np
from common import Caster, equal_error_seconds, show, slope

TURNS, QUICK, VERY_QUICK, TIMES_A_TURN = 5, 3.0, 0.1, 10
"""Ways faster than `QUICK` seconds take `TURNS` more turns, so that a busy machine slows all of them down. Ways faster
than `VERY_QUICK` run `TIMES_A_TURN` times in each. The least time counts."""
OURS, MITSUBA, BLENDER, LIBIGL = "pvphong", "Mitsuba 3", "Blender's bake", "libigl"
LEAST_ERROR, WANTED = 1e-8, 1e-3
"""Lower bound on errors; and lower bound on our error, at which times are compared."""
ALIKE = 0.05  # largest relative difference between a program's own truth and ours


@dataclass
class Way:
    """One way to do a job."""

    name: str
    prepare: Callable[[Any], Caster]  # function of a job
    rays: tuple[int, ...] = (1,)  # measured numbers of rays; one if no rays are needed
    most: int = 10**9  # largest number of vertices that is measured
    step: int = 1  # step between vertices with rays, by the job's `some`
    own_truth: int = 0  # number of rays of its own truth; 0 for the job's truth
    obstacle: str = ""
    preparing: float = 0.0
    seconds: dict[int, list[float]] = field(default_factory=dict)
    errors: list[float] = field(default_factory=list)

    def curve(self, size: int) -> list[tuple[float, float]]:
        return list(zip(self.seconds[size], self.errors, strict=True))

    def seconds_to(self, error: float, size: int) -> float:
        """Return the seconds to reach an error; infinite if no number of rays reaches it."""
        curve = self.curve(size)
        if len(curve) == 1 or curve[0][1] <= error:
            return curve[0][0] if curve[0][1] <= error else np.inf
        return equal_error_seconds(curve, error)


@dataclass
class Row:
    """One job, at any size, and its ways; the first is pvphong."""

    name: str
    make: Callable[[int], Any]
    judge: Callable[[Any], np.ndarray]
    ways: list[Way]
    judged_at: int = 0  # index of our number of rays at whose error times are compared
    wanted: float = WANTED

    @property
    def first(self) -> Way:
        """First way that is available."""
        return next(way for way in self.ways if not way.obstacle)

    @property
    def error(self) -> float:
        return max(self.first.errors[self.judged_at], self.wanted)

    def measure(self, sizes: Sequence[int]) -> None:
        jobs, truth = cache(self.make), cache(lambda size: self.judge(self.make(size)))
        for size in sizes:
            again = list[Callable[[], None]]()
            for way in self.ways:
                if not way.obstacle:
                    try:
                        most = min(size, way.most)
                        job = jobs(most) if way.step == 1 else jobs(most).some(way.step)
                        again.append(self._measure(way, size, job, partial(truth, most)))
                    except NotImplementedError as reason:
                        way.obstacle = str(reason)
                    except (ImportError, OSError, RuntimeError, subprocess.SubprocessError) as reason:
                        way.obstacle = f"missing: {str(reason).splitlines()[0][:70]}"
            for _ in range(TURNS):
                for run in again:
                    run()

    def _measure(self, way: Way, size: int, job: Any, truth: Callable[[], np.ndarray]) -> Callable[[], None]:
        """Measure a way once; return a function that measures it again."""
        share = min(way.most / size, 1.0) / way.step
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
            way.errors = _errors([found for _, found in first], way, cast, truth()[:: way.step])
        way.seconds[size] = [seconds / share for seconds, _ in first]
        taken = sum(seconds for seconds, _ in first)
        times = 0 if taken > QUICK else TIMES_A_TURN if taken < VERY_QUICK else 1

        def again() -> None:
            for _ in range(times):
                least = zip(way.seconds[size], way.rays, strict=True)
                way.seconds[size] = [min(before, cast(rays)[0] / share) for before, rays in least]

        return again


def _errors(found: list[np.ndarray], way: Way, cast: Caster, truth: np.ndarray) -> list[float]:
    if way.own_truth:
        own = cast(way.own_truth)[1]
        if not own.any():
            raise NotImplementedError("renders black")
        if way.name != LIBIGL:  # which weights directions uniformly
            off = relative(own, truth)
            if off > ALIKE:
                raise NotImplementedError(f"renders another picture: {off:.0%} off")
        truth = own
    return [max(relative(one, truth), LEAST_ERROR) for one in found]


def relative(found: np.ndarray, truth: np.ndarray) -> float:
    """Return the RMS error, relative to the truth's mean."""
    return float(np.sqrt(np.square(found - truth).mean()) / truth.mean())


def cells(row: Row, sizes: Sequence[int]) -> Iterator[list[str]]:
    """Yield the table rows of a job; slopes are exponents of the errors by rays."""
    for way in row.ways:
        job = f"{row.name}, to {row.error:.1e}" if way is row.ways[0] else ""
        if way.obstacle:
            yield [job, way.name, way.obstacle]
            continue
        errors = ", ".join(f"{rays}: {error:.0e}" for rays, error in zip(way.rays, way.errors, strict=True))
        falls = f"{slope(way.rays, way.errors):.2f}" if len(way.rays) > 1 else ""
        seconds, ratios = [], []
        for size in sizes:
            taken = way.seconds_to(row.error, size)
            over = taken / row.first.seconds_to(row.error, size)
            star = "" if size <= way.most and way.step == 1 else " *"
            seconds.append(f"{taken:.3g}{star}" if np.isfinite(taken) else "never")
            ratios.append(f"{over:.3g}" if 0.0 < taken < np.inf else "-")
        yield [job, way.name, errors, falls, *seconds, " / ".join(ratios), f"{way.preparing:.2g}"]


def show_row(row: Row, sizes: Sequence[int]) -> None:
    at_sizes = [f"{size:,} vertices, s" for size in sizes]
    headings = ["job", "by", "error, by rays", "slope", *at_sizes, "times the first", "prepared, s"]
    show("At equal error, processor seconds", headings, cells(row, sizes), texts=3)


def draw(rows: Sequence[Row], sizes: Sequence[int], path: str, styles: dict[str, tuple[str, str]]) -> None:
    """Draw seconds against error, with a panel for each job; ways without rays are single marks."""
    from matplotlib.figure import Figure

    down, across = (1, len(rows) + 1) if len(rows) < 4 else (2, len(rows) // 2 + 1)
    drawn = Figure(figsize=(1.0 + 3.1 * across, 3.3 * down + 1.0), layout="constrained", facecolor="white")
    panels, handles = drawn.subplots(down, across, squeeze=False), {}
    for panel, row, size in zip(panels.ravel(), rows, sizes, strict=False):
        for way in row.ways:
            if way.obstacle:
                continue
            color, marker = styles[way.name]
            looks = {"color": color, "marker": marker, "linewidth": 2.6 if way is row.first else 1.6}
            (handles[way.name],) = panel.loglog(*zip(*way.curve(size), strict=True), **looks)
        panel.axhline(row.error, color="#999999", linewidth=0.8, linestyle=":")
        panel.set_title(f"{row.name}, {size:,} vertices", fontsize=12)
        panel.grid(which="major", color="#e4e4e4")
        panel.spines[["top", "right"]].set_visible(False)
    for panel in panels[-1]:
        panel.set_xlabel("processor seconds")
    for panel in panels[:, 0]:
        panel.set_ylabel("relative RMS error")
    panels[-1, -1].set_axis_off()
    panels[-1, -1].legend(handles.values(), handles, loc="center", frameon=False, title="two threads together")
    drawn.savefig(path, dpi=100)
