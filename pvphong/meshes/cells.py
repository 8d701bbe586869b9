"""Reading the cells of a PyVista dataset, and refusing what would crash VTK.

VTK's algorithms trust a mesh: an index beyond the points, a cell with too few points, a dimension or an
array that does not fit ends the process. Everything here reads memory that is certainly there, and nothing
else, so it may be called on any mesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkGenericCell

from pvphong.base import check
from pvphong.base.types import IntArray


@dataclass(frozen=True)
class Cells:
    """One of a mesh's cell arrays, as views of VTK's memory.

    Attributes
    ----------
    label : str
        What an error calls one of them.
    first : int
        The mesh's number of the first of them: in a PolyData vertices come first, then lines, faces, strips.
    connectivity : ndarray
        Their point indices, one cell after the other.
    offsets : ndarray
        Shape (count + 1,): where each cell starts in `connectivity`, and the end.
    """

    label: str
    first: int
    connectivity: NDArray[Any]
    offsets: NDArray[Any]

    @property
    def count(self) -> int:
        """How many cells there are."""
        return len(self.offsets) - 1

    def out_of_range(self, n_points: int) -> IntArray:
        """Which of the cells have an index that is none of the points'."""
        if not len(self.connectivity) or (self.connectivity.min() >= 0 and self.connectivity.max() < n_points):
            return np.empty(0, dtype=np.intp)
        bad = np.flatnonzero((self.connectivity < 0) | (self.connectivity >= n_points))
        return np.unique(np.searchsorted(self.offsets, bad, side="right") - 1)

    def refuse_out_of_range(self, n_points: int) -> None:
        """Raise ``ValueError`` with the first cell that has such an index, and the index."""
        bad = self.out_of_range(n_points)
        if len(bad):
            corners = self.connectivity[self.offsets[bad[0]] : self.offsets[bad[0] + 1]]
            index = corners[(corners < 0) | (corners >= n_points)][0]
            allowed = f"a mesh whose cells refer to its {n_points} points" + (f", 0 to {n_points - 1}" * (n_points > 0))
            remedy = "The file or the code that made the cells counts its points differently; see pvphong.diagnose."
            check.refuse("mesh", f"index {index} in {self.label} {bad[0]}", allowed, remedy)


def cells(mesh: pv.DataSet) -> list[Cells]:
    """The cell arrays of a mesh; none of a dataset whose cells are implied by its dimensions.

    Raises
    ------
    ValueError
        If an array's offsets reach beyond its connectivity.
    """
    if isinstance(mesh, pv.PolyData):
        arrays = {
            "vertex": mesh.GetVerts(),
            "line": mesh.GetLines(),
            "face": mesh.GetPolys(),
            "strip": mesh.GetStrips(),
        }
    elif isinstance(mesh, (pv.UnstructuredGrid, pv.ExplicitStructuredGrid)):
        arrays = {"cell": mesh.GetCells()}
    else:
        arrays = {}
    result: list[Cells] = []
    for label, array in arrays.items():
        result.append(_read(label, array, sum(earlier.count for earlier in result)))
    return result


def _read(label: str, array: Any, first: int = 0) -> Cells:
    if array is None or array.GetNumberOfCells() == 0:
        return Cells(label, first, np.empty(0, dtype=np.int64), np.zeros(1, dtype=np.int64))
    connectivity = vtk_to_numpy(array.GetConnectivityArray())
    offsets = vtk_to_numpy(array.GetOffsetsArray())
    if offsets[0] != 0 or (np.diff(offsets) < 0).any() or offsets[-1] > len(connectivity):
        allowed = f"a mesh whose {label} offsets rise from 0 to {len(connectivity)}, the length of their connectivity"
        check.refuse("mesh", f"offsets from {offsets.min()} to {offsets.max()}", allowed)
    return Cells(label, first, connectivity[: offsets[-1]], offsets)


def _polyhedron_faces(mesh: pv.DataSet) -> tuple[Cells, Cells] | None:
    """The faces of a mesh's polyhedra, and for every cell which of them are its own; None where there are none."""
    if not isinstance(mesh, pv.UnstructuredGrid) or mesh.GetPolyhedronFaces() is None:
        return None
    faces = _read("polyhedron face", mesh.GetPolyhedronFaces())
    return faces, _read("polyhedron", mesh.GetPolyhedronFaceLocations())


