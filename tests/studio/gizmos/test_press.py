"""A drag as a pure function of what was frozen at the press and of the cursor."""

import numpy as np
import pytest
from views import EVERYWHERE, PROJECTIONS, place, view

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.studio.gizmos.kinds import kind_of
from pvphong.studio.gizmos.press import Cursor, Press, round_step, vector

LIGHTS = {
    "directional": lambda s: DirectionalLight(direction=(0.3 * s, -0.4 * s, -s), name="sun"),
    "point": lambda s: PointLight(position=(s, -0.5 * s, s), attenuation=(1, 0.3 / s, 0.5 / s**2), diffuse=(1, 0.5, 0)),
    "spot": lambda s: SpotLight(
        position=(s, -0.5 * s, 1.2 * s), direction=(-s, 0.4 * s, -s), cone_angle=22, exponent=9
    ),
}
HANDLES = {
    "directional": ("target",),
    "point": ("position", "radius"),
    "spot": ("position", "target", "cone"),
}
EACH = [(kind, handle) for kind, handles in HANDLES.items() for handle in handles]


def grab(kind, handle, projection="perspective", scale=1.0, offset=(0.0, 0.0), seen_from=None, **steps):
    light, seen_from = LIGHTS[kind](scale), seen_from or view(projection, scale)
    grip = kind_of(light).handles(light, place(scale), seen_from)[handle]
    x, y = seen_from.project(grip) + offset
    return Press(light, handle, vector(grip), (float(x), float(y)), seen_from, place(scale), **steps)


def moved(press, by, **modifiers):
    x, y = np.array(press.cursor) + by
    light = kind_of(press.light).drag(press, Cursor((float(x), float(y)), **modifiers))
    return light, kind_of(light).handles(light, press.place, press.view)[press.handle]


@pytest.mark.parametrize("kind", LIGHTS)
def test_handles_are_those_that_the_light_has(kind):
    light = LIGHTS[kind](1.0)
    assert tuple(kind_of(light).handles(light, place(), view())) == HANDLES[kind]


@pytest.mark.parametrize(("kind", "handle"), EACH)
@pytest.mark.parametrize(("projection", "scale"), EVERYWHERE)
def test_a_press_without_motion_changes_nothing_to_the_bit(kind, handle, projection, scale):
    press = grab(kind, handle, projection, scale, offset=(3.0, -4.0))
    assert moved(press, (0, 0))[0] == press.light
    assert moved(press, (0, 0), constrained=True)[0] == press.light


@pytest.mark.parametrize(("kind", "handle"), EACH)
@pytest.mark.parametrize(("projection", "scale"), EVERYWHERE)
def test_the_handle_follows_the_cursor(kind, handle, projection, scale):
    press = grab(kind, handle, projection, scale, offset=(3.0, -4.0))
    where = press.view.project(press.grip)
    for by in ((5.0, 3.0), (-6.0, 8.0)):
        light, grip = moved(press, by)
        assert light != press.light
        if handle in ("position", "target"):
            wanted = where + by
            got = press.view.project(grip)
            if kind == "directional":  # its arrow keeps its length: the tip lies on the line to the cursor
                start = press.view.project(press.place.anchor)
                run, way = wanted - start, got - start
                assert abs(run[0] * way[1] - run[1] * way[0]) <= 1e-6 * np.hypot(*run) * np.hypot(*way) + 1e-6
                assert run @ way > 0
            else:
                np.testing.assert_allclose(got, wanted, atol=1e-6)


@pytest.mark.parametrize(("projection", "scale"), EVERYWHERE)
def test_the_cones_edge_comes_as_near_to_the_cursor_as_it_can(projection, scale):
    press = grab("spot", "cone", projection, scale)
    way = press.view.project(press.grip) - press.view.project(
        kind_of(press.light).handles(press.light, press.place, press.view)["target"]
    )
    outward = way / np.hypot(*way)
    wider, grip = moved(press, 20 * outward)
    assert press.light.cone_angle < wider.cone_angle < 89.5
    assert (wider.position, wider.direction) == (press.light.position, press.light.direction)
    wanted = press.view.project(press.grip) + 20 * outward
    nearest = np.hypot(*(press.view.project(grip) - wanted))
    for other in np.linspace(1, 89, 400):
        edge = kind_of(press.light).handles(
            SpotLight(position=press.light.position, direction=press.light.direction, cone_angle=other),
            press.place, press.view)["cone"]  # fmt: skip
        assert np.hypot(*(press.view.project(edge) - wanted)) >= nearest - 1e-3
    narrower, _ = moved(press, -8 * outward)
    assert 0.5 < narrower.cone_angle < press.light.cone_angle


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_a_cone_that_points_at_the_eye_opens_and_closes(projection):
    eye = view(projection, position=(0, -6, 0), focal_point=(0, 0, 0))
    light = SpotLight(position=(0, 0, 0), direction=(0, -2, 0), cone_angle=25)
    grip = kind_of(light).handles(light, place(), eye)["cone"]
    x, y = eye.project(grip)
    press = Press(light, "cone", vector(grip), (x, y), eye, place())
    assert moved(press, (25, 0))[0].cone_angle > 28
    assert moved(press, (-15, 0))[0].cone_angle < 23


def test_a_cone_stays_a_cone():
    press = grab("spot", "cone")
    for by in np.random.default_rng(1).uniform(-3000, 3000, (60, 2)):
        assert 0.5 <= moved(press, by)[0].cone_angle <= 89.5


