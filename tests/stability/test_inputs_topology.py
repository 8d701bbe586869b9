"""Sections C and F of the catalogue of hard cases, as meshes: rows 21, 23, 26, 28, 29 and 31."""

from __future__ import annotations

import subprocess
import sys
import textwrap
from itertools import pairwise

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples
from stability import exact_normals as exact
from stability.ledger import U, held, record

from pvphong.meshes.surfaces import face_normals, polygons, vertex_normals
from pvphong.studies.diagnose.diagnosis import diagnose


def mesh_of(points, *faces):
    mesh = pv.PolyData()
    mesh.points = np.asarray(points)
    connectivity = np.array([index for face in faces for index in face], dtype=np.int64)
    mesh.SetPolys(pv.CellArray.from_arrays(np.cumsum([0, *map(len, faces)]), connectivity, deep=True))
    return mesh


def faces_of(mesh):
    connectivity, offsets = polygons(mesh)
    return [connectivity[a:b].tolist() for a, b in pairwise(offsets)]


# row 21: float32 points far from the origin


@pytest.mark.parametrize("offset", [1e4, 1e6, 1e8])
def test_row_21_normals_are_those_of_the_stored_points(offset):
    airplane = examples.load_airplane()
    stored = (np.asarray(airplane.points, dtype=float) + offset).astype(np.float32)
    faces = faces_of(airplane)[::10]
    normals = face_normals(mesh_of(stored, *faces))
    errors, bounds = [], []
    for normal, face in zip(normals, faces, strict=True):
        area = exact.area_vector(stored[face])
        if any(area):
            errors.append(exact.distance(normal, exact.unit(area)))
            bounds.append(8 * U * exact.slenderness(stored[face]))
        else:
            assert not normal.any()
    record(f"21 offset={offset:g}", "face_normals", "float32", errors, bounds)


@pytest.mark.parametrize("offset", [1e4, 1e6, 1e8])
def test_row_21_diagnose_warns_with_the_offset_that_cures(offset):
    airplane = examples.load_airplane()
    faces, world = faces_of(airplane), np.asarray(airplane.points, dtype=float) + offset
    found = diagnose(mesh_of(world.astype(np.float32), *faces))
    assert not found.ok
    assert len(found.far_faces)
    true = face_normals(airplane)
    here = np.linalg.norm(face_normals(mesh_of(world.astype(np.float32), *faces)) - true, axis=1).max()
    moved = (world - found.offset).astype(np.float32)
    cured = np.linalg.norm(face_normals(mesh_of(moved, *faces)) - true, axis=1).max()
    assert here > 2e-3
    assert cured < 1e-4
    assert diagnose(mesh_of(moved, *faces)).ok
    assert diagnose(mesh_of(world, *faces)).ok  # float64 holds it as it is


def test_row_21_near_the_origin_nothing_is_said():
    assert diagnose(examples.load_airplane()).offset is None


# row 23: faces without an area


@pytest.mark.parametrize(
    "extra",
    [(0, 1, 1), (2, 2, 2), (0, 4, 1), (0, 1, 5), (1, 5, 1, 5)],
    ids=["twice", "thrice", "collinear", "duplicate points", "there and back"],
)
def test_row_23_a_face_without_an_area_has_no_weight(extra):
    points = np.array([(0, 0, 0), (1, 0, 0), (0.5, 1, 0.25), (0, 1, 1), (0.25, 0, 0), (1, 0, 0)])
    sound, spoilt = mesh_of(points, (0, 1, 2), (0, 2, 3)), mesh_of(points, (0, 1, 2), (0, 2, 3), extra)
    np.testing.assert_array_equal(vertex_normals(spoilt)[:4], vertex_normals(sound)[:4])
    assert np.isfinite(vertex_normals(spoilt)).all()
    np.testing.assert_array_equal(face_normals(spoilt)[2], (0, 0, 0))
    found = diagnose(spoilt)
    assert found.degenerate_faces.tolist() == [2]
    assert found.unlit_points.tolist() == [index for index in (4, 5) if index in extra]
    assert not found.ok


# row 26: points that are not finite


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_row_26_a_bad_point_is_flagged_and_touches_no_bit_of_the_others(bad, dtype):
    airplane = examples.load_airplane()
    points, faces = np.asarray(airplane.points).astype(dtype), faces_of(airplane)
    victim = 700
    without = vertex_normals(mesh_of(points, *(face for face in faces if victim not in face)))
    points = points.copy()
    points[victim, 1] = bad
    broken = mesh_of(points, *faces)
    others = np.arange(len(points)) != victim
    np.testing.assert_array_equal(vertex_normals(broken)[others], without[others])
    found = diagnose(broken)
    assert found.non_finite_points.tolist() == [victim]
    assert not found.ok
    assert found.degenerate_faces.tolist() == found.unlit_points.tolist() == found.far_faces.tolist() == []


def test_row_26_a_mesh_of_nothing_but_nan_is_diagnosed():
    sphere = pv.Sphere()
    found = diagnose(mesh_of(np.full((sphere.n_points, 3), np.nan), *sphere.regular_faces.tolist()))
    assert len(found.non_finite_points) == sphere.n_points
    assert found.to_mesh().n_points == sphere.n_points


