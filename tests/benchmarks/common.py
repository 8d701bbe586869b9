"""Shared code of benchmarks: scenes, meshes, the textbook's formula, timing of calls in turns, and tables.

Calls take turns, so that a busy machine slows all of them down alike.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyvista as pv
from rich.console import Console
from rich.table import Table

from pvphong import Material, PointLight, Scene, Viewer
from pvphong.shading import kernel
from pvphong.studies.accuracy.peers import textbook_colors as textbook  # noqa: F401 for benchmarks

THREADS = 2  # of all compared programs
CONSOLE = Console(width=180)

# --- scenes and meshes


def measured_scene():
    """Return a scene and a material: three point lights with highlights and attenuation around the unit sphere."""
    lights = [
        PointLight(position=(2.0, 1.0, 2.5), attenuation=(0.5, 0.1, 0.05), diffuse=(1.0, 0.9, 0.8)),
        PointLight(position=(-2.0, 1.5, 1.0), attenuation=(1.0, 0.0, 0.1), diffuse=(0.3, 0.4, 0.9), intensity=1.5),
        PointLight(position=(0.5, -2.0, 2.0), attenuation=(0.2, 0.3, 0.1), specular=(1.0, 0.5, 0.2)),
    ]
    material = Material(ambient=0.1, diffuse=(0.6, 0.5, 0.4), specular=0.5, shininess=30, emission=0.01)
    return Scene(lights=lights, viewer=Viewer(position=(1.0, 0.5, 4.0))), material


def vertices(count, dtype=np.float64):
    """Return points on the unit sphere and perturbed normals."""
    rng = np.random.default_rng(0)
    points = rng.normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    normals = points + 0.1 * rng.normal(size=(count, 3))
    return points.astype(dtype), normals.astype(dtype)


def grid(cells, size=1.0, center=(0, 0, 0), direction=(0, 0, 1)):
    """Return a square of `cells` by `cells` cells, cut into triangles, with normals."""
    extent = {"i_size": size, "j_size": size, "i_resolution": cells, "j_resolution": cells}
    mesh = pv.Plane(center=center, direction=direction, **extent).triangulate()
    mesh.clear_data()
    mesh.point_data.active_normals = np.tile(np.float32(direction), (mesh.n_points, 1))
    return mesh


def torus(side):
    """Return a closed torus of `side` by `side` points, without normals."""
    mesh = pv.ParametricTorus(u_res=side, v_res=side).clean().triangulate()
    mesh.clear_data()
    return mesh


# --- measuring


def in_turns(calls, repeats, clock=time.perf_counter, of=min):
    """Return seconds of calls by name, the least or another statistic of all repeats; a first turn only compiles."""
    seconds = {name: [] for name in calls}
    for turn in range(repeats + 1):
        for name, call in calls.items():
            start = clock()
            call()
            if turn:
                seconds[name].append(clock() - start)
    return {name: of(times) for name, times in seconds.items()}


class Cast(NamedTuple):
    """Result of rays, and their time."""

    seconds: float  # processor time, summed over threads
    found: np.ndarray


Caster = Callable[[int], Cast]
"""Function that casts a number of rays per vertex."""


def timed(work: Callable[[int], np.ndarray]) -> Caster:
    """Return a caster that times the whole call."""

    def cast(rays: int) -> Cast:
        start = time.process_time()
        found = work(rays)
        return Cast(time.process_time() - start, found)

    return cast


def by_parts(at_once: int, count: int, of_some: Callable[[int, int, int], np.ndarray]) -> Caster:
    """Return a caster from a function of rays per vertex and a range of vertices, with `at_once` rays per call."""

    def work(rays: int) -> np.ndarray:
        step = max(at_once // rays, 1)
        return np.concatenate([of_some(rays, at, min(at + step, count)) for at in range(0, count, step)])

    return timed(work)


def baked(python, meshes, looking, **data) -> Caster:
    """Return a caster that runs Blender in a separate process; see `blender_bake.py` for its data."""
    if python is None:
        raise FileNotFoundError("no Python with bpy was named")
    subprocess.run([python, "-c", "import bpy"], check=True, capture_output=True)
    for number, mesh in enumerate(meshes):
        data |= {f"points{number}": np.array(mesh.points), f"corners{number}": np.array(mesh.regular_faces)}
    data |= {"count": len(meshes), "looking": looking}

    def cast(rays: int) -> Cast:
        with tempfile.TemporaryDirectory() as folder:
            given, result = Path(folder) / "given.npz", Path(folder) / "result.npz"
            np.savez(given, **data)
            script = Path(__file__).with_name("blender_bake.py")
            subprocess.run([python, script, given, result, str(rays), str(THREADS)], check=True, capture_output=True)
            with np.load(result) as found:
                return Cast(float(found["seconds"]), found["seen"])

    return cast


def begin_on(threads):
    """Restrict this process to a number of processors, and compile all code."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:threads])
    with suppress(kernel.CannotCompile):
        kernel.compile_all(lambda *_: None)


