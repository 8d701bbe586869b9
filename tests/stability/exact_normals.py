"""Exact normals: what the stored floats say, in fractions, with square roots and angles in mpmath.

Written apart from the package: the inverse-transpose comes by elimination, not by cofactors; polygons by
Newell's sum over the points themselves; angles by arccosine.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import mpmath
import numpy as np
from numpy.typing import ArrayLike

Exact = list[Fraction]

_mp = mpmath.MPContext()
_mp.prec = 2400  # angles of slivers 1e-300 high keep 400 bits


def fractions(values: ArrayLike) -> list:
    """The stored numbers as nested lists of fractions."""
    if isinstance(values, Fraction):
        return values
    values = np.asarray(values)
    return [fractions(value) if value.ndim else Fraction(value.item()) for value in values]


def dot(a: Exact, b: Exact) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def cross(a: Exact, b: Exact) -> Exact:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def subtract(a: Exact, b: Exact) -> Exact:
    return [x - y for x, y in zip(a, b, strict=True)]


def _real(value: Fraction) -> mpmath.mpf:
    return _mp.mpf(value.numerator) / value.denominator


def length(vector: Exact) -> mpmath.mpf:
    return _mp.sqrt(_real(dot(vector, vector)))


def unit(vector: Sequence) -> list[mpmath.mpf]:
    """A unit vector of fractions or mpmath numbers."""
    parts = [_real(part) if isinstance(part, Fraction) else part for part in vector]
    size = _mp.sqrt(sum(part**2 for part in parts))
    return [part / size for part in parts]


def distance(observed: ArrayLike, exact: Sequence) -> float:
    """Length of the difference between a computed vector and an exact unit vector; NaN counts as infinite."""
    observed = np.asarray(observed)
    if not np.isfinite(observed).all():
        return float("inf")
    return float(_mp.sqrt(sum((_mp.mpf(float(o)) - e) ** 2 for o, e in zip(observed, exact, strict=True))))


def inverse_transpose(matrix: ArrayLike) -> list[Exact]:
    """Inverse-transpose of the linear part L / w of an affine 4x4 matrix, by Gauss-Jordan elimination."""
    stored = fractions(np.asarray(matrix, dtype=np.float64))
    rows = [[entry / stored[3][3] for entry in stored[i][:3]] + [Fraction(i == j) for j in range(3)] for i in range(3)]
    for column in range(3):
        pivot = next(i for i in range(column, 3) if rows[i][column])
        rows[column], rows[pivot] = rows[pivot], rows[column]
        rows[column] = [entry / rows[column][column] for entry in rows[column]]
        for i in range(3):
            if i != column:
                rows[i] = [a - rows[i][column] * b for a, b in zip(rows[i], rows[column], strict=True)]
    return [[rows[j][3 + i] for j in range(3)] for i in range(3)]


def apply(matrix3: list[Exact], vector: ArrayLike) -> Exact:
    exact = fractions(vector)
    return [dot(row, exact) for row in matrix3]


def amplification(matrix3: list[Exact], vector: ArrayLike) -> float:
    """How much rounding of the terms of C·n can turn the result: ‖|C|·|n|‖ / ‖C·n‖."""
    magnitudes = [[abs(entry) for entry in row] for row in matrix3]
    terms = [dot(row, [abs(entry) for entry in fractions(vector)]) for row in magnitudes]
    return float(length(terms) / length(apply(matrix3, vector)))


def area_vector(points: ArrayLike) -> Exact:
    """Newell's normal of a polygon, twice its area long: the sum of p_i × p_(i+1)."""
    corners = fractions(points)
    total = [Fraction(0)] * 3
    for here, after in zip(corners, corners[1:] + corners[:1], strict=True):
        total = [a + b for a, b in zip(total, cross(here, after), strict=True)]
    return total


def slenderness(triangle: ArrayLike) -> float:
    """Longest edge over least height, L / h = L² / (twice the area)."""
    corners = fractions(triangle)
    edges = [subtract(corners[i], corners[i - 1]) for i in range(3)]
    return float(_real(max(dot(edge, edge) for edge in edges)) / length(area_vector(triangle)))


def point_normal(points: np.ndarray, triangles: Sequence[Sequence[int]], point: int, weighting: str) -> list:
    """Weighted unit normal of one point of a mesh of triangles."""
    total = [_mp.mpf(0)] * 3
    for triangle in triangles:
        if point not in triangle:
            continue
        corners = fractions(points[list(triangle)])
        here = list(triangle).index(point)
        a, b = (subtract(corners[(here + step) % 3], corners[here]) for step in (1, 2))
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
