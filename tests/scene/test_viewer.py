"""The viewer: fields, axes, and agreement with vtkCamera."""

import dataclasses
import math

import numpy as np
import pytest
import vtk
from cameras import as_array, random_camera

from pvphong.scene.viewer import Viewer


def test_defaults_are_vtk_cameras():
    lens = {"parallel": False, "view_angle": 30.0, "parallel_scale": 1.0, "clipping_range": (0.01, 1000.01)}
    expected = Viewer(position=(0, 0, 1), focal_point=(0, 0, 0), up=(0, 1, 0), **lens)
    assert Viewer.from_camera(vtk.vtkCamera()) == Viewer() == expected


def test_is_equal_by_its_fields_whatever_was_derived():
    viewer, same = Viewer(position=[1, 2, 3], up=np.array([0, 0, 1])), Viewer(position=(1.0, 2.0, 3.0), up=(0.0, 0, 1))
    assert viewer.distance == math.sqrt(14)
    assert viewer == same
    assert hash(viewer) == hash(same)
    moved = dataclasses.replace(viewer, position=(0, 3, 4))
    assert moved.view_direction == pytest.approx((0, -0.6, -0.8), rel=1e-15)


NO_VECTORS = [(0, 1), (0, math.nan, 0), (math.inf, 0, 1), "here", None, 1.0]
REFUSED = [(field, bad, f"{field}.* must be ") for field in ("position", "focal_point", "up") for bad in NO_VECTORS]
REFUSED += [
    ("up", (0, 0, 0), "up must be a direction"),
    ("focal_point", (0, 0, 1), "focal_point must be different from position; got .*needs a direction"),
    ("parallel", 1, "parallel must be True or False"),
    ("view_angle", 0, "view_angle must be a finite number > 0 and <= 179"),
    ("view_angle", 180, "view_angle must be a finite number > 0 and <= 179"),
    ("parallel_scale", 0, "parallel_scale must be a finite number > 0"),
    ("clipping_range", (1, 2, 3), "clipping_range must be 2 finite numbers"),
    ("clipping_range", (1, math.inf), r"clipping_range\[1\] must be a finite number"),
]


