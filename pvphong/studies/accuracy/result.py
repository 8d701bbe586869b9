"""What was measured of accuracy and time, and the choice among its rows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray, MatrixLike
from pvphong.scene.scene import Scene
from pvphong.studies.accuracy.rows import LedgerEntry, Promise, Row
from pvphong.studies.accuracy.subject import Subject
from pvphong.studies.accuracy.variants import variants

_WORST = 5


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """What was measured on one mesh and scene, and what follows from it.

    Tables and figures read this; `Tradeoff`, which has them, says what the fields are.
    """

    tolerance: float
    rows: tuple[Row, ...]
    ledger: tuple[LedgerEntry, ...]
    baseline: str
    promises: tuple[Promise, ...]
    left_out: dict[str, str]
    facts: dict[str, str]
    inside_errors: Float64Array
    inside_areas: Float64Array
    surface: pv.PolyData
    _subject: Subject = field(kw_only=True)

    def best(self, tolerance: float | None = None, *, inside: bool = False, rays: bool = False) -> Row | None:
        """The cheapest row within a tolerance; peers are not chosen.

        Parameters
        ----------
        tolerance : float, optional
            Largest absolute colour error; the report's own if not given.
        inside : bool, default False
            False: at the vertices, where the largest arithmetic and light-model error must not add up to more
            than the tolerance. True: inside triangles, by the largest interpolation error.
        rays : bool, default False
            Of the ways to cast rays, by the root mean square of what sampling leaves.

        Returns
        -------
        Row or None
            None if no row is within it.

        Raises
        ------
        ValueError
            If the tolerance is not a number >= 0.
        """
        allowed = self.tolerance if tolerance is None else check.number("tolerance", tolerance, at_least=0.0)
        within = [row for row in self._candidates(inside, rays) if row.decisive_error <= allowed]
        return min(within, key=lambda row: row.time.median, default=None)

    @property
    def chosen(self) -> list[Row]:
        """The best row for each question."""
        best = self.best(), self.best(rays=True), self.best(inside=True)
        return [row for row in best if row is not None]

    def nearest(self, *, inside: bool = False, rays: bool = False) -> Row:
        """The row that errs least, for when none is within the tolerance; peers are not chosen."""
        return min(self._candidates(inside, rays), key=lambda row: row.decisive_error)

    def cheaper_peer(self, *, inside: bool = False, rays: bool = False) -> Row | None:
        """The cheapest of others' ways within the tolerance, if it costs less than the row that is chosen."""
        chosen = self.best(inside=inside, rays=rays)
        peers = (row for row in self.rows if row.is_peer and row.answers(inside, rays))
        within = (row for row in peers if row.decisive_error <= self.tolerance)
        peer = min(within, key=lambda row: row.time.median, default=None)
        return None if peer and chosen and chosen.time.median <= peer.time.median else peer

    def slowest(self) -> Row:
        """The row that costs most at the vertices; peers are not counted."""
        return max(self._candidates(), key=lambda row: row.time.median)

    def next_step(self, row: Row) -> Row | None:
        """The cheapest row that errs less than a row and answers the same question; None where there is none."""
        better = [
            other
            for other in self._candidates(row.kind == "interpolation", row.kind == "sampling")
            if other.decisive_error < row.decisive_error
        ]
        return min(better, key=lambda other: other.time.median, default=None)

    def _candidates(self, inside: bool = False, rays: bool = False) -> Iterator[Row]:
        return (row for row in self.rows if row.answers(inside, rays) and not row.is_peer)

    @property
    def noise(self) -> float:
        """The spread of times in the middle row: from quartile to quartile, as a part of the median."""
        return float(np.median([row.time.spread for row in self.rows]))

    @cached_property
    def chosen_colors(self) -> FloatArray:
        """Shape (n_points, 3): the colours of the row that is chosen at the vertices, evaluated again."""
        chosen, (found, _) = self.best(), variants(self._subject, self.tolerance)
        run = next((one.run for one in found if chosen is not None and one.name == chosen.name), found[0].run)
        return run()

    @property
    def scene(self) -> Scene:
        """What lit the mesh."""
        return self._subject.scene

    @property
    def matrix(self) -> MatrixLike | None:
        """The model matrix, None for the identity."""
        return self._subject.matrix

    @property
    def reference_colors(self) -> Float64Array:
        """Shape (n_points, 3): colours of the float64 reference."""
        return self._subject.truth

    def worst(self) -> list[tuple[int, float]]:
        """The vertices where the chosen row errs most: number and error, largest first."""
        errors = np.abs(self.chosen_colors.astype(np.float64) - self.reference_colors).max(axis=1)
        order = np.argsort(-errors, kind="stable")[:_WORST]
        return [(int(index), float(errors[index])) for index in order]
