"""Access to the cells of a PyVista dataset, and refusal of meshes that would crash VTK.

VTK's algorithms do not check a mesh. They crash the process if a point index is out of range, a cell has too few
points, or the dimensions or the length of an array are wrong. The functions here read only memory that is known to
exist, so they are safe for any mesh.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkGenericCell

from pvphong.base import check
from pvphong.base.types import IntArray

# Number of valid cell arrays that are remembered, and number of offsets that are checked at once.
_REMEMBERED, _AT_ONCE = 1024, 2**20

_in_order: dict[tuple[int, ...], None] = {}
_lock = threading.Lock()


def _remember(version: tuple[int, ...] | None) -> None:
    """Remember the version of an array whose indices are valid. If there are too many, forget the oldest one.

    An array without a version (None) is not remembered.
    """
    if version is not None:
        with _lock:
            _in_order[version] = None
            if len(_in_order) > _REMEMBERED:
                del _in_order[next(iter(_in_order))]


@dataclass(frozen=True)
class Cells:
    """One of a mesh's cell arrays, such as its faces, as views of VTK's memory.

    Attributes
    ----------
    label : str
        Name of a cell of this array in error messages, such as "face".
    first : int
        Index of the array's first cell in the mesh. In a PolyData, vertices come first, then lines, faces and strips.
    count : int
        Number of cells.
    connectivity : ndarray
        Point indices of all cells, one cell after the other.
    version : tuple or None
        Value that changes when the array is modified. With it, an unmodified array is checked only once. None if the
        array is checked each time.
    """

    label: str
    first: int
    count: int
    connectivity: NDArray[Any]
    version: tuple[int, ...] | None
    _array: Any

    @cached_property
    def offsets(self) -> NDArray[Any]:
        """Index in `connectivity` at which each cell starts, and the end of the last cell, shape (count + 1,).

        VTK does not store offsets of cells of equal size; they are created at the first access.
        """
        return vtk_to_numpy(self._array.GetOffsetsArray()) if self.count else np.zeros(1, dtype=np.int64)

    def out_of_range(self, n_points: int) -> IntArray:
        """Return the cells of this array with a point index that is negative or not below `n_points`.

        The result has the cells' indices in this array, in ascending order.
        """
        version = self.version and (*self.version, n_points)
        unsigned = self.connectivity.view(f"u{self.connectivity.itemsize}")  # a negative index becomes a large one
        if version in _in_order or not len(unsigned) or unsigned.max() < n_points:
            _remember(version)
            return np.empty(0, dtype=np.intp)
        bad = np.flatnonzero(unsigned >= n_points)
        return np.unique(np.searchsorted(self.offsets, bad, side="right") - 1)

    def refuse_out_of_range(self, n_points: int) -> None:
        """Raise ``ValueError`` if a point index is negative or not below `n_points`.

        The message names the first such index and its cell.
        """
        bad = self.out_of_range(n_points)
        if len(bad):
            corners = self.connectivity[self.offsets[bad[0]] : self.offsets[bad[0] + 1]]
            index = corners[(corners < 0) | (corners >= n_points)][0]
            what = "polyhedron faces" if self.label == "polyhedron" else "points"
            allowed = f"a mesh whose cells refer to its {n_points} {what}" + (f", 0 to {n_points - 1}" * (n_points > 0))
            remedy = (
                "The cells may come from a file or code that counts points differently, for example from 1; "
                "see pvphong.diagnose."
            )
            check.refuse("mesh", f"index {index} in {self.label} {bad[0]}", allowed, remedy)


def cells(mesh: pv.DataSet) -> list[Cells]:
    """Return the cell arrays of a mesh; an empty list for a dataset whose cells follow from its dimensions.

    Arrays of a PolyData are checked once after each modification that VTK knows of. Code that writes directly into an
    array's memory must call ``Modified()``, as for drawing. Arrays of a grid are checked at each call, because VTK
    reads them next, to extract the surface, and a wrong index would crash the process.

    Raises
    ------
    ValueError
        If an array's offsets exceed its connectivity.
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
    first = 0
    for label, array in arrays.items():
        result.append(_read(label, array, first, once=isinstance(mesh, pv.PolyData)))
        first += result[-1].count
    return result


def _read(label: str, array: Any, first: int = 0, *, once: bool = False) -> Cells:
    count = 0 if array is None else array.GetNumberOfCells()
    if not count:
        return Cells(label, first, 0, np.empty(0, dtype=np.int64), None, None)
    indices, offsets = array.GetConnectivityArray(), array.GetOffsetsArray()
    parts = (array, indices, offsets)
    version = (*(part.GetMTime() for part in parts), indices.GetNumberOfValues(), count) if once else None
    connectivity = vtk_to_numpy(indices)
    if connectivity.dtype.kind not in "iu":
        check.refuse("mesh", f"{label} indices of type {connectivity.dtype}", "a mesh with integer point indices")
    result = Cells(label, first, count, connectivity[: array.GetOffset(count)], version, array)
    if version in _in_order:
        return result
    start, end = array.GetOffset(0), array.GetOffset(count)
    # in chunks, because the offsets may be larger than memory
    stretches = (result.offsets[at : at + _AT_ONCE + 1] for at in range(0, count + 1, _AT_ONCE))
    rises = array.IsStorageFixedSize() or all((part[1:] >= part[:-1]).all() for part in stretches)
    if start != 0 or not 0 <= end <= len(connectivity) or not rises:
        allowed = f"a mesh whose {label} offsets rise from 0 to {len(connectivity)}, the length of their connectivity"
        check.refuse("mesh", f"offsets from {result.offsets.min()} to {result.offsets.max()}", allowed)
    _remember(version)
    return result


