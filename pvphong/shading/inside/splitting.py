"""Refinement of a surface: cuts where colours jump, then rounds of splits until interpolated colours are accurate."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from pvphong.base import text, threads
from pvphong.base.types import Float64Array, IntArray
from pvphong.shading.inside.cutting import PIXEL, Cuts, cut_edges, uncut_area
from pvphong.shading.inside.interpolation import (
    DENSE,
    first_errors,
    jumps,
    more_errors,
    pattern_errors,
)
from pvphong.shading.inside.places import sizes
from pvphong.shading.inside.surface import LitSurface
from pvphong.shading.inside.triangles import marked

Stopped = Literal["tolerance", "max_points", "jump", "resolution"]

# Fractions of the tolerance. A triangle with an error above _AIM is split, and a triangle with an error above _CLOSE is
# sampled densely. Errors between samples were found to be larger by up to 5 % (dense) and 30 % (others).
_AIM, _CLOSE = 0.95, 0.7

# Least urgency of triangles that a round splits, as a fraction of the largest.
_URGENT = 0.25

# Progress, a fraction of the whole, after the cuts, the first samples, and the splits that these require.
_CUT, _SAMPLED, _SPLIT = 0.2, 0.4, 0.6

# Least height of a triangle that is split, in steps of its coordinates' precision.
_LEAST_HEIGHT = 16.0


# Record of each triangle.
_KNOWN = np.dtype(
    [
        ("error", np.float64),  # largest error at the samples so far; 0 without an area
        ("longest", np.float64),  # longest side
        ("visible", np.bool_),  # True if it has an area
        ("finished", np.bool_),  # True if all samples have been taken
        ("stuck", np.bool_),  # True if splitting would not help
        ("jump", np.bool_),  # True if the colour jumps in it
    ]
)


class Refinement:
    """Refinement of a surface in rounds.

    Attributes
    ----------
    surface : LitSurface
        Current surface.
    cuts : Cuts
        Summary of the cuts.
    """

    def __init__(self, surface: LitSurface) -> None:
        self.surface, self.cuts = surface, Cuts()
        self._known = np.zeros(0, dtype=_KNOWN)

    @property
    def errors(self) -> Float64Array:
        """Largest error in each triangle at the samples so far, shape (m,); 0 in a triangle without an area."""
        result: Float64Array = self._known["error"]
        return result

    def run(
        self, tolerance: float, limit: int, *, cut: bool, after_round: Callable[[], object] = lambda: None
    ) -> Stopped:
        """Split triangles until every error is within the tolerance, or splitting does not help.

        Return the reason for the end.
        The method always stops, because each round adds a point, and `limit` bounds the number of points.

        Parameters
        ----------
        tolerance : float
            Largest error that is allowed.
        limit : int
            Largest number of points.
        cut : bool
            True to cut along edges of shadows and cones first.
        after_round : callable
            Called after the cuts of each light and after each round of splits.
        """
        if cut:
            with text.stage("refining", 0.0, _CUT):
                self.cuts = cut_edges(self.surface, tolerance, limit, after_round)
        with text.stage("refining", _CUT, _SAMPLED):
            self._measure(np.arange(len(self.surface.triangles)), tolerance)
        first = len(self._known)
        while len(rows := self._next_round(tolerance)):
            threads.go_on()
            part = _SAMPLED + (_SPLIT - _SAMPLED) * self._part(first, tolerance)
            with text.stage("refining", part, part):
                marks = self.surface.triangles.marks(rows, self._known["visible"])
                if self.surface.triangles.n_vertices + np.count_nonzero(marks) > limit:
                    self._spend_what_is_left(tolerance, limit)
                    break
                self._measure(self.surface.split(marks), tolerance)
            after_round()
        if cut:
            self.cuts = self.cuts._replace(strip=self.cuts.strip + uncut_area(self.surface, tolerance))
        left = self.errors > tolerance
        if not left.any():
            return "tolerance"
        if self.cuts.is_spent or (left & ~self._known["stuck"]).any():
            return "max_points"
        return "jump" if self._known["jump"][left].any() else "resolution"

    def _part(self, first: int, tolerance: float) -> float:
        """Estimate which fraction of all rounds of splits is done.

        The estimate assumes that errors are proportional to triangles' areas. `first` is the number of triangles before
        the first round.
        """
        parts = np.where(self._known["stuck"], 1.0, np.maximum(self.errors / (_AIM * tolerance), 1.0))
        expected = float(parts.sum()) - first
        return (len(parts) - first) / expected if expected > 0.0 else 1.0

    def _next_round(self, tolerance: float) -> IntArray:
        """Return the triangles to split next.

        Return an empty array if all errors that splits can reduce are within the tolerance.
        """
        while True:
            rows = self._poor(tolerance)
            if not len(rows):
                if self._known["finished"].all():
                    return rows
                with text.stage("refining", _SPLIT, 1.0):
                    self._finish(tolerance)
                continue
            urgency = self._urgency(rows)
            rows = rows[urgency >= _URGENT * urgency.max()]
            self._look_for_jumps(rows[self._known["longest"][rows] < PIXEL * self.surface.diagonal], tolerance)
            rows = rows[~self._known["stuck"][rows]]
            if len(rows):
                return rows

    def _poor(self, tolerance: float) -> IntArray:
        return np.flatnonzero((self.errors > _AIM * tolerance) & ~self._known["stuck"])

    def _urgency(self, rows: IntArray) -> Float64Array:
        """Return the urgency of splitting each triangle of `rows`: its error times its longest side.

        Of two triangles with equal errors, the larger is more visible.
        """
        return self.errors[rows] * self._known["longest"][rows]

    def _finish(self, tolerance: float) -> None:
        """Take the remaining samples of all triangles.

        In triangles whose error is close to the tolerance, add dense samples.
        """
        rows = np.flatnonzero(~self._known["finished"])
        for errors_of in (more_errors, partial(pattern_errors, DENSE)):
            errors = errors_of(self.surface.vertices, self.surface.triangles.corners[rows], _CLOSE * tolerance)
            self.errors[rows] = np.maximum(self.errors[rows], errors)
            self._known["finished"][rows] = True
            rows = rows[(self.errors[rows] > _CLOSE * tolerance) & (self.errors[rows] <= _AIM * tolerance)]

    def _look_for_jumps(self, rows: IntArray, tolerance: float) -> None:
        """Search the triangles `rows` for jumps of the colour.

        Mark triangles as stuck if splitting would not improve them. Triangles in which the colour jumps are stuck, and
        triangles that share a vertex with them. For example, around a vertex without a normal, colours vary as much in
        small triangles as in large ones.
        """
        corners = self.surface.triangles.corners
        steps, errors = jumps(self.surface.vertices, corners[rows])
        self.errors[rows] = np.maximum(self.errors[rows], errors)
        self._known["jump"][rows] = steps > tolerance / 2.0  # splitting reduces no part of a jump, so small ones count
        at_jumps = marked(self.surface.triangles.n_vertices, corners[self._known["jump"]])
        self._known["stuck"][rows] |= at_jumps[corners[rows]].any(axis=1)

    def _spend_what_is_left(self, tolerance: float, limit: int) -> None:
        """Split the most urgent triangles until the number of points reaches `limit`."""
        rows = self._poor(tolerance)
        rows = rows[np.argsort(-self._urgency(rows), kind="stable")]
        fits, too_many = 0, len(rows) + 1
        while too_many - fits > 1:
            middle = (fits + too_many) // 2
            spent = np.count_nonzero(self.surface.triangles.marks(rows[:middle], self._known["visible"]))
            is_enough = self.surface.triangles.n_vertices + spent <= limit
            fits, too_many = (middle, too_many) if is_enough else (fits, middle)
        if fits:
            marks = self.surface.triangles.marks(rows[:fits], self._known["visible"])
            self._measure(self.surface.split(marks), tolerance)
        self._finish(tolerance)
        self._look_for_jumps(self._poor(tolerance), tolerance)

    def _measure(self, rows: IntArray, tolerance: float) -> None:
        """Record the sizes and the errors at the first samples of the triangles `rows`, which are new or changed."""
        corners = self.surface.triangles.corners[rows]
        points = self.surface.vertices.points
        longest, height = sizes(points, corners)
        step = np.abs(points).max(axis=1)[corners].max(axis=1, initial=0.0) * float(np.finfo(self.surface.real).eps)
        visible = height > 0.0
        added = len(self.surface.triangles) - len(self._known)
        self._known = np.concatenate([self._known, np.zeros(added, dtype=_KNOWN)])
        self._known[rows] = 0
        self._known["longest"][rows] = longest
        self._known["stuck"][rows] = ~(height > _LEAST_HEIGHT * step)
        self._known["visible"][rows] = visible
        self._known["finished"][rows] = ~visible
        self.errors[rows[visible]] = first_errors(self.surface.vertices, corners[visible], _CLOSE * tolerance)
