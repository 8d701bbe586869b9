"""Handles by role: where the handle of a light's field is, and what a drag of it makes of the light.

A place has its handle where it is, an aim at the target, and at the icon if the light has no place; an angle at the
edge as far away as the target and at the side seen best. A length has it to the right or above, at its share of this
distance, on the outline of a light that has one; a falloff to the right where half the light is left, if the light has
no aim; a turn at the light's front.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.types import Float64Array
from pvphong.optics.attenuation import distance_of
from pvphong.optics.light import Light
from pvphong.optics.roles import Aim, Angle, Corners, Falloff, Length, Place, Role, Turn, Up
from pvphong.studio.gizmos.drag_start import Cursor, DragStart, Scenery, vector
from pvphong.studio.gizmos.shape import (
    ORIGIN,
    axis,
    fields,
    front,
    front_normal,
    handle_names,
    middle_of,
    origin,
    reach,
    target,
    turned_by_icon,
)
from pvphong.studio.gizmos.view import View

# An angle stays so many degrees off its limits: a cone of 0° cannot be seen, and one of 90° is none to VTK.
_MARGIN = 0.5
# All turns, and a little more, lest the nearest is at an end. A circle that is seen edge-on has two places under the
# cursor: so many pixels farther counts the one a degree farther.
_TURNS = np.linspace(-190.0, 190.0, 761)
_RELUCTANCE = 0.02


class _Kind(NamedTuple):
    """What holds for the handles of one role."""

    where: Callable[[Light, str, Scenery, View], Float64Array | None]
    """From a light and the field's name to the handle's place; None where there is none."""

    dragged: Callable[[DragStart, Cursor, str], Light]
    """From the start, the cursor and the field's name to the light."""


def handles(light: Light, scenery: Scenery, view: View) -> dict[str, Float64Array]:
    """Name of each handle of a light of the world → where it is."""
    found = {}
    for name, (field, kind) in _kinds(light).items():
        point = kind.where(light, field, scenery, view)
        if point is not None:
            found[name] = point
    return found


def dragged(start: DragStart, at: Cursor) -> Light:
    """The light that the cursor asks for."""
    field, kind = _kinds(start.light)[start.handle]
    return kind.dragged(start, at, field)


def _kinds(light: Light) -> dict[str, tuple[str, _Kind]]:
    """Name of each handle → its field, and what holds for it."""
    kinds = {
        name: (field, kind)
        for field, name in handle_names(light).items()
        for role, kind in _KINDS.items()
        if isinstance(light.roles[field], role)
    }
    field = turned_by_icon(light)
    return kinds if field is None else kinds | {ORIGIN: (field, _ICON)}


def _with(light: Light, field: str, value: Any) -> Light:
    return replace(light, **{field: value})


# -- a place


def _at_place(light: Light, field: str, scenery: Scenery, view: View) -> Float64Array:  # noqa: ARG001 as others
    return np.array(getattr(light, field))


def _moved(start: DragStart, at: Cursor, field: str) -> Light:
    return moved_to(start.light, field, start.moved_on_grid(at), start.scenery)


def moved_to(light: Light, field: str, position: Float64Array, scenery: Scenery) -> Light:
    """The light in another place, aimed at the same target; as it is where that is the target itself."""
    if np.array_equal(position, getattr(light, field)):
        return light
    changes: dict[str, Any] = {field: vector(position)}
    for name, direction in fields(light, Aim).items() if field == next(iter(fields(light, Place))) else ():
        aim = target(light, direction, scenery) - position
        if not aim.any():
            return light
        changes[name] = vector(aim)
    return replace(light, **changes)


# -- corners


def _at_middle(light: Light, field: str, scenery: Scenery, view: View) -> Float64Array:  # noqa: ARG001 as others
    return middle_of(light, field)


def _carried(start: DragStart, at: Cursor, field: str) -> Light:
    return carried_to(start.light, field, start.moved_on_grid(at))


def carried_to(light: Light, field: str, middle: Float64Array) -> Light:
    """The light with the middle of its corners in another place."""
    way = middle - middle_of(light, field)
    return _with(light, field, tuple(vector(np.add(corner, way)) for corner in getattr(light, field)))


# -- an aim


def _at_target(light: Light, field: str, scenery: Scenery, view: View) -> Float64Array:  # noqa: ARG001 as others
    return target(light, getattr(light, field), scenery)


