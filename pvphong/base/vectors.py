"""Vectors as the columns of (3, n) float64 arrays: the layout of the evaluator's inner blocks.

Each column's result depends only on that column. A column that would overflow or underflow is scaled by its own exact
power of two, so that its result has the same bits as in a safe range. (In a matrix product by BLAS, a column's result
may depend on other columns, so no such product is used.)
"""

from __future__ import annotations

import math
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import BoolArray, Float64Array, FloatArray, Vector, VectorLike

Real = TypeVar("Real", bound=np.floating[Any])

# Squared lengths in this range have lost no bit to underflow, and float32 can represent them too.
_LEAST, _MOST = 2.0**-60, 2.0**60


def dot(a: FloatArray, b: FloatArray) -> Any:
    """Return the dot products of the columns of two (3, n) arrays, shape (n,), each summed in the order x, y, z."""
    products = a * b
    total = products[0]
    total += products[1]
    total += products[2]
    return total


def all_dots(a: Float64Array, b: Float64Array) -> Float64Array:
    """Return the dot products of each row of `a`, shape (m, 3), with each row of `b`, (n, 3), as an (m, n) array.

    Unlike those of the operator @, they do not depend on the other rows: BLAS rounds differently at the ends of arrays.
    """
    return a[:, :1] * b[:, 0] + a[:, 1:2] * b[:, 1] + a[:, 2:] * b[:, 2]


def is_direction(vectors: FloatArray) -> BoolArray:
    """Return a mask, shape (n,): True for each column of a (3, n) array that is finite and not zero."""
    x, y, z = vectors  # row by row, which is ten times faster
    return np.asarray(np.isfinite(x) & np.isfinite(y) & np.isfinite(z) & ((x != 0.0) | (y != 0.0) | (z != 0.0)))


def cross(a: NDArray[Real], b: NDArray[Real]) -> NDArray[Real]:
    """Return the cross products of the columns of two (3, ...) arrays, after broadcasting them to one shape."""
    result = np.empty(np.broadcast_shapes(a.shape, b.shape), a.dtype)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[j], b[k], out=result[i])
        result[i] -= a[k] * b[j]
    return result


def columns(rows: FloatArray) -> Float64Array:
    """Return a contiguous (3, n) float64 copy of an (n, 3) array."""
    return rows.T.astype(np.float64, order="C")


def unit_vector(vector: VectorLike) -> Vector:
    """Return the unit vector along a finite nonzero vector. The result has the same bits as that of `unit`."""
    (x, y, z), _ = moderate_vector(vector)
    length = math.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length


def moderate_vector(vector: VectorLike) -> tuple[Vector, float]:
    """Scale a finite nonzero vector by a power of two, so that its largest component is in [0.5, 1).

    Return the scaled vector, and 1 over the scaled vector's length.
    """
    scale = -math.frexp(max(map(abs, vector)))[1]
    x, y, z = (math.ldexp(component, scale) for component in vector)
    return (x, y, z), 1.0 / math.sqrt(x * x + y * y + z * z)


def angle_between(a: VectorLike, b: VectorLike) -> float:
    """Return the angle between two unit vectors in radians.

    The error is up to 1e-7, because arc cosines lose half the digits near 0 and π.
    """
    return math.acos(max(-1.0, min(1.0, a[0] * b[0] + a[1] * b[1] + a[2] * b[2])))


def unit(w: NDArray[Real]) -> tuple[NDArray[Real], NDArray[Real]]:
    """Normalize the columns of a (3, n) array; return the unit vectors, shape (3, n), and the lengths, shape (n,).

    A zero or non-finite column gives a zero vector and the length 0. Float64 unit vectors are within 4 roundings (4 *
    2**-53) of the exact ones.
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
    """Scale columns of a (3, n) array by powers of two, where needed to keep their squared lengths in a safe range.

    Parameters
    ----------
    w : ndarray
        Shape (3, n). Columns whose squared length is in the safe range are not scaled.
    real : type, default float64
        Float type of the results.

    Returns
    -------
    scaled : ndarray
        Shape (3, n), the columns, scaled where needed; zero for a zero or non-finite column.
    inverse : ndarray
        Shape (n,), 1 over the lengths of the columns of `scaled`; 0 for a zero column.
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
    """Compute the squared lengths of the columns of a (3, n) array, and find those outside the safe range.

    Return the squared lengths, and a mask that is True outside the safe range. The mask is None if all are inside it.
    """
    square = dot(w, w)
    if square.min(initial=1.0) >= _LEAST and square.max(initial=1.0) <= _MOST:  # a NaN fails both
        return square, None
    return square, ~((square >= _LEAST) & (square <= _MOST))


def _rescaled(w: NDArray[Real]) -> tuple[NDArray[Real], NDArray[np.int32]]:
    """Scale the columns of a (3, n) array by powers of two, so that the largest component of each is in [0.5, 1).

    Return the scaled columns and the exponents: a column is 2**exponent times its scaled column. The scaled column is
    zero if the column is zero or not finite.
    """
    finite = np.where(np.isfinite(w).all(axis=0), w, 0.0)
    exponents = np.frexp(np.abs(finite).max(axis=0))[1]
    return np.ldexp(finite, -exponents), exponents


def _inverse(length: NDArray[Real]) -> NDArray[Real]:
    return np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)


def towards(target: Vector, points: Float64Array, real: Any = np.float64) -> tuple[Any, Float64Array]:
    """Return the unit vectors from points to a target, shape (3, n), and the distances, shape (n,).

    `points` has the shape (3, n). The unit vectors have the float type `real`, the distances are float64. A unit vector
    is zero where the point is the target or is not finite. The distance is NaN where the point is not finite.
    """
    directions, inverse, distance = directions_to(target, points, real)
    directions *= inverse
    return directions, distance


def directions_to(target: Vector, points: Float64Array, real: Any = np.float64) -> tuple[Any, Any, Float64Array]:
    """Return vectors of moderate length from points to a target, their inverse lengths, and the distances.

    The differences of positions are computed in float64, so that positions near each other and far from the origin keep
    their digits. All other steps are in the float type `real`. With float32, a component may have an absolute error of
    2⁻¹¹⁹ times the distance, in addition to its rounding.

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
        Shape (3, n), target minus point, scaled by a power of two if very long or short; zero where the point is the
        target or is not finite.
    inverse : ndarray
        Shape (n,), 1 over the lengths of `directions`; 0 where `directions` is zero.
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
