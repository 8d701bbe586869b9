"""Splitting triangles until interpolated colours hold: the rounds, on plain arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.geometry.transform import normalize
from pvphong.shading.inside.interpolation import dense_errors, first_errors, jumps, more_errors
from pvphong.shading.inside.lit_vertices import Lighting, LitVertices, sizes
from pvphong.shading.inside.splitting import Triangles

Stopped = Literal["tolerance", "max_points", "jump", "resolution"]

# Parts of the tolerance: a triangle with an error above the first is split, one with an error above the second is
# sampled densely. Between samples errors were found to be larger by up to 5 % (dense) and 30 % (others).
_AIM, _CLOSE = 0.95, 0.7

# A round splits the triangles that are at least this urgent, against the most urgent.
_URGENT = 0.25

# A triangle in which the colour jumps is not split below this part of the mesh's diagonal: a pixel of a picture.
_PIXEL = 2.0**-10

# The least height of a triangle that is split, in steps of its coordinates' precision.
_LEAST_HEIGHT = 16.0


# What is known of each triangle.
_KNOWN = np.dtype(
    [
        ("error", np.float64),  # the largest at the samples so far; 0 in a triangle that has no area
        ("longest", np.float64),  # longest side
        ("visible", np.bool_),  # whether it has an area
        ("finished", np.bool_),  # whether all samples have been taken
        ("stuck", np.bool_),  # whether no splitting would help
        ("jump", np.bool_),  # because the colour jumps in it
    ]
)


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
    vertices : LitVertices
        As they are now; the given ones first.
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
        self.vertices = LitVertices(p, n, n, shades, lighting.colors(p, n, shades))
        self.triangles = Triangles(corners, len(p), _side_lengths(p[corners]))
        self.parents: list[IntArray] = []
        self._lighting, self._smooth, self._real = lighting, smooth, points.dtype
        finite = p[np.isfinite(p).all(axis=1)]
        self._diagonal = float(np.linalg.norm(np.ptp(finite, axis=0))) if len(finite) else 0.0
        self._known = np.zeros(0, dtype=_KNOWN)
        self._measure(np.arange(len(corners)))

    @property
    def errors(self) -> Float64Array:
        """(m,): each triangle's largest error at the samples so far; 0 in a triangle without an area."""
        result: Float64Array = self._known["error"]
        return result

    def run(self, tolerance: float, limit: int) -> Stopped:
        """Split until every error is within `tolerance` or nothing can be done, with at most `limit` points.

        It ends, because every round adds a point.
        """
        while True:
            rows = self._to_split(tolerance)
            if not len(rows):
                break
            marks = self._marks(rows)
            if self.triangles.n_vertices + np.count_nonzero(marks) > limit:
                self._spend_what_is_left(tolerance, limit)
                break
            self._split(marks)
        left = self.errors > tolerance
        if not left.any():
            return "tolerance"
        if (left & ~self._known["stuck"]).any():
            return "max_points"
        return "jump" if self._known["jump"][left].any() else "resolution"

    def _finish(self, tolerance: float) -> None:
        """Take the samples that have not been taken yet; more of them where it is a close thing."""
        rows = np.flatnonzero(~self._known["finished"])
        self._sample(rows, more_errors)
        errors = self.errors[rows]
        self._sample(rows[(errors > _CLOSE * tolerance) & (errors <= _AIM * tolerance)], dense_errors)
        self._known["finished"][rows] = True

    def _sample(self, rows: IntArray, errors_of: Callable[[LitVertices, IntArray, Lighting], Float64Array]) -> None:
        errors = errors_of(self.vertices, self.triangles.corners[rows], self._lighting)
        self.errors[rows] = np.maximum(self.errors[rows], errors)

    def _to_split(self, tolerance: float) -> IntArray:
        """The triangles of the next round; none if all that may be split are good."""
        while True:
            rows = self._poor(tolerance)
            if not len(rows):
                if self._known["finished"].all():
                    return rows
                self._finish(tolerance)
                continue
            urgency = self._urgency(rows)
            rows = rows[urgency >= _URGENT * urgency.max()]
            self._look_for_jumps(rows[self._known["longest"][rows] < _PIXEL * self._diagonal], tolerance)
            rows = rows[~self._known["stuck"][rows]]
            if len(rows):
                return rows

    def _poor(self, tolerance: float) -> IntArray:
        return np.flatnonzero((self.errors > _AIM * tolerance) & ~self._known["stuck"])

    def _urgency(self, rows: IntArray) -> Float64Array:
        """Error times length: of two equal errors the larger shows more."""
        return self.errors[rows] * self._known["longest"][rows]

    def _look_for_jumps(self, rows: IntArray, tolerance: float) -> None:
        """Triangles in which the colour jumps are stuck, and those that meet them: around a vertex without a normal
        the colours are as varied at every size.
        """
        corners = self.triangles.corners
        found = jumps(self.vertices, corners[rows], self._lighting)
        self.errors[rows] = np.maximum(self.errors[rows], found.errors)
        self._known["jump"][rows] = found.sizes > tolerance
        at_jumps = np.zeros(self.triangles.n_vertices, dtype=bool)
        at_jumps[corners[self._known["jump"]]] = True
        self._known["stuck"][rows] |= at_jumps[corners[rows]].any(axis=1)

    def _spend_what_is_left(self, tolerance: float, limit: int) -> None:
        """Split as many of the most urgent triangles as the limit allows."""
        rows = self._poor(tolerance)
        rows = rows[np.argsort(-self._urgency(rows), kind="stable")]
        fits, too_many = 0, len(rows) + 1
        while too_many - fits > 1:
            middle = (fits + too_many) // 2
            spent = np.count_nonzero(self._marks(rows[:middle]))
            fits, too_many = (middle, too_many) if self.triangles.n_vertices + spent <= limit else (fits, middle)
        if fits:
            self._split(self._marks(rows[:fits]))
        self._finish(tolerance)
        self._look_for_jumps(self._poor(tolerance), tolerance)

    def _marks(self, rows: IntArray) -> BoolArray:
        return self.triangles.marks(rows, self._known["visible"])

    def _split(self, marks: BoolArray) -> None:
        curved = self.triangles.have_two_triangles(marks) & self._smooth
        parents, rows = self.triangles.cut(marks)
        self._add_vertices(parents, curved)
        self._measure(rows)

    def _add_vertices(self, parents: IntArray, curved: BoolArray) -> None:
        old, (a, b) = self.vertices, parents.T
        points = 0.5 * old.points[a] + 0.5 * old.points[b]
        points[curved] += _bulge(old.points, old.normals, parents[curved])
        points = points.astype(self._real).astype(np.float64)
        normals = 0.5 * old.normals[a] + 0.5 * old.normals[b]
        stored = normalize(normals) * _mean_lengths(old.stored[a], old.stored[b])
        normals = stored if self._smooth else normals
        shades = None if old.shades is None else 0.5 * old.shades[a] + 0.5 * old.shades[b]
        colors = self._lighting.colors(points, normals, shades)
        self.vertices = old.followed_by(LitVertices(points, normals, stored, shades, colors))
        self.parents.append(parents)

    def _measure(self, rows: IntArray) -> None:
        """Take the first samples of triangles that are new or changed."""
        corners = self.triangles.corners[rows]
        points = self.vertices.points[corners]
        longest, height = sizes(points)
        step = np.abs(points).max(axis=(1, 2), initial=0.0) * float(np.finfo(self._real).eps)
        visible = height > 0.0
        added = len(self.triangles) - len(self._known)
        self._known = np.concatenate([self._known, np.zeros(added, dtype=_KNOWN)])
        self._known[rows] = 0
        self._known["longest"][rows] = longest
        self._known["stuck"][rows] = ~(height > _LEAST_HEIGHT * step)
        self._known["visible"][rows] = visible
        self._known["finished"][rows] = ~visible
        self.errors[rows[visible]] = first_errors(self.vertices, corners[visible], self._lighting)


