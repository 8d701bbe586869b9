"""Normals across the pieces of one surface: each piece gets its neighbours' faces around shared points.

Points of several pieces are the same if all their coordinates are equal. A piece sends the faces that have a corner on
its border. It receives those faces of other pieces that have a corner at one of its border points. With these, all
faces around its points are known, and normals and sharp edges are those of the whole surface. If the pieces are parts
of a volume, a face between two pieces occurs twice; its two normals are opposite and cancel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base.types import BoolArray, FloatArray, IntArray
from pvphong.batch.culling import Outline, outline_of
from pvphong.meshes.cells import cells
from pvphong.meshes.surfaces import FeatureAngle, polygons, split_sharp_edges, vertex_normals

NORMALS = "_pvphong_normals"
"""Name of the point normals that `with_normals` adds to a piece."""

_GHOST = "vtkGhostType"
_FOREIGN = "_pvphong_foreign"


@dataclass(frozen=True)
class Border:
    """Faces of a piece that touch its border, and the outline of the piece.

    Attributes
    ----------
    points : ndarray
        Corners of the faces, shape (m, 3), in the piece's float type.
    numbers : ndarray
        Indices of these corners in the piece, shape (m,).
    is_border : ndarray
        True for corners on the border, shape (m,).
    connectivity, offsets : ndarray
        The faces; their corners are rows of `points`.
    outline : Outline
        Outline of the whole piece.
    """

    points: FloatArray
    numbers: IntArray
    is_border: BoolArray
    connectivity: IntArray
    offsets: IntArray
    outline: Outline


@dataclass(frozen=True)
class Neighbours:
    """Faces of other pieces around the border points of a piece.

    Attributes
    ----------
    points : ndarray
        Corners that are not border points of the piece, shape (m, 3).
    connectivity, offsets : ndarray
        The faces. With n points in the piece, an index i < n is a point of the piece; any other is row i − n of
        `points`.
    """

    points: FloatArray
    connectivity: IntArray
    offsets: IntArray


def border_of(surface: pv.PolyData, *, of_volume: bool = False) -> Border:
    """Return the outline of a piece, and the faces of its surface that may share points with other pieces.

    These faces have a point on the surface's boundary edges. `of_volume` must be True if the surface encloses a volume.
    It is then closed, and all faces are returned, because any of them may be shared.
    """
    connectivity, offsets = polygons(surface)
    sizes = np.diff(offsets)
    on_border = np.full(surface.n_points, of_volume)
    if not of_volume:
        following = np.arange(1, len(connectivity) + 1)  # the next corner of the same face
        following[offsets[1:][sizes > 0] - 1] = offsets[:-1][sizes > 0]
        low, high = np.sort([connectivity, connectivity[following]], axis=0)
        edges, uses = np.unique(low * surface.n_points + high, return_counts=True)
        on_border[np.concatenate(np.divmod(edges[uses == 1], surface.n_points))] = True
    face = np.repeat(np.arange(len(sizes)), sizes)
    touches = np.zeros(len(sizes), bool)
    touches[face[on_border[connectivity]]] = True
    numbers, corners = np.unique(connectivity[touches[face]], return_inverse=True)
    points = np.asarray(surface.points)[numbers]
    return Border(points, numbers, on_border[numbers], corners, _offsets(sizes[touches]), outline_of(surface))


def neighbours_of(border: Border, others: Sequence[Border]) -> Neighbours:
    """Return the faces of other pieces that have a corner at a border point of a piece.

    `border` is the border of the piece, and `others` are the borders of the other pieces.
    """
    # the faces of all borders, one piece after the other. `corners` has the row of each corner among all points, and
    # `place` a number for each point, which is the same for points with equal coordinates
    borders = [border, *others]
    points = np.concatenate([each.points.astype(np.float64) for each in borders])
    place = np.unique(points, axis=0, return_inverse=True)[1].reshape(-1)
    own, rows = np.unique(place[: len(border.points)][border.is_border], return_index=True)
    first = _offsets([len(each.points) for each in borders])
    corners = np.concatenate([each.connectivity + row for each, row in zip(borders, first, strict=False)])
    sizes = np.concatenate([np.diff(each.offsets) for each in borders])
    offsets = _offsets(sizes)
    is_near = np.zeros(len(sizes), bool)
    is_near[np.repeat(np.arange(len(sizes)), sizes)[np.isin(place[corners], own)]] = True
    is_near[: len(border.offsets) - 1] = False
    near = np.flatnonzero(is_near)
    around = corners[_ranges(offsets[near], offsets[near + 1])]
    # replace a corner by the piece's border point with equal coordinates, the first if there are several
    found, some, inverse = np.unique(place[around], return_index=True, return_inverse=True)
    at = np.searchsorted(own, found).clip(max=len(own) - 1)
    is_own = own[at] == found
    numbers = np.empty(len(found), np.intp)
    numbers[is_own] = border.numbers[border.is_border][rows[at[is_own]]]
    numbers[~is_own] = border.outline.count + np.arange(np.count_nonzero(~is_own))
    strangers = points[around[some[~is_own]]].astype(border.points.dtype)
    return Neighbours(strangers, numbers[inverse], _offsets(sizes[near]))


def with_normals(surface: pv.PolyData, neighbours: Neighbours, feature_angle: FeatureAngle) -> pv.PolyData:
    """Return a piece's surface with the point normals that it has as a part of the whole surface.

    Parameters
    ----------
    surface : pyvista.PolyData
        Surface of the piece.
    neighbours : Neighbours
        Faces of other pieces around the piece's border points.
    feature_angle : float, "auto" or None
        The surface is split along edges that are sharper than this angle, as by `split_sharp_edges`.
    """
    added, extra = len(neighbours.offsets) - 1, len(neighbours.points)
    polys = cells(surface)[2]
    end = polys.first + polys.count
    joined = pv.PolyData()
    joined.points = np.concatenate([surface.points, neighbours.points])
    joined.SetVerts(surface.GetVerts())
    joined.SetLines(surface.GetLines())
    offsets = np.concatenate([polys.offsets, polys.offsets[-1] + neighbours.offsets[1:]])
    joined.SetPolys(pv.CellArray.from_arrays(offsets, np.concatenate([polys.connectivity, neighbours.connectivity])))
    joined.SetStrips(surface.GetStrips())
    for name, array in surface.point_data.items():
        joined.point_data[name] = np.concatenate([array, np.zeros((extra, *array.shape[1:]), array.dtype)])
    for name, array in surface.cell_data.items():
        zeros = np.zeros((added, *array.shape[1:]), array.dtype)
        joined.cell_data[name] = np.concatenate([array[:end], zeros, array[end:]])
    joined.cell_data[_FOREIGN] = np.repeat(np.array([0, 1, 0], np.uint8), [end, added, surface.n_cells - end])
    joined.field_data.update(surface.field_data)
    joined.point_data.active_normals_name = surface.point_data.active_normals_name
    split, _ = split_sharp_edges(joined, feature_angle)
    split.point_data[NORMALS] = vertex_normals(split)
    own = _with_cells(split, np.asarray(split.cell_data[_FOREIGN]) == 0)
    del own.cell_data[_FOREIGN]
    own.point_data.active_normals_name = NORMALS
    return own


def has_only_ghosts(mesh: pv.DataSet) -> bool:
    """Return True if a mesh has cells, and all of them are marked as ghost cells."""
    ghosts = mesh.cell_data.get(_GHOST)
    return ghosts is not None and mesh.n_cells > 0 and bool(np.all(ghosts))


def without_ghosts(surface: pv.PolyData) -> pv.PolyData:
    """Return a surface without its ghost cells, and without points that only ghost cells use."""
    ghosts = surface.cell_data.get(_GHOST)
    if ghosts is None or not np.any(ghosts):
        return surface
    kept = _with_cells(surface, np.asarray(ghosts) == 0)
    for data in (kept.cell_data, kept.point_data):
        if _GHOST in data:
            del data[_GHOST]
    return kept


def _with_cells(mesh: pv.PolyData, kept: BoolArray) -> pv.PolyData:
    """Return a mesh with only those cells for which the mask `kept` is True.

    Points that only removed cells used are removed too. Points that no cell used stay.
    """
    has_cell, is_kept = np.zeros(mesh.n_points, bool), np.zeros(mesh.n_points, bool)
    found: list[tuple[Any, Any]] = []
    for array in cells(mesh):
        keep, sizes = kept[array.first : array.first + array.count], np.diff(array.offsets)
        connectivity = array.connectivity[np.repeat(keep, sizes)]
        has_cell[array.connectivity] = True
        is_kept[connectivity] = True
        found.append((_offsets(sizes[keep]), connectivity))
    is_kept |= ~has_cell
    number = np.cumsum(is_kept) - 1
    result = pv.PolyData()
    result.points = np.asarray(mesh.points)[is_kept]
    setters = (result.SetVerts, result.SetLines, result.SetPolys, result.SetStrips)
    for put, (offsets, connectivity) in zip(setters, found, strict=True):
        put(pv.CellArray.from_arrays(offsets, number[connectivity]))
    # PyVista raises for arrays without rows
    for name, array in mesh.point_data.items() if is_kept.any() else ():
        result.point_data[name] = np.asarray(array)[is_kept]
    for name, array in mesh.cell_data.items() if kept.any() else ():
        result.cell_data[name] = np.asarray(array)[kept]
    result.field_data.update(mesh.field_data)
    if is_kept.any():
        result.point_data.active_normals_name = mesh.point_data.active_normals_name
    return result


def _offsets(sizes: Any) -> NDArray[np.intp]:
    """Return the start of each of several consecutive runs, followed by the end of the last run.

    `sizes` has the number of items in each run.
    """
    return np.concatenate([[0], np.cumsum(np.asarray(sizes, np.intp))]).astype(np.intp)


def _ranges(low: IntArray, high: IntArray) -> IntArray:
    """Return the integers low[i], …, high[i] − 1 for each i, concatenated."""
    sizes = high - low
    before = np.repeat(low - _offsets(sizes)[:-1], sizes)
    return before + np.arange(len(before))
