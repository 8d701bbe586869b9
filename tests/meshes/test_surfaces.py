"""Surfaces of datasets, their faces as arrays, and their normals."""

import numpy as np
import pytest
import pyvista as pv
import vtk
from pyvista import examples
from soups import faces_of, mesh_of, soup

import pvphong as ph
from pvphong.geometry.normals import point_normals, polygon_normals
from pvphong.meshes.surfaces import face_normals, has_only_triangles, polygons, surface, vertex_normals
from pvphong.shading import kernel

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)], dtype=float)


def full_mesh(*, faces=(), strips=(), verts=(), lines=()):
    """Return a mesh over `CORNERS`, with any kinds of cells that a PolyData may have."""
    mesh = mesh_of(CORNERS, *faces)
    for setter, cells in ((mesh.SetStrips, strips), (mesh.SetVerts, verts), (mesh.SetLines, lines)):
        connectivity, offsets = soup(*cells)
        setter(pv.CellArray.from_arrays(offsets, connectivity, deep=True))
    return mesh


# --- polygons ---


def test_strips_are_cut_as_vtk_cuts_them():
    strips = [[0, 1, 3, 2, 4], [2, 4, 1], [0, 1, 4, 3]]
    decomposed, triangle = vtk.vtkCellArray(), vtk.vtkIdList()
    for strip in strips:
        vtk.vtkTriangleStrip.DecomposeStrip(len(strip), strip, decomposed)
    expected = [[0, 1, 2]]
    for number in range(decomposed.GetNumberOfCells()):
        decomposed.GetCellAtId(number, triangle)
        expected.append([triangle.GetId(corner) for corner in range(3)])

    def from_the_least(face):
        """Rotate a triangle to a canonical first corner, with the same orientation."""
        return face[face.index(min(face)) :] + face[: face.index(min(face))]

    found = faces_of(full_mesh(faces=[[0, 1, 2]], strips=strips))
    assert list(map(from_the_least, found)) == list(map(from_the_least, expected))


def test_broken_strips_and_other_datasets_are_refused():
    with pytest.raises(ValueError, match=r"refer to its 5 points, 0 to 4; got index 5 in strip 0\."):
        polygons(full_mesh(faces=[[0, 1, 2]], strips=[[0, 1, 2, 5]]))
    with pytest.raises(ValueError, match=r"mesh must be a pyvista.PolyData; got UnstructuredGrid.*extract_surface"):
        polygons(examples.load_hexbeam())


def test_a_mesh_of_triangles_and_strips_has_not_only_triangles():
    """PyVista's `is_all_triangles` is True for it."""
    assert has_only_triangles(full_mesh(faces=[[0, 1, 2]]))
    assert not has_only_triangles(full_mesh(faces=[[0, 1, 2]], strips=[[0, 2, 3, 4]]))
    assert not has_only_triangles(full_mesh(faces=[[0, 1, 2, 3]]))


# --- surface ---

GRID = pv.ImageData(dimensions=(3, 3, 3))
DATASETS = [
    examples.load_hexbeam(),
    pv.ImageData(dimensions=(3, 4, 5)),
    pv.RectilinearGrid([0, 1, 3], [0, 1, 2], [0, 2, 5]),
    GRID.cast_to_structured_grid(),
    GRID.cast_to_structured_grid().cast_to_explicit_structured_grid(),
    pv.ImageData(dimensions=(3, 3, 1)),
    examples.cells.Polyhedron(),
    examples.cells.QuadraticHexahedron(),
    examples.cells.LagrangeHexahedron(),
    pv.Sphere().cast_to_unstructured_grid(),
]


@pytest.mark.parametrize("mesh", DATASETS, ids=lambda mesh: type(mesh).__name__)
def test_every_dataset_gives_its_surface_with_its_arrays_and_active_normals(mesh):
    mesh = mesh.copy()
    mesh.point_data["height"] = mesh.points[:, 2] * 2
    mesh.point_data.active_normals = np.asarray(mesh.points) * 2
    mesh.cell_data["number"] = np.arange(mesh.n_cells)
    names = mesh.array_names
    found = surface(mesh)
    assert isinstance(found, pv.PolyData)
    assert found.n_faces > 0
    np.testing.assert_allclose(found.point_data["height"], found.points[:, 2] * 2, atol=1e-6)
    np.testing.assert_array_equal(found.point_data.active_normals, found.points * 2)
    np.testing.assert_array_equal(found.cell_data["number"], found.cell_data["vtkOriginalCellIds"])
    np.testing.assert_array_equal(np.asarray(mesh.points)[found.point_data["vtkOriginalPointIds"]], found.points)
    assert mesh.array_names == names


FAR = np.array([500_000.37, 5_400_000.77, 100.13])  # metres, as in UTM
X, Y = np.meshgrid(np.arange(12.0) * 30, np.arange(9.0) * 30, indexing="ij")
TERRAIN = pv.StructuredGrid(X, Y, 40 * np.sin(X / 90) * np.cos(Y / 70))


