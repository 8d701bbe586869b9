"""Reliability of reports on accuracy and time: `python bench_tradeoff.py [seconds] [case ...]`.

`test_measure.py` tests the report's budget and choice. This benchmark makes the report twice for each mesh, in separate
processes, and a third process measures the costs of effects through `pvphong.evaluate`. It checks two claims:

- If a variant is dominated in the first report, in time and in error, it is not faster than all dominating variants in
  the second, beyond the noise that the reports state. (Meshes that are refined for a time differ between reports.)
- The ledger's costs are within 25 % of the costs in separate runs with and without an effect, if both are known to half
  of that; others are in the noise. Both are fractions of `evaluate`'s time in the same process, so that they do not
  depend on the machine's speed at the time.
"""

import os
from dataclasses import replace
from functools import partial
from timeit import repeat

import cyclopts
import numpy as np
import pyvista as pv
from common import CONSOLE, alone, mark, show, torus
from pyvista import examples

import pvphong as ph
from pvphong.shading import kernel

TOLERANCE = 1 / 255
REPEATS = 31
ALLOWED = 0.25

SHINY = ph.Material(ambient=0.1, diffuse=(0.6, 0.5, 0.4), specular=0.4, shininess=30)
NEEDLE = replace(SHINY, shininess=5000)


def lit(mesh):
    """Return a scene with a far, a near and a weak lamp around a mesh; the plan can simplify each of them."""
    middle, size = np.array(mesh.center), mesh.length

    def at(*place):
        return middle + size * np.array(place)

    near = {"attenuation": (1, 0, 0.5 / size**2), "diffuse": (0.3, 0.4, 0.6)}
    lights = [
        ph.PointLight(position=at(400, 100, 300), diffuse=(1, 0.95, 0.85), name="sun"),
        ph.PointLight(position=at(0.3, -0.9, 0.6), **near, name="lamp"),
        ph.PointLight(position=at(0, 0, -3), diffuse=0.0005, name="glow"),
    ]
    return ph.Scene(lights, ph.Viewer(position=at(1.1, -0.8, 0.7), focal_point=middle, up=(0, 0, 1)))


CASES = {
    "airplane": (examples.load_airplane, SHINY),
    "ant": (examples.load_ant, SHINY),
    "torus, needle": (partial(torus, 101), NEEDLE),
    "sphere, 1M": (partial(pv.Sphere, theta_resolution=1001, phi_resolution=1001), SHINY),
}


def reported(case, seconds):
    """Return a report as plain numbers, with the time of `evaluate`."""
    make, material = CASES[case]
    mesh = make()
    scene = lit(mesh)
    report = ph.tradeoff(mesh, scene, material, tolerance=TOLERANCE, seconds=seconds)
    seconds = evaluations(mesh)
    whole = np.median([seconds(scene, material) for _ in range(REPEATS)])
    return report.to_dict() | {"whole": whole}


def dropped(scene, material):
    """Yield the name, scene and material without each effect of the ledger that a scene can switch off."""
    yield "specular", scene, replace(material, specular=0.0)
    yield "diffuse", scene, replace(material, diffuse=0.0)
    yield "lights", replace(scene, lights=[]), material
    yield "local viewer", replace(scene, light_model=replace(scene.light_model, local_viewer=False)), material
    even = [replace(light, attenuation=(1, 0, 0)) for light in scene.lights]
    yield "attenuation", replace(scene, lights=even), material
    for light in scene.lights:
        others = [other for other in scene.lights if other != light]
        yield f"light {light.name}", replace(scene, lights=others), material


def evaluations(mesh):
    """Return a function from a scene and a material to the seconds of `evaluate`, the least of several if short."""
    normals, in_a_row = mesh.phong.normals(), 1 if mesh.n_points > 100_000 else 7

    def seconds(*lighting):
        return min(repeat(lambda: ph.evaluate(mesh.points, normals, *lighting), number=1, repeat=in_a_row))

    return seconds


def costs(case):
    """Return quartiles of each effect's cost, as a fraction of `evaluate`'s time, from runs with and without it."""
    make, material = CASES[case]
    mesh = make()
    scene, seconds = lit(mesh), evaluations(mesh)
    result = {}
    for name, *without in dropped(scene, material):
        pairs = np.array([(seconds(scene, material), seconds(*without)) for _ in range(REPEATS + 1)])[1:]
        result[name] = np.percentile((pairs[:, 0] - pairs[:, 1]) / np.median(pairs[:, 0]), (25, 50, 75)).tolist()
    return result


