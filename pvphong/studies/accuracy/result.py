"""Results of a measurement: errors by kind, times, rows with their Pareto fronts, and the choice."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray, MatrixLike
from pvphong.scene.scene import Scene
from pvphong.studies.accuracy.timing import FEWEST_REPEATS

if TYPE_CHECKING:
    from rich.table import Table

Kind = Literal["arithmetic", "light model", "sampling", "interpolation"]
KINDS: tuple[Kind, ...] = get_args(Kind)

Question = Literal["at the vertices", "casting rays", "inside triangles"]
QUESTIONS: tuple[Question, ...] = get_args(Question)
"""What a row answers: how to light vertices, how to cast rays from them, how to light between them."""

# Vertices that are named as the worst.
_WORST = 5


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

    @classmethod
    def at_vertices(cls, colors: FloatArray, truth: FloatArray) -> Errors:
        """Errors of colours (n, 3) against the truth at the same vertices."""
        differences = np.abs(colors.astype(np.float64) - truth)
        worst = differences.max(axis=1)
        rms = math.sqrt(float(np.mean(differences**2)))
        return cls(float(worst.max()), rms, float(np.percentile(worst, 99.0)), len(truth))

    @classmethod
    def inside_triangles(cls, errors: Float64Array, areas: Float64Array) -> Errors:
        """Errors of triangles (m,), each with the area of the surface that it represents, in any unit.

        By area, for what is seen of a triangle is its area: counted one by one, the many small triangles of a mesh
        that is refined where it errs most would make it look worse than it was.
        """
        whole = areas.sum()
        if not whole:  # triangles without an area have no error either
            return cls(0.0, 0.0, 0.0, len(errors))
        order = np.argsort(errors)
        cumulative = np.cumsum(areas[order])
        rank = np.searchsorted(cumulative, 0.99 * cumulative[-1])
        rms = math.sqrt(float(np.dot(errors**2, areas / whole)))
        return cls(float(errors.max()), rms, float(errors[order[min(rank, len(order) - 1)]]), len(errors))


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

    @property
    def is_noise(self) -> bool:
        """True if a difference of times may be noise: by its quartiles, or because of too few repeats."""
        return self.low <= 0.0 or self.repeats < FEWEST_REPEATS

    @classmethod
    def of(cls, seconds: Sequence[float] | Float64Array) -> Timing:
        """The quartiles of some seconds; NaN is where nothing was measured."""
        low, median, high = np.nanpercentile(seconds, (25.0, 50.0, 75.0)).tolist()
        return cls(median, low, high, int(np.count_nonzero(~np.isnan(seconds))))


UNTIMED = Timing(0.0, 0.0, 0.0, 0)
"""The timing of a row that is still to be timed."""


@dataclass(frozen=True)
class Row:
    """One variant of lighting a mesh: what it costs, how far it is off.

    The kinds of error are measured apart, each against a float64 truth in which only that kind is missing:
    `arithmetic` against the same equation in float64, `light_model` between two equations in float64, both at
    the vertices, `sampling` between colours by few rays and by all, `interpolation` between colours blended across
    a triangle and lit inside it, in float64.

    Attributes
    ----------
    name : str
        What is done.
    kind : {"arithmetic", "light model", "sampling", "interpolation"}
        The kind of error that it trades for time; rows of one kind can be compared.
    backend, precision : str
        What computes.
    points : int
        Vertices that it evaluates.
    time : Timing
        Of one evaluation of all its vertices, the plan included; of a peer that draws, of one frame.
    arithmetic, light_model, sampling, interpolation : Errors or None
        None where that kind was not measured.
    error_bound : float or None
        The bound on the light-model error that the plan predicted before anything ran.
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
    backend: str
    precision: str
    points: int
    time: Timing = UNTIMED
    arithmetic: Errors | None = None
    light_model: Errors | None = None
    sampling: Errors | None = None
    interpolation: Errors | None = None
    error_bound: float | None = None
    preparation: float = 0.0
    is_peer: bool = False
    note: str = ""
    on_front: bool = False

    @property
    def question(self) -> Question:
        """Question that it answers."""
        return {"sampling": QUESTIONS[1], "interpolation": QUESTIONS[2]}.get(self.kind, QUESTIONS[0])

    @property
    def error(self) -> Errors:
        """The error of the row's own kind."""
        error: Errors | None = getattr(self, self.kind.replace(" ", "_"))
        assert error is not None, "a row is made with the error of its own kind"
        return error

    @property
    def decisive_error(self) -> float:
        """Error that is compared with the tolerance.

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
    """Cost of one effect, or one light, on a mesh.

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

    @property
    def cost_text(self) -> str:
        """The cost for people; empty where it was not measured."""
        return "" if self.cost is None else "in the noise" if self.cost.is_noise else seconds(self.cost.median)


@dataclass(frozen=True)
class PredictedBound:
    """The bound that the plan took for one approximation, and the error that was measured.

    Attributes
    ----------
    effect : str
        What was left out.
    why : str
        How, for which lights.
    predicted : float
        The bound that the plan took for it.
    measured : float
        The largest difference that it made at any vertex, in float64.
    """

    effect: str
    why: str
    predicted: float
    measured: float


