"""Lights without a size: parallel light, attenuation by its closed form over all distances, and a spot's falloff."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight

U = 2.0**-53
LARGEST = np.finfo(np.float64).max
QUICK = settings(max_examples=150, derandomize=True, deadline=None, database=None)


# --- parallel


@pytest.mark.parametrize(
    "direction", [(0, 0, -1), (1, -2, 3), (1e-320, 0, 3e-320), (1e308, -1e308, 5), (1e-200, 1e200, 0)]
)
def test_parallel_light_arrives_everywhere_against_its_travel_as_a_unit_vector(direction):
    points = np.array([[0.0, 1e300, np.nan], [0.0, -1e300, 0.0], [0.0, 0.0, np.inf]])
    arrival = DirectionalLight(direction=direction).arrival(points)
    with mpmath.workdps(50):
        length = mpmath.sqrt(mpmath.fsum(mpmath.mpf(x) ** 2 for x in direction))
        exact = [float(mpmath.mpf(x) / length) for x in direction]
    assert arrival.strength == 1.0
    np.testing.assert_allclose(
        np.broadcast_to(arrival.direction, (3, 3)), np.tile([-x for x in exact], (3, 1)).T, rtol=0, atol=4 * U
    )


# --- attenuation


def arrival_along_x(distances, **fields):
    """What arrives on the x axis at some distances from a light in the origin."""
    points = np.zeros((3, len(distances)))
    points[0] = distances
    return PointLight(**fields).arrival(points)


def wide_floats(lowest=-300, highest=300):
    return st.tuples(st.floats(1, 2, exclude_max=True), st.integers(lowest, highest)).map(lambda x: math.ldexp(*x))


@pytest.mark.parametrize("attenuation", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (2, 3, 0), (0.5, 0, 7), (1, 0.25, 0.125)])
@given(distance=wide_floats())
@QUICK
def test_attenuation_is_the_closed_form(attenuation, distance):
    c, linear, quadratic = (Fraction(x) for x in attenuation)
    d = Fraction(distance)
    expected = float(1 / (c + linear * d + quadratic * d * d))
    strength = float(arrival_along_x([distance], attenuation=attenuation).strength[0])
    # five roundings; a denominator beyond float64 arrives as nothing
    assert strength == pytest.approx(expected, rel=8 * U, abs=4 / LARGEST)


@pytest.mark.parametrize(
    "attenuation", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1e300, 1e300, 1e300), (1e-300, 1e-300, 1e-300)]
)
@pytest.mark.parametrize("distance", [5e-324, 1e-310, 1e-160, 1e160, 1e300, LARGEST])
def test_extreme_distances_have_a_direction_and_no_nan(attenuation, distance):
    arrival = arrival_along_x([distance, -distance], attenuation=attenuation)
    np.testing.assert_array_equal(arrival.direction, [[-1, 1], [0, 0], [0, 0]])
    assert not np.isnan(arrival.strength).any()
    assert (arrival.strength >= 0).all()


def test_a_distance_beyond_float64_is_taken_for_its_largest():
    arrival = PointLight(position=(LARGEST, 0, 0), attenuation=(0, 1, 0)).arrival(np.array([[-LARGEST], [0.0], [0.0]]))
    assert arrival.direction.tolist() == [[1.0], [0.0], [0.0]]
    assert arrival.strength[0] == 1.0 / LARGEST


def test_at_the_very_point_where_it_is_it_has_no_direction_to_be_taken_as():
    """As in a report on a mesh around it."""
    for lamp in (PointLight(position=(1, 2, 3)), SpotLight(position=(1, 2, 3))):
        assert lamp.without("position", (1.0, 2.0, 3.0)) == (lamp, 1.0)
        other, _ = lamp.without("position", (1.0, 2.0, 2.0))
        assert other.direction == (0.0, 0.0, -1.0)


# --- a spot's falloff


def seen_from(angles):
    """Points (3, n) about a distance of 4 below the origin, at `angles` (radians) off the axis of a light there."""
    angles = np.asarray(angles, dtype=float)
    return -4.0 * np.array([np.sin(angles), np.zeros_like(angles), np.cos(angles)])


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 2.0, 25.0, 128.0, 1e4, 1e6])
def test_strength_is_the_cosine_to_the_exponent(exponent):
    width = 3 / math.sqrt(1 + exponent)
    points = seen_from(np.linspace(0, min(width, math.radians(89)), 40))
    with mpmath.workdps(50):
        lengths = [mpmath.sqrt(mpmath.fsum(mpmath.mpf(x) ** 2 for x in p)) for p in points.T.tolist()]
        cosines = [-mpmath.mpf(z) / length for z, length in zip(points[2].tolist(), lengths, strict=True)]
        expected = [float(cosine ** mpmath.mpf(exponent)) for cosine in cosines]
    # the stored ray's own rounding moves the cosine by √(2d)·u for a chord distance d; beside it a few roundings
    bound = 8 * U * (1 + math.sqrt(exponent) * 3 + exponent * width**2)
    found = SpotLight(cone_angle=90, exponent=exponent).arrival(points).strength
    np.testing.assert_allclose(found, expected, rtol=bound, atol=1e-300)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 1e6, 1e300])
@pytest.mark.parametrize("direction", [(0, 0, -1), (1, 2, -2), (0.1, 0.7, 0.3), (0, 0, -1e-320), (0, 0, -1e300)])
def test_strength_is_one_on_the_axis_however_long_the_direction(exponent, direction):
    axis = np.ldexp(direction, -math.frexp(max(map(abs, direction)))[1])
    arrival = SpotLight(direction=direction, exponent=exponent).arrival(4.0 * axis[:, None])
    assert arrival.strength[0] == pytest.approx(1.0, rel=1e-15)
