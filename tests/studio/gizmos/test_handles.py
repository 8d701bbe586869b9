"""Handles and their drags, as functions of the start and the cursor: invariants for every light."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from views import EACH, EVERYWHERE, KINDS, PROJECTIONS, SCALES, Globe, Glow, example, handles, role_of, scenery, view

from pvphong import DirectionalLight, Light, PointLight, SpotLight
from pvphong.base.color import luminance
from pvphong.optics.roles import Aim, Angle, Falloff, Length, Place, Turn, Up, length, place
from pvphong.studio.gizmos.handles import INTENSITY, LightInScene
from pvphong.studio.gizmos.interaction import typed_light
from pvphong.studio.gizmos.view import Cursor, DragStart, Scenery, vector

everywhere = pytest.mark.parametrize(("projection", "scale"), EVERYWHERE)
each = pytest.mark.parametrize(("kind", "handle"), EACH)
MODIFIERS = [{"constrained": constrained, "snapping": snapping} for constrained in (0, 1) for snapping in (0, 1)]


def handles_with(*roles, of=None):
    """Return the handles with one of these roles, of every kind of light for which `of` is true."""
    found = [each for each in EACH if issubclass(role_of(*each)[0], roles) and (of is None or of(example(each[0])))]
    return pytest.mark.parametrize(("kind", "handle"), found)


def has_axes(light):
    """Return True if the light has its own right and up axes."""
    return bool(light.values(Up))


def grabbed(light, handle, projection="perspective", scale=1.0, offset=(0.0, 0.0), seen_from=None, **steps):
    seen_from, around = seen_from or view(projection, scale), LightInScene(light, scenery(scale)).held(handle)
    point = handles(light, around, seen_from)[handle]
    x, y = seen_from.project(point) + offset
    return DragStart(light, handle, vector(point), (float(x), float(y)), seen_from, around, **steps)


def grab(kind, handle, projection="perspective", scale=1.0, **options):
    return grabbed(example(kind, scale), handle, projection, scale, **options)


def moved(start, by, **modifiers):
    """Return the light after a motion of the cursor, and its handle's position."""
    x, y = np.array(start.cursor) + by
    handle = LightInScene(start.light, start.scenery).handles[start.handle]
    light = handle.dragged(start, Cursor((float(x), float(y)), **modifiers))
    return light, handles(light, start.scenery, start.view)[start.handle]


# --- names and positions ---


def test_the_width_of_a_sun_is_typed_and_read():
    sun = DirectionalLight(direction=(0, 2, -2), angle=0.533, name="sun")
    shown = LightInScene(sun, scenery())
    assert "width" in shown.handles
    assert "width" not in handles(sun)  # the icon would hide it
    assert "width 0.533°" in shown.readout("target")
    assert "width" not in LightInScene(DirectionalLight(), scenery()).readout("target")
    assert typed_light(shown, "width", "2").angle == 2.0
    with pytest.raises(ValueError, match=r"^angle must be a finite number >= 0 and <= 90"):
        shown.handles["width"].typed({"width": 100.0})


@pytest.mark.parametrize(
    ("light", "expected"),
    [
        (DirectionalLight(), ["target", "origin"]),
        (PointLight(), ["position"]),
        (PointLight(attenuation=(3, 0, 0)), ["position"]),
        (PointLight(attenuation=(1, 0, 1)), ["position", "radius"]),
        (SpotLight(), ["position", "target", "cone"]),
        (SpotLight(attenuation=(1, 0, 1)), ["position", "target", "cone"]),
        (Globe(), ["position", "radius"]),
        (PointLight(frame="headlight"), []),
        (Glow(), []),
    ],
)
def test_a_light_has_the_handles_of_its_roles(light, expected):
    assert list(handles(light)) == expected


@dataclass(frozen=True)
class Tube(Light):
    """A light with two fields whose handles would have the same name."""

    position: Any = place()
    end: Any = place((0.0, 1.0, 0.0))
    radius: float = length(0.3, "radius")

    def nodes(self, count):  # noqa: ARG002 its first end is enough here
        return (PointLight(position=self.position),)


