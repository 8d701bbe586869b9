"""Surfaces of datasets: extraction, faces as plain arrays, normals from faces, and splitting by feature angle.

A surface shares points, cells and arrays with its mesh, like the outputs of VTK's filters.
"""

from __future__ import annotations

from typing import Any, Literal, TypeVar, get_args

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes

from pvphong.base import check
from pvphong.base.types import Backend, Float64Array, FloatArray, Weighting
from pvphong.geometry import normals
from pvphong.meshes.cells import cells, refuse_invalid
from pvphong.shading import kernel

# Least number of face corners for compiled code, which takes half a second to load. This number does not depend on
# previous calls, so equal calls on small meshes give equal bits.
_WORTH_LOADING = 2**19


def surface(mesh: pv.DataSet) -> pv.PolyData:
    """Return the surface of a dataset, for lighting.

    Parameters
    ----------
    mesh : pyvista.DataSet
        Any dataset with faces, or with active point normals, as a point cloud may have.

    Returns
    -------
    pyvista.PolyData
        For a PolyData, the mesh itself. For any other dataset, a new mesh with its outer faces, from
        `extract_surface`, and its point and cell arrays. The arrays ``vtkOriginalPointIds`` and ``vtkOriginalCellIds``
        hold the indices of points and cells in the dataset. With these indices, colours can be transferred back to the
        dataset.

    Raises
    ------
    ValueError
        If `mesh` is not a DataSet, has nothing that can be lit, or would crash VTK (an index out of range, a cell with
        too few points, dimensions or an array of the wrong length); the message names the cell.
    """
    if not isinstance(mesh, pv.DataSet):
        remedy = "Convert a VTK dataset with pyvista.wrap(...)."
        if isinstance(mesh, pv.MultiBlock):
            remedy = "For several blocks, use the methods of blocks.phong."
        check.refuse("mesh", type(mesh).__name__, "a pyvista.DataSet", remedy)
    refuse_invalid(mesh)
    result = outer_surface(mesh)
    if not result.n_points or not (has_faces(result) or has_normals(result)):
        allowed = "a mesh with faces, or points with normals"
        remedy = "Points without faces are lit by their normals: set mesh.point_data.active_normals."
        remedy = remedy if mesh.n_points else "It is empty."
        faceless = (
            "no faces" if isinstance(mesh, (pv.PolyData, pv.PointSet)) else f"{mesh.n_cells} cells but no surface"
        )
        what = f", {faceless} and no point normals" if mesh.n_points else ""
        check.refuse("mesh", f"a {type(mesh).__name__} with {mesh.n_points} points{what}", allowed, remedy)
    return result


def outer_surface(mesh: pv.DataSet) -> pv.PolyData:
    """Return the surface of a valid mesh, without checks; the mesh and the surface may be empty."""
    if isinstance(mesh, pv.PolyData):
        return mesh
    if isinstance(mesh, pv.PointSet):
        cloud = mesh.cast_to_polydata(deep=False)
        cloud.point_data.active_normals_name = mesh.point_data.active_normals_name  # the cast loses them
        return cloud
    # the filter could add indices too, but they are wrong for quadratic and other nonlinear cells
    numbered = mesh.copy(deep=False)
    numbered.point_data["vtkOriginalPointIds"] = np.arange(mesh.n_points)
    numbered.cell_data["vtkOriginalCellIds"] = np.arange(mesh.n_cells)
    points = np.asarray(mesh.points)
    name = "points"
    while name in numbered.point_data:
        name += "_"
    is_exact = bool(len(points)) and (isinstance(mesh, pv.Grid) or points.dtype == np.float64)
    if is_exact:
        # the filter computes points of grids and of nonlinear cells in float32, which is too coarse far from the
        # origin; arrays keep their type and are interpolated like points, so the points are passed as an array too
        numbered.point_data[name] = points.astype(np.float64, copy=False)
    result = numbered.extract_surface(pass_pointid=False, pass_cellid=False, algorithm=None)
    if is_exact and result.n_points:
        result.points = np.asarray(result.point_data.pop(name))
    return result


