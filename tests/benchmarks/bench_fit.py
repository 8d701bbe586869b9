"""Time of fits at 100,000 points against the figures of the guide: `python bench_fit.py`."""

import functools
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


def best(function, count=7) -> tuple[float, float]:
    """Return the least time of several calls, and the least processor time."""
    times = []
    for _ in range(count):
        start, used = time.perf_counter(), time.process_time()
        function()
        times.append((time.perf_counter() - start, time.process_time() - used))
    seconds, cpu = np.min(times, axis=0).tolist()
    return seconds, cpu


def painted(ball):
    """Return targets that no light can give: name → luminances or colours."""
    x, y, z = (5.0 * np.asarray(ball.points, float)).T

    one, other = np.hypot(x - 1.5, z - 1.5) < 0.75, np.hypot(x + 1.5, z + 1.0) < 1.0

    def soft(distance):
        return 1.0 / (1.0 + np.exp(-4.0 * distance))

    return {
        "one half": 0.1 + 0.6 * soft(x + 0.3 * z),
        "a stripe": 0.1 + 0.7 * soft(1.0 - np.abs(x)),
        "at least 1": 0.1 + 1.1 * soft(z),
        "two spots": np.where(one, 0.9, np.where(other, 0.5, 0.1)),
        "two spots alone": np.where(one & (y < 0), 0.9, np.where(other & (y < 0), 0.2, np.nan)),
        "colours": np.stack([0.1 + 0.6 * soft(x), 0.2 + 0.3 * soft(z), 0.1 + 0.6 * soft(-x)], axis=1),
    }


def main() -> int:
    """Print the table; return 1 if a fit takes longer than it may."""
    ball = pv.Sphere(theta_resolution=320, phi_resolution=316)
    ball.points *= 1.0 + 0.1 * np.sin(9.0 * ball.points[:, :1])
    ball = ball.compute_normals()
    rows = []
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
        begun = functools.partial(ball.phong.fit, begin, SHINY, target, vary)
        rows.append((len(lights), f"reachable, noise {noise:g}", vary, allowed, *best(begun)))
    begin = [replace(light, intensity=0.5) for light in LIGHTS[:2]]
    for name, target in painted(ball).items():
        vary = "intensity diffuse direction" if target.ndim == 2 else "intensity direction"
        begun = functools.partial(ball.phong.fit, begin, SHINY, target, vary)
        rows.append((2, f"painted: {name}", vary, MOVING, *best(begun, 3)))
    cells = [(f"{n}", target, vary, *(f"{1e3 * each:.0f}" for each in times)) for n, target, vary, *times in rows]
    show(f"{ball.n_points:,} points", ("lights", "target", "fields", "allowed ms", "ms", "CPU ms"), cells, texts=3)
    ok = all(seconds <= allowed for _, _, _, allowed, seconds, _ in rows)
    if not ok:
        CONSOLE.print("[red]A fit takes longer than it may.")
    return 0 if ok else 1


if __name__ == "__main__":
    sys.exit(main())
