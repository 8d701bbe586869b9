"""Lit colours as hue, saturation and value, and as CIE XYZ."""

import colorsys

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.vtkCommonCore import vtkMath

import pvphong as ph

SCENE = ph.Scene([ph.PointLight(position=(1, 1, 2), diffuse=(1.0, 0.7, 0.4)), ph.DirectionalLight(diffuse="skyblue")])
SHINY = ph.Material(ambient=0.1, diffuse=(0.2, 0.5, 0.9), specular=0.5, shininess=20)


@pytest.fixture(params=["float32", "float64"])
def lit(request):
    return pv.Sphere(theta_resolution=12, phi_resolution=12).phong.shade(SCENE, SHINY, precision=request.param)


def test_hsv_is_that_of_the_standard_library(lit):
    view = lit.phong.color_view("hsv")
    expected = [colorsys.rgb_to_hsv(*color) for color in lit["phong"].astype(float).tolist()]
    np.testing.assert_allclose(view["phong_hsv"], expected, atol=1e-5 if view["phong_hsv"].dtype == "float32" else 1e-9)
    assert np.ptp(view["phong_hsv"], axis=0).min() > 0.01


def test_xyz_is_vtks_once_its_curve_is_undone(lit):
    """VTK decodes sRGB's curve first, so it is given encoded colours."""
    linear = lit["phong"].astype(float)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    expected = np.empty_like(linear)
    for color, row in zip(encoded.tolist(), expected, strict=True):
        vtkMath.RGBToXYZ(color, row)
    np.testing.assert_allclose(lit.phong.color_view("xyz")["phong_xyz"], expected, atol=2e-4)


def test_above_1_hue_and_saturation_stay_and_value_tells_the_brightness_and_greys_have_neither(lit):
    view, lit["bright"] = lit.phong.color_view("hsv"), 4 * lit["phong"]
    bright = lit.phong.color_view("hsv", name="bright")["bright_hsv"]
    np.testing.assert_allclose(bright, view["phong_hsv"] * [1, 1, 4], rtol=1e-4)
    assert bright[:, 2].max() > 1
    assert bright[:, :2].max() <= 1
    greys = pv.PolyData(np.eye(3))
    greys["phong"] = np.array([[0.0] * 3, [0.5] * 3, [2.0] * 3])
    np.testing.assert_array_equal(greys.phong.color_view("hsv")["phong_hsv"], [[0, 0, 0], [0, 0, 0.5], [0, 0, 2]])


def test_other_datasets_give_their_surface_and_blocks_a_view_each():
    grid = pv.ImageData(dimensions=(3, 3, 3)).cast_to_unstructured_grid()
    grid["glow"] = np.tile((0.2, 0.4, 0.1), (grid.n_points, 1))
    view = grid.phong.color_view("hsv", name="glow")
    assert view.n_points == grid.n_points - 1  # but the one in the middle
    blocks = pv.MultiBlock({"a": grid, "gap": None, "in": pv.MultiBlock({"b": view})})
    found = blocks.phong.color_view("hsv", name="glow")
    assert (found.keys(), found["gap"]) == (["a", "gap", "in"], None)
    assert (view.active_scalars_name, "glow_hsv" in grid.point_data) == ("glow_hsv", False)
    for one in (found["a"], found["in"]["b"]):
        np.testing.assert_allclose(one["glow_hsv"], np.tile((5 / 18, 0.75, 0.4), (view.n_points, 1)))


@pytest.mark.parametrize(
    ("colors", "options", "message"),
    [
        (None, {}, "name must be"),
        (np.zeros((3, 3)), {"space": "lab"}, "space must be one of 'hsv', 'xyz'; got lab"),
        (np.zeros((3, 3)), {"name": "glow"}, "name must be one of 'phong'; got glow"),
        (np.zeros((3, 4)), {}, "three floats >= 0 per point"),
        (np.full((3, 3), 255, np.uint8), {}, "an array of uint8"),
        (np.full((3, 3), -0.1), {}, "a negative number"),
        (np.full((3, 3), np.nan), {}, "NaN"),
    ],
)
def test_what_is_no_lit_array_is_refused(colors, options, message):
    mesh = pv.PolyData(np.eye(3))
    mesh.clear_data()
    if colors is not None:
        mesh["phong"] = colors
    with pytest.raises(ValueError, match=message):
        mesh.phong.color_view(**{"space": "xyz"} | options)
