"""Light from one point, weaker with distance (OpenGL's w ≠ 0)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.base.vectors import directions_to
from pvphong.geometry.extent import Extent
from pvphong.optics import attenuation as weakening
from pvphong.optics.attenuation import attenuate, coefficients, strongest
from pvphong.optics.light import NOTHING_KNOWN, POSITION_EFFECT, Arrival, Light, Placement, Reach, Simpler, VtkValues
from pvphong.optics.lights.directional import DirectionalLight
from pvphong.optics.roles import place

# Radians by which a direction may be off in float64.
_SLACK = 1e-7

# In radii of the vertices' sphere: nearer than this its direction is never taken for the same everywhere.
_FAR = 2


@dataclass(frozen=True)
class PointLight(Light):
    """Light from a position, in all directions.

    Parameters
    ----------
    position : sequence of float, default (0, 0, 0)
        Where it stands, in the mesh's unit.
    attenuation : sequence of float, default (1, 0, 0)
        Constant c, linear l and quadratic q in 1 / (c + l·d + q·d²), d the distance; >= 0, not all zero.
    **common
        The fields of every light: `diffuse`, `specular`, `ambient`, `intensity`, `on`, `frame`, `name`.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.
    """

    position: VectorLike = place()
    attenuation: VectorLike = coefficients()

    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:
        """Direction to the light, shape (3, n), and attenuation, shape (n,), at points (3, n)."""
        x, y, z = self.position
        ways, inverse_length, distance = directions_to((x, y, z), points, real)
        return Arrival(ways, attenuate(distance, self.attenuation), inverse_length)

    @cached_property
    def effects(self) -> frozenset[str]:
        """Its position, and its attenuation if it weakens."""
        return placed_effects(self)

    def reach(self, extent: Extent) -> Reach:
        """What it sends to the nearest vertex."""
        return placed_reach(self, extent)

    def simpler(self, effect: str, extent: Extent, *, exactly: bool) -> Simpler | None:
        """As one that does not weaken; such a one as parallel light."""
        if effect == weakening.EFFECT:
            return weakening.taken_as_even(self, extent, exactly=exactly)
        if exactly or tuple(self.attenuation) != weakening.NONE:
            return None
        seen = extent.sight(self.position)
        if seen is None or seen.distance < _FAR * seen.radius:
            return None
        x, y, z = seen.direction
        why = "far away: its direction is the same to {bound:.2g}"
        return Simpler(why, lambda: DirectionalLight(direction=(-x, -y, -z)), turn=seen.turn)

    def without(self, effect: str, point: Vector) -> tuple[Light, float]:
        """As parallel light, or as strong everywhere as at a point."""
        return placed_without(self, effect, point)

    @property
    def placement(self) -> Placement:
        """Where it stands, and how it weakens."""
        (x, y, z), (c, l, q) = self.position, self.attenuation
        return Placement((x, y, z), (c, l, q))

    def as_vtk(self) -> VtkValues:
        """Position and attenuation; VTK's point light is a spot without a cone."""
        (x, y, z), (c, l, q) = self.position, self.attenuation
        return VtkValues(True, (0.0, 0.0, -1.0), (x, y, z), (c, l, q))


_STEADY = frozenset({POSITION_EFFECT})
_WEAKENING = _STEADY | {weakening.EFFECT}

# What holds for a light with `position` and `attenuation`, whatever its directions.


def placed_effects(light: Any) -> frozenset[str]:
    """The effects that it calls for."""
    return _STEADY if tuple(light.attenuation) == weakening.NONE else _WEAKENING


def placed_reach(light: Any, extent: Extent) -> Reach:
    """The nearest vertex gets most; the direction turns as its position is seen."""
    seen = extent.sight(light.position)
    if seen is None:
        return NOTHING_KNOWN
    return Reach(strongest(seen, light.attenuation), seen.direction, seen.turn + _SLACK)


def placed_without(light: Any, effect: str, point: Vector) -> tuple[Light, float]:
    """Taken as it is at a point: its strength, or with it its direction too."""
    if effect == weakening.EFFECT:
        return weakening.taken_as_at(light, point)
    if effect != POSITION_EFFECT:
        return light, 1.0
    arrival = light.arrival(np.array(point)[:, None])
    x, y, z = (-arrival.direction[:, 0]).tolist()
    if not (x or y or z):  # it is at that very point, where its light comes from nowhere
        return light, 1.0
    return DirectionalLight(direction=(x, y, z)), float(np.broadcast_to(arrival.strength, 1)[0])
