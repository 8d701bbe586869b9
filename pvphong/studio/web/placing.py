"""The place of a light as angles and distance about its target, for the fields of the page."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.optics.light import Light
from pvphong.optics.roles import MESH_UNIT, Aim, Corners, Place
from pvphong.studio.gizmos.handles import LightInScene, fields, is_movable
from pvphong.studio.gizmos.highlight import rotation
from pvphong.studio.gizmos.view import vector


def _turn(name: str, value: Any, **limits: Any) -> float:
    """Return an angle in degrees within half a turn, −180° to 180°. Angles outside this range are reduced to it.

    `name` and `limits` are for the check of the result.
    """
    number = check.number(name, value)
    return check.number(name, math.remainder(number, 360.0) if abs(number) > 180.0 else number, **limits)


def _distance(name: str, value: Any, **limits: Any) -> float | None:
    return None if value is None else check.number(name, value, **limits)


@dataclass(frozen=True)
class Placing:
    """Place of a light, relative to its target.

    Parameters
    ----------
    azimuth : float
        Direction of the light, in degrees clockwise from +y as seen from above: 90 is at +x, -90 at -x.
    elevation : float
        Angle of the light above the horizontal plane of its target, in degrees.
    distance : float, optional
        Distance of the light from its target; None for a light without a position.
    """

    azimuth: float = check.field(partial(_turn, at_least=-180.0, at_most=180.0), 0.0, unit="°")
    elevation: float = check.field(partial(check.number, at_least=-90.0, at_most=90.0), 0.0, unit="°")
    distance: float | None = check.field(partial(_distance, at_least=0.0), None, unit=MESH_UNIT)

    def __post_init__(self) -> None:
        check.fields(self)

    @property
    def offset(self) -> Float64Array:
        """Vector from the target to the light; a unit vector if there is no distance."""
        turn, height = math.radians(self.azimuth), math.radians(self.elevation)
        across = math.cos(height)
        unit = np.array([math.sin(turn) * across, math.cos(turn) * across, math.sin(height)])
        return unit if self.distance is None else self.distance * unit


def placing_of(shown: LightInScene) -> Placing | None:
    """Return the place of a light relative to its target; None for a headlight and for light from all around."""
    if not is_movable(shown.light) or not (shown.light.places or shown.along is not None):
        return None
    offset = shown.origin - _target(shown)
    if not shown.light.places:
        assert shown.along is not None, "a light without a place has an aim"
        offset = -shown.along
    length = float(np.linalg.norm(offset))
    east, north, up = offset.tolist()
    level = math.hypot(east, north)
    azimuth = math.degrees(math.atan2(east, north)) if level > 1e-9 * length else 0.0
    return Placing(azimuth, math.degrees(math.atan2(up, level)), length if shown.light.places else None)


def placed(shown: LightInScene, placing: Placing) -> Light:
    """Return the light at another place relative to its target, in world coordinates. It still shines on the target.

    Raises
    ------
    ValueError
        If the light would be at its target.
    """
    light, target, offset = shown.light, _target(shown), placing.offset
    if not offset.any():
        check.refuse("distance", placing.distance, "> 0", "A light cannot be at its target.")
    changes: dict[str, Any] = {}
    for name in list(fields(light, Place))[:1]:
        changes[name] = vector(target + offset)
    for name, aim in list(fields(light, Aim).items())[:1]:
        length = float(np.linalg.norm(offset if light.places else aim))
        changes[name] = vector(-length * offset / np.linalg.norm(offset))
    for name, corners in fields(light, Corners).items():
        turn = rotation(shown.origin - target, offset / np.linalg.norm(offset))
        changes[name] = tuple(vector(target + offset + turn @ (corner - shown.origin)) for corner in np.array(corners))
    return replace(light, **changes)


def _target(shown: LightInScene) -> Float64Array:
    """Return the point on which a light shines: its target, or the scene's centre for a light without an aim."""
    aims = shown.light.values(Aim)
    return shown.target(aims[0]) if aims and shown.light.places else np.array(shown.scenery.center)
