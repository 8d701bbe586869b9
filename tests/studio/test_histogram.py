"""The histogram of the displayed luminance, against the pixels of a screenshot."""

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.studio.histogram import histogram_of

BACKGROUND = 200


@pytest.fixture
def lit(new_plotter):
    """A plotter with a lit ball before a light grey background, drawn once."""
    plotter = new_plotter((160, 120))
    plotter.set_background([BACKGROUND / 255.0] * 3)
    plotter.phong.add_light(ph.DirectionalLight(direction=(-1, -1, -2), name="sun"))
    plotter.phong.add_mesh(pv.Sphere(theta_resolution=60, phi_resolution=60), ph.Material(ambient=0.0, diffuse=0.7))
    plotter.show(auto_close=False)
    return plotter


def pixels(plotter):
    """Return the pixels of a screenshot that differ from the background."""
    shown = plotter.screenshot(return_img=True)[..., :3].reshape(-1, 3)
    return shown[(shown != BACKGROUND).any(axis=1)]


def test_the_pixels_of_the_mesh_are_counted(lit):
    shown = pixels(lit)
    found = lit.phong.histogram(bins=32)
    luminance = shown @ [0.2126, 0.7152, 0.0722] / 255.0
    expected = np.histogram(luminance, 32, (0.0, 1.0))[0]
    assert found.counts.sum() == len(shown)
    assert np.abs(found.counts - expected).sum() <= 0.01 * len(shown)  # float32 at the edges of bins
    np.testing.assert_allclose(found.edges, np.linspace(0.0, 1.0, 33))
    assert found.clipped_low == pytest.approx((shown.max(axis=1) == 0).mean())
    assert found.clipped_low > 0.0
    assert found.clipped_high == 0.0


def test_the_display_is_followed_but_for_its_overlay_and_gizmos(lit):
    before = lit.phong.histogram()
    lit.phong.add_gizmos()
    lit.phong.display = ph.Display(overlay="clipping")
    marked = lit.phong.histogram()
    np.testing.assert_array_equal(marked.counts, before.counts)
    assert lit.phong.display.overlay == "clipping"
    lit.phong.exposure = 3
    bright = lit.phong.histogram()
    assert bright.clipped_high > 0.3
    lit.phong.display = ph.Display(exposure=3, tone="filmic")
    assert lit.phong.histogram().clipped_high < bright.clipped_high


@pytest.mark.parametrize("change", ["gradient", "translucent"])
def test_background_and_mesh_are_told_apart(lit, change):
    count = lit.phong.histogram().counts.sum()
    if change == "gradient":
        lit.set_background("white", top="blue")
    else:
        lit.actors.popitem()[1].prop.opacity = 0.5
    assert lit.phong.histogram().counts.sum() == count


def test_a_subplot_counts_its_own_pixels(new_plotter):
    plotter = new_plotter((160, 80), shape=(1, 2))
    for column, size in enumerate((1.0, 0.5)):
        plotter.subplot(0, column)
        plotter.phong.add_light(ph.DirectionalLight(direction=(0, 0, -1)))
        plotter.phong.add_mesh(pv.Plane(i_size=size, j_size=size))
        plotter.camera_position = [(0, 0, 3), (0, 0, 0), (0, 1, 0)]
    plotter.show(auto_close=False)
    counts = []
    for column in (0, 1):
        plotter.subplot(0, column)
        counts.append(plotter.phong.histogram().counts.sum())
    assert counts[1] == pytest.approx(counts[0] / 4, rel=0.15)


def test_levels_and_clipped_shares():
    found = histogram_of(np.array([[0, 0, 0], [255, 255, 255], [0, 0, 255], [9, 9, 9]], np.uint8), 4)
    assert found.counts.tolist() == [3, 0, 0, 1]
    assert (found.clipped_low, found.clipped_high) == (0.25, 0.5)
    empty = histogram_of(np.zeros((0, 3), np.uint8))
    assert (empty.counts.sum(), empty.clipped_low, empty.clipped_high) == (0, 0.0, 0.0)


@pytest.mark.parametrize("bins", [0, 257, 2.0, True, "8"])
def test_a_number_of_bins_that_is_none_is_refused(lit, bins):
    with pytest.raises(ValueError, match=r"bins must be a whole number from 1 to 256; got .*"):
        lit.phong.histogram(bins)
