"""Vectors as the columns of (3, n) float64 arrays: the layout of the evaluator's inner blocks.

Each column's result depends on that column alone, never on its neighbours: a column is rescued from
overflow or underflow by an exact power of two, chosen per column, and keeps the bits that it would have
had in a comfortable range. (A matrix product by BLAS would not give that, so none is used.)
"""

from __future__ import annotations

import math
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import BoolArray, Float64Array, FloatArray, Vector, VectorLike

Real = TypeVar("Real", bound=np.floating[Any])

# Squared lengths inside this range carry no underflow into their last bit and fit float32 as well.
_LEAST, _MOST = 2.0**-60, 2.0**60


def dot(a: FloatArray, b: FloatArray) -> Any:
    """Dot products of the columns of two (3, n) arrays, summed in the order x, y, z."""
    products = a * b
    total = products[0]
    total += products[1]
    total += products[2]
    return total


def is_direction(vectors: FloatArray) -> BoolArray:
    """Shape (n,): which columns of a (3, n) array are directions, finite and not zero."""
    x, y, z = vectors  # row by row it takes a tenth of the time
    return np.asarray(np.isfinite(x) & np.isfinite(y) & np.isfinite(z) & ((x != 0.0) | (y != 0.0) | (z != 0.0)))


def cross(a: NDArray[Real], b: NDArray[Real]) -> NDArray[Real]:
    """Cross products of the columns of two (3, ...) arrays."""
    result = np.empty(np.broadcast_shapes(a.shape, b.shape), a.dtype)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[j], b[k], out=result[i])
        result[i] -= a[k] * b[j]
    return result


def columns(rows: FloatArray) -> Float64Array:
    """A (3, n) float64 contiguous copy of an (n, 3) array."""
    return rows.T.astype(np.float64, order="C")


def unit_vector(vector: VectorLike) -> Vector:
    """A single vector, finite and not zero, made as long as 1: the bits of `unit` without the cost of arrays."""
    (x, y, z), _ = moderate_vector(vector)
    length = math.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length


def moderate_vector(vector: VectorLike) -> tuple[Vector, float]:
    """A single vector, finite and not zero, times a power of two that makes its length moderate; and 1/length."""
    scale = -math.frexp(max(map(abs, vector)))[1]
    x, y, z = (math.ldexp(component, scale) for component in vector)
    return (x, y, z), 1.0 / math.sqrt(x * x + y * y + z * z)


def angle_between(a: VectorLike, b: VectorLike) -> float:
    """Between two unit vectors, in radians; right to 1e-7, for arc cosines lose half the digits near 0 and π."""
    return math.acos(max(-1.0, min(1.0, a[0] * b[0] + a[1] * b[1] + a[2] * b[2])))


def unit(w: NDArray[Real]) -> tuple[NDArray[Real], NDArray[Real]]:
    """Unit vectors and lengths of the columns; a zero or non-finite column gives zero and length 0.

    Float64 unit vectors are within 4 roundings (4 * 2**-53) of the exact ones.
    """
    with np.errstate(all="ignore"):
        square, rare = _squares(w)
        length = np.sqrt(square)
        direction = w / length
        if rare is not None:
            scaled, exponents = _rescaled(w[:, rare])
            scaled_length = np.sqrt(dot(scaled, scaled))
            direction[:, rare] = np.where(scaled_length > 0.0, scaled / scaled_length, 0.0)
            length[rare] = np.ldexp(scaled_length, exponents)
    return direction, length


def moderate(w: FloatArray, real: Any = np.float64) -> tuple[Any, Any]:
    """Columns of the same directions and moderate lengths, and the inverses of those lengths.

    Both are new arrays of the float type `real`. A column in the comfortable range is only rounded to that type;
    any other is first scaled by a power of two. A zero or non-finite column gives zero, and 0 for the inverse of
    its length.
    """
    with np.errstate(all="ignore"):
        result = w.astype(real, order="C")
        square, rare = _squares(result)
        inverse = 1.0 / np.sqrt(square)
    if rare is not None:
        scaled = _rescaled(w[:, rare].astype(np.float64))[0].astype(real)
        result[:, rare], inverse[rare] = scaled, _inverse(np.sqrt(dot(scaled, scaled)))
    return result, inverse


def _squares(w: NDArray[Real]) -> tuple[NDArray[Real], BoolArray | None]:
    """Squared lengths, and which of them cannot be used as they are; None if all can."""
    square = dot(w, w)
    if square.min(initial=1.0) >= _LEAST and square.max(initial=1.0) <= _MOST:  # a NaN fails both
        return square, None
    return square, ~((square >= _LEAST) & (square <= _MOST))


def _rescaled(w: NDArray[Real]) -> tuple[NDArray[Real], NDArray[np.int32]]:
    """Columns with their largest entry in [0.5, 1), zero where not finite, and the powers of two taken out."""
    finite = np.where(np.isfinite(w).all(axis=0), w, 0.0)
    exponents = np.frexp(np.abs(finite).max(axis=0))[1]
    return np.ldexp(finite, -exponents), exponents


def _inverse(length: NDArray[Real]) -> NDArray[Real]:
    return np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)


def towards(target: Vector, points: Float64Array, real: Any = np.float64) -> tuple[Any, Float64Array]:
    """Unit vectors from points to a target, and the distances; see `directions_to`."""
    directions, inverse, distance = directions_to(target, points, real)
    directions *= inverse
    return directions, distance


def directions_to(target: Vector, points: Float64Array, real: Any = np.float64) -> tuple[Any, Any, Float64Array]:
    """Vectors of moderate lengths from points to a target, the inverses of those lengths, and the distances.

    The difference of two positions is taken in float64, however near each other and far from the origin they are.
    What follows is computed in the float type `real`; float32 rounds each component to 2⁻¹¹⁹ of the distance too.

    Parameters
    ----------
    target : tuple of float
        A position.
    points : ndarray
        Shape (3, n).
    real : type, default float64
        Float type of the vectors and of their inverse lengths.

    Returns
    -------
    directions : ndarray
        Shape (3, n), the differences, times a power of two where these are very long or short; zero where the point
        is the target or is not finite.
    inverse : ndarray
        Shape (n,), 1 over their lengths; 0 where they are zero.
    distance : ndarray
        Shape (n,), float64; NaN where the point is not finite, and at most the largest float.
    """
    goal = np.array(target)[:, None]
    directions = np.empty(points.shape, real)
    with np.errstate(all="ignore"):
        np.subtract(goal, points, out=directions, casting="same_kind")
        square, rare = _squares(directions)
        length = np.sqrt(square)
        inverse = 1.0 / length
        distance = length.astype(np.float64, copy=False)
        if rare is not None:  # a square is 0, not finite, or has overflowed or underflowed
            there = points[:, rare]
            difference = goal - there
            far = ~np.isfinite(difference).all(axis=0)
            difference[:, far] = goal * 0.25 - there[:, far] * 0.25
            scaled, exponents = _rescaled(difference)
            scaled = scaled.astype(real)
            scaled_length = np.sqrt(dot(scaled, scaled))
            distances = np.minimum(np.ldexp(scaled_length.astype(np.float64), exponents + 2 * far), np.finfo(float).max)
            distances[~np.isfinite(there).all(axis=0)] = np.nan
            directions[:, rare], inverse[rare], distance[rare] = scaled, _inverse(scaled_length), distances
    return directions, inverse, distance