def has_faces(mesh: pv.PolyData) -> bool:
    """Return True if a mesh has a polygon or a triangle strip."""
    return bool(mesh.GetPolys().GetNumberOfCells() or mesh.GetStrips().GetNumberOfCells())


def has_only_triangles(mesh: pv.PolyData) -> bool:
    """Return True if all cells of a mesh are triangular polygons.

    Unlike PyVista's `is_all_triangles`, it is False for a mesh with triangle strips.
    """
    return not mesh.n_strips and mesh.is_all_triangles


def has_normals(mesh: pv.PolyData) -> bool:
    """Return True if a mesh's points have active normals."""
    return mesh.GetPointData().GetNormals() is not None


def polygons(mesh: pv.PolyData) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the faces of a mesh as plain arrays: its polygons, then the triangles of its triangle strips.

    Parameters
    ----------
    mesh : pyvista.PolyData
        The mesh; vertices and lines are ignored. No VTK algorithm runs on it.

    Returns
    -------
    connectivity : ndarray
        int64, the point indices of all faces, one face after the other. All triangles of a strip have the orientation
        of its first triangle, as in ``vtkTriangleStrip``.
    offsets : ndarray
        int64, shape (n_faces + 1,): the start of each face in `connectivity`, and the end of the last.

    Raises
    ------
    ValueError
        If `mesh` is not a PolyData, or a face has an index out of range; the message names the index and the face.
    """
    if not isinstance(mesh, pv.PolyData):
        check.refuse(
            "mesh", type(mesh).__name__, "a pyvista.PolyData", "Extract its surface with mesh.extract_surface()."
        )
    for array in cells(mesh)[2:]:
        array.refuse_out_of_range(mesh.n_points)
    connectivity, offsets = unchecked_polygons(mesh)
    return np.array(connectivity, np.int64), np.array(offsets, np.int64)


def unchecked_polygons(mesh: pv.PolyData) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the faces of a mesh like `polygons`, without checks.

    The arrays must not be modified: without strips, they are VTK's own memory.
    """
    _, _, faces, strips = cells(mesh)
    if not strips.count:
        return faces.connectivity, faces.offsets
    counts = np.maximum(np.diff(strips.offsets) - 2, 0)
    place = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)  # index of a triangle in its strip
    triangles = strips.connectivity[(np.repeat(strips.offsets[:-1], counts) + place)[:, None] + np.arange(3)]
    odd = place % 2 == 1  # turn every second triangle, because orientations alternate in a strip
    triangles[odd] = triangles[odd][:, [1, 0, 2]]
    ends = faces.offsets[-1] + 3 * np.arange(1, len(triangles) + 1)
    return np.concatenate([faces.connectivity, triangles.ravel()]), np.concatenate([faces.offsets, ends])


def vertex_normals(mesh: pv.DataSet, weighting: Weighting = "angle", *, backend: Backend = "auto") -> Float64Array:
    """Compute unit normals of a mesh's points: weighted means of the normals of the faces around each point.

    Stored normals are ignored. Points are neither split nor merged, so there is one row per point.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with faces. If it is not a PolyData, the normals are for its extracted surface.
    weighting : {"angle", "area", "max"}, default "angle"
        Weight of a face at a corner; see `pvphong.geometry.normals.point_normals`.
    backend : {"auto", "numpy", "numba"}
        "numba" is compiled code, which needs the extra `fast` and is several times faster than "numpy". The results
        differ by a few roundings. "auto" uses compiled code for large meshes if it is already compiled; so equal calls
        may differ by these roundings. With "numpy" or "numba", equal calls give equal bits. "numba" waits a few seconds
        for the compiler, once per installation. Even with "numba", NumPy may compute the normals of a mesh if a face
        has more than 384 corners, or if the mesh's size is below 2⁻¹⁰⁰ or above 2¹⁰⁰.

    Returns
    -------
    ndarray
        Shape (n_points, 3), float64. The vector is zero for a point whose faces all lack an area, or have normals that
        cancel.

    Raises
    ------
    ValueError
        If `mesh` is not a valid DataSet or has no faces, the weighting or the backend is unknown, or Numba is missing.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> ph.pipeline.vertex_normals(pv.Plane(i_resolution=1, j_resolution=1))[0]
    array([0., 0., 1.])
    """
    check.choice("weighting", weighting, get_args(Weighting))
    kernel.check_backend(backend)
    source = _with_faces(mesh)
    return weighted_normals(check.array("points", source.points), *unchecked_polygons(source), weighting, backend)


