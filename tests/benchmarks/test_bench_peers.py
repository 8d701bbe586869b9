"""The benchmark beside other programs compares like with like: what is missing is named, and times are at one error."""

import numpy as np
import pytest
from benchmarks import bench_peers
from benchmarks.bench_peers import OURS, TEXTBOOK, Row, Way
from benchmarks.common import Cast


def test_direct_light_is_the_textbooks_and_who_is_not_there_is_named():
    row = next(row for row in bench_peers.rows_of(None) if row.name == "64 lamps")
    row.ways = [way for way in row.ways if way.name in (OURS, TEXTBOOK, bench_peers.BLENDER)]
    row.measure((100, 400))
    ours, textbook, blender = row.ways
    assert ours.errors[0] < 1e-6
    assert textbook.errors[0] < 1e-6
    assert blender.obstacle.startswith("missing: no Python with bpy")
    assert set(ours.seconds) == {100, 400}


def casts(error, seconds_of_a_ray=1e-3):
    return lambda _job: lambda rays: Cast(rays * seconds_of_a_ray, np.full(4, 1.0 + error(rays)))


def test_times_are_compared_at_our_error_and_what_is_too_much_is_multiplied():
    ways = [
        Way(OURS, casts(lambda rays: 1.0 / rays), (16, 64)),
        Way("slow", casts(lambda rays: 4.0 / rays), (16, 64), most=10),
        Way("black", casts(lambda _: -1.0), own_truth=64),
        Way("other", casts(lambda rays: 0.5 + 1.0 / rays), own_truth=4096),
    ]
    row = Row("job", lambda size: size, lambda _job: np.ones(4), ways, judged_at=1)
    row.measure((10, 100))
    assert row.error == pytest.approx(1 / 64)
    assert ways[0].seconds_to(row.error, 100) == pytest.approx(64e-3)
    assert ways[1].seconds_to(row.error, 10) == pytest.approx(256e-3)
    assert ways[1].seconds_to(row.error, 100) == pytest.approx(2.56)
    assert "black" in ways[2].obstacle
    assert "another picture: 50% off" in ways[3].obstacle
    told = [str(cell) for column in bench_peers.shown([row], (10, 100)).columns for cell in column.cells]
    assert "1 / 1" in told
    assert "4 / 40" in told
