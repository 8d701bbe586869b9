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
"""Task of a row: to light vertices, to cast rays from them, or to light between them."""

# Number of worst vertices in a report.
_WORST = 5


@dataclass(frozen=True)
class Errors:
    """Absolute colour errors of one kind.

    Attributes
    ----------
    largest : float
        Largest error over all places and channels.
    rms : float
        Root mean square: over all channels at the vertices; inside triangles by area, each with its largest error.
    p99 : float
        99th percentile over vertices, each with its worst channel; inside triangles by area.
    count : int
        Number of vertices or triangles.
    """

    largest: float
    rms: float
    p99: float
    count: int

    @classmethod
    def at_vertices(cls, colors: FloatArray, truth: FloatArray) -> Errors:
        """Return the errors of colours (n, 3) against the truth at the same vertices."""
        differences = np.abs(colors.astype(np.float64) - truth)
        worst = differences.max(axis=1)
        rms = math.sqrt(float(np.mean(differences**2)))
        return cls(float(worst.max()), rms, float(np.percentile(worst, 99.0)), len(truth))

    @classmethod
    def inside_triangles(cls, errors: Float64Array, areas: Float64Array) -> Errors:
        """Return statistics of errors of triangles (m,), each with the area that it represents, in any unit.

        Statistics are by area. By count, the many small triangles of a refined mesh would make it look worse than
        before.
        """
        whole = areas.sum()
        if not whole:  # triangles without an area have no error
            return cls(0.0, 0.0, 0.0, len(errors))
        order = np.argsort(errors)
        cumulative = np.cumsum(areas[order])
        rank = np.searchsorted(cumulative, 0.99 * cumulative[-1])
        rms = math.sqrt(float(np.dot(errors**2, areas / whole)))
        return cls(float(errors.max()), rms, float(errors[order[min(rank, len(order) - 1)]]), len(errors))


NO_ERROR = Errors(0.0, 0.0, 0.0, 0)


@dataclass(frozen=True)
class Timing:
    """Seconds of a repeated run.

    Attributes
    ----------
    median, low, high : float
        Median and quartiles.
    repeats : int
        Number of samples; for short runs, each is the minimum of a few runs in a row.
    """

    median: float
    low: float
    high: float
    repeats: int

    @property
    def spread(self) -> float:
        """Interquartile range relative to the median."""
        return (self.high - self.low) / self.median

    @property
    def is_noise(self) -> bool:
        """True if a difference of times may be noise: by its quartiles, or because of too few repeats."""
        return self.low <= 0.0 or self.repeats < FEWEST_REPEATS

    @classmethod
    def of(cls, seconds: Sequence[float] | Float64Array) -> Timing:
        """Return the quartiles of seconds; NaN if nothing was measured."""
        low, median, high = np.nanpercentile(seconds, (25.0, 50.0, 75.0)).tolist()
        return cls(median, low, high, int(np.count_nonzero(~np.isnan(seconds))))


UNTIMED = Timing(0.0, 0.0, 0.0, 0)
"""Timing of a row that is not timed yet."""


@dataclass(frozen=True)
class Row:
    """Cost and error of one variant of lighting a mesh.

    The kinds of error are measured separately, each against a float64 truth without that kind of error:
    `arithmetic` against the same equation in float64, `light_model` between two equations in float64, both at
    the vertices, `sampling` between colours by few rays and by all, `interpolation` between colours blended across
    a triangle and lit inside it, in float64.

    Attributes
    ----------
    name : str
        Name of the variant.
    kind : {"arithmetic", "light model", "sampling", "interpolation"}
        Kind of error that it trades for time. Rows of one kind can be compared.
    backend, precision : str
        Evaluator and type.
    points : int
        Number of evaluated vertices.
    time : Timing
        Time of one evaluation of all its vertices, with the plan; for a peer that draws, of one frame.
    arithmetic, light_model, sampling, interpolation : Errors or None
        Errors by kind; None if not measured.
    error_bound : float or None
        Bound on the light-model error that the plan predicted.
    preparation : float
        Seconds of preparation, such as splitting triangles.
    is_peer : bool
        True for code of others, which is compared and never chosen.
    note : str
        Remark.
    on_front : bool
        True if no other row of its kind has a smaller error in less time.
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
        """Error of the row's kind."""
        error: Errors | None = getattr(self, self.kind.replace(" ", "_"))
        assert error is not None, "a row has the error of its own kind"
        return error

    @property
    def decisive_error(self) -> float:
        """Error that is compared with the tolerance.

        For interpolation it is the largest error; for sampling the root mean square, because rays are cast to a
        standard error; otherwise the sum of the largest arithmetic and light-model errors, a bound at the vertices.
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
        Name in the plan, or "light" and the light's name.
    cost : Timing or None
        Difference of seconds with and without it, paired in turns, plus those of its rays. None if it is absent or was
        not measured.
    error : float or None
        Largest light-model error without it; None if it is absent.
    runs : bool
        True if the plan at the tolerance runs it.
    why : str
        Reason of the plan.
    """

    effect: str
    cost: Timing | None
    error: float | None
    runs: bool
    why: str

    @property
    def cost_text(self) -> str:
        """Formatted cost; empty if not measured."""
        return "" if self.cost is None else "in the noise" if self.cost.is_noise else seconds(self.cost.median)


