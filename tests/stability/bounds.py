"""Assertions on measurements: a bound for each sample, or identical bits. A failure reports the worst sample."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

U = 2.0**-53
"""Half a unit in the last place of 1.0 in float64."""

V = 2.0**-24
"""The same in float32."""


def assert_within(row: str, observed: ArrayLike, bound: ArrayLike) -> None:
    """Assert that errors of a row of the catalogue are within a common bound or one each; a bound may be 0."""
    errors, bounds = (np.ravel(each) for each in np.broadcast_arrays(np.asarray(observed, float), bound))
    assert len(errors), f"row {row}: nothing was measured"
    ratios = np.divide(errors, bounds, out=np.where(errors == 0.0, 0.0, np.inf), where=bounds > 0.0)
    ratios[np.isnan(ratios)] = np.inf
    worst = int(np.argmax(ratios))
    assert ratios[worst] <= 1.0, (
        f"row {row}: {np.count_nonzero(ratios > 1.0)} of {len(errors)} samples over the bound; the worst, sample "
        f"{worst}, has {errors[worst]:.3g} where {bounds[worst]:.3g} is allowed (ratio {ratios[worst]:.3g})"
    )


def assert_bits(row: str, observed: ArrayLike, expected: ArrayLike) -> None:
    """Assert that two arrays of numbers have identical bits."""
    a, b = np.asarray(observed), np.asarray(expected)
    assert (a.shape, a.dtype) == (b.shape, b.dtype), f"row {row}: {a.dtype} {a.shape} is no {b.dtype} {b.shape}"
    assert a.size, f"row {row}: nothing was compared"
    bits = [np.frombuffer(array.tobytes(), np.uint8).reshape(a.size, a.itemsize) for array in (a, b)]
    different = np.count_nonzero((bits[0] != bits[1]).any(axis=1))
    assert not different, f"row {row}: {different} of {a.size} numbers differ"
