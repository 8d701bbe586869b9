"""Light from one point inside a cone, brightest along its axis."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.base.vectors import dot, unit_vector, ways_to
from pvphong.optics.light import Arrival, EyeSpace, Light, place_for_vtk, point_ahead
from pvphong.optics.lights.point import attenuate, check_attenuation

if TYPE_CHECKING:
    import pyvista as pv


@dataclass(frozen=True)
class SpotLight(Light):
    """A point light that shines only inside a cone.

    Inside, it is weakened by cos θ to the power `exponent`, θ the angle off the axis; outside it is dark
    (OpenGL 2.1 specification, section 2.14.1, equation 2.5).

    Parameters
    ----------
    position : sequence of float, default (0, 0, 0)
        Where it stands, in the mesh's unit.
    direction : sequence of float, default (0, 0, -1)
        Axis of the cone, in the direction in which the light travels; of any length.
    cone_angle : float, default 30
        Angle in degrees from the axis to the cone's edge (half the opening), 0 < cone_angle <= 90.
    exponent : float, default 1
        Falloff from the axis to the edge; >= 0, and 0 is an evenly lit cone.
    attenuation : sequence of float, default (1, 0, 0)
        As for a point light.
    **common
        The fields of every light: `diffuse`, `specular`, `ambient`, `intensity`, `on`, `frame`, `name`.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.
    """

    position: VectorLike = (0.0, 0.0, 0.0)
    direction: VectorLike = (0.0, 0.0, -1.0)
    cone_angle: float = 30.0
    exponent: float = 1.0
    attenuation: VectorLike = (1.0, 0.0, 0.0)

    def _check_geometry(self) -> None:
        self._set("position", check.vector("position", self.position))
        self._set("direction", check.direction("direction", self.direction))
        remedy = "It is half the opening angle, in degrees; a light without a cone is a PointLight."
        self._set("cone_angle", check.number("cone_angle", self.cone_angle, above=0.0, at_most=90.0, remedy=remedy))
        self._set("exponent", check.number("exponent", self.exponent, at_least=0.0))
        self._set("attenuation", check_attenuation(self.attenuation))

    def in_world(self, viewer: EyeSpace) -> SpotLight:
        """This light with position and direction in the world, as `viewer` makes them."""
        if self.frame == "camera":
            (px, py, pz), (dx, dy, dz) = self.position, self.direction
            position, direction = viewer.point_to_world((px, py, pz)), viewer.vector_to_world((dx, dy, dz))
            return replace(self, position=position, direction=direction, frame="world")
        if self.frame == "headlight":
            return replace(self, position=viewer.position, direction=viewer.view_direction, frame="world")
        return self

    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:
        """Direction to the light, shape (3, n), and attenuation times spot factor, shape (n,), at points (3, n)."""
        x, y, z = self.position
        ways, inverse_length, distance = ways_to((x, y, z), points, real)
        factor = self.spot_factor(ways * inverse_length)
        if not distance.min(initial=1.0) > 0.0:  # on the light itself cos θ is taken to be 0
            factor[distance == 0.0] = float(self.cone_angle == 90.0 and self.exponent == 0.0)
        return Arrival(ways, attenuate(distance, self.attenuation) * factor, inverse_length)

    def spot_factor(self, to_light: Float64Array) -> Float64Array:
        """The cosine of θ to the power `exponent` inside the cone, 0 outside, for unit vectors (3, n) to the light.

        With the chord D between the axis and the ray, cos θ = 1 − ½|D|²: narrow cones and high exponents
        keep their digits, where a cosine near 1 has lost them.
        """
        axis = np.array(self.axis)[:, None]
        chord = axis + to_light
        square = dot(chord, chord)
        edge = 4.0 * math.sin(math.radians(self.cone_angle) / 2.0) ** 2
        inside = square <= edge
        if self.exponent == 0.0:
            return inside.astype(np.float64)
        with np.errstate(divide="ignore", over="ignore"):  # the far hemisphere: log of 0 gives 0 in the end
            falloff = np.exp(self.exponent * np.log1p(-np.minimum(0.5 * square, 1.0)))
        return np.where(inside, falloff, 0.0)

    @cached_property
    def axis(self) -> Vector:
        """Unit vector along the cone's axis, in which the light travels."""
        return unit_vector(self.direction)

    def _place(self, light: pv.Light, distance: float) -> None:
        (px, py, pz), (dx, dy, dz) = self.position, self.direction
        light.SetPositional(True)
        light.SetConeAngle(self.cone_angle)
        light.SetExponent(self.exponent)
        light.SetAttenuationValues(*self.attenuation)
        position = place_for_vtk((px, py, pz), self.frame, distance)
        light.SetPosition(position)
        light.SetFocalPoint(point_ahead(position, (dx, dy, dz)))
