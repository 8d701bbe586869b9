"""Time of fits at 100,000 points against the figures of the guide: `python bench_fit.py`."""

import sys
import time
from dataclasses import replace

import numpy as np
import pyvista as pv
from common import CONSOLE, show

import pvphong as ph

LINEAR, MOVING = 0.025, 2.0
"""Seconds that fits of four lights' intensities and colours, and of two lights' directions too, may take."""

LIGHTS = [
    ph.DirectionalLight(direction=(1, 0, -1), intensity=0.3, name="a"),
    ph.DirectionalLight(direction=(0, 1, 0.1), intensity=0.4, name="b"),
    ph.PointLight(position=(2, 2, 2), intensity=0.1, name="c"),
    ph.SpotLight(position=(0, 0, 2), intensity=0.25, name="d"),
]
SHINY = ph.Material(specular=0.3, shininess=20)


def best(function, count=7) -> float:
    """Return the least time of several calls."""
    times = []
    for _ in range(count):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> int:
    """Print the table; return 1 if a fit takes longer than it may."""
    ball = pv.Sphere(theta_resolution=320, phi_resolution=316)
    ball.points *= 1.0 + 0.1 * np.sin(9.0 * ball.points[:, :1])
    ball = ball.compute_normals()
    rows, ok = [], True
    random = np.random.default_rng(1)
    for lights, vary, noise, allowed in (
        (LIGHTS, "intensity", 0.01, LINEAR),
        (LIGHTS, "intensity diffuse", 0.01, LINEAR),
        (LIGHTS[:2], "intensity direction", 0.0, MOVING),
        (LIGHTS[:2], "intensity direction", 0.01, MOVING),
    ):
        clean = ball.phong.shade(lights, SHINY, precision="float64")["phong"]
        target = np.maximum(clean + noise * random.normal(size=clean.shape), 0.0)
        begin = [replace(light, intensity=1.0) for light in lights]
        if "direction" in vary:
            begin = [replace(light, direction=(0, 0, -1)) for light in begin]
        seconds = best(lambda begin=begin, target=target, vary=vary: ball.phong.fit(begin, SHINY, target, vary))
        ok &= seconds <= allowed
        rows.append((f"{len(lights)} lights", vary, f"{noise:g}", f"{1e3 * seconds:.0f}", f"{1e3 * allowed:.0f}"))
    show(f"{ball.n_points:,} points", ("lights", "fields", "noise", "ms", "allowed"), rows, texts=2)
    if not ok:
        CONSOLE.print("[red]A fit takes longer than it may.")
    return 0 if ok else 1


if __name__ == "__main__":
    sys.exit(main())