def weighted_normals(
    points: FloatArray,
    connectivity: Any,
    offsets: Any,
    weighting: Weighting = "angle",
    backend: Backend = "auto",
) -> Float64Array:
    """Compute the unit normals of a mesh's points, given as plain arrays, shape (n, 3).

    `connectivity` has the point indices of all faces, and `offsets` the start of each face in `connectivity`.
    `weighting` is the weight of a face at a corner; see `pvphong.geometry.normals.point_normals`. `backend` selects
    NumPy or compiled code; see `vertex_normals`.
    """
    waits = backend == "numba"
    if waits or (backend == "auto" and len(connectivity) >= _WORTH_LOADING):
        found = kernel.point_normals(points, connectivity, offsets, weighting, waits=waits)
        if found is not None:
            return found
    return normals.point_normals(points, connectivity, offsets, weighting)


def face_normals(mesh: pv.DataSet) -> Float64Array:
    """Compute unit normals of a mesh's faces. Corners run counter-clockwise as seen from the front.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with faces. If it is not a PolyData, the normals are for its extracted surface.

    Returns
    -------
    ndarray
        Shape (n_faces, 3), float64, in the order of `polygons`: a strip has one face per triangle. The vector is zero
        for a face without area, or with a point that is not finite.

    Raises
    ------
    ValueError
        If `mesh` is not a valid DataSet, or has no faces.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> ph.pipeline.face_normals(pv.Plane(i_resolution=1, j_resolution=1))
    array([[0., 0., 1.]])
    """
    source = _with_faces(mesh)
    return normals.polygon_normals(source.points, *unchecked_polygons(source))


def _with_faces(mesh: pv.DataSet) -> pv.PolyData:
    source = surface(mesh)
    if not has_faces(source):
        remedy = "Normals are computed from faces; stored ones are in mesh.point_data.active_normals."
        check.refuse("mesh", f"{source.n_points} points and no faces", "a mesh with faces", remedy)
    return source


FeatureAngle = float | Literal["auto"] | None
"""An edge is sharp if the normals of its faces differ by more than this angle in degrees; see `split_sharp_edges`."""

ORIGINAL_POINT = "pvphong_original_point"
"""Name of the point array with each point's index before edges were split."""

_AUTO = 30.0
"""Feature angle in degrees that "auto" stands for. The docstrings in `meshes/lit.py` and `plotter.py` repeat it."""


def sharp_angle(mesh: pv.PolyData, feature_angle: FeatureAngle) -> float | None:
    """Return the angle in degrees above which edges of a surface are split; None if no edge is split.

    The feature angle "auto" becomes a number or None as in `split_sharp_edges`.
    """
    if isinstance(feature_angle, str):
        if feature_angle != "auto":
            check.refuse("feature_angle", feature_angle, 'degrees from 0 to 180, "auto" or None')
        return None if has_normals(mesh) else _AUTO
    if feature_angle is None:
        return None
    return check.number("feature_angle", feature_angle, at_least=0.0, at_most=180.0)


