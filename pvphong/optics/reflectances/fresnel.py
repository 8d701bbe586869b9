"""Schlick's approximation of how much more is reflected at grazing angles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.base.types import FloatArray
from pvphong.optics.reflectances.highlight import square
from pvphong.optics.surface import Surface


def whiteness(surface: Surface, l: FloatArray) -> Any:
    """(1 − h·l)⁵, the part of the way from the reflectance at normal incidence to white (Schlick 1994, equation 15).

    H·l is half the length of l + v. Where l = −v it is 0, and there is no half-way direction.
    """
    real = surface.raw.dtype.type
    rest = np.maximum(real(1.0) - real(0.5) * np.sqrt(square(l + surface.to_viewer)), real(0.0))
    fourth = rest * rest
    fourth *= fourth
    fourth *= rest
    return fourth


WHITENESS_SLOPE = 2.5
"""Its largest change for a turn of l or v by a radian: h·l is the cosine of half the angle between them."""


def most_whiteness(psi: float) -> float:
    """The largest for an angle of at most ψ from light to viewer."""
    return (1.0 - math.cos(0.5 * min(psi, math.pi))) ** 5
