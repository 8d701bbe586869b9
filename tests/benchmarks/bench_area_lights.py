"""What lights with a size cost: beside a point light with a highlight, and beside 64 nodes, on one mesh in one run.

    python tests/benchmarks/bench_area_lights.py

Times are the least of some rounds in turns; errors are against the float64 reference.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from common import least_in_turns

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


SIZED = {"sphere": SPHERE, "square": SQUARE, "disk": DISK}
CASES: dict[str, tuple[list[ph.Light], float]] = {
    "point, highlight": ([POINT], 20.0),
    "point, matt": ([POINT], 0.0),
    "sky, matt": ([SKY], 0.0),
    "sky, shininess 20": ([SKY], 20.0),
}
for kind, sized in SIZED.items():
    CASES |= {f"{kind}, shininess {power:g}": ([sized], power) for power in (0.0, 20.0, 1000.0)}
    CASES[f"{kind}, 64 nodes"] = nodes_of(sized), 20.0
BESIDE, AGAINST = ph.Viewer((1.5, -2.0, 3.0)), ph.Viewer((-2.5, 1.5, 1.0))
"""Eyes that see where lights shine, and that look against them: highlights are cut by the horizon."""


def main() -> None:
    points, normals = ball()
    for where, viewer in (("seen from beside the lights", BESIDE), ("seen against the lights", AGAINST)):
        print(f"{len(points):,} vertices, float32, {where}")
        measure(points, normals, viewer)


def measure(points: np.ndarray, normals: np.ndarray, viewer: ph.Viewer) -> None:
    def run(lights: list[ph.Light], shininess: float, rows: slice = slice(None), **options: str) -> np.ndarray:
        scene = ph.Scene(lights, viewer, ph.LightModel(ambient=0.0))
        material = ph.Material(diffuse=0.6, specular=0.4 if shininess else 0.0, shininess=shininess)
        return ph.evaluate(points[rows], normals[rows], scene, material, **options).rgb

    some = slice(None, None, len(points) // FEW)
    seconds = least_in_turns({name: partial(run, *case, backend="numba") for name, case in CASES.items()}, ROUNDS)
    for name, (lights, shininess) in CASES.items():
        whole = [SIZED[name.split(",")[0]]] if name.endswith("nodes") else lights
        exact = run(whole, shininess, some, precision="float64", backend="numpy")
        error = np.abs(run(lights, shininess, some, backend="numba") - exact).max()
        times = seconds[name] / seconds["point, highlight"]
        print(f"{name:24} {seconds[name] * 1e3:8.1f} ms  {times:7.1f} x a point with highlight  error {error:.1e}")


if __name__ == "__main__":
    main()
