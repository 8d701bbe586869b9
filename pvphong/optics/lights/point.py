"""Light from one point, weaker with distance (OpenGL's w ≠ 0)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from pvphong.base.types import Vector, VectorLike
from pvphong.geometry.extent import ROUNDED_UP, TURN_SLACK, Extent
from pvphong.optics.attenuation import COEFFICIENTS, NONE, attenuate, strength_at, strongest
from pvphong.optics.attenuation import EFFECT as ATTENUATION_EFFECT
from pvphong.optics.light import POSITION_EFFECT, Light, Placement, Reach, StandIn, VtkValues
from pvphong.optics.lights.directional import DirectionalLight
from pvphong.optics.roles import meaning, place

_POSITION = frozenset({POSITION_EFFECT})

# In radii of the vertices' sphere: nearer than this its direction is never taken for the same everywhere.
_FAR = 2


class Weakening:
    """A light with `position` and `attenuation`, whatever its directions. For kinds of `Light`."""

    position: Any
    attenuation: Any

    @property
    def placement(self) -> Placement:
        """Where it is, and how it weakens."""
        return Placement(self.position, self.attenuation)

    @cached_property
    def effects(self) -> frozenset[str]:
        """Its position, and its attenuation if it weakens."""
        return _POSITION if tuple(self.attenuation) == NONE else _POSITION | {ATTENUATION_EFFECT}

    def reach(self, extent: Extent) -> Reach:
        """The nearest vertex gets most; the direction turns as its position is seen."""
        seen = extent.sight(self.position)
        return (
            Reach()
            if seen is None
            else Reach(strongest(seen, self.attenuation), seen.direction, seen.turn + TURN_SLACK)
        )

    def simpler(self, effect: str, extent: Extent, *, exactly: bool) -> StandIn | None:
        """A light that is equally strong at all vertices."""
        if effect != ATTENUATION_EFFECT:
            return None
        this: Any = self

        def even() -> tuple[Light]:
            return (replace(this, attenuation=NONE),)

        constant, linear, quadratic = self.attenuation
        if not linear and not quadratic:
            return StandIn(even, f"constant, {1.0 / constant:g}", 1.0 / constant)
        seen = None if exactly else extent.sight(self.position)
        if seen is None or seen.distance <= seen.radius:
            return None
        radius, why = seen.radius * ROUNDED_UP, "even over the mesh to {bound:.2g}"
        near, far = (strength_at(seen.distance + offset, self.attenuation) for offset in (-radius, radius))
        return StandIn(even, why, (near + far) / 2, (near - far) / 2)

    def without(self, effect: str, point: Vector) -> tuple[Light, float]:
        """Taken as it is at a point: its strength, or with it its direction too."""
        this: Any = self
        if effect == ATTENUATION_EFFECT:
            distance = np.array([math.dist(self.position, point)])
            return replace(this, attenuation=NONE), float(attenuate(distance, self.attenuation)[0])
        return parallel_at(this, point) if effect == POSITION_EFFECT else (this, 1.0)

    def as_vtk(self) -> VtkValues:
        """Position and attenuation; VTK's point light is a spot without a cone."""
        return VtkValues(True, (0.0, 0.0, -1.0), self.position, self.attenuation)


def parallel_at(light: Light, point: Vector) -> tuple[Light, float]:
    """A light taken as it is at a point: parallel light, and its strength."""
    arrival = light.arrival(np.array(point)[:, None])
    x, y, z = (-arrival.direction[:, 0]).tolist()
    if not (x or y or z):  # it is at that very point, where its light comes from nowhere
        return light, 1.0
    return DirectionalLight(direction=(x, y, z)), float(np.broadcast_to(arrival.strength, 1)[0])


@dataclass(frozen=True)
class PointLight(Weakening, Light):
    """Light from a position, in all directions.

    Parameters
    ----------
    position : sequence of float, default (0, 0, 0)
        Where it is, in the mesh's unit.
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
    attenuation: VectorLike = meaning(COEFFICIENTS, NONE)

    def simpler(self, effect: str, extent: Extent, *, exactly: bool) -> StandIn | None:
        """One that does not weaken; where it does not weaken itself, parallel light."""
        if effect != POSITION_EFFECT or exactly or tuple(self.attenuation) != NONE:
            return super().simpler(effect, extent, exactly=exactly)
        seen = extent.sight(self.position)
        if seen is None or seen.distance < _FAR * seen.radius:
            return None
        x, y, z = seen.direction
        why = "far away: its direction is the same to {bound:.2g}"
        return StandIn(lambda: (DirectionalLight(direction=(-x, -y, -z)),), why, turn=seen.turn)
