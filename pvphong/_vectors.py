"""Vectors as the columns of (3, n) float64 arrays: the layout of the evaluator's inner blocks.

Each column's result depends on that column alone, never on its neighbours: a column is rescued from
overflow or underflow by an exact power of two, chosen per column, and keeps the bits that it would have
had in a comfortable range. (A matrix product by BLAS would not give that, so none is used.)
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pvphong._types import BoolArray, Float64Array, FloatArray, Vector

# Squared lengths inside this range carry no underflow into their last bit and fit float32 as well.
_LEAST, _MOST = 2.0**-60, 2.0**60


def dot(a: FloatArray, b: FloatArray) -> Any:
    """Dot products of the columns of two (3, n) arrays, summed in the order x, y, z."""
    products = a * b
    total = products[0]
    total += products[1]
    total += products[2]
    return total


def square_of_cross(a: FloatArray, b: FloatArray) -> Any:
    """|a × b|² of the columns of two (3, n) arrays; exactly 0 where they are equal, or 2^k times as long."""
    total = _square_of_component(a, b, 1, 2)
    total += _square_of_component(a, b, 2, 0)
    total += _square_of_component(a, b, 0, 1)
    return total


def _square_of_component(a: FloatArray, b: FloatArray, i: int, j: int) -> Any:
    component = a[i] * b[j]
    component -= a[j] * b[i]
    component *= component
    return component


def columns(rows: FloatArray) -> Float64Array:
    """A (3, n) float64 contiguous copy of an (n, 3) array."""
    return rows.T.astype(np.float64, order="C")


def unit(w: Float64Array, out: Float64Array | None = None) -> tuple[Float64Array, Float64Array]:
    """Unit vectors and lengths of the columns; a zero or non-finite column gives zero and length 0.

    The unit vectors are written to `out`, which may be `w` itself, where it is given.
    """
    square, comfortable = _squares(w)
    if comfortable:
        length = np.sqrt(square, out=square)
        return np.multiply(w, 1.0 / length, out=out), length
    scaled, exponents = _rescue(w, square)
    length = np.sqrt(dot(scaled, scaled))
    with np.errstate(over="ignore", under="ignore"):
        return np.multiply(scaled, _inverse(length), out=out), np.ldexp(length, exponents)


def moderate(w: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Columns of the same directions and moderate lengths, and the inverses of those lengths.

    A column in the comfortable range is left as it is; any other is scaled by a power of two. A zero or
    non-finite column gives zero, and 0 for the inverse of its length.
    """
    square, comfortable = _squares(w)
    if comfortable:
        return w, 1.0 / np.sqrt(square)
    scaled = _rescue(w, square)[0]
    return scaled, _inverse(np.sqrt(dot(scaled, scaled)))


def _squares(w: Float64Array) -> tuple[Float64Array, bool]:
    """Squared lengths, and whether all of them can be used as they are."""
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):
        square = dot(w, w)
        comfortable = square.min(initial=1.0) >= _LEAST and square.max(initial=1.0) <= _MOST  # a NaN fails both
    return square, bool(comfortable)


def _rescue(w: Float64Array, square: Float64Array) -> tuple[Float64Array, NDArray[np.int32]]:
    """A copy whose uncomfortable columns have their largest entry in [0.5, 1), and the powers of two taken out."""
    rare: BoolArray = ~((square >= _LEAST) & (square <= _MOST))
    odd = w[:, rare]
    odd[:, ~np.isfinite(odd).all(axis=0)] = 0.0
    powers = np.frexp(np.abs(odd).max(axis=0))[1]
    scaled = w.copy()
    scaled[:, rare] = np.ldexp(odd, -powers)
    exponents = np.zeros(w.shape[1], dtype=np.int32)
    exponents[rare] = powers
    return scaled, exponents


def _inverse(length: Float64Array) -> Float64Array:
    return np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)


def towards(target: Vector, points: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Unit vectors from points to a target, and the distances.

    Parameters
    ----------
    target : tuple of float
        A position.
    points : ndarray
        Shape (3, n).

    Returns
    -------
    direction : ndarray
        Shape (3, n), unit; zero where the point is the target or is not finite.
    distance : ndarray
        Shape (n,); NaN where the point is not finite, and at most the largest float.
    """
    goal = np.array(target)[:, None]
    with np.errstate(over="ignore", invalid="ignore"):
        difference = goal - points
    direction, distance = unit(difference, out=difference)
    if not (distance.min(initial=1.0) > 0.0 and distance.max(initial=1.0) < np.inf):
        _mend(goal, points, direction, distance)
    return direction, distance


def _mend(goal: Float64Array, points: Float64Array, direction: Float64Array, distance: Float64Array) -> None:
    """Put right, in place, the columns of `towards` whose difference overflowed or is not finite."""
    with np.errstate(over="ignore", invalid="ignore"):
        overflowed = ~np.isfinite(goal - points).all(axis=0)
        direction[:, overflowed], quarter = unit(goal * 0.25 - points[:, overflowed] * 0.25)
        distance[overflowed] = quarter * 4.0
    np.minimum(distance, np.finfo(np.float64).max, out=distance)
    distance[~np.isfinite(points).all(axis=0)] = np.nan
