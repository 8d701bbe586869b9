"""The arithmetic of the kernel that libraries do not offer in a form that vectorises: max(1 − d, floor)ⁿ.

A call of libm's `log` or `exp` inside a loop keeps LLVM from vectorising it; polynomials and shifts of
exponent bits do not. The power is 2^(n·log2(1 − d)) for both precisions.

Coefficients, highest power first, come from `mpmath.chebyfit` with 50 digits, which interpolates at Chebyshev
nodes and is within a few per cent of the best approximation in the largest error. The exponential's constant
term is exactly 1, so that a power is exactly 1 where d = 0 or n = 0.

=======  =====================================  ==========================  ===========================
type     logarithm                              exponential                 measured error of the power
=======  =====================================  ==========================  ===========================
float32  log2(1 + t) = t·P(t), P of degree 9,   2^r = 1 + r·Q(r), Q of
         t in [√½ − 1, √2 − 1]: 8e-9            degree 5, |r| <= ½: 4e-9    1.6 · 2⁻²⁴ beside n·δd
float64  log2(1 + t) = z·P(z²), P of degree 7,  2^r = 1 + r·Q(r), Q of
         z = t / (2 + t): 4e-18                 degree 10, |r| <= ½: 7e-18  2.2 · 2⁻⁵³ beside n·δd
=======  =====================================  ==========================  ===========================

Only here is LLVM allowed to contract a product and a sum into one rounding: polynomials gain from it, and no
digit depends on two roundings. Everything else in the kernel is plain IEEE arithmetic, so that a vertex's bits
depend neither on its place in a block nor on its neighbours.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.extending import overload

Function = TypeVar("Function", bound=Callable[..., Any])


def plain(function: Function) -> Function:
    """Compile on first use, with IEEE arithmetic; a division by zero gives infinity."""
    return cast(Function, numba.njit(error_model="numpy")(function))


def inlined(function: Function) -> Function:
    """As `plain`, always inlined, so that a loop around it can be vectorised."""
    return cast(Function, numba.njit(error_model="numpy", forceinline=True)(function))


def contracted(function: Function) -> Function:
    """As `inlined`, with products and sums contracted."""
    return cast(Function, numba.njit(error_model="numpy", forceinline=True, fastmath={"contract"})(function))


_LOG32 = tuple(
    map(
        np.float32,
        (
            -0.10749789327383041,
            0.18476033210754395,
            -0.19138838350772858,
            0.20485764741897583,
            -0.23960812389850616,
            0.28855255246162415,
            -0.36069655418395996,
            0.48089852929115295,
            -0.7213473320007324,
            1.4426950216293335,
        ),
    )
)
_EXP32 = tuple(
    map(
        np.float32,
        (
            0.00015453163359779865,
            0.0013390863314270973,
            0.009618083015084267,
            0.055503569543361664,
            0.24022650718688965,
            0.6931471824645996,
            1.0,
        ),
    )
)

# Bits of √½: what lies above its mantissa counts as the next power of two.
_ROOT32, _SHIFT32 = np.int32(np.float32(0.5**0.5).view(np.int32)), np.int32(23)

# Adding it puts a number's nearest integer into the last bits of the mantissa.
_ROUND32 = np.float32(1.5 * 2**23)


@contracted
def _horner(t: Any, coefficients: Any) -> Any:
    total = coefficients[0]
    for k in range(1, len(coefficients)):
        total = total * t + coefficients[k]
    return total


@contracted
def _power32(square: Any, exponent: Any, most: Any) -> Any:
    d = min(np.float32(0.5) * square, most)
    bits = np.float32(np.float32(1.0) - d).view(np.int32)
    above = np.int32(bits - _ROOT32)
    k = np.int32(above >> _SHIFT32)
    m = np.int32(bits - np.int32(k << _SHIFT32)).view(np.float32)
    t = -d if k == np.int32(0) else m - np.float32(1.0)
    y = exponent * (t * _horner(t, _LOG32) + np.float32(k))
    y = max(y, np.float32(-126.0))
    whole = y + _ROUND32
    r = y - (whole - _ROUND32)
    power = _horner(r, _EXP32)
    scale = np.int32(np.int32(np.float32(whole).view(np.int32)) << _SHIFT32)
    return np.int32(np.float32(power).view(np.int32) + scale).view(np.float32)
