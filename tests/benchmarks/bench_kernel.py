"""Speed of the compiled evaluator: `python bench_kernel.py [vertices]`.

Every workload is measured as a ratio to `np.add(a, b, out=out)` on (n, 3) float32 arrays, which is NumPy's limit by
memory bandwidth, and to the textbook's formula. The least time of each counts. A busy machine affects processor time on
one thread least. The targets are for two idle cores; the speedup of two threads over one shows whether they were idle.
A shared machine can be slow for seconds, so the repeats are spread over the whole run. bench_whole_job.py measures
memory, growth and the first call.
"""

import time
from dataclasses import replace
from functools import partial

import cyclopts
import numpy as np
from common import CONSOLE, in_turns, mark, show, textbook, vertices

import pvphong as ph
from pvphong.base import threads
from pvphong.optics.photometry import Photometry
from pvphong.shading import kernel
from pvphong.shading.evaluation import evaluate
from pvphong.shading.plan.effects import EFFECTS
from pvphong.shading.vertices import Vertices

REPEATS, FEW_REPEATS = 100, 40

DULL = ph.Material(ambient=0.1, diffuse=(0.6, 0.5, 0.4))
SHINY = replace(DULL, specular=0.5, shininess=20)
PLACE, AIM, VIEWER = (2.0, 1.0, 2.5), (-2.0, -1.0, -2.5), ph.Viewer(position=(1.0, 0.5, 4.0))
LAMPS = (
    ph.PointLight(position=PLACE, diffuse=(1.0, 0.9, 0.8)),
    ph.PointLight(position=(-2.0, 1.5, 1.0), diffuse=(0.3, 0.4, 0.9)),
    ph.PointLight(position=(0.5, -2.0, 2.0)),
)
WITH_A_SIZE = {
    "square": ph.RectangleLight(PLACE, AIM, (0, 0, 1), 1.0, 1.0),
    "disk": ph.DiskLight(PLACE, AIM, 0.5),
    "sphere": ph.SphereLight(PLACE, 0.5),
}
WIDE_SUN = {"sun of 0.533°": ph.DirectionalLight(AIM, 0.533)}
V, H = np.arange(0.0, 91.0, 5.0), np.arange(0.0, 361.0, 15.0)
MEASURED = Photometry.of("C", V, H, np.cos(np.radians(V)) * (1.5 + np.cos(np.radians(H)))[:, None])


def compiled(arrays, lights, material, real=np.float32, planned=False, **model):
    """Return a call of the kernel, with planning only if `planned`; its attribute `plan` has the predicted cost."""
    scene = ph.Scene(lights, VIEWER, ph.LightModel(**model))
    points, normals = arrays
    out, given = ph.Shading(np.empty(points.shape, real)), Vertices(points, normals, material.maps)
    equation = given.equation(scene, material, None)

    def run():
        left, at = equation, given
        if planned:
            at = Vertices(points, normals, material.maps)
            left = ph.Plan.of(scene, material, at).equation
        assert kernel.evaluator()(points, normals, left, at.tints(left), out, channels=at.channels(left))

    run.plan = ph.Plan.of(scene, material, given)
    return run


def mapped(count):
    """Return materials by name, without and with maps."""
    numbers = np.random.default_rng(1).uniform(0.1, 1.0, (count, 3)).astype(np.float32)
    gloss, rough = 50 * numbers[:, 0].copy(), numbers[:, 1].copy()
    return {
        "no map": SHINY,
        "map of shininess": replace(SHINY, shininess=gloss),
        "map of specular": replace(SHINY, specular=numbers),
        "map of albedo": replace(SHINY, albedo=numbers),
        "all three": replace(SHINY, shininess=gloss, specular=numbers, albedo=numbers),
        "GGX": replace(DULL, reflectance=ph.GGX(0.4)),
        "GGX, map of roughness": replace(DULL, reflectance=ph.GGX(rough)),
    }


