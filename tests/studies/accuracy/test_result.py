"""Errors, times and fronts of a report on accuracy and time, on known numbers."""

from dataclasses import replace

import numpy as np
import pytest

from pvphong.studies.accuracy.result import Errors, Row, Timing, with_fronts


def row(name, seconds, error, kind="arithmetic", **fields):
    errors = {kind.replace(" ", "_"): Errors(error, error / 2, error / 1.1, 100)}
    made = Row(name, kind, backend="a", precision="b", points=100, time=Timing(seconds, seconds, seconds, 3), **errors)
    return replace(made, **fields)


def test_vertex_errors_are_largest_rms_and_percentile():
    truth = np.zeros((100, 3))
    colors = np.zeros((100, 3), np.float32)
    colors[7] = (0.0, -0.5, 0.25)
    errors = Errors.at_vertices(colors, truth)
    assert errors.largest == 0.5
    assert errors.rms == pytest.approx(np.sqrt((0.25 + 0.0625) / 300))
    assert errors.p99 == pytest.approx(0.005)  # between the last but one, 0, and the last, 0.5, at 98.01 of 99
    assert errors.count == 100


def test_triangle_errors_count_by_area():
    errors = Errors.inside_triangles(np.array([0.5, 0.1, 0.3]), np.array([1.0, 194.0, 5.0]))
    assert errors.largest == 0.5
    assert errors.p99 == 0.3  # the one at 0.5 is one part in two hundred, and the one at 0.1 less than 99 in a hundred
    assert errors.rms == pytest.approx(np.sqrt((0.25 + 194 * 0.01 + 5 * 0.09) / 200))
    assert errors.count == 3


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
