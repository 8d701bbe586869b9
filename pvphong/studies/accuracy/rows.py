"""The rows of a report on accuracy and time: errors by kind, times, ledger entries, and which rows are on a front."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from pvphong.base.types import Float64Array, FloatArray

Kind = Literal["arithmetic", "light model", "sampling", "interpolation"]
KINDS: tuple[Kind, ...] = get_args(Kind)

_AT_ONCE = 2**18


@dataclass(frozen=True)
class Errors:
    """Absolute colour errors of one kind, without sign.

    Attributes
    ----------
    largest : float
        Of all places and channels.
    rms : float
        Root of the mean square: over all channels at the vertices; inside triangles over their areas, each with its
        largest error.
    p99 : float
        What 99 % of the vertices stay below, each in its worst channel, or the triangles that make up 99 % of the area.
    count : int
        How many places were looked at: vertices, or triangles.
    """

    largest: float
    rms: float
    p99: float
    count: int


def vertex_errors(colors: FloatArray, truth: FloatArray) -> Errors:
    """Errors of colours (n, 3) against the truth at the same vertices."""
    worst, squares = np.empty(len(truth)), 0.0
    for start in range(0, len(truth), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        difference = np.abs(colors[part].astype(np.float64) - truth[part])
        worst[part] = difference.max(axis=1)
        squares += float(np.square(difference).sum())
    rms = math.sqrt(squares / max(3 * len(truth), 1))
    return Errors(float(worst.max()), rms, float(np.percentile(worst, 99.0)), len(truth))


def triangle_errors(errors: Float64Array, areas: Float64Array) -> Errors:
    """Errors of triangles (m,), each of which stands for so much of a surface, in any unit.

    By area, for what is seen of a triangle is its area: counted one by one, the many small triangles of a mesh that
    is refined where it errs most would make it look worse than it was.
    """
    whole = areas.sum()
    if not whole:  # triangles without an area have no error either
        return Errors(0.0, 0.0, 0.0, len(errors))
    order = np.argsort(errors)
    cumulative = np.cumsum(areas[order])
    rank = np.searchsorted(cumulative, 0.99 * cumulative[-1])
    rms = math.sqrt(float(np.dot(errors**2, areas / whole)))
    return Errors(float(errors.max()), rms, float(errors[order[min(rank, len(order) - 1)]]), len(errors))


NO_ERROR = Errors(0.0, 0.0, 0.0, 0)


@dataclass(frozen=True)
class Timing:
    """Seconds of a run that was repeated.

    Attributes
    ----------
    median, low, high : float
        The median and the quartiles.
    repeats : int
        How many samples they are taken from, each the least of a few runs in a row where those are short.
    """

    median: float
    low: float
    high: float
    repeats: int

    @property
    def spread(self) -> float:
        """From quartile to quartile, as a part of the median."""
        return (self.high - self.low) / self.median

    @classmethod
    def of(cls, seconds: Sequence[float] | Float64Array) -> Timing:
        """The quartiles of some seconds; NaN is where nothing was measured."""
        low, median, high = np.nanpercentile(seconds, (25.0, 50.0, 75.0)).tolist()
        return cls(median, low, high, int(np.count_nonzero(~np.isnan(seconds))))


UNTIMED = Timing(0.0, 0.0, 0.0, 0)
"""Of a row that is still to be timed."""


@dataclass(frozen=True)
class Row:
    """One way of lighting a mesh: what it costs, how far it is off.

    The kinds of error are measured apart, each against a float64 truth in which only that kind is missing:
    `arithmetic` against the same equation in float64, `light_model` between two equations in float64, both at
    the vertices, `sampling` between colours by few rays and by all, `interpolation` between colours blended across
    a triangle and lit inside it, in float64.

    Attributes
    ----------
    name : str
        What is done.
    kind : {"arithmetic", "light model", "interpolation"}
        The kind of error that it trades for time; rows of one kind can be compared.
    time : Timing
        Of one evaluation of all its vertices, the plan included; of a peer that draws, of one frame.
    arithmetic, light_model, interpolation, sampling : Errors or None
        None where that kind was not measured.
    points : int
        Vertices that it evaluates.
    backend, precision : str
        What computes.
    promised : float or None
        The bound on the light-model error that the plan gave before anything ran.
    preparation : float
        Seconds that were spent once, before: splitting triangles.
    is_peer : bool
        Whether somebody else's code does it; it is compared, and never chosen.
    note : str
        What else there is to know.
    on_front : bool
        Whether no other row of its kind has less error in less time.
    """

    name: str
    kind: Kind
    time: Timing
    arithmetic: Errors | None
    light_model: Errors | None
    interpolation: Errors | None
    points: int
    backend: str
    precision: str
    promised: float | None = None
    preparation: float = 0.0
    is_peer: bool = False
    note: str = ""
    on_front: bool = False
    sampling: Errors | None = None

    @property
    def error(self) -> Errors:
        """The error of the row's own kind."""
        error: Errors | None = getattr(self, self.kind.replace(" ", "_"))
        assert error is not None, "a row is made with the error of its own kind"
        return error

    def answers(self, inside: bool, rays: bool) -> bool:
        """Whether it is a way to light inside triangles, to cast rays, or else to light vertices."""
        return (self.kind == "interpolation", self.kind == "sampling") == (inside, rays)

    @property
    def decisive_error(self) -> float:
        """What is held against a tolerance.

        Of interpolation that is the largest error, and of sampling the root of the mean square, for it is the standard
        error that rays are cast to; else what the vertices cannot exceed, the largest arithmetic plus the largest
        light-model error.
        """
        if self.kind == "interpolation":
            return self.error.largest
        if self.kind == "sampling":
            return self.error.rms
        return sum(error.largest for error in (self.arithmetic, self.light_model) if error is not None)


