"""Properties of an equation that colours do not show: its gain, its limits and its origin."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from pvphong import DirectionalLight, LightModel, Material, PointLight, Scene, SpotLight, Viewer
from pvphong.base.formulas import BRIGHTEST
from pvphong.shading.equation import assemble, relative_to_mesh

MATERIAL = Material(ambient=(0.1, 0.2, 0.3), diffuse=0.5, specular=0.25, shininess=500, emission=(0.0, 0.01, 0.02))


def equation(*lights, model=None, material=MATERIAL):
    return assemble(Scene(lights, Viewer(), model or LightModel()), material, None)


def colors(term):
    """Return a term's colours times their gain."""
    return [tuple(c * term.gain for c in color) for color in (term.ambient, *term.colors)]


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


def test_vtks_cone_of_90_degrees_is_none():
    wide = SpotLight(position=(1, 2, 3), cone_angle=90, exponent=5, attenuation=(1, 2, 3), diffuse=0.5, intensity=2)
    light = equation(wide, model=LightModel.vtk()).terms[0].light
    assert isinstance(light, PointLight)
    assert (light.position, light.attenuation) == (wide.position, wide.attenuation)
    assert isinstance(equation(SpotLight(cone_angle=89.9), model=LightModel.vtk()).terms[0].light, SpotLight)


# --- the origin, if a matrix translates the mesh very far ---

LAMP = PointLight(position=(3, 4, 5), attenuation=(1, 0.1, 0))
SPOT = SpotLight(position=(-3, 4, 6), direction=(3, -4, -6), cone_angle=40, exponent=3)
SUN = DirectionalLight(direction=(1, -2, -3))
VERY_FAR = np.array([2.0**40, -(2.0**41), 2.0**39])  # sums with coordinates such as 3 and 4 are exact


def equation_at(offset, *lights, w=1.0, to=None):
    """Return an equation with lights and eye around an offset, and a matrix that moves the mesh there, or to `to`."""
    lights = [light.moved(lambda place: tuple(np.add(place, offset))) for light in lights]
    matrix = np.diag([1.0, 2.0, 3.0, w])
    matrix[:3, 3] = np.multiply(offset, w) if to is None else to
    return assemble(Scene(lights, Viewer(np.add((0, -2, 4), offset), offset)), MATERIAL, matrix)


def test_very_far_out_the_mesh_is_as_if_it_had_stayed():
    given, near = (equation_at(offset, LAMP, SPOT, SUN) for offset in (VERY_FAR, (0, 0, 0)))
    far = relative_to_mesh(given)
    np.testing.assert_array_equal(far.matrix, near.matrix)
    assert replace(far, matrix=None) == replace(near, matrix=None)
    assert given.matrix[0, 3] == VERY_FAR[0]


@pytest.mark.parametrize("w", [-3.0, 0.7])
def test_the_offset_is_divided_by_w_before_anything_is_rounded(w):
    moved = relative_to_mesh(equation_at(VERY_FAR / w, LAMP, w=w, to=VERY_FAR))
    for found, place, t in zip(moved.terms[0].light.position, LAMP.position, VERY_FAR, strict=True):
        assert found == float(Fraction(place + t / w) - Fraction(t) / Fraction(w))


@pytest.mark.parametrize(
    ("offset", "lights", "to"),
    [
        ((0, 0, 0), [LAMP], None),
        ((1e6, 2e6, 0), [LAMP], None),  # not so far
        ((0, 0, 0), [LAMP], VERY_FAR),  # lights and eye are not there
        ((1e308, 0, 0), [LAMP], (-1e308, 0, 0)),  # overflow
    ],
)
def test_else_it_stays_where_it_is(offset, lights, to):
    equation = equation_at(offset, *lights, to=to)
    assert relative_to_mesh(equation) is equation
