"""Exact normals of the stored floats, in fractions, with square roots and angles in mpmath.

Independent of the package's code: polygons by Newell's sum over the points themselves, angles by arccosine.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import mpmath
import numpy as np
from numpy.typing import ArrayLike
from oracle import Exact, cross, dot, exact, minus

_mp = mpmath.MPContext()
_mp.prec = 2400  # angles of slivers 1e-300 high keep 400 bits


def _real(value: Fraction) -> mpmath.mpf:
    return _mp.mpf(value.numerator) / value.denominator


def length(vector: Exact) -> mpmath.mpf:
    return _mp.sqrt(_real(dot(vector, vector)))


def unit(vector: Sequence) -> list[mpmath.mpf]:
    """Normalise a vector of fractions or mpmath numbers."""
    parts = [_real(part) if isinstance(part, Fraction) else part for part in vector]
    size = _mp.sqrt(sum(part**2 for part in parts))
    return [part / size for part in parts]


def distance(observed: ArrayLike, exact: Sequence) -> float:
    """Return the distance between a computed vector and an exact unit vector; NaN counts as infinite."""
    observed = np.asarray(observed)
    if not np.isfinite(observed).all():
        return float("inf")
    return float(_mp.sqrt(sum((_mp.mpf(float(o)) - e) ** 2 for o, e in zip(observed, exact, strict=True))))


def area_vector(points: ArrayLike) -> Exact:
    """Return Newell's normal of a polygon, the sum of p_i × p_(i+1), with twice the area as its length."""
    corners = [exact(point) for point in np.asarray(points)]
    products = [cross(here, after) for here, after in zip(corners, corners[1:] + corners[:1], strict=True)]
    x, y, z = (sum((product[axis] for product in products), Fraction(0)) for axis in range(3))
    return x, y, z


def slenderness(triangle: ArrayLike) -> float:
    """Return the longest edge over the smallest height, L / h = L² / (twice the area)."""
    corners = [exact(point) for point in np.asarray(triangle)]
    edges = [minus(corners[i], corners[i - 1]) for i in range(3)]
    return float(_real(max(dot(edge, edge) for edge in edges)) / length(area_vector(triangle)))


def point_normal(points: np.ndarray, triangles: Sequence[Sequence[int]], point: int, weighting: str) -> list:
    """Return the weighted unit normal of one point of a triangle mesh."""
    total = [_mp.mpf(0)] * 3
    for triangle in triangles:
        if point not in triangle:
            continue
        corners = [exact(point) for point in points[list(triangle)]]
        here = list(triangle).index(point)
        a, b = (minus(corners[(here + step) % 3], corners[here]) for step in (1, 2))
        area = area_vector(points[list(triangle)])
        if not any(area):
            continue
        weight = _weight(a, b, area, weighting)
        total = [sum_ + weight * part for sum_, part in zip(total, unit(area), strict=True)]
    return unit(total)


def _weight(a: Exact, b: Exact, area: Exact, weighting: str) -> mpmath.mpf:
    if weighting == "area":
        return length(area)
    lengths = length(a) * length(b)
    cosine = _real(dot(a, b)) / lengths
    if weighting == "angle":
        return _mp.acos(cosine)
    return _mp.sqrt(1 - cosine**2) / lengths
