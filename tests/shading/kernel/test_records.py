"""What compiled code reads of an equation stands where its types say."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import pvphong as ph
from pvphong.shading.assembly import assemble
from pvphong.shading.kernel.records import SETTINGS, codes_of, records_of
from pvphong.shading.kernel.terms import TERM

toolkit = pytest.importorskip("pvphong.shading.kernel.toolkit", reason="Numba cannot be imported")

SUN = ph.DirectionalLight(direction=(0, 0, -2), diffuse=(0.5, 0.25, 1.0), intensity=3.0)
LAMP = ph.PointLight(position=(1, 2, 3), attenuation=(1, 0.5, 0.25), diffuse=0.5, ambient=(0.25, 0, 0))
MATRIX = np.array([[2.0, 1, 0, 5], [0, 2, 1, 6], [1, 0, 2, 7], [0, 0, 0, 1]])
DULL = ph.Material(diffuse=0.5)
STAGES = SimpleNamespace(toolkit=toolkit, light=lambda *_: 7, reflectance=lambda *_: 9)
FLAGS = {"is_wide": False, "has_albedo": False, "is_display": False, "channel_length": 11}


def read(lights, material=DULL, matrix=None):
    scene = ph.Scene(lights, ph.Viewer(position=(0, 4, 9)), ph.LightModel(ambient=0.5))
    equation = assemble(scene, material, matrix)
    codes = codes_of(equation, toolkit, "float32", has_albedo=False)
    records = records_of(equation, codes, STAGES, "float32", **FLAGS)
    settings = np.frombuffer(records.settings, SETTINGS)
    return equation, settings[0], np.frombuffer(records.terms, TERM), np.frombuffer(records.numbers)


def test_settings():
    shiny = ph.Material(ambient=(0.5, 0.25, 0), emission=(0, 0.125, 0), specular=0.5, shininess=20)
    equation, settings, _, _ = read([SUN, LAMP], shiny, MATRIX)
    assert settings["count"] == 2
    assert settings["channel_length"] == 11
    assert (settings["sky"], settings["tangents"], settings["takes_albedo"]) == (-1, -1, 1)
    flags = {name for name in SETTINGS.names if SETTINGS[name].kind == "b" and settings[name]}
    always = {"needs_normals", "needs_points", "needs_eye", "has_local_facing", "has_lobes_of_viewer"}
    assert flags == always | {"moves_points", "is_wide", "turns_normals"}
    np.testing.assert_array_equal(settings["eye"], (0, 4, 9))
    np.testing.assert_array_equal(settings["to_eye"], equation.to_eye)
    np.testing.assert_array_equal(settings["matrix"], MATRIX[:3])
    np.testing.assert_array_equal(settings["normal_matrix"], ph.normal_matrix(MATRIX))
    np.testing.assert_array_equal(settings["base"], (0.25, 0.25, 0))
    np.testing.assert_array_equal(settings["emission"], (0, 0.125, 0))
    assert (settings["w"], settings["exponent"], settings["low"], settings["high"]) == (1.0, 1.0, 0.0, 1.0)


def test_a_light_that_is_the_same_everywhere():
    _, settings, (sun,), _ = read([SUN])
    assert settings["is_sunlit"]
    assert (sun["is_even"], sun["wanted"], sun["visible"], sun["arrives"], sun["reflects"]) == (True, 1, -1, 0, 0)
    length = np.linalg.norm(sun["way"])
    np.testing.assert_array_equal(sun["way"] / length, (0, 0, 1))
    np.testing.assert_allclose(sun["colors"][0] * length, np.array([0.5, 0.25, 1.0]) * 0.5 * 3.0, rtol=1e-15)
    assert not sun["colors"][1:].any()


def test_a_light_with_a_stage():
    equation, settings, (_, lamp), numbers = read([SUN, LAMP], ph.Material(diffuse=0.5, specular=1.0, shininess=8))
    assert (lamp["is_even"], lamp["varies"], lamp["has_ambient"]) == (False, True, True)
    assert (lamp["wanted"], lamp["visible"], lamp["arrives"], lamp["reflects"]) == (3, -1, 7, 9)
    np.testing.assert_allclose(lamp["gain"] * lamp["colors"][:2], [[0.25] * 3, [0.5] * 3], rtol=1e-15)
    stage, sun, own = numbers.reshape(3, settings["stride"])
    np.testing.assert_array_equal(stage[:3], equation.reflectance.parameters())
    np.testing.assert_array_equal(own[:6], (1, 2, 3, 1, 0.5, 0.25))
    assert not sun.any()


@pytest.mark.parametrize(
    "light",
    [
        ph.PointLight(position=(2.0**101, 0, 0)),
        ph.PointLight(attenuation=(1, 2.0**-101, 0)),
        ph.SpotLight(attenuation=(1, 0, 2.0**101)),
    ],
    ids=lambda light: type(light).__name__,
)
def test_what_is_out_of_range_has_no_code(light):
    equation = assemble(ph.Scene([SUN, light], ph.Viewer()), ph.Material(), None)
    assert codes_of(equation, toolkit, "float32", has_albedo=False) is None