def _too_small(mesh: pv.DataSet) -> tuple[IntArray, NDArray[Any], NDArray[Any]]:
    """Cells with fewer points than their type has, those numbers of points, and the types' numbers."""
    none = np.empty(0, dtype=np.intp)
    if not isinstance(mesh, pv.UnstructuredGrid) or mesh.n_cells == 0:
        return none, none, none
    kinds = np.unique(mesh.celltypes)
    least = np.zeros(256, dtype=np.int64)
    for kind in kinds.tolist():
        cell = vtkGenericCell.InstantiateCell(kind)
        least[kind] = 0 if cell is None else cell.GetNumberOfPoints()
    sizes, needed = np.diff(cells(mesh)[0].offsets), least[mesh.celltypes]
    small = np.flatnonzero(sizes < needed)
    return small, sizes[small], needed[small]


def _point_sets(mesh: pv.DataSet) -> IntArray:
    """Cells that are the hull of their points: VTK's triangulation of some, flat ones above all, ends the process."""
    if not isinstance(mesh, pv.UnstructuredGrid):
        return np.empty(0, dtype=np.intp)
    return np.flatnonzero(mesh.celltypes == pv.CellType.CONVEX_POINT_SET)


def invalid_cells(mesh: pv.DataSet) -> IntArray:
    """The mesh's numbers of the cells that would crash VTK, in rising order.

    They refer to points that do not exist, have fewer points than their type, or are convex point sets.
    """
    n_points = mesh.n_points
    found = [array.first + array.out_of_range(n_points) for array in cells(mesh)]
    found += [_too_small(mesh)[0], _point_sets(mesh)]
    polyhedra = _polyhedron_faces(mesh)
    if polyhedra is not None:
        faces, owners = polyhedra
        found.append(owners.out_of_range(faces.count))
        owned = np.isin(owners.connectivity, faces.out_of_range(n_points))
        found.append(np.searchsorted(owners.offsets, np.flatnonzero(owned), side="right") - 1)
    return np.unique(np.concatenate(found))


def refuse_invalid(mesh: pv.DataSet) -> None:
    """Raise ``ValueError`` for a mesh that would crash VTK, with the cell, the dimensions or the array to blame."""
    for array in cells(mesh):
        array.refuse_out_of_range(mesh.n_points)
    polyhedra = _polyhedron_faces(mesh)
    if polyhedra is not None:
        polyhedra[0].refuse_out_of_range(mesh.n_points)
        polyhedra[1].refuse_out_of_range(polyhedra[0].count)
    small, sizes, needed = _too_small(mesh)
    if len(small):
        got = f"cell {small[0]} with {sizes[0]} points where its type has {needed[0]}"
        check.refuse("mesh", got, "a mesh whose cells have all their points")
    hulls = _point_sets(mesh)
    if len(hulls):
        allowed = "a mesh without convex point sets, because VTK's triangulation of some ends the process"
        remedy = "pv.PolyData(points).delaunay_3d() makes tetrahedra of its points."
        check.refuse("mesh", f"cell {hulls[0]}, a convex point set", allowed, remedy)
    refuse_misfits(mesh)


def refuse_misfits(mesh: pv.DataSet) -> None:
    """Raise ``ValueError`` for dimensions or an array of another length than the points or cells."""
    if isinstance(mesh, pv.StructuredGrid) and np.prod(mesh.dimensions) != mesh.n_points:
        got = f"{mesh.n_points} points in dimensions {tuple(mesh.dimensions)}"
        check.refuse("mesh", got, "a grid with a point for each place in its dimensions")
    _refuse_short_arrays(mesh)


def _refuse_short_arrays(mesh: pv.DataSet) -> None:
    for of, data, count in (("point", mesh.GetPointData(), mesh.n_points), ("cell", mesh.GetCellData(), mesh.n_cells)):
        for number in range(data.GetNumberOfArrays()):
            array = data.GetAbstractArray(number)
            if array.GetNumberOfTuples() != count:
                got = f"{of} array {array.GetName()!r} with {array.GetNumberOfTuples()} rows"
                check.refuse("mesh", got, f"a mesh whose {of} arrays have one row per {of}, {count} rows")
