"""Bounds of a mesh, and a test for convexity. The bounds are a box and a sphere around vertices, and a cone around
normals.

To simplify the lighting equation, plans use these bounds before they examine single vertices.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base import threads
from pvphong.base.formulas import subtract
from pvphong.base.types import Float64Array, FloatArray, Vector, VectorLike
from pvphong.geometry.transform import MatrixClass, class_of, transform_normals, transform_points

# Factor by which bounds are rounded up; they are computed in float64.
ROUNDED_UP = 1.0 + 1e-9
# Largest error in radians of a direction in float64.
TURN_SLACK = 1e-7
# Number of rows that a thread reduces at once, which fit its caches; number of rows that are joined into one long row.
_CHUNK, _FOLD = 2**17, 512
# Number of normals that are tested first.
_SOME = 64


Box = tuple[Float64Array, Float64Array]
"""Smallest and largest coordinates, shape (3,) each."""


class Sphere(NamedTuple):
    """A sphere around vertices, in world coordinates."""

    center: Vector
    radius: float


class BoundingCone(NamedTuple):
    """Cone that contains the directions from all points of a sphere to a target, and the target's distance."""

    direction: Vector
    """Axis of the cone: unit vector from the sphere's centre to the target."""

    distance: float
    """Distance from the sphere's centre to the target."""

    radius: float
    """Radius of the sphere."""

    turn: float
    """Half-angle of the cone in radians: the largest angle between its axis and a direction to the target."""


