from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from stability.bounds import assert_bits, assert_within


@pytest.mark.parametrize(
    ("judge", "observed", "against", "message"),
    [
        (assert_within, [1.0, 5.0, 2.0], 4.0, "1 of 3 samples over the bound; the worst, sample 1, has 5 where 4"),
        (assert_within, [math.nan, 0.0], 1.0, "1 of 2 samples"),
        (assert_within, [1e-300, 0.0], 0.0, "1 of 2 samples"),
        (assert_within, [], 1.0, "nothing was measured"),
        (assert_bits, [0.0, 1.0], [-0.0, 1.0], "1 of 2 numbers differ"),
        (assert_bits, np.float32([-0.0, 1.0]), [-0.0, 1.0], "is no float64"),
        (assert_bits, [-0.0], [-0.0, 1.0], r"\(1,\) is no"),
    ],
)
def test_what_is_over_its_bound_or_has_other_bits_fails(judge: Any, observed: Any, against: Any, message: str) -> None:
    with pytest.raises(AssertionError, match=message):
        judge("9", observed, against)
    assert_within("9", [0.0, 2.0, -0.0], [0.0, 2.0, 1.0])
    assert_bits("9", [0.0, math.nan], [0.0, math.nan])