@pytest.mark.parametrize(("projection", "scale"), EVERYWHERE)
def test_the_radius_is_where_half_is_left(projection, scale):
    press = grab("point", "radius", projection, scale)
    light, grip = moved(press, (40.0, 0.0))
    reached = press.view.project(light.position) - (press.view.project(press.grip) + np.array((40.0, 0.0)))
    at_handle = press.view.project(light.position) - press.view.project(grip)
    np.testing.assert_allclose(at_handle, reached, atol=1e-6)
    radius = float(np.linalg.norm(grip - light.position))
    constant, linear, quadratic = light.attenuation
    assert 1 / (constant + linear * radius + quadratic * radius**2) == pytest.approx(0.5 / constant, rel=1e-9)
    assert light.attenuation[0] == press.light.attenuation[0]


def test_a_radius_never_vanishes():
    press = grab("point", "radius")
    to_center = press.view.project(press.light.position) - press.view.project(press.grip)
    light, _ = moved(press, to_center)
    assert np.isfinite(light.attenuation).all()


@pytest.mark.parametrize(("kind", "handle"), [each for each in EACH if each[1] in ("position", "target")])
@pytest.mark.parametrize(("projection", "scale"), EVERYWHERE)
def test_constrained_it_moves_along_one_axis(kind, handle, projection, scale):
    press = grab(kind, handle, projection, scale)
    for by in ((30.0, 2.0), (1.0, 25.0), (-20.0, -20.0)):
        x, y = np.array(press.cursor) + by
        way = press.moved(Cursor((x, y), constrained=True)) - press.grip
        assert np.count_nonzero(np.abs(way) > 1e-9 * scale) == 1


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_snapping_is_to_a_round_grid(scale):
    press = grab("point", "position", scale=scale)
    step = round_step(2.0 * scale / 20)
    position = np.array(moved(press, (31.0, 17.0), snapping=True)[0].position)
    np.testing.assert_allclose(position / step, np.round(position / step), atol=1e-6)
    assert not np.allclose(position, press.light.position)
    press = grab("point", "position", scale=scale, length_step=0.25 * scale)
    position = np.array(moved(press, (31.0, 17.0), snapping=True)[0].position) / (0.25 * scale)
    np.testing.assert_allclose(position, np.round(position), atol=1e-6)


def test_constrained_and_snapping_only_one_coordinate_changes():
    press = grab("point", "position")
    position = np.array(moved(press, (60.0, 3.0), snapping=True, constrained=True)[0].position)
    assert np.count_nonzero(position != press.light.position) == 1


@pytest.mark.parametrize("kind", ["directional", "spot"])
@pytest.mark.parametrize("step", [5.0, 15.0])
def test_directions_snap_to_steps_of_azimuth_and_elevation(kind, step):
    press = grab(kind, "target", angle_step=step)
    for by in ((31.0, 17.0), (-70.0, 4.0), (2.0, -90.0)):
        x, y, z = moved(press, by, snapping=True)[0].direction
        azimuth, elevation = np.degrees(np.arctan2(y, x)), np.degrees(np.arcsin(z / np.linalg.norm((x, y, z))))
        for angle in (azimuth, elevation):
            assert abs(angle / step - round(angle / step)) < 1e-9


def test_the_cone_snaps_too():
    press = grab("spot", "cone")
    angle = moved(press, (12.0, -20.0), snapping=True)[0].cone_angle
    assert angle % 5.0 == 0


@pytest.mark.parametrize("kind", ["point", "spot"])
def test_behind_the_camera_nothing_moves(kind):
    eye = view(position=(0, 0, 3), focal_point=(0, 0, 9), up=(0, 1, 0))  # looks away from the light
    light = LIGHTS[kind](1.0)
    for handle in HANDLES[kind]:
        grip = (1.0, 1.0, 1.0)
        press = Press(light, handle, grip, (300.0, 200.0), eye, place())
        for modifiers in ({}, {"constrained": True}, {"snapping": True}):
            x, y = np.array(press.cursor) + 15
            changed = kind_of(light).drag(press, Cursor((x, y), **modifiers))
            assert all(np.isfinite(np.ravel(value)).all() for value in (changed.position, changed.attenuation))
            if handle in ("radius", "target", "cone"):
                assert changed == light


def test_a_spot_keeps_its_target_when_it_is_moved():
    press = grab("spot", "position")
    light, _ = moved(press, (50.0, 20.0))
    target = np.array(press.light.position) + press.light.direction
    np.testing.assert_allclose(np.array(light.position) + light.direction, target, atol=1e-12)
    assert light.position != press.light.position


def test_a_target_cannot_be_put_on_the_light():
    press = grab("spot", "target")
    onto = press.view.project(press.light.position) - press.view.project(press.grip)
    assert np.isfinite(moved(press, onto)[0].direction).all()
    flat = view("parallel", position=(0, -6, 0), focal_point=(0, 0, 0))
    light = SpotLight(position=(0, 0, 0), direction=(1, 0, 0))
    press = Press(light, "target", (1.0, 0.0, 0.0), (float(flat.project((1, 0, 0))[0]), 270.0), flat, place())
    x = float(flat.project((0, 0, 0))[0])
    assert any(kind_of(light).drag(press, Cursor((x, 270.0))).direction)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_short_or_long_direction_shows_its_target_where_it_can_be_grabbed(scale):
    for length in (1e-30, 1e-3, 1.0, 1e30):
        light = SpotLight(position=(scale, 0, 0), direction=(0, 0, -length * scale))
        target = kind_of(light).handles(light, place(scale), view(scale=scale))["target"]
        distance = np.linalg.norm(target - light.position) / scale
        assert 0.1 <= distance <= 40
        assert target[2] < 0


@pytest.mark.parametrize(("length", "step"), [(1.0, 1.0), (0.99, 0.5), (4.9, 2.0), (5.1e-7, 5e-7), (1.9e6, 1e6)])
def test_round_steps(length, step):
    assert round_step(length) == pytest.approx(step)
