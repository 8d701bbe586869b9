"""Drawing of gizmos, in pixels, without a window."""

import dataclasses
import math

import numpy as np
import pytest
from views import EVERYWHERE, MOVABLE, PROJECTIONS, Globe, Glow, example, scenery, view

from pvphong.optics.lights import PointLight, PolygonLight, SpotLight
from pvphong.studio.gizmos.drawing import Drawing, circle, hue
from pvphong.studio.gizmos.handles import LightInScene

each_kind = pytest.mark.parametrize("kind", MOVABLE)


def drawn(light, seen_from, *, selected=False, active=None, scale=1.0):
    drawing = Drawing(seen_from, hue(light))
    LightInScene(light, scenery(scale)).draw(drawing, selected, active)
    return drawing


@pytest.mark.parametrize(
    ("diffuse", "expected"),
    [
        ((1, 0.5, 0.25), (1, 0.5, 0.25)),
        ((0.02, 0.01, 0), (1, 0.5, 0)),
        ((4.0, 4.0, 2.0), (1, 1, 0.5)),
        (0.3, (1, 1, 1)),
        (0.0, (0.6, 0.6, 0.6)),
    ],
)
def test_the_hue_is_the_lights_at_full_value(diffuse, expected):
    light = PointLight(diffuse=diffuse)
    np.testing.assert_allclose(hue(light), expected)
    np.testing.assert_allclose(hue(dataclasses.replace(light, on=False)), 0.45 * np.array(expected))
    np.testing.assert_allclose(hue(dataclasses.replace(light, intensity=0.0)), expected)


@each_kind
@pytest.mark.parametrize(("projection", "scale"), EVERYWHERE)
def test_all_of_it_is_finite_and_coloured_and_selected_shows_more(kind, projection, scale):
    light, seen_from = example(kind, scale, power=40.0), view(projection, scale)
    drawing = drawn(light, seen_from, selected=True, active="radius", scale=scale)
    segments, colors = drawing.lines
    assert np.isfinite(segments).all()
    assert colors.shape == (len(segments), 4)
    for corners, color in drawing.areas:
        assert np.isfinite(corners).all()
        assert color.shape == (4,)
    assert len(segments) > len(drawn(light, seen_from, scale=scale).lines[0])


@each_kind
def test_behind_the_camera_no_icon_is_drawn_but_an_arrow_towards_it(kind):
    away = view(position=(0, 0, 50), focal_point=(0, 0, 99), up=(0, 1, 0))
    drawing = drawn(example(kind, place=(-3.0, 0.0, 0.0)), away, selected=True)
    assert not drawing.labels
    assert len(drawing.areas) == 2
    for corners, _ in drawing.areas:
        assert (corners >= (100, 30)).all()
        assert (corners <= (740, 510)).all()
    assert np.isfinite(drawing.lines[0]).all()


def arrow(seen_from, point):
    """Return the corners of the arrow towards a point, the tip first; None if there is no arrow."""
    drawing = Drawing(seen_from)
    drawing.arrow_out_of_sight(np.array(point, dtype=float))
    return drawing.areas[1][0] if drawing.areas else None


@pytest.mark.parametrize("projection", PROJECTIONS)
@pytest.mark.parametrize(("right", "up"), [(1, 0), (-1, 0.3), (0.1, 1), (0, -1), (-1, -1)])
def test_an_arrow_at_the_edge_points_to_where_a_light_is(projection, right, up):
    seen_from = view(projection, position=(0, -9, 0), focal_point=(0, 0, 0))
    point = (20.0 * right, 0.0, 20.0 * up)
    tip, *rest = arrow(seen_from, point)
    offset, ahead = seen_from.project(point) - tip, tip - np.mean(rest, axis=0)
    assert offset @ ahead == pytest.approx(np.hypot(*offset) * np.hypot(*ahead), rel=1e-6)
    beside = np.abs(tip - (420, 270)) - (320, 240)
    assert -16 <= beside.max() <= 0
    assert arrow(seen_from, (0, 0, 0)) is None
    if projection == "perspective":  # a point behind the eye is shown at a side, straight behind at the bottom
        np.testing.assert_allclose(arrow(seen_from, (0, -20, 0))[0], (420, 30 + 8))
        np.testing.assert_allclose(arrow(seen_from, (3, -20, 0))[0], (100 + 640 - 8, 30 + 240))


