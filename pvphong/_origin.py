"""An equation's origin: put beside the mesh where a matrix carries the mesh very far out.

Where M p = L p + t with a very long t, the sum has lost of p what the rounding of t takes. A light beside the mesh has
the same t in its position; taken out of both before anything is added, it costs nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pvphong._types import Vector, VectorLike
from pvphong.equation import Equation, LightTerm
from pvphong.lights import DirectionalLight, Light, PointLight, SpotLight

# From where 2⁻⁵³ of the offset is more than 2⁻²⁴ of the way to a light. Nearer, nothing shows even in float32; and a
# light that was put on the image of a vertex, rounded as it is, is to stay on it.
_VERY_FAR = 2.0**29


def beside_the_mesh(equation: Equation) -> Equation:
    """The same equation about where the matrix puts the mesh's origin, if all that shines stands there, very far out.

    Else it is the equation itself. The vertices are not asked: none is to depend on where the others are. So this
    is for the whole equation, before a plan leaves out what does not reach them.
    """
    matrix = equation.matrix
    if matrix is None or matrix[3, 3] != 1.0 or not matrix[:3, 3].any():
        return equation
    kinds = (DirectionalLight, PointLight, SpotLight)
    if not all(isinstance(term.light, kinds) for term in equation.terms):
        return equation  # nobody knows where a light of another kind is
    offset, places = matrix[:3, 3], _places(equation)
    with np.errstate(over="ignore"):
        ways = [float(np.abs(np.subtract(place, offset)).max()) for place in places]
    if not ways or np.abs(offset).max() < _VERY_FAR * max(ways):
        return equation
    beside = matrix.copy()
    beside[:3, 3] = 0.0
    beside.flags.writeable = False
    return replace(
        equation,
        terms=tuple(_moved(term, offset) for term in equation.terms),
        eye=None if equation.eye is None else _difference(equation.eye, offset),
        matrix=beside,
    )


def _places(equation: Equation) -> list[VectorLike]:
    """Where the lights that shine stand, and the eye, if it counts."""
    shining = [term.light for term in equation.terms if not term.is_black]
    places: list[VectorLike] = [light.position for light in shining if isinstance(light, (PointLight, SpotLight))]
    if equation.eye is not None and equation.needs_eye:
        places.append(equation.eye)
    return places


def _moved(term: LightTerm, offset: VectorLike) -> LightTerm:
    light: Light = term.light
    if isinstance(light, (PointLight, SpotLight)):
        light = replace(light, position=_difference(light.position, offset))
    return replace(term, light=light)


def _difference(place: VectorLike, offset: VectorLike) -> Vector:
    x, y, z = (float(a) - float(b) for a, b in zip(place, offset, strict=True))
    return x, y, z
