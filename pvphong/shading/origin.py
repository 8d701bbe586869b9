"""An equation's origin: put beside the mesh where a matrix carries the mesh very far out.

Where p' = (L p + t) / w with a very long t, the sum has lost of p what the rounding of t takes. A light beside the mesh
has the same t/w in its position; taken out of both before anything is added, it costs nothing. Nor does it cost a light
anything that is as far away as t/w is long: its ways to the vertices are rounded to 2⁻⁵³ of their length as before.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np

from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.shading.equation import Equation, LightTerm

# From where 2⁻⁵³ of the offset is more than 2⁻²⁴ of the way to a light. Nearer, nothing shows even in float32; and a
# light that was put on the image of a vertex, rounded as it is, is to stay on it.
_VERY_FAR = 2.0**29


def beside_the_mesh(equation: Equation) -> Equation:
    """The same equation about where the matrix puts the mesh's origin, if that is very far out and a light or eye near.

    Else it is the equation itself. The vertices are not asked: none is to depend on where the others are. So this
    is for the whole equation, before a plan leaves out what does not reach them.
    """
    matrix = equation.matrix
    if matrix is None or matrix[3, :3].any() or not matrix[3, 3] or not matrix[:3, 3].any():
        return equation
    if not all(term.light.is_even or term.light.places for term in equation.terms):
        return equation  # nobody knows where they are
    with np.errstate(over="ignore", invalid="ignore"):
        offset = matrix[:3, 3] / matrix[3, 3]
        ways = [float(np.abs(np.subtract(place, offset)).max()) for place in _places(equation)]
    nearest = min((way for way in ways if way), default=0.0)  # what stands on the offset itself is as well off here
    if not ways or not max(ways) < math.inf or np.abs(offset).max() < _VERY_FAR * nearest:
        return equation
    beside = matrix.copy()
    beside[:3, 3] = 0.0
    beside.flags.writeable = False
    return replace(
        equation,
        terms=tuple(_moved(term, matrix) for term in equation.terms),
        eye=None if equation.eye is None else _seen_from_offset(equation.eye, matrix),
        matrix=beside,
    )


def _places(equation: Equation) -> list[VectorLike]:
    """Where the lights stand, and the eye, if it counts."""
    places: list[VectorLike] = [place for term in equation.terms for place in term.light.places]
    return places if equation.eye is None else [*places, equation.eye]


def _moved(term: LightTerm, matrix: Float64Array) -> LightTerm:
    return replace(term, light=term.light.moved(lambda place: _seen_from_offset(place, matrix)))


def _seen_from_offset(place: VectorLike, matrix: Float64Array) -> Vector:
    """A place minus t/w, rounded once."""
    w = Fraction(float(matrix[3, 3]))
    x, y, z = (float(Fraction(float(a)) - Fraction(t) / w) for a, t in zip(place, matrix[:3, 3].tolist(), strict=True))
    return x, y, z
