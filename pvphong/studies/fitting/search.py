"""Search for the *shapes* of lights (directions, positions, cones, sizes), with intensities and colours solved inside.

The method is variable projection (Golub and Pereyra, "The differentiation of pseudo-inverses and nonlinear least
squares problems whose variables separate", SIAM J. Numer. Anal. 10, 1973), with the Jacobian of Kaufman (BIT 15, 1975).
The error is a function of the shapes alone; for each shape, the best intensities and colours are used. Steps are those
of Levenberg and Marquardt. The search begins at several starts:

1. A bank of candidates for each light: directions that cover the sphere, positions around the mesh.
2. For each start, lights begin as given, dark, or at random candidates. Then they take turns: each light takes the
   candidate that reduces the error of the other lights most, and all intensities are solved again.
3. Short descents from all starts on a sample of the vertices, and long ones from the best. Where the target is nearly
   met, they are repeated without the few points that have far larger errors than the rest.
4. In the best result, each light in turn is exchanged for the candidate that reduces the error of the others most, and
   a descent follows.
5. The last descent is on all vertices.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pvphong.base import text
from pvphong.base.types import Float64Array
from pvphong.geometry.extent import Sphere
from pvphong.optics.light import Light
from pvphong.studies.fitting.columns import Columns, Share
from pvphong.studies.fitting.linear import Column, Normal, Problem, Rows, Solution, normal_equations, solve
from pvphong.studies.fitting.target import Wanted
from pvphong.studies.fitting.variation import Variation

# Numbers of vertices for the bank, for descents from starts, and for a descent before that on all vertices.
_OF_BANK, _OF_SEARCH, _OF_MOST = 400, 2000, 16000
# Number of directions in a bank.
_DIRECTIONS = 128
# Number of rounds in which lights take turns.
_ROUNDS = 4
# Numbers of steps of a short and of a long descent, and of starts that get a long one.
_SHORT, _LONG, _KEPT = 10, 40, 3
# Greatest number of exchanges of each light; an exchange gets a long descent if its error is below this multiple of the
# best one's.
_EXCHANGES, _PROMISING = 4, 4.0
# A fraction of the target's squares that is a perfect fit.
PERFECT = 1e-22
# Relative decreases of the squares by less, twice in a row, end a descent: on a sample, and on all vertices.
_LITTLE, _NOTHING = 1e-6, 1e-7
# The same if the target is not nearly met: the squares then say little about the shapes.
_ROUGH = 1e-4
# A step that promises a smaller part of such a decrease, or is shorter than this, is not tried.
_PROMISE, _SHORTEST = 1e-3, 1e-9
# A difference above this multiple of the median is far off; if fewer than this share of all are, they are left out, at
# most so many times.
_FAR_OFF, _FEW, _TRIMS = 6.0, 0.3, 4
# A target is nearly met if the squares are below this fraction of the target's own.
_CLOSE = 0.01
# Bounds on the damping of Levenberg and Marquardt.
_DAMPING, _LEAST, _MOST = 1e-3, 1e-14, 1e10


class Point(NamedTuple):
    """A point of the search: lights, their shares of the colours, and the solved intensities and colours."""

    lights: tuple[Light, ...]
    shares: tuple[Share, ...]
    solution: Solution


@dataclass(frozen=True, eq=False)
class Search:
    """A fit on some vertices.

    `columns` evaluates the lights' colours, `varied` are the lights with their fields that vary, `wanted` is the
    target, and `base` has the colours without these lights.
    """

    columns: Columns
    varied: Sequence[Variation]
    wanted: Wanted
    base: Float64Array

    @classmethod
    def of(cls, columns: Columns, varied: Sequence[Variation], wanted: Wanted) -> Search:
        """Return the search on the vertices of `columns`; arguments as for the class."""
        return cls(columns, varied, wanted, columns.base(varied))

    def at(
        self, lights: Sequence[Light], known: Sequence[Share | None] = (), near: Float64Array | None = None
    ) -> Point:
        """Return the point of the search for `lights`.

        `known` has a light's colours if they were evaluated before; None for a light to evaluate. `near` are the
        intensities of a similar point; see `solve`.
        """
        known = known or [None] * len(lights)
        shares = tuple(
            self.columns.share(one, light) if share is None else share
            for one, light, share in zip(self.varied, lights, known, strict=True)
        )
        return Point(tuple(lights), shares, solve(Problem.of(self.base, self.varied, shares, self.wanted), near))

    def derivatives(self, point: Point) -> Rows:
        """Return weighted derivatives of the colours by the coordinates of all shapes, at constant intensities.

        They are finite differences with constant shadows. Where colours jump, central differences with a long step are
        used.
        """
        solution, found, first = point.solution, list[Column](), 0
        for one, light, share in zip(self.varied, point.lights, point.shares, strict=True):
            x = solution.x[first : first + len(one.unknowns)]
            first += len(one.unknowns)
            for number, (step, jumps) in enumerate(one.steps):
                by = np.zeros(one.count)
                by[number] = step
                sides = [(one.moved(light, by), 1.0)] + [(one.moved(light, -by), -1.0)] * jumps
                difference = np.zeros_like(self.base)
                for moved, sign in sides:
                    difference += sign * _colors(one, self.columns.share(one, moved, share.seen), x)
                if not jumps:
                    difference -= _colors(one, share, x)
                found.append(Column(difference / (step * len(sides)), None))
        return Problem(self.base, found, self.wanted).rows(solution.clamped)

    @cached_property
    def close(self) -> float:
        """Squared error below which the target is nearly met."""
        return _CLOSE * float(np.square(self.wanted.roots * self.wanted.values).sum())

    def descend(self, point: Point, most: int, perfect: float, little: float = _LITTLE) -> Point:
        """Descend from `point` by Levenberg-Marquardt steps.

        The descent ends after `most` steps, at a squared error of at most `perfect`, or after two steps in a row that
        each reduce the error by a fraction of at most `little`, or of at most `_ROUGH` if the target is not nearly met.
        A step that promises far less, or is very short, ends it too.
        """
        if not any(one.count for one in self.varied):
            return point
        damping, stalls = _DAMPING, 0
        for _ in range(most):
            before, then = point.solution.squares, None
            if before <= perfect:
                break
            enough = (little if before <= self.close else max(little, _ROUGH)) * before
            matrix, right = projected(point.solution, self.derivatives(point))
            growth = 10.0
            while then is None and damping <= _MOST:
                damped = matrix + damping * np.diag(np.maximum(np.diag(matrix), 1e-12 * np.trace(matrix) + 1e-300))
                step = np.clip(np.linalg.lstsq(damped, right, rcond=None)[0], -1.0, 1.0)
                if step @ (2.0 * right - matrix @ step) <= _PROMISE * enough or np.abs(step).max() < _SHORTEST:
                    break
                trial = self._stepped(point, step)
                if trial.solution.squares < before:
                    then, damping = trial, max(damping * 0.1, _LEAST)
                else:
                    damping, growth = max(damping, _LEAST) * growth, min(10.0 * growth, 1e3)
            if then is None:
                break
            point = then
            stalls = stalls + 1 if before - point.solution.squares <= enough else 0
            if stalls == 2:
                break
        if not self.wanted.clamps:
            return point
        afresh = self.at(point.lights, point.shares)
        return afresh if afresh.solution.squares < point.solution.squares else point

    def _stepped(self, point: Point, step: Float64Array) -> Point:
        lights, known, first = [], list[Share | None](), 0
        for one, light, share in zip(self.varied, point.lights, point.shares, strict=True):
            lights.append(one.moved(light, step[first : first + one.count]))
            known.append(None if one.count else share)
            first += one.count
        return self.at(lights, known, point.solution.x)

    def settled(self, point: Point, most: int, perfect: float, little: float = _LITTLE) -> Point:
        """Descend from `point`, then try again without the few points that have far larger differences than the rest.

        Where a highlight ends at the edge of the light, colours jump as a light moves. A few points on the wrong side
        of such an edge would keep a descent from the minimum. The repetition is tried only where the target is nearly
        met. `most`, `perfect` and `little` are those of `descend`.
        """
        point = self.descend(point, most, perfect, little)
        for _ in range(_TRIMS):
            if not perfect < point.solution.squares <= self.close:
                break
            counts = self.wanted.roots > 0.0
            off = np.divide(
                np.abs(point.solution.residual), self.wanted.roots, out=np.zeros(counts.shape), where=counts
            )
            is_out = off > _FAR_OFF * np.median(off[counts])
            if not 0 < is_out.sum() < _FEW * counts.sum():
                break
            trimmed = replace(self, wanted=replace(self.wanted, roots=np.where(is_out, 0.0, self.wanted.roots)))
            moved = trimmed.descend(trimmed.at(point.lights, point.shares), _SHORT, perfect, little)
            trial = self.descend(self.at(moved.lights), _SHORT, perfect, little)
            if trial.solution.squares >= point.solution.squares:
                break
            point = trial
        return point

    def narrowed(self, point: Point, perfect: float) -> Point:
        """Improve the coordinates at which colours jump, one after the other, by trial steps in both directions.

        The step is halved when no coordinate improves. The search ends at a squared error of at most `perfect`.
        """
        jumpy = [(k, n) for k, one in enumerate(self.varied) for n, (_, jumps) in enumerate(one.steps) if jumps]
        length = 0.02
        while jumpy and length > 1e-5 and point.solution.squares > perfect:
            before = point.solution.squares
            for k, number in jumpy:
                for sign in (1.0, -1.0):
                    by = np.zeros(self.varied[k].count)
                    by[number] = sign * length
                    lights = list(point.lights)
                    lights[k] = self.varied[k].moved(lights[k], by)
                    trial = self.at(lights, [None if i == k else share for i, share in enumerate(point.shares)])
                    if trial.solution.squares < point.solution.squares:
                        point = trial
            if point.solution.squares >= before * (1.0 - 1e-3):
                length *= 0.5
        return point


def _colors(one: Variation, share: Share, x: Float64Array) -> Float64Array:
    """Return the colours (n, 3) of the light `one` if its unknowns have the values `x`.

    `share` has the colours per unit of each unknown.
    """
    found = np.zeros_like(share.columns[0]) if share.offset is None else share.offset.copy()
    factors = x.reshape(-1, 3) if one.colors else x
    for colors, factor in zip(share.columns, factors, strict=True):
        found += colors * factor
    return found


def projected(solution: Solution, derivatives: Rows) -> tuple[Float64Array, Float64Array]:
    """Return the matrix and the right side of the normal equations for a step of the shapes.

    The intensities and colours that are not 0 are eliminated. `solution` has the solved intensities and colours, and
    `derivatives` the colours' derivatives by the coordinates of the shapes.
    """
    joint = joined(solution, derivatives)
    free, inner = np.flatnonzero(solution.x > 0.0), len(solution.x)
    matrix, right = joint.matrix[inner:, inner:], joint.right[inner:]
    if len(free):
        across = joint.matrix[np.ix_(free, np.arange(inner, len(joint.right)))]
        eliminated = np.linalg.lstsq(joint.matrix[np.ix_(free, free)], across, rcond=None)[0]
        matrix = matrix - across.T @ eliminated
        right = right - eliminated.T @ joint.right[free]
    return matrix, right


def joined(solution: Solution, derivatives: Rows) -> Normal:
    """Return the normal equations of all unknowns.

    The intensities and colours come first, then the coordinates of the shapes. `solution` has the solved intensities
    and colours, and `derivatives` the colours' derivatives by the coordinates of the shapes.
    """
    inner = len(solution.x)
    rows = [
        (np.concatenate([numbers, inner + others]), np.concatenate([own, more]))
        for (numbers, own), (others, more) in zip(solution.rows, derivatives, strict=True)
    ]
    count = inner + (len(derivatives[0][0]) if derivatives else 0)
    return normal_equations(rows, solution.residual, count)


# --- starts


class Bank(NamedTuple):
    """Candidates for one light: lights with other shapes, and the colours that each gives."""

    lights: list[Light]
    shares: list[Share]
    rows: Float64Array
    """Weighted columns, shape (candidates, units, points · channels)."""
    lengths: Float64Array
    """Squared lengths of the columns, shape (candidates, units)."""

    @classmethod
    def of(cls, search: Search, one: Variation, around: Sphere) -> Bank:
        """Return the candidates for the light `one`. A light without shapes that vary is its only candidate.

        `search` evaluates them, and `around` is a sphere around the mesh.
        """
        lights = list(one.starts(around, search.columns.scene.viewer, _DIRECTIONS)) if one.count else [one.light]
        shares = [search.columns.share(one, light) for light in lights]
        roots = search.wanted.roots
        units = [[*share.columns, *([] if share.offset is None else [share.offset])] for share in shares]
        rows = np.array([[(roots * search.wanted.seen(colors)).ravel() for colors in each] for each in units])
        return cls(lights, shares, rows, np.einsum("mkn,mkn->mk", rows, rows))

    def best(self, residual: Float64Array) -> int:
        """Return the index of the candidate whose columns can reduce a weighted `residual` most."""
        along = np.einsum("mkn,n->mk", self.rows, residual)
        gains = np.divide(np.maximum(along, 0.0) ** 2, self.lengths, out=np.zeros_like(along), where=self.lengths > 0.0)
        return int(np.argmax(gains.sum(axis=1)))


@dataclass(frozen=True, eq=False)
class Starts:
    """Starts of a search on a few vertices. Each light has a bank of candidates."""

    search: Search
    banks: Sequence[Bank]

    @classmethod
    def of(cls, search: Search, around: Sphere) -> Starts:
        """Return the starts of a search, with a bank for each light. `around` is a sphere around the mesh."""
        return cls(search, [Bank.of(search, one, around) for one in search.varied])

    @property
    def moving(self) -> list[int]:
        """Indices of the lights that have candidates."""
        return [k for k, bank in enumerate(self.banks) if len(bank.lights) > 1]

    def _solved(self, shares: Sequence[Share | None]) -> Solution:
        """Return the best intensities and colours for the given `shares`, one for each light; None is a dark light."""
        search = self.search
        known = [
            share or Share([np.zeros_like(search.base)] * len(bank.shares[0].columns), None, [])
            for share, bank in zip(shares, self.banks, strict=True)
        ]
        return solve(Problem.of(search.base, search.varied, known, search.wanted))

    def _squares(self, chosen: Sequence[int]) -> float:
        return self._solved([bank.shares[number] for bank, number in zip(self.banks, chosen, strict=True)]).squares

    def first(self, count: int, random: np.random.Generator) -> list[tuple[Light, ...]]:
        """Return different starts, those with the smallest error first, and the lights as given last.

        There are `count` beginnings: the lights as given, all lights that move dark, and random candidates. From each,
        lights take turns: each light takes the candidate that reduces the error of the others most.
        """
        found: dict[tuple[int, ...], float] = {(0,) * len(self.banks): np.inf}
        for number in range(count):
            chosen: list[int | None] = [0] * len(self.banks)
            for k in self.moving if number else ():
                chosen[k] = None if number == 1 else int(random.integers(len(self.banks[k].lights)))
            before: list[int | None] = []
            for _ in range(_ROUNDS):
                for k in random.permutation(self.moving).tolist():
                    chosen[k] = None
                    shares = [
                        None if each is None else bank.shares[each]
                        for bank, each in zip(self.banks, chosen, strict=True)
                    ]
                    chosen[k] = self.banks[k].best(self._solved(shares).residual.ravel())
                if chosen == before:
                    break
                before = list(chosen)
            key = tuple(each or 0 for each in chosen)
            if key not in found:
                found[key] = self._squares(key)
        ranked = sorted(found, key=lambda key: (found[key], key))
        return [tuple(bank.lights[each] for bank, each in zip(self.banks, key, strict=True)) for key in ranked]

    def exchanged(self, lights: Sequence[Light], k: int) -> tuple[Light, ...]:
        """Return `lights` with light `k` replaced by the candidate that reduces the error of the other lights most."""
        shares = [
            None if number == k else self.search.columns.share(one, light)
            for number, (one, light) in enumerate(zip(self.search.varied, lights, strict=True))
        ]
        bank = self.banks[k]
        best = bank.lights[bank.best(self._solved(shares).residual.ravel())]
        return tuple(best if number == k else light for number, light in enumerate(lights))


# --- the whole search


def find(
    columns: Columns, varied: Sequence[Variation], wanted: Wanted, around: Sphere, *, tries: int, seed: int, goal: float
) -> tuple[Search, Point, bool]:
    """Return the search on all vertices, the best point that was found, and True if the search was interrupted.

    Parameters
    ----------
    columns : Columns
        Evaluator on all vertices.
    varied : sequence of Variation
        The lights that vary.
    wanted : Wanted
        The target.
    around : Sphere
        Sphere around the mesh in the world.
    tries : int
        Number of starts to make.
    seed : int
        Seed of the sample and of the beginnings.
    goal : float
        Squared error that ends the search.
    """
    whole = Search.of(columns, varied, wanted)
    lights = tuple(one.light for one in varied)
    if not any(one.count for one in varied):
        return whole, whole.at(lights), False
    random = np.random.default_rng(seed)
    rows = random.permutation(np.flatnonzero(wanted.counts))

    def sample(count: int) -> Search:
        part = np.sort(rows[:count])  # `Columns.at` keeps surfaces together
        return Search.of(columns.at(part), varied, wanted.at(part))

    few, some = sample(_OF_BANK), sample(_OF_SEARCH)
    exact = PERFECT * float(np.square(wanted.roots * wanted.values).sum())
    try:
        for point in _sampled(few, some, around, tries, random, max(exact, goal)):
            lights = point.lights
        with text.stage("all vertices", 0.9, 1.0):
            if point.solution.squares > exact and len(rows) > 2 * _OF_MOST:
                more = sample(_OF_MOST)
                point = more.settled(more.at(lights, near=point.solution.x), _LONG, exact)
                lights = point.lights
            return whole, whole.settled(whole.at(lights, near=point.solution.x), _LONG, exact, _NOTHING), False
    except KeyboardInterrupt:
        return whole, whole.at(lights), True


def _sampled(
    few: Search, some: Search, around: Sphere, tries: int, random: np.random.Generator, perfect: float
) -> Iterator[Point]:
    """Search on samples of the vertices, and yield each point that is better than all before.

    `few` makes the starts and `some`, with more vertices, the descents. A squared error of at most `perfect` ends them.
    `around`, `tries` and `random` are the sphere around the mesh, the number of starts, and the source of random
    numbers.
    """
    with text.stage("candidates", 0.0, 0.2):
        starts = Starts.of(few, around)
        first = starts.first(tries, random)
    points = list[Point]()
    for number, lights in enumerate(first):
        with text.stage("first steps", *_fraction(0.2, 0.5, number, len(first))):
            points.append(some.descend(some.at(lights), _SHORT, perfect))
        if points[-1].solution.squares <= min(point.solution.squares for point in points):
            yield points[-1]
        if points[-1].solution.squares <= perfect:
            return
    points.sort(key=lambda point: point.solution.squares)
    best = points[0]
    for number, point in enumerate(points[:_KEPT]):
        with text.stage("descents", *_fraction(0.5, 0.7, number, _KEPT)):
            long = some.narrowed(some.settled(point, _LONG, perfect), perfect)
        if long.solution.squares < best.solution.squares:
            yield (best := long)
        if best.solution.squares <= perfect:
            return
    last = -1  # the light whose exchange has helped last
    for number in range(_EXCHANGES * len(starts.moving)):
        k = starts.moving[number % len(starts.moving)]
        if k == last or len(starts.moving) < 2:
            return
        with text.stage("exchanges", *_fraction(0.7, 0.9, number, _EXCHANGES * len(starts.moving))):
            trial = some.descend(some.at(starts.exchanged(best.lights, k)), _SHORT, perfect)
            if trial.solution.squares < _PROMISING * best.solution.squares:
                trial = some.narrowed(some.settled(trial, _LONG, perfect), perfect)
        if trial.solution.squares < best.solution.squares * (1.0 - 1e-6):
            last = k
            yield (best := trial)
            if best.solution.squares <= perfect:
                return
        elif last < 0:
            last = k


def _fraction(begin: float, end: float, number: int, count: int) -> tuple[float, float]:
    """Return the progress at the beginning and end of step `number`.

    `count` equal steps lead from the progress `begin` to the progress `end`.
    """
    step = (end - begin) / count
    return begin + step * number, begin + step * (number + 1)
