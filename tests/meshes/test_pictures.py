"""Images of lit meshes, and conversion of their colours to HSV and CIE XYZ."""

import colorsys
import os
import subprocess
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.vtkCommonCore import vtkMath

import pvphong as ph
from pvphong import Viewer
from pvphong.meshes import pictures
from pvphong.meshes.pictures import HEADLESS_PACKAGES, draw, drawing_window, leaves, save_picture


@pytest.fixture
def fresh_trial():
    drawing_window.cache_clear()
    yield
    drawing_window.cache_clear()


def square(color, center=(0.0, 0.0, 0.0)):
    mesh = pv.Plane(center=center)
    mesh["phong"] = np.tile(np.asarray(color, np.float32), (mesh.n_points, 1))
    return mesh


FACING = Viewer(position=(0, 0, 5), parallel=True, parallel_scale=1.0)


def test_pixels_are_the_array_and_not_lit_again_on_the_background():
    mesh = square((0.25, 0.5, 1.0))
    mesh["other"] = np.zeros((mesh.n_points, 3), np.float32)
    before, environment = mesh.copy(), dict(os.environ)
    image = draw(mesh, FACING, size=(100, 80))
    assert (mesh, dict(os.environ)) == (before, environment)
    assert image.shape == (80, 100, 3)
    assert image.dtype == np.uint8
    np.testing.assert_allclose(image[40, 50].astype(float), 255 * np.array((0.25, 0.5, 1.0)), rtol=0, atol=1)
    np.testing.assert_array_equal(image[0, 0], (255, 255, 255))
    image = draw(mesh, FACING, name="other", size=(60, 60), background="lime")
    np.testing.assert_array_equal(image[[30, 0], [30, 0]], [(0, 0, 0), (0, 255, 0)])


@pytest.mark.parametrize(
    ("viewer", "center", "rows", "columns"),
    [
        (FACING, (0, 0, 0), (50, 150), (50, 150)),  # parallel scale is half the image's height: an edge of 1 in 2
        (Viewer(position=(0, 0, 5), view_angle=2 * np.degrees(np.arctan(1 / 5))), (0, 0, 0), (50, 150), (50, 150)),
        (FACING, (0, 0.75, 0), (0, 75), (50, 150)),  # up is up
        (replace(FACING, clipping_range=(0.1, 0.2)), (0, 0, 0), (50, 150), (50, 150)),  # beyond it is drawn too
        (replace(FACING, position=(0, 0, 5000)), (0, 0, 0), (50, 150), (50, 150)),  # and beyond VTK's initial range
        (Viewer(position=(0, 0, 5), focal_point=(0, 0, 6)), (0, 0, 0), (), ()),  # out of view
    ],
)
def test_a_mesh_is_seen_where_the_viewer_has_it(viewer, center, rows, columns):
    dark = (draw(square((0, 0, 0), center), viewer, size=(200, 200)) < 128).all(axis=2)
    for axis, expected in ((1, rows), (0, columns)):
        seen = np.flatnonzero(dark.any(axis=axis))
        assert [*seen[:1], *(seen[-1:] + 1)] == pytest.approx(list(expected), abs=1)


def test_blocks_are_drawn_and_empty_ones_passed_over():
    nested = pv.MultiBlock({"deep": square((0, 0, 1), center=(0.6, 0, 0)), "empty": pv.PolyData()})
    blocks = pv.MultiBlock({"red": square((1, 0, 0), center=(-0.6, 0, 0)), "none": None, "nested": nested})
    image = draw(blocks, FACING, size=(200, 200))
    np.testing.assert_array_equal(image[100, 50], (255, 0, 0))
    np.testing.assert_array_equal(image[100, 150], (0, 0, 255))
    assert len(leaves(blocks)) == 2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"size": (0, 10)}, "width must be a finite number >= 1 and <= 8192; got"),
        ({"size": (10, 100_000)}, "height must be a finite number >= 1 and <= 8192; got"),
        ({"background": "whyte"}, "background must be .* got whyte"),
    ],
)
def test_pictures_that_cannot_be_drawn_are_refused(options, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        draw(square((0, 0, 0)), FACING, **options)


@pytest.mark.usefixtures("fresh_trial")
@pytest.mark.parametrize(
    ("status", "output"), [(-11, ""), (1, "vtkEGLRenderWindow 255.0"), (0, ""), (0, "vtkEGLRenderWindow 0.0")]
)
def test_a_machine_that_cannot_draw_is_told_what_it_needs(monkeypatch, status, output):
    def trial(command, **_options):
        return subprocess.CompletedProcess(command, status, stdout=output, stderr="")

    monkeypatch.setattr(pictures.subprocess, "run", trial)
    with pytest.raises(ValueError, match=f"VTK cannot draw on this machine.* apt-get install {HEADLESS_PACKAGES}"):
        draw(square((0, 0, 0)), FACING)


def test_a_picture_is_saved_to_the_last_pixel_in_a_folder_that_exists(tmp_path):
    image = np.arange(4 * 5 * 3, dtype=np.uint8).reshape(4, 5, 3)
    save_picture(image, tmp_path / "small.png")
    saved = pv.read(tmp_path / "small.png")
    np.testing.assert_array_equal(saved.active_scalars.reshape(4, 5, 3)[::-1], image)  # VTK's rows start at the bottom
    assert [path.name for path in tmp_path.iterdir()] == ["small.png"]
    with pytest.raises(ValueError, match="path must be in a folder that exists"):
        save_picture(image, tmp_path / "no" / "small.png")


# --- colours in other spaces ---

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
    """VTK decodes sRGB first, so it gets encoded colours."""
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
    assert view.n_points == grid.n_points - 1  # without the point in the middle
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
        (np.full((3, 3), 255, np.uint8), {}, "a uint8 array"),
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


def test_a_plot_has_the_exposure_that_is_asked_for_and_the_mesh_keeps_its_colours(lit):
    before = lit["phong"].copy()
    views = []
    for options in ({}, {"exposure": 1.0}, {"exposure": 1.0, "tone": "filmic"}):
        look = {"off_screen": True, "screenshot": True, "return_img": True, "window_size": (60, 60)}
        shown = lit.phong.plot(**options, **look, background="black")
        views.append(np.asarray(shown[-1] if isinstance(shown, tuple) else shown).astype(int))
    assert views[1].mean() > 1.3 * views[0].mean()
    assert 0 < np.abs(views[2] - views[1]).max() < 60
    np.testing.assert_array_equal(lit["phong"], before)
