"""The point light: attenuation by its closed form, over the whole range of distances."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pvphong.optics.lights import PointLight, SpotLight

U = 2.0**-53
LARGEST = np.finfo(np.float64).max
QUICK = settings(max_examples=150, derandomize=True, deadline=None, database=None)


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


def test_inverse_square():
    strength = arrival_along_x([1.0, 2.0, 10.0], attenuation=(0, 0, 1)).strength
    np.testing.assert_array_equal(strength, [1.0, 0.25, 0.01])


@pytest.mark.parametrize(
    ("attenuation", "expected"), [((1, 0, 0), 1.0), ((4, 1, 1), 0.25), ((0, 1, 0), 0.0), ((0, 0, 1), 0.0)]
)
def test_on_the_light_itself(attenuation, expected):
    arrival = arrival_along_x([0.0], attenuation=attenuation)
    assert arrival.strength.tolist() == [expected]
    assert not arrival.direction.any()


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
    light = PointLight(position=(LARGEST, 0, 0), attenuation=(0, 1, 0))
    arrival = light.arrival(np.array([[-LARGEST], [0.0], [0.0]]))
    assert arrival.direction.tolist() == [[1.0], [0.0], [0.0]]
    assert arrival.strength[0] == 1.0 / LARGEST


def test_at_the_very_point_where_it_is_it_has_no_direction_to_be_taken_as():
    """As in a report on a mesh around it."""
    for lamp in (PointLight(position=(1, 2, 3)), SpotLight(position=(1, 2, 3))):
        assert lamp.without("position", (1.0, 2.0, 3.0)) == (lamp, 1.0)
        other, _ = lamp.without("position", (1.0, 2.0, 2.0))
        assert other.direction == (0.0, 0.0, -1.0)
