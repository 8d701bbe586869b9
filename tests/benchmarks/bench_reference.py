"""Speed of the reference evaluator, cost of its stability, and its memory: `python bench_reference.py`.

The evaluator is compared with a variant with naive formulas, but the same blocks, memory layout and order of work:

- highlights: the power of r·v or n·h instead of the power of a chord;
- cones: the cosine with the axis and its power instead of a chord;
- vectors: division by their length without a check for overflow;
- positions, in the last variant: float32 for float32 results instead of always float64.

`test_naive_block.py` and the studies' `test_peers.py` test that all variants agree.
"""

import tempfile
import time
import tracemalloc
from contextlib import ExitStack, contextmanager
from functools import partial
from statistics import median
from unittest import mock

import numpy as np
from common import apart, in_turns, mark, measured_scene, show, textbook, vertices

from pvphong import DirectionalLight, LightModel, Material, Scene, SpotLight, evaluate
from pvphong.base import formulas
from pvphong.base.vectors import dot
from pvphong.optics import light
from pvphong.optics.attenuation import attenuate
from pvphong.optics.light import Arrival
from pvphong.optics.reflectances import BlinnPhong, Phong
from pvphong.pipeline import normal_matrix
from pvphong.shading import reference

COUNT, MANY = 250_000, 10_000_000
REPEATS, IMPORTS = 15, 7
ALLOWED_LOSS, ALLOWED_MEMORY, ALLOWED_MATRIX, ALLOWED_IMPORT = 0.25, 64 * 2**20, 1e-3, 0.050


def mirror_cosine(at):
    """Return r·v by the mirror direction."""
    normals = formulas.times(at.n, at.scale)
    twice = 2 * formulas.dot(normals, at.l)
    return formulas.dot([twice * n - l for n, l in zip(normals, at.l, strict=True)], at.v)


def halfway_cosine(at):
    """Return n·h."""
    h = at.l + at.v
    return formulas.dot(formulas.times(at.n, at.scale), h / np.sqrt(formulas.dot(h, h)))


def power(cosine, exponent, floor=0.0):
    """Return max(cosine, floor) to the power of the exponent."""
    return np.maximum(cosine, cosine.dtype.type(floor)) ** cosine.dtype.type(exponent)


def naive_directions_to(target, points, real):
    """Return `naive_towards` in the form that lights use."""
    direction, distance = naive_towards(target, points, real)
    return direction, 1.0, distance


def naive_towards(target, points, real):
    """Return unit vectors and distances, without checks."""
    difference = np.empty(points.shape, real)
    np.subtract(np.array(target, points.dtype)[:, None], points, out=difference, casting="same_kind")
    distance = np.sqrt(dot(difference, difference))
    difference /= distance
    return difference, distance


def naive_moderate(w, real):
    w = w.astype(real, order="C")
    return w, 1.0 / np.sqrt(dot(w, w))


def naive_spot(self, points, real=np.float64):
    directions, _, distance = naive_directions_to(self.position, points, real)
    axis = np.array(self.direction, real)
    cosine = -dot(axis[:, None] / np.sqrt(axis @ axis), directions)
    inside = cosine >= real(np.cos(np.radians(self.cone_angle)))
    factor = np.where(inside, np.maximum(cosine, 0) ** real(self.exponent), 0)
    return Arrival(directions, attenuate(distance, self.attenuation) * factor)


@contextmanager
def naive_formulas(real=np.float64):
    """Make `evaluate` use naive formulas and positions of the float type `real` in this context."""
    replaced = [
        (Phong, "peak", Phong.peak._replace(square=mirror_cosine)),
        (BlinnPhong, "peak", BlinnPhong.peak._replace(square=halfway_cosine)),
        (reference, "chord_power", power),
        (reference, "moderate", naive_moderate),
        (reference, "towards", naive_towards),
        (reference, "columns", lambda rows: rows.T.astype(real, order="C")),
        (light, "directions_to", naive_directions_to),
        (SpotLight, "arrival", naive_spot),
    ]
    with ExitStack() as stack, np.errstate(all="ignore"):
        for patched in replaced:
            stack.enter_context(mock.patch.object(*patched))
        yield


