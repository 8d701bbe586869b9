"""The sun's position: NREL's published example, and places and times where signs and zones go wrong."""

from __future__ import annotations

import sys
import zoneinfo
from datetime import UTC, datetime
from zoneinfo import ZoneInfo

import numpy as np
import pytest

import pvphong as ph

pandas = pytest.importorskip("pandas")
pytest.importorskip("pvlib")

GREENWICH = ph.Place(51.48, 0.0)


def test_the_example_that_nrel_publishes():
    """NREL/TP-560-34302, table A5.1: zenith 50.11162°, azimuth 194.34024°, at 820 hPa and 11 °C."""
    sun = ph.sun_position("2003-10-17T12:30:30-07:00", ph.Place(39.742476, -105.1786, altitude=1830.14))
    assert sun.altitude[0] == pytest.approx(90.0 - 50.11162, abs=1e-3)  # 12 °C and the mean pressure at 1830 m
    assert sun.azimuth[0] == pytest.approx(194.34024, abs=1e-4)


def test_the_direction_is_the_angles():
    sun = ph.sun_position("2026-06-21T08:00+00:00", GREENWICH)
    east, north, up = sun.direction[0]
    assert np.degrees(np.arctan2(east, north)) == pytest.approx(sun.azimuth[0])
    assert np.degrees(np.arcsin(up)) == pytest.approx(sun.altitude[0])
    assert sun.direction.shape == (1, 3)


def test_the_equator_at_the_equinox():
    """The sun rises in the east, passes the zenith and sets in the west."""
    hours = pandas.date_range("2026-03-20T06:30Z", "2026-03-20T17:30Z", freq="h")
    sun = ph.sun_position(hours, ph.Place(0.0, 0.0))
    assert np.abs(sun.direction[:, 1]).max() < 0.005  # a declination below 0.3°
    assert (sun.direction[:5, 0] > 0.0).all()
    assert (sun.direction[-5:, 0] < 0.0).all()
    assert ph.sun_position("2026-03-20T12:07:30Z", ph.Place(0.0, 0.0)).altitude[0] > 89.5


def test_noon_in_both_hemispheres():
    """At solar noon the sun is in the south of the northern hemisphere, and in the north of the southern."""
    north, south = (ph.sun_position("2026-06-21T12:02Z", ph.Place(latitude, 0.0)) for latitude in (48.0, -48.0))
    assert north.azimuth[0] == pytest.approx(180.0, abs=0.3)
    assert north.altitude[0] == pytest.approx(90.0 - 48.0 + 23.436, abs=0.02)
    assert abs((south.azimuth[0] + 180.0) % 360.0 - 180.0) < 0.3
    assert south.altitude[0] == pytest.approx(90.0 - 48.0 - 23.436, abs=0.1)


def test_the_poles_and_the_midnight_sun():
    day = pandas.date_range("2026-06-21", periods=24, freq="h", tz="UTC")
    assert np.ptp(ph.sun_position(day, ph.Place(90.0, 0.0)).altitude) < 0.02
    assert (ph.sun_position(day, ph.Place(90.0, 0.0)).altitude > 23.4).all()
    assert (ph.sun_position(day, ph.Place(-90.0, 0.0)).altitude < -23.0).all()
    assert (ph.sun_position(day, ph.Place(69.65, 18.96)).altitude > 0.0).all()  # Tromsø


def test_daylight_saving():
    """In Berlin, 12:00 is 10:00 UTC after the change on 29 March 2026, and 11:00 UTC before."""
    berlin, zone = ph.Place(52.5, 13.4), "Europe/Berlin"
    local = pandas.DatetimeIndex(["2026-03-28T12:00", "2026-03-30T12:00"]).tz_localize(zone)
    utc = ["2026-03-28T11:00+00:00", "2026-03-30T10:00+00:00"]
    np.testing.assert_allclose(
        ph.sun_position(local, berlin).direction, ph.sun_position(utc, berlin).direction, atol=1e-12
    )
    python = [datetime(2026, 3, 28, 12, tzinfo=ZoneInfo(zone)), datetime(2026, 3, 30, 12, tzinfo=ZoneInfo(zone))]
    assert (ph.sun_position(python, berlin).altitude == ph.sun_position(local, berlin).altitude).all()


