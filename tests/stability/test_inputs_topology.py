"""Rows 21 and 31 of the catalogue of hard cases, as meshes; rows 23, 26, 28 and 29 are in test_mesh_normals."""

from __future__ import annotations

import subprocess
import sys
import textwrap

import numpy as np
import pytest
from pyvista import examples
from soups import faces_of, mesh_of
from stability.ledger import held

from pvphong.meshes.surfaces import face_normals
from pvphong.studies.diagnose.diagnosis import diagnose

# row 21: float32 points far from the origin


@pytest.mark.parametrize("offset", [1e4, 1e6, 1e8, (1e6, 0, 0), (1e7, -2e8, 5e7)])
def test_row_21_diagnose_warns_with_the_offset_that_cures(offset):
    airplane = examples.load_airplane()
    faces, world = faces_of(airplane), np.asarray(airplane.points, dtype=float) + offset
    found = diagnose(mesh_of(world.astype(np.float32), *faces))
    assert not found.ok
    assert len(found.far_faces)
    assert "Subtract an offset" in found.explain()
    assert "({:.17g}, {:.17g}, {:.17g})".format(*found.offset) in found.explain()
    true = face_normals(airplane)
    here = np.linalg.norm(face_normals(mesh_of(world.astype(np.float32), *faces)) - true, axis=1).max()
    moved = mesh_of((world - found.offset).astype(np.float32), *faces)
    assert here > 2e-3
    assert np.linalg.norm(face_normals(moved) - true, axis=1).max() < 1e-4
    for sound in (moved, mesh_of(world, *faces), airplane):  # float64 holds it as it is
        assert diagnose(sound).ok
        assert diagnose(sound).offset is None


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
