"""Where the vertices are and where their normals point, as far as effects ask; and how far off a target is seen."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, Vector, VectorLike
from pvphong.geometry.matrix_class import MatrixClass, class_of
from pvphong.geometry.transform import transform_normals, transform_points

# Bounds are computed in float64 and rounded up by this factor.
ROUNDED_UP = 1.0 + 1e-9
# Rows that are searched for extremes at once, and that are laid side by side for it.
_CHUNK, _FOLD = 2**20, 512
# Normals that are looked at first.
_SOME = 64


Search = Callable[[FloatArray], tuple[Float64Array, Float64Array] | None]


class Sphere(NamedTuple):
    """A sphere around vertices, in world coordinates."""

    center: Vector
    radius: float


class Sight(NamedTuple):
    """How a target is seen from the vertices' sphere."""

    direction: Vector
    """Unit vector from the centre."""

    distance: float
    """From the centre."""

    radius: float
    """Of the sphere."""

    turn: float
    """The largest angle in radians between the directions to the target from the centre and from the sphere."""


class Extent:
    """A sphere around all vertices, in world coordinates; computed when an effect first asks.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3).
    normals : callable or None
        Gives them, shape (n, 3), where they are known.
    matrix : ndarray or None
        (4, 4) model matrix.
    search : callable, optional
        Finds the least and the greatest entry of each column faster than NumPy does, or gives None.
    """

    def __init__(
        self,
        points: FloatArray,
        normals: Callable[[], FloatArray] | None,
        matrix: Float64Array | None,
        search: Search | None = None,
    ) -> None:
        self._points = points
        self._normals = normals
        self._matrix = matrix
        self._search = search
        self._sights: dict[Vector, Sight | None] = {}

    @cached_property
    def box(self) -> tuple[Float64Array, Float64Array] | None:
        """Least and greatest coordinates in the world; None where there is no point, or one is not finite.

        With a matrix it is the box around the transformed box, as VTK has an actor's bounds.
        """
        if not len(self._points):
            return None
        low, high = self._box(self._points)
        if self._matrix is not None:
            corners = transform_points(_corners(low, high), self._matrix)
            low, high = corners.min(axis=0), corners.max(axis=0)
        return (low, high) if np.isfinite([low, high]).all() else None

    @cached_property
    def sphere(self) -> Sphere | None:
        """Around all vertices; None where there is no point, or one is not finite."""
        if self.box is None:
            return None
        low, high = self.box
        x, y, z = centre = [a / 2 + b / 2 for a, b in zip(low.tolist(), high.tolist(), strict=True)]
        reach = (max(b - c, c - a) for a, b, c in zip(low.tolist(), high.tolist(), centre, strict=True))
        radius = math.hypot(*reach) * ROUNDED_UP
        return Sphere((x, y, z), radius) if math.isfinite(radius) else None

    def sight(self, target: VectorLike) -> Sight | None:
        """Of a target; None where nothing is known of the vertices, or it is in the middle of them."""
        x, y, z = target
        place = x, y, z
        if place not in self._sights:
            self._sights[place] = None if self.sphere is None else _sight(place, self.sphere)
        return self._sights[place]

    @cached_property
    def normal_cone(self) -> tuple[Vector, float] | None:
        """A unit axis, and an angle in radians within which all normals lie from it; None if unknown."""
        if self._normals is None or not len(self._points):
            return None
        kind = MatrixClass.TRANSLATION if self._matrix is None else class_of(self._matrix)
        if kind is MatrixClass.GENERAL:
            return None
        normals = self._normals()
        some = normals[:: max(len(normals) // _SOME, 1)]  # where these have no cone, all hardly have one
        stored = None if _cone(*_box(some)) is None else _cone(*self._box(normals))
        if stored is None or self._matrix is None or kind.keeps_normals:
            return stored
        axis, angle = stored
        x, y, z = transform_normals([axis], self._matrix)[0].tolist()
        return (x, y, z), angle

    def _box(self, rows: FloatArray) -> tuple[Float64Array, Float64Array]:
        return (self._search and self._search(rows)) or _box(rows)


ANYWHERE = Extent(np.zeros((0, 3)), None, None)
"""Of vertices of which nothing is known."""


def _sight(target: Vector, sphere: Sphere) -> Sight | None:
    (x, y, z), (cx, cy, cz), radius = target, *sphere
    x, y, z = x - cx, y - cy, z - cz
    distance = math.hypot(x, y, z)
    if not 0.0 < distance < math.inf:
        return None
    turn = math.pi if distance <= radius else math.asin(min(radius / distance, 1.0)) * ROUNDED_UP
    return Sight((x / distance, y / distance, z / distance), distance, radius, turn)


def _cone(low: Float64Array, high: Float64Array) -> tuple[Vector, float] | None:
    """Of normals between two: n·axis is least, and |n| greatest, at one of the corners."""
    largest = max(np.abs(low).max(), np.abs(high).max())
    if not 0.0 < largest < math.inf:
        return None
    low, high = (np.ldexp(bound, -np.frexp(largest)[1]) for bound in (low, high))  # so that squares can be taken
    corners = _corners(low, high)
    axis = (low + high) / 2
    length, longest = math.hypot(*axis), float(np.sqrt((corners**2).sum(axis=1)).max())
    if length == 0.0:
        return None
    x, y, z = (axis / length).tolist()
    cosine = float((corners @ (axis / length)).min()) / longest
    return ((x, y, z), math.acos(min(cosine, 1.0)) + 1e-7) if cosine > 0.0 else None


def _corners(low: Float64Array, high: Float64Array) -> Float64Array:
    """Of the box between two, shape (8, 3)."""
    return np.array(list(itertools.product(*zip(low.tolist(), high.tolist(), strict=True))))


def _box(rows: FloatArray) -> tuple[Float64Array, Float64Array]:
    """Least and greatest entry of each column; NaN where any is."""
    extremes = np.concatenate([_extremes(rows[start : start + _CHUNK]) for start in range(0, len(rows), _CHUNK)])
    return extremes.min(axis=0), extremes.max(axis=0)


def _extremes(rows: FloatArray) -> Float64Array:
    """A few rows with the same least and greatest entries. NumPy reduces long rows many times as fast as triples."""
    whole = len(rows) // _FOLD * _FOLD
    folded = rows[:whole].reshape(-1, 3 * _FOLD)
    parts = [rows[whole:]]
    if whole:
        parts += [folded.min(axis=0).reshape(_FOLD, 3), folded.max(axis=0).reshape(_FOLD, 3)]
    return np.concatenate(parts).astype(np.float64)
