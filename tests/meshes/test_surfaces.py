"""The surface of any dataset, its faces as arrays, and their normals."""

import math
from itertools import pairwise

import numpy as np
import pytest
import pyvista as pv
import vtk
from pyvista import examples
from vtkmodules.util.numpy_support import vtk_to_numpy

from pvphong.meshes.surfaces import face_normals, polygons, surface, vertex_normals

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)], dtype=float)


def cell_array(*cells, storage="Use64BitStorage"):
    array = vtk.vtkCellArray()
    getattr(array, storage)()
    for cell in cells:
        array.InsertNextCell(len(cell), cell)
    return array


def mesh_of(points, *, faces=(), strips=(), verts=(), lines=(), storage="Use64BitStorage"):
    mesh = pv.PolyData()
    mesh.points = np.asarray(points)
    mesh.SetPolys(cell_array(*faces, storage=storage))
    mesh.SetStrips(cell_array(*strips, storage=storage))
    mesh.SetVerts(cell_array(*verts, storage=storage))
    mesh.SetLines(cell_array(*lines, storage=storage))
    return mesh


def as_lists(connectivity, offsets):
    return [connectivity[a:b].tolist() for a, b in pairwise(offsets)]


# polygons


def test_polygons_of_all_sizes_come_in_order():
    faces = [[0, 1, 2, 3], [0, 1, 4], [4, 3, 2, 1, 0]]
    connectivity, offsets = polygons(mesh_of(CORNERS, faces=faces))
    assert as_lists(connectivity, offsets) == faces
    assert connectivity.dtype == offsets.dtype == np.int64


@pytest.mark.parametrize("storage", ["Use64BitStorage", "Use32BitStorage"])
def test_every_storage_of_vtk_is_read(storage):
    connectivity, offsets = polygons(mesh_of(CORNERS, faces=[[0, 1, 4], [1, 2, 4]], storage=storage))
    assert as_lists(connectivity, offsets) == [[0, 1, 4], [1, 2, 4]]
    assert connectivity.dtype == offsets.dtype == np.int64


@pytest.mark.skipif(not hasattr(vtk.vtkCellArray, "UseFixedSize64BitStorage"), reason="VTK 9.5 and older have none")
@pytest.mark.parametrize("storage", ["UseFixedSize32BitStorage", "UseFixedSize64BitStorage"])
def test_storage_without_offsets_is_read(storage):
    array = vtk.vtkCellArray()
    getattr(array, storage)(3)
    array.InsertNextCell(3, [0, 1, 4])
    array.InsertNextCell(3, [1, 2, 4])
    mesh = mesh_of(CORNERS)
    mesh.SetPolys(array)
    assert as_lists(*polygons(mesh)) == [[0, 1, 4], [1, 2, 4]]


def test_vertices_and_lines_have_no_faces():
    mesh = mesh_of(CORNERS, verts=[[0], [1, 2]], lines=[[0, 1, 2]], faces=[[2, 3, 4]])
    assert as_lists(*polygons(mesh)) == [[2, 3, 4]]
    assert as_lists(*polygons(pv.PolyData(CORNERS))) == []
    assert as_lists(*polygons(pv.PolyData())) == []


def test_strips_are_cut_as_vtk_cuts_them():
    strips = [[0, 1, 3, 2, 4], [2, 4, 1], [0, 1, 4, 3]]
    mesh = mesh_of(CORNERS, faces=[[0, 1, 2]], strips=strips)
    expected = [[0, 1, 2]]
    for strip in strips:
        triangles = vtk.vtkIdList()
        cell = vtk.vtkTriangleStrip()
        cell.GetPointIds().SetNumberOfIds(len(strip))
        cell.GetPoints().SetNumberOfPoints(len(strip))
        for place, index in enumerate(strip):
            cell.GetPointIds().SetId(place, index)
            cell.GetPoints().SetPoint(place, CORNERS[index])
        decomposed = vtk.vtkCellArray()
        vtk.vtkTriangleStrip.DecomposeStrip(len(strip), strip, decomposed)
        for number in range(decomposed.GetNumberOfCells()):
            decomposed.GetCellAtId(number, triangles)
            expected.append([triangles.GetId(corner) for corner in range(3)])
    found = as_lists(*polygons(mesh))
    # the same triangles with the same orientation, whichever corner comes first
    turned = [tuple(face[face.index(min(face)) :] + face[: face.index(min(face))]) for face in found]
    assert turned == [tuple(face[face.index(min(face)) :] + face[: face.index(min(face))]) for face in expected]


