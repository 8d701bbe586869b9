"""How fast the compiled evaluator is: `python bench_kernel.py [vertices]`.

Every workload is measured as a ratio to `np.add(a, b, out=out)` on (n, 3) float32 arrays, which is what the memory
allows NumPy, and to the textbook's formula; the least time of each counts. Processor time on one thread is what a busy
machine changes least. The targets are for two cores that have nothing else to do. Whether they had is told by how much
faster two threads are than one; a machine that is shared is at times slow for seconds, so the repeats are spread over
the whole run. Memory, growth and the first call are in bench_whole_job.py.
"""

import sys
import time
from dataclasses import replace

import numpy as np
from common import least_in_turns, mark, table, textbook, vertices
from rich.console import Console

from pvphong import (
    GGX,
    DirectionalLight,
    DiskLight,
    LightModel,
    Material,
    Plan,
    PointLight,
    RectangleLight,
    Scene,
    Shading,
    SphereLight,
    SpotLight,
    Viewer,
)
from pvphong.base import threads
from pvphong.shading import kernel
from pvphong.shading.evaluation import evaluate
from pvphong.shading.plan.effects import EFFECTS
from pvphong.shading.vertices import Vertices

REPEATS, FEW_REPEATS = 100, 40

DULL = Material(ambient=0.1, diffuse=(0.6, 0.5, 0.4))
SHINY = replace(DULL, specular=0.5, shininess=20)
LAMPS = (
    PointLight(position=(2.0, 1.0, 2.5), diffuse=(1.0, 0.9, 0.8)),
    PointLight(position=(-2.0, 1.5, 1.0), diffuse=(0.3, 0.4, 0.9)),
    PointLight(position=(0.5, -2.0, 2.0)),
)
SPOT = SpotLight(
    position=(2.0, 1.0, 2.5), direction=(-2.0, -1.0, -2.5), cone_angle=40, exponent=8, attenuation=(1, 0.1, 0.05)
)
SUN = DirectionalLight(direction=(-1.0, -1.0, -2.0))
WITH_A_SIZE = {
    "square": RectangleLight((2.0, 1.0, 2.5), (-2.0, -1.0, -2.5), (0, 0, 1), 1.0, 1.0),
    "disk": DiskLight((2.0, 1.0, 2.5), (-2.0, -1.0, -2.5), 0.5),
    "sphere": SphereLight((2.0, 1.0, 2.5), 0.5),
}
VIEWER = Viewer(position=(1.0, 0.5, 4.0))


def scene_of(*lights):
    return Scene(lights=lights, viewer=VIEWER)


BLINN_PHONG = replace(scene_of(*LAMPS), light_model=LightModel(reflection="blinn-phong"))


def compiled(arrays, scene, material, real, planned=False):
    """A call of the kernel, without its plan unless that is asked for; `.plan` tells what is expected of it."""
    points, normals = arrays
    out, given = Shading(np.empty(points.shape, real)), Vertices(points, normals, material.maps)
    equation = given.equation(scene, material, None)

    def run():
        left, at = equation, given
        if planned:
            at = Vertices(points, normals, material.maps)
            left = Plan.of(scene, material, at).equation
        assert kernel.shade(points, normals, left, at.tints(left), out, channels=at.channels(left))

    run.plan = Plan.of(scene, material, given)
    return run


def evaluated(arrays, material):
    """A call of `evaluate`, which checks a material's maps."""
    scene = scene_of(*LAMPS)
    return lambda: evaluate(*arrays, scene, material, backend="numba")


def mapped(count):
    """Name → material without a map, and with one."""
    numbers = np.random.default_rng(1).uniform(0.1, 1.0, (count, 3)).astype(np.float32)
    gloss, rough = 50 * numbers[:, 0].copy(), numbers[:, 1].copy()
    return {
        "no map": SHINY,
        "map of shininess": replace(SHINY, shininess=gloss),
        "map of specular": replace(SHINY, specular=numbers),
        "map of albedo": replace(SHINY, albedo=numbers),
        "all three": replace(SHINY, shininess=gloss, specular=numbers, albedo=numbers),
        "GGX": replace(DULL, reflectance=GGX(0.4)),
        "GGX, map of roughness": replace(DULL, reflectance=GGX(rough)),
    }


