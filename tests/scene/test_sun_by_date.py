"""The set-up "sun": place, day and hour, compared with `sun_position` and `daylight_scene`."""

from datetime import datetime

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.scene.sun_by_date import SunByDate

pytest.importorskip("pvlib")

BALL = pv.Sphere()
POLAR_NIGHT = {"latitude": 80, "longitude": 0, "day": 355, "hour": 12}
CAPE_HORN = {"latitude": -56, "longitude": -67, "day": 355, "hour": 11}


@pytest.mark.parametrize(
    ("given", "time"),
    [
        ({}, "2026-06-21T10:00+01:00"),
        ({"hour": 24.0}, "2026-06-22T00:00+01:00"),
        ({"day": 1, "hour": 12.25}, "2026-01-01T12:15+01:00"),
        ({"latitude": -33.9, "longitude": 151.2, "day": 355, "hour": 7.5}, "2026-12-21T07:30+10:00"),
        ({"longitude": -157.9, "latitude": 21.3}, "2026-06-21T10:00-11:00"),
    ],
)
def test_the_sun_is_where_it_is_at_that_time(given, time):
    sun = SunByDate(**given)
    expected = ph.sun_position(time, ph.Place(sun.latitude, sun.longitude))
    np.testing.assert_allclose(sun.position.direction, expected.direction, atol=1e-9)
    assert sun.time == datetime.fromisoformat(time).replace(tzinfo=None)


def test_lights_are_those_of_a_daylight_scene():
    lights = ph.setups["sun"](BALL, hour=17, scale=1.0)
    expected = ph.daylight_scene("2026-06-21T17:00+01:00", ph.Place(48.14, 11.58)).lights
    for ours, theirs in zip(lights, expected, strict=True):
        assert (ours.name, type(ours)) == (theirs.name, type(theirs))
        assert ours.intensity == pytest.approx(theirs.intensity, rel=1e-3)  # turbidity at noon, not at the hour
    np.testing.assert_allclose(lights[0].direction, expected[0].direction, atol=1e-9)
    np.testing.assert_allclose(lights[1].panorama.image, expected[1].panorama.image, rtol=1e-2)
    dimmed = ph.setups["sun"](BALL, hour=17)
    assert dimmed[0].intensity == pytest.approx(lights[0].intensity / 900.0)
    assert SunByDate(hour=17).sun == lights[0]


def test_north_is_minus_z_if_y_is_up():
    """At noon in the northern hemisphere the sun is in the south: +z if y is up, and -y if z is up."""
    lying, standing = (SunByDate(hour=12.0, up=up).sun.direction for up in ("y", "z"))
    np.testing.assert_allclose(lying, (standing[0], standing[2], -standing[1]), atol=1e-12)
    assert lying[2] < -0.3
    assert lying[1] < -0.5
    y_up = ph.Viewer((0, 0, 5), (0, 0, 0), (0, 1, 0))
    assert ph.setups["sun"](BALL, y_up, hour=12)[0].direction == lying
    assert ph.setups["sun"](BALL, y_up, hour=12, up="z")[0].direction == standing


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "On 21 June, 10:00 UTC+1 the sun is 54° high in the south-east."),
        ({"hour": 19.9}, "On 21 June, 19:54 UTC+1 the sun is 3° high in the north-west."),
        ({"hour": 20.5}, "Night: on 21 June, 20:30 UTC+1 the sun is 2° below the horizon."),
        (POLAR_NIGHT, "Night: on 21 December, 12:00 UTC+0 the sun is 13° below the horizon."),
        (CAPE_HORN, "On 21 December, 11:00 UTC-4 the sun is 54° high in the north-east."),
    ],
)
def test_words(given, words):
    assert SunByDate(**given).words == words


def test_night_is_refused_in_one_line():
    words = r"^hour must be between sunrise and sunset; got 2, night: on 21 June, 02:00 UTC\+1 the sun is 15° below"
    with pytest.raises(ValueError, match=words + r" the horizon\.$"):
        ph.setups["sun"](BALL, hour=2)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"latitude": 91}, "latitude must be a finite number >= -90 and <= 90; got 91"),
        ({"longitude": -181}, "longitude must be"),
        ({"day": 0}, "day must be"),
        ({"day": 1.5}, "day must be"),
        ({"hour": 25}, "hour must be a finite number >= 0 and <= 24; got 25"),
        ({"up": "x"}, "up must be one of"),
        ({"scale": 0}, "scale must be"),
    ],
)
def test_what_is_refused(given, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        ph.setups["sun"](BALL, **given)
