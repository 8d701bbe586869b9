"""Closed parts of a surface that are inside out, by the sign of the volume that they enclose."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.geometry.normals import Faces
from pvphong.studies.diagnose.checks import finite_rows

_ROUNDING = 1e-9  # of the sum of a volume's terms, below which its sign is nobody's


def inside_out_faces(points: FloatArray, faces: Faces) -> IntArray:
    """Faces of closed parts whose fronts look inwards, in rising order.

    A part is what hangs together by edges, where points in one place count as one. It is closed if each of its edges
    is run along as often in one direction as in the other; then 1/6 of the sum of all p · (q × r) over its triangles
    is its volume, wherever the origin lies (Gauss's theorem), and it is negative where the fronts look inwards. A part
    that lies within another whose fronts look outwards is the wall of a cavity, and right.

    Parameters
    ----------
    points : ndarray
        (n, 3).
    faces : Faces
        All with indices of points.
    """
    welded = _welded(points)
    points = _scaled(points)
    begin, end, owner = _edges(faces, welded)
    parts = _parts(len(points), begin, end)[begin]
    part_of_face = np.full(faces.count, -1)
    part_of_face[owner] = parts
    closed = np.setdiff1d(np.unique(parts), _open_parts(begin, end, parts, points))
    volumes, terms = _volumes(points, faces, part_of_face)
    turned = [part for part in closed if volumes[part] < -_ROUNDING * terms[part]]
    outward = [part for part in closed if volumes[part] > _ROUNDING * terms[part]]
    wrong = [part for part in turned if not _within(points, faces, part_of_face, part, outward)]
    return np.flatnonzero(np.isin(part_of_face, wrong))


def _welded(points: FloatArray) -> IntArray:
    """For each point the first that lies in the same place."""
    order = np.lexsort(points.T)
    is_new = np.ones(len(points), dtype=bool)
    is_new[1:] = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    welded = np.empty(len(points), dtype=np.intp)
    welded[order] = order[is_new][np.cumsum(is_new) - 1]
    return welded


def _scaled(points: FloatArray) -> Float64Array:
    """By a power of two that brings the finite coordinates to 1, so that their products stay in range."""
    wide = points.astype(np.float64)
    largest = np.abs(wide[finite_rows(points)]).max(initial=0.0)
    return np.ldexp(wide, -int(np.frexp(largest)[1]))


def _edges(faces: Faces, welded: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Where each edge of each face begins and ends, and whose it is; edges without a length are left out."""
    begin = welded[faces.connectivity]
    end = np.empty_like(begin)
    end[:-1] = begin[1:]
    sizes = np.diff(faces.offsets)
    some = sizes > 0
    end[faces.offsets[1:][some] - 1] = begin[faces.offsets[:-1][some]]
    owner = np.repeat(np.arange(faces.count), sizes)
    real = begin != end
    return begin[real], end[real], owner[real]


def _parts(n_points: int, begin: IntArray, end: IntArray) -> IntArray:
    """For each point the lowest that it is connected with."""
    labels = np.arange(n_points)
    while True:
        lowest = np.minimum(labels[begin], labels[end])
        lower = labels.copy()
        np.minimum.at(lower, labels[begin], lowest)
        np.minimum.at(lower, labels[end], lowest)
        while not np.array_equal(further := lower[lower], lower):
            lower = further
        if np.array_equal(lower, labels):
            return labels
        labels = lower


def _open_parts(begin: IntArray, end: IntArray, parts: IntArray, points: Float64Array) -> IntArray:
    """Parts with an edge that is run along more often in one direction than in the other, or that are not finite."""
    edges = np.minimum(begin, end).astype(np.int64) * len(points) + np.maximum(begin, end)
    _, first, edge = np.unique(edges, return_index=True, return_inverse=True)
    balance = np.bincount(edge.ravel(), np.where(begin < end, 1.0, -1.0))
    return np.concatenate([parts[first[balance != 0]], parts[~finite_rows(points)[begin]]])


def _volumes(points: Float64Array, faces: Faces, parts: IntArray) -> tuple[Float64Array, Float64Array]:
    """The volume of each part, by its number, and the sum of its terms' sizes; about a point of its own."""
    sizes = np.diff(faces.offsets)
    count = len(points)
    volumes, terms = np.zeros(count), np.zeros(count)
    with np.errstate(all="ignore"):
        for size in np.unique(sizes[sizes >= 3]).tolist():
            rows = np.flatnonzero((sizes == size) & (parts >= 0))
            corners = faces.connectivity[faces.offsets[rows][:, None] + np.arange(size)]
            origin = points[parts[rows]]
            p = points[corners[:, 0]] - origin
            q = points[corners[:, 1]] - origin
            for corner in range(2, size):
                r = points[corners[:, corner]] - origin
                each = np.einsum("ij,ij->i", p, np.cross(q, r)) / 6.0
                volumes += np.bincount(parts[rows], each, count)
                terms += np.bincount(parts[rows], np.abs(each), count)
                q = r
    return volumes, terms


def _within(points: Float64Array, faces: Faces, parts: IntArray, part: int, others: list[int]) -> bool:
    """Whether a part lies within others: how often they go round a point of it, by the sum of solid angles."""
    low, high = _bounds(points, faces, parts, part)
    turns = 0.0
    for other in others:
        least, greatest = _bounds(points, faces, parts, other)
        if (least <= low).all() and (greatest >= high).all():
            turns += _solid_angle(points, faces, parts == other, part) / (4.0 * math.pi)
    return turns > 0.5


def _bounds(points: Float64Array, faces: Faces, parts: IntArray, part: int) -> tuple[Float64Array, Float64Array]:
    corners = points[faces.connectivity[np.repeat(parts == part, np.diff(faces.offsets))]]
    return corners.min(axis=0), corners.max(axis=0)


def _solid_angle(points: Float64Array, faces: Faces, chosen: NDArray[np.bool_], at: int) -> float:
    """Of some faces as a point sees them (van Oosterom & Strackee, The Solid Angle of a Plane Triangle, 1983)."""
    sizes = np.diff(faces.offsets)
    total = 0.0
    for size in np.unique(sizes[chosen & (sizes >= 3)]).tolist():
        rows = np.flatnonzero(chosen & (sizes == size))
        corners = points[faces.connectivity[faces.offsets[rows][:, None] + np.arange(size)]] - points[at]
        lengths = np.sqrt(np.einsum("ijk,ijk->ij", corners, corners))
        a, la = corners[:, 0], lengths[:, 0]
        for corner in range(2, size):
            b, c, lb, lc = corners[:, corner - 1], corners[:, corner], lengths[:, corner - 1], lengths[:, corner]
            above = np.einsum("ij,ij->i", a, np.cross(b, c))
            below = la * lb * lc
            for one, other, third in ((a, b, lc), (a, c, lb), (b, c, la)):
                below = below + np.einsum("ij,ij->i", one, other) * third
            total += 2.0 * float(np.arctan2(above, below).sum())
    return total
