"""The directional light: one direction everywhere, strength 1."""

import mpmath
import numpy as np
import pytest

from pvphong.optics.lights import DirectionalLight


def exact_unit(vector):
    with mpmath.workdps(50):
        square = mpmath.fsum(mpmath.mpf(x) ** 2 for x in vector)
        return np.array([float(mpmath.mpf(x) / mpmath.sqrt(square)) for x in vector])


@pytest.mark.parametrize(
    "direction", [(0, 0, -1), (1, -2, 3), (1e-320, 0, 3e-320), (1e308, -1e308, 5), (1e-200, 1e200, 0)]
)
def test_arrives_against_its_travel_as_a_unit_vector(direction):
    arrival = DirectionalLight(direction=direction).arrival(np.zeros((3, 7)))
    assert arrival.strength == 1.0
    np.testing.assert_allclose(arrival.direction, -exact_unit(direction)[:, None], rtol=0, atol=4 * 2.0**-53)


def test_arrives_the_same_everywhere():
    points = np.array([[0.0, 1e300, np.nan], [0.0, -1e300, 0.0], [0.0, 0.0, np.inf]])
    arrival = DirectionalLight(direction=(1, 2, 2)).arrival(points)
    np.testing.assert_array_equal(np.broadcast_to(arrival.direction, (3, 3)), np.tile([[-1], [-2], [-2]], 3) / 3)
