"""The fewest lights of a list that meet a tolerance."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from planted_lights import MATERIAL, VIEWER, bumpy

import pvphong as ph
from pvphong.studies.fitting.variation import sphere_directions

MESH = bumpy(3)
LAMPS = [ph.DirectionalLight(direction=-d, name=f"lamp {k}") for k, d in enumerate(sphere_directions(10))]


def lit(chosen, lights=LAMPS):
    scene = ph.Scene([replace(lights[k], intensity=i) for k, i in chosen.items()], VIEWER)
    return MESH.phong.shade(scene, MATERIAL, precision="float64")["phong"]


def names(fit):
    return {light.name for light in fit.scene.lights if light.on}


def test_three_of_ten_lamps_are_found_again():
    target = lit({1: 0.5, 4: 0.3, 8: 0.6})
    fit = MESH.phong.fit(ph.Scene(LAMPS, VIEWER), MATERIAL, target, "intensity", max_lights=5, tolerance=1e-5)
    assert names(fit) == {"lamp 1", "lamp 4", "lamp 8"}
    on = {light.name: light.intensity for light in fit.scene.lights if light.on}
    np.testing.assert_allclose([on["lamp 1"], on["lamp 4"], on["lamp 8"]], [0.5, 0.3, 0.6], rtol=1e-6)
    off = [light for light in fit.scene.lights if not light.on]
    assert [replace(light, on=True) for light in off] == [light for light in LAMPS if light.name not in names(fit)]
    assert fit.is_within


def test_the_choice_of_two_is_the_best_of_all_pairs():
    target = lit({0: 0.2, 3: 0.5, 6: 0.4, 7: 0.3})
    scene = ph.Scene(LAMPS, VIEWER)
    fit = MESH.phong.fit(scene, MATERIAL, target, "intensity", max_lights=2)
    assert len(names(fit)) == 2
    assert not fit.is_within
    errors = [
        MESH.phong.fit(ph.Scene(pair, VIEWER), MATERIAL, target, "intensity").error.rms
        for pair in combinations(LAMPS, 2)
    ]
    assert fit.error.rms == pytest.approx(min(errors), rel=1e-9)


def test_a_looser_tolerance_needs_fewer_lights():
    target = lit({0: 0.2, 3: 0.5, 6: 0.4, 7: 0.3})
    counts = []
    for tolerance in (0.2, 0.08, 0.02, 1e-6):
        how = {"max_lights": 10, "tolerance": tolerance}
        fit = MESH.phong.fit(ph.Scene(LAMPS, VIEWER), MATERIAL, target, "intensity", **how)
        assert fit.error.rms <= tolerance
        counts.append(len(names(fit)))
    assert counts == sorted(counts)
    assert counts[0] < counts[-1] == 4


def test_colors_of_the_chosen_lights_are_found_too_and_clamping_counts():
    lights = [replace(LAMPS[2], diffuse=(1.0, 0.5, 0.2), intensity=3.0), replace(LAMPS[5], intensity=0.4)]
    scene = ph.Scene(lights, VIEWER)
    target = MESH.phong.shade(scene, MATERIAL, precision="float64")["phong"]
    assert (target == 1.0).any()
    fit = MESH.phong.fit(ph.Scene(LAMPS, VIEWER), MATERIAL, target, "intensity diffuse", max_lights=4, tolerance=1e-5)
    assert names(fit) == {"lamp 2", "lamp 5"}
    warm = next(light for light in fit.scene.lights if light.name == "lamp 2")
    np.testing.assert_allclose(warm.diffuse, (1.0, 0.5, 0.2), rtol=1e-4)
    assert warm.intensity == pytest.approx(3.0, rel=1e-4)


def test_lights_of_which_something_would_be_left_are_not_chosen_among():
    lamps = [replace(lamp, specular="white") for lamp in LAMPS[:3]]
    allowed = "an intensity, or all colours, of each light if max_lights is given"
    with pytest.raises(ValueError, match=f"^vary must be {allowed}; got only some colours of 'lamp 0'"):
        MESH.phong.fit(ph.Scene(lamps, VIEWER), MATERIAL, lit({0: 0.5}), "diffuse", max_lights=1)