def slope(numbers, errors):
    """Return the exponent of errors as a power of numbers: -0.5 for plain random samples."""
    return float(np.polyfit(np.log(numbers), np.log(errors), 1)[0])


def equal_error_seconds(curve, error):
    """Return the seconds to reach an error, from pairs of both: linear on logarithmic axes, or extrapolated."""
    logs = np.log(curve)
    after = int(np.clip(np.count_nonzero(logs[:, 1] > np.log(error)), 1, len(logs) - 1))
    (start, above), (end, below) = logs[after - 1], logs[after]
    return float(np.exp(start + (np.log(error) - above) * (end - start) / (below - above)))


def apart(code, **environment):
    """Return the output of code in a separate process that can import benchmarks."""
    run = [sys.executable, "-c", code]
    return subprocess.check_output(run, env=os.environ | environment, cwd=Path(__file__).parent, text=True)


def alone(function, *arguments):
    """Return the result of a function in a separate process."""
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


# --- many files


def new_cluster(workers):
    """Start a cluster of workers with one thread, as `shade_files` does."""
    from distributed import LocalCluster

    single = {"threads_per_worker": 1, "env": {"VTK_SMP_MAX_THREADS": "1"}}
    return LocalCluster(n_workers=workers, dashboard_address=":0", **single)


def files_lit(cluster, files, out, *lighting, **options):
    """Return the seconds of a run without earlier results, and the largest memory of a worker in bytes."""
    from distributed import Client

    from pvphong import shade_files

    with Client(cluster) as client:
        before = client.run(reset_peak)
        start = time.perf_counter()
        batch = shade_files(files, out, *lighting, client=client, backend="numba", **options)
        seconds = time.perf_counter() - start
        assert len(batch.done) == len(files), batch
        return seconds, max(most - before[worker] for worker, most in client.run(peak).items())


def reset_peak():
    """Reset the peak memory of a worker, and return its current memory."""
    import psutil

    Path("/proc/self/clear_refs").write_text("5")
    return psutil.Process().memory_info().rss


def peak():
    """Return the peak memory of a worker."""
    status = Path("/proc/self/status").read_text()
    return 1024 * int(status.split("VmHWM:")[1].split()[0])


# --- printing


def show(title, headings, rows, texts=1):
    """Print a table. The first `texts` columns hold text, the others numbers; rows without cells are separators."""
    made = Table(title=title, title_justify="left")
    for place, heading in enumerate(headings):
        made.add_column(heading, justify="right" if place >= texts else "left")
    for row in rows:
        if row:
            made.add_row(*row)
        else:
            made.add_section()
    CONSOLE.print(made)


def mark(holds):
    """Return a table cell with "yes" or "no"."""
    return "[green]yes[/]" if holds else "[red]no[/]"
