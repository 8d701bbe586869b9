"""The comparators of the benchmark compute the same thing as the evaluator; so their times can be compared."""

import numpy as np
from common import measured_scene, vertices
from naive_block import naive_highlights

from pvphong.shading.evaluation import evaluate

COUNT = 40_000


def test_the_naive_block_agrees_and_is_another_formula():
    scene, material = measured_scene()
    points, normals = vertices(COUNT)
    with naive_highlights():
        naive = evaluate(points, normals, scene, material, precision="float64", backend="numpy").rgb
    stable = evaluate(points, normals, scene, material, precision="float64", backend="numpy").rgb
    assert 0 < np.abs(naive - stable).max() < 1e-12
