"""Errors, fronts, times and split triangles: the parts of the report on accuracy and time, on known numbers."""

import time
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from pvphong.accuracy_inside import Triangles, split
from pvphong.accuracy_rows import Errors, Row, Timing, triangle_errors, vertex_errors, with_fronts
from pvphong.accuracy_timing import Clock, fitting, interleaved


def row(name, seconds, error, kind="arithmetic", **fields):
    errors = {"arithmetic": None, "light_model": None, "interpolation": None}
    errors[kind.replace(" ", "_")] = Errors(error, error / 2, error / 1.1, 100)
    made = Row(name, kind, Timing(seconds, seconds, seconds, 3), **errors, points=100, backend="a", precision="b")
    return replace(made, **fields)


def test_vertex_errors_are_largest_rms_and_percentile():
    truth = np.zeros((100, 3))
    colors = np.zeros((100, 3), np.float32)
    colors[7] = (0.0, -0.5, 0.25)
    errors = vertex_errors(colors, truth)
    assert errors.largest == 0.5
    assert errors.rms == pytest.approx(np.sqrt((0.25 + 0.0625) / 300))
    assert errors.p99 == pytest.approx(0.005)  # between the last but one, 0, and the last, 0.5, at 98.01 of 99
    assert errors.count == 100


def test_triangle_errors_count_each_for_those_it_stands_for():
    errors = triangle_errors(np.array([0.5, 0.1]), np.array([1.0, 199.0]))
    assert errors.largest == 0.5
    assert errors.p99 == 0.1  # the large one is one in two hundred
    assert errors.rms == pytest.approx(np.sqrt((0.25 + 199 * 0.01) / 200))


def test_timing_has_quartiles():
    timing = Timing.of([5.0, 1.0, 2.0, 3.0, 4.0])
    assert timing == Timing(3.0, 2.0, 4.0, 5)
    assert timing.spread == pytest.approx(2 / 3)


def test_only_undominated_rows_are_on_the_front():
    rows = [row("slow", 3, 0.0), row("middle", 2, 0.1), row("worse", 2.5, 0.2), row("fast", 1, 0.3), row("tie", 2, 0.1)]
    marked = {r.name: r.on_front for r in with_fronts(rows)}
    assert marked == {"slow": True, "middle": True, "worse": False, "fast": True, "tie": True}


def test_kinds_are_not_held_against_each_other_but_a_model_is_against_the_exact_one():
    rows = [
        row("exact", 2, 1e-7),
        row("cheap", 1, 0.1, kind="light model"),
        row("dear", 3, 0.1, kind="light model"),
        row("dear elsewhere", 3, 0.01, kind="light model", backend="other"),
        row("inside", 9, 0.2, kind="interpolation"),
    ]
    marked = {r.name: r.on_front for r in with_fronts(rows)}
    assert marked == {"exact": True, "cheap": True, "dear": False, "dear elsewhere": True, "inside": True}


def test_the_decisive_error_adds_what_can_come_together():
    both = replace(row("both", 1, 0.1), light_model=Errors(0.2, 0.1, 0.1, 100))
    assert both.decisive_error == pytest.approx(0.3)
    assert both.error.largest == 0.1
    assert row("inside", 1, 0.2, kind="interpolation").decisive_error == 0.2


def test_runs_take_turns_and_stop_in_time():
    calls = []

    def run(name, seconds):
        def sleeping():
            calls.append(name)
            time.sleep(seconds)

        return sleeping

    said = []
    clock = Clock(0.5, lambda part, what: said.append((part, what)))
    runs = {"a": run("a", 0.02), "b": run("b", 0.03)}
    times = interleaved(runs, {"a": 0.02, "b": 0.03}, clock)
    assert clock.left > -0.1
    assert len(times["a"]) == len(times["b"]) >= 3
    assert times["b"].min() >= 0.03 > times["a"].min() >= 0.02
    for turn in range(len(times["a"])):
        assert set(calls[2 * turn : 2 * turn + 2]) == {"a", "b"}
    assert {tuple(calls[2 * turn : 2 * turn + 2]) for turn in range(len(times["a"]))} == {("a", "b"), ("b", "a")}
    assert said[0][1] == "round 1"
    assert all(0.0 <= part <= 1.0 for part, _ in said)


def test_a_short_run_is_sampled_by_the_least_of_some():
    count = 0

    def interrupted():
        nonlocal count
        count += 1
        if count % 2:
            time.sleep(0.05)

    times = interleaved({"a": interrupted}, {"a": 1e-3}, Clock(1.0, lambda *_: None))
    assert times["a"].max() < 0.05


def test_there_is_always_one_round():
    clock = Clock(1e-9, lambda *_: None)
    assert len(interleaved({"a": lambda: None}, {"a": 1.0}, clock)["a"]) == 1


def test_the_slowest_go_first_and_what_is_needed_stays():
    estimates = {"reference": 5.0, "slow": 2.0, "quick": 0.1, "quicker": 0.01}
    assert fitting(estimates, {"reference"}, 100.0) == set(estimates)
    assert fitting(estimates, {"reference"}, 26.0) == {"reference", "quick", "quicker"}
    assert fitting(estimates, {"reference"}, 1.0) == {"reference"}


def test_split_triangles_share_their_new_points_and_lie_where_they_did():
    mesh = pv.Sphere(theta_resolution=12, phi_resolution=10)
    start = Triangles(
        np.asarray(mesh.points), np.asarray(mesh.point_normals), mesh.regular_faces, np.arange(float(mesh.n_cells))
    )
    points, normals, corners, weights = split(start)
    fine = pv.PolyData.from_regular_faces(points, corners)
    assert fine.n_points == mesh.n_points + mesh.extract_all_edges().n_cells
    assert fine.n_cells == 4 * mesh.n_cells
    assert fine.is_manifold
    assert fine.n_open_edges == 0
    assert fine.area == pytest.approx(mesh.area, rel=1e-6)
    assert fine.volume == pytest.approx(mesh.volume, rel=1e-6)  # orientations are kept
    np.testing.assert_array_equal(points[: mesh.n_points], mesh.points)
    centers = (normals[corners].mean(axis=1)).reshape(-1, 4, 3).mean(axis=1)
    np.testing.assert_allclose(centers, mesh.point_normals[mesh.regular_faces].mean(axis=1), atol=1e-6)
    np.testing.assert_array_equal(weights, np.repeat(start.weights, 4))