def test_of_two_handles_with_one_name_the_second_has_its_fields():
    light = Tube()
    assert list(handles(light)) == ["position", "end", "radius"]
    after, point = moved(grabbed(light, "end"), (20, 9))
    assert (after.position, after.radius) == (light.position, light.radius)
    np.testing.assert_allclose(point, after.end)


@everywhere
@handles_with(Length, Falloff, of=lambda light: light.outline is None)
def test_a_size_is_shown_beside_the_light_as_far_away_as_it_says(kind, handle, projection, scale):
    start = grab(kind, handle, projection, scale)
    (position,) = start.light.values(Place)
    role, field = start.light.roles[role_of(kind, handle)[1]], role_of(kind, handle)[1]
    ahead = getattr(role, "axis", 0)
    away = start.view.project(start.point) - start.view.project(position)
    assert away[ahead] > 0
    assert abs(away[1 - ahead]) < 1e-9
    if isinstance(role, Length):
        assert math.dist(start.point, position) == pytest.approx(role.share * getattr(start.light, field))


@everywhere
@handles_with(Length, of=lambda light: light.outline is not None)
def test_a_size_of_a_light_with_an_outline_is_shown_on_that_to_the_right_or_above(kind, handle, projection, scale):
    start = grab(kind, handle, projection, scale)
    outline, role = start.light.outline, start.light.roles[role_of(kind, handle)[1]]
    sides, along = np.roll(outline, -1, axis=0) - outline, np.array(start.point) - outline
    part = np.clip((along * sides).sum(axis=1) / (sides**2).sum(axis=1), 0.0, 1.0)[:, None]
    assert np.linalg.norm(along - part * sides, axis=1).min() < 0.4 * 2e-3 * scale  # a rim is drawn with 64 sides
    assert (np.array(start.point) - start.light.position) @ start.view.viewer.axes[role.axis] > 0


@pytest.mark.parametrize("falloff", [(1, 1, 0), (1, 0, 4), (2, 0.5, 0.01), (0, 1, 0), (0, 0, 3), (1, 0, 1e-7)])
def test_half_of_the_light_is_left_at_a_falloffs_handle(falloff):
    light = PointLight(attenuation=falloff)
    point = handles(light)["radius"]
    assert light.arrival(point[:, None]).strength[0] == pytest.approx(0.5 / (falloff[0] or 1), rel=1e-12)


@pytest.mark.parametrize("scale", SCALES)
def test_a_short_or_long_direction_shows_its_target_where_it_can_be_grabbed(scale):
    for size in (1e-30, 1e-3, 1.0, 1e30):
        light = SpotLight(position=(scale, 0, 0), direction=(0, 0, -size * scale))
        target = handles(light, scenery(scale), view(scale=scale))["target"]
        assert 0.1 <= math.dist(target, light.position) / scale <= 40
        assert target[2] < 0
        lines = LightInScene(light, scenery(scale)).readout("cone").splitlines()
        assert "target ({:.4g}, {:.4g}, {:.4g})".format(*target) in lines
        assert any(line.startswith(f"distance {math.dist(target, light.position):.4g}, cone ") for line in lines)


# --- invariants of all drags ---


@everywhere
@pytest.mark.parametrize("frame", ["world", "camera"])
@pytest.mark.parametrize("kind", KINDS)
def test_frames_have_inverses_in_which_a_drag_without_motion_changes_nothing(kind, frame, projection, scale):
    viewer, light = view(projection, scale).viewer, example(kind, scale)
    seated = light.in_frame(frame, viewer)
    back = seated.in_world(viewer)
    assert (seated.frame, back.frame) == (frame, "world")
    for field, role in light.roles.items():
        size = 1.0 if isinstance(role, Turn) else scale
        np.testing.assert_allclose(getattr(back, field), getattr(light, field), rtol=1e-12, atol=1e-14 * size)
    for handle in handles(back, scenery(scale), view(projection, scale)):
        start = grabbed(back, handle, projection, scale, offset=(3.0, -4.0))
        for modifiers in MODIFIERS:
            assert moved(start, (0, 0), **modifiers)[0] == back