@pytest.mark.parametrize(("field", "bad", "message"), REFUSED)
def test_fields_out_of_range_are_refused_by_name(field, bad, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        Viewer(**{field: bad})


# --- from a camera ---


@pytest.mark.parametrize("seed", range(10))
def test_a_viewer_has_all_that_its_camera_has_and_its_eye_space(seed):
    camera = random_camera(seed)
    before = camera.GetMTime()
    viewer = Viewer.from_camera(camera)
    assert dataclasses.astuple(viewer) == (
        camera.GetPosition(),
        camera.GetFocalPoint(),
        camera.GetViewUp(),
        bool(camera.GetParallelProjection()),
        camera.GetViewAngle(),
        camera.GetParallelScale(),
        camera.GetClippingRange(),
    )
    np.testing.assert_allclose(viewer.axes, as_array(camera.GetViewTransformMatrix())[:3, :3], rtol=0, atol=1e-14)
    np.testing.assert_allclose(viewer.view_direction, camera.GetDirectionOfProjection(), rtol=1e-14)
    assert viewer.distance == pytest.approx(camera.GetDistance(), rel=1e-14)
    assert camera.GetMTime() == before
    point = tuple(np.random.default_rng(seed).normal(size=3).tolist())
    np.testing.assert_allclose(
        viewer.axes @ np.subtract(viewer.point_to_world(point), viewer.position), point, atol=1e-13
    )
    np.testing.assert_allclose(viewer.axes @ viewer.vector_to_world(point), point, atol=1e-14)
    assert viewer.point_to_world((0, 0, 0)) == viewer.position


@pytest.mark.parametrize("bad", [None, "xy", vtk.vtkLight(), (0, 0, 1), Viewer()])
def test_from_camera_refuses_others(bad):
    with pytest.raises(ValueError, match=r"^camera must be a pyvista\.Camera or a vtkCamera; got "):
        Viewer.from_camera(bad)


# --- eye space ---


@pytest.mark.parametrize("scale", [1e-300, 1e-160, 1e160, 1e300])
def test_axes_at_extreme_scales(scale):
    position = np.array([3.0, -2.0, 5.0]) * scale
    viewer = Viewer(position=position, focal_point=(0, 0, 0), up=(0.2 * scale, 0.3 * scale, scale))
    expected = Viewer(position=(3, -2, 5), up=(0.2, 0.3, 1)).axes
    np.testing.assert_allclose(viewer.axes, expected, rtol=0, atol=1e-15)
    assert viewer.distance == pytest.approx(math.sqrt(38) * scale, rel=1e-15)


def test_the_least_and_the_largest_distance():
    viewer = Viewer(position=(1e308, 1e308, 1e308), focal_point=(-1e308, -1e308, -1e308))
    assert viewer.distance == np.finfo(np.float64).max
    np.testing.assert_allclose(viewer.view_direction, [-1 / math.sqrt(3)] * 3, rtol=1e-15)
    assert Viewer(position=(0, 0, 0), focal_point=(0, 0, 5e-324)).view_direction == (0.0, 0.0, 1.0)


@pytest.mark.parametrize("position", [(0, 0, 1), (1, 2, 3), (0.3, 0.7, 0.2), (0.1, 0.2, 0.3), (7.1, -3.3, 1e-3)])
@pytest.mark.parametrize("factor", [1.0, 3.0, -0.1])
def test_up_along_the_view_axis_is_refused_where_it_is_needed(position, factor):
    viewer = Viewer(position=position, up=np.multiply(position, factor))
    assert viewer.distance > 0
    with pytest.raises(ValueError, match=r"^up must be a direction not parallel to the view axis; got "):
        _ = viewer.axes


# --- boxes in view ---

BOX = (1.0, 3.0, -1.0, 1.0, 4.0, 5.0)


@pytest.mark.parametrize("parallel", [False, True])
@pytest.mark.parametrize("position", [(9.0, 1.0, 3.0), (-4.0, 6.0, 8.0), (2.0, 0.0, -30.0)])
def test_moved_to_see_a_box_it_looks_the_same_way_and_sees_every_corner(position, parallel):
    before = Viewer(position=position, focal_point=(100.0, 50.0, -70.0), up=(0, 1, 0), parallel=parallel, view_angle=40)
    assert not before.sees((1e4, 1e4 + 1, 0, 1, 0, 1), 1.5)
    after = before.moved_to_see(BOX)
    np.testing.assert_allclose(after.view_direction, before.view_direction, atol=1e-12)
    assert after.sees(BOX, 1.0)
    for corner in np.array(np.meshgrid(BOX[:2], BOX[2:4], BOX[4:])).reshape(3, -1).T:
        x, y, z = after.point_to_eye(tuple(corner))
        half = after.parallel_scale if parallel else -z * np.tan(np.radians(20.0))
        assert max(abs(x), abs(y)) <= half * (1 + 1e-12)
        near, far = after.clipping_range
        assert near * (1 - 1e-12) <= -z <= far * (1 + 1e-12)


@pytest.mark.parametrize("place", [0.0, 1e9, 1e20, -1e300])
def test_a_point_is_seen_from_elsewhere_however_far_out(place):
    assert Viewer.framing((place,) * 6).sees((place,) * 6, 1.0)


@pytest.mark.parametrize(
    ("away", "seen"),
    [((0, 0, 0), True), ((0, 0, 20), False), ((11, 0, 0), True), ((14, 0, 0), False), ((-14, 0, 0), False),
     ((0, 7, 0), True), ((0, 10, 0), False), ((0, -10, 0), False)],
)  # fmt: skip
def test_a_box_beside_the_picture_is_not_seen(away, seen):
    """An eye at distance 10 looks down z with a view angle of 80° and aspect 3 : 2; the nearest face is at 9."""
    viewer = Viewer(position=(0, 0, 10), focal_point=(0, 0, 0), view_angle=80.0)
    low = np.array(away) - 0.5
    assert viewer.sees(np.stack([low, low + 1], axis=1).ravel(), 1.5) == seen
