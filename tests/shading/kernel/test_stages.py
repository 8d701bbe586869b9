"""Stages are compiled once, and the reference runs without a stage; optics/reflectances tests that both agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from strategies import LIGHT_SHAPES, REFLECTANCE_SHAPES, Dice, triple

import pvphong as ph
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.shading import kernel


def light_of(kind, dice):
    aim = triple(-dice.unit_vector())
    return LIGHT_TYPES[kind](**LIGHT_SHAPES[kind](dice, triple(-3.0 * np.array(aim)), aim, 60.0), ambient=0.1)


def lit(light, reflectance, seed, backend="numba"):
    random = np.random.default_rng(seed)
    points = random.uniform(-1.0, 1.0, (300, 3))
    normals = points + 0.3 * random.normal(size=(300, 3))
    material = ph.Material(diffuse=0.5, specular=0.4, shininess=20, tangents=points, reflectance=reflectance)
    scene = ph.Scene([light], ph.Viewer((1, -2, 5)))
    return ph.evaluate(points, normals, scene, material, backend=backend).rgb


def test_a_light_whose_formula_is_not_marked_is_the_references(monkeypatch):
    light = light_of("spot", Dice(1))
    marked = light.placement._replace(falloff=lambda *given: light.placement.falloff(*given))
    monkeypatch.setattr(ph.SpotLight, "placement", property(lambda _: marked))
    assert np.array_equal(lit(light, None, 1), lit(light, None, 1, "numpy"))


@pytest.mark.parametrize("name", REFLECTANCES)
def test_a_reflectance_whose_formula_is_not_marked_is_the_references(name, monkeypatch):
    reflectance, light = REFLECTANCES[name](**REFLECTANCE_SHAPES[name](Dice(1))), light_of("point", Dice(1))
    marked = reflectance.factors
    monkeypatch.setattr(REFLECTANCES[name], "factors", staticmethod(lambda *given: marked(*given)))
    assert np.array_equal(lit(light, reflectance, 1), lit(light, reflectance, 1, "numpy"))


@pytest.mark.parametrize("kind", LIGHT_TYPES)
def test_a_stage_is_compiled_once_for_all_lights_that_have_it(kind):
    light = light_of(kind, Dice(1))
    lit(light, None, 1)
    before = len(kernel._library())
    lit(replace(light, diffuse=0.3).moved(lambda place: triple(2.0 * np.array(place))), None, 2)
    assert len(kernel._library()) == before
