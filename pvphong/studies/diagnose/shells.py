"""Closed parts of a surface that are inside out, by the sign of their enclosed volume."""

from __future__ import annotations

import math

import numpy as np

from pvphong.base import threads
from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.base.vectors import columns, cross, dot
from pvphong.geometry.normals import Faces
from pvphong.studies.diagnose.checks import Edges, edges_of, finite_rows, owners_of

_AT_ONCE = 2**13  # triangles that a thread processes at once; they fit its caches
_ROUNDING = 1e-9  # volumes below this fraction of the sum of their terms' magnitudes have no certain sign


def inside_out_faces(
    points: FloatArray, faces: Faces, first_in_place: IntArray, edges: Edges | None
) -> tuple[IntArray, bool]:
    """Find the closed parts of a surface whose fronts point inwards.

    A part is a set of faces that edges connect; coincident points count as one. A part is closed if faces run along
    each of its edges equally often in both directions. The volume of a closed part is 1/6 of the sum of p · (q × r)
    over its triangles (p, q, r), for any origin (Gauss's theorem). The volume is negative if the fronts point inwards.
    An inward part inside an outward one is the wall of a cavity, and has the right orientation.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3).
    faces : Faces
        All faces with valid indices.
    first_in_place : ndarray
        Shape (n,): for each point the lowest index of a coincident point.
    edges : Edges, optional
        Edges of all faces, if no points coincide.

    Returns
    -------
    faces : ndarray
        Faces of the inward parts that are no cavities, in ascending order.
    all_closed : bool
        True if there are parts, and all of them are closed.
    """
    finite, count = finite_rows(points), len(points)
    if edges is None:
        begin, end = edges_of(faces)
        edges = Edges.between(first_in_place[begin], first_in_place[end], count)
    parts = connected(count, edges.lower, edges.higher)  # the number of a part is its first point
    part_of_face = _parts_of(faces, first_in_place, parts)

    # A part is open if faces run along an edge more often in one direction, or if a point is not finite.
    is_part, is_open, has_edge = np.zeros((3, count), dtype=bool)
    has_edge[edges.lower] = True
    is_part[parts[has_edge]] = True
    is_open[parts[edges.lower[edges.forth != edges.back]]] = True
    is_open[parts[first_in_place[~finite]]] = True
    closed = np.flatnonzero(is_part & ~is_open)
    all_closed = len(closed) > 0 and not (is_part & is_open).any()
    if not len(closed):
        return closed, all_closed

    # Split faces into fans of triangles, and sum their signed volumes relative to a point of the part.
    triangles, face = fan(faces)
    part = part_of_face[face]
    if (is_folded := part < 0).any():
        triangles, part = triangles[~is_folded], part[~is_folded]
    # Scale the finite coordinates to about 1 by a power of two, so that their products do not overflow.
    wide = points.astype(np.float64)
    wide = np.ldexp(wide, -int(np.frexp(np.abs(wide[finite]).max(initial=0.0))[1]))
    each = np.empty(len(part))

    def add(first: int, last: int) -> None:
        with np.errstate(all="ignore"):
            to = np.take(wide, part[first:last], axis=0)
            p, q, r = (columns(np.take(wide, corner, axis=0) - to) for corner in triangles[first:last].T)
            each[first:last] = dot(p, cross(q, r)) / 6.0

    threads.run(add, len(part), _AT_ONCE)
    volumes, terms = np.bincount(part, each, count), np.bincount(part, np.abs(each), count)
    certain = closed[np.abs(volumes[closed]) > _ROUNDING * terms[closed]]
    turned, outward = certain[volumes[certain] < 0.0], certain[volumes[certain] > 0.0]

    def is_cavity(inner: int) -> bool:
        """Return True if an inward part is the wall of a cavity: one of its points is inside the outward parts.

        A point is inside if the winding number of the outward parts around it is positive. The winding number is the
        sum of the solid angles of their triangles, seen from the point, divided by 4π. `inner` is the number of the
        part, which is also the index of its first point.
        """
        own, turns = wide[triangles[part == inner]], 0.0
        for outer in outward:
            around = wide[triangles[part == outer]]
            if (around.min(axis=(0, 1)) <= own.min(axis=(0, 1))).all() and (
                around.max(axis=(0, 1)) >= own.max(axis=(0, 1))
            ).all():
                turns += solid_angle(around - wide[inner]) / (4.0 * math.pi)
        return turns > 0.5

    wrong = [inner for inner in turned.tolist() if not is_cavity(inner)]
    return np.flatnonzero(np.isin(part_of_face, wrong)) if wrong else np.empty(0, np.intp), all_closed


