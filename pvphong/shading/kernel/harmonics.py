"""The kernel's loops over spherical harmonics, as which an environment is lit; formulas as in `optics.harmonics`.

The part of a lobe above the horizon is t Σ c T(2t² − 1) + ½, T Chebyshev's polynomials, t the elevation of the mirrored
viewer over that at which nothing is hidden any more.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel import vertices as at
from pvphong.shading.kernel.angles32 import angle_above
from pvphong.shading.kernel.arithmetic import like, multiply_add, plain
from pvphong.shading.kernel.vertices import BLOCK, square_of

_F = np.float32
_ZERO, _HALF, _ONE, _TWO = _F(0.0), _F(0.5), _F(1.0), _F(2.0)
_HALF_PI = _F(0.5 * math.pi)
_CONSTANT, _ROOT_OF_TWO = math.sqrt(0.25 / math.pi), math.sqrt(2.0)

# Rows of a stage's own: ρᵐ cos mφ and sin mφ, Q of two bands, and the sums over bands of what these multiply.
_COSINE, _SINE, _BEFORE, _HERE, _EVEN, _ODD = range(at.OWN, at.OWN + 6 * BLOCK, BLOCK)


@plain
def look_around(rows: Any, axes: Any, is_mirrored: bool) -> None:
    """The normal, or the viewer mirrored at it, along three axes: into the rows of ways."""
    ax, ay, az = like(rows, axes[0]), like(rows, axes[1]), like(rows, axes[2])
    bx, by, bz = like(rows, axes[3]), like(rows, axes[4]), like(rows, axes[5])
    cx, cy, cz = like(rows, axes[6]), like(rows, axes[7]), like(rows, axes[8])
    for i in range(BLOCK):
        shrink = rows[at.INVERSE + i]
        x, y, z = rows[at.NX + i] * shrink, rows[at.NY + i] * shrink, rows[at.NZ + i] * shrink
        if is_mirrored:
            twice = _TWO * (rows[at.FACING + i] * shrink)
            x, y, z = twice * x - rows[at.VX + i], twice * y - rows[at.VY + i], twice * z - rows[at.VZ + i]
        rows[at.DX + i] = multiply_add(ax, x, multiply_add(ay, y, az * z))
        rows[at.DY + i] = multiply_add(bx, x, multiply_add(by, y, bz * z))
        rows[at.DZ + i] = multiply_add(cx, x, multiply_add(cy, y, cz * z))


@plain
def add_harmonics(rows: Any, coefficients: Any, bands: int, target: int) -> None:
    """The sum of harmonics into a row: pairs of coefficients, those of one m after the other."""
    for i in range(BLOCK):
        rows[_COSINE + i], rows[_SINE + i], rows[target + i] = _ONE, _ZERO, _ZERO
    first, place = _CONSTANT, 0
    for m in range(bands):
        if m > 0:
            first *= math.sqrt((2.0 * m + 1.0) / (2.0 * m)) * (_ROOT_OF_TWO if m == 1 else 1.0)
            for i in range(BLOCK):
                x, y, cosine, sine = rows[at.DX + i], rows[at.DY + i], rows[_COSINE + i], rows[_SINE + i]
                rows[_COSINE + i] = multiply_add(x, cosine, -(y * sine))
                rows[_SINE + i] = multiply_add(x, sine, y * cosine)
        start = like(rows, first)
        for i in range(BLOCK):
            rows[_BEFORE + i], rows[_HERE + i], rows[_EVEN + i], rows[_ODD + i] = _ZERO, start, _ZERO, _ZERO
        for l in range(m, bands):
            if l > m:
                _next(rows, l, m)
            if coefficients[place] != 0.0 or coefficients[place + 1] != 0.0:
                even, odd = like(rows, coefficients[place]), like(rows, coefficients[place + 1])
                for i in range(BLOCK):
                    rows[_EVEN + i] = multiply_add(even, rows[_HERE + i], rows[_EVEN + i])
                    rows[_ODD + i] = multiply_add(odd, rows[_HERE + i], rows[_ODD + i])
            place += 2
        for i in range(BLOCK):
            sum_of_m = multiply_add(rows[_COSINE + i], rows[_EVEN + i], rows[_SINE + i] * rows[_ODD + i])
            rows[target + i] += sum_of_m


@plain
def _next(rows: Any, l: int, m: int) -> None:
    """Q of the next band."""
    a = math.sqrt((4.0 * l * l - 1.0) / (l * l - m * m))
    b = like(rows, a * math.sqrt(((l - 1.0) * (l - 1.0) - m * m) / (4.0 * (l - 1.0) * (l - 1.0) - 1.0)))
    slope = like(rows, a)
    for i in range(BLOCK):
        here = rows[_HERE + i]
        rows[_HERE + i] = multiply_add(slope * rows[at.DZ + i], here, -(b * rows[_BEFORE + i]))
        rows[_BEFORE + i] = here


@plain
def not_below(rows: Any, target: int) -> None:
    """Nothing that is negative, and nothing where there is no normal."""
    for i in range(BLOCK):
        has_normal = rows[at.INVERSE + i] > _ZERO
        is_lit = square_of(rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i]) > _ZERO
        rows[target + i] = max(rows[target + i], _ZERO) if has_normal & is_lit else _ZERO


@plain
def hide_below(rows: Any, shares: Any, count: int, target: int) -> None:
    """A row times the part of the lobe that is above the horizon: of 1 over its end, and so many coefficients."""
    per_end = like(rows, shares[0])
    for i in range(BLOCK):
        c = min(max(rows[at.FACING + i] * rows[at.INVERSE + i], -_ONE), _ONE)
        t = (_HALF_PI - angle_above(np.sqrt(_ONE - c * c), c)) * per_end
        t = min(max(t, -_ONE), _ONE)
        rows[_COSINE + i], rows[_SINE + i] = t, _TWO * (_TWO * t * t - _ONE)
        rows[_BEFORE + i], rows[_HERE + i] = _ZERO, _ZERO
    for k in range(count, 1, -1):
        coefficient = like(rows, shares[k])
        for i in range(BLOCK):
            here = rows[_HERE + i]
            rows[_HERE + i] = multiply_add(rows[_SINE + i], here, coefficient - rows[_BEFORE + i])
            rows[_BEFORE + i] = here
    last = like(rows, shares[1])
    for i in range(BLOCK):
        total = multiply_add(_HALF * rows[_SINE + i], rows[_HERE + i], last - rows[_BEFORE + i])
        share = multiply_add(rows[_COSINE + i], total, _HALF)
        rows[target + i] *= min(max(share, _ZERO), _ONE)
