"""Typed values, without a window."""

import math

import numpy as np
import pytest
from views import EACH, KINDS, example, handles, role_of, scenery

from pvphong.optics.lights import PointLight
from pvphong.optics.roles import Aim, Angle, Corners, Place, Turn
from pvphong.studio.gizmos.handles import INTENSITY, LightInScene
from pvphong.studio.gizmos.interaction import typed_light

LAMP = PointLight(position=(7, 8, 9), attenuation=(1, 0, 1))
each = pytest.mark.parametrize(("kind", "handle"), [*EACH, *((kind, INTENSITY) for kind in KINDS)])


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
    assert typed(LAMP, "position", text).position == position


@pytest.mark.parametrize(
    ("text", "handle", "message"),
    [
        ("1 2 3 4", "position", r"^text must be at most 3 of x, y, z; got 1 2 3 4"),
        ("z1 2", "position", r"^text must be at most 3"),
        ("-", "position", r"^x must be a number; got -\."),
        ("1.2.3", INTENSITY, r"^intensity must be a number; got 1\.2\.3"),
        ("x1", INTENSITY, r"^intensity must be a number; got x1"),
        ("1e999", "radius", r"^half left at must be a number"),
    ],
)
def test_texts_that_are_no_numbers(text, handle, message):
    with pytest.raises(ValueError, match=message):
        typed(LAMP, handle, text)


@each
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
    first = next(iter(known))  # one number leaves the others
    alone = numbers(typed(light, handle, [wanted[first]]), handle)
    assert alone == pytest.approx(known | {first: wanted[first]}, rel=1e-9)


@pytest.mark.parametrize(("kind", "handle"), EACH)
def test_values_that_a_light_does_not_allow_are_refused(kind, handle):
    light = example(kind)
    role, _ = role_of(kind, handle)
    if role in (Place, Corners):
        if not light.values(Aim):
            return
        forbidden = numbers(light, "target").values()
    elif role is Aim:
        forbidden = numbers(light, "position").values() if light.values(Place) else (0.0, 100.0)
    else:
        forbidden = [{Angle: 1e9, Turn: math.inf}.get(role, -1.0)]
    with pytest.raises(ValueError, match="must be"):
        typed(light, handle, forbidden)


@pytest.mark.parametrize(("handle", "sign"), [("target", 1.0), ("origin", -1.0)])
def test_azimuth_and_elevation_are_exact_along_the_axes(handle, sign):
    sun = example("directional")
    expected = (0, sign * math.hypot(*sun.direction), 0)
    assert typed(sun, handle, "90 0").direction == pytest.approx(expected, abs=0)
