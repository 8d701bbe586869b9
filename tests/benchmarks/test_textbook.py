"""The comparators of the benchmark compute the same thing as the evaluator; so their times can be compared."""

import numpy as np
from benchmarks.naive_block import naive_highlights
from benchmarks.textbook import measured_scene, shade, vertices

from pvphong.shading.evaluation import evaluate

COUNT = 40_000


def test_textbook_and_evaluator_agree():
    scene, material = measured_scene()
    points, normals = vertices(COUNT)
    result = evaluate(points, normals, scene, material, precision="float64", components=True)
    assert len(result.per_light) == 3
    assert np.count_nonzero(result.specular > 0.05) > 1000  # highlights are really met
    assert np.abs(result.rgb - shade(points, normals, scene, material)).max() < 1e-12


def test_the_naive_block_agrees_and_is_another_formula():
    scene, material = measured_scene()
    points, normals = vertices(COUNT)
    with naive_highlights():
        naive = evaluate(points, normals, scene, material, precision="float64", backend="numpy").rgb
    stable = evaluate(points, normals, scene, material, precision="float64", backend="numpy").rgb
    assert 0 < np.abs(naive - stable).max() < 1e-12