@each
def test_behind_the_camera_nothing_moves(kind, handle):
    away = view(position=(0, 0, 3), focal_point=(0, 0, 9), up=(0, 1, 0))
    light = example(kind)
    point = vector(handles(light, scenery(), away)[handle])
    start = DragStart(light, handle, point, (300.0, 200.0), away, LightInScene(light, scenery()).held(handle))
    for modifiers in MODIFIERS:
        assert moved(start, (15, 15), **modifiers)[0] == light


# --- places and targets ---


@everywhere
@handles_with(Place, Aim)
def test_the_handle_follows_the_cursor(kind, handle, projection, scale):
    start = grab(kind, handle, projection, scale, offset=(3.0, -4.0))
    where = start.view.project(start.point)
    for by in ((5.0, 3.0), (-6.0, 8.0)):
        wanted, got = where + by, start.view.project(moved(start, by)[1])
        if start.light.values(Place):
            np.testing.assert_allclose(got, wanted, atol=1e-6)
        else:  # it keeps its distance from the pivot, on the line from there to the cursor
            middle = start.view.project(start.scenery.anchor)
            run, motion = wanted - middle, got - middle
            assert abs(run[0] * motion[1] - run[1] * motion[0]) <= 1e-6 * np.hypot(*run) * np.hypot(*motion) + 1e-6
            assert run @ motion > 0


@everywhere
def test_constrained_it_moves_along_one_axis(projection, scale):
    start = grab("point", "position", projection, scale)
    for by in ((30.0, 2.0), (1.0, 25.0), (-20.0, -20.0)):
        for snapping in (False, True):
            after, _ = moved(start, by, constrained=True, snapping=snapping)
            motion = np.subtract(after.position, start.light.position)
            assert np.count_nonzero(np.abs(motion) > 1e-9 * scale) == 1


@handles_with(Place)
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("step", [None, 0.25])
def test_places_snap_to_a_round_grid(kind, handle, scale, step):
    for size, expected in ((1.0, 1.0), (0.99, 0.5), (4.9, 2.0), (5.1e-7, 5e-7), (1.9e6, 1e6)):
        start = dataclasses.replace(grab("point", "position"), scenery=Scenery((0, 0, 0), 20.0 * size, (0, 0, 0)))
        assert start.grid == pytest.approx(expected)
    start = grab(kind, handle, scale=scale, length_step=None if step is None else step * scale)
    steps = moved(start, (31.0, 17.0), snapping=True)[1] / (step * scale if step else start.grid)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert not np.allclose(steps * start.grid, start.point)


@handles_with(Aim)
@pytest.mark.parametrize("step", [5.0, 15.0])
def test_targets_snap_to_steps_of_azimuth_and_elevation(kind, handle, step):
    start = grab(kind, handle, angle_step=step)
    for by in ((31.0, 17.0), (-70.0, 4.0), (2.0, -90.0)):
        x, y, z = moved(start, by, snapping=True)[0].values(Aim)[0]
        angles = np.degrees([np.arctan2(y, x), np.arcsin(z / math.hypot(x, y, z))]) / step
        np.testing.assert_allclose(angles, np.round(angles), atol=1e-9)


def test_a_light_that_is_moved_keeps_its_target():
    start = grab("spot", "position")
    after, _ = moved(start, (50.0, 20.0))
    target = np.add(start.light.position, start.light.direction)
    np.testing.assert_allclose(np.add(after.position, after.direction), target, atol=1e-12)
    onto = start.view.project(target) - start.view.project(start.point)
    assert any(moved(start, onto)[0].direction)


def test_a_sun_turns_around_its_icon_where_its_target_is_dragged_and_else_around_what_is_in_front_of_it():
    light, around, seen_from = example("directional"), Scenery((0.0, 0.0, 0.0), 2.0, (0.0, 0.0, 0.0), 1.9), view()
    for handle in ("target", "origin", "target", "target", "origin"):
        before, around = handles(light, around, seen_from), LightInScene(light, around).held(handle)
        np.testing.assert_allclose(handles(light, around, seen_from)[handle], before[handle], atol=1e-12)  # no jump
        along = np.divide(light.direction, np.linalg.norm(light.direction))
        stays = before["origin"] + (1.9 * along if handle == "origin" else 0.0)
        x, y = seen_from.project(before[handle])
        light, point = moved(DragStart(light, handle, vector(before[handle]), (x, y), seen_from, around), (40.0, 15.0))
        np.testing.assert_allclose(around.anchor, stays, atol=1e-12)
        assert math.dist(point, stays) == pytest.approx(math.dist(before[handle], stays))
        assert not np.allclose(point, before[handle])


