"""How fast the reference evaluator is, beside a textbook's NumPy, and what it needs: `python bench_reference.py`.

The studies' `test_peers.py` shows that both compute the same thing.
"""

import tempfile
import time
import tracemalloc
from functools import partial
from statistics import median

import numpy as np
from common import apart, in_turns, mark, measured_scene, table, textbook, vertices
from rich.console import Console

from pvphong import DirectionalLight, LightModel, Material, Scene, SpotLight, evaluate, normal_matrix

COUNT, MANY = 250_000, 10_000_000
REPEATS, IMPORTS = 15, 7
ALLOWED_MEMORY, ALLOWED_MATRIX, ALLOWED_IMPORT = 64 * 2**20, 1e-3, 0.050


def scenes():
    """Name → scene, material; the mesh is a sphere of radius 1."""
    points, material = measured_scene()
    sun = DirectionalLight(direction=(-1, -2, -3))
    spots = [
        SpotLight(position=(2.0, 1.0, 2.5), direction=(-2, -1, -2.5), cone_angle=20, exponent=8),
        SpotLight(position=(-2.0, 1.5, 1.0), direction=(2, -1.5, -1), cone_angle=30, exponent=2.5),
    ]
    blinn, far = LightModel(reflection="blinn-phong"), LightModel(local_viewer=False)
    return {
        "sun, viewer far away": (Scene([sun], points.viewer, far), material),
        "sun, local viewer": (Scene([sun], points.viewer), material),
        "3 point lights": (points, material),
        "3 point lights, Blinn-Phong": (Scene(points.lights, points.viewer, blinn), material),
        "2 spot lights": (Scene(spots, points.viewer), material),
        "3 point lights, matt": (points, Material()),
    }


def measure(scene, material, precision):
    """Seconds of the evaluator and of the textbook, by name; medians."""
    points, normals = vertices(COUNT, precision)
    variants = {
        "stable": lambda: evaluate(points, normals, scene, material, precision=precision, backend="numpy"),
        "textbook": lambda: textbook(points, normals, scene, material),
    }
    return {name: median(times) for name, times in in_turns(variants, REPEATS, time.process_time).items()}


def measure_memory(precision):
    """Bytes at the peak beside inputs and output, for float32 vertices."""
    scene, material = measured_scene()
    points, normals = (np.resize(a, (MANY, 3)) for a in vertices(COUNT, np.float32))
    tracemalloc.start()
    rgb = evaluate(points, normals, scene, material, precision=precision, backend="numpy").rgb
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak - rgb.nbytes


def matrix_seconds():
    """Median seconds of an exact normal matrix, of the slowest kind of matrix."""
    rng, calls = np.random.default_rng(0), {}
    for scales in ((1, 1, 1), (1e-8, 1, 1e8), (1e-150, 1, 1e150)):
        matrix = np.eye(4)
        matrix[:3, :3] = rng.normal(size=(3, 3)) * scales
        calls[scales] = partial(normal_matrix, matrix)
    return max(median(times) for times in in_turns(calls, 300).values())


IMPORT = """
import time
import pyvista
start = time.process_time()
import pvphong
print(time.process_time() - start)
"""


def import_seconds():
    """Median seconds of CPU time that `import pvphong` adds after `import pyvista`, in fresh interpreters.

    The first one compiles to bytecode, as an installer does, and does not count.
    """
    with tempfile.TemporaryDirectory() as bytecode:
        variables = {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": bytecode}
        return median([float(apart(IMPORT, **variables)) for _ in range(1 + IMPORTS)][1:])


def main():
    title = f"CPU time per vertex, median of {REPEATS} runs in turns over {COUNT:,} vertices"
    speed = table(title, "scene", "precision", "stable", "textbook", "textbook over it", texts=2)
    for name, (scene, material) in scenes().items():
        for precision in ("float32", "float64"):
            stable, book = measure(scene, material, precision).values()
            speed.add_row(
                name, precision, *(f"{each / COUNT * 1e9:.0f} ns" for each in (stable, book)), f"{book / stable:.2f}"
            )
    console, others = Console(width=120), table("Beside speed", "what", "measured", "allowed", "met")
    for precision in ("float32", "float64"):
        peak, allowed = measure_memory(precision) / 2**20, ALLOWED_MEMORY / 2**20
        what = f"peak memory beside inputs and output, {MANY / 1e6:g} M vertices, {precision}"
        others.add_row(what, f"{peak:.1f} MiB", f"{allowed:g} MiB", mark(peak < allowed))
    matrix, importing = matrix_seconds(), import_seconds()
    what, allowed = "exact normal matrix, the slowest kind", f"{ALLOWED_MATRIX * 1e6:g} µs"
    others.add_row(what, f"{matrix * 1e6:.0f} µs", allowed, mark(matrix < ALLOWED_MATRIX))
    what, allowed = "import pvphong after pyvista", f"{ALLOWED_IMPORT * 1e3:.0f} ms"
    others.add_row(what, f"{importing * 1e3:.0f} ms", allowed, mark(importing < ALLOWED_IMPORT))
    console.print(speed)
    console.print(others)


if __name__ == "__main__":
    main()
