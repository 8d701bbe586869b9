"""The projection between cursor and world, compared with VTK's camera and with closed forms."""

import numpy as np
import pytest
import vtk
from views import EVERYWHERE, SCALES, view

from pvphong.optics.lights import PointLight

POINTS = np.array([(0.3, 0.1, 0.2), (-1.0, 0.7, -0.4), (1.5, 1.1, 0.9)])


everywhere = pytest.mark.parametrize(("projection", "scale"), EVERYWHERE)


@everywhere
def test_pixels_are_vtks(projection, scale):
    """The window has the subplot's size; the subplot's origin is added."""
    seen_from = view(projection, scale)
    window, renderer = vtk.vtkRenderWindow(), vtk.vtkRenderer()
    window.SetOffScreenRendering(True)
    window.SetSize(*(int(side) for side in seen_from.size))
    window.AddRenderer(renderer)
    viewer, camera = seen_from.viewer, renderer.GetActiveCamera()
    camera.SetPosition(viewer.position)
    camera.SetFocalPoint(viewer.focal_point)
    camera.SetViewUp(viewer.up)
    camera.SetViewAngle(viewer.view_angle)
    camera.SetParallelScale(viewer.parallel_scale)
    camera.SetParallelProjection(viewer.parallel)
    camera.SetClippingRange(0.1 * viewer.distance, 10 * viewer.distance)
    for point in scale * POINTS:
        renderer.SetWorldPoint(*point, 1.0)
        renderer.WorldToDisplay()
        pixel = np.array(renderer.GetDisplayPoint()[:2]) + seen_from.origin
        np.testing.assert_allclose(seen_from.project(point), pixel, atol=1e-6)


@everywhere
def test_the_cursor_is_found_again_on_the_plane_of_a_point(projection, scale):
    seen_from = view(projection, scale)
    for point in scale * POINTS:
        cursor = np.array([222.0, 333.0])
        found = seen_from.facing(point, cursor)
        np.testing.assert_allclose(seen_from.project(found), cursor, atol=1e-9)
        off_plane = (found - point) @ seen_from.viewer.axes[2]
        assert abs(off_plane) <= 1e-14 * scale * 10
        np.testing.assert_allclose(seen_from.facing(point, seen_from.project(point)), point, atol=1e-14 * scale * 10)


@everywhere
@pytest.mark.parametrize("axis", np.eye(3), ids="xyz")
def test_along_an_axis_the_picture_follows_the_cursor(projection, scale, axis):
    seen_from = view(projection, scale)
    for point in scale * POINTS:
        motion = np.array([13.0, -21.0])
        found = seen_from.along(point, axis, motion)
        assert np.linalg.norm(np.cross(found - point, axis)) <= 1e-12 * scale
        offset = seen_from.project(found) - seen_from.project(point)
        run = offset / np.hypot(*offset)
        assert offset @ run == pytest.approx(abs(motion @ run), rel=1e-6)
        assert (offset @ motion) > 0


@pytest.mark.parametrize("scale", SCALES)
def test_the_cursor_beyond_the_vanishing_point_stops_the_handle(scale):
    seen_from = view("perspective", scale, position=(0, -6, 1), focal_point=(0, 0, 0.5))
    point, away = scale * np.array([0.4, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    depth = seen_from.seen(point)[2]
    for length in (1e2, 1e3, 1e5):
        for sign in (1, -1):
            found = seen_from.along(point, away, sign * length * np.array([-0.3, 1.0]))
            assert np.isfinite(found).all()
            assert 0.0199 * depth <= seen_from.seen(found)[2] <= 50.01 * depth


@pytest.mark.parametrize("projection", ["perspective", "parallel"])
def test_an_axis_that_points_at_the_eye_is_not_chosen(projection):
    seen_from = view(projection, position=(0, -6, 0), focal_point=(0, 0, 0))
    point = np.zeros(3)
    assert seen_from.axis_along(point, np.zeros(2)) is None
    for motion in ([10.0, 0.0], [0.0, 10.0], [7.0, 7.1], [1e-3, 0]):
        axis = seen_from.axis_along(point, np.array(motion))
        assert axis[1] == 0
    np.testing.assert_array_equal(seen_from.axis_along(point, np.array([9.0, 4.0])), (1, 0, 0))
    np.testing.assert_array_equal(seen_from.axis_along(point, np.array([4.0, -9.0])), (0, 0, 1))
    np.testing.assert_array_equal(seen_from.along(point, np.array([0.0, 1, 0]), np.array([9.0, 9.0])), point)
    beside = np.array([0.05, 0.0, 0.05])  # in perspective the y axis has a short projection along the diagonal
    assert seen_from.axis_along(beside, np.array([7.0, 7.0]))[1] == 0


def test_a_light_that_the_eye_carries_beside_it_is_never_ahead():
    """Light kits have such lights. For half of all cameras rounding makes the depth slightly larger than zero."""
    random, rounded_up = np.random.default_rng(3), 0
    for scale in (1e-6, 1.0, 1e6):
        for position, focal_point in random.normal(size=(100, 2, 3)):
            seen_from = view(scale=scale, position=position + 10.0, focal_point=focal_point + 10.0)
            for far in (0.0, 1.0, 1e3):
                carried = PointLight(position=(5.5 * scale * far, -4.4 * scale * far, 0.0), frame="camera")
                at = carried.in_world(seen_from.viewer).position
                assert not seen_from.is_ahead(at)
                rounded_up += bool(seen_from.seen(at)[2] > 0)
            assert seen_from.is_ahead(seen_from.viewer.focal_point)
    assert rounded_up > 100


def test_behind_the_eye_of_a_perspective_there_is_no_picture():
    seen_from = view()
    behind = np.array(seen_from.viewer.position) * 2
    assert not seen_from.is_ahead(behind)
    assert not seen_from.is_ahead(seen_from.viewer.position)
    assert np.isnan(seen_from.project(behind)).all()
    assert view("parallel").is_ahead(behind)
    assert np.isfinite(view("parallel").project(behind)).all()