def workloads(count):
    """Return calls by name."""
    small, wide = vertices(count, np.float32), vertices(count)
    sun = ph.DirectionalLight(direction=(-1.0, -1.0, -2.0))
    spot = ph.SpotLight(position=PLACE, direction=AIM, cone_angle=40, exponent=8, attenuation=(1, 0.1, 0.05))
    lamp = ph.PhotometricLight(MEASURED, PLACE, AIM)
    missing = [ph.SpotLight(position=(0.0, 0.0, 50.0 + k), direction=(0, 0, 1), cone_angle=20) for k in range(60)]
    lit, scene = [*LAMPS, replace(LAMPS[0], position=(0.0, 3.0, 0.0))], ph.Scene(LAMPS, VIEWER)
    total = np.empty_like(small[0])
    calls = {
        "a + b": lambda: np.add(*small, out=total),
        "3 lamps, highlights": compiled(small, LAMPS, SHINY),
        "3 lamps, highlights, Blinn-Phong": compiled(small, LAMPS, SHINY, reflection="blinn-phong"),
        "3 lamps, highlights, 0-255": compiled(small, LAMPS, SHINY, np.uint8),
        "3 lamps, dull": compiled(small, LAMPS, DULL),
        "1 sun, dull": compiled(small, [sun], DULL),
        "ambient only": compiled(small, [], DULL),
        "1 lamp, highlights": compiled(small, LAMPS[:1], SHINY),
        "1 spot, highlights": compiled(small, [spot], SHINY),
        "1 spot, dull": compiled(small, [spot], DULL),
        "1 measured lamp, dull": compiled(small, [lamp], DULL),
    }
    for name, light in (("spot", spot), ("measured lamp", lamp)):
        calls[f"evaluate, 1 {name}"] = partial(evaluate, *small, ph.Scene([light], VIEWER), DULL, backend="numba")
    sized = WITH_A_SIZE | WIDE_SUN
    for looks, material in (("dull", DULL), ("highlights", SHINY)):
        calls |= {f"1 {name}, {looks}": compiled(small, [light], material) for name, light in sized.items()}
    calls["4 lamps, with plan"] = compiled(small, lit, SHINY, planned=True)
    calls["64 lights, 60 miss, with plan"] = compiled(small, [*lit, *missing], SHINY, planned=True)
    for name, material in mapped(count).items():
        calls[f"evaluate, {name}"] = partial(evaluate, *small, scene, material, backend="numba")
    return calls | {"3 lamps, highlights, float64": compiled(wide, LAMPS, SHINY, np.float64)}


def targets(least, book):
    """Return (description, measured, limit) for each target."""
    add, highlights, lamp = (least[name] for name in ("a + b", "3 lamps, highlights", "1 lamp, highlights"))
    bare, ggx = least["evaluate, no map"], least["evaluate, GGX"]
    return [
        ("3 lamps, highlights: textbook over it", book / highlights, ">= 60"),
        ("3 lamps, highlights: over a + b", highlights / add, "<= 3.5"),
        ("3 lamps, dull: over a + b", least["3 lamps, dull"] / add, "<= 1.5"),
        ("1 sun, dull: over a + b", least["1 sun, dull"] / add, "<= 0.8"),
        ("ambient only: over a + b", least["ambient only"] / add, "<= 0.5"),
        ("1 spot over 1 lamp", least["1 spot, highlights"] / lamp, "<= 1.6"),
        (
            "evaluate, 1 measured lamp over 1 spot",
            least["evaluate, 1 measured lamp"] / least["evaluate, 1 spot"],
            "<= 2",
        ),
        *((f"1 {name} over 1 lamp", least[f"1 {name}, highlights"] / lamp, "<= 12") for name in WITH_A_SIZE),
        ("float64: textbook over it", book / least["3 lamps, highlights, float64"], ">= 12"),
        ("0-255 over float32", least["3 lamps, highlights, 0-255"] / highlights, "<= 1"),
        ("map of shininess over none", least["evaluate, map of shininess"] / bare, "<= 1.5"),
        ("map of specular over none", least["evaluate, map of specular"] / bare, "<= 1.5"),
        ("map of roughness over none", least["evaluate, GGX, map of roughness"] / ggx, "<= 1.5"),
        ("64 lights over 4", least["64 lights, 60 miss, with plan"] / least["4 lamps, with plan"], "<= 1.3"),
    ]


def estimate(call):
    """Return a call's cost by `Plan.explain`, ns per vertex on one thread, which excludes writing the colours."""
    plan = getattr(call, "plan", None)
    return "" if plan is None else f"{sum(effect.nanoseconds(plan.effects[effect.name]) for effect in EFFECTS):.1f}"


def main(count: float = 1e6):
    count = int(count)
    calls, arrays, scene = workloads(count), vertices(count), ph.Scene(LAMPS, VIEWER)
    first = in_turns(calls, REPEATS)
    with threads.limited(1):
        alone = in_turns(calls, FEW_REPEATS, time.thread_time)
    book = in_turns({"it": lambda: textbook(*arrays, scene, SHINY)}, 3)["it"]
    least = {name: min(first[name], seconds) for name, seconds in in_turns(calls, REPEATS).items()}

    rows = []
    for name, seconds in {**least, "textbook, float64": book}.items():
        ratios = f"{seconds / least['a + b']:.2f}", f"{book / seconds:.1f}"
        single = f"{alone[name] / count * 1e9:.2f}" if name in alone else ""
        rows.append((name, f"{seconds * 1e3:.2f}", *ratios, single, estimate(calls.get(name))))
    headings = "workload", "ms", "over a + b", "textbook over it", "one thread, ns", "ns by plan"
    show(f"{count / 1e6:g} M vertices, least of {2 * REPEATS} repeats in turns", headings, rows)
    sooner = alone["3 lamps, highlights"] / least["3 lamps, highlights"]
    CONSOLE.print(f"3 lamps, highlights: two threads are {sooner:.2f} times as fast as one.")
    promises = []
    for what, measured, target in targets(least, book):
        sign, limit = target.split()
        met = measured >= float(limit) if sign == ">=" else measured <= float(limit)
        promises.append((what, f"{measured:.2f}", target, mark(met)))
    show("Targets", ("what", "measured", "target", "met"), promises)


if __name__ == "__main__":
    cyclopts.run(main)
