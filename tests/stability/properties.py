"""What the property tests share. Each hunts in a few scenes in every run, in 100,000 by `pytest -m long`.

The 80-digit oracle judges a tenth as many: its arithmetic takes that much longer. Here is how they run, and which
arrays of a result must have the same bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from stability.evaluators import BACKENDS, EVALUATORS
from stability.hunting import FEW, MANY

from pvphong.shading.result import Shading

FLATTENING_IS_NO_FAILURE = pytest.mark.filterwarnings("ignore::pvphong.geometry.transform.SingularMatrixWarning")
"""Every other warning is one: NumPy's about overflow, division by zero and invalid operations."""

hunted = pytest.mark.parametrize(
    "examples", [pytest.param(FEW, id="few"), pytest.param(MANY, id="many", marks=pytest.mark.long)]
)
on_every_backend = pytest.mark.parametrize("backend", BACKENDS)
on_every_evaluator = pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)


def arrays(shading: Shading) -> dict[str, np.ndarray]:
    found = {name: getattr(shading, name) for name in Shading.__dataclass_fields__}
    return {name: array for name, array in found.items() if array is not None}


def assert_same_bits(got: Shading, expected: Shading, rows: Any = slice(None), of_expected: Any = slice(None)) -> None:
    for name, array in arrays(expected).items():
        ours, theirs = arrays(got)[name][..., rows, :], array[..., of_expected, :]
        assert ours.shape == theirs.shape, name
        bits = [np.ascontiguousarray(a).view(f"u{a.dtype.itemsize}") for a in (ours, theirs)]
        assert np.array_equal(*bits), (
            f"{name} is off by {np.abs(ours - theirs).max():.3g} of {np.abs(theirs).max():.3g}"
        )
