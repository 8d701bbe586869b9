"""What gizmos look like, in pixels, without a window."""

import dataclasses
import math

import numpy as np
import pytest
from views import EVERYWHERE, place, view

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.studio.gizmos.drawing import Drawing, circle, hue
from pvphong.studio.gizmos.kinds import kind_of

LIGHTS = [
    DirectionalLight(direction=(0.3, -0.4, -1)),
    PointLight(position=(1, -0.5, 1), attenuation=(1, 0, 1)),
    SpotLight(position=(1, -0.5, 1.2), direction=(-1, 0.4, -1), cone_angle=22, exponent=40),
]
KINDS = pytest.mark.parametrize("light", LIGHTS, ids=lambda light: type(light).__name__)


def drawn(light, seen_from, *, selected=False, scale=1.0):
    drawing = Drawing(seen_from, hue(light))
    kind_of(light).draw(drawing, light, place(scale), selected)
    return drawing


@pytest.mark.parametrize(
    ("diffuse", "expected"),
    [
        ((1, 0.5, 0.25), (1, 0.5, 0.25)),
        ((0.02, 0.01, 0), (1, 0.5, 0)),
        ((4.0, 4.0, 2.0), (1, 1, 0.5)),
        (0.3, (1, 1, 1)),
    ],
)
def test_the_hue_is_the_lights_at_full_value(diffuse, expected):
    light = PointLight(diffuse=diffuse)
    np.testing.assert_allclose(hue(light), expected)
    np.testing.assert_allclose(hue(dataclasses.replace(light, on=False)), 0.35 * np.array(expected))
    np.testing.assert_allclose(hue(dataclasses.replace(light, intensity=0.0)), expected)


def test_a_black_light_is_grey():
    assert hue(PointLight(diffuse=0)) == (0.6, 0.6, 0.6)


@KINDS
def test_selected_shows_more(light):
    assert len(drawn(light, view(), selected=True).lines[0]) > len(drawn(light, view()).lines[0])


@KINDS
@pytest.mark.parametrize(("projection", "scale"), EVERYWHERE)
def test_all_of_it_is_finite_and_coloured(light, projection, scale):
    if not isinstance(light, DirectionalLight):
        light = dataclasses.replace(light, position=tuple(scale * np.array(light.position)))
    drawing = drawn(light, view(projection, scale), selected=True, scale=scale)
    segments, colors = drawing.lines
    assert np.isfinite(segments).all()
    assert colors.shape == (len(segments), 4)
    for corners, color in drawing.areas:
        assert np.isfinite(corners).all()
        assert color.shape == (4,)


@pytest.mark.parametrize("projection", ["perspective", "parallel"])
def test_icons_and_handles_keep_their_size(projection):
    sizes = []
    for distance in (1.0, 0.1, 10.0):
        seen_from = view(projection, position=distance * np.array((4.0, -7, 5)), focal_point=(0, 0, 0))
        drawing = Drawing(seen_from)
        for shape in ("sun", "bulb", "lamp"):
            drawing.icon(np.zeros(3), shape, np.array([0.0, 0, -1]))
        drawing.handle(np.zeros(3))
        drawing.ring(np.zeros(3), hovered=True)
        parts = [np.ptp(corners, axis=0) for corners, _ in drawing.areas]
        sizes.append([np.ptp(drawing.lines[0].reshape(-1, 2), axis=0), *parts])
    np.testing.assert_allclose(sizes[0][1:], sizes[1][1:], atol=1e-6)
    np.testing.assert_allclose(sizes[0], sizes[2], atol=1e-6)


def test_a_hovered_handle_is_larger():
    small, large = Drawing(view()), Drawing(view())
    small.handle(np.zeros(3))
    large.handle(np.zeros(3), hovered=True)
    assert np.ptp(large.areas[0][0], axis=0).max() > 1.5 * np.ptp(small.areas[0][0], axis=0).max()
    assert len(large.areas) > len(small.areas)


def test_the_cone_is_true_to_the_light():
    """Just inside the rim that is drawn the light is bright, just outside it is dark."""
    light = SpotLight(position=(0, 0, 2), direction=(0.2, 0, -2), cone_angle=20, exponent=0)
    axis = np.array(light.direction) / math.dist((0, 0, 0), light.direction)
    far, half = math.dist((0, 0, 0), light.direction), math.radians(20)
    seen_from = view()
    segments, _ = drawn(light, seen_from).lines
    for inward, strength in ((0.999, 1.0), (1.001, 0.0)):
        rim = circle(np.array(light.position) + far * math.cos(half) * axis, axis, inward * far * math.sin(half))
        np.testing.assert_array_equal(light.arrival(rim.T).strength, strength)
        near = np.abs(seen_from.project(rim)[:, None] - segments[:, 0]).max(axis=2).min(axis=1)
        assert near.max() < 0.5


def test_the_spheres_of_a_point_light_are_true_to_its_falloff():
    light = PointLight(attenuation=(1, 0, 1))
    seen_from = view("parallel", position=(0, -9, 0), focal_point=(0, 0, 0))
    segments, _ = drawn(light, seen_from, selected=True).lines
    middle = seen_from.project((0, 0, 0))
    reach = np.linalg.norm(segments[:, 0] - middle, axis=1) * seen_from.unit_per_pixel((0, 0, 0))
    for strength in (0.5, 1 / 256):
        radius = math.sqrt(1 / strength - 1)
        assert float(light.arrival(np.array([[radius], [0.0], [0.0]])).strength[0]) == pytest.approx(strength)
        assert np.abs(reach - radius).min() < 1e-9


def test_lines_end_before_the_eye():
    seen_from = view(position=(0, -3, 0), focal_point=(0, 0, 0))
    drawing = Drawing(seen_from)
    drawing.line(np.array([[1.0, 2.0, 0.5], [1.0, -9.0, 0.5]]))  # passes the eye
    drawing.line(np.array([[1.0, -5.0, 0.0], [1.0, -9.0, 0.0]]))  # behind it
    segments, _ = drawing.lines
    assert len(segments) == 1
    assert np.isfinite(segments).all()
    np.testing.assert_allclose(segments[0, 0], seen_from.project((1, 2, 0.5)))
    middle = seen_from.project((0, 0, 0))
    start, end = segments[0] - middle
    assert np.cross([*start, 0], [*end, 0])[2] == pytest.approx(0, abs=1e-3 * np.hypot(*end) * np.hypot(*start))
    assert end @ start > 0


@KINDS
def test_behind_the_camera_no_icon_is_drawn(light):
    away = view(position=(0, 0, 50), focal_point=(0, 0, 99), up=(0, 1, 0))
    drawing = drawn(light, away, selected=True)
    assert not drawing.areas
    assert np.isfinite(drawing.lines[0]).all()


def test_a_drawing_of_nothing_is_empty():
    segments, colors = Drawing(view()).lines
    assert segments.shape == (0, 2, 2)
    assert colors.shape == (0, 4)
    assert Drawing(view()).areas == []
