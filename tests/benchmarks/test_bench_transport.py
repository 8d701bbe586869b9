"""The benchmark of light that bounces compares like with like: its ways agree, and one that is missing is named."""

from benchmarks import bench_transport


def test_its_ways_agree_and_what_is_missing_is_named():
    _, rows, curves, missing, again = bench_transport.compare(3, None)
    assert "Blender's bake" in missing
    errors = {(name, rays): error for name, rays, _, error in rows}
    assert again > 0.0
    assert errors[bench_transport.OURS, 256] < 0.1
    for name, curve in curves.items():
        assert curve[-1][1] < curve[0][1], name
        assert curve[-1][1] < 0.2, name
