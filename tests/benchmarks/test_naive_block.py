"""The comparisons of the benchmark compute the same colours as the evaluator, so that their times are comparable."""

import numpy as np
import pytest
from bench_reference import naive_formulas, scenes
from common import vertices

from pvphong.shading.evaluation import evaluate

COUNT = 40_000


@pytest.mark.parametrize("name", scenes())
def test_naive_formulas_agree_and_are_others(name):
    how = {"precision": "float64", "backend": "numpy"}
    stable = evaluate(*vertices(COUNT), *scenes()[name], **how).rgb
    with naive_formulas():
        naive = evaluate(*vertices(COUNT), *scenes()[name], **how).rgb
    assert 0 < np.abs(naive - stable).max() < 1e-12
