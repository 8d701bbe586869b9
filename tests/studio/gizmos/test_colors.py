"""Steps of colour: what stays, and that a step back undoes one on."""

import colorsys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pvphong.optics.lights import PointLight
from pvphong.studio.gizmos.colors import hue_turned, luminance, recolored, warmed

CHANNEL = st.floats(0.05, 4.0)
COLORS = st.tuples(CHANNEL, CHANNEL, CHANNEL).filter(lambda color: max(color) > 1.1 * min(color))


def test_the_luminance_is_that_of_bt_709():
    """Primaries of sRGB in CIE XYZ, IEC 61966-2-1: the middle row of the matrix."""
    assert [luminance(color) for color in ((1, 0, 0), (0, 1, 0), (0, 0, 1))] == [0.2126, 0.7152, 0.0722]
    assert luminance(0.5) == pytest.approx(0.5, abs=1e-15)


@given(COLORS)
def test_a_turn_keeps_value_and_saturation_and_a_turn_back_undoes_it(color):
    on = hue_turned(color, 15.0)
    before, after = colorsys.rgb_to_hsv(*color), colorsys.rgb_to_hsv(*on)
    assert after[1:] == pytest.approx(before[1:], rel=1e-9)
    assert (after[0] - before[0]) % 1.0 == pytest.approx(15 / 360, abs=1e-9)
    assert hue_turned(on, -15.0) == pytest.approx(color, rel=1e-9)


@given(COLORS)
def test_warmth_keeps_the_luminance_and_cooling_undoes_it(color):
    warm = warmed(color, 1.0)
    assert luminance(warm) == pytest.approx(luminance(color), rel=1e-9)
    assert warm[0] / warm[2] > color[0] / color[2]
    assert warmed(warm, -1.0) == pytest.approx(color, rel=1e-9)


def test_grey_gets_a_hue_and_black_stays_black():
    for degrees in (15.0, -15.0):
        red, green, blue = hue_turned(0.8, degrees)
        assert max(red, green, blue) == 0.8
        assert min(red, green, blue) < 0.5
    assert warmed(0.0, 1.0) == (0.0, 0.0, 0.0)


def test_all_colours_that_a_light_has_of_its_own_change():
    light = PointLight(diffuse=(1, 0.5, 0.2), specular=(0.2, 0.5, 1.0), name="it")
    changed = recolored(light, lambda color: tuple(np.array(color)[::-1]))
    assert (changed.diffuse, changed.specular) == ((0.2, 0.5, 1), (1, 0.5, 0.2))
    assert changed.ambient == light.ambient
    assert recolored(PointLight(), lambda _: (1.0, 0, 0)).specular is None
