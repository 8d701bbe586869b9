"""Every light and reflectance of the registries has a stage, and without it the reference gives the same colours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from strategies import LIGHT_SHAPES, REFLECTANCE_SHAPES, Dice, triple

import pvphong as ph
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.shading import kernel

pytest.importorskip("numba", reason="the extra `fast` is not installed")
pytestmark = pytest.mark.skipif(not kernel.is_available(), reason="Numba cannot run here")

COUNT = 300
STEPS = {"float32": 2.0**-24, "float64": 2.0**-53}


def light_of(kind, dice):
    aim = triple(-dice.unit_vector())
    return LIGHT_TYPES[kind](**LIGHT_SHAPES[kind](dice, triple(-3.0 * np.array(aim)), aim, 60.0), ambient=0.1)


def vertices_of(dice):
    random = np.random.default_rng(dice.getrandbits(32))
    points = random.uniform(-1.0, 1.0, (COUNT, 3))
    return points, points + 0.3 * random.normal(size=(COUNT, 3))


def lit(light, reflectance, seed, precision, shade_by="numba", albedo=1.0):
    points, normals = vertices_of(Dice(seed))
    fields = {"albedo": albedo, "tangents": points, "reflectance": reflectance}
    material = ph.Material(diffuse=0.5, specular=0.4, shininess=20, **fields)
    scene = ph.Scene([light], ph.Viewer((1, -2, 5)))
    return ph.evaluate(points, normals, scene, material, precision=precision, backend=shade_by).rgb


def test_a_light_whose_formula_is_not_marked_is_the_references(monkeypatch):
    light = light_of("spot", Dice(1))
    marked = light.placement
    monkeypatch.setattr(
        ph.SpotLight, "placement", property(lambda _: marked._replace(falloff=lambda *given: marked.falloff(*given)))
    )
    assert np.array_equal(lit(light, None, 1, "float32"), lit(light, None, 1, "float32", "numpy"))


@pytest.mark.parametrize("precision", STEPS)
@pytest.mark.parametrize("name", REFLECTANCES)
def test_a_reflectance_whose_formula_is_not_marked_is_the_references(name, precision, monkeypatch):
    albedo = np.random.default_rng(2).random((COUNT, 3))
    for seed in range(4):
        dice = Dice(seed)
        reflectance = REFLECTANCES[name](**REFLECTANCE_SHAPES[name](dice))
        light = light_of(("directional", "point")[seed % 2], dice)
        compiled = lit(light, reflectance, seed, precision, albedo=albedo)
        with monkeypatch.context() as patch:
            same = REFLECTANCES[name].factors
            patch.setattr(REFLECTANCES[name], "factors", staticmethod(lambda *given, same=same: same(*given)))
            plain = lit(light, reflectance, seed, precision, albedo=albedo)
        by_reference = lit(light, reflectance, seed, precision, "numpy", albedo)
        assert np.array_equal(plain, by_reference)
        allowed = 2 * (4 * np.sqrt(reflectance.sharpness) + 16) * STEPS[precision] * 2
        assert np.abs(compiled - by_reference).max() <= allowed


@pytest.mark.parametrize("kind", LIGHT_TYPES)
def test_a_stage_is_compiled_once_for_all_lights_that_have_it(kind):
    light = light_of(kind, Dice(1))
    lit(light, None, 1, "float32")
    before = len(kernel._library())
    lit(replace(light, diffuse=0.3).moved(lambda place: triple(2.0 * np.array(place))), None, 2, "float32")
    assert len(kernel._library()) == before
