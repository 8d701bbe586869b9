"""VTK's choice of tier, read off what it draws, and scenes said in its terms."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading.equation import vtk_tier
from pvphong.vtk.oracle import vtk_shade
from pvphong.vtk.scenes import InexpressibleError, in_vtk_terms, refuse_inexpressible

SUN = DirectionalLight(direction=(0.0, 1.0, -1.0))
HEADLIGHT = DirectionalLight(frame="headlight")
RIDER = DirectionalLight(direction=(0.3, 0.0, -1.0), frame="camera")
BULB = PointLight(position=(3.0, 3.0, 3.0))
KINDS = (SUN, HEADLIGHT, RIDER, BULB)


def drawn_tier(lights: list) -> str:
    """Read off one vertex that faces away from all lights, under a diffuse that magnifies VTK's floors.

    Only the first tier has a floor, of 1e-6, under the diffuse factor; only without light is there full diffuse.
    """
    mesh = pv.PolyData([[0.0, 0.0, 0.0]])
    mesh.point_data.active_normals = [[0.0, 0.0, -1.0]]
    material = Material(ambient=0.0, diffuse=1e6)
    color = vtk_shade(mesh, lights, material, Viewer(position=(0.0, 0.0, 5.0)))[0, 0]
    return {0.0: "lit", 1.0: "headlight", 1e6: "unlit"}[round(float(color), 3)]


@pytest.mark.parametrize("on", list(itertools.product((True, False), repeat=2)))
@pytest.mark.parametrize("kinds", list(itertools.product(range(4), repeat=2)))
def test_the_tier_is_the_one_that_vtk_draws(kinds, on):
    lights = [replace(KINDS[kind], on=shines) for kind, shines in zip(kinds, on, strict=True)]
    assert drawn_tier(lights) == {0: "unlit", 1: "headlight"}.get(vtk_tier(lights), "lit")


@pytest.mark.parametrize(
    ("lights", "tier"),
    [([HEADLIGHT, HEADLIGHT], 2), ([SUN, BULB], 3), ([HEADLIGHT, replace(BULB, on=False)], 3)],
)
def test_a_second_light_and_one_with_a_position_change_the_tier(lights, tier):
    assert vtk_tier(lights) == tier


# --- terms --------------------------------------------------------------------------------------------------------

PLASTIC = Material(ambient=(0.1, 0.2, 0.3), diffuse=0.5, specular=0.4, shininess=20.0, emission=(0.0, 0.1, 0.0))
EYE = Viewer(position=(2.0, 0.0, 0.0), up=(0.0, 0.0, 1.0))
MIDDLE, SIZE = np.array([0.5, 0.0, 0.0]), 4.0


def test_vtk_s_convention_is_said_as_it_is():
    off = replace(SUN, on=False)
    odd = SpotLight(cone_angle=90.0, ambient=0.3, specular=0.2)
    terms = in_vtk_terms(Scene([off, odd], EYE, LightModel.vtk()), PLASTIC, MIDDLE, SIZE)
    assert (terms.lights, terms.viewer, terms.tier) == ((off, odd), EYE, 3)
    assert terms.material == replace(PLASTIC, ambient=(0.1, 0.2 + 0.1, 0.3), emission=0.0)
    assert terms.conversions == ("emission as a part of VTK's ambient",)


def test_ambient_light_is_multiplied_in():
    scene = Scene([SUN], EYE, LightModel(ambient=(1.0, 0.5, 0.0)))
    terms = in_vtk_terms(scene, PLASTIC, MIDDLE, SIZE)
    assert terms.material.ambient == (0.1, 0.5 * 0.2 + 0.1, 0.0)
    assert terms.material.emission == 0.0
    assert terms.lights == (SUN,)


def test_lights_that_are_off_are_left_out_of_a_standard_scene():
    terms = in_vtk_terms(Scene([HEADLIGHT, replace(BULB, on=False), SUN], EYE), PLASTIC, MIDDLE, SIZE)
    assert terms.lights == (HEADLIGHT, SUN)
    assert terms.tier == 2


def test_a_black_light_lifts_the_tier_where_vtk_would_simplify():
    for lights in ([], [HEADLIGHT]):
        terms = in_vtk_terms(Scene(lights, EYE), PLASTIC, MIDDLE, SIZE)
        assert terms.lights[:-1] == tuple(lights)
        assert terms.lights[-1].diffuse == 0.0
        assert terms.tier == 2


def test_an_eye_at_infinity_stands_far_back_on_its_axis():
    for scene in (Scene([RIDER], EYE, LightModel(local_viewer=False)), Scene([RIDER], replace(EYE, parallel=True))):
        terms = in_vtk_terms(scene, PLASTIC, MIDDLE, SIZE)
        np.testing.assert_allclose(terms.viewer.position, MIDDLE + np.array([4e8, 0.0, 0.0]))
        assert not terms.viewer.parallel
        assert terms.lights == (RIDER.in_world(EYE),)  # it rides with the eye of the scene
    matte = replace(PLASTIC, specular=0.0)  # nothing depends on the eye
    assert in_vtk_terms(Scene([BULB], EYE, LightModel(local_viewer=False)), matte, MIDDLE, SIZE).viewer == EYE


def test_only_a_lone_headlight_of_blinn_phong_at_infinity_is_left_to_the_first_tier():
    opengl = LightModel.opengl()
    assert in_vtk_terms(Scene([HEADLIGHT], EYE, opengl), PLASTIC, MIDDLE, SIZE).tier == 1
    assert in_vtk_terms(Scene([HEADLIGHT], EYE, replace(opengl, reflection="phong")), PLASTIC, MIDDLE, SIZE).tier == 2
    for light in (SUN, RIDER):
        with pytest.raises(InexpressibleError, match="Blinn-Phong"):
            refuse_inexpressible(Scene([light], EYE, opengl), replace(PLASTIC, emission=0.0), None)
    local = replace(opengl, local_viewer=True)
    assert in_vtk_terms(Scene([HEADLIGHT], EYE, local), replace(PLASTIC, specular=0.0), MIDDLE, SIZE).tier == 2


def test_a_half_space_is_narrowed_by_less_than_float32_shows():
    half = SpotLight(cone_angle=90.0)
    (narrowed,) = in_vtk_terms(Scene([half], EYE), PLASTIC, MIDDLE, SIZE).lights
    assert 90.0 - 1e-5 < narrowed.cone_angle < 90.0
    assert np.float32(narrowed.cone_angle) < np.float32(90.0)


def test_the_nearest_to_blinn_phong_and_to_powers_beyond_vtks_is_of_phong_with_a_power_that_it_has():
    spot = SpotLight(exponent=200.0)
    scene = Scene([spot], EYE, LightModel(reflection="blinn-phong"))
    for power, nearest in ((20.0, 5.0), (1000.0, 128.0)):
        with pytest.raises(InexpressibleError) as error:
            refuse_inexpressible(scene, replace(PLASTIC, shininess=power), None)
        assert error.value.material == replace(PLASTIC, shininess=nearest)
        assert error.value.scene == Scene([replace(spot, exponent=128.0)], EYE, LightModel())


def test_the_nearest_light_has_highlights_of_its_diffuse_colour_and_no_ambient_of_its_own():
    scene = Scene([replace(SUN, ambient=0.25, intensity=2.0), replace(BULB, ambient=0.5, specular="red")], EYE)
    with pytest.raises(InexpressibleError) as error:
        refuse_inexpressible(scene, PLASTIC, None)
    assert error.value.scene.lights == (replace(SUN, intensity=2.0, ambient=0.0), replace(BULB, ambient=0.0))
    assert error.value.scene.light_model.ambient == (0.7, 0.7, 0.7)  # 0.2, and that of a light that is even