def _turned(start: DragStart, at: Cursor, field: str) -> Light:
    """The light aimed at the target's new place; snapping: in steps of azimuth and elevation about z."""
    light, goal = start.light, start.moved(at)
    if np.array_equal(goal, start.point):
        return light
    return _towards(start, at, field, goal - origin(light, start.scenery))


def _towards(start: DragStart, at: Cursor, field: str, aim: Float64Array) -> Light:
    """The light with an aim; snapping: with the nearest step of it."""
    length = float(np.linalg.norm(aim))
    return aimed(start.light, field, _in_steps(aim, length, start.angle_step) if at.snapping and length else aim)


def aimed(light: Light, field: str, aim: Float64Array) -> Light:
    """The light with another aim; as it is where that is none."""
    return _with(light, field, vector(aim)) if aim.any() else light


def _in_steps(aim: Float64Array, length: float, degrees: float) -> Float64Array:
    step = math.radians(degrees)
    azimuth = round(math.atan2(aim[1], aim[0]) / step) * step
    elevation = round(math.asin(max(-1.0, min(1.0, aim[2] / length))) / step) * step
    level = length * math.cos(elevation)
    aim = np.array([level * math.cos(azimuth), level * math.sin(azimuth), length * math.sin(elevation)])
    aim[np.abs(aim) < 1e-15 * length] = 0.0
    return aim


# -- an aim, by the icon


def _at_icon(light: Light, field: str, scenery: Scenery, view: View) -> Float64Array:  # noqa: ARG001 as others
    return origin(light, scenery)


def _swung(start: DragStart, at: Cursor, field: str) -> Light:
    """The light that comes from the icon's new place, as seen from what it turns around; snapping as a target does."""
    goal = start.moved(at)
    if np.array_equal(goal, start.point):
        return start.light
    return _towards(start, at, field, np.array(start.scenery.anchor) - goal)


# -- an angle


def _at_edge(light: Light, field: str, scenery: Scenery, view: View) -> Float64Array | None:
    along = axis(light)
    return None if along is None else _edge(light, along, getattr(light, field), scenery, view)


def _edge(light: Light, along: Float64Array, degrees: Any, scenery: Scenery, view: View) -> Float64Array:
    """Points as far away as the target and angles off the aim, at the side seen best."""
    middle, turn = origin(light, scenery), np.radians(degrees)[..., None]
    far, side = reach(light, light.values(Aim)[0], scenery), view.across(along, middle)
    return middle + far * (np.cos(turn) * along + np.sin(turn) * side)


def _opened(start: DragStart, at: Cursor, field: str) -> Light:
    """The light at whose angle the edge comes nearest to the cursor on the screen."""
    light, role, along = start.light, start.light.roles[field], axis(start.light)
    assert isinstance(role, Angle)
    assert along is not None
    if not start.motion(at).any():
        return light
    least, most = role.least + _MARGIN, role.most - _MARGIN
    best = _nearest(
        start,
        at,
        lambda degrees: _edge(light, along, degrees, start.scenery, start.view),
        np.linspace(least, most, 81),
    )
    if best is None:
        return light
    if at.snapping:
        best = round(best / start.angle_step) * start.angle_step
    return _with(light, field, min(max(best, least), most))


def _nearest(
    start: DragStart, at: Cursor, places: Callable[[Any], Float64Array], tried: Float64Array, reluctance: float = 0.0
) -> float | None:
    """Of numbers in a range, the one whose place comes nearest to the cursor on the screen; None if none is seen.

    Parameters
    ----------
    start, at
        The drag.
    places : callable
        From numbers, shape (n,), to points, shape (n, 3).
    tried : numpy.ndarray
        From the least number to the largest, in steps in which the nearest can be told.
    reluctance : float, default 0
        So many pixels farther counts a place for each 1 that its number is off zero.
    """
    best, limits, step = 0.0, (tried[0], tried[-1]), float(tried[1] - tried[0])
    for _ in range(5):  # each round looks 20 times closer, around the best
        off = np.linalg.norm(start.view.project(places(tried)) - start.picture(at), axis=1)
        if np.isnan(off).all():
            return None
        best = float(tried[np.nanargmin(off + reluctance * np.abs(tried))])
        tried = np.clip(best + step * np.linspace(-1.0, 1.0, 41), *limits)
        step /= 20.0
    return best


