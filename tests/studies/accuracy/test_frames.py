"""VTK as the peer: it draws the scene that is measured."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.studies.accuracy import frames

GREEN = ph.Material(ambient=0.1, diffuse=(0.2, 0.6, 0.3))
SCENE = ph.Scene([ph.DirectionalLight(direction=(0, -1, -2))], ph.Viewer(position=(0, 0, 3), up=(0, 1, 0)))
COSINE, SINE = np.cos(np.radians(50.0)), np.sin(np.radians(50.0))
TILTED = np.array([[1.0, 0, 0, 0], [0, COSINE, -SINE, 0], [0, SINE, COSINE, 0], [0, 0, 0, 1]])


@pytest.fixture
def square():
    mesh = pv.Plane(i_resolution=4, j_resolution=4).triangulate()
    mesh.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (mesh.n_points, 1))
    return mesh


def shown(window):
    """The colour in the middle of a window, which is closed."""
    image = window.screenshot(return_img=True)
    window.close()
    return image[image.shape[0] // 2, image.shape[1] // 2] / 255


@pytest.mark.parametrize("matrix", [None, TILTED], ids=["as it is", "tilted"])
def test_both_windows_show_the_evaluated_colour(square, matrix):
    colors = ph.evaluate(square.points, square.point_data.active_normals, SCENE, GREEN, matrix=matrix).rgb
    for window in (frames._per_pixel(square, SCENE, GREEN, matrix), frames._lit(square, colors, SCENE, matrix)):
        np.testing.assert_allclose(shown(window), colors[0], atol=1.5 / 255)


def test_frames_can_be_drawn_and_say_by_what_and_what_was_changed(square):
    shiny = replace(GREEN, specular=0.5, shininess=40)
    for model, changed in ((ph.LightModel(), ""), (ph.LightModel(reflection="blinn-phong"), "without Blinn-Phong")):
        scene = replace(SCENE, light_model=model)
        with frames.vtk_frames(square, np.ones((square.n_points, 3)), scene, shiny) as drawn:
            drawn.per_pixel()
            drawn.lit_array()
            assert len(drawn.driver) > 5
            assert drawn.changed.startswith(changed)
            assert bool(drawn.changed) is bool(changed)


def test_what_vtk_cannot_draw_at_all_is_refused(square):
    flat = np.diag([1.0, 1.0, 0.0, 1.0])
    drawn = frames.vtk_frames(square, np.ones((square.n_points, 3)), SCENE, GREEN, flat)
    with pytest.raises(ValueError, match="VTK can draw"), drawn:
        pass
