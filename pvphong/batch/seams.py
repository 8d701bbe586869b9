"""Normals across the pieces of one surface: each piece gets its neighbours' faces around the points that it shares.

Points of several pieces are the same where all their coordinates are. What a piece hands on are its faces with a corner
on its border; what it gets are the others' faces with a corner on one of its own border points. With these added, its
own points have all their faces, and normals and sharp edges come out as on the surface in one piece. Where the cells
of a volume are shared out, the faces that two pieces have in common point against each other and cancel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base.types import BoolArray, FloatArray, IntArray
from pvphong.meshes.cells import cells
from pvphong.meshes.surfaces import FeatureAngle, polygons, split_sharp_edges, vertex_normals

_GHOST = "vtkGhostType"
_FOREIGN = "_pvphong_foreign"
_NORMALS = "_pvphong_normals"


@dataclass(frozen=True)
class Border:
    """The faces of a piece that touch its border.

    Attributes
    ----------
    points : ndarray
        Shape (m, 3): of their corners, in the type that the piece has.
    numbers : ndarray
        Shape (m,): which of the piece's points each is.
    is_border : ndarray
        Shape (m,): whether it is on the border.
    connectivity, offsets : ndarray
        The faces, by places in `points`.
    count : int
        How many points the piece has.
    """

    points: FloatArray
    numbers: IntArray
    is_border: BoolArray
    connectivity: IntArray
    offsets: IntArray
    count: int


@dataclass(frozen=True)
class Neighbours:
    """Faces of other pieces around the border points of one.

    Attributes
    ----------
    points : ndarray
        Shape (m, 3): those corners that are none of the piece's border points.
    connectivity, offsets : ndarray
        The faces: by the piece's own numbers, and after these by places in `points`.
    """

    points: FloatArray
    connectivity: IntArray
    offsets: IntArray


def without_ghosts(surface: pv.PolyData) -> pv.PolyData:
    """A surface without the cells that it has only to know its neighbours, and without the points of those alone."""
    ghosts = surface.cell_data.get(_GHOST)
    if ghosts is None or not np.any(ghosts):
        return surface
    kept = _with_cells(surface, np.asarray(ghosts) == 0)
    for data in (kept.cell_data, kept.point_data):
        if _GHOST in data:
            del data[_GHOST]
    return kept


def border_of(surface: pv.PolyData, *, of_volume: bool = False) -> Border:
    """The faces of a surface that touch an edge which only one of them has; all of it if it is a volume's.

    A volume's surface is closed: what it shares with its neighbours may be anywhere on it.
    """
    connectivity, offsets = polygons(surface)
    sizes = np.diff(offsets)
    after = np.arange(1, len(connectivity) + 1)
    after[offsets[1:][sizes > 0] - 1] = offsets[:-1][sizes > 0]
    on_border = np.full(surface.n_points, of_volume)
    if not of_volume:
        low, high = np.sort([connectivity, connectivity[after]], axis=0)
        edges, uses = np.unique(low * surface.n_points + high, return_counts=True)
        on_border[np.concatenate(np.divmod(edges[uses == 1], surface.n_points))] = True
    face = np.repeat(np.arange(len(sizes)), sizes)
    touches = np.zeros(len(sizes), bool)
    touches[face[on_border[connectivity]]] = True
    numbers, corners = np.unique(connectivity[touches[face]], return_inverse=True)
    return Border(
        np.asarray(surface.points)[numbers],
        numbers,
        on_border[numbers],
        corners.astype(np.intp),
        _starts(sizes[touches]),
        surface.n_points,
    )


def neighbours_of(borders: Sequence[Border]) -> list[Neighbours]:
    """For each piece the others' faces around its border points."""
    together = _Together(borders)
    return [together.around(number) for number in range(len(borders))]


class _Together:
    """The faces along all borders, and at which place each corner is; places count from 0."""

    def __init__(self, borders: Sequence[Border]) -> None:
        self._borders = borders
        self._points = np.concatenate([border.points.astype(np.float64) for border in borders])
        places = np.unique(self._points + 0.0, axis=0, return_inverse=True)[1]  # -0 and 0 are one place
        self._place = places.reshape(-1)
        self._first = _starts([len(border.points) for border in borders])
        shifted = [border.connectivity + first for border, first in zip(borders, self._first, strict=False)]
        self._corners = np.concatenate(shifted)
        self._sizes = np.concatenate([np.diff(border.offsets) for border in borders])
        self._starts = _starts(self._sizes)
        self._piece = np.repeat(np.arange(len(borders)), [len(border.offsets) - 1 for border in borders])
        places = self._place[self._corners]
        order = np.argsort(places, kind="stable")
        self._sorted_places = places[order]
        self._sorted_faces = np.repeat(np.arange(len(self._sizes)), self._sizes)[order]

    def around(self, number: int) -> Neighbours:
        """Other pieces' faces with a corner on the border of this one."""
        border = self._borders[number]
        places = self._place[self._first[number] : self._first[number + 1]][border.is_border]
        low, high = (np.searchsorted(self._sorted_places, places, side=side) for side in ("left", "right"))
        near = np.unique(self._sorted_faces[_ranges(low, high)])
        near = near[self._piece[near] != number]
        corners = self._corners[_ranges(self._starts[near], self._starts[near + 1])]
        return self._numbered(border, places, corners, self._sizes[near])

    def _numbered(self, border: Border, own: IntArray, corners: IntArray, sizes: IntArray) -> Neighbours:
        """Foreign faces, by the numbers that their corners have on the piece; `own` are places of its border points."""
        order = np.argsort(own, kind="stable")  # of several points at one place the first counts
        places, some, inverse = np.unique(self._place[corners], return_index=True, return_inverse=True)
        at = np.searchsorted(own, places, sorter=order).clip(max=len(own) - 1)
        found = order[at]
        is_own = own[found] == places
        numbers = np.where(is_own, border.numbers[border.is_border][found], 0)
        numbers[~is_own] = border.count + np.arange(np.count_nonzero(~is_own))
        others = self._points[corners[some[~is_own]]].astype(border.points.dtype)
        return Neighbours(others, numbers[inverse], _starts(sizes))


