"""Bounded least squares: the intensities and colours, all >= 0, that come nearest to a target.

With the columns A, the unknowns x and the colours u = base + A x, the error is Σ w (target − f(u))², where w are the
weights and f clamps at 1 if the light model does. Without clamped colours this is the convex problem of Lawson and
Hanson ("Solving Least Squares Problems", 1974, chapter 23), solved from its normal equations. A target of 1 or more
asks for colours of *at least* 1, and the problem stays convex. Where other colours are clamped, it is not convex.
Gauss-Newton steps then descend from the solution of the convex problem, or from a multiple of this solution if its
error is smaller.

Sums over vertices run in one thread and in a fixed order, so their bits do not depend on the number of threads.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, IntArray
from pvphong.studies.fitting.columns import Share
from pvphong.studies.fitting.target import LUMINANCE, Wanted
from pvphong.studies.fitting.variation import Variation

_STEPS = 30
# A decrease of the error by less than this fraction ends the descent.
_NOTHING = 1e-15
# A larger relative change of an unknown by the correction is made.
_CORRECTED = 1e-12
# Mean squares of the differences below this are rounding errors.
_ROUNDING = 1e-24
# Eigenvalues of the scaled normal equations below this fraction of the largest are rounding.
_RANK = 1e-14


# Factors by which all lights may be brighter, and the number of points at which this is tried.
_FACTORS, _SOME = (1.0, 1.5, 2.5, 5.0), 1000


def refuse_without_scipy() -> None:
    """Raise ``ValueError`` if SciPy is missing."""
    if importlib.util.find_spec("scipy") is None:
        raise ValueError("fit needs SciPy, which is not installed. Run pip install scipy, or install the extra fit.")


class Column(NamedTuple):
    """Colours of all points per unit of one unknown: an intensity, or one channel of a light's colour."""

    colors: Float64Array
    """Colours of all points per unit of the unknown, shape (n, 3)."""
    channel: int | None
    """The colour channel (0, 1, 2) that the unknown changes; None if it changes all three."""


Rows = list[tuple[IntArray, Float64Array]]
"""Weighted columns of each compared channel: the indices of the columns that change this channel, and their values."""


class Normal(NamedTuple):
    """Normal equations G x = b of weighted least squares; `matrix` is G, `right` is b."""

    matrix: Float64Array
    right: Float64Array


@dataclass(frozen=True, eq=False)
class Problem:
    """Least-squares problem for the unknowns of all lights: intensities and channels of colours.

    `columns` are the colours per unit of each unknown, and `wanted` is the target.
    """

    base: Float64Array
    """Shape (n, 3): the colours with all unknowns 0."""
    columns: Sequence[Column]
    wanted: Wanted

    @classmethod
    def of(cls, base: Float64Array, varied: Sequence[Variation], shares: Sequence[Share], wanted: Wanted) -> Problem:
        """Return the least-squares problem of some lights.

        `base` has the colours without these lights. `varied` are the lights with their fields that vary, and `shares`
        the colours that each gives per unit of its unknowns. `wanted` is the target.
        """
        columns = []
        for share in shares:
            if share.offset is not None:
                base = base + share.offset
        for one, share in zip(varied, shares, strict=True):
            for colors in share.columns:
                columns += [Column(colors, c) for c in range(3)] if one.colors else [Column(colors, None)]
        return cls(base, columns, wanted)

    def colors(self, x: Float64Array) -> Float64Array:
        """Return the colours u (n, 3) for the unknowns x, before clamping."""
        found = self.base.copy()
        for value, column in zip(x.tolist(), self.columns, strict=True):
            if value and column.channel is None:
                found += value * column.colors
            elif value:
                found[:, column.channel] += value * column.colors[:, column.channel]
        return found

    @cached_property
    def asks_for_full(self) -> Any:
        """Mask of targets of 1 or more, shape (n, 1) or (n, 3). A clamped colour meets such a target exactly."""
        return (self.wanted.values >= 1.0) & (self.wanted.roots > 0.0)

    def clamped(self, colors: Float64Array, *, convex: bool) -> Any:
        """Return a mask (n, 3) of the `colors` that are clamped; None if no colour is.

        With `convex`, only colours whose target is 1 or more count as clamped.
        """
        if not self.wanted.clamps or colors.max(initial=0.0) < 1.0:
            return None
        found = (colors >= 1.0) & (self.asks_for_full if convex else self.wanted.roots > 0.0)
        return found if found.any() else None

    def residual(self, colors: Float64Array, clamped: Any) -> Float64Array:
        """Return the weighted difference between target and `colors`, shape (n, 1) or (n, 3).

        `clamped` is the mask of colours that are replaced by 1; None for no colour.
        """
        wanted = self.wanted
        shown = colors if clamped is None else np.where(clamped, 1.0, colors)
        return wanted.roots * (wanted.reachable - wanted.seen(shown))

    @cached_property
    def unclamped(self) -> Rows:
        """The weighted columns as rows, if no colour is clamped."""
        roots, found = self.wanted.roots, []
        if self.wanted.is_luminance:
            rows = np.empty((len(self.columns), len(roots)))
            for row, (colors, channel) in zip(rows, self.columns, strict=True):
                seen = self.wanted.seen(colors)[:, 0] if channel is None else LUMINANCE[channel] * colors[:, channel]
                np.multiply(seen, roots[:, 0], out=row)
            return [(np.arange(len(self.columns)), rows)]
        for c in range(3):
            numbers = np.array([k for k, (_, channel) in enumerate(self.columns) if channel in (None, c)], np.intp)
            rows = np.empty((len(numbers), len(roots)))
            for row, k in zip(rows, numbers, strict=True):
                np.multiply(self.columns[k].colors[:, c], roots[:, c], out=row)
            found.append((numbers, rows))
        return found

    def rows(self, clamped: Any) -> Rows:
        """Return the weighted columns as contiguous rows, for each channel that is compared.

        Each entry has the numbers of the columns that count in this channel, and the rows, shape (k, n). Clamped
        colours do not change, so their columns are 0.
        """
        if clamped is None:
            return self.unclamped
        if not self.wanted.is_luminance:
            found = [(numbers, rows.copy()) for numbers, rows in self.unclamped]
            for c, (_, rows) in enumerate(found):
                rows[:, np.flatnonzero(clamped[:, c])] = 0.0
            return found
        (numbers, rows), where = self.unclamped[0], np.flatnonzero(clamped.any(axis=1))
        rows = rows.copy()
        weights = np.where(clamped[where], 0.0, LUMINANCE * self.wanted.roots[where])
        for row, (colors, channel) in zip(rows, self.columns, strict=True):
            own = slice(None) if channel is None else slice(channel, channel + 1)
            row[where] = np.einsum("nc,nc->n", colors[where][:, own], weights[:, own])
        return [(numbers, rows)]