@dataclass(frozen=True)
class LedgerEntry:
    """What one effect, or one light, costs on a mesh.

    Attributes
    ----------
    effect : str
        Its name in the plan, or "light" and the light's.
    cost : Timing or None
        Seconds with it minus seconds without it, paired in turns, and those of casting its rays. None where it is not
        there, or was not measured.
    error : float or None
        The largest light-model error if it were dropped; None where it is not there.
    runs : bool
        Whether the plan at the tolerance runs it.
    why : str
        The plan's reason.
    """

    effect: str
    cost: Timing | None
    error: float | None
    runs: bool
    why: str


@dataclass(frozen=True)
class Promise:
    """What the plan promised of one approximation, and what it turned out to be.

    Attributes
    ----------
    effect : str
        What was left out.
    why : str
        How, for which lights.
    promised : float
        The bound that the plan took for it.
    measured : float
        The largest difference that it made at any vertex, in float64.
    """

    effect: str
    why: str
    promised: float
    measured: float


def with_fronts(rows: Sequence[Row]) -> tuple[Row, ...]:
    """The rows, each with whether it is on the Pareto front of its kind.

    A light-model row is also held against the exact equation on the same evaluator, an arithmetic row whose
    light-model error is 0.
    """
    return tuple(replace(row, on_front=not any(_dominates(other, row) for other in rows)) for row in rows)


def _dominates(a: Row, b: Row) -> bool:
    """Whether a is no slower and no farther off than b, and better in one of the two."""
    exact = b.kind == "light model" and a.kind == "arithmetic" and _evaluator(a) == _evaluator(b)
    if a.kind != b.kind and not exact:
        return False
    error = 0.0 if exact else a.error.largest
    times = a.time.median, b.time.median
    return times[0] <= times[1] and error <= b.error.largest and (times[0] < times[1] or error < b.error.largest)


def _evaluator(row: Row) -> tuple[str, str]:
    return row.backend, row.precision
