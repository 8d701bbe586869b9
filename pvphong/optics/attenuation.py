"""Distance attenuation 1 / (c + l·d + q·d²) of positional lights (OpenGL 2.1 specification, 2.14.1).

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
"""Coefficients of a light without falloff."""

INVERSE_SQUARE = (0.0, 0.0, 1.0)
"""Coefficients of physical falloff, 1/d²."""


def checked_coefficients(name: str, value: VectorLike) -> Vector:
    """Check three attenuation coefficients, and return them as a tuple.

    `value` has the constant, linear and quadratic coefficient. All must be >= 0, and at least one must be > 0. `name`
    is the argument's name in messages.
    """
    constant, linear, quadratic = check.numbers_in(name, value, 3)
    if min(constant, linear, quadratic) < 0.0 or not (constant or linear or quadratic):
        allowed = "three numbers >= 0 (constant, linear, quadratic) that are not all zero"
        check.refuse(name, value, allowed, "Use (1, 0, 0) for a light without falloff.")
    return constant, linear, quadratic


COEFFICIENTS = Falloff(checked_coefficients, "radius")
"""Role of a field that holds attenuation coefficients."""


@formula
def divisor(c: Any, l: Any, q: Any, d: Any) -> Any:
    """Compute c + l·d + q·d² for a distance d. The attenuation is 1 divided by the result."""
    return multiply_add(multiply_add(q, d, l), d, c)


def attenuate(distance: Float64Array, attenuation: VectorLike) -> Float64Array:
    """Return the attenuation for each distance, limited to the largest float.

    `attenuation` has the constant, linear and quadratic coefficients. The result is 0 for a distance of NaN (a point
    that is not finite). At the distance 0, the result is 1 over the constant coefficient. If this coefficient is 0, the
    result is 0 there, because a light does not light its own position.
    """
    constant, linear, quadratic = attenuation
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        strength: Float64Array = 1.0 / divisor(constant, linear, quadratic, distance)
    if constant < np.finfo(np.float64).tiny:  # the sum may have underflowed; keep it finite, so that 0 times it is 0
        np.minimum(strength, np.finfo(np.float64).max, out=strength)
    if not distance.min(initial=1.0) > 0.0:  # a NaN, or a vertex on the light
        strength[np.isnan(distance)] = 0.0
        if not constant:
            strength[distance == 0.0] = 0.0
    return strength


def strength_at(distance: float, attenuation: VectorLike) -> float:
    """Return the attenuation at one distance.

    `attenuation` has the constant, linear and quadratic coefficients. If the constant coefficient is 0, the result for
    the distance 0 is infinite.
    """
    constant, linear, quadratic = attenuation
    weakening = divisor(constant, linear, quadratic, distance)
    return 1.0 / weakening if weakening > 0.0 else math.inf


def distance_of(fraction: float, attenuation: VectorLike) -> float | None:
    """Return the distance at which the attenuation has fallen to a fraction of its value at the light.

    `attenuation` has the constant, linear and quadratic coefficients. The result is None if the attenuation does not
    fall. If the constant coefficient is 0, the value at the light is infinite; the result is then the distance at which
    the attenuation equals `fraction`.
    """
    constant, linear, quadratic = attenuation
    rest = (constant or 1.0) / fraction - constant
    if quadratic:
        root = math.sqrt(linear * linear + 4.0 * quadratic * rest)
        return 2.0 * rest / (linear + root)
    return rest / linear if linear else None
