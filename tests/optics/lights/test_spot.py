"""The spot light: cosine to the power of its exponent inside the cone, dark outside."""

import math

import mpmath
import numpy as np
import pytest

from pvphong.optics.lights import PointLight, SpotLight


def to_light(angles):
    """Unit vectors towards a light that shines along −z, seen from `angles` (radians) off its axis."""
    angles = np.asarray(angles, dtype=float)
    return np.array([np.sin(angles), np.zeros_like(angles), np.cos(angles)])


def exact_factor(vector, exponent):
    """cos θ^exponent of the stored vector against the axis z."""
    with mpmath.workdps(50):
        length = mpmath.sqrt(mpmath.fsum(mpmath.mpf(float(x)) ** 2 for x in vector))
        return float((mpmath.mpf(float(vector[2])) / length) ** mpmath.mpf(exponent))


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 2.0, 25.0, 128.0, 1e4, 1e6])
def test_factor_is_the_cosine_to_the_exponent(exponent):
    width = 3 / math.sqrt(1 + exponent)
    rays = to_light(np.linspace(0, min(width, math.radians(89)), 40))
    factors = SpotLight(cone_angle=90, exponent=exponent).spot_factor(rays)
    expected = [exact_factor(ray, exponent) for ray in rays.T]
    # the stored ray's own rounding moves the cosine by √(2d)·u for a chord distance d; beside it a few roundings
    bound = 8 * 2.0**-53 * (1 + math.sqrt(exponent) * 3 + exponent * width**2)
    np.testing.assert_allclose(factors, expected, rtol=bound, atol=1e-300)


def test_factor_is_exactly_one_on_the_axis():
    for exponent in (0.0, 1.0, 1e6, 1e300):
        for direction in ((0, 0, -1), (1, 2, -2), (0.1, 0.7, 0.3)):
            axis = np.array(direction, float)[:, None]
            arrival = SpotLight(direction=direction, exponent=exponent).arrival(axis * 4.0)
            assert arrival.strength[0] == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("cone_angle", [1e-3, 1.0, 15.0, 30.0, 45.0, 60.0, 89.0, 90.0])
def test_edge_is_where_the_cone_angle_says(cone_angle):
    light = SpotLight(cone_angle=cone_angle, exponent=0)
    edge = math.radians(cone_angle)
    band = 8 * 2.0**-53 * max(1.0, 1.0 / edge)  # of the angle
    inside, outside = light.spot_factor(to_light([edge * (1 - 1e-12) - band, edge * (1 + 1e-12) + band]))
    assert (inside, outside) == (1.0, 0.0)


@pytest.mark.parametrize("exponent", [0.0, 0.3, 1.0, 1e6])
@pytest.mark.parametrize(("cone_angle", "outside"), [(20, [20.001, 30, 60, 90, 120, 179, 180]), (90, [90.1, 180])])
def test_dark_outside_and_behind(cone_angle, outside, exponent):
    light = SpotLight(cone_angle=cone_angle, exponent=exponent)
    assert not light.spot_factor(to_light(np.radians(outside))).any()


def test_just_inside_the_edge_the_factor_is_that_of_the_edge():
    light = SpotLight(cone_angle=60, exponent=3)
    assert light.spot_factor(to_light([math.radians(60 - 1e-9)]))[0] == pytest.approx(0.5**3, rel=1e-8)


def test_length_of_the_direction_does_not_count():
    rays = to_light(np.linspace(0, 0.5, 20))
    once = SpotLight(direction=(0, 0, -1), exponent=5).spot_factor(rays)
    for length in (1e-320, 1e-10, 3.0, 1e300):
        again = SpotLight(direction=(0, 0, -length), exponent=5).spot_factor(rays)
        np.testing.assert_allclose(again, once, rtol=1e-15)


def test_arrival_is_the_point_lights_times_the_factor():
    points = np.random.default_rng(1).normal(size=(3, 50)) - [[0], [0], [3]]
    fields = {"position": (0.1, 0.2, 0.3), "attenuation": (0.5, 0.25, 0.125)}
    spot = SpotLight(cone_angle=40, exponent=7, **fields)
    point = PointLight(**fields).arrival(points)
    arrival = spot.arrival(points)
    np.testing.assert_array_equal(arrival.direction, point.direction)
    np.testing.assert_array_equal(arrival.strength, point.strength * spot.spot_factor(point.direction))
    assert 0 < np.count_nonzero(arrival.strength) < 50


@pytest.mark.parametrize("exponent", [0.0, 1.0, 5e-324, 1e308])
def test_on_the_light_and_at_points_that_are_not_finite(exponent):
    points = np.array([[0.0, np.nan, np.inf, 1e308], [0.0] * 4, [0.0, 0.0, 0.0, -1e308]])
    strength = SpotLight(exponent=exponent, attenuation=(0, 0, 1)).arrival(points).strength
    assert not strength.any()


@pytest.mark.parametrize("offset", [1e3, 1e9, 1e16, 1e100])
@pytest.mark.parametrize("direction", [(0, 0, -1), (1, 2, -2), (1e-6, 0, 0), (0, 1e-20, 0)])
def test_to_pyvista_keeps_the_direction_far_from_the_origin(offset, direction):
    converted = SpotLight(position=(offset, -offset, offset), direction=direction).to_pyvista()
    kept = np.subtract(converted.GetFocalPoint(), converted.GetPosition())
    unit = np.array(direction) / np.linalg.norm(direction)
    assert np.linalg.norm(kept) > 0
    np.testing.assert_allclose(kept / np.linalg.norm(kept), unit, atol=1e-6)
