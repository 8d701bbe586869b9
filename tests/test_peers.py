"""What pvphong is compared with: the textbook's NumPy gives the same colours, VTK draws the same scene."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong import peers
from pvphong.accuracy_rungs import Subject
from pvphong.textbook import textbook_colors

GREEN = ph.Material(ambient=0.1, diffuse=(0.2, 0.6, 0.3))
ABOVE = ph.Viewer(position=(0, 0, 3), up=(0, 1, 0))


def scenes():
    lights = [
        ph.DirectionalLight(direction=(1, -2, -3), diffuse=(0.5, 0.4, 0.3), ambient=0.1),
        ph.PointLight(position=(2, 1, 3), attenuation=(1, 0.1, 0.2), specular=(0.3, 0.5, 0.1), intensity=0.8),
        ph.SpotLight(position=(0, 0, 4), direction=(0.1, 0, -1), cone_angle=25, exponent=3),
        ph.DirectionalLight(frame="headlight", diffuse=0.1),
        ph.PointLight(on=False),
    ]
    viewer = ph.Viewer(position=(1, -3, 4), up=(0, 0, 1))
    for reflection in ("phong", "blinn-phong"):
        for local in (True, False):
            for two_sided in (True, False):
                model = ph.LightModel(reflection=reflection, local_viewer=local, two_sided=two_sided)
                yield ph.Scene(lights=lights, viewer=viewer, light_model=model)
    yield ph.Scene(lights=lights, viewer=replace(viewer, parallel=True), light_model=ph.LightModel(clamp=False))


@pytest.mark.parametrize("scene", list(scenes()), ids=lambda scene: str(scene.light_model))
def test_the_textbook_agrees_with_the_evaluator(scene):
    mesh = pv.ParametricTorus(u_res=40, v_res=40)
    material = ph.Material(diffuse=(0.4, 0.5, 0.6), specular=0.5, shininess=12, emission=(0.0, 0.1, 0.0))
    matrix = np.eye(4)
    matrix[:3] = [[1, 0.5, 0, 0.2], [0, 2, 0, 0], [0.1, 0, 1, -0.3]]
    for given in (None, matrix):
        subject = Subject(mesh.points, mesh.point_normals, scene, material, given)
        colors = textbook_colors(mesh.points, mesh.point_normals, scene, material, given)
        assert np.ptp(colors) > 0.3
        np.testing.assert_allclose(colors, subject.truth, atol=1e-9)


def test_the_textbook_knows_one_convention():
    with pytest.raises(ValueError, match="convention must be 'standard' for the textbook formula; got vtk"):
        textbook_colors(np.eye(3), np.eye(3), ph.Scene(light_model=ph.LightModel.vtk()), GREEN)


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
    windows = [peers._per_pixel(square, scene, GREEN, None), peers._lit(square, colors, scene, None)]
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
    window = peers._per_pixel(square, scene, GREEN, matrix)
    try:
        lit = np.multiply(GREEN.diffuse, np.cos(angle)) + 0.1 * 0.2
        np.testing.assert_allclose(center(window), lit, atol=1.5 / 255)
    finally:
        window.close()


def test_frames_can_be_drawn_and_name_their_driver(square):
    scene = ph.Scene(lights=[ph.PointLight(position=(1, 1, 2))], viewer=ABOVE)
    with peers.vtk_frames(square, np.ones((square.n_points, 3)), scene, GREEN) as frames:
        frames.per_pixel()
        frames.lit_array()
        assert frames.changed == ""
        assert len(frames.driver) > 5


def test_what_vtk_cannot_draw_is_drawn_nearly_and_said(square):
    shiny = replace(GREEN, specular=0.5, shininess=40)
    blinn = ph.Scene(
        lights=[ph.DirectionalLight(direction=(0, -1, -2))],
        viewer=ABOVE,
        light_model=ph.LightModel(reflection="blinn-phong"),
    )
    with peers.vtk_frames(square, np.ones((square.n_points, 3)), blinn, shiny) as frames:
        assert "Blinn-Phong" in frames.changed


def test_what_vtk_cannot_draw_at_all_is_refused(square):
    flat = np.diag([1.0, 1.0, 0.0, 1.0])
    scene = ph.Scene(lights=[ph.DirectionalLight(direction=(0, -1, -2))], viewer=ABOVE)
    with (
        pytest.raises(ValueError, match="VTK can draw"),
        peers.vtk_frames(square, np.ones((square.n_points, 3)), scene, GREEN, flat),
    ):
        pass
