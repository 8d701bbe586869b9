"""Daylight coefficients of a city's ground for the same error, by pvphong and by Radiance's rfluxmtx; and a whole year.

    python tests/benchmarks/bench_daylight.py [vertices] [points]

The scene is a square with 100 boxes. Both programs compute the visible part of Tregenza's 145 patches; rfluxmtx at
`points` of the vertices, because it is slower. The error is that of the visible sky, relative to 64 of our rays to each
patch, in per cent of the open sky, at vertices outside of the boxes. Times are processor seconds of all threads for
100,000 vertices. Last, all rays of a year of hours for all vertices, and the light of another weather.
"""

import resource
import subprocess
import tempfile
import time
from pathlib import Path

import cyclopts
import numpy as np
import pandas as pd
import pyradiance
import pyvista as pv
from common import CONSOLE, THREADS, grid, show

import pvphong as ph

MUNICH, NIGHT = ph.Place(48.14, 11.58), "2026-06-21T00:30+02:00"
YEAR = pd.date_range("2026-01-01T00:30", "2026-12-31T23:30", freq="h", tz="Etc/GMT-1")
SAMPLES, TRUTH, RAYS = (2, 4, 8), 64, (64, 256, 1024, 4096)
PER = 100_000  # vertices


def boxes():
    """Yield 100 boxes on a square of a kilometre."""
    random = np.random.default_rng(1)
    for x in np.linspace(-450, 450, 10):
        for y in np.linspace(-450, 450, 10):
            w, d = random.uniform(15, 30, 2)
            yield pv.Box((x - w, x + w, y - d, y + d, 0, random.uniform(20, 100))).triangulate()


def sky_by_us(ground, occluders, samples):
    """Return the visible sky at vertices, from 0 to 1, and processor seconds; the trees are built before."""
    light = ground.phong.daylight(NIGHT, MUNICH, ([0.0], [1.0]), occluders=occluders, samples=samples)
    tracer = light._study.cast.tracer
    tracer.receiver.origins, tracer.occluders.casters  # noqa: B018
    start = time.process_time()
    kept = light._study.cast.coefficients
    seconds = time.process_time() - start
    patches = light._study.patches
    return kept.sky @ patches.moments[:, 2] / (255.0 * np.pi), seconds


def sky_by_rfluxmtx(points, triangles, rays):
    """Return the visible sky at points that face up, and processor seconds of the processes."""
    programs = Path(pyradiance.BINPATH)
    with tempfile.TemporaryDirectory() as folder:
        text = "void plastic black\n0\n0\n5 0 0 0 0 0\n"
        for number, corners in enumerate(triangles):
            text += f"black polygon p{number}\n0\n0\n9 {' '.join(f'{x:.9g}' for x in corners.ravel())}\n"
        (Path(folder) / "city.rad").write_text(text)
        glow = "#@rfluxmtx h={0} u=Y\nvoid glow g{1}\n0\n0\n4 1 1 1 0\ng{1} source s{1}\n0\n0\n4 0 0 {2} 180\n"
        (Path(folder) / "sky.rad").write_text(glow.format("u", 1, -1) + glow.format("r1", 2, 1))
        given = "\n".join(f"{x:.9g} {y:.9g} {z + 1e-3:.9g} 0 0 1" for x, y, z in points)
        options = ["-h", "-I+", "-ab", "1", "-ad", str(rays), "-lw", "1e-9", "-n", str(THREADS), "-y", str(len(points))]
        command = [programs / "rfluxmtx", *options, "-", "sky.rad", "city.rad"]
        paths = {"PATH": f"{programs}:/usr/bin:/bin", "RAYPATH": f".:{programs.parent / 'lib'}"}
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        found = subprocess.run(command, input=given, text=True, cwd=folder, env=paths, capture_output=True, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    numbers = np.array(found.stdout.split(), float).reshape(len(points), -1, 3)[:, 1:, 0]  # without the ground
    return numbers.sum(axis=1) / np.pi, seconds


def main(vertices: int = PER, points: int = 2000):
    ground, occluders = grid(round(vertices**0.5) - 1, 1000.0), list(boxes())
    truth, _ = sky_by_us(ground, occluders, TRUTH)
    outside = np.flatnonzero(truth > 0.02)
    rows, ours = [], []
    for samples in SAMPLES:
        found, seconds = sky_by_us(ground, occluders, samples)
        error = 100.0 * np.sqrt(np.mean((found - truth)[outside] ** 2))
        ours.append((error, seconds * PER / ground.n_points))
        rows.append(("pvphong", f"{145 * samples}", f"{error:.2f} %", f"{ours[-1][1]:.2f}"))
    some = outside[np.linspace(0, len(outside) - 1, points).astype(int)]
    triangles = np.concatenate([each.points[each.regular_faces] for each in (grid(1, 1000.0), *occluders)])
    theirs = []
    for rays in RAYS:
        found, seconds = sky_by_rfluxmtx(ground.points[some], triangles, rays)
        error = 100.0 * np.sqrt(np.mean((found - truth[some]) ** 2))
        theirs.append((error, seconds * PER / points))
        rows.append(("rfluxmtx", f"{rays}", f"{error:.2f} %", f"{theirs[-1][1]:.1f}"))
    show("Visible sky", ("program", "rays per vertex", "error, rms", f"CPU s per {PER:,} vertices"), rows)
    for error, seconds in ours:
        errors, times = np.log(theirs).T
        if errors.min() <= np.log(error) <= errors.max():
            equal = np.exp(np.interp(-np.log(error), -errors, times))
            CONSOLE.print(f"at {error:.2f} % rfluxmtx takes {equal:.0f} s, {equal / seconds:.0f} times as long")
    light = ground.phong.daylight(YEAR, MUNICH, occluders=occluders)
    wall, start = time.perf_counter(), time.process_time()
    kept = light._study.cast.coefficients
    used, wall = time.process_time() - start, time.perf_counter() - wall
    CONSOLE.print(f"a year: {kept.rays:.3g} rays in {wall:.1f} s, {used:.1f} processor seconds")
    wall = time.perf_counter()
    light.with_weather((np.full(len(YEAR), 500.0), np.full(len(YEAR), 100.0))).total  # noqa: B018
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    CONSOLE.print(f"another weather: {time.perf_counter() - wall:.2f} s; at most {peak:.2f} GiB of memory")


if __name__ == "__main__":
    cyclopts.run(main)
