"""Time budgets, and runs that are measured in turns."""

from __future__ import annotations

import gc
import random
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import numpy as np

from pvphong._types import Float64Array

Run = Callable[[], object]
Report = Callable[[float, str], None]

_MOST_REPEATS = 51
_FEWEST_REPEATS = 5

# A sample is the least of a few runs in a row, as many as take this many seconds: another process that interrupts
# one of them does not count. Long runs are taken as they are.
_SAMPLE, _MOST_IN_A_ROW = 3e-2, 7


class Clock:
    """A time budget.

    Parameters
    ----------
    seconds : float
        From now.
    report : callable
        Told how much of the budget is spent, from 0 to 1, and what is being done.
    """

    def __init__(self, seconds: float, report: Report) -> None:
        self.seconds = seconds
        self._start = time.perf_counter()
        self._report = report

    @property
    def spent(self) -> float:
        """Seconds since the start."""
        return time.perf_counter() - self._start

    @property
    def left(self) -> float:
        """Seconds that are left; negative when it is over."""
        return self.seconds - self.spent

    def say(self, what: str) -> None:
        """Report what is being done."""
        self._report(min(self.spent / self.seconds, 1.0), what)


def once(run: Callable[[], object]) -> float:
    """Seconds of a single run."""
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


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
        if sum(kept.values()) * _FEWEST_REPEATS <= seconds:
            break
        if name not in needed:
            del kept[name]
    return set(kept)


def interleaved(runs: Mapping[str, Run], estimates: Mapping[str, float], clock: Clock) -> dict[str, Float64Array]:
    """Seconds of every repeat of every run.

    All runs take turns, in an order that is shuffled for every round, so that a machine that drifts slows all of
    them alike. Rounds end before one would outlast the clock; there is always one. Every run must have run
    before: this does not warm anything up.

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
        Shape (repeats,), in the order of the rounds.
    """
    counts = {name: max(1, min(int(_SAMPLE / max(estimates[name], 1e-9)), _MOST_IN_A_ROW)) for name in runs}
    seconds: dict[str, list[float]] = {name: [] for name in runs}
    order, dice = list(runs), random.Random(0)
    longest = 0.0
    with _without_garbage_collection():
        for turn in range(_MOST_REPEATS):
            if turn and clock.left < 1.1 * longest:
                break
            clock.say(f"round {turn + 1}")
            start = time.perf_counter()
            dice.shuffle(order)
            for name in order:
                seconds[name].append(min(once(runs[name]) for _ in range(counts[name])))
            longest = max(longest, time.perf_counter() - start)
    return {name: np.array(taken) for name, taken in seconds.items()}


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
