"""Results of a measurement: errors by kind, times, rows with their Pareto fronts, and the choice of a row."""

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
"""Questions of a report: the best way to light vertices, to cast rays from them, and to light points between them."""

# Number of worst vertices in a report.
_WORST = 5


@dataclass(frozen=True)
class Errors:
    """Absolute colour errors of one kind.

    Attributes
    ----------
    largest : float
        Largest error over all vertices or triangles, and all channels.
    rms : float
        Root mean square. At vertices, it is taken over all channels. Inside triangles, it is taken over each triangle's
        largest error, weighted by area.
    p99 : float
        99th percentile. At vertices, it is taken over each vertex's worst channel. Inside triangles, it is taken over
        each triangle's largest error, weighted by area.
    count : int
        Number of vertices or triangles.
    """

    largest: float
    rms: float
    p99: float
    count: int

    @classmethod
    def at_vertices(cls, colors: FloatArray, truth: FloatArray) -> Errors:
        """Return statistics of the errors of `colors` at vertices, shape (n, 3). `truth` has the true colours."""
        differences = np.abs(colors.astype(np.float64) - truth)
        worst = differences.max(axis=1)
        rms = math.sqrt(float(np.mean(differences**2)))
        return cls(float(worst.max()), rms, float(np.percentile(worst, 99.0)), len(truth))

    @classmethod
    def inside_triangles(cls, errors: Float64Array, areas: Float64Array) -> Errors:
        """Return statistics of the largest errors in m triangles, weighted by area.

        Without weights, a refined mesh would look worse than before, because of its many small triangles where errors
        are large.

        Parameters
        ----------
        errors : ndarray
            Shape (m,): the largest error in each triangle.
        areas : ndarray
            Shape (m,): the area that each triangle represents, in any unit.
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
        Number of samples. For a short run, each sample is the minimum of a few consecutive runs.
    """

    median: float
    low: float
    high: float
    repeats: int

    @property
    def spread(self) -> float:
        """Distance between the quartiles divided by the median."""
        return (self.high - self.low) / self.median

    @property
    def is_noise(self) -> bool:
        """True if this time, a difference of two other times, may be noise.

        This is so if the lower quartile is not positive, or there are too few repeats.
        """
        return self.low <= 0.0 or self.repeats < FEWEST_REPEATS

    @classmethod
    def of(cls, seconds: Sequence[float] | Float64Array) -> Timing:
        """Return the timing of repeated runs, given their seconds; NaN entries are skipped."""
        low, median, high = np.nanpercentile(seconds, (25.0, 50.0, 75.0)).tolist()
        return cls(median, low, high, int(np.count_nonzero(~np.isnan(seconds))))


UNTIMED = Timing(0.0, 0.0, 0.0, 0)
"""Timing of a row that is not timed yet."""


@dataclass(frozen=True)
class Row:
    """Time and errors of one variant, that is, one way to light a mesh.

    The kinds of error are measured separately, each against float64 colours without that kind of error:

    - `arithmetic`: colours at the vertices compared with the same equation in float64.
    - `light_model`: a simpler equation compared with the full one at the vertices, both in float64.
    - `sampling`: colours by few rays compared with colours by 4096 rays.
    - `interpolation`: colours blended across triangles compared with colours lit inside them, both in float64.

    Attributes
    ----------
    name : str
        Name of the variant.
    kind : {"arithmetic", "light model", "sampling", "interpolation"}
        Kind of error that the variant trades for time. Rows of one kind can be compared.
    backend : str
        Name of the evaluator.
    precision : str
        Type of the colours, such as "float32".
    points : int
        Number of evaluated vertices.
    time : Timing
        Time to make the plan and evaluate all vertices once. For frames drawn by VTK, time of one frame.
    arithmetic, light_model, sampling, interpolation : Errors or None
        Errors by kind; None if not measured.
    error_bound : float or None
        Bound that the plan predicted for the light-model error; None for rows without such a bound.
    preparation : float
        Seconds of preparation, such as splitting triangles.
    is_peer : bool
        True for an implementation other than pvphong's. Such a row is compared but never chosen.
    note : str
        Remark.
    on_front : bool
        True if the row is on the Pareto front of its kind; see `with_fronts`.
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
        """Question that the row answers: "at the vertices", "casting rays" or "inside triangles".

        The row's `kind` determines the question.
        """
        return {"sampling": QUESTIONS[1], "interpolation": QUESTIONS[2]}.get(self.kind, QUESTIONS[0])

    @property
    def error(self) -> Errors:
        """The row's measured error of the kind that `kind` names, such as the field `sampling`."""
        error: Errors | None = getattr(self, self.kind.replace(" ", "_"))
        assert error is not None, "a row has the error of its own kind"
        return error

    @property
    def decisive_error(self) -> float:
        """Error that is compared with the tolerance.

        For interpolation it is the largest error. For sampling it is the root mean square, because rays are cast to a
        standard error. For the other kinds it is the sum of the largest arithmetic and light-model errors. This sum
        bounds the total error at the vertices.
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
        Seconds with the effect minus seconds without it, in the same rounds, plus the seconds to cast its rays. None if
        the effect is absent or was not measured.
    error : float or None
        Largest light-model error without the effect; None if the effect is absent or was not measured.
    runs : bool
        True if the plan at the tolerance runs the effect.
    why : str
        Reason that the plan gives for running the effect, or for leaving it out.
    """

    effect: str
    cost: Timing | None
    error: float | None
    runs: bool
    why: str

    @property
    def cost_text(self) -> str:
        """Cost of the effect as text; empty if it was not measured."""
        return "" if self.cost is None else "in the noise" if self.cost.is_noise else seconds(self.cost.median)


