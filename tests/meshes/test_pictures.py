import os
import subprocess
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

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
        (FACING, (0, 0, 0), (50, 150), (50, 150)),  # parallel scale is half the picture's height: an edge of 1 in 2
        (Viewer(position=(0, 0, 5), view_angle=2 * np.degrees(np.arctan(1 / 5))), (0, 0, 0), (50, 150), (50, 150)),
        (FACING, (0, 0.75, 0), (0, 75), (50, 150)),  # up is up
        (replace(FACING, clipping_range=(0.1, 0.2)), (0, 0, 0), (50, 150), (50, 150)),  # beyond it is drawn too
        (replace(FACING, position=(0, 0, 5000)), (0, 0, 0), (50, 150), (50, 150)),  # and beyond VTK's first one
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
    np.testing.assert_array_equal(saved.active_scalars.reshape(4, 5, 3)[::-1], image)  # VTK's rows start below
    assert [path.name for path in tmp_path.iterdir()] == ["small.png"]
    with pytest.raises(ValueError, match="path must be in a folder that exists"):
        save_picture(image, tmp_path / "no" / "small.png")
