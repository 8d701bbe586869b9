"""The display transform, by formulas in Python's own numbers."""

import math

import numpy as np
import pytest

import pvphong as ph

COLORS = np.random.default_rng(3).gamma(0.7, 1.0, (40_000, 3)).astype(np.float32)
COLORS[:4] = [0, 0, 0], [1, 1, 1], [np.nan, 0.5, 2.0], [-0.5, np.inf, 0.25]


def byte(value, exposure, tone):
    """Return one channel as a screen shows it."""
    value = 0.0 if math.isnan(value) else max(value * 2.0**exposure, 0.0)
    if tone == "filmic" and value > 0.6:
        value = 0.6 + 0.4 * (1.0 - math.exp((0.6 - value) / 0.4))
    return 255.0 * min(value, 1.0)


@pytest.mark.parametrize("exposure", [-3.0, 0.0, 0.37, 4.0])
@pytest.mark.parametrize("tone", ["none", "filmic"])
@pytest.mark.parametrize("kind", ["float32", "float64"])
def test_it_is_the_formula_rounded(exposure, tone, kind):
    given = COLORS.astype(kind)
    before = given.copy()
    shown = ph.Display(exposure, tone)(given)
    assert shown.dtype == np.uint8
    expected = [[byte(channel, exposure, tone) for channel in row] for row in given[:3000].tolist()]
    assert np.abs(shown[:3000] - np.array(expected)).max() <= 0.5 + 1e-3
    np.testing.assert_array_equal(given, before)
    np.testing.assert_array_equal(ph.Display(exposure, tone)(given[17:19]), shown[17:19])


def test_the_default_shows_what_numpy_rounds():
    finite = COLORS[4:]
    np.testing.assert_array_equal(ph.Display()(finite), np.rint(np.clip(finite, 0.0, 1.0) * np.float32(255.0)))


def test_the_filmic_curve_rises_and_leaves_no_colour_clipped_that_is_not_far_above_1():
    rising = np.linspace(0.0, 2.5, 5000, dtype=np.float32)[:, None].repeat(3, axis=1)
    shown = ph.Display(tone="filmic")(rising)[:, 0].astype(int)
    assert (np.diff(shown) >= 0).all()
    assert np.diff(shown).max() == 1
    assert shown[rising[:, 0] < 0.6].tolist() == np.rint(255 * rising[rising[:, 0] < 0.6, 0]).tolist()
    assert shown[np.searchsorted(rising[:, 0], 2.0)] < 254


def test_clipping_marks_what_is_1_or_more_and_what_is_black():
    colors = np.array([[0.2, 0.3, 0.4], [0.2, 0.5, 0.3], [0.0, 0.0, 0.0], [0.0, 0.01, 0.0]])
    shown = ph.Display(1.0, overlay="clipping")(colors)
    assert shown.tolist() == [[102, 153, 204], [255, 0, 0], [0, 0, 255], [0, 5, 0]]


def test_false_colours_are_bands_of_luminance_and_exposure_moves_them():
    stops = np.arange(-6.0, 3.0, 0.5)
    grey = (0.18 * 2.0**stops)[:, None].repeat(3, axis=1)
    bands = ph.Display(overlay="false color")(grey)
    assert len(np.unique(bands, axis=0)) == 9
    assert bands[stops == 0.0].tolist() == [[40, 160, 40]]
    assert bands[-1].tolist() == [255, 0, 0]  # 2.5 stops above middle grey is brighter than white
    np.testing.assert_array_equal(ph.Display(1.0, overlay="false color")(grey)[:-2], bands[2:])


def test_it_writes_into_an_array_that_is_given():
    out = np.zeros((len(COLORS), 3), np.uint8)
    assert ph.Display()(COLORS, out) is out
    np.testing.assert_array_equal(out, ph.Display()(COLORS))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"exposure": 11}, r"^exposure must be a finite number >= -10 and <= 10; got 11"),
        ({"exposure": "bright"}, r"^exposure must be a finite number"),
        ({"tone": "film"}, r"^tone must be one of 'none', 'filmic'; got film\. Did you mean 'filmic'"),
        ({"overlay": "zebra"}, r"^overlay must be one of 'none', 'clipping', 'false color'; got zebra"),
    ],
)
def test_bad_values_are_refused(fields, message):
    with pytest.raises(ValueError, match=message):
        ph.Display(**fields)


@pytest.mark.parametrize(
    ("rgb", "out", "message"),
    [
        (np.zeros((2, 3), np.uint8), None, r"^rgb must be an array of floats, .* got an array of uint8\. Divide"),
        (np.zeros((2, 4)), None, r"^rgb must be .* got an array of shape \(2, 4\)"),
        ("red", None, r"^rgb must be"),
        (COLORS, np.zeros((1, 3), np.uint8), r"^out must be an array of uint8 with the shape of rgb, \(40000, 3\)"),
        (COLORS, np.zeros(COLORS.shape), r"^out must be .* got an array of float64 with shape \(40000, 3\)"),
    ],
)
def test_arrays_that_are_no_colours_are_refused(rgb, out, message):
    with pytest.raises(ValueError, match=message):
        ph.Display()(rgb, out)


def test_a_list_of_colours_is_taken():
    assert ph.Display()([[0.0, 0.5, 2.0]]).tolist() == [[0, 128, 255]]
