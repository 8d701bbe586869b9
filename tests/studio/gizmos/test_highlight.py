"""Highlight dragging: the evaluator itself says where the brightest point has gone."""

import dataclasses

import numpy as np
import pytest
from views import EVERYWHERE, view

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.shading.evaluation import evaluate
from pvphong.studio.gizmos.highlight import Spot, brightest, mirrored_to_eye

LIGHTS = [
    DirectionalLight(direction=(-1, 3, -2)),
    PointLight(position=(2, -3, 3)),
    SpotLight(position=(1, -4, 2), direction=(-1, 4, -2), cone_angle=50),
]


def sphere(scale, count=20_000):
    """Evenly spread points of a sphere, which are their own normals."""
    index = np.arange(count) + 0.5
    z, turn = 1 - 2 * index / count, np.pi * (1 + 5**0.5) * index
    normals = np.stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z], axis=1)
    return scale * normals, normals


def scaled(light, scale):
    if isinstance(light, DirectionalLight):
        return light
    return dataclasses.replace(light, position=tuple(scale * np.array(light.position)))


def brightest_by_evaluation(light, seen_from, points, normals):
    scene = Scene(lights=[light], viewer=seen_from.viewer)
    mirror = Material(ambient=0, diffuse=0, specular=1, shininess=400)
    return points[int(np.argmax(evaluate(points, normals, scene, mirror, precision="float64").rgb[:, 0]))]


@pytest.mark.parametrize(("projection", "scale"), EVERYWHERE)
@pytest.mark.parametrize("light", LIGHTS, ids=lambda light: type(light).__name__)
def test_the_highlight_is_where_the_evaluator_is_brightest(projection, scale, light):
    seen_from, (points, normals), light = view(projection, scale), sphere(scale), scaled(light, scale)
    cosine, spot = brightest(light, seen_from, points, normals)
    np.testing.assert_array_equal(spot.point, brightest_by_evaluation(light, seen_from, points, normals))
    assert 0.999 < cosine <= 1 + 1e-12


@pytest.mark.parametrize(("projection", "scale"), EVERYWHERE)
@pytest.mark.parametrize("light", LIGHTS, ids=lambda light: type(light).__name__)
def test_a_dragged_highlight_is_where_the_cursor_is(projection, scale, light):
    seen_from, (points, normals), light = view(projection, scale), sphere(scale), scaled(light, scale)
    held = brightest(light, seen_from, points, normals)[1]
    facing = np.flatnonzero(normals @ np.array(seen_from.viewer.axes[2]) > 0.75)
    for index in facing[:: len(facing) // 7]:
        target = Spot(tuple(points[index]), tuple(normals[index]))
        found = mirrored_to_eye(light, seen_from, held, target)
        now = brightest_by_evaluation(found, seen_from, points, normals)
        assert np.linalg.norm(now - points[index]) < 0.03 * scale


def test_what_a_dragged_light_keeps():
    seen_from, (points, normals) = view(), sphere(1.0)
    target = Spot((0.0, -1.0, 0.0), (0.0, -1.0, 0.0))
    for light in LIGHTS:
        held = brightest(light, seen_from, points, normals)[1]
        found = mirrored_to_eye(light, seen_from, held, target)
        if isinstance(light, DirectionalLight):
            assert np.linalg.norm(found.direction) == pytest.approx(np.linalg.norm(light.direction))
        else:
            before = np.linalg.norm(np.array(light.position) - held.point)
            assert np.linalg.norm(np.array(found.position) - target.point) == pytest.approx(before)
        if isinstance(light, SpotLight):
            aim = np.array(target.point) - found.position
            np.testing.assert_allclose(np.cross(aim, found.direction), 0, atol=1e-12)


def test_a_light_behind_everything_has_no_highlight():
    seen_from, (points, normals) = view(position=(0, -9, 0), focal_point=(0, 0, 0)), sphere(1.0)
    assert brightest(DirectionalLight(direction=(0, -1, 0)), seen_from, points, normals) is None
    away = SpotLight(position=(0, -3, 0), direction=(0, -1, 0))
    assert brightest(away, seen_from, points, normals) is None
