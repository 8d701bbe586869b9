"""What the stability tests measured against their bounds, kept for a summary after the run."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

U = 2.0**-53
"""Half a unit in the last place of 1.0 in float64."""

V = 2.0**-24
"""The same in float32."""


@dataclass(frozen=True)
class Entry:
    """The worst of one measurement: `ratio` is observed / bound, and must not exceed 1.

    Where nothing is measured `bound` is a promise in words, such as ``"raises ValueError"``, and `ratio` None if it
    was kept.
    """

    row: str
    evaluator: str
    precision: str
    observed: float
    bound: float | str
    ratio: float | None


entries: list[Entry] = []


@contextmanager
def held(promise: str, row: str, evaluator: str, precision: str = "any") -> Iterator[None]:
    """Note whether the block, which tests a promise that has no measure, passed; its failure goes on."""
    try:
        yield
    except BaseException:
        entries.append(Entry(row, evaluator, precision, math.nan, promise, math.inf))
        raise
    entries.append(Entry(row, evaluator, precision, math.nan, promise, None))


def same_bits(row: str, evaluator: str, precision: str, observed: ArrayLike, expected: ArrayLike) -> None:
    """Note how many numbers of two arrays differ in a bit, and fail if one does."""
    a, b = np.asarray(observed), np.asarray(expected)
    assert (a.shape, a.dtype) == (b.shape, b.dtype), f"row {row}: {a.dtype} {a.shape} is no {b.dtype} {b.shape}"
    assert a.size, f"row {row}: nothing was compared"
    bits = [np.frombuffer(array.tobytes(), np.uint8).reshape(array.size, array.itemsize) for array in (a, b)]
    different = int(np.count_nonzero((bits[0] != bits[1]).any(axis=1)))
    entries.append(Entry(row, evaluator, precision, different, "same bits", math.inf if different else 0.0))
    assert not different, f"row {row}, {evaluator} in {precision}: {different} of {a.size} numbers differ"


def record(row: str, evaluator: str, precision: str, observed: ArrayLike, bound: ArrayLike) -> None:
    """Note the worst of observed / bound, and fail if it exceeds 1.

    Parameters
    ----------
    row : str
        The row of the catalogue, and the size if there are several: ``"3 c=1e12"``.
    evaluator, precision : str
        What was measured, and in which arithmetic.
    observed, bound : array_like
        One error, or one per sample; a bound of 0 allows an error of 0 only.
    """
    errors, bounds = (
        np.ravel(values) for values in np.broadcast_arrays(np.asarray(observed, float), np.asarray(bound, float))
    )
    assert len(errors), f"row {row}: nothing was measured"
    exact = (errors == 0.0) & (bounds >= 0.0)
    ratios = np.divide(errors, bounds, out=np.full(len(errors), np.inf), where=bounds > 0.0)
    ratios[exact] = 0.0
    ratios[np.isnan(ratios)] = np.inf
    worst = int(np.argmax(ratios))
    entry = Entry(row, evaluator, precision, float(errors[worst]), float(bounds[worst]), float(ratios[worst]))
    entries.append(entry)
    over = np.count_nonzero(ratios > 1.0)
    assert not over, (
        f"row {row}, {evaluator} in {precision}: {over} of {len(errors)} samples over the bound; the worst, "
        f"sample {worst}, has {entry.observed:.3g} where {entry.bound:.3g} is allowed (ratio {entry.ratio:.3g})"
    )
