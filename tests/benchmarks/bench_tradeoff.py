"""Whether a report on accuracy and time can be relied on: `python bench_tradeoff.py [seconds]`.

For each mesh the report is made twice, each time in a process of its own, and a third process measures on its own,
through `pvphong.evaluate`, what effects cost. The colours of the report's choice are judged by exact arithmetic at
some vertices, the worst among them. A rung off the front must not get ahead of the front in the second report by more
than the noise that the first one states; the ledger's costs must be those of the runs with and without the effect.
"""

import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pyvista as pv
from pyvista import examples
from rich.console import Console
from rich.table import Table

import pvphong as ph

sys.path.append(str(Path(__file__).parent.parent))

TOLERANCE = 1 / 255
JUDGED = 200
REPEATS = 31
ALLOWED = 0.25

SHINY = ph.Material(ambient=0.1, diffuse=(0.6, 0.5, 0.4), specular=0.4, shininess=30)
NEEDLE = replace(SHINY, shininess=5000)


def lit(mesh):
    """A far lamp, a near one and a weak one around a mesh, and an eye; the plan can leave out something of each."""
    middle, size = np.array(mesh.center), mesh.length
    return ph.Scene(
        lights=[
            ph.PointLight(position=middle + size * np.array([400, 100, 300]), diffuse=(1, 0.95, 0.85), name="sun"),
            ph.PointLight(
                position=middle + size * np.array([0.3, -0.9, 0.6]),
                attenuation=(1, 0, 0.5 / size**2),
                diffuse=(0.3, 0.4, 0.6),
                name="lamp",
            ),
            ph.PointLight(position=middle + size * np.array([0, 0, -3]), diffuse=0.0005, name="glow"),
        ],
        viewer=ph.Viewer(position=middle + size * np.array([1.1, -0.8, 0.7]), focal_point=middle, up=(0, 0, 1)),
    )


def torus():
    """Closed, 10 000 points."""
    mesh = pv.ParametricTorus(u_res=101, v_res=101, w_res=101).clean().triangulate()
    mesh.clear_data()
    return mesh


CASES = {
    "airplane": (examples.load_airplane, SHINY),
    "ant": (examples.load_ant, SHINY),
    "torus, needle": (torus, NEEDLE),
    "sphere, 1M": (lambda: pv.Sphere(theta_resolution=1001, phi_resolution=1001), SHINY),
}


def reported(case, seconds):
    """A report as plain numbers, what it took, and how far its choice is from exact colours."""
    make, material = CASES[case]
    mesh = make()
    scene = lit(mesh)
    start = time.perf_counter()
    report = ph.tradeoff(mesh, scene, material, tolerance=TOLERANCE, seconds=seconds)
    took = time.perf_counter() - start
    return report.to_dict() | {"took": took, "off": off_exact(report, scene, material), "shown": str(report)}


def off_exact(report, scene, material):
    """The largest error of the chosen colours, in 80 digits."""
    import oracle

    points, normals = report.surface.points, report.surface.point_data.active_normals
    if normals is None:
        normals = report.surface.phong.normals()
    some = np.random.default_rng(1).choice(len(points), JUDGED, replace=False)
    rows = np.union1d(some, [index for index, _ in report.worst()])
    truth = oracle.as_array(oracle.shade(points[rows], normals[rows], scene, material), "color")
    return float(np.abs(report.chosen_colors[rows] - truth).max())


def dropped(scene, material):
    """For what the ledger drops and a scene can say: its name there, and the scene and material without it."""
    yield "specular", scene, replace(material, specular=0.0)
    yield "diffuse", scene, replace(material, diffuse=0.0)
    yield "lights", replace(scene, lights=[]), material
    yield "local viewer", replace(scene, light_model=replace(scene.light_model, local_viewer=False)), material
    even = [replace(light, attenuation=(1, 0, 0)) for light in scene.lights]
    yield "attenuation", replace(scene, lights=even), material
    for light in scene.lights:
        yield f"light {light.name}", replace(scene, lights=[other for other in scene.lights if other != light]), material


def costs(case):
    """Quartiles of the seconds that `evaluate` takes longer with each effect than without it, run by run in turns."""
    make, material = CASES[case]
    mesh = make()
    scene, normals = lit(mesh), mesh.phong.normals()
    in_a_row = 1 if mesh.n_points > 100_000 else 7

    def seconds(some, how):
        least = np.inf
        for _ in range(in_a_row):
            start = time.perf_counter()
            ph.evaluate(mesh.points, normals, some, how)
            least = min(least, time.perf_counter() - start)
        return least

    result = {}
    for name, *without in dropped(scene, material):
        differences = [seconds(scene, material) - seconds(*without) for _ in range(REPEATS + 1)]
        result[name] = np.percentile(differences[1:], (25, 50, 75)).tolist()
    return result


def alone(function, *arguments):
    """What a function gives in a process of its own."""
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def error_of(row):
    """The error of the row's own kind."""
    return row[row["kind"].replace(" ", "_")]["largest"]


def ahead(first, second):
    """By how much rungs off the first report's front are ahead of it in the second, as a part of its time."""
    again = {row["name"]: row for row in second["rows"]}
    front = [again[row["name"]] for row in first["rows"] if row["on_front"] and row["name"] in again]
    result = {}
    for row in first["rows"]:
        if row["on_front"] or row["name"] not in again:
            continue
        it = again[row["name"]]
        rivals = [
            other["time"]["median"]
            for other in front
            if other["kind"] == it["kind"] and error_of(other) <= error_of(it)
        ]
        if rivals:
            result[row["name"]] = 1.0 - it["time"]["median"] / min(rivals)
    return result