def _parts_of(faces: Faces, first_in_place: IntArray, parts: IntArray) -> IntArray:
    """Return the number of the part to which each face belongs, shape (n_faces,); −1 if all corners of a face coincide.

    Parameters
    ----------
    faces : Faces
        The faces.
    first_in_place : ndarray
        Shape (n,): for each point the lowest index of a coincident point.
    parts : ndarray
        Shape (n,): for each point the number of its part.
    """
    if faces.are_triangles:
        found = np.empty(faces.count, np.intp)

        def look(first: int, last: int) -> None:
            a, b, c = np.take(first_in_place, faces.connectivity[3 * first : 3 * last].reshape(-1, 3)).T
            found[first:last] = np.where((a == b) & (b == c), -1, np.take(parts, a))

        threads.run(look, faces.count, _AT_ONCE)
        return found
    begin, end = edges_of(faces)
    begin, end = first_in_place[begin], first_in_place[end]
    found, is_edge = np.full(faces.count, -1), begin != end
    found[owners_of(faces)[is_edge]] = parts[begin[is_edge]]
    return found


def connected(count: int, begin: IntArray, end: IntArray) -> IntArray:
    """Return, for each of `count` points, the lowest index of a point that a chain of edges connects with it.

    Edge i connects the points begin[i] and end[i]. In each round, every part is joined to the lowest part to which an
    edge connects it. Only edges between different parts are kept (Y. Shiloach and U. Vishkin, "An O(log n) parallel
    connectivity algorithm", 1982).
    """
    labels = np.arange(count)
    while len(begin):
        np.minimum.at(labels, np.maximum(begin, end), np.minimum(begin, end))
        while not np.array_equal(further := labels[labels], labels):
            labels = further
        begin, end = labels[begin], labels[end]
        apart = begin != end
        begin, end = begin[apart], end[apart]
    return labels


def fan(faces: Faces) -> tuple[IntArray, IntArray]:
    """Split faces into triangles that share the face's first corner.

    Return the points of the triangles, shape (m, 3), and the indices of their faces, shape (m,).
    """
    if faces.are_triangles:
        return faces.connectivity.reshape(-1, 3), np.arange(faces.count)
    owner = np.repeat(np.arange(faces.count), faces.sizes)
    place = np.arange(len(owner)) - faces.offsets[owner]  # position of the corner in its face
    second = np.flatnonzero((place >= 1) & (place < faces.sizes[owner] - 1))
    face, corners = owner[second], faces.connectivity
    return np.stack([corners[faces.offsets[face]], corners[second], corners[second + 1]], axis=1), face


def solid_angle(triangles: Float64Array) -> float:
    """Return the sum of the solid angles of triangles, seen from the origin.

    `triangles` has the corners, shape (m, 3 corners, 3). A triangle's solid angle is positive if the origin sees its
    back. Source: van Oosterom & Strackee, The Solid Angle of a Plane Triangle, IEEE Trans. Biomed. Eng. 30 (1983).
    """
    a, b, c = triangles.transpose(1, 0, 2)
    la, lb, lc = np.linalg.norm(triangles, axis=2).T
    above = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc
    for one, other, third in ((a, b, lc), (a, c, lb), (b, c, la)):
        below = below + np.einsum("ij,ij->i", one, other) * third
    return 2.0 * float(np.arctan2(above, below).sum())