@each_kind
def test_a_light_that_is_off_is_crossed_out(kind):
    on, off = (drawn(example(kind, on=is_on), view()).areas for is_on in (True, False))
    assert len(off) == len(on) + 2
    assert off[-1][1].tolist() == [255, 255, 255, 255]


def test_spheres_are_labelled_where_they_are_seen():
    light, using = PointLight(attenuation=(1, 0, 1)), {"selected": True, "active": "radius"}
    assert [text for _, text in drawn(light, view(), **using).labels] == ["1/2 left"]
    far = view(position=(0, -90, 0), focal_point=(0, 0, 0))
    assert [text for _, text in drawn(light, far, **using).labels] == ["1/2 left", "1/256 left"]
    for others in ({}, {"selected": True}, {"selected": True, "active": "position"}):
        assert not drawn(light, far, **others).labels


@pytest.mark.parametrize("drawing", [Drawing(view()), drawn(Glow(), view()), drawn(Glow(), view(), selected=True)])
def test_a_drawing_of_nothing_and_of_a_light_without_roles_is_empty(drawing):
    segments, colors = drawing.lines
    assert segments.shape == (0, 2, 2)
    assert colors.shape == (0, 4)
    assert drawing.areas == []


@pytest.mark.parametrize("projection", PROJECTIONS)
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


def test_the_cone_is_true_to_the_light():
    """The light is bright just inside the drawn rim, and dark just outside."""
    light = SpotLight(position=(0, 0, 2), direction=(0.2, 0, -2), cone_angle=20, exponent=0)
    halved = SpotLight(position=(0, 0, 2), direction=(0.2, 0, -2), cone_angle=20, exponent=30)
    axis = np.array(light.direction) / math.dist((0, 0, 0), light.direction)
    far, half = math.dist((0, 0, 0), light.direction), math.radians(20)
    seen_from = view()
    segments, _ = drawn(light, seen_from).lines
    for inward, strength in ((0.999, 1.0), (1.001, 0.0)):
        rim = circle(np.array(light.position) + far * math.cos(half) * axis, axis, inward * far * math.sin(half))
        np.testing.assert_array_equal(light.arrival(rim.T).strength, strength)
        near = np.abs(seen_from.project(rim)[:, None] - segments[:, 0]).max(axis=2).min(axis=1)
        assert near.max() < 0.5
    turn = math.acos(0.5 ** (1.0 / halved.exponent))
    ring = circle(np.array(light.position) + far * math.cos(turn) * axis, axis, far * math.sin(turn))
    np.testing.assert_allclose(halved.arrival(ring.T).strength, 0.5)
    segments, _ = drawn(halved, seen_from, selected=True).lines
    assert np.abs(seen_from.project(ring)[:, None] - segments[:, 0]).max(axis=2).min(axis=1).max() < 1e-6


def radii_drawn(light, **options):
    """Return the distances of the drawn corners from a light at the origin."""
    seen_from = view("parallel", position=(0, -9, 0), focal_point=(0, 0, 0))
    segments, _ = drawn(light, seen_from, **options).lines
    middle = seen_from.project((0, 0, 0))
    return np.linalg.norm(segments[:, 0] - middle, axis=1) * seen_from.unit_per_pixel((0, 0, 0))


@pytest.mark.parametrize("falloff", [(1, 0, 1), (1, 1, 0), (2, 0.5, 0.01), (0, 1, 0)])
def test_the_spheres_of_a_point_light_are_true_to_its_falloff(falloff):
    light = PointLight(attenuation=falloff)
    radii = np.unique(np.round(radii_drawn(light, selected=True, active="radius"), 6))
    strengths = light.arrival(np.array([radii, 0 * radii, 0 * radii])).strength * (falloff[0] or 1)
    for fraction in (0.5, 1 / 256):
        assert np.abs(strengths / fraction - 1).min() < 1e-4