class Solution(NamedTuple):
    """Solution of a `Problem`."""

    x: Float64Array
    """The unknowns, all >= 0."""
    squares: float
    """Weighted sum of squared differences from the target, over points and channels."""
    colors: Float64Array
    """Colours (n, 3) before clamping."""
    residual: Float64Array
    """The weighted residual."""
    clamped: Any
    """Mask (n, 3) of the colours that are clamped; None if no colour is."""
    rows: Rows
    """The weighted columns."""
    normal: Normal
    """Normal equations for a change of the unknowns; the right side is 0 at the optimum where x > 0, else <= 0."""
    is_convex: bool
    """True if no colour is clamped whose target is below 1. Then, no other intensities without such colours are better.
    """

    @property
    def violation(self) -> float:
        """Largest violation of the optimality conditions of Karush, Kuhn and Tucker, from 0 to 1.

        For each unknown, the cosine of the angle between the residual and the unknown's column should be 0. For an
        unknown that is 0, a negative cosine is no violation. A residual that is only rounding error violates nothing.
        """
        wrong = np.where(self.x > 0.0, np.abs(self.normal.right), self.normal.right)
        scale = np.sqrt(np.diag(self.normal.matrix) * self.squares)
        is_known = (scale > 0.0) & (self.squares > _ROUNDING)
        return float(np.divide(wrong, scale, out=np.zeros(len(wrong)), where=is_known).clip(0.0, 1.0).max(initial=0.0))


def normal_equations(rows: Rows, residual: Float64Array, count: int, known: Float64Array | None = None) -> Normal:
    """Return the normal equations of `count` columns from the columns' weighted `rows` and the weighted `residual`.

    `known` is the matrix of these equations if it was computed before.
    """
    matrix, right = np.zeros((count, count)), np.zeros(count)
    for channel, (numbers, vectors) in zip(np.ascontiguousarray(residual.T), rows, strict=True):
        if known is None:
            matrix[np.ix_(numbers, numbers)] += np.einsum("in,jn->ij", vectors, vectors)
        right[numbers] += np.einsum("in,n->i", vectors, channel)
    return Normal(matrix if known is None else known, right)


