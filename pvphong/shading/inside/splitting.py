"""Splitting triangles until interpolated colours hold: conforming bisection, and the rounds in which it is applied.

A triangle is always cut through the middle of its longest side, and a side that is cut is cut for all triangles
that share it, so that no vertex ever lies inside another triangle's side. This is longest-edge bisection
(M.-C. Rivara: Algorithms for refining triangular grids suitable for adaptive and multigrid techniques.
International Journal for Numerical Methods in Engineering 20 (1984), 745-756).

"Longest" is measured as if every triangle had come with equal sides. Its descendants are then, up to that affine
map, of three shapes only, with no angle below 30°: cutting keeps the shape that a triangle came with. A long thin
triangle is cut along both of its directions, as uniform subdivision would, and never into ever thinner ones.
"""

from __future__ import annotations

from functools import partial
from typing import Any, Literal

import numpy as np

from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.geometry.transform import normalize
from pvphong.shading.inside.interpolation import (
    DENSE,
    Lighting,
    LitVertices,
    first_errors,
    jumps,
    more_errors,
    pattern_errors,
    sizes,
)

# --- bisection, on index arrays alone: who is whose neighbour, not where anything lies

# How much of a side's true length counts, so that of sides that are equally long to the algorithm the truly
# longest is cut.
_TIE = 2.0**-10


class Triangles:
    """Triangles as corners and numbered sides, which can be cut.

    Parameters
    ----------
    corners : ndarray of int
        Shape (m, 3), vertices in their orientation.
    n_vertices : int
        How many vertices there are.
    lengths : ndarray
        Shape (m, 3): true length of the side from each corner to the next; what is not finite counts as 0.

    Attributes
    ----------
    corners : ndarray
        Shape (m, 3).
    sides : ndarray
        Shape (m, 3): the number of the side from each corner to the next. Sides with the same ends are one.
    source : ndarray
        Shape (m,): which of the first triangles each is a part of.
    n_vertices : int
        How many vertices there are now.
    """

    def __init__(self, corners: IntArray, n_vertices: int, lengths: Float64Array) -> None:
        self.corners = corners.copy()
        self.n_vertices = n_vertices
        self.source: IntArray = np.arange(len(corners))
        following = np.roll(corners, -1, axis=1)
        keys = np.minimum(corners, following) * n_vertices + np.maximum(corners, following)
        unique, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
        self.sides: IntArray = inverse.reshape(corners.shape)
        self._ends: IntArray = np.stack(np.divmod(unique, max(n_vertices, 1)), axis=1)
        length = lengths.ravel()[first]
        length[~np.isfinite(length)] = 0.0
        # Squares of the lengths: medians are linear in them.
        self._squares: Float64Array = 1.0 + _TIE * length / (length.max(initial=0.0) or 1.0)

    def __len__(self) -> int:
        return len(self.corners)

    def marks(self, rows: IntArray, shaped: BoolArray) -> BoolArray:
        """Which sides must be cut so that some triangles are cut, and all that have a shape through their longest side.

        Parameters
        ----------
        rows : ndarray of int
            The triangles to cut.
        shaped : ndarray of bool
            Shape (m,): False for triangles that are cut only where their neighbours are.
        """
        longest = np.take_along_axis(self.sides, self._squares[self.sides].argmax(axis=1)[:, None], axis=1)[:, 0]
        marks = np.zeros(len(self._ends), dtype=bool)
        marks[longest[rows]] = True
        while True:  # ends, for each turn but the last marks a side more
            more = longest[marks[self.sides].any(axis=1) & shaped]
            more = more[~marks[more]]
            if not len(more):
                return marks
            marks[more] = True

    def cut(self, marks: BoolArray) -> tuple[IntArray, IntArray]:
        """Cut the sides that `marks` gave, and all triangles that have them.

        Returns
        -------
        parents : ndarray of int
            (k, 2): the ends of the sides whose middles are the k new vertices, in the order of their numbers.
        rows : ndarray of int
            The triangles that are new or changed.
        """
        cut_sides = np.flatnonzero(marks)
        rows = np.flatnonzero(marks[self.sides].any(axis=1))
        numbers = len(marks) + 2 * len(cut_sides) + 3 * len(rows)  # at most 3 cuts in a triangle, a new side for each
        middle, half = np.full((2, numbers), -1)
        middle[cut_sides] = self.n_vertices + np.arange(len(cut_sides))
        half[cut_sides] = len(marks) + 2 * np.arange(len(cut_sides))
        parents = self._ends[cut_sides]
        ends = np.stack([parents.ravel(), np.repeat(middle[cut_sides], 2)], axis=1)
        self._add_sides(ends, np.repeat(self._squares[cut_sides] / 4.0, 2))
        self.n_vertices += len(cut_sides)
        changed = [rows[:0]]
        while len(rows):
            children = self._bisect(rows, middle, half)
            changed.append(children)
            rows = children[(middle[self.sides[children]] >= 0).any(axis=1)]
        return parents, np.unique(np.concatenate(changed))

    def _bisect(self, rows: IntArray, middle: IntArray, half: IntArray) -> IntArray:
        """Cut each triangle from the middle m of its longest cut side pq to the opposite corner r."""
        squares = np.where(middle[self.sides[rows]] >= 0, self._squares[self.sides[rows]], -1.0)
        turn = (squares.argmax(axis=1)[:, None] + np.arange(3)) % 3
        p, q, r = np.take_along_axis(self.corners[rows], turn, axis=1).T
        pq, qr, rp = np.take_along_axis(self.sides[rows], turn, axis=1).T
        m = middle[pq]
        pm = half[pq] + (self._ends[pq, 0] != p)
        mq = half[pq] + (self._ends[pq, 0] == p)
        mr = len(self._ends) + np.arange(len(rows))
        squares = self._squares
        self._add_sides(np.stack([m, r], axis=1), (2.0 * (squares[rp] + squares[qr]) - squares[pq]) / 4.0)
        self.corners[rows] = np.stack([p, m, r], axis=1)
        self.sides[rows] = np.stack([pm, mr, rp], axis=1)
        added = len(self) + np.arange(len(rows))
        self.corners = np.concatenate([self.corners, np.stack([m, q, r], axis=1)])
        self.sides = np.concatenate([self.sides, np.stack([mq, qr, mr], axis=1)])
        self.source = np.concatenate([self.source, self.source[rows]])
        return np.concatenate([rows, added])

    def _add_sides(self, ends: IntArray, squares: Float64Array) -> None:
        self._ends = np.concatenate([self._ends, ends])
        self._squares = np.concatenate([self._squares, squares])


