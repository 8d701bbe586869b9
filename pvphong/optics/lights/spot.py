"""Light from one point inside a cone, brightest along its axis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

from pvphong.base import check
from pvphong.base.formulas import BRIGHTEST, ONE, TWO, ZERO, Power, add, formula, select, square, times
from pvphong.base.types import Vector, VectorLike
from pvphong.base.vectors import moderate_vector
from pvphong.optics.attenuation import COEFFICIENTS, NONE
from pvphong.optics.light import Light, PunctualParameters
from pvphong.optics.lights.aimed import Aimed
from pvphong.optics.lights.point import Weakening
from pvphong.optics.roles import Power as FalloffPower
from pvphong.optics.roles import aim, angle, meaning, place

_HALF = "It is half the opening angle, in degrees. Use a PointLight for a light without a cone."


@formula
def _in_cone(own: Any, l: Any) -> Any:
    """Return 1 inside the cone, else 0; and the squared chord |C|² of the angle θ off the axis: cos θ = 1 − ½|C|².

    `own` has the axis and the squared chord at the cone's edge; `l` is the unit vector to the light. A cosine near 1
    has lost the digits that narrow cones and high exponents need, but the chord keeps them. On the light itself, cos θ
    is taken as 0.
    """
    chord = select(square(l) > ZERO, square(add((own[0], own[1], own[2]), l)), TWO)
    return select(chord <= own[3], ONE, ZERO), chord


@dataclass(frozen=True)
class SpotLight(Aimed, Weakening, Light):
    """Spot light: a point light that shines only inside a cone.

    Inside the cone, cos θ to the power `exponent` multiplies the light, with θ the angle off the axis. Outside the
    cone, no light arrives (OpenGL 2.1 specification, section 2.14.1, equation 2.5).

    Parameters
    ----------
    position : sequence of float, default (0, 0, 0)
        Its position, in the mesh's unit.
    direction : sequence of float, default (0, 0, -1)
        Axis of the cone, in the direction in which the light travels; of any length.
    cone_angle : float, default 30
        Angle in degrees from the axis to the cone's edge (half the opening), 0 < cone_angle <= 90.
    exponent : float, default 1
        Falloff from the axis to the edge; >= 0. With 0, the cone is uniform.
    attenuation : sequence of float, default (1, 0, 0)
        Constant c, linear l and quadratic q in 1 / (c + l·d + q·d²), d the distance; >= 0, not all zero.
    **common
        The fields of every light: `diffuse`, `specular`, `ambient`, `intensity`, `on`, `frame`, `name`.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> spot = ph.SpotLight.at((2, -1, 2), target=(0, 0, 0), cone_angle=12)
    >>> lit = pv.Sphere().phong.shade(spot)
    """

    position: VectorLike = place()
    direction: VectorLike = aim()
    cone_angle: float = angle(30.0, "cone", above=0.0, at_most=90.0, remedy=_HALF)
    exponent: float = meaning(FalloffPower(partial(check.number, at_least=0.0)), 1.0)
    attenuation: VectorLike = meaning(COEFFICIENTS, NONE)

    @cached_property
    def axis(self) -> Vector:
        """Unit vector along the cone's axis, the direction in which the light travels.

        The vector is rounded in the same way as unit vectors to the light.
        """
        return times(*moderate_vector(self.direction))

    @property
    def placement(self) -> PunctualParameters:
        """Position and attenuation of the light, and the falloff off the cone's axis."""
        # if the gain were larger, the light would be clamped before the falloff reduces it again
        most_gain = BRIGHTEST * (self.attenuation[0] or 1.0) if self.exponent else math.inf
        edge = 2.0 if self.cone_angle == 90.0 else 4.0 * math.sin(math.radians(self.cone_angle) / 2.0) ** 2
        own, power = (*self.axis, edge), Power(self.exponent)
        return super().placement._replace(falloff=_in_cone, power=power, parameters=own, most_gain=most_gain)
