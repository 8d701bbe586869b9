"""Refined meshes of a report on accuracy and time."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.studies.accuracy.interpolation import ADAPTIVE, AS_IT_IS, Triangles, interpolation, seconds_of_rays, split
from pvphong.studies.accuracy.timing import Clock
from pvphong.studies.accuracy.variants import Subject

SCENE = ph.Scene([ph.PointLight(position=(1, 0.5, 2))], ph.Viewer(position=(0, 0, 3)))
SHINY = ph.Material(specular=0.4, shininess=30)
MODULE = "pvphong.studies.accuracy.interpolation"


def refined(tolerance, seconds=20.0, scene=SCENE, mesh=None):
    """Return rows by name, errors of the searched triangles, and the variants left out."""
    mesh = mesh or pv.Sphere(theta_resolution=12, phi_resolution=12)
    subject = Subject(mesh.points, mesh.point_data.active_normals, scene, SHINY, None)
    found = interpolation(mesh, subject, tolerance, 1e-4, Clock(seconds))
    return {variant.row.name: variant.row for variant in found.variants}, found.errors, found.left_out


def test_it_is_refined_to_the_tolerance_and_only_where_it_is_not_within():
    found, errors, left_out = refined(0.02)
    assert found[ADAPTIVE].note == "reached the tolerance"
    assert found[ADAPTIVE].error.largest <= 0.02 < found[AS_IT_IS].error.largest == errors.max() < 0.9
    assert ADAPTIVE not in left_out
    found, _, left_out = refined(0.9)
    assert ADAPTIVE not in found
    assert left_out[ADAPTIVE] == "the original mesh is within the tolerance"


def test_triangles_of_strips_are_searched_beside_those_that_are_polygons():
    mesh = pv.PolyData(np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], float), faces=[3, 0, 1, 2])
    mesh.SetStrips(pv.CellArray([3, 2, 1, 3]))
    mesh.point_data.active_normals = np.tile([0.0, 0.0, 1.0], (4, 1))
    _, errors, _ = refined(0.02, mesh=mesh)
    assert len(errors) == 2


def test_without_time_meshes_are_left_out_and_few_triangles_searched():
    large = pv.Sphere(theta_resolution=100, phi_resolution=100)
    found, errors, left_out = refined(0.001, seconds=1e-3, mesh=large)
    assert list(found) == [AS_IT_IS]
    assert len(errors) == 2000 < large.n_cells
    assert found[AS_IT_IS].note == f"searched in 2000 of {large.n_cells} triangles"
    assert set(left_out) == {ADAPTIVE, "refined 1×", "refined 2×", "refined 3×"}
    whole = large.phong.interpolation_error(SCENE, SHINY)["phong_interpolation_error"]
    assert set(errors.round(12)) <= set(whole.round(12))


def test_the_saw_of_a_hard_shadow_falls_with_the_fourth_root_of_the_points_and_is_cut():
    """The edge is straight, so all triangles along it have the same errors."""
    ground = pv.Plane(i_size=4, j_size=4, i_resolution=16, j_resolution=16).triangulate()
    roof = pv.Plane(center=(3.03, 0, 1), i_size=6, j_size=8)
    scene = ph.Scene([ph.DirectionalLight(direction=(0, 0, -1))], SCENE.viewer, ph.LightModel(shadows=True))
    seen = ground.phong.visibility(scene, occluders=[roof])
    subject = Subject(np.asarray(ground.points), ground.phong.normals(), scene, SHINY, None, seen)
    assert seconds_of_rays(subject, 1 / 255) > 0
    found = interpolation(ground, subject, 0.01, 1e-4, Clock(3600.0))
    expected = ground.phong.interpolation_error(scene, SHINY, occluders=[roof])["phong_interpolation_error"]
    np.testing.assert_allclose(found.errors, expected, atol=1e-12)
    errors = {variant.row.name: variant.row.error for variant in found.variants}
    assert errors[ADAPTIVE].largest <= 0.01
    saws = [errors[name] for name in (AS_IT_IS, "refined 1×", "refined 2×", "refined 3×")]
    assert min(saw.largest for saw in saws) > 0.4
    powers = np.diff(np.log2([saw.rms for saw in saws])) / 2
    assert powers.mean() == pytest.approx(-0.25, abs=0.05)


def test_rays_that_need_not_be_cast_take_no_time():
    ball, scene = pv.Sphere(), replace(SCENE, light_model=ph.LightModel(shadows=True))
    seen = ball.phong.visibility(scene)
    subject = Subject(np.asarray(ball.points), ball.phong.normals(), scene, SHINY, None, seen)
    assert seconds_of_rays(subject, 1 / 255) == 0


def test_rays_inside_triangles_take_longer_the_coarser_those_at_vertices_were(monkeypatch):
    """Rays are cast to the same standard error in both cases; it falls with their number to the power ¾."""
    monkeypatch.setattr(f"{MODULE}.timed", lambda run: (run(), 1.0))
    ball, lamp = pv.Sphere(), ph.SphereLight(position=(0, 0, 3), radius=0.5)
    roof = pv.Disc(center=(0, 0, 1), inner=0.0, outer=0.2)
    scene = ph.Scene([lamp], SCENE.viewer, ph.LightModel(shadows=True))
    seen = ball.phong.visibility(scene, occluders=[roof])
    subject = Subject(np.asarray(ball.points), ball.phong.normals(), scene, SHINY, None, seen)
    fine, coarse = (seconds_of_rays(subject, tolerance) for tolerance in (0.01, 0.08))
    assert coarse / fine == pytest.approx(8 ** (4 / 3))


def test_what_took_long_to_search_is_not_searched_again_as_four_times_as_many_triangles(monkeypatch):
    monkeypatch.setattr(f"{MODULE}.timed", lambda run: (run(), 10.0))
    found, _, left_out = refined(0.02, seconds=20.0)
    assert list(found) == [AS_IT_IS]
    assert left_out["refined 1×"] == "there was no time for it"


def test_some_triangles_stand_for_all_on_refined_meshes(monkeypatch):
    mesh = pv.Sphere(theta_resolution=36, phi_resolution=36)
    monkeypatch.setattr(f"{MODULE}._LEVELS", (1,))
    monkeypatch.setattr("pvphong.shading.plan.plan._WORTH_LOADING", 2**40)  # NumPy evaluates both
    some = refined(0.9, mesh=mesh)[0]["refined 1×"].error
    monkeypatch.setattr(f"{MODULE}._WORST", mesh.n_cells)
    every = refined(0.9, mesh=mesh)[0]["refined 1×"].error
    assert some.count < every.count == 4 * mesh.n_cells
    assert some.largest == every.largest
    assert some.rms == pytest.approx(every.rms, rel=0.1)


def test_split_triangles_share_their_new_points_and_lie_where_they_did():
    mesh = pv.Sphere(theta_resolution=12, phi_resolution=10)
    paint, given = np.asarray(mesh.points) + 0.5, (np.asarray(mesh.points), np.asarray(mesh.point_normals))
    painted = replace(SHINY, emission=paint)
    start = Triangles(*given, mesh.regular_faces, np.arange(float(mesh.n_cells)), painted)
    points, normals, corners, areas, material = split(start)
    np.testing.assert_allclose(material.emission.source, points + 0.5, atol=1e-6)
    fine = pv.PolyData.from_regular_faces(points, corners)
    assert fine.n_points == mesh.n_points + mesh.extract_all_edges().n_cells
    assert fine.n_cells == 4 * mesh.n_cells
    assert fine.is_manifold
    assert fine.n_open_edges == 0
    assert fine.area == pytest.approx(mesh.area, rel=1e-6)
    assert fine.volume == pytest.approx(mesh.volume, rel=1e-6)  # orientations are kept
    np.testing.assert_array_equal(points[: mesh.n_points], mesh.points)
    centers = (normals[corners].mean(axis=1)).reshape(-1, 4, 3).mean(axis=1)
    np.testing.assert_allclose(centers, mesh.point_normals[mesh.regular_faces].mean(axis=1), atol=1e-6)
    np.testing.assert_array_equal(areas, np.repeat(start.areas / 4, 4))


def test_refining_where_it_matters_lessens_what_is_seen_of_the_error():
    """Weighted by count, the RMS would rise with the number of small triangles around the worst places."""
    lamp = ph.SpotLight(position=(0, 0, 2), direction=(0, 0, -1), cone_angle=8)
    found, _, _ = refined(1 / 255, scene=ph.Scene([lamp], ph.Viewer(position=(0, 0, 3))))
    before, after = found[AS_IT_IS].error, found[ADAPTIVE].error
    assert found[ADAPTIVE].note == "reached the tolerance"  # its cone is cut
    assert after.rms < 0.5 * before.rms
    assert after.p99 < 0.5 * before.p99


@pytest.mark.parametrize("matrix", [None, np.diag([1.0, 1.0, 50.0, 1.0]), np.diag([1e-180, 1e-180, 1e-180, 1.0])])
def test_areas_are_parts_of_the_surface_in_the_world(matrix):
    mesh = pv.Box((0, 1, 0, 2, 0, 3)).triangulate()
    mesh.points = mesh.points.astype(float)
    normals = np.tile((0.0, 0.0, 1.0), (mesh.n_points, 1))
    found = interpolation(mesh, Subject(mesh.points, normals, SCENE, SHINY, matrix), 0.5, 1e-4, Clock(20.0))
    placed = mesh if matrix is None else mesh.scale(np.diag(matrix)[:3] / matrix[0, 0])
    sizes = placed.compute_cell_sizes()["Area"]
    np.testing.assert_allclose(found.areas, sizes / sizes.sum(), rtol=1e-6)