def split_sharp_edges(mesh: pv.PolyData, feature_angle: FeatureAngle) -> tuple[pv.PolyData, NDArray[np.int64] | None]:
    """Duplicate the points of a surface along its sharp edges.

    Points are split as by vtkPolyDataNormals, but faces are not reoriented.

    Parameters
    ----------
    mesh : pyvista.PolyData
        A checked surface; it is not modified.
    feature_angle : float, "auto" or None
        Edges are split if the normals of their faces differ by more than this angle, in degrees from 0 to 180. 0 is
        flat shading: each face has its own points. Existing point normals are removed, because they belong to the
        points before splitting. "auto" is 30, as in Blender's "smooth by angle" and in PyVista, if the mesh has no
        point normals; if it has, "auto" splits nothing. None splits nothing.

    Returns
    -------
    surface : pyvista.PolyData
        The mesh itself if it has no faces, if `feature_angle` is None, or if "auto" splits nothing. In all other cases,
        a new mesh with all arrays and the point array ``pvphong_original_point``, int64, with the original index of
        each point. If `mesh` is the result of an earlier split, these are the indices before the earlier split.
        Triangle strips become triangles.
    points : ndarray or None
        Index in `mesh` of each point of the surface, shape (n_points,); None if the surface is `mesh` itself.

    Raises
    ------
    ValueError
        If the angle is invalid.
    """
    if feature_angle is None or not has_faces(mesh):
        return mesh, None
    angle, is_auto = sharp_angle(mesh, feature_angle), isinstance(feature_angle, str)
    if angle is None:
        return mesh, None
    faces, offsets = unchecked_polygons(mesh)
    same = np.arange(mesh.n_points)
    if angle == 0.0:
        split, points = _apart(mesh, faces, offsets)
    else:
        faces, added = _split_points(mesh, faces, offsets, angle)
        if is_auto and not len(added):
            return mesh, None
        points = np.concatenate([same, added])
        is_shared = not (len(added) or mesh.n_strips)
        split = shallow_copy(mesh) if is_shared else _rebuilt(mesh, points, faces, offsets, same)
    if has_normals(split):
        del split.point_data[split.point_data.active_normals_name]
    before = mesh.point_data.get(ORIGINAL_POINT)
    split.point_data[ORIGINAL_POINT] = points if before is None else np.asarray(before)[points]
    return split, points


def _apart(mesh: pv.PolyData, faces: NDArray[Any], offsets: NDArray[Any]) -> tuple[pv.PolyData, NDArray[np.int64]]:
    """Return a surface in which each face has its own points, and the index in `mesh` of each new point, shape (n,).

    Coplanar faces are separated too. A vertex cell or line cell keeps its points that no face uses. A point that faces
    use is replaced by the copy in one of these faces.

    Parameters
    ----------
    mesh : pyvista.PolyData
        The original surface.
    faces, offsets : ndarray
        Its faces, from `polygons`.
    """
    place = np.full(mesh.n_points, -1)
    place[faces[::-1]] = np.arange(len(faces))[::-1]
    loose = np.unique(np.concatenate([each.connectivity for each in cells(mesh)[:2]]))
    loose = loose[place[loose] < 0]
    place[loose] = len(faces) + np.arange(len(loose))
    points = np.concatenate([faces, loose]).astype(np.int64, copy=False)
    return _rebuilt(mesh, points, np.arange(len(faces)), offsets, place), points


