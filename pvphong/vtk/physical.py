"""What float32 does to VTK's physically based shading: an estimate in float64, apart from evaluator and shader.

Symbols as in `pvphong.optics.reflectances.microfacets`. Errors are in roundings of 2⁻²⁴.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, Vector

GAMMA = 2.2
"""The shader raises the sum of all light to 1/2.2."""

_FLOOR = 1e-5
"""Under which no cosine falls there."""

_LEAST = math.sqrt(1e-8 / math.pi)
"""Under which D's denominator does not fall."""

_DIELECTRIC = 0.04


class Cosines(NamedTuple):
    """Of n vertices and one light, and by how much float32 turns the directions that they are of."""

    n_l: Float64Array
    n_v: Float64Array
    n_h: Float64Array
    h_l: Float64Array
    light_turn: Any
    """Of the angle between n and l."""
    eye_turn: Any
    """Of that between n and v."""


def allowed_error(roughness: float) -> float:
    """6 · 2⁻²⁴ / roughness⁴ + 2e-6, relative where a colour is more than 1.

    D's denominator 1 − (1 − α²)(n·h)² is α² = roughness⁴ at the peak. Five or six roundings of n·h and of its
    square count there so much more; D has its square, and the picture its power 1/2.2.
    """
    return 6.0 * 2.0**-24 / max(roughness**4, _LEAST) + 2e-6


def reflected(metallic: float, roughness: float, color: Vector, c: Cosines) -> tuple[Float64Array, Float64Array]:
    """What leaves of white light, shape (n, 3), and its relative error in roundings, likewise."""
    x, y, m = np.maximum(c.n_l, _FLOOR), np.maximum(c.n_v, _FLOOR), metallic
    a = np.array(color)
    f0 = (1.0 - m) * _DIELECTRIC + m * a
    grazing = (1.0 - np.clip(c.h_l, _FLOOR, 1.0))[:, None]
    f = f0 + (1.0 - f0) * grazing**5
    denominator = np.maximum(1.0 - (1.0 - roughness**4) * np.maximum(c.n_h, 0.0) ** 2, _LEAST)
    r2 = roughness**2
    masked = x * np.sqrt(r2 + (1.0 - r2) * y * y) + y * np.sqrt(r2 + (1.0 - r2) * x * x)
    shine = ((r2 / denominator) ** 2 * x / (2.0 * masked))[:, None]
    base = (1.0 - m) * (1.0 - f) * a * x[:, None]
    half_turn = (c.light_turn + c.eye_turn) / (2.0 * np.maximum(c.h_l, 1e-9))
    of_x, of_y = _relative(c.n_l, c.light_turn), _relative(c.n_v, c.eye_turn)
    of_f = 5.0 * grazing**4 * (1.0 - f0) * (_sine(c.h_l) * half_turn + 3.0)[:, None]
    of_cosine = 2.0 * np.maximum(c.n_h, 0.0) * (_sine(c.n_h) * half_turn + 2.0) + 1.5
    of_shine = (of_x + of_y + 2.0 * of_cosine / denominator + 12.0)[:, None]
    light = base + shine * f
    error = base * (of_x[:, None] + 8.0) + (1.0 - m) * a * x[:, None] * of_f + shine * (f * of_shine + of_f)
    return light / math.pi, error / np.maximum(light, np.finfo(np.float64).tiny)


def _relative(cosine: Float64Array, turn: Any) -> Float64Array:
    """Of a cosine that is not below its floor."""
    lost = _sine(cosine) * turn + 3.0
    return np.where(cosine > _FLOOR - lost * 2.0**-24, lost / np.maximum(cosine, _FLOOR), 0.0)


def _sine(cosine: Float64Array) -> Any:
    return np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
