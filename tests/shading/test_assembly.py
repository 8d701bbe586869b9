"""From a scene and a material to the equation, in both conventions."""

import dataclasses

import numpy as np
import pytest

from pvphong.base.formulas import BRIGHTEST
from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading.equation import assemble

MATERIAL = Material(ambient=(0.1, 0.2, 0.3), diffuse=0.5, specular=0.25, shininess=500, emission=(0.0, 0.01, 0.02))
VIEWER = Viewer(position=(0, 0, 4))
VTK = LightModel.vtk()


def equation(*lights, model=None, material=MATERIAL, viewer=VIEWER, matrix=None):
    scene = Scene(lights=lights, viewer=viewer, light_model=LightModel() if model is None else model)
    return assemble(scene, material, matrix)


def colors(term):
    """A term's colours with their gain put back."""
    return [tuple(c * term.gain for c in color) for color in (term.ambient, *term.colors)]


# --- the standard convention ---


def test_what_is_there_without_light():
    bare = equation(model=LightModel(ambient=(1.0, 0.5, 0.0)))
    assert (bare.ambient, bare.emission, bare.terms) == ((0.1, 0.2 * 0.5, 0.0), (0.0, 0.01, 0.02), ())


@pytest.mark.parametrize(
    ("light", "model", "expected"),
    [
        (
            PointLight(diffuse=(1, 0.5, 0.25), specular=(0.0, 1.0, 2.0), ambient=(0.5, 1, 0), intensity=2),
            LightModel(),
            [(0.1, 0.4, 0.0), (1.0, 0.5, 0.25), (0.0, 0.5, 1.0)],
        ),
        (PointLight(diffuse=(1, 0.5, 0)), LightModel(), [(0, 0, 0), (0.5, 0.25, 0.0), (0.25, 0.125, 0.0)]),
        # VTK's lights have no ambient light and one colour for all else
        (
            PointLight(diffuse=(1, 0.5, 0), specular="blue", ambient=1),
            VTK,
            [(0, 0, 0), (0.5, 0.25, 0), (0.25, 0.125, 0)],
        ),
    ],
)
def test_colours_are_light_times_material_times_intensity(light, model, expected):
    for got, color in zip(colors(equation(light, model=model).terms[0]), expected, strict=True):
        assert got == pytest.approx(color, rel=1e-15)


@pytest.mark.parametrize("intensity", [0.0, 5e-324, 1e-30, 0.3, 1.0, 1e20, 1e30, 1e300])
def test_gain_is_a_power_of_two_that_leaves_colours_up_to_one(intensity):
    term = equation(PointLight(diffuse=(1, 0.3, 0), intensity=intensity)).terms[0]
    assert np.frexp(term.gain)[0] == 0.5
    assert 0 < term.gain < np.inf
    assert max(max(color) for color in (term.ambient, *term.colors)) <= 1.0
    assert max(term.colors[0]) * term.gain == 0.5 * intensity


def test_no_colour_is_beyond_the_brightest():
    material = Material(ambient=1e308, diffuse=1e308, specular=1e308, emission=1e308)
    bright = equation(
        DirectionalLight(diffuse=1e308, ambient=1e308, intensity=1e308),
        model=LightModel(ambient=1e308),
        material=material,
    )
    assert bright.ambient == bright.emission == (BRIGHTEST,) * 3
    assert colors(bright.terms[0]) == [(2.0**1000,) * 3] * 3


@pytest.mark.parametrize(
    ("local_viewer", "parallel", "eye"),
    [(True, False, (0.0, 0.0, 4.0)), (False, False, None), (True, True, None), (False, True, None)],
)
def test_the_eye_counts_where_the_viewer_is_local(local_viewer, parallel, eye):
    viewer = dataclasses.replace(VIEWER, parallel=parallel)
    result = equation(model=LightModel(local_viewer=local_viewer), viewer=viewer)
    assert result.eye == eye
    assert result.to_eye == (0.0, 0.0, 1.0)
    assert result.local_facing is (eye is not None)


# --- VTK's convention ---


def test_vtks_exponents_end_at_128():
    result = equation(SpotLight(exponent=1000), model=VTK)
    assert result.reflectance.shininess == 128.0
    assert result.terms[0].light.exponent == 128.0
    dull = equation(SpotLight(exponent=3), model=VTK, material=Material(shininess=7))
    assert (dull.reflectance.shininess, dull.terms[0].light.exponent) == (7.0, 3.0)


def test_vtks_cone_of_90_degrees_is_none():
    wide = SpotLight(position=(1, 2, 3), cone_angle=90, exponent=5, attenuation=(1, 2, 3), diffuse=0.5, intensity=2)
    light = equation(wide, model=VTK).terms[0].light
    assert isinstance(light, PointLight)
    assert (light.position, light.attenuation) == (wide.position, wide.attenuation)
    assert isinstance(equation(SpotLight(cone_angle=89.9), model=VTK).terms[0].light, SpotLight)


@pytest.mark.parametrize("parallel", [False, True])
def test_vtks_viewer_is_local_even_in_parallel_projection(parallel):
    result = equation(model=VTK, viewer=dataclasses.replace(VIEWER, parallel=parallel))
    assert result.eye == (0.0, 0.0, 4.0)
    assert result.local_facing is not parallel


# --- what the equation needs ---

DULL = Material(specular=0)
SHINY = Material(specular=0.5)
AMBIENT = Material(diffuse=0)


@pytest.mark.parametrize(
    ("lights", "model", "material", "normals", "eye", "points"),
    [
        ([], LightModel(), SHINY, False, False, False),
        ([DirectionalLight()], LightModel(), DULL, True, False, False),
        ([DirectionalLight()], LightModel(), SHINY, True, True, True),
        ([DirectionalLight()], LightModel(local_viewer=False), SHINY, True, False, False),
        ([DirectionalLight()], LightModel(two_sided=True), DULL, True, True, True),
        ([DirectionalLight()], LightModel(two_sided=True, local_viewer=False), DULL, True, False, False),
        ([PointLight()], LightModel(), DULL, True, False, True),
        ([PointLight(ambient=1)], LightModel(two_sided=True), AMBIENT, False, False, True),
        ([DirectionalLight(diffuse=0, specular=0)], LightModel(), SHINY, False, False, False),
        ([DirectionalLight(frame="headlight")], VTK, SHINY, True, True, True),
        ([DirectionalLight(frame="headlight")], LightModel.vtk(two_sided=False), SHINY, True, False, False),
    ],
)
def test_needs(lights, model, material, normals, eye, points):
    result = equation(*lights, model=model, material=material)
    assert (result.needs_normals, result.needs_eye, result.needs_points) == (normals, eye, points)
