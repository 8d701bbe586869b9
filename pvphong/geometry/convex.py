"""Whether a mesh bounds a convex body."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import BoolArray, Float64Array, FloatArray

# Angles in radians by which faces may be bent the wrong way: the rounding of coordinates bends flat ones by as much.
_BENT = 1e-5
# Faces against which points are tried first: where the body is not convex, hardly any is in front of no point.
_TRIED, _POINTS_TRIED = 16, 4096


def is_convex(points: FloatArray, normals: FloatArray, triangles: NDArray[np.int64]) -> bool:
    """Whether triangles are the whole surface of a convex body, and normals point out of it.

    Rays that begin at a point, on that side of it to which its normal points, then leave the body.

    Source: K. Mehlhorn et al., "Checking geometric programs or verification of geometric structures" (1999): a closed
    surface that is convex at each edge bounds a convex body if a point is behind all faces, and a ray from there meets
    one face only.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3). Points that stand in one place are taken as one.
    triangles : ndarray
        Shape (m, 3), the points at their corners, counter-clockwise as seen from outside.
    """
    if len(triangles) < 4 or not np.isfinite(points).all():
        return False
    p = np.asarray(points, np.float64) - np.mean(points, axis=0, dtype=np.float64)
    size = np.abs(p).max()
    if not 0.0 < size < np.inf:
        return False
    p /= size
    corners = p[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.sqrt((across**2).sum(axis=1))
    if not length.all():
        return False
    across /= length[:, None]
    levels = (across * corners[:, 0]).sum(axis=1)
    if not (levels > 0.0).all() or not _few_are_in_front(p, across, levels):
        return False
    return (
        bool((_out_of_body(corners, normals[triangles])).all())
        and _is_convex_at_edges(p, triangles, across)
        and _meets_one(corners, across, levels)
    )


def _few_are_in_front(p: Float64Array, across: Float64Array, levels: Float64Array) -> bool:
    faces = slice(None, None, max(len(across) // _TRIED, 1))
    some = p[:: max(len(p) // _POINTS_TRIED, 1)]
    return bool((some @ across[faces].T - levels[faces] <= _BENT).all())


def _out_of_body(corners: Float64Array, normals: FloatArray) -> BoolArray:
    """Whether at each corner the edges of the face fall off from the tangent plane."""
    with np.errstate(invalid="ignore"):
        n = normals / np.sqrt((normals.astype(np.float64) ** 2).sum(axis=2, keepdims=True))
    good = np.ones(len(corners), bool)
    for k in range(3):
        for other in (corners[:, k - 1], corners[:, k - 2]):
            edges = other - corners[:, k]
            rise = (n[:, k] * edges).sum(axis=1)
            good &= rise <= _BENT * np.sqrt((edges**2).sum(axis=1))  # a normal that is none is NaN here
    return good


def _is_convex_at_edges(p: Float64Array, triangles: NDArray[np.int64], across: Float64Array) -> bool:
    """Whether each edge has two faces, in opposite orders, and neither rises above the other."""
    rows = np.ascontiguousarray(p + 0.0).view(np.dtype((np.void, 3 * p.itemsize))).ravel()  # sorted at once; no -0.0
    _, first, merged = np.unique(rows, return_index=True, return_inverse=True)
    places, corners = p[first], merged.ravel()[triangles]
    begins, ends = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    apexes, faces = np.roll(corners, -2, axis=1).ravel(), np.repeat(np.arange(len(corners)), 3)
    forth, back = begins * len(places) + ends, ends * len(places) + begins
    order, other = np.argsort(forth), np.argsort(back)
    one, two = forth[order], back[other]
    if (one[1:] == one[:-1]).any() or (one != two).any():
        return False
    to_apex = places[apexes[other]] - places[begins[order]]
    rise = (across[faces[order]] * to_apex).sum(axis=1)
    return bool((rise <= _BENT * np.sqrt((to_apex**2).sum(axis=1))).all())


def _meets_one(corners: Float64Array, across: Float64Array, levels: Float64Array) -> bool:
    """Whether a ray from the middle through that of a face meets no other."""
    way = corners[0].mean(axis=0)
    along = across @ way
    with np.errstate(divide="ignore", invalid="ignore"):
        met = np.where(along > 0.0, levels / along, 0.0)[:, None] * way
    inside = along > 0.0
    for k in range(3):
        edges = corners[:, k - 2] - corners[:, k]
        inside &= (np.cross(edges, met - corners[:, k]) * across).sum(axis=1) >= 0.0
    return int(np.count_nonzero(inside)) == 1
