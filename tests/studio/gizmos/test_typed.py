"""Typed values, without a window."""

import math

import numpy as np
import pytest
from views import EACH, KINDS, example, role_of, scenery, view

from pvphong.optics.roles import Aim, Angle, Corners, Place, Turn
from pvphong.studio.gizmos.handles import handles
from pvphong.studio.gizmos.typed import INTENSITY, numbers, parse, with_numbers

XYZ = ["x", "y", "z"]


@pytest.mark.parametrize(
    ("text", "labels", "found"),
    [
        ("", XYZ, {}),
        ("1 -2.5 1e3", XYZ, {"x": 1.0, "y": -2.5, "z": 1000.0}),
        ("z2", XYZ, {"z": 2.0}),
        ("z 2 x.5", XYZ, {"z": 2.0, "x": 0.5}),
        ("y1 2", XYZ, {"y": 1.0, "z": 2.0}),
        ("x", XYZ, {}),
        ("45", ["cone"], {"cone": 45.0}),
        ("10 -30", ["azimuth", "elevation"], {"azimuth": 10.0, "elevation": -30.0}),
    ],
)
def test_texts_and_their_numbers(text, labels, found):
    assert parse(text, labels) == found


@pytest.mark.parametrize(
    ("text", "labels", "message"),
    [
        ("1 2 3 4", XYZ, r"^text must be at most 3 of x, y, z; got 1 2 3 4"),
        ("z1 2", XYZ, r"^text must be at most 3"),
        ("-", XYZ, r"^x must be a number; got -\."),
        ("1.2.3", ["cone"], r"^cone must be a number; got 1\.2\.3"),
        ("x1", ["cone"], r"^cone must be a number; got x1"),
        ("1e999", ["radius"], r"^radius must be a number"),
    ],
)
def test_texts_that_are_none(text, labels, message):
    with pytest.raises(ValueError, match=message):
        parse(text, labels)


@pytest.mark.parametrize(("kind", "handle"), [*EACH, *((kind, INTENSITY) for kind in KINDS)])
def test_what_is_typed_is_what_the_light_then_has_and_where_its_handle_is(kind, handle):
    light = example(kind)
    known = numbers(light, handle, scenery())
    assert (
        with_numbers(light, handle, known, scenery()) is light or with_numbers(light, handle, known, scenery()) == light
    )
    wanted = {label: value * 0.75 + 0.125 for label, value in known.items()}
    changed = with_numbers(light, handle, wanted, scenery())
    assert changed != light
    assert numbers(changed, handle, scenery()) == pytest.approx(wanted, rel=1e-12)
    if handle != INTENSITY and (role_of(kind, handle)[0] is Place or (light.values(Place) and "x" in known)):
        np.testing.assert_allclose(handles(changed, scenery(), view())[handle], list(wanted.values()), rtol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_one_number_leaves_the_others(kind):
    light = example(kind)
    for handle in handles(light, scenery(), view()):
        known = numbers(light, handle, scenery())
        label = list(known)[-1]
        changed = with_numbers(light, handle, {label: known[label] + 1.0}, scenery())
        assert numbers(changed, handle, scenery()) == pytest.approx(known | {label: known[label] + 1.0}, rel=1e-9)


@pytest.mark.parametrize(("kind", "handle"), EACH)
def test_values_that_a_light_does_not_allow_are_refused(kind, handle):
    light = example(kind)
    role, _ = role_of(kind, handle)
    if role in (Place, Corners):
        if not light.values(Aim):
            return
        forbidden = numbers(light, "target", scenery())
    elif role is Aim:
        forbidden = numbers(light, "position", scenery()) if light.values(Place) else {"elevation": 100.0}
    else:
        value = {Angle: 1e9, Turn: math.nan}.get(role, -1.0)
        forbidden = dict.fromkeys(numbers(light, handle, scenery()), value)
    with pytest.raises(ValueError, match="must be"):
        with_numbers(light, handle, forbidden, scenery())


def test_azimuth_and_elevation_are_exact_along_the_axes():
    sun = with_numbers(example("directional"), "target", {"azimuth": 90.0, "elevation": 0.0}, scenery())
    length = math.hypot(*example("directional").direction)
    assert sun.direction == pytest.approx((0, length, 0), abs=0)
    sun = with_numbers(example("directional"), "origin", {"azimuth": 90.0, "elevation": 0.0}, scenery())
    assert sun.direction == pytest.approx((0, -length, 0), abs=0)