@dataclass(frozen=True, eq=False)
class MeshBounds:
    """Bounds of all vertices, in world coordinates; computed at the first use.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3).
    normals : callable or None
        Function that returns the normals, shape (n, 3); None if they are unknown.
    matrix : ndarray or None
        Model matrix, shape (4, 4); None for the identity.
    """

    points: FloatArray
    normals: Callable[[], FloatArray] | None
    matrix: Float64Array | None

    @cached_property
    def box(self) -> Box | None:
        """Smallest and largest world coordinates, shape (3,) each; None without points, or if a point is not finite.

        With a matrix, the result is the box around the transformed corners of the points' box, as VTK computes the
        bounds of an actor.
        """
        if not len(self.points):
            return None
        low, high = box_of(self.points)
        if self.matrix is not None:
            corners = transform_points(corners_of(low, high), self.matrix)
            low, high = corners.min(axis=0), corners.max(axis=0)
        return (low, high) if np.isfinite([low, high]).all() else None

    @cached_property
    def sphere(self) -> Sphere | None:
        """Sphere around all vertices; None without points, or if a point is not finite."""
        found = None if self.box is None else sphere_around(self.box)
        return None if found is None or math.isinf(found.radius) else found

    def sight(self, target: VectorLike) -> BoundingCone | None:
        """Return a cone that contains the directions from all vertices to the point `target`.

        The result is None if the sphere around the vertices is unknown, or if the target is at the sphere's centre or
        infinitely far away.
        """
        sphere = self.sphere
        if sphere is None:
            return None
        x, y, z = subtract(target, sphere.center)
        distance, radius = math.hypot(x, y, z), sphere.radius
        if not 0.0 < distance < math.inf:
            return None
        turn = math.pi if distance <= radius else math.asin(min(radius / distance, 1.0)) * ROUNDED_UP
        return BoundingCone((x / distance, y / distance, z / distance), distance, radius, turn)

    @cached_property
    def normal_cone(self) -> tuple[Vector, float] | None:
        """Cone that contains all normals, as unit axis and half-angle in radians; None if no such cone is known."""
        if self.normals is None or not len(self.points):
            return None
        kind = MatrixClass.TRANSLATION if self.matrix is None else class_of(self.matrix)
        if kind is MatrixClass.GENERAL:
            return None
        normals = self.normals()
        some = normals[:: max(len(normals) // _SOME, 1)]  # if no cone contains these normals, none contains all
        stored = None if _cone(*box_of(some)) is None else _cone(*box_of(normals))
        if stored is None or self.matrix is None or kind.keeps_normals:
            return stored
        axis, angle = stored
        x, y, z = transform_normals([axis], self.matrix)[0].tolist()
        return (x, y, z), angle


ANYWHERE = MeshBounds(np.zeros((0, 3)), None, None)
"""Bounds of unknown vertices."""


def _cone(low: Float64Array, high: Float64Array) -> tuple[Vector, float] | None:
    """Return the unit axis and the half-angle of a cone around all vectors in the box from `low` to `high`.

    Only the box's corners are examined: for a vector n, n·axis is smallest at a corner, and |n| is largest at a corner.
    The result is None if the half-angle would be 90° or more, or a bound is not finite.
    """
    largest = max(np.abs(low).max(), np.abs(high).max())
    if not 0.0 < largest < math.inf:
        return None
    low, high = (np.ldexp(bound, -np.frexp(largest)[1]) for bound in (low, high))  # squares must not overflow
    corners = corners_of(low, high)
    axis = (low + high) / 2
    length, longest = math.hypot(*axis), float(np.sqrt((corners**2).sum(axis=1)).max())
    if length == 0.0:
        return None
    x, y, z = (axis / length).tolist()
    cosine = float((corners @ (axis / length)).min()) / longest
    return ((x, y, z), math.acos(min(cosine, 1.0)) + TURN_SLACK) if cosine > 0.0 else None


def corners_of(low: Float64Array, high: Float64Array) -> Float64Array:
    """Return the eight corners of the box from `low` to `high`, shape (8, 3)."""
    return np.array(list(itertools.product(*zip(low.tolist(), high.tolist(), strict=True))))


def sphere_around(box: Box) -> Sphere:
    """Return the least sphere around a box, with its radius rounded up. The radius is infinite if it overflows."""
    low, high = (end.tolist() for end in box)
    x, y, z = centre = [a / 2 + b / 2 for a, b in zip(low, high, strict=True)]
    reach = (max(b - c, c - a) for a, b, c in zip(low, high, centre, strict=True))
    return Sphere((x, y, z), math.hypot(*reach) * ROUNDED_UP)


def box_of(rows: FloatArray) -> Box:
    """Return the smallest and the largest entry of each column of an (n, 3) array, n > 0: two arrays of shape (3,).

    For a column that contains a NaN, both are NaN.
    """
    lows: list[FloatArray] = []
    highs: list[FloatArray] = []

    def look(first: int, last: int) -> None:  # NumPy reduces long rows many times faster than triples
        folded = rows[first:last].reshape(-1, 3 * _FOLD)
        lows.append(folded.min(axis=0))
        highs.append(folded.max(axis=0))

    whole = len(rows) // _FOLD * _FOLD
    if whole:
        threads.run(look, whole, _CHUNK)
    folds = [np.min(lows, axis=0).reshape(-1, 3), np.max(highs, axis=0).reshape(-1, 3)] if whole else []
    few = np.concatenate([*folds, rows[whole:]]).T.astype(np.float64, order="C")
    return few.min(axis=1), few.max(axis=1)


# --- convex


# Largest angle in radians by which neighbouring faces may be concave: rounding of coordinates may bend flat surfaces by
# this angle.
_BENT = 1e-5
# Number of faces and of points that are tested first: if the body is not convex, nearly every face has points in front
# of it.
_TRIED, _POINTS_TRIED = 16, 4096


def is_convex(points: FloatArray, normals: FloatArray, triangles: NDArray[np.int64]) -> bool:
    """Return True if triangles are the whole surface of a convex body, and normals point outwards.

    If the result is True, a ray that starts at a point, on the side to which the point's normal points, does not hit
    the body.

    A closed surface that is convex at each edge bounds a convex body, if some point is behind all faces and a ray from
    this point hits only one face. Source: K. Mehlhorn et al., "Checking geometric programs or verification of geometric
    structures" (1999).

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3). Points with equal coordinates are merged.
    triangles : ndarray
        Shape (m, 3), indices of the corners, counter-clockwise as seen from outside.
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
    length = np.linalg.norm(across, axis=1)
    if not length.all():
        return False
    across /= length[:, None]
    levels = (across * corners[:, 0]).sum(axis=1)
    some, faces = p[:: max(len(p) // _POINTS_TRIED, 1)], slice(None, None, max(len(across) // _TRIED, 1))
    if not (levels > 0.0).all() or not (some @ across[faces].T - levels[faces] <= _BENT).all():
        return False
    with np.errstate(invalid="ignore"):
        n = normals[triangles] / np.linalg.norm(normals[triangles].astype(np.float64), axis=2, keepdims=True)
    if not ((n * across[:, None]).sum(axis=2) > 0.0).all():  # inward, zero or not finite
        return False
    for k in range(3):  # at each corner, the edges of the face must lie below the tangent plane
        for neighbour in (corners[:, k - 1], corners[:, k - 2]):
            edges = neighbour - corners[:, k]
            rise = (n[:, k] * edges).sum(axis=1)
            if not (rise <= _BENT * np.linalg.norm(edges, axis=1)).all():
                return False
    # each edge must have two faces, which run along it in opposite orders, and neither may rise above the other
    rows = np.ascontiguousarray(p + 0.0).view(np.dtype((np.void, 3 * p.itemsize))).ravel()  # sorts whole rows; no -0.0
    _, first, merged = np.unique(rows, return_index=True, return_inverse=True)
    places, indices = p[first], merged.ravel()[triangles]
    begins, ends = indices.ravel(), np.roll(indices, -1, axis=1).ravel()
    apexes, owners = np.roll(indices, -2, axis=1).ravel(), np.repeat(np.arange(len(triangles)), 3)
    forth, back = begins * len(places) + ends, ends * len(places) + begins
    order, other = np.argsort(forth), np.argsort(back)
    one, two = forth[order], back[other]
    if (one[1:] == one[:-1]).any() or (one != two).any():
        return False
    to_apex = places[apexes[other]] - places[begins[order]]
    rise = (across[owners[order]] * to_apex).sum(axis=1)
    if not (rise <= _BENT * np.linalg.norm(to_apex, axis=1)).all():
        return False
    # a ray from the centre through the centre of a face must hit no other face
    ray = corners[0].mean(axis=0)
    along = across @ ray
    with np.errstate(divide="ignore", invalid="ignore"):
        met = np.where(along > 0.0, levels / along, 0.0)[:, None] * ray
    inside = along > 0.0
    for k in range(3):
        edges = corners[:, k - 2] - corners[:, k]
        inside &= (np.cross(edges, met - corners[:, k]) * across).sum(axis=1) >= 0.0
    return int(np.count_nonzero(inside)) == 1