def compile_kernel(case):
    """Compile code, which budgets exclude."""
    mesh = CASES[case][0]()
    for precision in ("float32", "float64"):
        some = mesh.points[:9], mesh.phong.normals()[:9]
        ph.evaluate(*some, lit(mesh), SHINY, precision=precision, backend="numba" if kernel.is_available() else "auto")


def seconds_of(row):
    """Return a row's median time."""
    return row["time"]["median"]


def is_better(one, other):
    """Return True if a row is at least as good as another of its kind in time and in error."""
    same, kind = one["kind"] == other["kind"] and one["name"] != other["name"], one["kind"].replace(" ", "_")
    return same and one[kind]["largest"] <= other[kind]["largest"] and seconds_of(one) <= seconds_of(other)


def ahead(first, second):
    """Return the dominated variant of the first report that is furthest ahead of all dominating ones in the second.

    The result is its name, its lead as a fraction of the time, and the noise: the largest that both reports state, or
    the largest quartile range of the variants.
    """
    again = {(row["name"], row["points"]): row for row in second["rows"]}
    found = []
    for row in first["rows"]:
        better = [again.get((other["name"], other["points"])) for other in first["rows"] if is_better(other, row)]
        rival = min(filter(None, better), key=seconds_of, default=None)
        it = again.get((row["name"], row["points"]))
        if it and rival and not row["on_front"]:
            spreads = [(end["time"]["high"] - end["time"]["low"]) / seconds_of(end) for end in (row, it, rival)]
            noise = max(first["noise"], second["noise"], *spreads)
            found.append((1.0 - seconds_of(it) / seconds_of(rival), noise, row["name"]))
    part, noise, name = max(found, key=lambda one: one[0] - one[1])
    return name, part, noise


def uncertainty(cost, repeats):
    """Return twice the standard error of a median cost, which is about IQR/√n, as a fraction of the cost."""
    low, middle, high = cost
    return 2.0 * (high - low) / repeats**0.5 / middle if middle > 0.0 else np.inf


def compared(report, own):
    """Yield effect, cost by the ledger, cost by separate runs, and True if both are accurate enough to compare."""
    for entry in report["ledger"]:
        if entry["cost"] and entry["effect"] in own:
            told = [entry["cost"][key] / report["whole"] for key in ("low", "median", "high")]
            apart = own[entry["effect"]]
            known = np.hypot(uncertainty(told, entry["cost"]["repeats"]), uncertainty(apart, REPEATS)) <= ALLOWED / 2
            yield entry["effect"], told, apart, known


def parts(cost):
    """Format median and quartiles."""
    low, middle, high = cost
    return f"{middle:.1%} ({low:.1%} – {high:.1%})"


def main(seconds: float = 20.0, *cases: str) -> int:
    """Run the benchmark; return 0 if all claims hold."""
    reports, ledgers, missing, held = [], [], [], True
    for name in cases or CASES:
        alone(compile_kernel, name)
        first, second = alone(reported, name, seconds), alone(reported, name, seconds)
        variant, part, noise = ahead(first, second)
        counts, noises = [row["time"]["repeats"] for row in first["rows"]], (first["noise"], second["noise"])
        said = ", ".join(f"{each:.1%}" for each in noises), f"{min(counts)} – {max(counts)}"
        over = f"{part:+.1%} of {noise:.1%}: {variant}"
        reports.append((name, first["chosen"]["at the vertices"], *said, over, mark(part <= noise)))
        held &= part <= noise
        for effect, told, apart, known in compared(first, alone(costs, name)):
            ratio = told[1] / apart[1] if apart[1] else np.nan
            agrees = abs(ratio - 1.0) <= ALLOWED
            held &= agrees or not known
            said = mark(agrees) if known else "in the noise"
            ledgers.append((name, effect, parts(told), parts(apart), f"{ratio:.2f}", said))
        missing += [(name, what, why) for what, why in first["left_out"].items()]
    headings = "mesh", "chosen", "noise", "repeats", "lead, of noise", "holds"
    show(f"Reports in {seconds:g} s, two for each mesh", headings, reports)
    headings = "mesh", "effect", "ledger", "separate runs", "ratio", "holds"
    show("Costs of effects as fractions of `evaluate`'s time: medians and quartiles", headings, ledgers)
    show("Left out", ("mesh", "what", "why"), missing)
    CONSOLE.print(f"{first['facts']['machine']}; load {os.getloadavg()[0]:.1f}; {first['facts']['date']}")
    return 0 if held else 1


if __name__ == "__main__":
    cyclopts.run(main)
