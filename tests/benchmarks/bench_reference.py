"""How fast the reference evaluator is, what its stability costs, and what it needs: `python bench_reference.py`.

Variants are measured in turns, so that a busy machine slows all of them down alike; a ratio is given of medians
and of minima. `test_naive_block.py` and the studies' `test_peers.py` show that all compute the same thing.
"""

import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from statistics import median

import numpy as np
from naive_block import naive_highlights
from rich.console import Console
from rich.table import Table
from textbook import measured_scene, shade, vertices

from pvphong.geometry.transform import normal_matrix
from pvphong.shading.evaluation import evaluate

COUNT = 1_000_000
MANY = 10_000_000
REPEATS = 7
IMPORTS = 7

ALLOWED_MEMORY = 64 * 2**20
ALLOWED_IMPORT = 0.050


def interleaved(variants, repeats):
    """Seconds of CPU time of every repeat of every variant, in turns."""
    seconds = {name: [] for name in variants}
    for run in variants.values():
        run()  # warms caches up
    for _ in range(repeats):
        for name, run in variants.items():
            start = time.process_time()
            run()
            seconds[name].append(time.process_time() - start)
    return seconds


def speed_table(title, seconds, base, count):
    """Rows of times; ratios are the base's time over the row's: above 1 is faster than the base."""
    table = Table(title=title)
    for heading in ("variant", "median", "least", "M/s", "× median", "× least"):
        table.add_column(heading, justify="left" if heading == "variant" else "right")
    for name, times in seconds.items():
        middle, least = median(times), min(times)
        table.add_row(
            name,
            f"{middle * 1e3:.1f} ms",
            f"{least * 1e3:.1f} ms",
            f"{count / middle / 1e6:.2f}",
            f"{median(seconds[base]) / middle:.2f}",
            f"{min(seconds[base]) / least:.2f}",
        )
    return table


def measure_speed():
    scene, material = measured_scene()
    points, normals = vertices(COUNT)

    def blocked(precision):
        return evaluate(points, normals, scene, material, precision=precision, backend="numpy")

    def naive(precision):
        with naive_highlights():
            return blocked(precision)

    variants = {
        "textbook, float64": lambda: shade(points, normals, scene, material),
        "evaluate, float64": lambda: blocked("float64"),
        "evaluate, float32": lambda: blocked("float32"),
        "naive highlights, float64": lambda: naive("float64"),
        "naive highlights, float32": lambda: naive("float32"),
    }
    return interleaved(variants, REPEATS)


def measure_memory(precision):
    """Bytes at the peak beside inputs and output, for float32 vertices."""
    scene, material = measured_scene()
    points, normals = (np.resize(a, (MANY, 3)) for a in vertices(COUNT, np.float32))
    tracemalloc.start()
    rgb = evaluate(points, normals, scene, material, precision=precision, backend="numpy").rgb
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak - rgb.nbytes


def measure_normal_matrix():
    """Microseconds per call, for model matrices of several kinds."""
    rng = np.random.default_rng(0)
    turned = np.eye(4)
    turned[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    sheared, wide = turned.copy(), turned.copy()
    sheared[:3, :3] = rng.normal(size=(3, 3))
    wide[:3, :3] = sheared[:3, :3] * [1e-8, 1.0, 1e8]
    result = {}
    for name, matrix in {"identity": np.eye(4), "rotation": turned, "shear": sheared, "1e16 wide": wide}.items():
        times = []
        for _ in range(200):
            start = time.perf_counter()
            normal_matrix(matrix)
            times.append(time.perf_counter() - start)
        result[name] = median(times) * 1e6
    return result


IMPORT = """
import time
import pyvista
start = time.process_time()
import pvphong
print(time.process_time() - start)
"""


def measure_import():
    """Seconds of CPU time that `import pvphong` adds after `import pyvista`, in fresh interpreters.

    The first one compiles to bytecode, as an installer does, and does not count.
    """
    with tempfile.TemporaryDirectory() as bytecode:
        environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": bytecode}
        runs = [
            subprocess.run([sys.executable, "-c", IMPORT], capture_output=True, text=True, check=True, env=environment)
            for _ in range(1 + IMPORTS)
        ]
    return [float(run.stdout) for run in runs[1:]]


def verdict(good):
    return "[green]within[/]" if good else "[red]over[/]"


def main():
    console = Console()
    seconds = measure_speed()
    title = f"{COUNT / 1e6:g} M vertices, 3 point lights with highlights and attenuation, {REPEATS} repeats in turns"
    console.print(speed_table(title, seconds, "textbook, float64", COUNT))
    for precision in ("float64", "float32"):
        stable, naive = (seconds[f"{variant}, {precision}"] for variant in ("evaluate", "naive highlights"))
        cost = f"{median(stable) / median(naive) - 1:+.1%} by medians, {min(stable) / min(naive) - 1:+.1%} by minima"
        console.print(f"the stable highlight costs {cost} of the whole in {precision}")

    table = Table(title="Beside speed")
    for heading in ("what", "measured", "allowed", ""):
        table.add_column(heading)
    for precision in ("float32", "float64"):
        peak = measure_memory(precision)
        what = f"peak memory beside inputs and output, {MANY / 1e6:g} M vertices, {precision}"
        table.add_row(
            what, f"{peak / 2**20:.1f} MiB", f"{ALLOWED_MEMORY / 2**20:g} MiB", verdict(peak < ALLOWED_MEMORY)
        )
    for name, microseconds in measure_normal_matrix().items():
        table.add_row(f"exact normal matrix, {name}", f"{microseconds:.0f} µs", "", "")
    times = measure_import()
    shown = f"{median(times) * 1e3:.0f} ms (least {min(times) * 1e3:.0f})"
    within = verdict(median(times) < ALLOWED_IMPORT)
    table.add_row("import pvphong after pyvista", shown, f"{ALLOWED_IMPORT * 1e3:.0f} ms", within)
    console.print(table)


if __name__ == "__main__":
    main()