def test_leap_days():
    days = ph.sun_position(["2028-02-28T12:00Z", "2028-02-29T12:00Z", "2028-03-01T12:00Z"], GREENWICH).altitude
    np.testing.assert_allclose(np.diff(days), [0.377, 0.379], atol=0.01)  # the declination moves by 0.38° a day


def test_forms_of_one_time():
    expected = ph.sun_position("2026-06-21T10:00+00:00", GREENWICH).direction
    forms = [
        datetime(2026, 6, 21, 10, tzinfo=UTC),
        pandas.Timestamp("2026-06-21T12:00+02:00"),
        np.datetime64("2026-06-21T10:00"),  # UTC
        np.array(["2026-06-21T10:00"], "datetime64[s]"),
        pandas.Series(pandas.to_datetime(["2026-06-21T10:00Z"])),
        np.array([datetime(2026, 6, 21, 10, tzinfo=UTC)], object),
    ]
    for form in forms:
        np.testing.assert_allclose(ph.sun_position(form, GREENWICH).direction, expected, atol=1e-12)


def test_north_turned_and_y_up():
    time, plain = "2026-06-21T08:00Z", ph.sun_position("2026-06-21T08:00Z", GREENWICH).direction[0]
    turned = ph.sun_position(time, ph.Place(51.48, 0.0, north=(3.0, 0.0, 7.0))).direction[0]  # north is +x, east −y
    np.testing.assert_allclose(turned, (plain[1], -plain[0], plain[2]), atol=1e-12)
    y_up = ph.sun_position(time, ph.Place(51.48, 0.0, up=(0, 2, 0), north=(0, 0, -1))).direction[0]
    np.testing.assert_allclose(y_up, (plain[0], plain[2], -plain[1]), atol=1e-12)


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ("2026-06-21T10:00", "must be times with a time zone; got 2026-06-21 10:00:00. Add a UTC offset"),
        (datetime(2026, 6, 21), "must be times with a time zone"),
        (pandas.DatetimeIndex(["2026-06-21"]), "must be times with a time zone"),
        (pandas.Series(pandas.to_datetime(["2026-06-21"])), "must be times with a time zone"),
        (
            ["2026-06-21T10:00+02:00", "2026-06-21T10:00+01:00"],
            r"must be in one time zone; got .*UTC\+01:00, UTC",
        ),
        (["2026-06-21T10:00+02:00", "2026-06-21T10:00"], "must be in one time zone"),
        ("1949-12-31T12:00Z", "must be in 1950 or later; got 1949-12-31"),
        ("noon", "must be times, such as .*; got noon"),
        (12.5, "must be times, such as .*; got 12.5"),
        (pandas.Series([1.0, 2.0]), "must be times"),
        ([], "must be at least one time"),
        ([np.datetime64("NaT")], "must be times"),
        (np.array(["NaT"], "datetime64[s]"), "must be times without gaps"),
    ],
)
def test_times_that_are_refused(times, message):
    with pytest.raises(ValueError, match=f"^times {message}"):
        ph.sun_position(times, GREENWICH)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"latitude": 95.0, "longitude": 0.0}, "latitude must be a finite number >= -90 and <= 90; got 95"),
        ({"latitude": 0.0, "longitude": 200.0}, "longitude must be .* <= 180"),
        ({"latitude": 0.0, "longitude": 0.0, "north": (0, 0, 3)}, "north must be not parallel to up"),
        ({"latitude": 0.0, "longitude": 0.0, "up": (0, 0, 0)}, "up must be a direction"),
    ],
)
def test_places_that_are_refused(fields, message):
    with pytest.raises(ValueError, match=message):
        ph.Place(**fields)


def test_a_tuple_is_no_place():
    with pytest.raises(ValueError, match=r"place must be a Place; got \(48, 11\)"):
        ph.sun_position("2026-06-21T10:00Z", (48, 11))


def test_without_pvlib_the_message_names_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pvlib", None)
    with pytest.raises(ValueError, match="Run: pip install pvlib"):
        ph.sun_position("2026-06-21T10:00Z", GREENWICH)


def test_one_moment_in_all_time_zones():
    moment = pandas.Timestamp("2026-03-29T01:30Z")  # clocks change in Europe in this hour
    expected = ph.sun_position(moment, GREENWICH).direction
    for zone in sorted(zoneinfo.available_timezones())[::25]:
        found = ph.sun_position(moment.tz_convert(zone).to_pydatetime(), GREENWICH).direction
        np.testing.assert_allclose(found, expected, atol=1e-12, err_msg=zone)