def with_fronts(rows: Sequence[Row]) -> tuple[Row, ...]:
    """The rows, each with whether it is on the Pareto front of its kind: no other is better in time and in error.

    A light-model row is also compared with the exact equation on the same evaluator, an arithmetic row whose
    light-model error is 0.
    """

    def dominates(a: Row, b: Row) -> bool:
        evaluators = (a.backend, a.precision), (b.backend, b.precision)
        is_exact = (a.kind, b.kind) == ("arithmetic", "light model") and evaluators[0] == evaluators[1]
        if a.kind != b.kind and not is_exact:
            return False
        error = 0.0 if is_exact else a.error.largest
        no_worse = a.time.median <= b.time.median and error <= b.error.largest
        return no_worse and (a.time.median < b.time.median or error < b.error.largest)

    return tuple(replace(row, on_front=not any(dominates(other, row) for other in rows)) for row in rows)


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """Measurements on one mesh and scene, and the choice among the rows; source of the figure.

    `Tradeoff`, which adds sentences, tables and files, says what the fields are.
    """

    tolerance: float
    rows: tuple[Row, ...]
    ledger: tuple[LedgerEntry, ...]
    baseline: str
    predicted_bounds: tuple[PredictedBound, ...]
    left_out: dict[str, str]
    facts: dict[str, str]
    inside_errors: Float64Array
    inside_areas: Float64Array
    surface: pv.PolyData
    scene: Scene
    matrix: MatrixLike | None
    reference_colors: Float64Array
    _lighting: Mapping[str, Callable[[], FloatArray]] = field(kw_only=True)
    """Lights the vertices again, by the names of rows."""

    def best(
        self, tolerance: float | None = None, question: Question = "at the vertices", *, peers: bool = False
    ) -> Row | None:
        """The cheapest row within a tolerance.

        Parameters
        ----------
        tolerance : float, optional
            Largest absolute colour error; the report's own if not given.
        question : {"at the vertices", "casting rays", "inside triangles"}
            At the vertices the largest arithmetic and light-model error must not add up to more than the tolerance.
            Of rows that cast rays the root mean square error counts, inside triangles the largest.
        peers : bool, default False
            Whether it is one of the peers, which are not chosen otherwise.

        Returns
        -------
        Row or None
            None if no row is within it.

        Raises
        ------
        ValueError
            If the tolerance is not a number >= 0, or the question is another.
        """
        allowed = self.tolerance if tolerance is None else check.number("tolerance", tolerance, at_least=0.0)
        check.choice("question", question, QUESTIONS)
        within = (row for row in self.rows_for(question, peers=peers) if row.decisive_error <= allowed)
        return min(within, key=lambda row: row.time.median, default=None)

    def next_step(self, row: Row) -> Row | None:
        """The cheapest row that errs less than a row and answers the same question; None where there is none."""
        better = (other for other in self.rows_for(row.question) if other.decisive_error < row.decisive_error)
        return min(better, key=lambda other: other.time.median, default=None)

    @property
    def chosen(self) -> list[Row]:
        """The best row for each question."""
        best = (self.best(question=question) for question in QUESTIONS)
        return [row for row in best if row is not None]

    def rows_for(self, question: Question, *, peers: bool = False) -> Iterator[Row]:
        """The rows that answer a question: pvphong's own, or those of peers."""
        return (row for row in self.rows if row.question == question and row.is_peer == peers)

    @property
    def noise(self) -> float:
        """The spread of times in the middle row: from quartile to quartile, as a part of the median."""
        return float(np.median([row.time.spread for row in self.rows]))

    @property
    def name_of_chosen(self) -> str:
        """The name of the row that is chosen at the vertices, of which there is one: the reference has no error."""
        chosen = self.best()
        assert chosen is not None, "the reference is within every tolerance"
        return chosen.name

    @cached_property
    def chosen_colors(self) -> FloatArray:
        """Shape (n_points, 3): the colours of the row that is chosen at the vertices, evaluated again."""
        return self._lighting[self.name_of_chosen]()

    def worst(self) -> list[tuple[int, float]]:
        """The vertices where the chosen row errs most: number and error, largest first."""
        errors = np.abs(self.chosen_colors.astype(np.float64) - self.reference_colors).max(axis=1)
        order = np.argsort(-errors, kind="stable")[:_WORST]
        return [(int(index), float(errors[index])) for index in order]


def table(title: str, *headings: str, right: Collection[str] = ()) -> Table:
    """An empty `rich.table.Table`; columns of some headings are of numbers, which are not broken."""
    from rich import box
    from rich.table import Table

    made = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in headings:
        is_right = heading in right
        made.add_column(heading, overflow="fold", justify="right" if is_right else "left", no_wrap=is_right)
    return made


def seconds(value: float) -> str:
    """A time in the unit that suits it."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if abs(value) >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value * 1e6:.3g} µs"


def number(value: float) -> str:
    """An error in three digits."""
    return "0" if value == 0.0 else f"{value:.3g}"