@dataclass(frozen=True)
class PredictedBound:
    """Predicted bound and measured error of one approximation.

    Attributes
    ----------
    effect : str
        Effect that was left out.
    why : str
        Description of the approximation, and the lights that it affects.
    predicted : float
        Bound that the plan predicted.
    measured : float
        Largest difference that the approximation makes to a colour at any vertex, in float64.
    """

    effect: str
    why: str
    predicted: float
    measured: float


def with_fronts(rows: Sequence[Row]) -> tuple[Row, ...]:
    """Return copies of the rows with `on_front` set: True for the rows on the Pareto front of their kind.

    A row is on the front if no other row is at least as good in time and error, and better in time or error. A
    light-model row is also compared with the arithmetic row of the same evaluator. That row evaluates the exact
    equation, so its light-model error is 0.
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
    """Measurements on one mesh and scene, with methods that choose a row. The module `figure` draws a result.

    A row has the errors and the time of one way to light the mesh. The subclass `Tradeoff` adds sentences, tables and
    files.

    Attributes
    ----------
    tolerance : float
        Allowed colour error.
    rows : tuple of Row
        Measured ways to light the mesh.
    ledger : tuple of LedgerEntry
        Cost of each effect and each light, and the error without this effect or light.
    baseline : str
        Name of the row to which the ledger's costs refer.
    predicted_bounds : tuple of PredictedBound
        Approximations within the tolerance, with bounds and measured errors.
    left_out : dict of str to str
        Variants that were not measured, and the reasons.
    facts : dict of str to str
        Mesh, scene, machine and versions, by name.
    inside_errors, inside_areas : ndarray
        Shape (m,): the largest interpolation error in each searched triangle, and each triangle's fraction of the area
        of all searched triangles.
    surface : pyvista.PolyData
        Mesh whose points were lit.
    scene : Scene
        Scene that lit the mesh.
    matrix : array_like or None
        (4, 4) model matrix; None for the identity.
    reference_colors : ndarray
        Colours of the float64 reference, shape (n_points, 3).
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
    """Name of a row → function that lights the vertices again as this row did, and returns their colours."""

    def best(
        self, tolerance: float | None = None, question: Question = "at the vertices", *, peers: bool = False
    ) -> Row | None:
        """Return the row with the least time within a tolerance. A row stands for one way to light the mesh.

        Parameters
        ----------
        tolerance : float, optional
            Largest absolute colour error; by default the report's.
        question : {"at the vertices", "casting rays", "inside triangles"}
            Question that the row answers. It decides which error must be within the tolerance. At the vertices, this is
            the sum of the largest arithmetic and light-model errors. For casting rays, it is the root mean square
            error, and inside triangles the largest error.
        peers : bool, default False
            Choose among other implementations instead of pvphong's.

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
        """Return the quickest row with the same question as `row` and a smaller error; None without such a row."""
        better = (other for other in self.rows_for(row.question) if other.decisive_error < row.decisive_error)
        return min(better, key=lambda other: other.time.median, default=None)

    @property
    def chosen(self) -> list[Row]:
        """Best rows within the report's tolerance, one for each question that has such a row."""
        best = (self.best(question=question) for question in QUESTIONS)
        return [row for row in best if row is not None]

    def rows_for(self, question: Question, *, peers: bool = False) -> Iterator[Row]:
        """Yield the rows that answer a question: pvphong's own rows, or with `peers` those of other implementations."""
        return (row for row in self.rows if row.question == question and row.is_peer == peers)

    @property
    def noise(self) -> float:
        """Median of the spread of the times, over all rows; see `Timing.spread`."""
        return float(np.median([row.time.spread for row in self.rows]))

    @property
    def name_of_chosen(self) -> str:
        """Name of pvphong's row with the least time within the report's tolerance at the vertices. Peers do not count.

        There is always such a row, because the float64 reference has no error.
        """
        chosen = self.best()
        assert chosen is not None, "the reference is within every tolerance"
        return chosen.name

    @cached_property
    def chosen_colors(self) -> FloatArray:
        """Colours at the vertices by the row that `name_of_chosen` names, shape (n_points, 3).

        They are computed at the first access.
        """
        return self._lighting[self.name_of_chosen]()

    def worst(self) -> list[tuple[int, float]]:
        """Return index and error of the five vertices at which `chosen_colors` have the largest errors."""
        errors = np.abs(self.chosen_colors.astype(np.float64) - self.reference_colors).max(axis=1)
        order = np.argsort(-errors, kind="stable")[:_WORST]
        return [(int(index), float(errors[index])) for index in order]


def table(title: str, *headings: str, right: Collection[str] = ()) -> Table:
    """Return an empty `rich.table.Table` with a title. Columns named in `right` are right-aligned and not wrapped."""
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