def test_a_target_cannot_be_put_on_the_light():
    start = grab("spot", "target")
    onto = start.view.project(start.light.position) - start.view.project(start.point)
    assert np.isfinite(moved(start, onto)[0].direction).all()
    flat = view("parallel", position=(0, -6, 0), focal_point=(0, 0, 0))
    start = grabbed(SpotLight(position=(0, 0, 0), direction=(1, 0, 0)), "target", seen_from=flat)
    onto = flat.project((0, 0, 0)) - flat.project(start.point)
    assert any(moved(start, onto)[0].direction)


# --- angles ---


@everywhere
@handles_with(Angle)
def test_an_edge_comes_as_near_to_the_cursor_as_it_can(kind, handle, projection, scale):
    start = grab(kind, handle, projection, scale)
    (before,) = start.light.values(Angle)
    where = start.view.project(start.point)
    motion = where - start.view.project(handles(start.light, start.scenery, start.view)["target"])
    outward = motion / np.hypot(*motion)
    wider, point = moved(start, 20 * outward)
    assert before < wider.values(Angle)[0] < 89.5
    nearest = np.hypot(*(start.view.project(point) - where - 20 * outward))
    for other in np.linspace(1, 89, 400):
        light = dataclasses.replace(start.light, **{role_of(kind, handle)[1]: other})
        edge = handles(light, start.scenery, start.view)[handle]
        assert np.hypot(*(start.view.project(edge) - where - 20 * outward)) >= nearest - 1e-3
    assert 0.5 < moved(start, -8 * outward)[0].values(Angle)[0] < before
    assert moved(start, (12.0, -20.0), snapping=True)[0].values(Angle)[0] % 5.0 == 0
    for by in np.random.default_rng(1).uniform(-3000, 3000, (20, 2)):
        for snapping in (False, True):
            assert 0.5 <= moved(start, by, snapping=snapping)[0].values(Angle)[0] <= 89.5


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_a_cone_that_points_at_the_eye_opens_and_closes(projection):
    eye = view(projection, position=(0, -6, 0), focal_point=(0, 0, 0))
    start = grabbed(SpotLight(position=(0, 0, 0), direction=(0, -2, 0), cone_angle=25), "cone", seen_from=eye)
    assert moved(start, (25, 0))[0].cone_angle > 28
    assert moved(start, (-15, 0))[0].cone_angle < 23


# --- turns ---


def fronts(start, field, degrees):
    """Return the handle's pixels after turns, from the light's own axes."""
    turned = [dataclasses.replace(start.light, **{field: float(value)}) for value in degrees]
    return np.array([start.view.project(handles(each, start.scenery, start.view)[start.handle]) for each in turned])


@everywhere
@handles_with(Turn)
def test_a_front_follows_the_cursor_all_the_way_around(kind, handle, projection, scale):
    start, (_, field) = grab(kind, handle, projection, scale, offset=(3.0, -4.0)), role_of(kind, handle)
    where = start.view.project(start.point)
    for wanted, pixel in zip(range(-170, 180, 20), fronts(start, field, range(-170, 180, 20)), strict=True):
        assert getattr(moved(start, pixel - where)[0], field) == pytest.approx(wanted, abs=1e-3)
        snapped = getattr(moved(start, pixel - where + (1.0, 1.0), snapping=True)[0], field)
        assert snapped == pytest.approx(5.0 * round(snapped / 5.0))
        assert abs(math.remainder(snapped - wanted, 360.0)) < 10.0


@pytest.mark.parametrize("projection", PROJECTIONS)
@handles_with(Turn)
def test_on_a_circle_seen_edge_on_a_front_stays_on_the_side_where_it_was(kind, handle, projection):
    eye = view(projection, position=(-3.0, -9.0, 0.0), focal_point=(0, 0, 0))
    _, field = role_of(kind, handle)
    for before in (-90.0, 90.0):
        start = grabbed(dataclasses.replace(example(kind), up=(0, 0, 1), **{field: before}), handle, seen_from=eye)
        turned = before + np.arange(-41.7, 45.0, 8.3)
        for wanted, pixel in zip(turned, fronts(start, field, turned), strict=True):
            after, _ = moved(start, pixel - start.view.project(start.point))
            assert getattr(after, field) == pytest.approx(wanted, abs=0.1)