def test_a_stripped_sphere_keeps_its_normals():
    sphere = pv.Sphere(theta_resolution=12, phi_resolution=12)
    stripped = sphere.strip()
    assert stripped.n_strips > 0
    np.testing.assert_allclose(vertex_normals(stripped), vertex_normals(sphere), atol=1e-15)


def test_the_arrays_are_the_callers_own():
    mesh = mesh_of(CORNERS, faces=[[0, 1, 2]])
    connectivity, offsets = polygons(mesh)
    connectivity[:] = 4
    offsets[:] = 0
    assert as_lists(*polygons(mesh)) == [[0, 1, 2]]


@pytest.mark.parametrize("index", [-1, 5, 10**9, -(10**9)])
def test_an_index_out_of_range_names_the_face_and_the_index(index):
    mesh = mesh_of(CORNERS, verts=[[0]], faces=[[0, 1, 2], [0, index, 2]])
    with pytest.raises(ValueError, match=rf"refer to its 5 points, 0 to 4; got index {index} in face 1\."):
        polygons(mesh)
    strip = mesh_of(CORNERS, faces=[[0, 1, 2]], strips=[[0, 1, 2, index]])
    with pytest.raises(ValueError, match=f"index {index} in strip 0"):
        polygons(strip)


def test_broken_offsets_are_refused():
    mesh = mesh_of(CORNERS, faces=[[0, 1, 2], [1, 2, 3]])
    vtk_to_numpy(mesh.GetPolys().GetOffsetsArray())[1:] = (5, 10**9)
    with pytest.raises(ValueError, match="face offsets rise from 0 to 6"):
        polygons(mesh)


def test_polygons_takes_polydata_only():
    with pytest.raises(ValueError, match=r"mesh must be a pyvista.PolyData; got UnstructuredGrid.*extract_surface"):
        polygons(examples.load_hexbeam())


# surface


def test_polydata_is_given_back_itself():
    mesh = pv.Sphere()
    assert surface(mesh) is mesh


@pytest.mark.parametrize(
    "mesh",
    [
        examples.load_hexbeam(),
        pv.ImageData(dimensions=(3, 4, 5)),
        pv.RectilinearGrid([0, 1, 3], [0, 1, 2], [0, 2, 5]),
        pv.ImageData(dimensions=(3, 3, 3)).cast_to_structured_grid(),
        pv.ImageData(dimensions=(3, 3, 3)).cast_to_structured_grid().cast_to_explicit_structured_grid(),
        pv.ImageData(dimensions=(3, 3, 1)),
        examples.cells.Polyhedron(),
        examples.cells.QuadraticHexahedron(),
        examples.cells.LagrangeHexahedron(),
        pv.Sphere().cast_to_unstructured_grid(),
    ],
    ids=lambda mesh: type(mesh).__name__,
)
def test_every_dataset_gives_its_surface_with_its_arrays(mesh):
    mesh = mesh.copy()
    mesh.point_data["height"] = mesh.points[:, 2] * 2
    mesh.cell_data["number"] = np.arange(mesh.n_cells)
    names = mesh.array_names
    found = surface(mesh)
    assert isinstance(found, pv.PolyData)
    assert found.n_faces > 0
    np.testing.assert_allclose(found.point_data["height"], found.points[:, 2] * 2, atol=1e-6)
    np.testing.assert_array_equal(found.cell_data["number"], found.cell_data["vtkOriginalCellIds"])
    np.testing.assert_array_equal(np.asarray(mesh.points)[found.point_data["vtkOriginalPointIds"]], found.points)
    assert mesh.array_names == names


def test_active_normals_stay_active():
    grid = pv.Sphere().cast_to_unstructured_grid()
    grid.point_data.active_normals = np.asarray(grid.points) * 2
    found = surface(grid)
    np.testing.assert_array_equal(found.point_data.active_normals, found.points * 2)