def moved(mesh, offset):
    """Return a moved mesh, with points in float64 if it stores points."""
    mesh = mesh.copy()
    if isinstance(mesh, pv.ImageData):
        mesh.origin = np.add(mesh.origin, offset)
    elif isinstance(mesh, pv.RectilinearGrid):
        mesh.x, mesh.y, mesh.z = (each + by for each, by in zip((mesh.x, mesh.y, mesh.z), offset, strict=True))
    else:
        mesh.points = np.asarray(mesh.points, float) + offset
    return mesh


@pytest.mark.parametrize("mesh", [*DATASETS, TERRAIN, examples.cells.BezierHexahedron()])
def test_far_from_the_origin_a_surface_has_the_points_that_it_has_there(mesh):
    """The points agree to a rounding of float64; VTK's filter uses float32, up to a quarter of a metre off."""
    near, far = surface(moved(mesh, np.zeros(3))), surface(moved(mesh, FAR))
    assert far.points.dtype == np.float64
    assert "points" not in far.point_data
    np.testing.assert_array_equal(far.faces, near.faces)
    np.testing.assert_allclose(far.points - FAR, near.points, atol=4 * np.spacing(FAR.max()))


def test_the_filter_takes_a_users_array_of_the_same_name_along():
    mesh = moved(TERRAIN, FAR)
    mesh["points"] = np.arange(mesh.n_points)
    found = surface(mesh)
    np.testing.assert_array_equal(found["points"], found["vtkOriginalPointIds"])
    np.testing.assert_array_equal(found.points, mesh.points[found["points"]])


def test_a_terrain_has_the_colours_far_away_that_it_has_at_the_origin():
    scene = ph.Scene(lights=[ph.DirectionalLight(direction=(-1, -0.5, -2))])  # from below, where the faces point
    near, far = (moved(TERRAIN, offset).phong.shade(scene)["phong"] for offset in (np.zeros(3), FAR))
    np.testing.assert_allclose(far, near, atol=1e-6)
    assert np.ptp(near) > 0.1


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (pv.PolyData(), "faces, or points with normals; got a PolyData with 0 points"),
        (pv.PolyData(CORNERS), "got a PolyData with 5 points, no faces and no point normals.*active_normals"),
        (pv.PointSet(CORNERS), "got a PointSet with 5 points, no faces and no point normals"),
        (pv.ImageData(dimensions=(3, 1, 1)), "3 points, 2 cells but no surface"),
        (pv.MultiBlock(), r"mesh must be a pyvista\.DataSet; got MultiBlock\. .* methods of blocks\.phong"),
        (pv.Table(), "got Table"),
        (np.zeros((3, 3)), "got ndarray"),
        (None, "got NoneType"),
    ],
)
@pytest.mark.parametrize("call", [surface, vertex_normals, face_normals])
def test_what_is_missing_is_said(call, mesh, message):
    with pytest.raises(ValueError, match=message):
        call(mesh)
    cloud = pv.PointSet(CORNERS)
    cloud.point_data.active_normals = CORNERS
    if call is surface:
        np.testing.assert_array_equal(call(cloud).point_data.active_normals, CORNERS)
    else:
        with pytest.raises(ValueError, match="a mesh with faces; got 5 points and no faces"):
            call(cloud)


# --- normals ---


BACKENDS = {"numpy": point_normals} | ({"numba": kernel.point_normals} if kernel.is_available() else {})


@pytest.mark.parametrize("mesh", [pv.Sphere(), pv.Sphere().strip(), examples.load_airplane(), *DATASETS])
def test_normals_are_those_of_the_surfaces_stored_points_and_faces_and_the_mesh_is_left_alone(mesh):
    """A named backend gives its own bits; by default a small mesh uses NumPy."""
    before, source = mesh.copy(), surface(mesh)
    stored = np.asarray(source.points), *polygons(source)
    for weighting in ("angle", "area", "max"):
        for backend, form in ({"auto": point_normals} | BACKENDS).items():
            expected = form(*stored, weighting)
            np.testing.assert_array_equal(vertex_normals(mesh, weighting, backend=backend), expected)
            np.testing.assert_array_equal(mesh.phong.normals(weighting, backend=backend), expected)
    np.testing.assert_array_equal(vertex_normals(mesh), point_normals(*stored, "angle"))
    np.testing.assert_array_equal(face_normals(mesh), polygon_normals(*stored))
    assert mesh == before


@pytest.mark.parametrize("has_code", [False, True])
def test_large_meshes_have_compiled_normals_where_the_code_is_there(monkeypatch, has_code):
    mesh, asked = pv.Plane(), []

    def compiled(points, _connectivity, _offsets, weighting, *, waits):
        asked.append((weighting, waits))
        return np.zeros((len(points), 3)) if has_code else None

    monkeypatch.setattr(kernel, "point_normals", compiled)
    monkeypatch.setattr("pvphong.meshes.surfaces._WORTH_LOADING", 4 * mesh.n_cells + 1)
    assert (vertex_normals(mesh) == (0, 0, 1)).all()
    assert not asked
    monkeypatch.setattr("pvphong.meshes.surfaces._WORTH_LOADING", 4 * mesh.n_cells)
    assert (vertex_normals(mesh, "area") == (0, 0, 0 if has_code else 1)).all()
    assert asked == [("area", False)]
    assert (vertex_normals(mesh, backend="numpy") == (0, 0, 1)).all()
    assert len(asked) == 1
