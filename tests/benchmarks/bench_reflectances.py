"""What reflectances cost in compiled code: a million vertices and three point lights, each beside Phong's or Lambert's.

    python tests/benchmarks/bench_reflectances.py

Processor time of all threads together, the least of some rounds in turns, in one run.
"""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial

import numpy as np
from common import least_in_turns

import pvphong as ph

COUNT, ROUNDS = 1_000_000, 25
SCENE = ph.Scene([ph.PointLight(at) for at in ((3, 1, 2), (-3, 1, 2), (0, 3, 3))], ph.Viewer((0, 0, 5)))
LAMBERT, PHONG = "Lambert", "Phong"
CASES = {
    LAMBERT: (ph.Material(diffuse=0.5), LAMBERT, None),
    PHONG: (ph.Material(diffuse=0.5, specular=0.5, shininess=20), PHONG, None),
    "Blinn-Phong": (ph.Material(diffuse=0.5, specular=0.5, reflectance=ph.BlinnPhong(80)), PHONG, None),
    "modified Phong": (ph.Material(diffuse=0.5, specular=0.5, reflectance=ph.ModifiedPhong(20)), PHONG, None),
    "metal": (ph.Material(diffuse=0.1, reflectance=ph.Metal((1.0, 0.78, 0.34), 20)), PHONG, 1.2),
    "Oren-Nayar": (ph.Material(diffuse=0.5, reflectance=ph.OrenNayar(25)), LAMBERT, 1.5),
    "retro": (ph.Material(diffuse=0.5, specular=0.5, reflectance=ph.Retro(20)), PHONG, None),
    "Ward": (ph.Material(diffuse=0.5, specular=0.5, reflectance=ph.Ward(0.1, 0.4)), PHONG, None),
    "GGX": (ph.Material(diffuse=0.5, reflectance=ph.GGX(0.3)), PHONG, 1.6),
    "PBR": (ph.Material(diffuse=0.5, reflectance=ph.PBR(0.0, 0.3)), PHONG, None),
}


def main() -> None:
    normals = np.random.default_rng(0).normal(size=(COUNT, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    tangents = np.roll(normals, 1, axis=1)

    def run(material: ph.Material) -> None:
        ph.evaluate(normals, normals, SCENE, replace(material, tangents=tangents), backend="numba")

    calls = {name: partial(run, material) for name, (material, _, _) in CASES.items()}
    seconds = least_in_turns(calls, ROUNDS, time.process_time)
    print(f"{COUNT:,} vertices, {len(SCENE.lights)} point lights, float32")
    for name, (_, beside, most) in CASES.items():
        asked = "" if most is None else f", at most {most} asked for"
        print(f"{name:15s} {1e3 * seconds[name]:6.2f} ms  {seconds[name] / seconds[beside]:5.2f} x {beside}{asked}")


if __name__ == "__main__":
    main()
