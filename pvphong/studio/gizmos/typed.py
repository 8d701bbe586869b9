"""Values that can be typed, by role: what a handle's numbers are called, and what they make of the light.

All in the world, as readouts show them: a place and a target by their coordinates, the aim of a light without a place
by azimuth and elevation, at its icon by those of where it comes from, an angle, a length, and the distance at which
half the light is left.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, Vector
from pvphong.base.vectors import unit_vector
from pvphong.optics.attenuation import distance_of
from pvphong.optics.light import Light
from pvphong.optics.roles import Aim, Angle, Corners, Falloff, Length, Place, Role, Turn
from pvphong.studio.gizmos.drag_start import Scenery, vector
from pvphong.studio.gizmos.handles import aimed, carried_to, fading_at, moved_to
from pvphong.studio.gizmos.shape import ORIGIN, handle_names, middle_of, origin, target, turned_by_icon

INTENSITY = "intensity"
"""What is typed for a light as a whole, beside its handles."""

CHARACTERS = frozenset("0123456789.+-exyz ")
"""Of what typed text consists; a comma counts as a decimal point."""


class _Kind(NamedTuple):
    """What holds for the numbers of one role."""

    read: Callable[[Light, str, Scenery], dict[str, float]]
    """From a light, a field and the scenery to label → number, in the order in which they are typed."""

    write: Callable[[Light, str, dict[str, float], Scenery], Light]
    """The light with all of these numbers."""


def numbers(light: Light, handle: str, scenery: Scenery) -> dict[str, float]:
    """Label → number of what a handle of a light of the world sets, or of its intensity."""
    if handle == INTENSITY:
        return {INTENSITY: light.intensity}
    field, kind = _of(light, handle)
    return kind.read(light, field, scenery)


def with_numbers(light: Light, handle: str, given: dict[str, float], scenery: Scenery) -> Light:
    """A light of the world with some of a handle's numbers changed.

    Raises
    ------
    ValueError
        If the light allows no such value.
    """
    if handle == INTENSITY:
        return replace(light, intensity=given.get(INTENSITY, light.intensity))
    field, kind = _of(light, handle)
    known = kind.read(light, field, scenery)
    if all(known[label] == value for label, value in given.items()):
        return light
    written = kind.write(light, field, known | given, scenery)
    if written == light:  # it would shine from its target
        check.refuse(handle, given, "another place", "The light must shine somewhere.")
    return written


def parse(text: str, labels: list[str]) -> dict[str, float]:
    """Label → number of a typed text: numbers in the labels' order; a label of one letter goes to its number.

    Raises
    ------
    ValueError
        If it is no such text, or has too many numbers.
    """
    found: dict[str, float] = {}
    letters = "".join(label for label in labels if len(label) == 1)
    at = 0
    for part in re.findall(f"[{letters}]|[^{letters} ]+" if letters else "[^ ]+", text):
        if part in labels:
            at = labels.index(part)
        elif at == len(labels):
            check.refuse("text", text, f"at most {len(labels)} of {', '.join(labels)}")
        else:
            found[labels[at]] = _number(labels[at], part)
            at += 1
    return found


def _number(label: str, text: str) -> float:
    try:
        return check.number(label, float(text))
    except ValueError:
        check.refuse(label, text, "a number")


def _of(light: Light, handle: str) -> tuple[str, _Kind]:
    turned = turned_by_icon(light) if handle == ORIGIN else None
    if turned is not None:
        return turned, _ICON
    field = next(field for field, name in handle_names(light).items() if name == handle)
    return field, next(kind for role, kind in _KINDS.items() if isinstance(light.roles[field], role))


def _coordinates(point: Any) -> dict[str, float]:
    x, y, z = vector(point)
    return {"x": x, "y": y, "z": z}


def _point(given: dict[str, float]) -> Vector:
    return given["x"], given["y"], given["z"]


# -- a place


def _place(light: Light, field: str, scenery: Scenery) -> dict[str, float]:  # noqa: ARG001 as others
    return _coordinates(getattr(light, field))


def _placed(light: Light, field: str, given: dict[str, float], scenery: Scenery) -> Light:
    return moved_to(light, field, np.array(_point(given)), scenery)


# -- corners


def _middle(light: Light, field: str, scenery: Scenery) -> dict[str, float]:  # noqa: ARG001 as others
    return _coordinates(middle_of(light, field))


def _carried(light: Light, field: str, given: dict[str, float], scenery: Scenery) -> Light:  # noqa: ARG001 as others
    return carried_to(light, field, np.array(_point(given)))


# -- an aim


def _aim(light: Light, field: str, scenery: Scenery) -> dict[str, float]:
    direction = getattr(light, field)
    if light.values(Place):
        return _coordinates(target(light, direction, scenery))
    return _angles(direction)


def _aimed(light: Light, field: str, given: dict[str, float], scenery: Scenery) -> Light:
    if light.values(Place):
        return aimed(light, field, np.array(_point(given)) - origin(light, scenery))
    return aimed(light, field, _along(light, field, given))


def _angles(direction: Any) -> dict[str, float]:
    azimuth, elevation = angles_of(direction)
    return {"azimuth": azimuth, "elevation": elevation}


def _along(light: Light, field: str, given: dict[str, float]) -> Float64Array:
    """The vector with these angles, as long as the field's."""
    check.number("elevation", given["elevation"], at_least=-90.0, at_most=90.0)
    return math.hypot(*getattr(light, field)) * np.array(direction_of(*given.values()))


