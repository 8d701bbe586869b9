"""Refined meshes of a report on accuracy and time."""

import numpy as np
import pytest
import pyvista as pv

from pvphong.accuracy.inside import Triangles, split


def test_split_triangles_share_their_new_points_and_lie_where_they_did():
    mesh = pv.Sphere(theta_resolution=12, phi_resolution=10)
    start = Triangles(
        np.asarray(mesh.points), np.asarray(mesh.point_normals), mesh.regular_faces, np.arange(float(mesh.n_cells))
    )
    points, normals, corners, weights = split(start)
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
    np.testing.assert_array_equal(weights, np.repeat(start.weights, 4))
