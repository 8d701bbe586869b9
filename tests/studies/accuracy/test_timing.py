"""Time budgets, and runs measured in turns, with a clock that advances only in runs."""

from itertools import cycle

import numpy as np
import pytest

from pvphong.studies.accuracy import timing
from pvphong.studies.accuracy.timing import Clock, interleaved


class Watch:
    """Clock that runs advance themselves."""

    def __init__(self):
        self.now = 0.0
        self.calls = []

    def __call__(self):
        return self.now

    def run(self, name, *durations):
        """Return a run that takes these seconds, one after the other."""
        turns = cycle(durations)

        def running():
            self.calls.append(name)
            self.now += next(turns)

        return running


@pytest.fixture
def watch(monkeypatch):
    made = Watch()
    monkeypatch.setattr(timing, "perf_counter", made)
    return made


def test_a_part_of_a_budget_reports_to_the_whole(watch):
    said = []
    clock = Clock(10.0, lambda part, what: said.append((part, what)))
    part = clock.part(4.0)
    watch.now = 5.0
    part.say("it")
    assert said == [(0.5, "it")]
    assert (part.left, clock.left) == (-1.0, 5.0)


def test_runs_take_turns_and_stop_in_time(watch):
    said = []
    clock = Clock(1.0, lambda part, what: said.append((part, what)))
    runs = {"a": watch.run("a", 0.02), "b": watch.run("b", 0.03)}
    times = interleaved(runs, {"a": 0.02, "b": 0.03}, clock)
    np.testing.assert_allclose(times["a"], 0.02)
    np.testing.assert_allclose(times["b"], 0.03)
    assert 0.0 <= clock.left < 0.1
    rounds = [tuple(watch.calls[start : start + 2]) for start in range(0, len(watch.calls), 2)]
    assert set(rounds) == {("a", "b"), ("b", "a")}
    assert len(rounds) == len(times["a"]) >= 15
    assert said[0] == (0.0, "round 1")
    assert all(0.0 <= part <= 1.0 for part, _ in said)


def test_slow_runs_take_turns_less_often_and_evenly(watch):
    seconds = {"quick": 0.05, "quicker": 0.04, "slow": 0.5}
    clock = Clock(5.5)
    times = interleaved({name: watch.run(name, taken) for name, taken in seconds.items()}, seconds, clock)
    assert clock.left >= 0.0
    assert len(times["quick"]) == len(times["slow"])
    assert np.isfinite(times["quick"]).all()
    turns = np.flatnonzero(np.isfinite(times["slow"]))
    assert 5 <= len(turns) < len(times["quick"])
    assert turns[0] == 0
    assert np.ptp(np.diff(turns)) <= 1


def test_a_machine_that_slows_down_costs_rounds_and_not_the_budget(watch):
    runs = {"a": watch.run("a", 0.1, 0.4), "b": watch.run("b", 0.4)}
    clock = Clock(8.0)
    times = interleaved(runs, {"a": 0.1, "b": 0.1}, clock)
    assert 0.0 <= clock.left < 1.0
    assert len(times["a"]) < 40  # the number that would fit at the initial speed


def test_a_short_run_is_sampled_by_the_least_of_some_and_there_is_always_one_round(watch):
    times = interleaved({"a": watch.run("a", 0.05, 0.001)}, {"a": 1e-3}, Clock(1.0))
    np.testing.assert_allclose(times["a"], 0.001)
    assert len(interleaved({"a": watch.run("a", 1.0)}, {"a": 1.0}, Clock(1e-9), ["a"])["a"]) == 1


def rounds(watch, estimates, seconds, needed=()):
    """Return the number of turns of each run, if a sample is a single run."""
    runs = {name: watch.run(name, taken) for name, taken in estimates.items()}
    times = interleaved(runs, estimates, Clock(seconds), needed)
    return {name: np.count_nonzero(np.isfinite(taken)) for name, taken in times.items()}


def test_the_slowest_are_left_out_first_and_what_is_needed_never(watch):
    estimates = {"reference": 5.0, "slow": 2.0, "quick": 0.1, "quicker": 0.01}
    assert set(rounds(watch, estimates, 100.0, ["reference"])) == set(estimates)
    assert set(rounds(watch, estimates, 26.0, ["reference"])) == {"reference", "quick", "quicker"}
    assert set(rounds(watch, estimates, 1.0, ["reference"])) == {"reference"}


def test_rounds_fill_the_time_and_no_more(watch):
    estimates = {"quick": 0.1, "quicker": 0.05, "as quick": 0.1, "slow": 0.8, "slower": 1.0}
    found = rounds(watch, estimates, 20.0)
    assert found["quick"] == found["quicker"] == found["as quick"] > found["slow"] == found["slower"] >= 5
    assert 17.0 <= sum(found[name] * estimates[name] for name in estimates) <= 20.0
    assert 40 < rounds(watch, estimates, 100.0)["slow"] < 51 == rounds(watch, estimates, 100.0)["quick"]
    assert set(rounds(watch, estimates, 1e6).values()) == {51}
