"""Scenes of one moment outdoors: sun and sky in W/m²."""

from __future__ import annotations

import math

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph

pandas = pytest.importorskip("pandas")
pvlib = pytest.importorskip("pvlib")

MUNICH, TEN = ph.Place(48.14, 11.58, altitude=520), "2026-06-21T10:00+02:00"


def irradiance(scene, normal):
    """Return the irradiance of one open point."""
    point = pv.PolyData(np.zeros((1, 3)))
    point.point_data.active_normals = np.array([normal], float)
    return float(point.phong.irradiance(scene)["irradiance"][0, 0])


def test_an_open_surface_gets_sun_and_sky():
    scene = ph.daylight_scene(TEN, MUNICH, direct_normal=700, diffuse_horizontal=120)
    altitude = ph.sun_position(TEN, MUNICH).altitude[0]
    expected = 700.0 * math.sin(math.radians(altitude)) + 120.0
    assert irradiance(scene, (0, 0, 1)) == pytest.approx(expected, rel=1e-3)
    assert irradiance(scene, (0, 0, -1)) == pytest.approx(0.2 * expected, rel=2e-3)


def test_a_surface_that_faces_the_sun_gets_its_irradiance():
    scene = ph.daylight_scene(TEN, MUNICH, direct_normal=700, diffuse_horizontal=0.0)
    assert irradiance(scene, ph.sun_position(TEN, MUNICH).direction[0]) == pytest.approx(700.0, rel=0.05)  # and ground
    assert scene.lights[0].intensity == 700.0


def test_a_scale_for_pictures():
    plain, scaled = (
        ph.daylight_scene(TEN, MUNICH, direct_normal=700, diffuse_horizontal=120, scale=scale)
        for scale in (1.0, 0.0025)
    )
    assert irradiance(scaled, (0, 0, 1)) == pytest.approx(0.0025 * irradiance(plain, (0, 0, 1)), rel=1e-6)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # pvlib calls deprecated functions of pandas
def test_without_irradiances_the_sky_is_clear():
    scene, where = ph.daylight_scene(TEN, MUNICH), pvlib.location.Location(48.14, 11.58, altitude=520)
    expected = where.get_clearsky(pandas.DatetimeIndex([TEN]))["ghi"].iloc[0]
    assert irradiance(scene, (0, 0, 1)) == pytest.approx(expected, rel=0.005)  # Ineichen's GHI is not quite the sum


def test_at_night_there_is_no_sun():
    scene = ph.daylight_scene("2026-06-21T01:00+02:00", MUNICH)
    assert [light.name for light in scene.lights] == ["sky"]
    assert irradiance(scene, (0, 0, 1)) == 0.0
    twilight = ph.daylight_scene("2026-06-21T01:00+02:00", MUNICH, direct_normal=90, diffuse_horizontal=3)
    assert irradiance(twilight, (0, 0, 1)) == pytest.approx(3.0, rel=1e-3)


def test_north_and_up_of_the_mesh():
    plain, given = (ph.daylight_scene(TEN, place, direct_normal=700, diffuse_horizontal=120) for place in (
        MUNICH, ph.Place(48.14, 11.58, altitude=520, up=(0, 1, 0), north=(0, 0, -1))
    ))  # fmt: skip
    for x, y, z in np.random.default_rng(1).normal(size=(5, 3)):
        assert irradiance(given, (x, z, -y)) == pytest.approx(irradiance(plain, (x, y, z)), rel=1e-4)


def test_walls_cast_shadows_on_the_ground():
    ground = pv.Plane(i_size=40, j_size=40, i_resolution=8, j_resolution=8)
    box = pv.Box((-2, 2, -2, 2, 0.0, 10))
    scene = ph.daylight_scene(TEN, MUNICH, direct_normal=700, diffuse_horizontal=120)
    lit = ground.phong.irradiance(scene, occluders=[box])
    towards = ph.sun_position(TEN, MUNICH).direction[0]
    shadow = -towards[:2] / towards[2] * 5.0  # of a point in the middle of the box
    assert lit["irradiance_light_sun"][ground.find_closest_point((*shadow, 0.0)), 0] == 0.0
    assert lit["irradiance_light_sun"][0, 0] > 0.0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"time": [TEN, TEN]}, "time must be one time; got 2 times"),
        ({"direct_normal": 700}, "diffuse_horizontal must be given with the other irradiance"),
        ({"direct_normal": -1, "diffuse_horizontal": 1}, "direct_normal must be a finite number >= 0; got -1"),
        ({"direct_normal": 1, "diffuse_horizontal": math.inf}, "diffuse_horizontal must be a finite number"),
        ({"scale": 0}, "scale must be a finite number > 0; got 0"),
        ({"albedo": 2}, "albedo must be"),
        ({"model": "rainy"}, "model must be one of"),
        ({"time": "2026-06-21T10:00"}, "times must be times with a time zone"),
    ],
)
def test_scenes_that_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        ph.daylight_scene(**{"time": TEN, "place": MUNICH} | given)
