"""Time budgets and interleaved timing."""

from __future__ import annotations

import gc
import random
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from statistics import median
from time import perf_counter
from typing import TypeVar

import numpy as np

from pvphong.base.types import Float64Array

Run = Callable[[], object]
Result = TypeVar("Result")

FEWEST_REPEATS = 5
"""Smallest number of rounds for which a run is worth measuring."""

_MOST_REPEATS = 51

# A sample of a short run is the minimum of a few runs in a row, which take about _SAMPLE seconds. This discards runs
# that another process interrupts. A sample of a long run is a single run. If the budget is short, samples have fewer
# runs, to leave time for _ROUNDS_FIRST rounds.
_SAMPLE, _MOST_IN_A_ROW, _ROUNDS_FIRST = 3e-2, 7, 15

# A run is slow if it takes this many times as long as the median run.
_SLOW = 5.0


class Clock:
    """A time budget.

    Parameters
    ----------
    seconds : float
        Budget in seconds, counted from now.
    report : callable, optional
        Called with the spent fraction of the budget, from 0 to 1, and a description of the current step.
    """

    def __init__(self, seconds: float, report: Callable[[float, str], None] = lambda *_: None) -> None:
        self.seconds = seconds
        self.report = report
        self._start = perf_counter()

    @property
    def spent(self) -> float:
        """Seconds since the start."""
        return perf_counter() - self._start

    @property
    def left(self) -> float:
        """Seconds of the budget that remain; negative after its end."""
        return self.seconds - self.spent

    def say(self, what: str) -> None:
        """Report the current step, `what`, and the spent fraction of the budget."""
        self.report(min(self.spent / self.seconds, 1.0), what)

    def part(self, seconds: float) -> Clock:
        """Return a new clock for `seconds` of this clock's budget. This clock reports the steps of the new one."""
        return Clock(seconds, lambda _, what: self.say(what))


@contextmanager
def progress(clock: Clock, what: str) -> Iterator[None]:
    """Return a context in which stderr, if it is a terminal, shows a progress bar of a clock's budget.

    `what` is the text next to the bar.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(what, total=1.0)
        clock.report = lambda part, doing: bar.update(task, completed=part, description=f"{what}: {doing}")
        yield


def timed(run: Callable[[], Result]) -> tuple[Result, float]:
    """Run a function once. Return its result and the seconds that it took."""
    start = perf_counter()
    result = run()
    return result, perf_counter() - start


def interleaved(
    runs: Mapping[str, Run], estimates: Mapping[str, float], clock: Clock, needed: Collection[str] = ()
) -> dict[str, Float64Array]:
    """Time all runs in interleaved rounds, and return the seconds of every repeat.

    The order is shuffled in every round, so that a machine that becomes slower slows all runs alike. Slow runs take
    part in some rounds only, evenly spread, so that quick runs are repeated more often. There is at least one round;
    another round starts only if it fits the budget. There is no warm-up, so every run must have been called before.

    Parameters
    ----------
    runs : mapping of str to callable
        Runs to measure.
    estimates : mapping of str to float
        Estimated seconds of each run.
    clock : Clock
        The budget.
    needed : collection of str
        Names of runs that are always measured. Of the other runs, the slowest ones are left out until the rest can be
        repeated often enough.

    Returns
    -------
    dict of str to ndarray
        Name → seconds, shape (rounds,), for the runs that are not left out; NaN for rounds without the run.
    """
    kept = list(runs)
    for name in sorted(runs, key=estimates.__getitem__, reverse=True):
        if sum(estimates[one] for one in kept) * FEWEST_REPEATS <= clock.left:
            break
        if name not in needed:
            kept.remove(name)

    sample = min(_SAMPLE, max(clock.left, 0.0) / (_ROUNDS_FIRST * len(kept)))
    counts = {name: max(1, min(int(sample / max(estimates[name], 1e-9)), _MOST_IN_A_ROW)) for name in kept}
    costs = {name: counts[name] * estimates[name] for name in kept}
    turns = _turns(costs, clock.left)
    rounds, dice = max(turns.values()), random.Random(0)
    seconds: dict[str, list[float]] = {name: [] for name in kept}
    expected, start = 1e-9, clock.spent
    was_collecting = gc.isenabled()
    gc.disable()
    try:
        for number in range(rounds):
            order = [name for name in kept if number * turns[name] // rounds > (number - 1) * turns[name] // rounds]
            cost, slowness = sum(costs[name] for name in order), (clock.spent - start) / expected
            if number and clock.left < 1.2 * cost * slowness:
                break
            clock.say(f"round {number + 1}")
            dice.shuffle(order)
            for name in order:
                seconds[name].append(min(timed(runs[name])[1] for _ in range(counts[name])))
            for name in set(kept) - set(order):
                seconds[name].append(np.nan)
            expected += cost
    finally:
        if was_collecting:
            gc.enable()
    return {name: np.array(taken) for name, taken in seconds.items()}


def _turns(costs: Mapping[str, float], seconds: float) -> dict[str, int]:
    """Return the number of rounds in which each run takes part.

    `costs` has the seconds that each run takes, and `seconds` is the time for all rounds. Quick runs take part equally
    often. If time is short, slow runs take part less often.
    """
    limit = _SLOW * median(costs.values())
    slow = {name for name, cost in costs.items() if cost > limit}
    in_slow = sum(costs[name] for name in slow)
    in_quick = max(sum(costs.values()) - in_slow, 1e-9)
    often = int(max(FEWEST_REPEATS, min(_MOST_REPEATS, (seconds - FEWEST_REPEATS * in_slow) / in_quick)))
    seldom = int(max(FEWEST_REPEATS, min(often, (seconds - often * in_quick) / max(in_slow, 1e-9))))
    return {name: seldom if name in slow else often for name in costs}
