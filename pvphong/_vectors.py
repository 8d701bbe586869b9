"""Vectors as the columns of (3, n) float64 arrays: the layout of the evaluator's inner blocks.

Each column's result depends on that column alone, never on its neighbours: a column is rescued from
overflow or underflow by an exact power of two, chosen per column, and keeps the bits that it would have
had in a comfortable range. (A matrix product by BLAS would not give that, so none is used.)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pvphong._types import BoolArray, Float64Array, FloatArray, Vector

# Squared lengths inside this range carry no underflow into their last bit and fit float32 as well.
_LEAST, _MOST = 2.0**-60, 2.0**60


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Dot products of the columns of two (3, n) arrays, summed in the order x, y, z."""
    products = a * b
    total: FloatArray = products[0]
    total += products[1]
    total += products[2]
    return total


def columns(rows: FloatArray) -> Float64Array:
    """A (3, n) float64 contiguous copy of an (n, 3) array."""
    return rows.T.astype(np.float64, order="C")


def linear(matrix: Float64Array, w: Float64Array) -> Float64Array:
    """The columns of `w` (3, n) multiplied by a (3, 3) matrix."""
    return np.array([dot(row[:, None], w) for row in matrix])


def rescale(w: Float64Array) -> tuple[Float64Array, NDArray[np.int32] | None]:
    """Columns of moderate length, each scaled by a power of two where it has to be.

    Parameters
    ----------
    w : ndarray
        Shape (3, n).

    Returns
    -------
    scaled : ndarray
        Shape (3, n): `w` itself where every column is comfortable; else a copy in which the other
        columns are scaled so that their largest entry lies in [0.5, 1). Zero columns and columns with
        a NaN or an infinity become zero.
    exponents : ndarray or None
        Shape (n,): ``ldexp(scaled, exponents)`` gives `w` back; None where nothing was scaled.
    """
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):
        square = dot(w, w)
        if square.size == 0 or (square.min() >= _LEAST and square.max() <= _MOST):  # a NaN fails both
            return w, None
        rare: BoolArray = ~((square >= _LEAST) & (square <= _MOST))
    odd = w[:, rare]
    odd[:, ~np.isfinite(odd).all(axis=0)] = 0.0
    powers = np.frexp(np.abs(odd).max(axis=0))[1]
    scaled = w.copy()
    scaled[:, rare] = np.ldexp(odd, -powers)
    exponents = np.zeros(w.shape[1], dtype=np.int32)
    exponents[rare] = powers
    return scaled, exponents


def unit(w: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Unit vectors and lengths of the columns; a zero or non-finite column gives zero and length 0."""
    scaled, exponents = rescale(w)
    length = np.sqrt(dot(scaled, scaled))
    inverse = np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)
    if exponents is not None:
        with np.errstate(over="ignore", under="ignore"):
            length = np.ldexp(length, exponents)
    return scaled * inverse, length


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
    direction, distance = unit(difference)
    if not distance.all() or np.isinf(distance.max(initial=0.0)):
        _mend(goal, points, difference, direction, distance)
    return direction, distance


def _mend(
    goal: Float64Array, points: Float64Array, difference: Float64Array, direction: Float64Array, distance: Float64Array
) -> None:
    """Put right, in place, the columns of `towards` that overflowed or that are not finite."""
    overflowed = ~np.isfinite(difference).all(axis=0)
    direction[:, overflowed], quarter = unit(goal * 0.25 - points[:, overflowed] * 0.25)
    with np.errstate(over="ignore"):
        distance[overflowed] = quarter * 4.0
    np.minimum(distance, np.finfo(np.float64).max, out=distance)
    distance[~np.isfinite(points).all(axis=0)] = np.nan