def test_points_with_normals_need_no_faces():
    cloud = pv.PolyData(CORNERS)
    cloud.point_data.active_normals = CORNERS
    assert surface(cloud) is cloud
    bare = pv.PointSet(CORNERS)
    bare.point_data.active_normals = CORNERS
    found = surface(bare)
    assert isinstance(found, pv.PolyData)
    np.testing.assert_array_equal(found.point_data.active_normals, CORNERS)


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (pv.PolyData(), "faces, or points with normals; got a PolyData with 0 points"),
        (pv.PolyData(CORNERS), "got a PolyData with 5 points, no faces and no point normals.*active_normals"),
        (pv.Line(), "got a PolyData with 2 points, no faces and no point normals"),
        (pv.PointSet(CORNERS), "got a PointSet with 5 points, no faces and no point normals"),
        (pv.UnstructuredGrid(), "got a UnstructuredGrid with 0 points"),
        (pv.ImageData(), "got a ImageData with 0 points"),
        (pv.ImageData(dimensions=(3, 1, 1)), "3 points, 2 cells but no surface"),
        (pv.MultiBlock(), "mesh must be a pyvista.DataSet; got MultiBlock"),
        (pv.Table(), "got Table"),
        (np.zeros((3, 3)), "got ndarray"),
        (None, "got NoneType"),
    ],
)
def test_what_is_missing_is_said(mesh, message):
    with pytest.raises(ValueError, match=message):
        surface(mesh)


def test_arrays_and_points_that_do_not_fit_are_refused():
    mesh = pv.ImageData(dimensions=(3, 3, 3)).cast_to_unstructured_grid()
    short = vtk.vtkDoubleArray()
    short.SetName("short")
    short.SetNumberOfTuples(2)
    mesh.GetCellData().AddArray(short)
    with pytest.raises(ValueError, match="one row per cell, 8 rows; got cell array 'short' with 2 rows"):
        surface(mesh)
    mesh.GetCellData().RemoveArray("short")
    mesh.GetPointData().AddArray(short)
    with pytest.raises(ValueError, match="one row per point, 27 rows; got point array 'short' with 2 rows"):
        surface(mesh)


# normals


def angle_normal(points, faces, index):
    """Angle-weighted normal of a point, corner by corner from the definition, for flat convex faces."""
    total = np.zeros(3)
    for face in faces:
        if index in face:
            here = face.index(index)
            a, b = points[face[here - 1]] - points[index], points[face[(here + 1) % len(face)]] - points[index]
            normal = np.cross(b, a)
            cosine = a @ b / np.linalg.norm(a) / np.linalg.norm(b)
            total += math.acos(cosine) * normal / np.linalg.norm(normal)
    return total / np.linalg.norm(total)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_vertex_normals_are_weighted_by_angle(dtype):
    faces = [[3, 2, 1, 0], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    found = vertex_normals(mesh_of(CORNERS.astype(dtype), faces=faces))
    expected = [angle_normal(CORNERS, faces, index) for index in range(5)]
    np.testing.assert_allclose(found, expected, atol=1e-14)
    assert found.dtype == np.float64


def test_the_weighting_is_passed_on():
    corner = [(0, 0, 0), (3, 0, 0), (0, 1, 0), (0, 0, 1)]
    mesh = mesh_of(corner, faces=[[0, 2, 1], [0, 1, 3], [0, 3, 2]])  # areas 3/2, 3/2 and 1/2
    diagonal = -np.array([(1, 1, 1), (1, 3, 3)]) / np.sqrt([[3], [19]])
    np.testing.assert_allclose(vertex_normals(mesh)[0], diagonal[0], atol=1e-15)
    np.testing.assert_allclose(vertex_normals(mesh, "area")[0], diagonal[1], atol=1e-15)
    with pytest.raises(ValueError, match="weighting must be one of"):
        vertex_normals(mesh, "vtk")


def test_normals_of_a_volume_are_its_surfaces():
    beam = examples.load_hexbeam()
    found = surface(beam)
    assert vertex_normals(beam).shape == (found.n_points, 3)
    assert face_normals(beam).shape == (found.n_faces, 3)
    centres = found.cell_centers().points
    assert (np.einsum("ij,ij->i", face_normals(beam), centres - np.array(beam.center)) > 0).all()  # outwards


def test_a_strip_has_a_face_normal_per_triangle():
    mesh = mesh_of(CORNERS, strips=[[0, 1, 3, 2]])
    np.testing.assert_array_equal(face_normals(mesh), [(0, 0, 1), (0, 0, 1)])


@pytest.mark.parametrize("call", [vertex_normals, face_normals])
def test_normals_need_faces(call):
    cloud = pv.PolyData(CORNERS)
    cloud.point_data.active_normals = CORNERS
    with pytest.raises(ValueError, match="a mesh with faces; got 5 points and no faces"):
        call(cloud)
    with pytest.raises(ValueError, match="no faces and no point normals"):
        call(pv.PolyData(CORNERS))


def test_normals_leave_the_mesh_as_it_is():
    mesh = pv.Sphere()
    before = mesh.copy()
    vertex_normals(mesh)
    face_normals(mesh)
    assert mesh == before
