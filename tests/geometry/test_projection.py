"""The viewing pipeline against vtkCamera, vtkRenderer and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
import vtk
from cameras import as_array, random_camera

from pvphong import Viewer
from pvphong.pipeline import frustum, look_at, ortho, perspective, project


def vtk_display(camera, points, window_size):
    window, renderer = vtk.vtkRenderWindow(), vtk.vtkRenderer()
    window.SetOffScreenRendering(True)
    window.SetSize(*window_size)
    window.AddRenderer(renderer)
    renderer.SetActiveCamera(camera)
    found = []
    for point in points:
        renderer.SetWorldPoint(*point, 1)
        renderer.WorldToDisplay()
        found.append(renderer.GetDisplayPoint())
    return np.array(found)


@pytest.mark.parametrize("seed", range(40))
def test_view_and_projection_matrices_are_the_vtk_cameras(seed):
    camera = random_camera(seed)
    view = Viewer.from_camera(camera)
    expected = as_array(camera.GetModelViewTransformMatrix())
    np.testing.assert_allclose(look_at(view.position, view.focal_point, view.up), expected, rtol=1e-12, atol=1e-12)
    aspect = np.random.default_rng(seed + 1000).uniform(0.3, 3)
    expected = as_array(camera.GetProjectionTransformMatrix(aspect, -1, 1))
    half = view.parallel_scale
    if view.parallel:
        ours = ortho(-half * aspect, half * aspect, -half, half, *view.clipping_range)
    else:
        ours = perspective(view.view_angle, aspect, *view.clipping_range)
    np.testing.assert_allclose(ours, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("window_size", [(641, 333), (200, 1000)])
@pytest.mark.parametrize("seed", range(12))
def test_project_is_vtks_world_to_display(seed, window_size):
    camera = random_camera(seed)
    view = Viewer.from_camera(camera)
    rng = np.random.default_rng(seed + 2000)
    focal, eye = np.array(view.focal_point), np.array(view.position)
    ahead = (focal - eye) / np.linalg.norm(focal - eye)
    # a box of points in front of the eye, some of them outside the window and the clipping planes
    points = eye + ahead * rng.uniform(0.05, 150, (50, 1)) + rng.normal(size=(50, 3)) * 0.02
    expected = vtk_display(camera, points, window_size)
    scale = np.maximum(np.abs(expected), (*window_size, 1))
    assert np.abs((project(points, view, window_size) - expected) / scale).max() <= 1e-9


def test_rows_without_a_place_in_the_picture_are_nan():
    view = Viewer(position=(0, 0, 5))
    points = [(0, 0, 0), (1, 2, 5), (0, 0, 6), (np.nan, 0, 0), (0, np.inf, 0), (1, 0, 0)]
    assert np.isnan(project(points, view, (10, 10))).tolist() == [[row in (1, 2, 3, 4)] * 3 for row in range(6)]


def test_project_keeps_its_precision_far_from_the_origin():
    view = Viewer(position=(1e9, 1e9, 1e9 + 1), focal_point=(1e9, 1e9, 1e9), clipping_range=(0.5, 2))
    near = replace(view, position=(0, 0, 1), focal_point=(0, 0, 0))
    offsets = np.array([(0.125, 0.25, 0), (-0.25, 0.0625, 0.25)])  # exact at 1e9, where floats have a step of 2⁻²³
    found, expected = project(1e9 + offsets, view, (1000, 1000)), project(offsets, near, (1000, 1000))
    np.testing.assert_allclose(found, expected, rtol=1e-13)
    matrix = perspective(30, 1, 0.5, 2) @ look_at(view.position, view.focal_point, view.up)
    clip = np.c_[1e9 + offsets, np.ones(2)] @ matrix.T
    naive = (clip[:, :2] / clip[:, 3:] + 1) / 2 * 1000
    assert np.abs(naive - expected[:, :2]).max() > 1e-6  # the plain matrix product loses these digits


# --- matrices of every size ---


@pytest.mark.parametrize("scale", [2.0**-1000, 2.0**-600, 2.0**1020])
def test_matrices_of_any_size_differ_in_their_lengths_alone(scale):
    eye, target, window = np.array([3.0, -4.0, 9.0]), np.array([-1.0, 0.5, -9.0]), np.array([-1, 2, -1, 1, 1, 4])
    for call, given, place in (
        (lambda size: look_at(size * eye, size * target, (0.1, 0.2, 0.9)), 1.0, np.s_[:3, 3]),
        (lambda size: frustum(*(size * window)), 2.0**-2, np.s_[2, 3]),
    ):
        expected, found = call(1.0), call(scale * given)
        np.testing.assert_allclose(found[place] / (scale * given), expected[place], rtol=1e-15)
        found[place] = expected[place]
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-15)
    near, far = look_at(eye, (0, 0, 0), (0, 0, 1)), look_at(eye + 2.0**40, (2.0**40,) * 3, (0, 0, 1))
    np.testing.assert_allclose(far[:3, :3], near[:3, :3], rtol=0, atol=1e-15)
    np.testing.assert_allclose(far @ (*(eye + 2.0**40), 1), (0, 0, 0, 1), rtol=0, atol=1e-3)


EYE, HERE = (0, 0, 1), (0, 0, 0)


@pytest.mark.parametrize(
    ("function", "arguments", "message"),
    [
        (look_at, (EYE, EYE, (0, 1, 0)), "target must be different from eye"),
        (look_at, (EYE, HERE, (0, 0, -2)), r"up must be a direction not parallel to the view.*\[-0*\.? *-0"),
        (look_at, ((3, 6, 9), HERE, (1e100, 2e100, 3e100)), "up must be a direction not parallel to the view"),
        (look_at, (EYE, HERE, (0, 0, 0)), "up must be a direction, three finite numbers"),
        (look_at, ((0, 0, np.nan), HERE, (0, 1, 0)), r"eye\[2\] must be a finite number"),
        (frustum, (-1, 1, -1, 1, 0, 5), "near must be a finite number > 0; got 0"),
        (frustum, (-1, 1, -1, 1, 5, 5), r"far must be greater than near \(5\), by a finite amount; got 5"),
        (frustum, (1, 1, -1, 1, 1, 5), r"right must be different from left \(1\), by a finite amount; got 1"),
        (ortho, (-1, 1, 2, 2, 1, 5), r"top must be different from bottom \(2\), by a finite amount; got 2"),
        (ortho, (-1e308, 1e308, -1, 1, 1, 5), "right must be .* by a finite amount"),
        (ortho, (-1, 1, -1, 1, 5, 1), r"far must be greater than near \(5\), by a finite amount"),
        (ortho, (0, 5e-324, 0, 1, 0, 1), "the view volume must be neither so small nor so large that its matrix"),
        (perspective, (0, 1, 1, 2), "view_angle must be a finite number > 0"),
        (perspective, (180, 1, 1, 2), "view_angle must be a full angle in degrees, > 0 and < 180"),
        (perspective, (30, -1, 1, 2), "aspect must be a finite number > 0"),
        (project, ([(0, 0)], Viewer(), (10, 10)), r"points must be an \(n, 3\) array"),
        (project, ([HERE], Viewer(), (10, 0)), r"window_size\[1\] must be a finite number > 0"),
        (project, ([HERE], Viewer(), 10), "window_size must be 2 finite numbers"),
        (project, ([HERE], Viewer(up=EYE), (10, 10)), "up must be a direction not parallel to the view"),
    ],
)
def test_bad_arguments_are_refused(function, arguments, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        function(*arguments)