@dataclass(frozen=True)
class PredictedBound:
    """Predicted bound and measured error of one approximation.

    Attributes
    ----------
    effect : str
        Effect that was left out.
    why : str
        Approximation and its lights.
    predicted : float
        Bound of the plan.
    measured : float
        Largest difference at any vertex, in float64.
    """

    effect: str
    why: str
    predicted: float
    measured: float


def with_fronts(rows: Sequence[Row]) -> tuple[Row, ...]:
    """Return the rows with `on_front` set for those on the Pareto front of their kind, which no other beats in time and
    error.

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

    `Tradeoff`, which adds sentences, tables and files, describes the fields.
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
    """Name of a row → function that lights the vertices again."""

    def best(
        self, tolerance: float | None = None, question: Question = "at the vertices", *, peers: bool = False
    ) -> Row | None:
        """Return the cheapest row within a tolerance.

        Parameters
        ----------
        tolerance : float, optional
            Largest absolute colour error; by default the report's.
        question : {"at the vertices", "casting rays", "inside triangles"}
            At the vertices the largest arithmetic and light-model error must not add up to more than the tolerance.
            For rows that cast rays the root mean square error counts, inside triangles the largest error.
        peers : bool, default False
            Choose among the peers instead.

        Returns
        -------
        Row or None
            None if no row is within the tolerance.

        Raises
        ------
        ValueError
            If the tolerance is not a number >= 0, or the question is unknown.
        """
        allowed = self.tolerance if tolerance is None else check.number("tolerance", tolerance, at_least=0.0)
        check.choice("question", question, QUESTIONS)
        within = (row for row in self.rows_for(question, peers=peers) if row.decisive_error <= allowed)
        return min(within, key=lambda row: row.time.median, default=None)

    def next_step(self, row: Row) -> Row | None:
        """Return the cheapest row with a smaller error than a row, for the same question; None if there is none."""
        better = (other for other in self.rows_for(row.question) if other.decisive_error < row.decisive_error)
        return min(better, key=lambda other: other.time.median, default=None)

    @property
    def chosen(self) -> list[Row]:
        """The best row for each question."""
        best = (self.best(question=question) for question in QUESTIONS)
        return [row for row in best if row is not None]

    def rows_for(self, question: Question, *, peers: bool = False) -> Iterator[Row]:
        """Return the rows for a question: pvphong's own, or those of peers."""
        return (row for row in self.rows if row.question == question and row.is_peer == peers)

    @property
    def noise(self) -> float:
        """Median over the rows of the interquartile range relative to the median."""
        return float(np.median([row.time.spread for row in self.rows]))

    @property
    def name_of_chosen(self) -> str:
        """Name of the row chosen at the vertices. There is always one, because the reference has no error."""
        chosen = self.best()
        assert chosen is not None, "the reference is within every tolerance"
        return chosen.name

    @cached_property
    def chosen_colors(self) -> FloatArray:
        """Return the colours of the row chosen at the vertices, shape (n_points, 3), evaluated again."""
        return self._lighting[self.name_of_chosen]()

    def worst(self) -> list[tuple[int, float]]:
        """Vertices with the largest errors of the chosen row: index and error, largest first."""
        errors = np.abs(self.chosen_colors.astype(np.float64) - self.reference_colors).max(axis=1)
        order = np.argsort(-errors, kind="stable")[:_WORST]
        return [(int(index), float(errors[index])) for index in order]


def table(title: str, *headings: str, right: Collection[str] = ()) -> Table:
    """Return an empty `rich.table.Table`. Columns of numbers are not wrapped."""
    from rich import box
    from rich.table import Table

    made = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in headings:
        is_right = heading in right
        made.add_column(heading, overflow="fold", justify="right" if is_right else "left", no_wrap=is_right)
    return made


def seconds(value: float) -> str:
    """Format a time with a suitable unit."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if abs(value) >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value * 1e6:.3g} µs"


def number(value: float) -> str:
    """Format an error with three digits."""
    return "0" if value == 0.0 else f"{value:.3g}"