# --- sizes and falloffs ---


@everywhere
@handles_with(Length, Falloff, of=lambda light: not has_axes(light))
def test_a_size_becomes_the_cursors_distance(kind, handle, projection, scale):
    start = grab(kind, handle, projection, scale)
    (position,) = start.light.values(Place)
    middle, where = start.view.project(position), start.view.project(start.point)
    for by in ((40.0, 0.0), (-7.0, 0.0), (10.0, 25.0)):
        after, point = moved(start, by)
        got = np.hypot(*(start.view.project(point) - middle))
        assert got == pytest.approx(np.hypot(*(where + by - middle)), abs=1e-6)
        for before, now in zip(start.light.values(Falloff), after.values(Falloff), strict=True):
            assert before[0] == now[0]


@everywhere
@handles_with(Length, of=has_axes)
def test_a_size_along_a_lights_own_axis_goes_as_far_as_the_cursor_along_that(kind, handle, projection, scale):
    start, (_, field) = grab(kind, handle, projection, scale), role_of(kind, handle)
    for factor in (0.3, 0.9, 1.5, 4.0):
        wanted = factor * getattr(start.light, field)
        light = dataclasses.replace(start.light, **{field: wanted})
        x, y = start.view.project(handles(light, start.scenery, start.view)[handle]) - start.view.project(start.point)
        for by in ((x, y), (x - 0.5 * y, y + 0.5 * x)):
            assert getattr(moved(start, by)[0], field) == pytest.approx(wanted, rel=1e-9)


@everywhere
@handles_with(Length, Falloff)
def test_a_size_never_vanishes_and_snaps_to_the_grid(kind, handle, projection, scale):
    start = grab(kind, handle, projection, scale)
    (position,) = start.light.values(Place)
    onto = start.view.project(position) - start.view.project(start.point)
    after, point = moved(start, onto)
    assert all(np.isfinite(value).all() for value in after.values(Falloff))
    assert math.dist(point, position) > 0
    for by in ((40.0, 0.0), (-400.0, 0.0), onto + 0.1):
        steps = math.dist(moved(start, by, snapping=True)[1], position) / start.grid
        assert steps == pytest.approx(max(round(steps), 1))


# --- the numbers beside the cursor ---


FADING = PointLight(position=(0, 0, 2), attenuation=(1, 0, 0.25), intensity=3, name="lamp")
CONE = SpotLight(position=(1, 0, 2), direction=(0, 0, -2), cone_angle=22.25, exponent=3, attenuation=(1, 0.5, 0))
SUN = DirectionalLight(direction=(0, 2, -2), name="sun", intensity=0.5, diffuse=(1, 0, 0))
SAID = {
    (FADING, "position"): "lamp: position|position (0, 0, 2)|attenuation (1, 0, 0.25)"
    "|1.5 arriving at the scene's centre|luminance 1.5",
    (CONE, "cone"): "cone|position (1, 0, 2)|target (1, 0, 0)|distance 2, cone 22.2°|0.5 arriving at the target"
    "|luminance 0.5",
    (SUN, "target"): "sun: target|direction (0, 0.7071, -0.7071)|azimuth 90.0°, elevation -45.0°"
    "|0.5 arriving everywhere|luminance 0.106",
    (Globe(position=(1, 0, 2), radius=0.25, on=False), "radius"): "radius|position (1, 0, 2)|radius 0.25"
    "|0 arriving at the scene's centre|luminance 0",
}


@pytest.mark.parametrize(("shown", "expected"), SAID.items())
def test_the_numbers_of_each_kind(shown, expected):
    light, handle = shown
    assert LightInScene(light, scenery()).readout(handle).splitlines() == expected.split("|")


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_with_a_handle_is_named(kind):
    light = example(kind)
    for handle in handles(light):
        first, *lines, last, _ = LightInScene(light, scenery()).readout(handle).splitlines()
        assert first == handle
        _, field = role_of(kind, handle)
        assert any(f"{name} " in line for line in lines for name in (handle, field))
        off = LightInScene(dataclasses.replace(light, on=False), scenery()).readout(handle)
        assert off.splitlines()[-2].startswith("0 arriving")
        assert not last.startswith("0 ")