def with_normals(
    surface: pv.PolyData, neighbours: Neighbours, feature_angle: FeatureAngle
) -> tuple[pv.PolyData, FloatArray]:
    """The surface, split along its sharp edges, and the normals of its points on the surface in one piece."""
    split, _ = split_sharp_edges(_joined(surface, neighbours), feature_angle)
    split.point_data[_NORMALS] = vertex_normals(split)
    own = _with_cells(split, np.asarray(split.cell_data[_FOREIGN]) == 0)
    del own.cell_data[_FOREIGN]
    return own, np.asarray(own.point_data.pop(_NORMALS))


def _joined(surface: pv.PolyData, neighbours: Neighbours) -> pv.PolyData:
    """A surface with foreign faces, which are marked, behind its own polygons."""
    added, extra = len(neighbours.offsets) - 1, len(neighbours.points)
    polys = cells(surface)[2]
    joined = pv.PolyData()
    joined.points = np.concatenate([surface.points, neighbours.points])
    joined.SetVerts(surface.GetVerts())
    joined.SetLines(surface.GetLines())
    joined.SetPolys(
        pv.CellArray.from_arrays(
            np.concatenate([polys.offsets, polys.offsets[-1] + neighbours.offsets[1:]]),
            np.concatenate([polys.connectivity, neighbours.connectivity]),
        )
    )
    joined.SetStrips(surface.GetStrips())
    for name, array in surface.point_data.items():
        joined.point_data[name] = np.concatenate([array, np.zeros((extra, *array.shape[1:]), array.dtype)])
    behind = polys.first + polys.count
    for name, array in surface.cell_data.items():
        between = np.zeros((added, *array.shape[1:]), array.dtype)
        joined.cell_data[name] = np.concatenate([array[:behind], between, array[behind:]])
    joined.field_data.update(surface.field_data)
    foreign = np.zeros(surface.n_cells + added, np.uint8)
    foreign[behind : behind + added] = 1
    joined.cell_data[_FOREIGN] = foreign
    joined.point_data.active_normals_name = surface.point_data.active_normals_name
    return joined


def _with_cells(mesh: pv.PolyData, kept: BoolArray) -> pv.PolyData:
    """Some of a mesh's cells, with their points, and with those points that no cell has."""
    arrays = cells(mesh)
    parts = [(array, kept[array.first : array.first + array.count]) for array in arrays]
    used, wanted = np.zeros(mesh.n_points, bool), np.zeros(mesh.n_points, bool)
    found: list[tuple[Any, Any]] = []
    for array, keep in parts:
        sizes = np.diff(array.offsets)
        mine = array.connectivity[np.repeat(keep, sizes)]
        used[array.connectivity] = True
        wanted[mine] = True
        found.append((mine, _starts(sizes[keep])))
    points = np.flatnonzero(wanted | ~used)
    number = np.zeros(mesh.n_points, np.int64)
    number[points] = np.arange(len(points))
    result = pv.PolyData()
    result.points = np.asarray(mesh.points)[points]
    setters = (result.SetVerts, result.SetLines, result.SetPolys, result.SetStrips)
    for put, (connectivity, offsets) in zip(setters, found, strict=True):
        put(pv.CellArray.from_arrays(offsets, number[connectivity]))
    for name, array in mesh.point_data.items():
        result.point_data[name] = np.asarray(array)[points]
    for name, array in mesh.cell_data.items():
        result.cell_data[name] = np.asarray(array)[kept]
    result.field_data.update(mesh.field_data)
    result.point_data.active_normals_name = mesh.point_data.active_normals_name
    return result


def _starts(sizes: Any) -> NDArray[np.intp]:
    """Where each of some runs begins, and the end."""
    return np.concatenate([[0], np.cumsum(np.asarray(sizes, np.intp))]).astype(np.intp)


def _ranges(low: IntArray, high: IntArray) -> IntArray:
    """The integers of all ranges from low to high, one range after the other."""
    sizes = high - low
    before = np.repeat(low - _starts(sizes)[:-1], sizes)
    return before + np.arange(len(before))