def _side_lengths(points: Float64Array) -> Float64Array:
    with np.errstate(invalid="ignore", over="ignore"):
        return np.linalg.norm(np.roll(points, -1, axis=1) - points, axis=2)


def _mean_lengths(normals: Float64Array, others: Float64Array) -> Float64Array:
    """(k, 1) mean lengths of two normals each, so that between unit normals there are unit normals."""
    lengths = np.stack([np.linalg.norm(normals, axis=1), np.linalg.norm(others, axis=1)])
    return np.where(lengths.min(axis=0) > 0.0, lengths.mean(axis=0), lengths.max(axis=0))[:, None]


def _bulge(points: Float64Array, normals: Float64Array, ends: IntArray) -> Float64Array:
    """From the middles of sides (k, 2) to the middles of cubic curves that meet the ends' normals at right angles.

    The curves are the sides of PN triangles: A. Vlachos, J. Peters, C. Boyd, J. L. Mitchell: Curved PN triangles.
    Symposium on Interactive 3D Graphics (2001), 159-166. On a circle they err in the fourth power of the angle.
    """
    p, q = points[ends].transpose(1, 0, 2)
    n, m = (normalize(normals[end]) for end in ends.T)
    along = q - p
    rise, fall = (np.einsum("ki,ki->k", along, normal)[:, None] for normal in (n, m))
    return (fall * m - rise * n) / 8.0