@pytest.mark.parametrize("selected", [False, True])
def test_a_size_is_drawn_through_its_handle_which_here_is_halfway(selected):
    radii = radii_drawn(Globe(radius=1.4), selected=selected)
    assert np.isclose(radii, 0.7).sum() >= (2 if selected else 1) * 64


with_outline = pytest.mark.parametrize("kind", [kind for kind in MOVABLE if example(kind).outline is not None])
FRONT = np.array([-1.0, 0.4, -1.0]) / math.hypot(1.0, 0.4, 1.0)  # of the examples


def hatched(light, along):
    """Return the ends of a selected light's weakest lines, in pixels, seen from afar along a direction."""
    middle = np.mean(light.places, axis=0)
    seen_from = view("parallel", position=middle - 5.0 * along, focal_point=middle, up=(0.1, 0.9, 0.2))
    drawing = drawn(light, seen_from, selected=True)
    segments, colors = drawing.lines
    return segments[(colors[:, :3].max(axis=1) < 160) & drawing.thin], seen_from


@with_outline
@pytest.mark.parametrize("two_sided", [False, True])
def test_a_side_is_hatched_if_it_glows(kind, two_sided):
    light = dataclasses.replace(example(kind), two_sided=two_sided)
    assert len(hatched(light, -FRONT)[0]) >= 11
    assert (len(hatched(light, FRONT)[0]) > 0) == two_sided


def test_hatches_fill_an_outline_and_leave_out_what_is_not_inside():
    corners = np.array([(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)])
    for turn in range(6):
        light = PolygonLight(np.roll(corners, turn, axis=0))
        segments, seen_from = hatched(light, np.array([0.0, 0.0, -1.0]))
        middle, unit = np.mean(light.places, axis=0), seen_from.unit_per_pixel(np.zeros(3))
        right, up, _ = seen_from.viewer.axes
        flat = (segments - seen_from.project(middle)) * unit
        ends = middle + flat[..., :1] * right + flat[..., 1:] * up
        points = ends[:, :1] + np.linspace(0, 1, 50)[:, None] * (ends[:, 1:] - ends[:, :1])
        x, y, z = np.moveaxis(points, -1, 0)
        assert ((np.abs(z) < 1e-9) & (np.minimum(x, y) > -1e-9) & (np.minimum(x, y) < 1 + 1e-9)).all()
        assert np.maximum(x, y).max() < 2 + 1e-9
        for spot in ((0.5, 0.5), (1.5, 0.5), (0.5, 1.5)):
            assert np.hypot(x - spot[0], y - spot[1]).min() < 0.15


@with_outline
def test_what_is_normal_to_a_front_is_drawn(kind):
    light = example(kind)
    middle = np.mean(light.places, axis=0)
    seen_from = view("parallel", position=middle + 5.0 * np.cross(FRONT, (0, 0, 1)), focal_point=middle)
    ends = drawn(light, seen_from, selected=True).lines[0].reshape(-1, 2)
    there, not_there = seen_from.project(middle + 0.25 * 2.0 * np.array([[1.0], [-1.0]]) * FRONT)
    assert np.abs(ends - there).max(axis=1).min() < 1e-6
    assert np.abs(ends - not_there).max(axis=1).min() > 5.0


def test_lines_end_before_the_eye():
    seen_from = view(position=(0, -3, 0), focal_point=(0, 0, 0))
    drawing = Drawing(seen_from)
    drawing.line(np.array([[1.0, 2.0, 0.5], [1.0, -9.0, 0.5]]))  # passes by the eye
    drawing.line(np.array([[1.0, -5.0, 0.0], [1.0, -9.0, 0.0]]))  # behind it
    segments, _ = drawing.lines
    assert len(segments) == 1
    assert np.isfinite(segments).all()
    np.testing.assert_allclose(segments[0, 0], seen_from.project((1, 2, 0.5)))
    middle = seen_from.project((0, 0, 0))
    start, end = segments[0] - middle
    assert np.cross([*start, 0], [*end, 0])[2] == pytest.approx(0, abs=1e-3 * np.hypot(*end) * np.hypot(*start))
    assert end @ start > 0
