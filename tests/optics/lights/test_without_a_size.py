"""Lights without a size on themselves and on their axis; else the oracle judges them, in tests/stability."""

import math

import numpy as np
import pytest

from pvphong.optics.lights import PointLight, SpotLight


def test_at_the_very_point_where_it_is_it_has_no_direction_to_be_taken_as():
    """As in a report on a mesh around it."""
    for lamp in (PointLight(position=(1, 2, 3)), SpotLight(position=(1, 2, 3))):
        assert lamp.without("position", (1.0, 2.0, 3.0)) == (lamp, 1.0)
        other, _ = lamp.without("position", (1.0, 2.0, 2.0))
        assert other.direction == (0.0, 0.0, -1.0)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 1e6, 1e300])
@pytest.mark.parametrize("direction", [(0, 0, -1), (1, 2, -2), (0.1, 0.7, 0.3), (0, 0, -1e-320), (0, 0, -1e300)])
def test_strength_is_one_on_the_axis_however_long_the_direction(exponent, direction):
    axis = np.ldexp(direction, -math.frexp(max(map(abs, direction)))[1])
    arrival = SpotLight(direction=direction, exponent=exponent).arrival(4.0 * axis[:, None])
    assert arrival.strength[0] == pytest.approx(1.0, rel=1e-15)
