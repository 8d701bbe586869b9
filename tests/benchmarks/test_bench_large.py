"""Benchmark of large surfaces: its city is one surface, and its schedule is correct in known cases."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("distributed")
pytest.importorskip("psutil")

from bench_large import Cluster, Task, piece_of_city, simulate

IDEAL = Cluster(4, storage=np.inf, link=np.inf, per_message=0.0, lives=np.inf)


def test_pieces_of_the_city_meet_in_the_same_points():
    left, right = piece_of_city(0, 0, 2), piece_of_city(1, 0, 2)
    common = {tuple(point) for point in left.points.tolist()} & {tuple(point) for point in right.points.tolist()}
    assert len(common) == 25
    assert left.points[:, 2].max() > 0.0


@pytest.mark.parametrize(
    ("change", "seconds", "busiest"),
    [
        ({}, 2 * 100 / 4, "workers"),
        ({"workers": 1000}, 2.0, "workers"),
        ({"per_message": 1.0}, 3 * 100 + 2, "scheduler"),
        ({"storage": 0.5}, 2 * 100 / 0.5, "storage"),
        ({"link": 0.5}, (2 + 2 / 0.5) * 100 / 4, "workers"),
    ],
)
def test_what_is_scarce_says_how_long_it_takes(change, seconds, busiest):
    run = simulate([Task("light", 2.0, 2.0, messages=3.0)], 100, replace(IDEAL, **change))
    assert run.seconds == pytest.approx(seconds, rel=0.03)
    assert max(run.busy, key=run.busy.get) == busiest or run.busy[busiest] > 0.9
    assert (run.deaths, run.redone) == (0, 0.0)


def test_what_a_worker_was_doing_and_held_is_done_again():
    border, light = Task("border", 1.0, 0.0, kept=True), Task("light", 10.0, 0.0)
    whole = simulate([border, light], 2000, IDEAL)
    dying = simulate([border, light], 2000, replace(IDEAL, lives=1000.0, restart=5.0))
    assert dying.deaths == pytest.approx(whole.seconds * 4 / 1000.0, rel=0.5)
    assert dying.redone > dying.deaths / 4000  # each death lost a task and borders
    assert whole.seconds < dying.seconds < 2 * whole.seconds