# row 28: coincident opposite faces


def test_row_28_coincident_opposite_faces_are_unlit_and_reported():
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0), (-1, 2, 3)]
    mesh = mesh_of(points, (0, 1, 2), (2, 1, 0), (0, 3, 4))
    normals = vertex_normals(mesh)
    np.testing.assert_array_equal(normals[[1, 2]], 0)
    np.testing.assert_allclose(normals[[0, 3, 4]], face_normals(mesh)[[2, 2, 2]], atol=1e-15)
    found = diagnose(mesh)
    assert found.unlit_points.tolist() == [1, 2]
    assert not found.ok


# row 29: non-manifold edges

BOOK = [(0, 0, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (-1, -1, 0)]
PAGES = [(0, 2, 1), (0, 3, 1), (0, 4, 1)]


def test_row_29_a_non_manifold_edge_keeps_the_point_count():
    book = mesh_of(BOOK, *PAGES)
    assert vertex_normals(book).shape == (5, 3)
    assert diagnose(book).non_manifold_edges.tolist() == [[0, 1]]
    split = book.compute_normals(split_vertices=True, feature_angle=30, cell_normals=False)
    assert split.n_points == 9  # what VTK makes of the same 5 points


# row 31: indices that no point has

CRASHERS = {
    "face 9 of 3": ("pv.PolyData(points[:3], faces=[3, 0, 1, 9])", "index 9 in face 0"),
    "face -1": ("pv.PolyData(points[:3], faces=[3, 0, 1, 2, 3, 0, 1, -1])", "index -1 in face 1"),
    "face 1e9": ("pv.PolyData(points, faces=[3, 0, 1, 10**9])", "index 1000000000 in face 0"),
    "strip": ("pv.PolyData(points, strips=[4, 0, 1, 2, 10**9])", "index 1000000000 in strip 0"),
    "line": ("pv.PolyData(points, lines=[2, 0, 10**9])", "index 1000000000 in line 0"),
    "vertex": ("pv.PolyData(points, verts=[1, 10**9])", "index 1000000000 in vertex 0"),
    "tetrahedron": ("pv.UnstructuredGrid([4, 0, 1, 2, 10**9], [10], points)", "index 1000000000 in cell 0"),
    "too few points": ("pv.UnstructuredGrid([2, 0, 1], [10], points)", "cell 0 with 2 points where its type has 4"),
    "3 as a solid": ("pv.UnstructuredGrid([3, 0, 1, 2], [41], points)", "cell 0, a convex point set"),
    "5 in a plane": (
        "pv.UnstructuredGrid([5, 0, 1, 2, 3, 4], [41], points * (1, 1, 0))",
        "cell 0, a convex point set",
    ),
    "a nearly flat hull": (
        "pv.UnstructuredGrid([4, 0, 1, 2, 3], [41], np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.3, 0.3, 0.01)]))",
        "cell 0, a convex point set",
    ),
    "polyhedron": ("polyhedron()", "index 1000000000 in polyhedron face 1"),
    "explicit grid": ("explicit()", "index 1000000000 in cell 0"),
}
DIMENSIONS = ("structured()", "got 6 points in dimensions (100, 100, 100)")

PRELUDE = """
import numpy as np, pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy
from pyvista import examples
from pvphong.studies.diagnose.diagnosis import diagnose
from pvphong.meshes.surfaces import surface, vertex_normals, face_normals, polygons

points = np.random.default_rng(1).random((6, 3))

def polyhedron():
    mesh = examples.cells.Polyhedron()
    vtk_to_numpy(mesh.GetPolyhedronFaces().GetConnectivityArray())[3] = 10**9
    return mesh

def explicit():
    mesh = pv.ImageData(dimensions=(3, 3, 3)).cast_to_structured_grid().cast_to_explicit_structured_grid()
    vtk_to_numpy(mesh.GetCells().GetConnectivityArray())[3] = 10**9
    return mesh

def structured():
    mesh = pv.StructuredGrid()
    mesh.points = points
    mesh.dimensions = (100, 100, 100)
    return mesh
"""


def test_row_31_every_broken_mesh_is_refused_and_diagnosed_without_a_crash():
    code = f"""
    for name, (mesh, message) in {CRASHERS!r}.items():
        mesh = eval(mesh)
        for call in (surface, vertex_normals, face_normals):
            try:
                call(mesh)
            except ValueError as error:
                assert message in str(error), (name, call, str(error))
            else:
                raise AssertionError((name, call))
        found = diagnose(mesh)
        assert found.invalid_cells.tolist() == [1 if "-1" in name else 0], (name, found.invalid_cells)
        assert not found.ok and "invalid_cells" in str(found)
        assert found.to_mesh().n_points > 0
    for call in (surface, diagnose):
        try:
            call(eval({DIMENSIONS[0]!r}))
        except ValueError as error:
            assert {DIMENSIONS[1]!r} in str(error), str(error)
        else:
            raise AssertionError(call)
    print("still alive")
    """
    command = [sys.executable, "-W", "error", "-c", PRELUDE + textwrap.dedent(code)]
    with held("process lives", "31 as a mesh", "surface, diagnose"):
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
        assert (done.returncode, done.stdout.strip()) == (0, "still alive"), done.stderr
