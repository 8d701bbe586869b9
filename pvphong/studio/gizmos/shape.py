"""Where a light stands in a window, and where it shines to: read from its fields by their roles."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array, Vector
from pvphong.base.vectors import unit_vector
from pvphong.optics.light import Light
from pvphong.optics.roles import Aim, Falloff, Place, Role, Turn
from pvphong.studio.gizmos.drag_start import Scenery, vector

ORIGIN = "origin"
"""The handle of a light without a place at its icon; its aim has another one at the target."""

# Of a light without a place, in scene sizes: how far off the scene's middle its icon stands; how long its arrow is.
_STANDS_OFF = 0.95
_ARROW = 0.6 * _STANDS_OFF
# A direction's own length is the distance of the target where that can be seen and grabbed, in scene sizes.
_NEAREST, _FARTHEST = 0.05, 20.0


def is_movable(light: Light) -> bool:
    """Whether a hand can move it: a headlight is where the viewer is, and other lights may be the same everywhere."""
    return light.frame != "headlight" and (comes_from_somewhere(light) or bool(light.values(Turn)))


def comes_from_somewhere(light: Light) -> bool:
    """Whether it comes from one place or direction, not from all around."""
    return bool(light.places or light.values(Aim))


def fields(light: Light, kind: type[Role]) -> dict[str, Any]:
    """Name of each of its fields with a role → value."""
    return {field: getattr(light, field) for field, role in light.roles.items() if isinstance(role, kind)}


def handle_names(light: Light) -> dict[str, str]:
    """Each of its fields that can have a handle → the handle's name, which is the field's own where it is taken."""
    names: dict[str, str] = {}
    for field, role in light.roles.items() if is_movable(light) else ():
        if role.handle:
            names[field] = field if role.handle in names.values() else role.handle
    return names


def falloffs(light: Light) -> dict[str, Vector]:
    """Name of each of its fields that says how it weakens to all sides alike → coefficients.

    A light with an aim has none here: its target says how far it is meant to reach.
    """
    if light.values(Aim):
        return {}
    return {field: value for field, value in fields(light, Falloff).items() if light.roles[field].handle}


def turned_by_icon(light: Light) -> str | None:
    """The field that a drag of its icon changes: the aim of a light without a place; None of any other light."""
    return None if light.places or not is_movable(light) else next(iter(fields(light, Aim)), None)


def around_middle(center: Vector, size: float) -> Scenery:
    """A scene in front of whose middle a light without a place stands, where it comes from; it turns around that."""
    return Scenery(center, size, center, _STANDS_OFF * size)


def held(light: Light, handle: str, scenery: Scenery) -> Scenery:
    """The scenery while a handle is dragged: a light without a place turns around its icon, or its icon around it.

    An icon that stood in front of the scene's middle turns around that.
    """
    field = turned_by_icon(light)
    if field is None or handle not in (ORIGIN, handle_names(light)[field]):
        return scenery
    icon, behind = origin(light, scenery), _STANDS_OFF * scenery.size if handle == ORIGIN else 0.0
    return replace(scenery, anchor=vector(icon + behind * np.array(unit_vector(getattr(light, field)))), behind=behind)


def origin(light: Light, scenery: Scenery) -> Float64Array:
    """Where its icon stands."""
    if light.places:
        return np.mean(light.places, axis=0)
    along = axis(light)
    if along is None and light.values(Turn):
        return front(light, scenery)
    return np.array(scenery.anchor) - (0.0 if along is None else scenery.behind * along)


def front(light: Any, scenery: Scenery) -> Float64Array:
    """Where the front of a light that can be turned stands, on a circle around the scene's middle."""
    return np.asarray(scenery.center + _STANDS_OFF * scenery.size * light.axes[0])


def front_normal(outline: Float64Array) -> Float64Array:
    """Unit normal of an outline, around which it runs counter-clockwise."""
    offsets = outline - outline[0]
    return np.array(unit_vector(np.cross(offsets, np.roll(offsets, -1, axis=0)).sum(axis=0).tolist()))


def middle_of(light: Light, field: str) -> Float64Array:
    """Where the middle of its corners is."""
    return np.mean(getattr(light, field), axis=0)


def axis(light: Light) -> Float64Array | None:
    """Unit vector along its aim, the first if it has several."""
    return next((np.array(unit_vector(direction)) for direction in light.values(Aim)), None)


def target(light: Light, direction: Any, scenery: Scenery) -> Float64Array:
    """Where it shines to, along a direction of its own."""
    return origin(light, scenery) + reach(light, direction, scenery) * np.array(unit_vector(direction))


def reach(light: Light, direction: Any, scenery: Scenery) -> float:
    """How far from its icon a target is shown: as far as the direction is long, where that can be seen."""
    if not light.values(Place):
        return _ARROW * scenery.size
    length = math.hypot(*direction)
    if _NEAREST * scenery.size <= length <= _FARTHEST * scenery.size:
        return length
    to_middle = np.array(scenery.center) - origin(light, scenery)
    return max(float(np.linalg.norm(to_middle)), 0.5 * scenery.size)
