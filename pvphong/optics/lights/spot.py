"""Light from one point inside a cone, brightest along its axis."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np

from pvphong.base.float_range import BRIGHTEST
from pvphong.base.formulas import ONE, ZERO, Power, add, chord_power, formula, square, where
from pvphong.base.types import Float64Array, FloatArray, Vector, VectorLike
from pvphong.base.vectors import angle_between, directions_to, dot, unit_vector
from pvphong.geometry.extent import Extent, Sight
from pvphong.optics import attenuation as weakening
from pvphong.optics.attenuation import attenuate, coefficients, strongest
from pvphong.optics.light import Arrival, Light, Placement, Reach, Simpler, VtkValues
from pvphong.optics.lights.point import PointLight, placed_effects, placed_reach, placed_without
from pvphong.optics.roles import aim, angle, place, power, way_from

CONE = "cone"
"""The plan's effect."""

_HALF = "It is half the opening angle, in degrees; a light without a cone is a PointLight."

# Angles are known to this many radians: arc cosines lose half the digits near 0.
_SLACK = 1e-6


@formula
def _in_cone(own: Any, l: Any) -> Any:
    """1 inside the cone and 0 outside, and |C|² for the chord C between the axis and the ray: cos θ = 1 − ½|C|².

    By the chord, narrow cones and high exponents keep their digits, where a cosine near 1 has lost them.
    """
    chord = square(add((own[0], own[1], own[2]), l))
    return where(chord <= own[3], ONE, ZERO), chord


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

    position: VectorLike = place()
    direction: VectorLike = aim()
    cone_angle: float = angle(30.0, "cone", above=0.0, at_most=90.0, remedy=_HALF)
    exponent: float = power(1.0)
    attenuation: VectorLike = coefficients()

    @classmethod
    def at(cls, position: VectorLike, *, target: VectorLike, **fields: Any) -> Self:
        """A spot light at a place, which shines at another.

        Parameters
        ----------
        position, target : sequence of float
            Two places that differ.
        **fields
            The other fields of the light.

        Raises
        ------
        ValueError
            As for the light itself, or if the places are the same.
        """
        return cls(position=position, direction=way_from(position, target), **fields)

    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:
        """Direction to the light, shape (3, n), and attenuation times spot factor, shape (n,), at points (3, n)."""
        x, y, z = self.position
        ways, inverse_length, distance = directions_to((x, y, z), points, real)
        factor = self.spot_factor(ways * inverse_length)
        if not distance.min(initial=1.0) > 0.0:  # on the light itself cos θ is taken to be 0
            factor[distance == 0.0] = float(self.cone_angle == 90.0 and self.exponent == 0.0)
        return Arrival(ways, attenuate(distance, self.attenuation) * factor, inverse_length)

    def spot_factor(self, to_light: FloatArray) -> Float64Array:
        """The cosine of θ to the power `exponent` inside the cone, 0 outside, for unit vectors (3, n) to the light."""
        # in float64, for light may be as bright as its falloff is steep
        inside, square = _in_cone((*self.axis, self._edge), to_light.astype(np.float64, copy=False))
        return np.asarray(inside * chord_power(square, self.exponent), np.float64)

    @property
    def _edge(self) -> float:
        """The chord's square at the cone's edge."""
        return 4.0 * math.sin(math.radians(self.cone_angle) / 2.0) ** 2

    @cached_property
    def axis(self) -> Vector:
        """Unit vector along the cone's axis, in which the light travels."""
        return unit_vector(self.direction)

    @cached_property
    def effects(self) -> frozenset[str]:
        """A point light's, and its cone."""
        return placed_effects(self) | {CONE}

    def reach(self, extent: Extent) -> Reach:
        """A point light's: nothing is lost by forgetting the cone."""
        return placed_reach(self, extent)

    def simpler(self, effect: str, extent: Extent, *, exactly: bool) -> Simpler | None:
        """Off outside its cone, a point light inside it; or as one that does not weaken."""
        if effect == weakening.EFFECT:
            return weakening.taken_as_even(self, extent, exactly=exactly)
        seen = extent.sight(self.position) if effect == CONE else None
        if seen is None:
            return None
        middle, edge = math.pi - angle_between(seen.direction, self.axis), math.radians(self.cone_angle)
        least, most = max(middle - seen.turn, 0.0), min(middle + seen.turn, math.pi)
        if least > edge + _SLACK:
            margin = math.degrees(least - edge)
            return Simpler(
                f"mesh lies outside the cone by {f'{margin:.0f}' if margin >= 1.0 else f'{margin:.1g}'}°", None
            )
        if most >= edge - _SLACK or (exactly and self.exponent):
            return None
        return self._as_point(seen, max(least - _SLACK, 0.0), most + _SLACK)

    def _as_point(self, seen: Sight, least: float, most: float) -> Simpler:
        """For vertices between two angles off the axis, all inside the cone."""

        def make() -> Light:
            return PointLight(position=self.position, attenuation=self.attenuation)

        why = "mesh lies inside the cone"
        if self.exponent == 0.0:
            return Simpler(why, make)
        brightest, darkest = (max(math.cos(off_axis), 0.0) ** self.exponent for off_axis in (least, most))
        spread = strongest(seen, self.attenuation) * (brightest - darkest) / 2
        why += ", whose light is even to {bound:.2g}"
        return Simpler(why, make, factor=(brightest + darkest) / 2, spread=spread)

    def without(self, effect: str, point: Vector) -> tuple[Light, float]:
        """A point light, parallel light, or as strong everywhere as at a point."""
        if effect == CONE:
            return PointLight(position=self.position, attenuation=self.attenuation), 1.0
        return placed_without(self, effect, point)

    def offsets(self, points: Float64Array) -> Iterator[Float64Array]:
        """From its position, and from its axis."""
        axis, from_light = np.array(self.axis)[:, None], points - np.array(self.position)[:, None]
        yield from_light
        yield from_light - dot(axis, from_light) * axis

    def edges(self, directions: FloatArray) -> Iterator[FloatArray]:
        """Of the cone."""
        yield self._edge - square(add(self.axis, directions))

    @property
    def placement(self) -> Placement:
        """A point light's, and the spot factor."""
        (x, y, z), (c, l, q) = self.position, self.attenuation
        # beyond it, strength would be cut off before the falloff brings it down again
        most_gain = BRIGHTEST * (c or 1.0) if self.exponent else math.inf
        own = (*self.axis, self._edge)
        return Placement((x, y, z), (c, l, q), _in_cone, Power(self.exponent), own, most_gain)

    def as_vtk(self) -> VtkValues:
        """All its fields. VTK takes a cone of 90° for none, and keeps exponents up to 128."""
        (x, y, z), (c, l, q), (dx, dy, dz) = self.position, self.attenuation, self.direction
        return VtkValues(True, (dx, dy, dz), (x, y, z), (c, l, q), self.cone_angle, self.exponent)
