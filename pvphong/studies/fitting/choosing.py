"""The fewest lights of a list that meet a tolerance, greedily with refit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pvphong.base.types import IntArray
from pvphong.studies.fitting.linear import Normal, Problem, Solution, nonnegative, solve
from pvphong.studies.fitting.search import Point
from pvphong.studies.fitting.variation import Variation


class Chosen(NamedTuple):
    """The lights that were chosen, and the least-squares problem in which only these lights vary."""

    lights: tuple[int, ...]
    """Indices among the lights that vary."""
    problem: Problem
    """The problem with the unknowns of the chosen lights only."""
    solution: Solution
    """Solution of `problem`."""


def choose(point: Point, problem: Problem, varied: Sequence[Variation], most: int, allowed: float) -> Chosen:
    """Choose at most `most` lights greedily, and stop as soon as they meet the tolerance.

    Each step adds the light that gives the smallest squared error, with the unknowns of all chosen lights solved again.
    Then each chosen light is exchanged for another if this makes the error smaller. In the end, lights that the
    tolerance does not need are dropped.

    Parameters
    ----------
    point : Point
        Result of the search with all lights.
    problem : Problem
        Least-squares problem of all lights.
    varied : sequence of Variation
        All lights that vary.
    most : int
        Largest number of lights to choose.
    allowed : float
        Squared error that is small enough; no more lights are added then.
    """
    ends = np.cumsum([len(one.unknowns) for one in varied])
    of_light = [np.arange(end - len(one.unknowns), end) for one, end in zip(varied, ends.tolist(), strict=True)]
    whole = point.solution
    normal = Normal(whole.normal.matrix, whole.normal.right + whole.normal.matrix @ whole.x)
    total = whole.squares + float(whole.x @ (whole.normal.right + normal.right))  # squares with all unknowns 0

    def squares(chosen: Sequence[int]) -> float:
        used = np.concatenate([of_light[k] for k in chosen])
        part = Normal(normal.matrix[np.ix_(used, used)], normal.right[used])
        x = nonnegative(part)
        return total + float(x @ (part.matrix @ x - 2.0 * part.right))

    chosen: list[int] = []
    best: Chosen | None = None
    while len(chosen) < min(most, len(varied)):
        others = [k for k in range(len(varied)) if k not in chosen]
        chosen.append(min(others, key=lambda k: squares([*chosen, k])))
        for place in range(len(chosen)):
            others = [k for k in range(len(varied)) if k not in chosen]
            kept = chosen[:place] + chosen[place + 1 :]
            rival = min(others, key=lambda k: squares([*kept, k]), default=None)
            if rival is not None and squares([*kept, rival]) < squares(chosen) * (1.0 - 1e-9):
                chosen = [*kept, rival]
        best = _solved(problem, tuple(sorted(chosen)), of_light)
        if best.solution.squares <= allowed:
            break
    assert best is not None
    return _thinned(problem, best, of_light, allowed)


def _thinned(problem: Problem, found: Chosen, of_light: Sequence[IntArray], allowed: float) -> Chosen:
    """Return `found` without lights that are dark, and without lights that the tolerance does not need.

    Row k of `of_light` has the indices of light k's unknowns. `allowed` is the largest squared error. `problem` is that
    of all lights.
    """
    ends = np.cumsum([len(of_light[k]) for k in found.lights])
    unknowns = np.split(found.solution.x, ends[:-1])
    lit = tuple(k for k, x in zip(found.lights, unknowns, strict=True) if x.any())
    if lit and lit != found.lights:
        return _thinned(problem, _solved(problem, lit, of_light), of_light, allowed)
    for k in found.lights if found.solution.squares <= allowed else ():
        fewer = tuple(other for other in found.lights if other != k)
        if fewer:
            trial = _solved(problem, fewer, of_light)
            if trial.solution.squares <= allowed:
                return _thinned(problem, trial, of_light, allowed)
    return found


def _solved(problem: Problem, chosen: tuple[int, ...], of_light: Sequence[IntArray]) -> Chosen:
    used = np.concatenate([of_light[k] for k in chosen])
    part = replace(problem, columns=[problem.columns[k] for k in used])
    return Chosen(chosen, part, solve(part))
