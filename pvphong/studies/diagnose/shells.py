"""Closed parts of a surface that are inside out, by the sign of the volume that they enclose."""

from __future__ import annotations

import math

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.geometry.normals import Faces
from pvphong.studies.diagnose.checks import edges_of, finite_rows

_ROUNDING = 1e-9  # of the sum of a volume's terms, below which its sign is nobody's


def inside_out_faces(points: FloatArray, faces: Faces, first_in_place: IntArray) -> tuple[IntArray, bool]:
    """Faces of closed parts whose fronts look inwards, in rising order, and whether all parts are closed.

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
    first_in_place : ndarray
        (n,): for each point the lowest index of one in the same place.
    """
    finite, count = finite_rows(points), len(points)
    wide = points.astype(np.float64)
    # By a power of two the finite coordinates come to 1, so that their products stay in range.
    wide = np.ldexp(wide, -int(np.frexp(np.abs(wide[finite]).max(initial=0.0))[1]))
    begin, end, owner = edges_of(faces)
    begin, end = first_in_place[begin], first_in_place[end]
    real = begin != end
    begin, end, owner = begin[real], end[real], owner[real]
    parts = connected(count, begin, end)[begin]  # by the number of their first point
    part_of_face = np.full(faces.count, -1)
    part_of_face[owner] = parts

    # Open is a part with an edge that is run along more often in one direction than in the other; one that is not
    # finite, too.
    edges = np.minimum(begin, end) * count + np.maximum(begin, end)
    _, some, edge = np.unique(edges, return_index=True, return_inverse=True)
    balance = np.bincount(edge.ravel(), np.where(begin < end, 1.0, -1.0))
    open_parts = np.concatenate([parts[some[balance != 0]], parts[~finite[begin]]])
    closed = np.setdiff1d(np.unique(parts), open_parts)

    # A fan of triangles from each face's first corner, and the sums of the volumes to a point of the part.
    triangles, face = fan(faces)
    part = part_of_face[face]
    triangles, part = triangles[part >= 0], part[part >= 0]
    with np.errstate(all="ignore"):
        p, q, r = (wide[triangles] - wide[part][:, None]).transpose(1, 0, 2)
        each = np.einsum("ij,ij->i", p, np.cross(q, r)) / 6.0
    volumes, terms = np.bincount(part, each, count), np.bincount(part, np.abs(each), count)
    certain = closed[np.abs(volumes[closed]) > _ROUNDING * terms[closed]]
    turned, outward = certain[volumes[certain] < 0.0], certain[volumes[certain] > 0.0]

    def is_cavity(inner: int) -> bool:
        """Whether a part lies within others: how often they go round a point of it, by the sum of solid angles."""
        own, turns = wide[triangles[part == inner]], 0.0
        for outer in outward:
            around = wide[triangles[part == outer]]
            if (around.min(axis=(0, 1)) <= own.min(axis=(0, 1))).all() and (
                around.max(axis=(0, 1)) >= own.max(axis=(0, 1))
            ).all():
                turns += solid_angle(around - wide[inner]) / (4.0 * math.pi)
        return turns > 0.5

    wrong = [inner for inner in turned.tolist() if not is_cavity(inner)]
    return np.flatnonzero(np.isin(part_of_face, wrong)), len(closed) > 0 and not len(open_parts)


def connected(count: int, begin: IntArray, end: IntArray) -> IntArray:
    """For each of so many points the lowest that edges connect it with."""
    labels = np.arange(count)
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


def fan(faces: Faces) -> tuple[IntArray, IntArray]:
    """Each face as triangles from its first corner: their points (m, 3), and the numbers of their faces (m,)."""
    owner = np.repeat(np.arange(faces.count), faces.sizes)
    place = np.arange(len(owner)) - faces.offsets[owner]  # of a corner in its face
    second = np.flatnonzero((place >= 1) & (place < faces.sizes[owner] - 1))
    face, corners = owner[second], faces.connectivity
    return np.stack([corners[faces.offsets[face]], corners[second], corners[second + 1]], axis=1), face


def solid_angle(triangles: Float64Array) -> float:
    """The solid angle of triangles (m, 3 corners, 3) as the origin sees them, positive where it sees their backs.

    Source: van Oosterom & Strackee, The Solid Angle of a Plane Triangle, IEEE Trans. Biomed. Eng. 30 (1983).
    """
    a, b, c = triangles.transpose(1, 0, 2)
    la, lb, lc = np.linalg.norm(triangles, axis=2).T
    above = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc
    for one, other, third in ((a, b, lc), (a, c, lb), (b, c, la)):
        below = below + np.einsum("ij,ij->i", one, other) * third
    return 2.0 * float(np.arctan2(above, below).sum())