def workloads(count):
    """Name → call."""
    small, wide = vertices(count, np.float32), vertices(count)
    missing = [SpotLight(position=(0.0, 0.0, 50.0 + k), direction=(0, 0, 1), cone_angle=20) for k in range(60)]
    lit = [*LAMPS, replace(LAMPS[0], position=(0.0, 3.0, 0.0))]
    total = np.empty_like(small[0])
    return {
        "a + b": lambda: np.add(*small, out=total),
        "3 lamps, highlights": compiled(small, scene_of(*LAMPS), SHINY, np.float32),
        "3 lamps, highlights, Blinn-Phong": compiled(small, BLINN_PHONG, SHINY, np.float32),
        "3 lamps, highlights, 0-255": compiled(small, scene_of(*LAMPS), SHINY, np.uint8),
        "3 lamps, dull": compiled(small, scene_of(*LAMPS), DULL, np.float32),
        "1 sun, dull": compiled(small, scene_of(SUN), DULL, np.float32),
        "ambient only": compiled(small, scene_of(), DULL, np.float32),
        "1 lamp, highlights": compiled(small, scene_of(LAMPS[0]), SHINY, np.float32),
        "1 spot, highlights": compiled(small, scene_of(SPOT), SHINY, np.float32),
        **{
            f"1 {name}, dull": compiled(small, scene_of(light), DULL, np.float32) for name, light in WITH_A_SIZE.items()
        },
        **{
            f"1 {name}, highlights": compiled(small, scene_of(light), SHINY, np.float32)
            for name, light in WITH_A_SIZE.items()
        },
        "4 lamps, with plan": compiled(small, scene_of(*lit), SHINY, np.float32, planned=True),
        "64 lights, 60 miss, with plan": compiled(small, scene_of(*lit, *missing), SHINY, np.float32, planned=True),
        **{f"evaluate, {name}": evaluated(small, material) for name, material in mapped(count).items()},
        "3 lamps, highlights, float64": compiled(wide, scene_of(*LAMPS), SHINY, np.float64),
    }


def targets(least, book):
    """(what, measured, target, whether more is better) for each promise."""
    add = least["a + b"]
    highlights = least["3 lamps, highlights"]
    return [
        ("3 lamps, highlights: textbook over it", book / highlights, 60.0, True),
        ("3 lamps, highlights: over a + b", highlights / add, 3.5, False),
        ("3 lamps, dull: over a + b", least["3 lamps, dull"] / add, 1.5, False),
        ("1 sun, dull: over a + b", least["1 sun, dull"] / add, 0.8, False),
        ("ambient only: over a + b", least["ambient only"] / add, 0.5, False),
        ("1 spot over 1 lamp", least["1 spot, highlights"] / least["1 lamp, highlights"], 1.6, False),
        *[
            (f"1 {name} over 1 lamp", least[f"1 {name}, highlights"] / least["1 lamp, highlights"], 12.0, False)
            for name in WITH_A_SIZE
        ],
        ("float64: textbook over it", book / least["3 lamps, highlights, float64"], 12.0, True),
        ("0-255 over float32", least["3 lamps, highlights, 0-255"] / highlights, 1.0, False),
        *[
            (f"map of {name} over none", least[f"evaluate, map of {name}"] / least["evaluate, no map"], 1.5, False)
            for name in ("shininess", "specular")
        ],
        ("map of roughness over none", least["evaluate, GGX, map of roughness"] / least["evaluate, GGX"], 1.5, False),
        ("64 lights over 4", least["64 lights, 60 miss, with plan"] / least["4 lamps, with plan"], 1.3, False),
    ]


def estimate(call):
    """What `Plan.explain` says that a call costs, ns per vertex on one thread; the writing of colours is no effect."""
    plan = getattr(call, "plan", None)
    return "" if plan is None else f"{sum(effect.nanoseconds(plan.effects[effect.name]) for effect in EFFECTS):.1f}"


def main():
    count = int(float(sys.argv[1])) if len(sys.argv) > 1 else 1_000_000
    calls, arrays = workloads(count), vertices(count)
    first = least_in_turns(calls, REPEATS)
    with threads.limited(1):
        alone = least_in_turns(calls, FEW_REPEATS, time.thread_time)
    book = least_in_turns({"it": lambda: textbook(*arrays, scene_of(*LAMPS), SHINY)}, 3)["it"]
    least = {name: min(first[name], seconds) for name, seconds in least_in_turns(calls, REPEATS).items()}

    headings = "ms", "over a + b", "textbook over it", "one thread, ns", "of which plan says"
    times = table(f"{count / 1e6:g} M vertices, least of {2 * REPEATS} repeats in turns", "workload", *headings)
    for name, seconds in {**least, "textbook, float64": book}.items():
        ratios = f"{seconds / least['a + b']:.2f}", f"{book / seconds:.1f}"
        single = f"{alone[name] / count * 1e9:.2f}" if name in alone else ""
        times.add_row(name, f"{seconds * 1e3:.2f}", *ratios, single, estimate(calls.get(name)))
    promises = table("Targets", "what", "measured", "target", "met")
    for what, measured, target, more in targets(least, book):
        met = measured >= target if more else measured <= target
        promises.add_row(what, f"{measured:.2f}", f"{'>=' if more else '<='} {target:g}", mark(met))
    console = Console()
    console.print(times)
    sooner = alone["3 lamps, highlights"] / least["3 lamps, highlights"]
    console.print(f"3 lamps, highlights: two threads are {sooner:.2f} times as fast as one")
    console.print(promises)


if __name__ == "__main__":
    main()
