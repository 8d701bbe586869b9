"""Whether a report on accuracy and time can be relied on: `python bench_tradeoff.py [seconds] [case ...]`.

`test_measure.py` holds its budget and its choice. Here, for each mesh the report is made twice, each time in a process
of its own, and a third process measures through `pvphong.evaluate` what effects cost. Shown is that

- no variant that others were better than in the first report, in time and in error, is faster than all of them in the
  second, by more than the noise that the reports state. (Meshes that are refined for a time are other meshes.)
- the ledger's costs are within 25 % of those of separate runs with and without an effect, where that is known to half
  of it; others are in the noise. Both are parts of what `evaluate` takes in the same process, so that a machine that
  was slower meanwhile does not count.
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
    """A far lamp, a near one and a weak one around a mesh, and an eye; the plan can leave out something of each."""
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
    """A report as plain numbers, and what `evaluate` takes."""
    make, material = CASES[case]
    mesh = make()
    scene = lit(mesh)
    report = ph.tradeoff(mesh, scene, material, tolerance=TOLERANCE, seconds=seconds)
    seconds = evaluations(mesh)
    whole = np.median([seconds(scene, material) for _ in range(REPEATS)])
    return report.to_dict() | {"whole": whole}


def dropped(scene, material):
    """For what the ledger drops and a scene can say: its name there, and the scene and material without it."""
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
    """A function from a scene and a material to the seconds that `evaluate` takes: the least of a few where short."""
    normals, in_a_row = mesh.phong.normals(), 1 if mesh.n_points > 100_000 else 7

    def seconds(*lighting):
        return min(repeat(lambda: ph.evaluate(mesh.points, normals, *lighting), number=1, repeat=in_a_row))

    return seconds


def costs(case):
    """Quartiles of what `evaluate` takes longer with each effect than without it, as parts of its time, in turns."""
    make, material = CASES[case]
    mesh = make()
    scene, seconds = lit(mesh), evaluations(mesh)
    result = {}
    for name, *without in dropped(scene, material):
        pairs = np.array([(seconds(scene, material), seconds(*without)) for _ in range(REPEATS + 1)])[1:]
        result[name] = np.percentile((pairs[:, 0] - pairs[:, 1]) / np.median(pairs[:, 0]), (25, 50, 75)).tolist()
    return result


def compile_kernel(case):
    """What budgets do not count."""
    mesh = CASES[case][0]()
    for precision in ("float32", "float64"):
        some = mesh.points[:9], mesh.phong.normals()[:9]
        ph.evaluate(*some, lit(mesh), SHINY, precision=precision, backend="numba" if kernel.is_available() else "auto")


def seconds_of(row):
    """Its median time."""
    return row["time"]["median"]


def is_better(one, other):
    """Whether a row is as good as another of its kind in time and in error."""
    same, kind = one["kind"] == other["kind"] and one["name"] != other["name"], one["kind"].replace(" ", "_")
    return same and one[kind]["largest"] <= other[kind]["largest"] and seconds_of(one) <= seconds_of(other)


def ahead(first, second):
    """The variant off the first report's front that beats, in the second, all better ones by most of their time.

    Gives its name, by which part, and the noise: the most of what both reports state, of both variants' quartiles too.
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
    """Twice the standard error of a median cost, about IQR/√n each, as a part of it."""
    low, middle, high = cost
    return 2.0 * (high - low) / repeats**0.5 / middle if middle > 0.0 else np.inf


def compared(report, own):
    """Effect, cost by the ledger, cost by separate runs, and whether both are known well enough to be compared."""
    for entry in report["ledger"]:
        if entry["cost"] and entry["effect"] in own:
            told = [entry["cost"][key] / report["whole"] for key in ("low", "median", "high")]
            apart = own[entry["effect"]]
            known = np.hypot(uncertainty(told, entry["cost"]["repeats"]), uncertainty(apart, REPEATS)) <= ALLOWED / 2
            yield entry["effect"], told, apart, known


def parts(cost):
    """Median and quartiles."""
    low, middle, high = cost
    return f"{middle:.1%} ({low:.1%} – {high:.1%})"


def main(seconds: float = 20.0, *cases: str) -> int:
    """Measure; 0 if all that is claimed holds."""
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
    headings = "mesh", "chosen", "noise", "repeats", "ahead, of noise", "holds"
    show(f"Reports in {seconds:g} s, each made twice", headings, reports)
    headings = "mesh", "effect", "ledger", "separate runs", "ratio", "holds"
    show("What effects cost, of `evaluate`'s time: medians and quartiles", headings, ledgers)
    show("Left out", ("mesh", "what", "why"), missing)
    CONSOLE.print(f"{first['facts']['machine']}; load {os.getloadavg()[0]:.1f}; {first['facts']['date']}")
    return 0 if held else 1


if __name__ == "__main__":
    cyclopts.run(main)