def _split_points(
    mesh: pv.PolyData, faces: NDArray[Any], offsets: NDArray[Any], angle: float
) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Split a surface along its sharp edges. Return the new faces, and the points that were duplicated.

    Parameters
    ----------
    mesh : pyvista.PolyData
        The original surface.
    faces, offsets : ndarray
        Its faces, from `polygons`.
    angle : float
        Edges are sharp if the normals of their faces differ by more than this, in degrees.

    Returns
    -------
    faces : ndarray
        Connectivity of the split faces; an index >= `mesh.n_points` is a new point.
    points : ndarray
        For each new point, the index of its original in `mesh`.
    """
    if len(faces) >= _WORTH_LOADING:
        found = kernel.split_points(check.array("points", mesh.points), faces, offsets, angle, waits=False)
        if found is not None:
            return found
    bare = pv.PolyData()
    bare.SetPoints(mesh.GetPoints())
    bare.faces = pv.CellArray.from_arrays(offsets, faces)
    options: dict[str, Any] = dict.fromkeys(
        ("cell_normals", "consistent_normals", "auto_orient_normals", "non_manifold_traversal", "flip_normals"), False
    )
    split = bare.compute_normals(point_normals=True, split_vertices=True, feature_angle=angle, **options)
    points = np.asarray(split.point_data["pyvistaOriginalPointIds"]).astype(np.int64, copy=False)
    return cells(split)[2].connectivity, points[mesh.n_points :]


def _rebuilt(
    mesh: pv.PolyData,
    points: NDArray[np.int64],
    faces: NDArray[Any],
    offsets: NDArray[Any],
    place: NDArray[np.int64],
) -> pv.PolyData:
    """Return a mesh with new points and faces, and with the arrays and all other cells of `mesh`.

    Parameters
    ----------
    mesh : pyvista.PolyData
        The original mesh; its strips become triangles.
    points : ndarray
        For each new point, the index of its original in `mesh`.
    faces, offsets : ndarray
        The new faces, in the order of `polygons`.
    place : ndarray
        For each point of `mesh`, the index of the new point that replaces it in vertex and line cells.
    """
    verts, lines, _, strips = cells(mesh)
    split = pv.PolyData()
    moved = np.take(np.asarray(mesh.points), points, axis=0)
    split.SetPoints(pv.vtk_points(moved, deep=False, force_float=False))
    split.verts, split.lines = (
        pv.CellArray.from_arrays(each.offsets, place[each.connectivity]) for each in (verts, lines)
    )
    split.faces = pv.CellArray.from_arrays(offsets, faces)
    triangles = np.maximum(np.diff(strips.offsets) - 2, 0)  # number of triangles of each strip
    copies = np.concatenate([np.ones(mesh.n_cells - strips.count, np.int64), triangles])
    before = np.repeat(np.arange(mesh.n_cells), copies) if strips.count else None
    for given, kept, rows in ((mesh.point_data, split.point_data, points), (mesh.cell_data, split.cell_data, before)):
        for name, array in given.items():
            kept.set_array(array if rows is None else np.take(np.asarray(array), rows, axis=0), name)
        for kind in range(vtkDataSetAttributes.NUM_ATTRIBUTES):
            active = given.GetAbstractAttribute(kind)
            if active is not None:
                kept.SetActiveAttribute(active.GetName(), kind)
    split.field_data.update(mesh.field_data)
    split.copy_meta_from(mesh, deep=True)  # records which arrays have type bool
    return split


_Mesh = TypeVar("_Mesh", bound=pv.PolyData)


def drawable(mesh: pv.DataSet, name: str) -> pv.DataSet:
    """Return a mesh whose colours are clipped to [0, 1] for drawing, because VTK draws larger values wrongly.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A mesh with colours as the point array `name`. The mesh is not modified, and shares all other data with the
        result.
    name : str
        Name of the array, of floats or uint8. uint8 colours are not changed.
    """
    result, colors = mesh.copy(deep=False), np.asarray(mesh.point_data[name])
    if colors.dtype != np.uint8:
        result.point_data[name] = np.clip(np.nan_to_num(colors), 0.0, 1.0)
    return result


def shallow_copy(mesh: _Mesh) -> _Mesh:
    """Return a new mesh that shares points, cells and arrays with `mesh`.

    Adding, replacing or removing arrays, or setting points, cells or active arrays, affects only one of the two meshes.
    Changing the values or the name of a shared array affects both.
    """
    result = type(mesh)()
    result.shallow_copy(mesh)
    # A deep copy of PyVista's record of bool arrays. `copy` would share it, so setting an array of one mesh would
    # affect both.
    result.copy_meta_from(mesh, deep=True)
    # PyVista replaces the array inside VTK's points object, so each mesh needs its own object. It also needs its own
    # VTK array: putting one array into two objects would mark it as modified.
    result.SetPoints(pv.vtk_points(np.asarray(result.points), deep=False, force_float=False))
    return result


def point_normals(mesh: pv.PolyData, weighting: Weighting | None = None, *, backend: Backend = "auto") -> FloatArray:
    """Return the point normals for lighting a surface, shape (n, 3).

    The surface's active point normals are returned unchanged. If it has none, or a weighting is given, normals are
    computed from its faces. Cell normals are ignored, because vertices are lit, not faces.
    """
    if weighting is None and has_normals(mesh):
        stored: FloatArray = vtk_to_numpy(mesh.GetPointData().GetNormals())
        return stored
    return vertex_normals(mesh, weighting or "angle", backend=backend)
