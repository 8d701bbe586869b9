"""Blocks as one surface: the points, faces and normals of each, and nothing of another."""

import numpy as np
import pytest
import pyvista as pv

from pvphong.meshes.lit import one_surface


def blocks():
    ball, box = pv.Sphere(theta_resolution=9, phi_resolution=8), pv.Box((2, 3, 0, 1, 0, 1))
    ball.point_data.active_normals = -ball.point_data.active_normals  # its own, which faces would not give
    ball["tint"] = np.ones((ball.n_points, 3))
    grid = pv.ImageData(dimensions=(3, 3, 3), origin=(5, 0, 0)).cast_to_unstructured_grid()
    grid.points = grid.points.astype(np.float64) + 1e-9
    return pv.MultiBlock({"ball": ball, "gap": None, "inner": pv.MultiBlock({"box": box, "grid": grid})})


def test_all_surfaces_are_there_with_the_normals_that_they_are_lit_with():
    given = blocks()
    before = given.copy()
    whole = one_surface(given)
    lit = given.phong.normals()
    parts = [lit["ball"], lit["inner"]["box"], lit["inner"]["grid"]]
    assert whole.n_cells == sum(part.n_cells for part in parts)
    assert whole.area == pytest.approx(sum(part.area for part in parts))
    np.testing.assert_array_equal(whole.points, np.concatenate([part.points for part in parts]))
    assert whole.points.dtype == np.float64
    normals = np.concatenate([part.point_data.active_normals for part in parts])
    np.testing.assert_array_equal(whole.point_data.active_normals, normals)
    assert whole.array_names == [whole.point_data.active_normals_name]
    for key in ("ball", "inner"):
        assert given[key] == before[key]


def test_a_single_block_is_given_as_a_new_mesh():
    ball = pv.Sphere()
    ball["tint"] = np.ones(ball.n_points)
    whole = one_surface(pv.MultiBlock({"ball": ball}))
    assert "tint" in ball.array_names
    np.testing.assert_array_equal(whole.points, ball.points)


def test_without_a_mesh_there_is_nothing_and_a_broken_block_is_named():
    with pytest.raises(ValueError, match="mesh must be one with a mesh that can be lit; got a MultiBlock of 1 without"):
        one_surface(pv.MultiBlock({"gap": None}))
    with pytest.raises(ValueError, match=r"block \['cloud'\]: mesh must be a mesh with faces"):
        one_surface(pv.MultiBlock({"ball": pv.Sphere(), "cloud": pv.PolyData(np.eye(3))}))
