"""What stability costs: the reference evaluator against itself with naive formulas, `python bench_stability.py`.

Blocks, memory layout and the order of the work are the same in all variants; these differ:

- highlights: the power of r·v or n·h, where the evaluator takes the power of a chord;
- cones: the cosine with the axis and its power, where it takes a chord too;
- vectors: divided by their length, where it looks for lengths that would overflow first;
- positions, in the last variant: float32 where the result is float32, where they are always float64.

Variants are measured in turns, so that a busy machine slows all of them down alike.
"""

import time
from contextlib import ExitStack, contextmanager
from statistics import median
from unittest import mock

import numpy as np
from naive_block import naive_highlights
from rich.console import Console
from rich.table import Table
from textbook import measured_scene, vertices

from pvphong import DirectionalLight, LightModel, Material, Scene, SpotLight, evaluate, normal_matrix
from pvphong.base.vectors import dot
from pvphong.optics import light
from pvphong.optics.attenuation import attenuate
from pvphong.optics.light import Arrival
from pvphong.shading import reference

COUNT = 250_000
REPEATS = 15
ALLOWED = 0.25
ALLOWED_MATRIX = 1e-3


def naive_directions_to(target, points, real):
    """`naive_towards`, in the form that lights take."""
    direction, distance = naive_towards(target, points, real)
    return direction, 1.0, distance


def naive_towards(target, points, real):
    """Unit vectors and distances, whatever the numbers."""
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
def naive_formulas(real):
    """While it lasts, `evaluate` computes with naive formulas, from positions in the float type `real`."""
    with ExitStack() as stack:
        stack.enter_context(naive_highlights())
        replaced = [(reference, "moderate", naive_moderate), (reference, "towards", naive_towards)]
        replaced += [(light, "directions_to", naive_directions_to), (SpotLight, "arrival", naive_spot)]
        replaced += [(reference, "columns", lambda rows: rows.T.astype(real, order="C"))]
        for owner, name, naive in replaced:
            stack.enter_context(mock.patch.object(owner, name, naive))
        yield


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


def interleaved(variants):
    """Median seconds of each variant, run in turns."""
    seconds = {name: [] for name in variants}
    for turn in range(REPEATS + 1):
        for name, run in variants.items():
            start = time.process_time()
            run()
            if turn:  # the first one warms up
                seconds[name].append(time.process_time() - start)
    return {name: median(times) for name, times in seconds.items()}


def measure(scene, material, precision):
    points, normals = vertices(COUNT, precision)

    def run():
        evaluate(points, normals, scene, material, precision=precision, backend="numpy")

    def run_naive(real):
        with naive_formulas(real), np.errstate(all="ignore"):
            run()

    variants = {"stable": run, "naive": lambda: run_naive(np.float64)}
    if precision == "float32":
        variants["float32 throughout"] = lambda: run_naive(np.float32)
    return interleaved(variants)


def verdict(loss):
    return f"[{'green' if loss < ALLOWED else 'red'}]{loss:+.0%}[/]"


def matrix_seconds():
    """Median seconds of an exact normal matrix, of the slowest kind of matrix."""
    rng = np.random.default_rng(0)
    slowest = 0.0
    for scales in ((1, 1, 1), (1e-8, 1, 1e8), (1e-150, 1, 1e150)):
        matrix = np.eye(4)
        matrix[:3, :3] = rng.normal(size=(3, 3)) * scales
        times = []
        for _ in range(300):
            start = time.perf_counter()
            normal_matrix(matrix)
            times.append(time.perf_counter() - start)
        slowest = max(slowest, median(times))
    return slowest


def main():
    table = Table(title=f"CPU time per vertex, median of {REPEATS} runs in turns over {COUNT:,} vertices")
    for heading in ("scene", "precision", "stable", "naive", "loss", "float32 throughout", "loss"):
        table.add_column(heading, justify="left" if heading in ("scene", "precision") else "right")
    for name, (scene, material) in scenes().items():
        for precision in ("float32", "float64"):
            seconds = measure(scene, material, precision)
            stable = seconds.pop("stable")
            cells = [f"{stable / COUNT * 1e9:.0f} ns"]
            for naive in seconds.values():
                cells += [f"{naive / COUNT * 1e9:.0f} ns", verdict(1 - naive / stable)]
            table.add_row(name, precision, *cells)
    console = Console(width=120)
    console.print(table)
    seconds = matrix_seconds()
    within = "within" if seconds < ALLOWED_MATRIX else "over"
    console.print(f"exact normal matrix: {seconds * 1e6:.0f} µs a call, {within} {ALLOWED_MATRIX * 1e6:.0f} µs")


if __name__ == "__main__":
    main()
