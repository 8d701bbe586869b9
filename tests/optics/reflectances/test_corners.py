"""Reflectances against their formulas in 50 digits, at difficult angles, in both evaluators and both precisions."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from reflectance_oracle import FORMULAS, Corner, ctx

from pvphong import LightModel, Material, PointLight, Scene, Viewer, evaluate
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.shading import kernel

SHAPES = {
    "phong": [{"shininess": s} for s in (0.0, 3.0, 1e6)],
    "blinn-phong": [{"shininess": s} for s in (0.0, 3.0, 1e6)],
    "modified-phong": [{"shininess": s} for s in (0.0, 3.0, 1e6)],
    "metal": [{"color": 0.3, "shininess": s} for s in (3.0, 1e6)],
    "oren-nayar": [{"sigma": s} for s in (0.0, 25.0, 90.0)],
    "retro": [{"shininess": s} for s in (0.0, 3.0, 1e6)],
    "ward": [{"alpha_x": a, "alpha_y": b} for a, b in ((1e-6, 1e-6), (1e-3, 1.0), (0.3, 0.05), (1.0, 1.0))],
    "ggx": [{"roughness": r, "f0": 0.3} for r in (1e-6, 0.02, 0.3, 1.0)],
    "pbr": [{"roughness": r, "metallic": m} for r, m in ((1e-6, 1.0), (0.02, 0.0), (0.3, 0.4), (1.0, 0.7), (0.1, 0.8))],
}
SPECULAR = 0.5
STEPS = {"float32": 2.0**-24, "float64": 2.0**-53}
BACKENDS = ["numpy", *(["numba"] if kernel.is_available() else [])]


def corners():
    """Yield normal, light and eye, exact in float32: at the peak, near it, grazing, opposite, behind."""
    up, eye, mirrored = np.array([0, 0, 1.0]), np.array([3.0, 0, 4.0]), np.array([-3.0, 0, 4.0])
    yield up, mirrored, eye
    yield up, eye, eye
    yield up, up, up
    for tilt in (2.0**-20, 2.0**-12, 2.0**-6, 0.25):
        yield up + np.array([tilt, 0, 0]), mirrored, eye
        yield up + np.array([0, tilt, 0]), mirrored, eye
        yield up, np.array([-1, 0, tilt]), np.array([1, 0, tilt])
        yield up, np.array([-1, 0, tilt]), eye
        yield up, eye, np.array([1, 0.5, tilt])
        yield up, eye, np.array([1, 0.5, -tilt])
        yield up, np.array([1, 0.5, -tilt]), eye
        yield up, eye, -eye + [0, 0, 2 * tilt]
    yield up, np.array([1.0, 0, 0.5]), np.array([-2.0, 0, -1.0])


NORMALS, LIGHTS, EYES = (np.array(part, np.float32) for part in zip(*corners(), strict=True))


def diffuse_of(shape):
    """Return 0.005 for the partial metal, so that its F₉₀ is below 1, else 0.6."""
    return 0.005 if shape.get("metallic") == 0.8 else 0.6


def judged(name, shape):
    """Return the reflectance, its colour from 50 digits, and its sensitivity to the rounding of directions."""
    reflectance = REFLECTANCES[name](**shape)
    found = [Corner(*triple) for triple in zip(NORMALS, LIGHTS, EYES, strict=True)]
    exact = np.array(
        [float(FORMULAS[name](reflectance, c, ctx.mpf(diffuse_of(shape)), ctx.mpf(SPECULAR))) for c in found]
    )
    return reflectance, exact, conditions(found, reflectance.sharpness)


def conditions(found, sharpness):
    """Return the allowed error in roundings of directions: h is more sensitive the closer l and v are to opposite."""
    grazing = np.array([float(min(abs(c.n_l), abs(c.n_v))) for c in found])
    middle = np.array([float(abs(c.h_l)) for c in found])
    steepness = 4 * math.sqrt(sharpness)
    return 16 + steepness + 4 / np.maximum(grazing, 2.0**-60) + (steepness + 4) / np.maximum(middle, 2.0**-60)


def evaluated(reflectance, diffuse, precision, backend):
    """Evaluate one light at a time, because corners differ in all three vectors."""
    material = Material(ambient=0, diffuse=diffuse, specular=SPECULAR, reflectance=reflectance)
    how = {"precision": precision, "backend": backend}
    model, point = LightModel(ambient=0, clamp=False), np.zeros((1, 3), np.float32)
    found = []
    for n, l, v in zip(NORMALS, LIGHTS, EYES, strict=True):
        scene = Scene([PointLight(l)], Viewer(v, (v + np.eye(3)[0]).tolist()), model)
        found.append(evaluate(point, n[None], scene, replace(material, tangents=[(1, 0, 0)]), **how).rgb[0, 0])
    return np.array(found)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("precision", STEPS)
@pytest.mark.parametrize(("name", "shape"), [(name, shape) for name in REFLECTANCES for shape in SHAPES[name]])
def test_it_is_its_formula_to_the_roundings_that_its_sharpness_costs(name, shape, precision, backend):
    reflectance, exact, roundings = judged(name, shape)
    got = evaluated(reflectance, diffuse_of(shape), precision, backend)
    relative = roundings * STEPS[precision]
    assert np.isfinite(got).all()
    known = relative < 0.1
    assert (np.abs(got - exact) <= relative * np.maximum(exact, 1.0))[known].all()
    assert known.sum() > 20 or math.sqrt(reflectance.sharpness) * STEPS[precision] > 0.02