def _polyhedron_faces(mesh: pv.DataSet) -> tuple[Cells, Cells] | None:
    """Return the polyhedra of a mesh as two arrays: the faces, and the cells.

    The first array has the point indices of each face, the second the face indices of each cell. The result is None if
    the mesh has no polyhedra.
    """
    if not isinstance(mesh, pv.UnstructuredGrid) or mesh.GetPolyhedronFaces() is None:
        return None
    faces = _read("polyhedron face", mesh.GetPolyhedronFaces())
    return faces, _read("polyhedron", mesh.GetPolyhedronFaceLocations())


def _bad_types(mesh: pv.DataSet) -> list[tuple[IntArray, Callable[[int], str], str, str]]:
    """Find the cells that VTK cannot process because of their type, in groups by the kind of error.

    Return four items for each group: the cells' indices, and three items for an error message. These are a function
    that describes a cell by its index, the allowed values, and the remedy.
    """
    if not isinstance(mesh, pv.UnstructuredGrid) or mesh.n_cells == 0:
        return []
    types, sizes = mesh.celltypes, np.diff(cells(mesh)[0].offsets)
    least, is_known = np.zeros(256, dtype=np.int64), np.zeros(256, dtype=bool)
    for number in np.unique(types).tolist():
        cell = vtkGenericCell.InstantiateCell(number)
        is_known[number] = number == 0 or cell is not None
        least[number] = 0 if cell is None else cell.GetNumberOfPoints()
    return [
        (
            np.flatnonzero(sizes < least[types]),
            lambda cell: f"cell {cell} with {sizes[cell]} points, but its type needs {least[types[cell]]}",
            "a mesh whose cells have all their points",
            "",
        ),
        (
            np.flatnonzero(~is_known[types]),  # VTK would skip them
            lambda cell: f"cell {cell} of type {types[cell]}",
            "a mesh with cells of VTK's types",
            "",
        ),
        (
            np.flatnonzero(types == pv.CellType.CONVEX_POINT_SET),
            lambda cell: f"cell {cell}, a convex point set",
            "a mesh without convex point sets, because VTK crashes when it triangulates some of them",
            "Convert its points to tetrahedra with pv.PolyData(points).delaunay_3d().",
        ),
    ]


def invalid_cells(mesh: pv.DataSet) -> IntArray:
    """Return the indices of the cells that would crash VTK, in ascending order.

    Such a cell refers to a point that does not exist, has fewer points than its type needs, has a type that VTK does
    not know, or is a convex point set.
    """
    n_points = mesh.n_points
    found = [array.first + array.out_of_range(n_points) for array in cells(mesh)]
    found += [numbers for numbers, *_ in _bad_types(mesh)]
    polyhedra = _polyhedron_faces(mesh)
    if polyhedra is not None:
        faces, owners = polyhedra
        found.append(owners.out_of_range(faces.count))
        owned = np.isin(owners.connectivity, faces.out_of_range(n_points))
        found.append(np.searchsorted(owners.offsets, np.flatnonzero(owned), side="right") - 1)
    return np.unique(np.concatenate([np.zeros(0, np.int64), *found]))


def refuse_invalid(mesh: pv.DataSet) -> None:
    """Raise ``ValueError`` for a mesh that would crash VTK. The message names the invalid cell, dimensions or array."""
    n_points = mesh.n_points
    for array in cells(mesh):
        array.refuse_out_of_range(n_points)
    polyhedra = _polyhedron_faces(mesh)
    if polyhedra is not None:
        polyhedra[0].refuse_out_of_range(n_points)
        polyhedra[1].refuse_out_of_range(polyhedra[0].count)
    for numbers, phrase, allowed, remedy in _bad_types(mesh):
        if len(numbers):
            check.refuse("mesh", phrase(int(numbers[0])), allowed, remedy)
    refuse_wrong_sizes(mesh)


def refuse_wrong_sizes(mesh: pv.DataSet) -> None:
    """Raise ``ValueError`` if a grid's dimensions or an array's length do not fit the number of points or cells."""
    if isinstance(mesh, pv.StructuredGrid) and np.prod(mesh.dimensions) != mesh.n_points:
        got = f"{mesh.n_points} points in dimensions {tuple(mesh.dimensions)}"
        check.refuse("mesh", got, "a grid with as many points as the product of its dimensions")
    if isinstance(mesh, pv.RectilinearGrid):
        axes = (mesh.GetXCoordinates(), mesh.GetYCoordinates(), mesh.GetZCoordinates())
        counts = tuple(0 if axis is None else axis.GetNumberOfTuples() for axis in axes)
        if counts != tuple(mesh.dimensions):
            got = f"{counts} coordinates in dimensions {tuple(mesh.dimensions)}"
            check.refuse("mesh", got, "a grid with as many coordinates along each axis as its dimensions")
    for of, data, count in (("point", mesh.GetPointData(), mesh.n_points), ("cell", mesh.GetCellData(), mesh.n_cells)):
        for number in range(data.GetNumberOfArrays()):
            array = data.GetAbstractArray(number)
            if array.GetNumberOfTuples() != count:
                got = f"{of} array {array.GetName()!r} with {array.GetNumberOfTuples()} rows"
                check.refuse("mesh", got, f"a mesh whose {of} arrays have one row per {of}, {count} rows")
