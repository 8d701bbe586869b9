"""Compiled code sums components and each light's contribution in one pass, as the readable evaluator does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import pvphong as ph

COUNT = 1500  # more than two of the kernel's blocks, and not a multiple of their size
RANDOM = np.random.default_rng(11)
POINTS = RANDOM.normal(size=(COUNT, 3))
NORMALS = POINTS + 0.3 * RANDOM.normal(size=(COUNT, 3))
COLORS = RANDOM.random((COUNT, 3))
NUMBERS = RANDOM.random(COUNT)

SUN = ph.DirectionalLight(direction=(-1, -1, -2), diffuse=(1, 0.9, 0.7), ambient=0.1)
LAMP = ph.PointLight(position=(2, -1, 3), attenuation=(1, 0.1, 0.02), diffuse=(0.5, 0.7, 1))
SPOT = ph.SpotLight(position=(1, 1, 4), direction=(-1, -1, -4), cone_angle=20, exponent=9, ambient=0.2)
BALL = ph.SphereLight(position=(-2, 1, 3), radius=0.5)
SKY = ph.EnvironmentLight()
OFF = replace(LAMP, on=False)
SHINY = ph.Material(ambient=0.3, diffuse=(0.4, 0.5, 0.6), specular=(0.5, 0.4, 0.3), shininess=25, emission=0.05)
VIEWER = ph.Viewer(position=(0, -3, 4))

LIGHTS = {
    "none": [],
    "one that is off": [OFF],
    "a sun": [SUN],
    "of all kinds": [SUN, OFF, LAMP, SPOT, BALL, SKY, ph.DirectionalLight(frame="headlight")],
}
MATERIALS = {
    "plain": SHINY,
    "dull": replace(SHINY, specular=0.0, emission=0.0),
    "black": ph.Material(ambient=0.0, diffuse=0.0, specular=0.0),
    "albedo": replace(SHINY, albedo=COLORS),
    "emission alone a map": replace(SHINY, emission=COLORS),
    "all maps": replace(
        SHINY, albedo=COLORS, diffuse=NUMBERS, specular=COLORS[::-1], emission=COLORS, shininess=9 * NUMBERS
    ),
    "metallic a map": replace(SHINY, albedo=COLORS, reflectance=ph.PBR(metallic=NUMBERS, roughness=0.4)),
}
MODELS = {
    "": ph.LightModel(ambient=0.2),
    "two-sided, unclamped": ph.LightModel(two_sided=True, clamp=False),
    "shadows": ph.LightModel(ambient=0.2, shadows=True, ambient_occlusion=True),
}
ARRAYS = "rgb", "ambient", "diffuse", "specular", "emission", "base", "per_light"


def lit(lights, material, model, precision="float64", backend="numba", *, components=True, points=POINTS):
    seen = RANDOM_SEEN[: len(lights) + 1] if model.shadows else None
    scene = ph.Scene(lights, VIEWER, model)
    how = {"precision": precision, "backend": backend, "components": components, "visibility": seen}
    return ph.evaluate(points, NORMALS, scene, material, **how)


RANDOM_SEEN = RANDOM.random((10, COUNT))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("lights", LIGHTS)
def test_each_array_is_the_readable_evaluators(lights, material, model):
    given = LIGHTS[lights], MATERIALS[material], MODELS[model]
    compiled, readable = (lit(*given, backend=backend) for backend in ("numba", "numpy"))
    for name in ARRAYS:
        np.testing.assert_allclose(getattr(compiled, name), getattr(readable, name), rtol=0, atol=1e-12, err_msg=name)


@pytest.mark.parametrize("material", MATERIALS)
def test_colours_are_those_without_components_but_for_rounding(material):
    given = LIGHTS["of all kinds"], MATERIALS[material], MODELS[""], "float32"
    apart, together = lit(*given), lit(*given, components=False)
    np.testing.assert_allclose(apart.rgb, together.rgb, rtol=0, atol=4e-6)


@pytest.mark.parametrize("material", ["plain", "all maps"])
def test_vertices_that_are_declined_have_the_readable_evaluators_bits(material):
    declined = [3, 127, 128, COUNT - 1]
    points = POINTS.copy()
    points[declined] = LAMP.position, VIEWER.position, (0, np.nan, 0), (1e300, 0, 0)
    given = LIGHTS["of all kinds"], MATERIALS[material], MODELS[""], "float32"
    compiled, usual, readable = lit(*given, points=points), lit(*given), lit(*given, "numpy", points=points)
    others = np.delete(np.arange(COUNT), declined)
    for name in ARRAYS:
        found = getattr(compiled, name)
        np.testing.assert_array_equal(found[..., declined, :], getattr(readable, name)[..., declined, :], err_msg=name)
        np.testing.assert_array_equal(found[..., others, :], getattr(usual, name)[..., others, :], err_msg=name)


def test_it_is_compiled_code_that_ran(monkeypatch):
    monkeypatch.setattr("pvphong.shading.reference.shade", None)
    assert lit(LIGHTS["of all kinds"], SHINY, MODELS[""]).per_light.any()
