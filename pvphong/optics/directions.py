"""Importance sampling of the directions of light that a highlight reflects, on arrays."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.formulas import cross, dot, power_less_one
from pvphong.base.types import Float64Array, FloatArray
from pvphong.optics.area.sampling import combined, length_and_direction, on_disk, orthogonals


class Directions(NamedTuple):
    """Importance sampling of one direction at each of n points.

    It consists of two functions: one chooses the directions, the other returns their density.
    """

    sample: Callable[[Any, Any], Float64Array]
    """Function of u and v, shape (n,), that returns unit vectors, shape (3, n); zero where there is no direction."""

    density: Callable[[Float64Array], Float64Array]
    """Function of unit vectors, shape (3, n), that returns their density per solid angle, shape (n,)."""


def around(axis: FloatArray, exponent: Any) -> Directions:
    """Sample directions at n points with a density proportional to max(z, 0)ᵖ, where z is the cosine with an axis.

    `axis` has a unit vector for each point, shape (3, n). `exponent` is p, one number or one for each point. With the
    normals as axes, p = 1 gives sampling by the cosine.
    """
    raised = exponent + 1.0
    across, up = orthogonals(axis)

    def sample(u: Any, v: Any) -> Float64Array:
        x, y = on_disk(u, v)
        inner = np.minimum(x * x + y * y, 1.0 - 2.0**-30)
        less = -np.expm1(np.log1p(-inner) / raised)  # 1 − z
        wide = np.sqrt(less * (2.0 - less) / np.maximum(inner, 1e-300))
        return np.stack(combined(x * wide, across, y * wide, up, 1.0 - less, axis))

    def density(l: Float64Array) -> Float64Array:
        off = l - axis
        less = 0.5 * dot(off, off)
        power = np.where(less < 1.0, 1.0 + power_less_one(less, exponent), 0.0)
        return np.asarray(power * (raised / (2.0 * math.pi)))

    return Directions(sample, density)


def by_halves(
    n: FloatArray,
    v: FloatArray,
    slopes: Callable[[Any, Any], tuple[Any, Any]],
    slope_density: Callable[[Any, Any], Any],
    t: FloatArray | None = None,
) -> Directions:
    """Sample half-way directions h by their slopes, and mirror the vectors v to the viewer at them.

    The two slopes of h are h·t/h·n and h·(n × t)/h·n. The density of slopes, divided by (h·n)³, is the density of h.
    The density of h, divided by 4 v·h, is the density of the mirrored directions.

    Parameters
    ----------
    n, v : ndarray
        Unit normals and vectors to the viewer, shape (3, n).
    slopes : callable
        Function of the coordinates x and y of points of the unit disk. It returns both slopes.
    slope_density : callable
        Function of both slopes. It returns their density.
    t : ndarray, optional
        Unit tangents, shape (3, n); by default, arbitrary unit vectors orthogonal to the normals.
    """
    t, b = orthogonals(n) if t is None else (t, cross(n, t))

    def sample(u: Any, w: Any) -> Float64Array:
        x, y = slopes(*on_disk(u, w))
        h = length_and_direction(combined(1.0, n, x, t, y, b))[1]
        height = np.maximum(dot(h, v), 0.0)
        return np.stack(combined(2.0 * height, h, np.where(height > 0.0, -1.0, 0.0), v, 0.0, n))

    def density(l: Float64Array) -> Float64Array:
        s = l + v
        height, length = dot(n, s), np.sqrt(dot(s, s))
        above = np.where(height > 0.0, height, 1.0)
        found = slope_density(dot(t, s) / above, dot(b, s) / above) * (length / above) ** 3 / (2.0 * length)
        return np.where(height > 0.0, found, 0.0)

    return Directions(sample, density)


def mixed(first: Directions, second: Directions, share: float) -> Directions:
    """Mix two samplings.

    A direction is chosen by `first` with the probability `share`, and by `second` with the probability 1 − `share`.
    """

    def sample(u: Any, v: Any) -> Float64Array:
        is_first = u < share
        found = first.sample(np.minimum(u / share, 1.0), v), second.sample((u - share).clip(0.0) / (1.0 - share), v)
        return np.where(is_first, *found)

    return Directions(sample, lambda l: share * first.density(l) + (1.0 - share) * second.density(l))