def scenes():
    """Return pairs of scene and material by name, for a sphere of radius 1."""
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
    """Return median seconds by name, of the evaluator, of naive formulas and of the textbook."""
    points, normals = vertices(COUNT, precision)

    def run():
        evaluate(points, normals, scene, material, precision=precision, backend="numpy")

    def run_naive(real):
        with naive_formulas(real):
            run()

    variants = {"stable": run, "naive": lambda: run_naive(np.float64)}
    if precision == "float32":
        variants["float32 throughout"] = lambda: run_naive(np.float32)
    else:
        variants["textbook"] = lambda: textbook(points, normals, scene, material)
    return in_turns(variants, REPEATS, time.process_time, median)


def measure_memory(precision):
    """Return the peak memory in bytes beyond inputs and output, for float32 vertices."""
    scene, material = measured_scene()
    points, normals = (np.resize(a, (MANY, 3)) for a in vertices(COUNT, np.float32))
    tracemalloc.start()
    rgb = evaluate(points, normals, scene, material, precision=precision, backend="numpy").rgb
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak - rgb.nbytes


def matrix_seconds():
    """Return the median seconds of an exact normal matrix, for the slowest kind of matrix."""
    rng, calls = np.random.default_rng(0), {}
    for scales in ((1, 1, 1), (1e-8, 1, 1e8), (1e-150, 1, 1e150)):
        matrix = np.eye(4)
        matrix[:3, :3] = rng.normal(size=(3, 3)) * scales
        calls[scales] = partial(normal_matrix, matrix)
    return max(in_turns(calls, 300, of=median).values())


IMPORT = """
import time
import pyvista
start = time.process_time()
import pvphong
print(time.process_time() - start)
"""


def import_seconds():
    """Return the median CPU seconds of `import pvphong` after `import pyvista`, in fresh interpreters.

    The first one compiles to bytecode, as an installer does, and does not count.
    """
    with tempfile.TemporaryDirectory() as bytecode:
        variables = {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": bytecode}
        return median([float(apart(IMPORT, **variables)) for _ in range(1 + IMPORTS)][1:])


def speed(name, scene, material, precision):
    """Return the table row of a scene."""
    seconds = measure(scene, material, precision)
    cells = [f"{seconds['stable'] / COUNT * 1e9:.0f} ns"]
    for naive in ("naive", "float32 throughout", "textbook"):
        if naive in seconds:
            loss = 1.0 - seconds[naive] / seconds["stable"]
            verdict = f"[{'green' if loss < ALLOWED_LOSS else 'red'}]{loss:+.0%}[/]"
            cells += [f"{seconds[naive] / COUNT * 1e9:.0f} ns", "" if naive == "textbook" else verdict]
    return name, precision, *cells


def promise(what, measured, allowed, unit, scale, decimals=0):
    """Return the table row of a measured value and its limit, both divided by the unit's scale."""
    shown = f"{measured / scale:.{decimals}f} {unit}", f"{allowed / scale:g} {unit}"
    return what, *shown, mark(measured < allowed)


def main():
    precisions = "float32", "float64"
    speeds = [speed(name, *lit, precision) for name, lit in scenes().items() for precision in precisions]
    memory = f"peak memory beyond inputs and output, {MANY / 1e6:g} M vertices"
    promises = [
        *(promise(f"{memory}, {each}", measure_memory(each), ALLOWED_MEMORY, "MiB", 2**20, 1) for each in precisions),
        promise("exact normal matrix, the slowest kind", matrix_seconds(), ALLOWED_MATRIX, "µs", 1e-6),
        promise("import pvphong after pyvista", import_seconds(), ALLOWED_IMPORT, "ms", 1e-3),
    ]
    title = f"CPU time per vertex, median of {REPEATS} runs in turns over {COUNT:,} vertices, and the cost of stability"
    headings = "scene", "precision", "stable", "naive", "loss", "float32 throughout, textbook", "loss"
    show(title, headings, speeds, texts=2)
    show("Memory and start", ("what", "measured", "allowed", "met"), promises)


if __name__ == "__main__":
    main()
