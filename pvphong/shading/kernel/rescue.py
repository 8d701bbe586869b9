"""Scalar code for the vertices that the kernel's loops cannot take as they come.

A vector is rare where its squared length would overflow or underflow, or is not finite, or is zero. It is
scaled by a power of two, exactly, so that the loops make of it the bits that they would have made in a
comfortable range; what is not finite becomes a zero vector.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import inlined, plain
from pvphong.shading.kernel.passes import ray_square, strength
from pvphong.shading.kernel.rows import BLOCK
from pvphong.shading.kernel.vectors import is_moderate, square_of

# In the place of an exponent: the vertex is not finite.
_LOST = 100_000

# The power of two of a number that is 0.
_NONE = -100_000

# Makes room for sums of coordinates as large as float64 can hold; a power of two, so that it changes no bit.
_SMALLER = 2.0**-300


@inlined
def _is_finite(x: float, y: float, z: float) -> bool:
    return math.isfinite(x) and math.isfinite(y) and math.isfinite(z)


@inlined
def _exponent(x: float, y: float, z: float) -> int:
    """The power of two that takes the largest of three numbers to [0.5, 1); 0 for zeros."""
    return math.frexp(max(abs(x), max(abs(y), abs(z))))[1]


@inlined
def _rescaled(x: float, y: float, z: float) -> tuple[float, float, float]:
    if not _is_finite(x, y, z):
        return 0.0, 0.0, 0.0
    exponent = _exponent(x, y, z)
    return math.ldexp(x, -exponent), math.ldexp(y, -exponent), math.ldexp(z, -exponent)


@inlined
def _product(matrix: Any, x: float, y: float, z: float) -> tuple[float, float, float]:
    return (
        matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z,
        matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z,
        matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z,
    )


@inlined
def _wide_sum(a: Any, x: float, y: float, z: float) -> tuple[float, int]:
    """A row of a matrix times a vector, as a number and a power of two that it is to be multiplied by."""
    (ax, i), (ay, j), (az, k) = math.frexp(a[0]), math.frexp(a[1]), math.frexp(a[2])
    (x, p), (y, q), (z, r) = math.frexp(x), math.frexp(y), math.frexp(z)
    x, y, z = ax * x, ay * y, az * z
    i, j, k = i + p if x else _NONE, j + q if y else _NONE, k + r if z else _NONE
    top = max(i, max(j, k))
    return math.ldexp(x, i - top) + math.ldexp(y, j - top) + math.ldexp(z, k - top), top


@plain
def _wide_product(matrix: Any, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A matrix times a vector over a power of two: also where numbers that matter would underflow or overflow."""
    (u, i), (v, j), (w, k) = _wide_sum(matrix[0], x, y, z), _wide_sum(matrix[1], x, y, z), _wide_sum(matrix[2], x, y, z)
    i, j, k = i if u else _NONE, j if v else _NONE, k if w else _NONE
    top = max(i, max(j, k))
    return math.ldexp(u, i - top), math.ldexp(v, j - top), math.ldexp(w, k - top)


@inlined
def _vector(array: Any, start: int, count: int, i: int) -> tuple[float, float, float]:
    """The vector that `split` put at i."""
    k = 3 * (start + min(i, count - 1))
    return np.float64(array[k]), np.float64(array[k + 1]), np.float64(array[k + 2])


@plain
def rescue_normals(array: Any, start: int, count: int, matrix: Any, is_turned: bool, rows: Any) -> None:
    """Rescale the rare normals of a block."""
    for i in range(BLOCK):
        if is_moderate(square_of(rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i])):
            continue
        x, y, z = _vector(array, start, count, i)
        if is_turned and _is_finite(x, y, z):
            x, y, z = _wide_product(matrix, x, y, z)
        x, y, z = _rescaled(x, y, z)
        rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i] = x, y, z


@plain
def rescue_points(array: Any, start: int, count: int, matrix: Any, w: float, wide: Any) -> None:
    """Transform once more the points of a block whose sums may have overflowed before they cancelled."""
    for i in range(BLOCK):
        x, y, z = _vector(array, start, count, i)
        if _is_finite(x, y, z) and not _is_finite(wide[i], wide[BLOCK + i], wide[2 * BLOCK + i]):
            x, y, z = _product(matrix, x * _SMALLER, y * _SMALLER, z * _SMALLER)
            wide[i] = (x + matrix[0, 3] * _SMALLER) / w / _SMALLER
            wide[BLOCK + i] = (y + matrix[1, 3] * _SMALLER) / w / _SMALLER
            wide[2 * BLOCK + i] = (z + matrix[2, 3] * _SMALLER) / w / _SMALLER


@plain
def rescue_rays(points: Any, x: float, y: float, z: float, rows: Any) -> None:
    """Rescale the rare rays of a block from points to (x, y, z), and note the powers of two taken out."""
    for i in range(BLOCK):
        rows[at.EXPONENT + i] = 0
        if is_moderate(ray_square(rows, i)):
            continue
        px, py, pz = np.float64(points[i]), np.float64(points[BLOCK + i]), np.float64(points[2 * BLOCK + i])
        if not _is_finite(px, py, pz):
            rows[at.EXPONENT + i] = _LOST
            rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i] = 0.0, 0.0, 0.0
            continue
        exponent = _exponent(x - px, y - py, z - pz)
        rows[at.EXPONENT + i] = exponent
        rows[at.DX + i] = _difference(points, x, px, exponent)
        rows[at.DY + i] = _difference(points, y, py, exponent)
        rows[at.DZ + i] = _difference(points, z, pz, exponent)


@inlined
def _difference(points: Any, target: float, coordinate: float, exponent: int) -> Any:
    """Target − coordinate over 2^exponent, rounded where `approach` rounds it."""
    real = points.dtype.type
    high = np.float64(real(target))
    low = target - high
    scaled = (real(math.ldexp(high, -exponent)) - real(math.ldexp(coordinate, -exponent))) + real(
        math.ldexp(low, -exponent)
    )
    if math.isfinite(scaled):
        return scaled
    # so near each other that coordinates scaled like their difference overflow; the difference is exact then
    return real(math.ldexp(target - coordinate, -exponent))


@plain
def mend_strength(rows: Any, constant: float, linear: float, quadratic: float, gain: float, on_light: float) -> None:
    """Strength over rescaled rays: 0 where the vertex is lost, and on the light where c is 0."""
    real = rows.dtype.type
    for i in range(BLOCK):
        square, exponent = ray_square(rows, i), int(rows[at.EXPONENT + i])
        if exponent == _LOST or (square == 0.0 and constant == 0.0):
            rows[at.STRENGTH + i] = 0.0
        elif square == 0.0:
            rows[at.STRENGTH + i] = on_light * strength(square, real(constant), real(0.0), real(0.0), real(gain))
        else:
            scaled = real(math.ldexp(linear, exponent)), real(math.ldexp(quadratic, 2 * exponent))
            rows[at.STRENGTH + i] = strength(square, real(constant), scaled[0], scaled[1], real(gain))


@plain
def hide_unseen(rows: Any) -> None:
    """No highlight where there is no v."""
    for i in range(BLOCK):
        if rows[at.VX + i] == 0.0 and rows[at.VY + i] == 0.0 and rows[at.VZ + i] == 0.0:
            rows[at.SHINE + i] = 0.0
