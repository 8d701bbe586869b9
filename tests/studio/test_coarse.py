"""Coarse pictures of large meshes."""

import time

import numpy as np
import pytest
import pyvista as pv
from waiting import until

import pvphong as ph
from pvphong.studio import coarse
from pvphong.studio.coarse import CoarsePictures, clustered

BALL = pv.Sphere(theta_resolution=60, phi_resolution=60)
TRIANGLES = BALL.regular_faces


@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_every_vertex_is_near_one_that_remains(offset):
    points = np.asarray(BALL.points, np.float64) + offset
    found = clustered(points, np.asarray(BALL.point_normals), TRIANGLES, cubes=20.0)
    side = np.linalg.norm(np.ptp(points, axis=0)) / 20.0
    away = np.linalg.norm(points[:, None] - points[found.rows], axis=2).min(axis=1)
    assert away.max() <= np.sqrt(3.0) * side + 1e-9
    assert len(found.rows) < 0.5 * len(points)
    corners = np.sort(found.triangles, axis=1)
    assert (corners[:, 0] < corners[:, 1]).all()
    assert (corners[:, 1] < corners[:, 2]).all()
    assert len(np.unique(corners, axis=0)) == len(corners)
    assert corners.max() < len(found.rows)
    assert pv.PolyData.from_regular_faces(points[found.rows], corners).area == pytest.approx(BALL.area, rel=0.05)


def test_faces_keep_their_front():
    points = np.asarray(BALL.points, np.float64)
    found = clustered(points, np.asarray(BALL.point_normals), TRIANGLES, cubes=15.0)
    a, b, c = points[found.rows[found.triangles]].transpose(1, 0, 2)
    outwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c)
    assert (outwards > 0.0).mean() > 0.95  # clusters of a few cubes fold over


def test_the_sides_of_a_thin_plate_stay_apart():
    plane = pv.Plane(i_resolution=40, j_resolution=40).triangulate()
    points = np.concatenate([plane.points, plane.points + np.array([0, 0, 1e-4])])
    normals = np.repeat([[0.0, 0, -1], [0.0, 0, 1]], plane.n_points, axis=0)
    faces = plane.regular_faces
    found = clustered(points, normals, np.concatenate([faces, faces + plane.n_points]), cubes=15.0)
    sides = normals[found.rows, 2]
    assert (sides[found.triangles] == sides[found.triangles[:, :1]]).all()
    assert set(sides) == {-1.0, 1.0}


def test_points_that_are_not_finite_harm_nobody():
    points = np.array(BALL.points, np.float64)
    points[5] = np.nan, np.inf, 0.0
    found = clustered(points, np.asarray(BALL.point_normals), TRIANGLES, cubes=10.0)
    assert 0 < len(found.triangles) < len(TRIANGLES)
    alone = clustered(np.zeros((3, 3)), np.zeros((3, 3)), np.array([[0, 1, 2]]), 10.0)
    assert len(alone.triangles) == 0


@pytest.fixture
def drawn(new_plotter, monkeypatch):
    """A plotter with a ball, the coarse pictures of its subplot, and the ball's lit mesh."""
    monkeypatch.setattr(coarse, "_MANY", 1000)
    monkeypatch.setattr(coarse, "_CUBES", 20.0)
    plotter = new_plotter((200, 150))
    plotter.phong.add_light(ph.DirectionalLight(direction=(-1, -1, -2), name="sun"))
    plotter.phong.add_mesh(BALL.copy(), "white plastic", name="ball")
    plotter.show(auto_close=False)
    subplot = plotter.phong._subplot
    pictures = CoarsePictures(subplot.renderer, subplot.lit)
    yield plotter, pictures, subplot.lit.meshes[0]
    pictures.release()


def made(plotter, pictures, mesh):
    """Wait until the coarse picture is shown."""
    pictures.are_wanted = True

    def is_shown():
        plotter.render()
        return pictures.are_shown

    until(is_shown)
    return mesh.actor.mapper.dataset


def test_colours_follow_edits_and_the_whole_mesh_comes_back(drawn):
    plotter, pictures, mesh = drawn
    before = plotter.screenshot(return_img=True).astype(int)
    shown = made(plotter, pictures, mesh)
    assert shown.n_points < 0.5 * mesh.drawn.n_points
    near = plotter.screenshot(return_img=True).astype(int)
    assert np.abs(near - before).mean() < 3.0
    plotter.phong.set_light("sun", intensity=0.3)
    plotter.render()
    rows = np.linalg.norm(np.asarray(mesh.drawn.points)[:, None] - shown.points, axis=2).argmin(axis=0)
    np.testing.assert_array_equal(shown["phong"], mesh.drawn["phong"][rows])
    plotter.phong.set_light("sun", intensity=1.0)
    pictures.are_wanted = False
    plotter.render()
    assert mesh.actor.mapper.dataset is mesh.drawn
    np.testing.assert_array_equal(plotter.screenshot(return_img=True), before)


def test_an_edited_mesh_gets_another_picture_and_picking_its_own_faces(drawn):
    plotter, pictures, mesh = drawn
    first = made(plotter, pictures, mesh)
    mesh.mesh.points *= 1.5
    plotter.render()
    assert mesh.actor.mapper.dataset is mesh.drawn  # until the new picture is made
    second = made(plotter, pictures, mesh)
    assert second.length == pytest.approx(1.5 * first.length, rel=0.02)
    plotter.phong._subplot.lit.show_own_vertices()
    assert mesh.actor.mapper.dataset is mesh.drawn


@pytest.mark.parametrize("how", ["small", "edges", "opacity", "refined"])
def test_other_meshes_are_drawn_as_always(drawn, monkeypatch, how):
    plotter, pictures, mesh = drawn
    lit = plotter.phong._subplot.lit
    if how == "small":
        monkeypatch.setattr(coarse, "_MANY", 10**6)
    elif how == "edges":
        mesh.actor.prop.show_edges = True
    elif how == "refined":
        lit.refine(0.1)
    else:
        plotter.phong.add_mesh(BALL, "gold", opacity=np.full(BALL.n_points, 0.5), name="ball")
    pictures.are_wanted = True
    for _ in range(10):
        plotter.render()
        time.sleep(0.02)
        assert not pictures.are_shown


def test_downloads_as_shown_are_of_the_mesh_itself(drawn):
    plotter, pictures, mesh = drawn
    made(plotter, pictures, mesh)
    assert mesh.as_shown().n_points == mesh.drawn.n_points
