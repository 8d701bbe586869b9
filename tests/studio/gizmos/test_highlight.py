"""Highlight dragging: the evaluator's brightest point follows."""

import numpy as np
import pytest
from views import EVERYWHERE, FROM_SOMEWHERE, PROJECTIONS, SCALES, example, view

from pvphong import DirectionalLight, LightModel, Material, Scene, SpotLight
from pvphong.optics.roles import Aim, Place
from pvphong.shading.evaluation import evaluate
from pvphong.studio.gizmos.highlight import SurfacePoint, brightest, mirrored_to_eye

MIRROR = Material(ambient=0, diffuse=0, specular=1, shininess=400)


def sphere(scale, count=20_000):
    """Return evenly spread points of a sphere, which are also its normals."""
    index = np.arange(count) + 0.5
    z, turn = 1 - 2 * index / count, np.pi * (1 + 5**0.5) * index
    normals = np.stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z], axis=1)
    return scale * normals, normals


def shining(kind, scale=1.0):
    """Return a light from one side, with a wide cone and without attenuation."""
    return example(kind, scale, place=(2, -3, 3), aim=(-2, 3, -3), angle=50.0, power=1.0, falloff=(1, 0, 0))


def brightest_by_evaluation(light, seen_from, points, normals):
    scene = Scene([light], seen_from.viewer, LightModel(clamp=False))
    return points[int(np.argmax(evaluate(points, normals, scene, MIRROR, precision="float64").rgb[:, 0]))]


# All pairs of kind, projection and scale.
@pytest.mark.parametrize(
    ("kind", "projection", "scale"),
    [
        (kind, projection, scale)
        for number, kind in enumerate(FROM_SOMEWHERE)
        for projection, scale in EVERYWHERE
        if (number + PROJECTIONS.index(projection) + SCALES.index(scale)) % 2 == 0
    ],
)
def test_the_highlight_is_where_the_evaluator_is_brightest_and_goes_where_it_is_dragged(kind, projection, scale):
    seen_from, (points, normals), light = view(projection, scale), sphere(scale), shining(kind, scale)
    cosine, held = brightest(light, seen_from, points, normals)
    assert np.linalg.norm(held.point - brightest_by_evaluation(light, seen_from, points, normals)) < 0.04 * scale
    assert 0.999 < cosine <= 1 + 1e-12
    facing = np.flatnonzero(normals @ np.array(seen_from.viewer.axes[2]) > 0.75)
    for index in facing[:: len(facing) // 7]:
        target = SurfacePoint(tuple(points[index]), tuple(normals[index]))
        found = mirrored_to_eye(light, seen_from, held, target)
        now = brightest_by_evaluation(found, seen_from, points, normals)
        assert np.linalg.norm(now - points[index]) < 0.04 * scale


@pytest.mark.parametrize("kind", FROM_SOMEWHERE)
def test_what_a_dragged_light_keeps(kind):
    seen_from, (points, normals), light = view(), sphere(1.0), shining(kind)
    target = SurfacePoint((0.0, -1.0, 0.0), (0.0, -1.0, 0.0))
    held = brightest(light, seen_from, points, normals)[1]
    found = mirrored_to_eye(light, seen_from, held, target)
    for before, place in zip(light.values(Place), found.values(Place), strict=True):
        distance = np.linalg.norm(np.subtract(before, held.point))
        assert np.linalg.norm(np.subtract(place, target.point)) == pytest.approx(distance)
        for aim in found.values(Aim):
            np.testing.assert_allclose(np.cross(np.subtract(target.point, place), aim), 0, atol=1e-12)
    if not light.values(Place):
        assert np.linalg.norm(found.values(Aim)) == pytest.approx(np.linalg.norm(light.values(Aim)))


def test_a_light_behind_everything_has_no_highlight():
    seen_from, (points, normals) = view(position=(0, -9, 0), focal_point=(0, 0, 0)), sphere(1.0)
    assert brightest(DirectionalLight(direction=(0, -1, 0)), seen_from, points, normals) is None
    away = SpotLight(position=(0, -3, 0), direction=(0, -1, 0))
    assert brightest(away, seen_from, points, normals) is None
