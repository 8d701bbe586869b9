"""An equation's origin is put beside the mesh where a matrix carries it very far out, and stays where it is else."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import pvphong as ph
from pvphong.shading.equation import assemble, relative_to_mesh

LAMP = ph.PointLight(position=(3, 4, 5), attenuation=(1, 0.1, 0))
SPOT = ph.SpotLight(position=(-3, 4, 6), direction=(3, -4, -6), cone_angle=40, exponent=3)
SUN = ph.DirectionalLight(direction=(1, -2, -3))
SHINY = ph.Material(specular=0.5, shininess=20)
VERY_FAR = np.array([2.0**40, -(2.0**41), 2.0**39])  # to which coordinates such as 3 and 4 are added exactly


def scene_at(offset, *lights):
    lights = [
        replace(light, position=np.add(light.position, offset)) if hasattr(light, "position") else light
        for light in lights
    ]
    return ph.Scene(lights, ph.Viewer(position=np.add((0, -2, 4), offset), focal_point=offset))


def matrix_at(offset, w=1.0):
    matrix = np.diag([1.0, 2.0, 3.0, w])
    matrix[:3, 3] = offset
    return matrix


def test_very_far_out_the_mesh_is_as_if_it_had_stayed():
    far = relative_to_mesh(assemble(scene_at(VERY_FAR, LAMP, SPOT, SUN), SHINY, matrix_at(VERY_FAR)))
    near = assemble(scene_at((0, 0, 0), LAMP, SPOT, SUN), SHINY, matrix_at((0, 0, 0)))
    np.testing.assert_array_equal(far.matrix, near.matrix)
    assert replace(far, matrix=None) == replace(near, matrix=None)
    assert relative_to_mesh(far) is far


@pytest.mark.parametrize("place", [(0, 0, 0), -VERY_FAR])
def test_lights_and_eye_that_are_elsewhere_are_as_far_away_as_before(place):
    scene = replace(scene_at(VERY_FAR, LAMP, replace(LAMP, position=place - VERY_FAR)), viewer=ph.Viewer())
    moved = relative_to_mesh(assemble(scene, SHINY, matrix_at(VERY_FAR)))
    assert not moved.matrix[:3, 3].any()
    assert moved.terms[0].light.position == LAMP.position
    assert moved.terms[1].light.position == tuple(place - VERY_FAR)
    assert moved.eye == tuple((0, 0, 1) - VERY_FAR)


@pytest.mark.parametrize("w", [2.0, -3.0, 0.7])
def test_the_offset_is_divided_by_w_before_anything_is_rounded(w):
    moved = relative_to_mesh(assemble(scene_at(VERY_FAR / w, LAMP), SHINY, matrix_at(VERY_FAR, w)))
    for axis, t in enumerate(VERY_FAR):
        exact = Fraction(LAMP.position[axis] + t / w) - Fraction(t) / Fraction(w)
        assert moved.terms[0].light.position[axis] == float(exact)
    assert moved.matrix[3, 3] == w
    assert not moved.matrix[:3, 3].any()


def test_the_given_equation_stays_as_it_is():
    given = assemble(scene_at(VERY_FAR, LAMP), SHINY, matrix_at(VERY_FAR))
    relative_to_mesh(given)
    np.testing.assert_array_equal(given.matrix, matrix_at(VERY_FAR))
    assert given.terms[0].light.position == tuple(np.add(LAMP.position, VERY_FAR))


@pytest.mark.parametrize(
    ("scene", "matrix"),
    [
        (scene_at((0, 0, 0), LAMP), None),
        (scene_at((0, 0, 0), LAMP), matrix_at((0, 0, 0))),
        (scene_at((1e6, 2e6, 0), LAMP), matrix_at((1e6, 2e6, 0))),
        (scene_at((0, 0, 0), LAMP), matrix_at(VERY_FAR)),
        (replace(scene_at((0, 0, 0), LAMP), viewer=ph.Viewer(position=(5, 6, 7))), matrix_at((5, 6, 7))),
        (scene_at((1e308, 0, 0), LAMP), matrix_at((-1e308, 0, 0))),
        (replace(scene_at(VERY_FAR, SUN), light_model=ph.LightModel(local_viewer=False)), matrix_at(VERY_FAR)),
    ],
    ids=[
        "no matrix",
        "no offset",
        "not so far",
        "lights are not there",
        "the eye is on the offset",
        "overflow",
        "nothing has a place",
    ],
)
def test_else_it_stays_where_it_is(scene, matrix):
    equation = assemble(scene, SHINY, matrix)
    assert relative_to_mesh(equation) is equation