def test_the_luminance_is_that_of_bt_709():
    """The weights are the middle row of the sRGB to CIE XYZ matrix, IEC 61966-2-1."""
    assert [luminance(color) for color in ((1, 0, 0), (0, 1, 0), (0, 0, 1))] == [0.2126, 0.7152, 0.0722]
    assert luminance(0.5) == pytest.approx(0.5, abs=1e-15)


# --- typed values ---


PLACED = PointLight(position=(7, 8, 9), attenuation=(1, 0, 1))


def numbers(light, handle):
    return LightInScene(light, scenery()).handles[handle].numbers


def typed(light, handle, values):
    text = values if isinstance(values, str) else " ".join(map(repr, values))
    return typed_light(LightInScene(light, scenery()), handle, text)


@pytest.mark.parametrize(
    ("text", "position"),
    [
        ("", (7, 8, 9)),
        ("1 -2.5 1e3", (1, -2.5, 1000)),
        ("z2", (7, 8, 2)),
        ("z 2 x.5", (0.5, 8, 2)),
        ("y1 2", (7, 1, 2)),
        ("x", (7, 8, 9)),
    ],
)
def test_numbers_go_to_the_labels_in_turn_or_to_the_one_that_is_named(text, position):
    assert typed(PLACED, "position", text).position == position


@pytest.mark.parametrize(
    ("text", "handle", "message"),
    [
        ("1 2 3 4", "position", r"^text must be at most 3 numbers: x, y, z; got 1 2 3 4"),
        ("z1 2", "position", r"^text must be at most 3"),
        ("-", "position", r"^x must be a number; got -\."),
        ("1.2.3", INTENSITY, r"^intensity must be a number; got 1\.2\.3"),
        ("x1", INTENSITY, r"^intensity must be a number; got x1"),
        ("1e999", "radius", r"^half left at must be a number"),
    ],
)
def test_texts_that_are_no_numbers(text, handle, message):
    with pytest.raises(ValueError, match=message):
        typed(PLACED, handle, text)


@pytest.mark.parametrize(("kind", "handle"), [*EACH, *((kind, INTENSITY) for kind in KINDS)])
def test_what_is_typed_is_what_the_light_then_has_and_where_its_handle_is(kind, handle):
    light = example(kind)
    known = numbers(light, handle)
    assert typed(light, handle, known.values()) == light
    wanted = {label: value * 0.75 + 0.125 for label, value in known.items()}
    changed = typed(light, handle, wanted.values())
    assert changed != light
    assert numbers(changed, handle) == pytest.approx(wanted, rel=1e-12)
    if handle != INTENSITY and (role_of(kind, handle)[0] is Place or (light.values(Place) and "x" in known)):
        np.testing.assert_allclose(handles(changed)[handle], list(wanted.values()), rtol=1e-12)
    first = next(iter(known))  # one number keeps the others
    alone = numbers(typed(light, handle, [wanted[first]]), handle)
    assert alone == pytest.approx(known | {first: wanted[first]}, rel=1e-9)


@handles_with(Length, Falloff, Angle)
def test_values_that_a_light_does_not_allow_are_refused(kind, handle):
    with pytest.raises(ValueError, match="must be"):
        typed(example(kind), handle, "1e9" if role_of(kind, handle)[0] is Angle else "-1")
    if example(kind).values(Aim):
        with pytest.raises(ValueError, match="must be"):
            typed(example(kind), "target", numbers(example(kind), "position").values())


@pytest.mark.parametrize(("handle", "sign"), [("target", 1.0), ("origin", -1.0)])
def test_azimuth_and_elevation_are_exact_along_the_axes(handle, sign):
    sun = example("directional")
    expected = (0, sign * math.hypot(*sun.direction), 0)
    assert typed(sun, handle, "90 0").direction == pytest.approx(expected, abs=0)
