"""What lights with a size cost: beside a point light with a highlight, and beside 64 nodes, on one mesh in one run.

    python tests/benchmarks/bench_area_lights.py

Times are the least of some rounds in turns; errors are against the float64 reference.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

import pvphong as ph

SIDE, ROUNDS, FEW = 1000, 9, 20000
PLACE = (1.5, -1.0, 2.0)
AIM = (-1.5, 1.0, -2.0)
SPHERE = ph.SphereLight(PLACE, 0.3, intensity=5)
SQUARE = ph.RectangleLight(PLACE, AIM, (0, 0, 1), 0.6, 0.6, intensity=5)
DISK = ph.DiskLight(PLACE, AIM, 0.3, intensity=5)
SKY = ph.EnvironmentLight(np.random.default_rng(0).uniform(0.0, 1.0, (8, 16, 3)))
POINT = ph.PointLight(PLACE, (0, 0, 1), intensity=5)


def ball() -> tuple[np.ndarray, np.ndarray]:
    """A million vertices of a sphere, row by row, and their normals."""
    theta, phi = np.meshgrid(np.linspace(1e-3, np.pi - 1e-3, SIDE), np.linspace(0, 2 * np.pi, SIDE), indexing="ij")
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    return points.reshape(-1, 3).astype(np.float32), points.reshape(-1, 3).astype(np.float32)


def nodes_of(light: ph.Light) -> list[ph.Light]:
    return [replace(node, intensity=node.intensity * light.intensity) for node in light.nodes(64)]


def material_of(shininess: float) -> ph.Material:
    return ph.Material(diffuse=0.6, specular=0.4 if shininess else 0.0, shininess=shininess)


CASES: dict[str, tuple[list[ph.Light], float]] = {
    "point, highlight": ([POINT], 20.0),
    "point, matt": ([POINT], 0.0),
    "sphere, matt": ([SPHERE], 0.0),
    "sphere, shininess 20": ([SPHERE], 20.0),
    "sphere, shininess 1000": ([SPHERE], 1000.0),
    "sphere, 64 nodes": (nodes_of(SPHERE), 20.0),
    "square, matt": ([SQUARE], 0.0),
    "square, shininess 20": ([SQUARE], 20.0),
    "square, shininess 1000": ([SQUARE], 1000.0),
    "square, 64 nodes": (nodes_of(SQUARE), 20.0),
    "sky, matt": ([SKY], 0.0),
    "sky, shininess 20": ([SKY], 20.0),
    "disk, matt": ([DISK], 0.0),
    "disk, shininess 20": ([DISK], 20.0),
    "disk, shininess 1000": ([DISK], 1000.0),
}
EXACT = {"sphere, 64 nodes": SPHERE, "square, 64 nodes": SQUARE}


BESIDE, AGAINST = ph.Viewer((1.5, -2.0, 3.0)), ph.Viewer((-2.5, 1.5, 1.0))
"""Eyes that see where lights shine, and that look against them: highlights are cut by the horizon."""


def main() -> None:
    points, normals = ball()
    for where, viewer in (("seen from beside the lights", BESIDE), ("seen against the lights", AGAINST)):
        print(f"{len(points):,} vertices, float32, {where}")
        measure(points, normals, viewer)


def measure(points: np.ndarray, normals: np.ndarray, viewer: ph.Viewer) -> None:
    model = ph.LightModel(ambient=0.0)

    def run(lights: list[ph.Light], shininess: float, rows: slice = slice(None), **options: str) -> np.ndarray:
        scene = ph.Scene(lights, viewer, model)
        return ph.evaluate(points[rows], normals[rows], scene, material_of(shininess), **options).rgb

    def least(action: Callable[[], object]) -> float:
        start = time.perf_counter()
        action()
        return time.perf_counter() - start

    some = slice(None, None, len(points) // FEW)
    seconds = dict.fromkeys(CASES, np.inf)
    for _ in range(ROUNDS):
        for name, case in CASES.items():
            if not np.isfinite(seconds[name]):
                run(*case, backend="numba")
            if seconds[name] < 1.0 or not np.isfinite(seconds[name]):
                seconds[name] = min(seconds[name], least(lambda case=case: run(*case, backend="numba")))
    for name, (lights, shininess) in CASES.items():
        exact = run([EXACT[name]] if name in EXACT else lights, shininess, some, precision="float64", backend="numpy")
        error = np.abs(run(lights, shininess, some, backend="numba") - exact).max()
        times = seconds[name] / seconds["point, highlight"]
        print(f"{name:24} {seconds[name] * 1e3:8.1f} ms  {times:7.1f} x a point with highlight  error {error:.1e}")


if __name__ == "__main__":
    main()
