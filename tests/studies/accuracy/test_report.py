"""Errors, fronts, the choice among rows, sentences and tables, on known numbers."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.base import text
from pvphong.studies.accuracy.report import Tradeoff
from pvphong.studies.accuracy.result import Errors, LedgerEntry, PredictedBound, Row, Timing, with_fronts


def row(name, seconds, error, kind="arithmetic", is_peer=False, backend="a"):
    errors = {kind.replace(" ", "_"): Errors(error, error / 2, error / 1.1, 100)}
    time = Timing(seconds, 0.95 * seconds, 1.07 * seconds, 9)
    return Row(name, kind, backend, "b", 12345678, time, is_peer=is_peer, **errors)


def report(*rows, **fields):
    """Return a report of rows, given as arguments of `row`."""
    cloud = pv.PolyData(np.eye(3))
    given = {
        "tolerance": 1 / 255,
        "ledger": (LedgerEntry("local viewer", Timing(1e-3, 9e-4, 2e-3, 9), 0.2, True, "highlights of the lamp"),),
        "baseline": "float32 kernel",
        "predicted_bounds": (PredictedBound("lights", "glow: too weak to be seen, at most 0.0005", 0.0005, 0.0003),),
        "left_out": {},
        "facts": {"machine": "some processor, 2 cores"},
        "inside_errors": np.zeros(0),
        "inside_areas": np.zeros(0),
        "surface": cloud,
        "scene": ph.Scene(),
        "matrix": None,
        "reference_colors": np.zeros((3, 3)),
        "_lighting": {name: lambda: np.full((3, 3), 1e-8) for name, *_ in rows},
    }
    return Tradeoff(rows=with_fronts([row(*each) for each in rows]), **(given | fields))


# --- errors and fronts


def test_vertex_errors_are_largest_rms_and_percentile():
    truth = np.zeros((100, 3))
    colors = np.zeros((100, 3), np.float32)
    colors[7] = (0.0, -0.5, 0.25)
    errors = Errors.at_vertices(colors, truth)
    assert errors.largest == 0.5
    assert errors.rms == pytest.approx(np.sqrt((0.25 + 0.0625) / 300))
    assert errors.p99 == pytest.approx(0.005)  # at 98.01 of 99, between the second last, 0, and the last, 0.5
    assert errors.count == 100


def test_triangle_errors_count_by_area():
    errors = Errors.inside_triangles(np.array([0.5, 0.1, 0.3]), np.array([1.0, 194.0, 5.0]))
    assert errors.largest == 0.5
    assert errors.p99 == 0.3  # 0.5 has a share of 1/200, and those up to 0.1 less than 99 %
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
        row("dear, and off by less than the exact one is rounded", 4, 1e-9, kind="light model"),
        row("dear elsewhere", 3, 0.01, kind="light model", backend="other"),
        row("inside", 9, 0.2, kind="interpolation"),
    ]
    marked = {r.name: r.on_front for r in with_fronts(rows)}
    assert {name for name, is_on in marked.items() if is_on} == {"exact", "cheap", "dear elsewhere", "inside"}


def test_the_decisive_error_adds_what_can_come_together():
    both = replace(row("both", 1, 0.1), light_model=Errors(0.2, 0.1, 0.1, 100))
    assert both.decisive_error == pytest.approx(0.3)
    assert both.error.largest == 0.1
    assert row("inside", 1, 0.2, kind="interpolation").decisive_error == 0.2


# --- the choice


@pytest.mark.parametrize(
    ("cost", "noise"),
    [
        (Timing(5e-6, 4e-6, 6e-6, 20), False),
        (Timing(5e-6, -1e-6, 6e-6, 20), True),
        (Timing(-5e-6, -6e-6, -4e-6, 20), True),  # a negative cost is noise
        (Timing(5e-6, 4e-6, 6e-6, 2), True),  # two samples have no meaningful quartiles
    ],
)
def test_a_cost_is_noise_where_it_cannot_be_told_from_none(cost, noise):
    assert cost.is_noise is noise


LONGEST = "Blinn-Phong, shininess × 128"
SLOW, QUICK = ("float64 reference", 0.8, 0.0), ("float32 kernel", 0.02, 1e-7)


def test_a_cheaper_peer_within_the_tolerance_is_told_in_words_and_gets_no_star():
    rows = [SLOW, QUICK, ("textbook", 0.01, 1e-9, "arithmetic", True)]
    cheaper = report(*rows)
    assert cheaper.best().name == "float32 kernel"
    said = "Of the peers, textbook is faster at the vertices, 10 ms."
    assert said in cheaper.summary()
    assert said in cheaper.summary(with_next=True)
    (starred,) = [line for line in cheaper.explain().splitlines() if line.lstrip().startswith("★") and "kernel" in line]
    assert "textbook" not in starred
    for changed in (("textbook", 0.03, 1e-9, "arithmetic", True), ("textbook", 0.01, 0.1, "arithmetic", True)):
        assert "peers" not in str(report(*rows[:2], changed))


def test_where_nothing_of_ones_own_is_within_the_tolerance_a_peer_that_is_is_told():
    found = report(
        QUICK,
        ("as it is", 0.02, 0.5, "interpolation"),
        ("refined", 0.03, 0.4, "interpolation"),
        ("VTK per pixel", 0.9, 0.0, "interpolation", True),
    )
    assert found.summary()[2:] == [
        "  inside triangles: none; nearest refined, 30 ms, off by 0.4",
        "Of the peers, VTK per pixel is accurate enough inside triangles, 900 ms.",
    ]


def test_on_a_small_mesh_everything_is_cheap_and_on_a_large_one_it_is_not():
    small = report(("reference", 9e-4, 0.0), ("refined", 0.2, 0.0, "interpolation"))
    assert small.summary()[-1] == "The mesh is so small that everything is cheap: at most 900 µs at the vertices."
    assert "everything is cheap" not in str(report(SLOW, QUICK))
    peer = report(("reference", 9e-4, 0.0), ("textbook", 0.5, 0.0, "arithmetic", True))
    assert "everything is cheap" in str(peer)


def test_no_report_is_wider_than_80_columns_and_none_breaks_a_word(monkeypatch):
    found = report(
        (LONGEST, 0.0123, 1.23e-10, "light model"),
        ("textbook NumPy", 0.0103, 1.11e-10, "arithmetic", True),
        ("refined adaptively", 0.0123, 0.111, "interpolation"),
        ("VTK drawing lit array", 0.0123, 1.23e-10, "interpolation", True),
    )
    shown = found.explain(), str(found)
    assert all(len(line) <= 80 for part in shown for line in part.splitlines())
    assert len(shown[1].splitlines()) <= 5
    monkeypatch.setattr(text, "WIDTH", 1000)
    for narrow, wide in zip(shown, (found.explain(), str(found)), strict=True):
        assert sorted(narrow.replace("─", "").split()) == sorted(wide.replace("─", "").split())


def test_one_line_has_all_that_is_left_out_for_the_same_reason():
    found = report(SLOW, left_out={"a": "no time", "b": "no highlight", "c": "no time"})
    assert [line.split() for line in found.explain().splitlines()].count(["a,", "c", "no", "time"]) == 1