def nonnegative(normal: Normal) -> Float64Array:
    """Return the x >= 0 that minimizes x·G x / 2 − b·x.

    The equations are scaled, and a square root of G is passed to SciPy's solver (Lawson and Hanson's algorithm). If
    columns depend on each other, so that several x are optimal, one of these is returned.
    """
    from scipy.optimize import nnls

    scale = np.sqrt(np.diag(normal.matrix))
    used = scale > 0.0
    x = np.zeros(len(scale))
    if not used.any():
        return x
    unit = scale[used]
    values, vectors = np.linalg.eigh(normal.matrix[np.ix_(used, used)] / np.outer(unit, unit))
    kept = values > _RANK * values[-1]
    roots, vectors = np.sqrt(values[kept]), vectors[:, kept]
    found, _ = nnls(roots[:, None] * vectors.T, (vectors.T @ (normal.right[used] / unit)) / roots)
    x[used] = found / unit
    return x


def solve(problem: Problem, near: Float64Array | None = None) -> Solution:
    """Solve the problem: the optimum of the convex problem, and a descent if other colours are clamped.

    `near` are the unknowns of a similar problem. If colours clamp, the descent then begins there: this takes fewer
    steps, and may end in another optimum if the problem is not convex.
    """
    if near is not None and problem.wanted.clamps:
        found = _descent(problem, near, convex=False)
        is_convex = found.clamped is None or not (found.clamped & ~problem.asks_for_full).any()
        return found._replace(is_convex=is_convex)
    found = _descent(problem, np.zeros(len(problem.columns)), convex=True)
    if not problem.wanted.clamps:
        return found
    brighter = _brighter(problem, found)
    if brighter == 1.0:
        over = problem.clamped(found.colors, convex=False)
        if over is None or not (over & ~problem.asks_for_full).any():
            return found
    return _descent(problem, brighter * found.x, convex=False)._replace(is_convex=False)


def _brighter(problem: Problem, found: Solution) -> float:
    """Return the factor for all unknowns that gives the smallest error with clamped colours; at least 1.

    The factor is estimated from some of the points. `found` is the solution of the convex problem.
    """
    if found.colors.max(initial=0.0) * _FACTORS[-1] <= 1.0:
        return 1.0
    some = slice(None, None, max(len(problem.base) // _SOME, 1))
    wanted = problem.wanted
    part = Problem(problem.base[some], (), Wanted(wanted.values[some], wanted.roots[some], wanted.clamps))
    varied = found.colors[some] - part.base

    def squares(factor: float) -> float:
        colors = part.base + factor * varied
        return float(np.square(part.residual(colors, part.clamped(colors, convex=False))).sum())

    return min(_FACTORS, key=squares)


def _descent(problem: Problem, x: Float64Array, *, convex: bool) -> Solution:
    """Take Gauss-Newton steps from `x` until the error no longer falls.

    Within a step, the set of clamped colours is constant. Without clamped colours the first step is exact. A correction
    by the residual follows, because normal equations square the condition number. With `convex`, only colours whose
    target is 1 or more count as clamped.
    """
    now = _at(problem, x, convex)
    for _ in range(_STEPS if problem.columns else 0):
        step = nonnegative(Normal(now.normal.matrix, now.normal.right + now.normal.matrix @ now.x)) - now.x
        then = _at(problem, now.x + step, convex, now)
        for _ in range(_STEPS):
            if then.squares <= now.squares:
                break
            step *= 0.5
            then = _at(problem, now.x + step, convex, now)
        else:
            break
        is_done = now.squares - then.squares <= _NOTHING * now.squares or _are_same(then.clamped, now.clamped)
        now = then
        if is_done:
            break
    positive = now.x > 0.0
    if not positive.any():
        return now
    matrix = now.normal.matrix[np.ix_(positive, positive)]
    change = np.linalg.lstsq(matrix, now.normal.right[positive], rcond=None)[0]
    if (np.abs(change) <= _CORRECTED * now.x[positive]).all():
        return now
    x = now.x.copy()
    x[positive] += change
    corrected = _at(problem, np.maximum(x, 0.0), convex, now)
    return corrected if corrected.squares <= now.squares else now


def _at(problem: Problem, x: Float64Array, convex: bool, before: Solution | None = None) -> Solution:
    """Return the state of the problem for the unknowns `x`.

    With `convex`, only colours whose target is 1 or more count as clamped. `before` is an earlier state; its weighted
    columns are reused if the same colours are clamped.
    """
    colors = problem.colors(x)
    clamped = problem.clamped(colors, convex=convex)
    residual = problem.residual(colors, clamped)
    if before is not None and _are_same(clamped, before.clamped):
        rows, matrix = before.rows, before.normal.matrix
    else:
        rows, matrix = problem.rows(clamped), None
    normal = normal_equations(rows, residual, len(problem.columns), matrix)
    return Solution(x, float(np.square(residual).sum()), colors, residual, clamped, rows, normal, True)


def _are_same(a: Any, b: Any) -> bool:
    return a is b or (a is not None and b is not None and bool(np.array_equal(a, b)))
