"""Colours of temperatures, by Planck's law and colour-matching functions."""

import math

import numpy as np
import pytest

import pvphong as ph
from pvphong.base.color import XYZ_OF_RGB

WAVELENGTHS = np.arange(380.0, 781.0, 1.0)


def lobe(middle, below, above):
    width = np.where(middle > WAVELENGTHS, below, above)
    return np.exp(-0.5 * ((WAVELENGTHS - middle) / width) ** 2)


# Wyman, Sloan and Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2013
MATCHING = np.stack(
    [
        1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2),
        0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
        1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8),
    ]
)


def chromaticity(xyz):
    return np.array(xyz[:2]) / sum(xyz)


def planck(temperature):
    """Return x and y of a black body, from its spectrum."""
    meters = 1e-9 * WAVELENGTHS
    spectrum = 1.0 / (meters**5 * np.expm1(0.014387769 / (meters * temperature)))
    return chromaticity(MATCHING @ spectrum)


@pytest.mark.parametrize("temperature", [2300, 2856, 3200, 4000, 5000, 6500, 9000, 15000, 25000])
def test_the_chromaticity_is_that_of_plancks_spectrum(temperature):
    found = chromaticity(XYZ_OF_RGB @ ph.kelvin(temperature))
    np.testing.assert_allclose(found, planck(temperature), atol=0.004)


def test_it_is_the_standard_illuminant_a():
    np.testing.assert_allclose(chromaticity(XYZ_OF_RGB @ ph.kelvin(2856)), (0.44757, 0.40745), atol=6e-4)


def test_colours_turn_from_red_to_blue_without_jumps():
    colors = np.array([ph.kelvin(t) for t in np.geomspace(1667.0, 25000.0, 4000)])
    assert (colors.max(axis=1) == 1.0).all()
    assert (colors.min(axis=1) >= 0.0).all()
    assert (np.diff(colors[:, 2] - colors[:, 0]) > -1e-6).all()
    assert np.abs(np.diff(colors, axis=0)).max() < 0.003
    assert np.abs(np.array(ph.kelvin(6600)) - 1.0).max() < 0.07  # nearly white


@pytest.mark.parametrize("bad", [1666, 25001, -1, 0, math.nan, "warm"])
def test_other_temperatures_are_refused(bad):
    with pytest.raises(ValueError, match=r"^temperature must be a finite number >= 1667 and <= 25000; got"):
        ph.kelvin(bad)