# --- rounds

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
    albedo : ndarray or None
        Shape (n, 3), in [0, 1].
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
        albedo: Float64Array | None,
        corners: IntArray,
        lighting: Lighting,
        smooth: bool = False,
    ) -> None:
        p, n = points.astype(np.float64), normals.astype(np.float64)
        self.vertices = LitVertices(p, n, n, albedo, lighting.colors(p, n, albedo))
        with np.errstate(invalid="ignore", over="ignore"):
            lengths = np.linalg.norm(np.roll(p[corners], -1, axis=1) - p[corners], axis=2)
        self.triangles = Triangles(corners, len(p), lengths)
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
        while len(rows := self._next_round(tolerance)):
            marks = self.triangles.marks(rows, self._known["visible"])
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

    def _next_round(self, tolerance: float) -> IntArray:
        """The triangles to split; none if all that may be split are good."""
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

    def _finish(self, tolerance: float) -> None:
        """Take the samples that have not been taken yet; more of them where it is a close thing."""
        rows = np.flatnonzero(~self._known["finished"])
        for errors_of in (more_errors, partial(pattern_errors, DENSE)):
            errors = errors_of(self.vertices, self.triangles.corners[rows], self._lighting)
            self.errors[rows] = np.maximum(self.errors[rows], errors)
            self._known["finished"][rows] = True
            rows = rows[(self.errors[rows] > _CLOSE * tolerance) & (self.errors[rows] <= _AIM * tolerance)]

    def _look_for_jumps(self, rows: IntArray, tolerance: float) -> None:
        """Triangles in which the colour jumps are stuck, and those that meet them: around a vertex without a normal
        the colours are as varied at every size.
        """
        corners = self.triangles.corners
        steps, errors = jumps(self.vertices, corners[rows], self._lighting)
        self.errors[rows] = np.maximum(self.errors[rows], errors)
        self._known["jump"][rows] = steps > tolerance
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
            spent = np.count_nonzero(self.triangles.marks(rows[:middle], self._known["visible"]))
            fits, too_many = (middle, too_many) if self.triangles.n_vertices + spent <= limit else (fits, middle)
        if fits:
            self._split(self.triangles.marks(rows[:fits], self._known["visible"]))
        self._finish(tolerance)
        self._look_for_jumps(self._poor(tolerance), tolerance)

    def _split(self, marks: BoolArray) -> None:
        """Cut the sides, and light the vertices at their middles.

        On a smooth surface these are moved to the middles of cubic curves that meet the ends' normals at right angles:
        the sides of PN triangles (A. Vlachos, J. Peters, C. Boyd, J. L. Mitchell: Curved PN triangles. Symposium on
        Interactive 3D Graphics (2001), 159-166). On a circle they err in the fourth power of the angle.
        """
        triangles_of = np.bincount(self.triangles.sides.ravel(), minlength=len(marks))
        curved = (triangles_of[marks] == 2) & self._smooth  # not on a boundary, nor where several sheets meet
        parents, rows = self.triangles.cut(marks)
        old, (a, b) = self.vertices, parents.T
        points = 0.5 * old.points[a] + 0.5 * old.points[b]
        p, q = old.points[a[curved]], old.points[b[curved]]
        n, m = normalize(old.normals[a[curved]]), normalize(old.normals[b[curved]])
        rise, fall = (np.einsum("ki,ki->k", q - p, normal)[:, None] for normal in (n, m))
        points[curved] += (fall * m - rise * n) / 8.0
        points = points.astype(self._real).astype(np.float64)
        normals = 0.5 * old.normals[a] + 0.5 * old.normals[b]
        lengths = np.stack([np.linalg.norm(old.stored[ends], axis=1) for ends in (a, b)])
        mean = np.where(lengths.min(axis=0) > 0.0, lengths.mean(axis=0), lengths.max(axis=0))
        stored = normalize(normals) * mean[:, None]  # so that between unit normals there are unit normals
        normals = stored if self._smooth else normals
        albedo = None if old.albedo is None else 0.5 * old.albedo[a] + 0.5 * old.albedo[b]
        colors = self._lighting.colors(points, normals, albedo)
        new = LitVertices(points, normals, stored, albedo, colors)
        joined: dict[str, Any] = {
            name: a if a is None else np.concatenate([a, getattr(new, name)]) for name, a in vars(old).items()
        }
        self.vertices = LitVertices(**joined)
        self.parents.append(parents)
        self._measure(rows)

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
