"""The rounds in which triangles are split until interpolated colours hold, after they are cut where colours jump."""

from __future__ import annotations

from functools import partial
from typing import Literal

import numpy as np

from pvphong.base import threads
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.shading.inside.cutting import PIXEL, Cuts, cut_edges, uncut_area
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
from pvphong.shading.inside.surface import Added, LitSurface
from pvphong.shading.inside.triangles import Triangles

Stopped = Literal["tolerance", "max_points", "jump", "resolution"]

# Parts of the tolerance: a triangle with an error above the first is split, one with an error above the second is
# sampled densely. Between samples errors were found to be larger by up to 5 % (dense) and 30 % (others).
_AIM, _CLOSE = 0.95, 0.7

# A round splits the triangles that are at least this urgent, against the most urgent.
_URGENT = 0.25

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
    corners : ndarray of int
        Shape (m, 3).
    lighting : Lighting
        The scene, the material and the model matrix.
    smooth : bool
        Whether new vertices are put on a smooth surface, or stay in the triangle.

    Attributes
    ----------
    cuts : Cuts
        What has been cut.
    """

    def __init__(
        self,
        points: FloatArray,
        normals: FloatArray,
        corners: IntArray,
        lighting: Lighting,
        smooth: bool = False,
    ) -> None:
        self._surface = LitSurface(points, normals, corners, lighting, smooth)
        self._lighting, self._real = lighting, points.dtype
        self.cuts = Cuts()
        self._known = np.zeros(0, dtype=_KNOWN)

    @property
    def triangles(self) -> Triangles:
        """As they are now."""
        return self._surface.triangles

    @property
    def vertices(self) -> LitVertices:
        """As they are now; the given ones first."""
        return self._surface.vertices

    @property
    def added(self) -> list[Added]:
        """What the others lie between."""
        return self._surface.added

    @property
    def errors(self) -> Float64Array:
        """(m,): each triangle's largest error at the samples so far; 0 in a triangle without an area."""
        result: Float64Array = self._known["error"]
        return result

    def run(self, tolerance: float, limit: int, *, cut: bool) -> Stopped:
        """Split until every error is within `tolerance` or nothing can be done, with at most `limit` points.

        It ends, because every round adds a point.

        Parameters
        ----------
        tolerance : float
            Largest error that may be left.
        limit : int
            How many points there may be.
        cut : bool
            Whether to cut along edges of what is seen of lights first.
        """
        if cut:
            self.cuts = cut_edges(self._surface, tolerance, limit)
        self._measure(np.arange(len(self.triangles)))
        while len(rows := self._next_round(tolerance)):
            threads.go_on()
            marks = self.triangles.marks(rows, self._known["visible"])
            if self.triangles.n_vertices + np.count_nonzero(marks) > limit:
                self._spend_what_is_left(tolerance, limit)
                break
            self._split(marks)
        if cut:
            strip = self.cuts.strip + uncut_area(self._surface, tolerance)
            self.cuts = self.cuts._replace(strip=strip)
        left = self.errors > tolerance
        if not left.any():
            return "tolerance"
        if self.cuts.is_spent:
            return "max_points"
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
            self._look_for_jumps(rows[self._known["longest"][rows] < PIXEL * self._surface.diagonal], tolerance)
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
        self._known["jump"][rows] = steps > tolerance / 2.0  # of what no splitting would cure, no part is to be left
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
        self._measure(self._surface.split(marks))

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
