"""Where a point light has weakened."""

import math

import numpy as np
import pytest
from views import place, view

from pvphong.optics.lights import PointLight
from pvphong.studio.gizmos import point


@pytest.mark.parametrize("attenuation", [(1, 1, 0), (1, 0, 4), (2, 0.5, 0.01), (0, 1, 0), (0, 0, 3), (1, 0, 1e-7)])
@pytest.mark.parametrize("fraction", [0.5, 1 / 256])
def test_it_has_fallen_to_the_fraction_there(attenuation, fraction):
    light = PointLight(attenuation=attenuation)
    distance = point.falls_to(light, fraction)
    constant, linear, quadratic = attenuation
    left = 1 / (constant + linear * distance + quadratic * distance**2)
    assert left == pytest.approx(fraction / (constant or 1), rel=1e-12)


def test_without_falloff_there_is_no_radius():
    light = PointLight(attenuation=(3, 0, 0))
    assert point.falls_to(light, 0.5) is None
    assert list(point.handles(light, place(), view())) == ["position"]


def test_the_radius_handle_lies_to_the_right_at_the_radius():
    light, seen_from = PointLight(position=(1, 0, 0), attenuation=(1, 0, 4)), view()
    found = point.handles(light, place(), seen_from)
    assert math.dist(found["position"], found["radius"]) == pytest.approx(0.5)
    shift = seen_from.project(found["radius"]) - seen_from.project(found["position"])
    np.testing.assert_allclose(shift[1], 0, atol=1e-9)
    assert shift[0] > 0
