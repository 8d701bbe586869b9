"""Angles in float32, in forms that vectorise, for lights with a size.

The arc tangent is t − t³ P(t²) for t in [0, 1], with P as `mpmath.chebyfit` gives it with 40 digits: 3e-9.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel.arithmetic import inlined, multiply_add

_F = np.float32
_ZERO, _ONE, _TWO, _TINY = _F(0.0), _F(1.0), _F(2.0), _F(2.0**-126)
_PI, _HALF_PI = _F(math.pi), _F(0.5 * math.pi)

_ARCTAN = tuple(
    _F(c)
    for c in (
        -0.001488691894337535, 0.00914462935179472, -0.026305001229047775, 0.04896051436662674,
        -0.07031914591789246, 0.08931826800107956, -0.11088261753320694, 0.14284004271030426,
        -0.19999949634075165, 0.3333333432674408,
    )
)  # fmt: skip

# sin x / x for |x| <= π/4 as a polynomial in x², by `mpmath.chebyfit` with 40 digits: 3e-9.
_SINE = tuple(_F(c) for c in (-0.00019503904, 0.0083320355, -0.16666651, 1.0))


@inlined
def less_arctan(square: Any) -> Any:
    """(t − atan t) / t³ for t² = `square`, t <= 1."""
    total = _ARCTAN[0]
    for k in range(1, len(_ARCTAN)):
        total = multiply_add(total, square, _ARCTAN[k])
    return total


@inlined
def angle_above(y: Any, x: Any) -> Any:
    """Of a point with y >= 0, in [0, π]."""
    size = abs(x)
    t = min(y, size) / max(max(y, size), _TINY)
    square = t * t
    turned = t - t * (square * less_arctan(square))
    turned = _HALF_PI - turned if y > size else turned
    return _PI - turned if x < _ZERO else turned


@inlined
def angle_of(y: Any, x: Any) -> Any:
    """Of a point, in [−π, π]."""
    found = angle_above(abs(y), x)
    return -found if y < _ZERO else found


@inlined
def small_sine(x: Any) -> Any:
    """For |x| <= π/4."""
    square = x * x
    total = _SINE[0]
    for k in range(1, len(_SINE)):
        total = multiply_add(total, square, _SINE[k])
    return x * total


@inlined
def cosine_and_sine(quarter: Any) -> tuple[Any, Any]:
    """Of four times an angle in [−π/4, π/4]."""
    sine = small_sine(quarter)
    twice, rest = _TWO * sine * np.sqrt(max(_ONE - sine * sine, _ZERO)), _ONE - _TWO * sine * sine
    return _ONE - _TWO * twice * twice, _TWO * twice * rest
