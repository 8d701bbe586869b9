"""VTK as the peer: it draws the scene that is measured."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.studies.accuracy import frames

GREEN = ph.Material(ambient=0.1, diffuse=(0.2, 0.6, 0.3))
ABOVE = ph.Viewer(position=(0, 0, 3), up=(0, 1, 0))


@pytest.fixture
def square():
    mesh = pv.Plane(i_resolution=4, j_resolution=4).triangulate()
    mesh.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (mesh.n_points, 1))
    return mesh


def center(plotter):
    image = plotter.screenshot(return_img=True)
    return image[image.shape[0] // 2, image.shape[1] // 2] / 255


def test_both_windows_show_the_evaluated_colour(square):
    scene = ph.Scene(lights=[ph.DirectionalLight(direction=(0, -1, -2))], viewer=ABOVE)
    colors = ph.evaluate(square.points, square.point_data.active_normals, scene, GREEN).rgb
    windows = [frames._per_pixel(square, scene, GREEN, None), frames._lit(square, colors, scene, None)]
    try:
        for window in windows:
            np.testing.assert_allclose(center(window), colors[0], atol=1.5 / 255)
    finally:
        for window in windows:
            window.close()


def test_per_pixel_follows_the_model_matrix(square):
    scene = ph.Scene(lights=[ph.DirectionalLight(direction=(0, 0, -1))], viewer=ABOVE)
    angle = np.radians(50.0)
    matrix = np.eye(4)
    matrix[1:3, 1:3] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    window = frames._per_pixel(square, scene, GREEN, matrix)
    try:
        lit = np.multiply(GREEN.diffuse, np.cos(angle)) + 0.1 * 0.2
        np.testing.assert_allclose(center(window), lit, atol=1.5 / 255)
    finally:
        window.close()


def test_frames_can_be_drawn_and_name_their_driver(square):
    scene = ph.Scene(lights=[ph.PointLight(position=(1, 1, 2))], viewer=ABOVE)
    with frames.vtk_frames(square, np.ones((square.n_points, 3)), scene, GREEN) as drawn:
        drawn.per_pixel()
        drawn.lit_array()
        assert drawn.changed == ""
        assert len(drawn.driver) > 5


def test_what_vtk_cannot_draw_is_drawn_nearly_and_said(square):
    shiny = replace(GREEN, specular=0.5, shininess=40)
    blinn = ph.Scene(
        lights=[ph.DirectionalLight(direction=(0, -1, -2))],
        viewer=ABOVE,
        light_model=ph.LightModel(reflection="blinn-phong"),
    )
    with frames.vtk_frames(square, np.ones((square.n_points, 3)), blinn, shiny) as drawn:
        assert "Blinn-Phong" in drawn.changed


def test_what_vtk_cannot_draw_at_all_is_refused(square):
    flat = np.diag([1.0, 1.0, 0.0, 1.0])
    scene = ph.Scene(lights=[ph.DirectionalLight(direction=(0, -1, -2))], viewer=ABOVE)
    with (
        pytest.raises(ValueError, match="VTK can draw"),
        frames.vtk_frames(square, np.ones((square.n_points, 3)), scene, GREEN, flat),
    ):
        pass
