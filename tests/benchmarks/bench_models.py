"""Cost of area lights and reflectances in compiled code, in float32, relative to Phong, Lambert and 64 nodes.

    python tests/benchmarks/bench_models.py

A sphere with a million vertices; processor time summed over all threads, the least of several rounds in turns, in one
run. Errors are relative to the float64 reference. The viewer is next to the lights, and opposite to them, where the
horizon cuts highlights.
"""

import time
from dataclasses import replace
from functools import partial

import numpy as np
from common import in_turns, show

import pvphong as ph

SIDE, ROUNDS, FEW = 1000, 9, 20000
PLACE, AIM = (1.5, -1.0, 2.0), (-1.5, 1.0, -2.0)
SIZED = {
    "sphere": ph.SphereLight(PLACE, 0.3, intensity=5),
    "square": ph.RectangleLight(PLACE, AIM, (0, 0, 1), 0.6, 0.6, intensity=5),
    "disk": ph.DiskLight(PLACE, AIM, 0.3, intensity=5),
    "sky": ph.EnvironmentLight(np.random.default_rng(0).uniform(0.0, 1.0, (8, 16, 3))),
}
POINT = ph.PointLight(PLACE, (0, 0, 1), intensity=5)
THREE = [ph.PointLight(at) for at in ((3, 1, 2), (-3, 1, 2), (0, 3, 3))]
VIEWS = {"from beside the lights": (1.5, -2.0, 3.0), "against the lights": (-2.5, 1.5, 1.0)}
MATT = ph.Material(diffuse=0.6)
GLOSSY = replace(MATT, specular=0.4, shininess=20)
HALF, SHINY = ph.Material(diffuse=0.5), ph.Material(diffuse=0.5, specular=0.5)
LAMBERT, PHONG = "Lambert", "Phong"
REFLECTANCES = {  # material, compared with, largest allowed ratio
    LAMBERT: (HALF, LAMBERT, None),
    PHONG: (replace(SHINY, shininess=20), PHONG, None),
    "Blinn-Phong": (replace(SHINY, reflectance=ph.BlinnPhong(80)), PHONG, None),
    "modified Phong": (replace(SHINY, reflectance=ph.ModifiedPhong(20)), PHONG, None),
    "metal": (ph.Material(diffuse=0.1, reflectance=ph.Metal((1.0, 0.78, 0.34), 20)), PHONG, 1.2),
    "Oren-Nayar": (replace(HALF, reflectance=ph.OrenNayar(25)), LAMBERT, 1.5),
    "retro": (replace(SHINY, reflectance=ph.Retro(20)), PHONG, None),
    "Ward": (replace(SHINY, reflectance=ph.Ward(0.1, 0.4)), PHONG, None),
    "GGX": (replace(HALF, reflectance=ph.GGX(0.3)), PHONG, 1.6),
    "PBR": (replace(HALF, reflectance=ph.PBR(0.0, 0.3)), PHONG, None),
}


def ball():
    """Return vertices of the unit sphere row by row, which are their normals too."""
    theta, phi = np.meshgrid(np.linspace(1e-3, np.pi - 1e-3, SIDE), np.linspace(0, 2 * np.pi, SIDE), indexing="ij")
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    return points.reshape(-1, 3).astype(np.float32)


def lit(points, lights, material, eye, **options):
    scene = ph.Scene(lights, ph.Viewer(eye), ph.LightModel(ambient=0.0))
    return ph.evaluate(points, points, scene, material, **({"backend": "numba"} | options)).rgb


def least(points, cases, eye):
    calls = {name: partial(lit, points, *case, eye) for name, case in cases.items()}
    return in_turns(calls, ROUNDS, time.process_time)


def lights_with_a_size(points, eye):
    cases = {"point, shininess 20": ([POINT], GLOSSY), "point, matt": ([POINT], MATT)}
    for kind, light in SIZED.items():
        cases[f"{kind}, matt"] = [light], MATT
        for power in (20, 1000):
            cases[f"{kind}, shininess {power}"] = [light], replace(GLOSSY, shininess=power)
        if kind != "sky":
            nodes = [replace(node, intensity=node.intensity * light.intensity) for node in light.nodes(64)]
            cases[f"{kind}, 64 nodes"] = nodes, GLOSSY
    seconds, some = least(points, cases, eye), points[:: len(points) // FEW]
    for name, (lights, material) in cases.items():
        whole = [SIZED[name.split(",")[0]]] if name.endswith("nodes") else lights
        exact = lit(some, whole, material, eye, precision="float64", backend="numpy")
        error = np.abs(lit(some, lights, material, eye) - exact).max()
        ratio = seconds[name] / seconds["point, shininess 20"]
        yield name, f"{1e3 * seconds[name]:.1f}", f"{ratio:.1f}", f"{error:.1e}"


def reflectances(points, eye):
    tangents = np.roll(points, 1, axis=1)
    cases = {name: (THREE, replace(material, tangents=tangents)) for name, (material, _, _) in REFLECTANCES.items()}
    seconds = least(points, cases, eye)
    for name, (_, beside, most) in REFLECTANCES.items():
        ratio = f"{seconds[name] / seconds[beside]:.2f} x {beside}"
        yield name, f"{1e3 * seconds[name]:.1f}", ratio, f"{most or ''}"


def main():
    points = ball()
    for where, eye in VIEWS.items():
        title, headings = (
            f"{len(points):,} vertices, seen {where}",
            ("light", "ms", "x a point with highlight", "error"),
        )
        show(title, headings, lights_with_a_size(points, eye))
    show("Three point lights", ("reflectance", "ms", "ratio", "at most"), reflectances(points, (0, 0, 5)))


if __name__ == "__main__":
    main()
