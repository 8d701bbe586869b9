"""Attenuation with distance, 1 / (c + l·d + q·d²), of lights with a position (OpenGL 2.1 specification, 2.14.1).

Symbols: c, l, q the constant, linear and quadratic coefficient; d the distance from the light.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.formulas import formula, multiply_add
from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.optics.roles import Falloff

NONE = (1.0, 0.0, 0.0)
"""The coefficients of a light that does not weaken with distance."""

INVERSE_SQUARE = (0.0, 0.0, 1.0)
"""Those of a light that weakens as light does, by 1/d²."""


def checked_coefficients(name: str, value: VectorLike) -> Vector:
    """Constant, linear and quadratic coefficient: all >= 0 and not all zero."""
    constant, linear, quadratic = check.numbers_in(name, value, 3)
    if min(constant, linear, quadratic) < 0.0 or not (constant or linear or quadratic):
        allowed = "three numbers >= 0 (constant, linear, quadratic) that are not all zero"
        check.refuse(name, value, allowed, "(1, 0, 0) is a light that does not weaken with distance.")
    return constant, linear, quadratic


COEFFICIENTS = Falloff(checked_coefficients, "radius")
"""The role of a field that holds them."""


@formula
def divisor(c: Any, l: Any, q: Any, d: Any) -> Any:
    """C + l·d + q·d²."""
    return multiply_add(multiply_add(q, d, l), d, c)


def attenuate(distance: Float64Array, attenuation: VectorLike) -> Float64Array:
    """Strength at distances d; at most the largest float.

    Where the point is not finite (d is NaN) nothing arrives. On the light itself (d = 0) it is 1/c,
    and 0 where c = 0: the light cannot be seen from inside itself.
    """
    constant, linear, quadratic = attenuation
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        strength: Float64Array = 1.0 / divisor(constant, linear, quadratic, distance)
    if constant < np.finfo(np.float64).tiny:  # the sum may have underflowed; finite, so that 0 times it is 0
        np.minimum(strength, np.finfo(np.float64).max, out=strength)
    if not distance.min(initial=1.0) > 0.0:  # a NaN, or a vertex on the light
        strength[np.isnan(distance)] = 0.0
        if not constant:
            strength[distance == 0.0] = 0.0
    return strength


def strength_at(distance: float, attenuation: VectorLike) -> float:
    """Strength at one distance, infinite on a light with c = 0."""
    constant, linear, quadratic = attenuation
    weakening = divisor(constant, linear, quadratic, distance)
    return 1.0 / weakening if weakening > 0.0 else math.inf


def distance_of(fraction: float, attenuation: VectorLike) -> float | None:
    """The distance at which the strength is a fraction of what it is at the light, if there is one.

    Where c is 0 it has no bounds at the light, and the fraction is of 1.
    """
    constant, linear, quadratic = attenuation
    rest = (constant or 1.0) / fraction - constant
    if quadratic:
        root = math.sqrt(linear * linear + 4.0 * quadratic * rest)
        return 2.0 * rest / (linear + root)
    return rest / linear if linear else None
