"""Meshes whose colours are kept current: where they are written, what is shared, what it costs in memory."""

import dataclasses
import gc
import tracemalloc

import numpy as np
import pytest
import pyvista as pv

from pvphong.optics.lights import PointLight
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.studio.live import ARRAY, LiveMesh

SCENE = Scene(lights=[PointLight(position=(2, 2, 2))], viewer=Viewer(position=(0, 0, 5)))
SHINY = Material(specular=0.5, shininess=20)


def ball():
    return pv.Sphere(theta_resolution=16, phi_resolution=12)


def address(live):
    return live.drawn.GetPointData().GetArray(ARRAY).GetVoidPointer(0)


def other_light(step):
    return dataclasses.replace(SCENE, lights=[PointLight(position=(2, 2, 2 + 0.01 * step))])


def assert_lit(live, scene):
    lit = live.mesh.phong.shade(scene, live.material, precision="float64")[ARRAY]
    assert np.abs(np.asarray(live.drawn[ARRAY]) - 255.0 * lit).max() <= 0.51


def test_colours_are_written_in_place():
    live = LiveMesh(ball(), SHINY)
    array, at = live.drawn.GetPointData().GetArray(ARRAY), address(live)
    for step in range(5):
        assert live.refresh(other_light(step))
        assert_lit(live, other_light(step))
        assert live.drawn.GetPointData().GetArray(ARRAY) is array
        assert address(live) == at


@pytest.mark.parametrize("points", ["moved", "more"])
def test_the_buffer_stays_while_the_number_of_points_does(points):
    mesh = ball()
    live = LiveMesh(mesh, SHINY)
    live.refresh(SCENE)
    at = address(live)
    if points == "moved":
        mesh.points = mesh.points * [1, 2, 3]
        mesh.point_data.active_normals_name = None
    else:
        mesh.copy_from(pv.Sphere(theta_resolution=30, phi_resolution=30))
    assert live.refresh(SCENE)
    assert (address(live) == at) == (points == "moved")
    assert_lit(live, SCENE)


def test_the_renderer_is_told_of_new_colours_and_of_nothing_else():
    live = LiveMesh(ball(), SHINY)
    live.refresh(SCENE)
    array, points = live.drawn.GetPointData().GetArray(ARRAY), live.drawn.GetPoints()
    before, shape = array.GetMTime(), points.GetMTime()
    live.refresh(SCENE)
    assert array.GetMTime() == before
    live.refresh(other_light(1))
    assert array.GetMTime() > before
    assert points.GetMTime() == shape


def test_points_and_arrays_are_shared():
    mesh = ball()
    mesh["number"] = np.arange(mesh.n_points)
    live = LiveMesh(mesh, SHINY)
    assert live.drawn.GetPoints() is mesh.GetPoints()
    assert live.drawn.GetPointData().GetArray("number") is mesh.GetPointData().GetArray("number")
    assert ARRAY not in mesh.point_data


def test_a_mesh_that_is_lit_already_can_be_drawn():
    lit = ball().phong.shade(SCENE, SHINY)
    before = lit[ARRAY].copy()
    live = LiveMesh(lit, SHINY)
    live.refresh(other_light(50))
    np.testing.assert_array_equal(lit[ARRAY], before)
    assert live.drawn[ARRAY].dtype == np.uint8


def test_given_albedo_of_the_same_object_is_no_change_and_another_is():
    live = LiveMesh(ball(), SHINY, np.full((ball().n_points, 3), 0.5))
    assert live.refresh(SCENE)
    assert not live.refresh(SCENE)
    live.albedo = np.full((ball().n_points, 3), 0.5)
    assert live.refresh(SCENE)


def test_a_named_albedo_that_is_missing_is_named():
    mesh = ball()
    mesh["tint"] = np.full((mesh.n_points, 3), 0.5)
    live = LiveMesh(mesh, SHINY, "tint")
    live.refresh(SCENE)
    live.albedo = "tnit"
    with pytest.raises(ValueError, match=r"^albedo must be one of .*'tint'"):
        live.refresh(SCENE)


def test_a_grid_is_followed_when_it_is_warped():
    grid = pv.ImageData(dimensions=(6, 6, 2)).cast_to_structured_grid()
    live = LiveMesh(grid, SHINY)
    assert live.refresh(SCENE)
    assert not live.refresh(SCENE)
    grid.points[:, 2] += 0.1 * grid.points[:, 0] ** 2
    assert live.refresh(SCENE)
    assert_lit(live, SCENE)


def test_memory_does_not_grow_over_a_thousand_updates():
    live, traced, window = LiveMesh(ball(), SHINY), [], 500
    tracemalloc.start()
    for step in range(4 * window):
        assert live.refresh(other_light(step))
        if step % window == window - 1:
            gc.collect()
            traced.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    # VTK keeps the Python side of some weak references, one for each address that was ever in use: that fills up, the
    # slower the longer. A leak grows all the time, and its least object, a float, has 24 bytes.
    assert min(np.diff(traced)) < 24 * window
