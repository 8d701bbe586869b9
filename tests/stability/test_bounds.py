from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from stability.bounds import assert_bits, assert_within


@pytest.mark.parametrize(
    ("observed", "bound", "message"),
    [
        ([1.0, 5.0, 2.0], 4.0, "1 of 3 samples over the bound; the worst, sample 1, has 5 where 4"),
        ([math.nan, 0.0], 1.0, "1 of 2 samples"),
        ([1e-300, 0.0], 0.0, "1 of 2 samples"),
        (math.nan, 0.0, "1 of 1 samples"),
        ([], 1.0, "nothing was measured"),
    ],
)
def test_what_is_over_its_bound_fails(observed: Any, bound: float, message: str) -> None:
    with pytest.raises(AssertionError, match=message):
        assert_within("9", observed, bound)
    assert_within("9", [0.0, 2.0, -0.0], [0.0, 2.0, 1.0])


@pytest.mark.parametrize(
    ("observed", "message"),
    [([0.0, 1.0], "1 of 2 numbers differ"), (np.float32([-0.0, 1.0]), "is no float64"), ([-0.0], r"\(1,\) is no")],
)
def test_other_bits_fail(observed: Any, message: str) -> None:
    with pytest.raises(AssertionError, match=message):
        assert_bits("55", observed, [-0.0, 1.0])
    assert_bits("55", [0.0, math.nan], [0.0, math.nan])