# -- a length


def _at_size(light: Light, field: str, scenery: Scenery, view: View) -> Float64Array:
    role = light.roles[field]
    assert isinstance(role, Length)
    return origin(light, scenery) + role.share * getattr(light, field) * _side(light, role.axis, view)


def _side(light: Any, axis: int, view: View) -> Float64Array:
    """Unit vector from a light's middle to the handle of a size: to the right or above, in its plane if it has one."""
    shown = view.viewer.axes[axis]
    if light.values(Up):
        side = light.axes[1 + axis]
    elif light.outline is not None:
        side = view.level(front_normal(light.outline))
    else:
        return shown
    return np.asarray(side if side @ shown >= 0.0 else -side)


def _stretched(start: DragStart, at: Cursor, field: str) -> Light:
    """The light of whose length the handle's share is as far as the cursor is."""
    light, role = start.light, start.light.roles[field]
    assert isinstance(role, Length)
    distance = _distance(start, at, _side(light, role.axis, start.view) if light.values(Up) else None)
    return light if distance is None else _with(light, field, distance / role.share)


def _distance(start: DragStart, at: Cursor, along: Float64Array | None = None) -> float | None:
    """How far from the light the cursor is, > 0, along an axis or else parallel to the picture; snapping: in steps."""
    middle, view = origin(start.light, start.scenery), start.view
    if not view.is_ahead(middle) or not start.motion(at).any():
        return None
    if along is None:
        distance = float(np.linalg.norm(view.facing(middle, start.picture(at)) - middle))
    else:
        distance = float((view.along(np.array(start.point), along, start.motion(at)) - middle) @ along)
    if at.snapping:
        distance = max(round(distance / start.grid), 1) * start.grid
    return max(distance, 1e-6 * start.scenery.size)


# -- a falloff


def _at_half(light: Light, field: str, scenery: Scenery, view: View) -> Float64Array | None:
    """An aim says already how far the light is meant to reach."""
    radius = None if light.values(Aim) else distance_of(0.5, getattr(light, field))
    return None if radius is None else origin(light, scenery) + radius * view.viewer.axes[0]


def _weakened(start: DragStart, at: Cursor, field: str) -> Light:
    """Linear and quadratic coefficient scaled so that half the light is left at the cursor's distance."""
    distance = _distance(start, at)
    return start.light if distance is None else fading_at(start.light, field, distance)


def fading_at(light: Light, field: str, distance: float) -> Light:
    """The light of which half is left at another distance > 0."""
    constant, linear, quadratic = getattr(light, field)
    old = distance_of(0.5, (constant, linear, quadratic))
    if old is None:
        return light
    shrink = old / distance
    return _with(light, field, (constant, linear * shrink, quadratic * shrink * shrink))


# -- a turn


def _at_front(light: Light, field: str, scenery: Scenery, view: View) -> Float64Array:  # noqa: ARG001 as others
    return front(light, scenery)


def _spun(start: DragStart, at: Cursor, field: str) -> Light:
    """The light whose front comes nearest to the cursor on the screen; snapping: in steps of degrees."""
    light: Any = start.light
    middle, (ahead, right, _) = np.array(start.scenery.center), light.axes
    far = float(np.linalg.norm(start.point - middle))

    def fronts(turns: Any) -> Float64Array:
        turns = np.radians(turns)[:, None]
        return np.asarray(middle + far * (np.cos(turns) * ahead - np.sin(turns) * right))

    turn = _nearest(start, at, fronts, _TURNS, _RELUCTANCE) if start.motion(at).any() else None
    if turn is None:
        return light
    degrees = getattr(light, field) + turn
    if at.snapping:
        degrees = round(degrees / start.angle_step) * start.angle_step
    return _with(light, field, math.remainder(degrees, 360.0))


_KINDS: dict[type[Role], _Kind] = {
    Place: _Kind(_at_place, _moved),
    Corners: _Kind(_at_middle, _carried),
    Aim: _Kind(_at_target, _turned),
    Angle: _Kind(_at_edge, _opened),
    Length: _Kind(_at_size, _stretched),
    Falloff: _Kind(_at_half, _weakened),
    Turn: _Kind(_at_front, _spun),
}
"""Role → its handles; a role that is not here has none."""

_ICON = _Kind(_at_icon, _swung)
"""The other handle of the aim of a light without a place."""
