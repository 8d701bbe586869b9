"""Lights without a size at the limits of float64; the oracle in tests/stability covers the rest."""

import math

import numpy as np
import pytest

from pvphong.optics.lights import PointLight, SpotLight
from pvphong.shading.plan.lights import without

LARGEST = np.finfo(np.float64).max


@pytest.mark.parametrize(
    "attenuation", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1e300, 1e300, 1e300), (1e-300, 1e-300, 1e-300)]
)
@pytest.mark.parametrize("distance", [5e-324, 1e-310, 1e-160, 1e160, 1e300, LARGEST])
def test_extreme_distances_have_a_direction_and_no_nan(attenuation, distance):
    arrival = PointLight(attenuation=attenuation).arrival(np.array([[distance, -distance], [0, 0], [0, 0]]))
    np.testing.assert_array_equal(arrival.direction, [[-1, 1], [0, 0], [0, 0]])
    assert not np.isnan(arrival.strength).any()
    assert (arrival.strength >= 0).all()


def test_a_distance_beyond_float64_is_taken_for_its_largest():
    arrival = PointLight(position=(LARGEST, 0, 0), attenuation=(0, 1, 0)).arrival(np.array([[-LARGEST], [0.0], [0.0]]))
    assert arrival.direction.tolist() == [[1.0], [0.0], [0.0]]
    assert arrival.strength[0] == 1.0 / LARGEST


def test_at_the_very_point_where_it_is_it_has_no_direction_to_be_taken_as():
    """This occurs in a report on a mesh around the light."""
    for lamp in (PointLight(position=(1, 2, 3)), SpotLight(position=(1, 2, 3))):
        assert without(lamp, "position", (1.0, 2.0, 3.0)) == (lamp, 1.0)
        other, _ = without(lamp, "position", (1.0, 2.0, 2.0))
        assert other.direction == (0.0, 0.0, -1.0)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 1e6, 1e300])
@pytest.mark.parametrize("direction", [(0, 0, -1), (1, 2, -2), (0.1, 0.7, 0.3), (0, 0, -1e-320), (0, 0, -1e300)])
def test_strength_is_one_on_the_axis_however_long_the_direction(exponent, direction):
    axis = np.ldexp(direction, -math.frexp(max(map(abs, direction)))[1])
    arrival = SpotLight(direction=direction, exponent=exponent).arrival(4.0 * axis[:, None])
    assert arrival.strength[0] == pytest.approx(1.0, rel=1e-15)
