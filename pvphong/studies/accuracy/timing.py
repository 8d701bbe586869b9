"""Time budgets, and runs that are measured in turns."""

from __future__ import annotations

import gc
import random
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from statistics import median
from time import perf_counter
from typing import TypeVar

import numpy as np

from pvphong.base.types import Float64Array

Run = Callable[[], object]
Report = Callable[[float, str], None]
Result = TypeVar("Result")

FEWEST_REPEATS = 5
"""Rounds without which a run is not worth measuring."""

_MOST_REPEATS = 51

# A sample is the least of a few runs in a row, as many as take this many seconds: another process that interrupts
# one of them does not count. Long runs are taken as they are. Where a budget is short, rounds go first.
_SAMPLE, _MOST_IN_A_ROW, _ROUNDS_FIRST = 3e-2, 7, 15

# A run is slow that takes this many times as long as the middle one.
_SLOW = 5.0


class Clock:
    """A time budget.

    Parameters
    ----------
    seconds : float
        From now.
    report : callable, optional
        Told how much of the budget is spent, from 0 to 1, and what is being done.
    """

    def __init__(self, seconds: float, report: Report = lambda *_: None) -> None:
        self.seconds = seconds
        self.report = report
        self._start = perf_counter()

    @property
    def spent(self) -> float:
        """Seconds since the start."""
        return perf_counter() - self._start

    @property
    def left(self) -> float:
        """Seconds that are left; negative when it is over."""
        return self.seconds - self.spent

    def say(self, what: str) -> None:
        """Report what is being done."""
        self.report(min(self.spent / self.seconds, 1.0), what)

    def part(self, seconds: float) -> Clock:
        """A budget inside this one, which reports to it."""
        return Clock(seconds, lambda _, what: self.say(what))


def timed(run: Callable[[], Result]) -> tuple[Result, float]:
    """What a single run gives, and its seconds."""
    start = perf_counter()
    result = run()
    return result, perf_counter() - start


def fitting(estimates: Mapping[str, float], needed: set[str], seconds: float) -> set[str]:
    """The names of the runs that can be repeated often enough in some seconds; the slowest go first.

    Parameters
    ----------
    estimates : mapping of str to float
        Seconds of each run.
    needed : set of str
        Names that stay, whatever they take.
    seconds : float
        What there is.
    """
    kept = dict(estimates)
    for name in sorted(estimates, key=estimates.__getitem__, reverse=True):
        if sum(kept.values()) * FEWEST_REPEATS <= seconds:
            break
        if name not in needed:
            del kept[name]
    return set(kept)


def interleaved(runs: Mapping[str, Run], estimates: Mapping[str, float], clock: Clock) -> dict[str, Float64Array]:
    """Seconds of every repeat of every run.

    All runs take turns, in an order that is shuffled for every round, so that a machine that drifts slows all of
    them alike. Slow ones take a turn in some rounds only, evenly spread, so that the others are repeated more often.
    Rounds end before one would outlast the clock; there is always one. Every run must have run before: this does not
    warm anything up.

    Parameters
    ----------
    runs : mapping of str to callable
        What is measured.
    estimates : mapping of str to float
        About how many seconds each takes.
    clock : Clock
        The budget.

    Returns
    -------
    dict of str to ndarray
        Shape (rounds,); NaN where a run took no turn.
    """
    sample = min(_SAMPLE, max(clock.left, 0.0) / (_ROUNDS_FIRST * len(runs)))
    counts = {name: max(1, min(int(sample / max(estimates[name], 1e-9)), _MOST_IN_A_ROW)) for name in runs}
    costs = {name: counts[name] * estimates[name] for name in runs}
    turns = repeats(costs, clock.left)
    rounds, dice = max(turns.values()), random.Random(0)
    seconds: dict[str, list[float]] = {name: [] for name in runs}
    expected, start = 1e-9, clock.spent
    with _without_garbage_collection():
        for number in range(rounds):
            order = [name for name in runs if number * turns[name] // rounds > (number - 1) * turns[name] // rounds]
            cost, slowness = sum(costs[name] for name in order), (clock.spent - start) / expected
            if number and clock.left < 1.2 * cost * slowness:
                break
            clock.say(f"round {number + 1}")
            dice.shuffle(order)
            for name in order:
                seconds[name].append(min(timed(runs[name])[1] for _ in range(counts[name])))
            for name in runs.keys() - set(order):
                seconds[name].append(np.nan)
            expected += cost
    return {name: np.array(taken) for name, taken in seconds.items()}


def repeats(costs: Mapping[str, float], seconds: float) -> dict[str, int]:
    """How often each run takes a turn: the quick ones equally often, the slow ones less often where time is short.

    Parameters
    ----------
    costs : mapping of str to float
        Seconds of a turn of each run.
    seconds : float
        What there is.
    """
    limit = _SLOW * median(costs.values())
    slow = {name for name, cost in costs.items() if cost > limit}
    in_slow = sum(costs[name] for name in slow)
    in_quick = max(sum(costs.values()) - in_slow, 1e-9)
    often = int(max(FEWEST_REPEATS, min(_MOST_REPEATS, (seconds - FEWEST_REPEATS * in_slow) / in_quick)))
    seldom = int(max(FEWEST_REPEATS, min(often, (seconds - often * in_quick) / max(in_slow, 1e-9))))
    return {name: seldom if name in slow else often for name in costs}


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
