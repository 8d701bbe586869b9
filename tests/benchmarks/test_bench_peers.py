"""The benchmark of other programs compares equal results at equal error, and names missing programs."""

import bench_peers
import bench_transport
import numpy as np
import pytest
import ways
from bench_peers import TEXTBOOK
from common import Cast
from ways import BLENDER, OURS, Row, Way


@pytest.fixture(autouse=True)
def _once(monkeypatch):
    monkeypatch.setattr(ways, "TURNS", 0)


def test_direct_light_is_the_textbooks_and_who_is_not_there_is_named():
    row = next(row for row in bench_peers.rows_of(None) if row.name == "64 lamps")
    row.ways = [way for way in row.ways if way.name in (OURS, TEXTBOOK, BLENDER)]
    row.measure((100, 400))
    ours, textbook, blender = row.ways
    assert ours.errors[0] < 1e-6
    assert textbook.errors[0] < 1e-6
    assert blender.obstacle.startswith("missing: no Python with bpy")
    assert set(ours.seconds) == {100, 400}


def test_ways_to_have_all_bounces_agree_and_what_is_missing_is_named():
    again = []
    row = bench_transport.row("All bounces", 64, None, bench_transport.PATHS, again=again)
    row.measure((100,))
    there = [way for way in row.ways if not way.obstacle]
    assert {OURS, "mesh.phong.truth"} <= {way.name for way in there}
    assert next(way for way in row.ways if way.name == BLENDER).obstacle.startswith("missing: no Python with bpy")
    assert min(again) > 0.0
    assert row.first.errors[2] < 0.1
    for way in there:
        assert way.errors[-1] < min(way.errors[0], 0.2), way.name


def casts(error, seconds_of_a_ray=1e-3):
    return lambda _job: lambda rays: Cast(rays * seconds_of_a_ray, np.full(4, 1.0 + error(rays)))


def test_times_are_compared_at_our_error_and_what_is_too_much_is_multiplied():
    several = [
        Way(OURS, casts(lambda rays: 1.0 / rays), (16, 64)),
        Way("slow", casts(lambda rays: 4.0 / rays), (16, 64), most=10),
        Way("black", casts(lambda _: -1.0), own_truth=64),
        Way("other", casts(lambda rays: 0.5 + 1.0 / rays), own_truth=4096),
    ]
    row = Row("job", lambda size: size, lambda _job: np.ones(4), several, judged_at=1)
    row.measure((10, 100))
    assert row.error == pytest.approx(1 / 64)
    assert several[0].seconds_to(row.error, 100) == pytest.approx(64e-3)
    assert several[1].seconds_to(row.error, 10) == pytest.approx(256e-3)
    assert several[1].seconds_to(row.error, 100) == pytest.approx(2.56)
    assert "black" in several[2].obstacle
    assert "another picture: 50% off" in several[3].obstacle
    told = [cell for cells in ways.cells(row, (10, 100)) for cell in cells]
    assert "1 / 1" in told
    assert "4 / 40" in told
