"""Splitting triangles until interpolated colours hold: the rounds, on plain arrays."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from pvphong._interpolation import Lighting, Vertices, first_errors, jumps, more_errors
from pvphong._splitting import Triangles
from pvphong._types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.transform import normalize

Stopped = Literal["tolerance", "max_points", "jump", "resolution"]

# Between the samples, errors are up to 3 % larger than at them.
_AIM = 0.95

# A round splits the triangles that are at least this urgent, against the most urgent.
_URGENT = 0.25

# A triangle in which the colour jumps is not split below this part of the mesh's diagonal: a pixel of a picture.
_PIXEL = 2.0**-10

# The least height of a triangle that is split, in steps of its coordinates' precision.
_LEAST_HEIGHT = 16.0


class Refinement:
    """Triangles that are split, round by round, where they need it.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3), float32 or float64; new points are rounded to the same type.
    normals : ndarray
        Shape (n, 3), of any length.
    shades : ndarray or None
        Shape (n, 3), albedo in [0, 1].
    corners : ndarray of int
        Shape (m, 3).
    lighting : Lighting
        The scene, the material and the model matrix.
    smooth : bool
        Whether new vertices are put on a smooth surface, or stay in the triangle.

    Attributes
    ----------
    triangles : Triangles
        As they are now.
    vertices : Vertices
        As they are now; the given ones first.
    errors : ndarray
        Shape (m,): each triangle's largest error at the samples so far; 0 in a triangle without an area.
    parents : list of ndarray
        For each round (k, 2), the vertices that its new ones lie between.
    """

    def __init__(
        self,
        points: FloatArray,
        normals: FloatArray,
        shades: Float64Array | None,
        corners: IntArray,
        lighting: Lighting,
        smooth: bool = False,
    ) -> None:
        p, n = points.astype(np.float64), normals.astype(np.float64)
        self.vertices = Vertices(p, n, n, shades, lighting.colors(p, n, shades))
        self.triangles = Triangles(corners, len(p), _side_lengths(p[corners]))
        self.parents: list[IntArray] = []
        self._lighting, self._smooth, self._real = lighting, smooth, points.dtype
        finite = p[np.isfinite(p).all(axis=1)]
        self._pixel = _PIXEL * float(np.linalg.norm(np.ptp(finite, axis=0))) if len(finite) else 0.0
        self._add_rows(len(corners))
        self._measure(np.arange(len(corners)))

    def run(self, tolerance: float, limit: int) -> Stopped:
        """Split until every error is within `tolerance` or nothing can be done, with at most `limit` points.

        It ends, because every round adds a point.
        """
        while True:
            rows = self._to_split(tolerance)
            if not len(rows):
                break
            marks = self.triangles.marks(rows)
            if self.triangles.n_vertices + np.count_nonzero(marks) > limit:
                self._spend_what_is_left(tolerance, limit)
                break
            self._split(marks)
        left = self.errors > tolerance
        if not left.any():
            return "tolerance"
        if (left & ~self._stuck).any():
            return "max_points"
        return "jump" if self._jump[left].any() else "resolution"

    def finish(self) -> None:
        """Take the samples that have not been taken yet."""
        rows = np.flatnonzero(~self._finished)
        more = more_errors(self.vertices, self.triangles.corners[rows], self._lighting)
        self.errors[rows] = np.maximum(self.errors[rows], more)
        self._finished[rows] = True

    def _to_split(self, tolerance: float) -> IntArray:
        """The triangles of the next round; none if all that may be split are good."""
        while True:
            rows = self._poor(tolerance)
            if not len(rows):
                if self._finished.all():
                    return rows
                self.finish()
                continue
            urgency = self._urgency(rows)
            rows = rows[urgency >= _URGENT * urgency.max()]
            self._look_for_jumps(rows[self._longest[rows] < self._pixel], tolerance)
            rows = rows[~self._stuck[rows]]
            if len(rows):
                return rows

    def _poor(self, tolerance: float) -> IntArray:
        return np.flatnonzero((self.errors > _AIM * tolerance) & ~self._stuck)

    def _urgency(self, rows: IntArray) -> Float64Array:
        """Error times length: of two equal errors the larger shows more."""
        return self.errors[rows] * self._longest[rows]

    def _look_for_jumps(self, rows: IntArray, tolerance: float) -> None:
        found = jumps(self.vertices, self.triangles.corners[rows], self._lighting)
        self.errors[rows] = np.maximum(self.errors[rows], found.errors)
        self._jump[rows] = found.sizes > tolerance
        self._stuck[rows] |= self._jump[rows]

    def _spend_what_is_left(self, tolerance: float, limit: int) -> None:
        """Split as many of the most urgent triangles as the limit allows."""
        rows = self._poor(tolerance)
        rows = rows[np.argsort(-self._urgency(rows), kind="stable")]
        fits, too_many = 0, len(rows) + 1
        while too_many - fits > 1:
            middle = (fits + too_many) // 2
            spent = np.count_nonzero(self.triangles.marks(rows[:middle]))
            fits, too_many = (middle, too_many) if self.triangles.n_vertices + spent <= limit else (fits, middle)
        if fits:
            self._split(self.triangles.marks(rows[:fits]))
        self.finish()
        self._look_for_jumps(self._poor(tolerance), tolerance)

    def _split(self, marks: BoolArray) -> None:
        inner = self.triangles.are_shared_by_two(marks) if self._smooth else np.empty(0, dtype=bool)
        count = len(self.triangles)
        parents, rows = self.triangles.cut(marks)
        self._add_vertices(parents, inner)
        self._add_rows(len(self.triangles) - count)
        self._measure(rows)

    def _add_vertices(self, parents: IntArray, inner: BoolArray) -> None:
        a, b = parents.T
        old = self.vertices
        points = old.points[a] + (old.points[b] - old.points[a]) / 2.0
        normals = (old.normals[a] + old.normals[b]) / 2.0
        stored = normalize(normals)
        if self._smooth:
            normals = stored
            points[inner] += _bulge(old.points, old.normals, parents[inner])
        points = points.astype(self._real).astype(np.float64)
        shades = None if old.shades is None else (old.shades[a] + old.shades[b]) / 2.0
        self.vertices = Vertices(
            points=np.concatenate([old.points, points]),
            normals=np.concatenate([old.normals, normals]),
            stored=np.concatenate([old.stored, stored]),
            shades=None if old.shades is None or shades is None else np.concatenate([old.shades, shades]),
            colors=np.concatenate([old.colors, self._lighting.colors(points, normals, shades)]),
        )
        self.parents.append(parents)

    def _add_rows(self, count: int) -> None:
        """Room for what is known of each triangle; `_measure` fills it."""
