"""Scalar code for the vertices that the kernel's loops cannot take as they come.

A vector is rare where its squared length would overflow or underflow, or is not finite, or is zero. It is
scaled by a power of two, exactly, so that the loops make of it the bits that they would have made in a
comfortable range; what is not finite becomes a zero vector.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong._kernel_math import inlined, plain
from pvphong._kernel_passes import BLOCK, SHINE, STRENGTH, X, Y, Z, is_moderate, square_of, strength

LOST = -100_000
"""In the place of an exponent: the vertex is not finite."""

# Makes room for sums of coordinates as large as float64 can hold; a power of two, so that it changes no bit.
_SMALLER = 2.0**-300


@inlined
def _exponent(x: float, y: float, z: float) -> int:
    """The power of two that takes the largest of three numbers to [0.5, 1); 0 for zeros."""
    return math.frexp(max(abs(x), max(abs(y), abs(z))))[1]


@inlined
def _is_finite(x: float, y: float, z: float) -> bool:
    return math.isfinite(x) and math.isfinite(y) and math.isfinite(z)


@plain
def rescue_normals(array: Any, matrix: Any, is_transformed: bool, normals: Any) -> None:
    """Rescale the rare normals of a block, from the array that they came from."""
    last = len(array) // 3 - 1
    for i in range(BLOCK):
        if is_moderate(square_of(normals, i)):
            continue
        k = 3 * min(i, last)
        x, y, z = _rescaled(np.float64(array[k]), np.float64(array[k + 1]), np.float64(array[k + 2]))
        if is_transformed:
            x, y, z = _rescaled(*rotated(matrix, x, y, z))
        normals[X + i] = x
        normals[Y + i] = y
        normals[Z + i] = z


@inlined
def _rescaled(x: float, y: float, z: float) -> tuple[float, float, float]:
    if not _is_finite(x, y, z):
        return 0.0, 0.0, 0.0
    power = _exponent(x, y, z)
    return math.ldexp(x, -power), math.ldexp(y, -power), math.ldexp(z, -power)


@plain
def rescue_points(array: Any, matrix: Any, w: float, points: Any) -> None:
    """Transform once more the points of a block whose sums may have overflowed before they cancelled."""
    last = len(array) // 3 - 1
    for i in range(BLOCK):
        k = 3 * min(i, last)
        x, y, z = np.float64(array[k]), np.float64(array[k + 1]), np.float64(array[k + 2])
        if _is_finite(x, y, z) and not _is_finite(points[X + i], points[Y + i], points[Z + i]):
            x, y, z = rotated(matrix, x * _SMALLER, y * _SMALLER, z * _SMALLER)
            points[X + i] = (x + matrix[0, 3] * _SMALLER) / w / _SMALLER
            points[Y + i] = (y + matrix[1, 3] * _SMALLER) / w / _SMALLER
            points[Z + i] = (z + matrix[2, 3] * _SMALLER) / w / _SMALLER


@plain
def rescue_rays(points: Any, x: float, y: float, z: float, ray: Any, exponents: Any) -> None:
    """Rescale the rare rays towards (x, y, z) of a block, and note the powers of two taken out."""
    for i in range(BLOCK):
        exponents[i] = 0
        if is_moderate(square_of(ray, i)):
            continue
        px, py, pz = np.float64(points[X + i]), np.float64(points[Y + i]), np.float64(points[Z + i])
        if not _is_finite(px, py, pz):
            exponents[i] = LOST
            ray[X + i], ray[Y + i], ray[Z + i] = 0.0, 0.0, 0.0
            continue
        power = _exponent(x - px, y - py, z - pz)
        exponents[i] = power
        ray[X + i] = _difference(points, x, px, power)
        ray[Y + i] = _difference(points, y, py, power)
        ray[Z + i] = _difference(points, z, pz, power)


@inlined
def _difference(points: Any, target: float, coordinate: float, power: int) -> Any:
    """Target − coordinate over 2^power, rounded where `approach` rounds it."""
    real = points.dtype.type
    high = np.float64(real(target))
    low = target - high
    return (real(math.ldexp(high, -power)) - real(math.ldexp(coordinate, -power))) + real(math.ldexp(low, -power))


@plain
def mend_strength(
    ray: Any, exponents: Any, constant: float, linear: float, quadratic: float, gain: float, factors: Any
) -> None:
    """Strength over rescaled rays; 1/c where the light is on the vertex, but 0 where c is 0, and where it is lost."""
    real = ray.dtype.type
    for i in range(BLOCK):
        square, power = square_of(ray, i), exponents[i]
        if power == LOST or (square == 0.0 and constant == 0.0):
            factors[STRENGTH + i] = 0.0
            continue
        l, q = real(math.ldexp(linear, power)), real(math.ldexp(quadratic, 2 * power))
        factors[STRENGTH + i] = strength(square, real(constant), l, q, real(gain))


@plain
def hide_unseen(viewer: Any, factors: Any) -> None:
    """No highlight where there is no v."""
    for i in range(BLOCK):
        if square_of(viewer, i) == 0.0:
            factors[SHINE + i] = 0.0


@inlined
def rotated(matrix: Any, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The first three columns of a matrix times a vector, summed in the order x, y, z."""
    return (
        matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z,
        matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z,
        matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z,
    )