def angles_of(direction: Any) -> tuple[float, float]:
    """Azimuth about z from x towards y, and elevation above the plane of the two, in degrees."""
    x, y, z = unit_vector(direction)
    return math.degrees(math.atan2(y, x)), math.degrees(math.asin(max(-1.0, min(1.0, z))))


def direction_of(azimuth: float, elevation: float) -> Vector:
    """The unit vector with these angles in degrees; exact along the axes."""
    around, up = math.radians(azimuth), math.radians(elevation)
    parts = math.cos(up) * math.cos(around), math.cos(up) * math.sin(around), math.sin(up)
    x, y, z = (0.0 if abs(part) < 1e-15 else part for part in parts)
    return x, y, z


# -- an aim, by the icon


def _from(light: Light, field: str, scenery: Scenery) -> dict[str, float]:  # noqa: ARG001 as others
    return _angles(np.negative(getattr(light, field)))


def _coming_from(light: Light, field: str, given: dict[str, float], scenery: Scenery) -> Light:  # noqa: ARG001 as others
    return aimed(light, field, 0.0 - _along(light, field, given))  # and no −0


# -- an angle, a length, a turn


def _scalar(light: Light, field: str, scenery: Scenery) -> dict[str, float]:  # noqa: ARG001 as others
    return {handle_names(light)[field]: getattr(light, field)}


def _scaled(light: Light, field: str, given: dict[str, float], scenery: Scenery) -> Light:  # noqa: ARG001 as others
    (value,) = given.values()
    changed: dict[str, Any] = {field: value}
    return replace(light, **changed)


# -- a falloff


def _half(light: Light, field: str, scenery: Scenery) -> dict[str, float]:  # noqa: ARG001 as others
    return {"half left at": distance_of(0.5, getattr(light, field)) or math.inf}


def _faded(light: Light, field: str, given: dict[str, float], scenery: Scenery) -> Light:  # noqa: ARG001 as others
    (distance,) = given.values()
    return fading_at(light, field, check.number("half left at", distance, above=0.0))


_KINDS: dict[type[Role], _Kind] = {
    Place: _Kind(_place, _placed),
    Corners: _Kind(_middle, _carried),
    Aim: _Kind(_aim, _aimed),
    Angle: _Kind(_scalar, _scaled),
    Length: _Kind(_scalar, _scaled),
    Falloff: _Kind(_half, _faded),
    Turn: _Kind(_scalar, _scaled),
}
"""Role → its numbers, for every role that `handles.py` has handles for."""

_ICON = _Kind(_from, _coming_from)
"""Of the aim of a light without a place at its icon."""
