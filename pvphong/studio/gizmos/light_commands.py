"""What keys do to the selected light, and lights that they add. What a light can do is asked of its fields' roles."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from pvphong.base.types import rgb
from pvphong.base.vectors import unit_vector
from pvphong.optics.light import Light
from pvphong.optics.lights import PointLight
from pvphong.optics.roles import Aim
from pvphong.studio.gizmos.colors import hue_turned, luminance, recolored, warmed
from pvphong.studio.gizmos.drag_start import vector
from pvphong.studio.gizmos.gizmo import Gizmo
from pvphong.studio.gizmos.names import called, free_name
from pvphong.studio.gizmos.shape import comes_from_somewhere, fields
from pvphong.studio.gizmos.status import soloed
from pvphong.studio.gizmos.surroundings import Surroundings

_HUE_STEP = 15.0
# Of the scene's size: how high above a surface a new light stands, and how far beside a light its double.
_ABOVE, _BESIDE = 0.4, 0.15


def _chosen(board: Surroundings) -> Gizmo | None:
    if board.selected is None:
        board.notice = "no light is selected: n, or a click on one, does"
    return board.selected


def _change(board: Surroundings, change: Callable[[Light], Light]) -> Light | None:
    """Make the selected light another; gives what it is then."""
    if (gizmo := _chosen(board)) is None:
        return None
    changed = change(gizmo.light)
    gizmo.handle.set(changed, board.view.viewer)
    return changed


def mute(board: Surroundings) -> None:
    """The selected light off, or on."""
    _change(board, lambda light: replace(light, on=not light.on))


def solo(board: Surroundings) -> None:
    """All others off; if they are off already, all on."""
    if (chosen := _chosen(board)) is None:
        return
    viewer, handles = board.view.viewer, board.rig.handles
    others_on = soloed(handles, viewer) is chosen.handle
    for handle in handles:
        handle.set(replace(handle.light(viewer), on=others_on or handle is chosen.handle), viewer)


def to_camera(board: Surroundings) -> None:
    """The light where the eye is, shining along the view axis."""
    viewer = board.view.viewer

    def moved(light: Light) -> Light:
        world = replace(light, frame="headlight").in_world(viewer)
        aim: Any = tuple(viewer.distance * part for part in viewer.view_direction)
        aimed = replace(world, **dict.fromkeys(list(fields(world, Aim))[:1], aim))  # the focal point is its target
        return aimed.in_frame(light.frame, viewer)

    _change(board, moved)


def reset(board: Surroundings) -> None:
    """The light as it was when it got its gizmo."""
    if (gizmo := _chosen(board)) is not None:
        gizmo.handle.set(gizmo.first, board.view.viewer)


# -- intensity and colour


def brighter(board: Surroundings) -> None:
    """A third of a stop more: three make it twice as bright."""
    _brightened(board, 1)


def dimmer(board: Surroundings) -> None:
    """A third of a stop less."""
    _brightened(board, -1)


def _brightened(board: Surroundings, thirds: int) -> None:
    changed = _change(board, lambda light: replace(light, intensity=by_thirds(light.intensity, thirds)))
    if changed is not None:
        stops = f" = {math.log2(changed.intensity):+.2g} stops" if changed.intensity else ": Enter, to type one"
        board.notice = f"{called(changed)}: intensity {changed.intensity:.4g}{stops}"


def by_thirds(intensity: float, thirds: int) -> float:
    """An intensity times 2^(thirds/3); on the scale of thirds around 1 without rounding errors piling up."""
    if not intensity:
        return 0.0
    steps = 3.0 * math.log2(intensity)
    if abs(steps - round(steps)) < 1e-9:
        return float(2.0 ** ((round(steps) + thirds) / 3.0))
    return float(intensity * 2.0 ** (thirds / 3.0))


def hue_on(board: Surroundings) -> None:
    """The hue a step on: red, yellow, green, blue."""
    _recolor(board, "hue", lambda light: recolored(light, lambda color: hue_turned(color, _HUE_STEP)))


def hue_back(board: Surroundings) -> None:
    """The hue a step back."""
    _recolor(board, "hue", lambda light: recolored(light, lambda color: hue_turned(color, -_HUE_STEP)))


def warmer(board: Surroundings) -> None:
    """More red and less blue, equally bright."""
    _recolor(board, "warmer", lambda light: recolored(light, lambda color: warmed(color, 1.0)))


def cooler(board: Surroundings) -> None:
    """More blue and less red, equally bright."""
    _recolor(board, "cooler", lambda light: recolored(light, lambda color: warmed(color, -1.0)))


def _recolor(board: Surroundings, what: str, change: Callable[[Light], Light]) -> None:
    changed = _change(board, change)
    if changed is not None:
        red, green, blue = rgb(changed.diffuse)
        bright = luminance(changed.diffuse)
        board.notice = f"{called(changed)}: {what}, colour ({red:.3g}, {green:.3g}, {blue:.3g}), luminance {bright:.3g}"


# -- lights that come and go


def add(board: Surroundings) -> None:
    """A point light above the place of a surface that the cursor points at; half of it arrives there."""
    below = board.surfaces.pick(board.cursor)
    if below is None:
        board.notice = "new light: point at a lit mesh"
        return
    height = _ABOVE * board.extent[1]
    place = vector(np.array(below.point) + height * np.array(below.normal))
    _put(board, PointLight(position=place, attenuation=(1.0, 0.0, height**-2), name="point"))


def duplicate(board: Surroundings) -> None:
    """A light like the selected one, a little to the right of it; one without a place comes from the right."""
    if (gizmo := _chosen(board)) is None:
        return
    light, viewer = gizmo.light, board.view.viewer
    if light.frame == "headlight" or not comes_from_somewhere(light):
        where = "is the viewer" if light.frame == "headlight" else "comes from all around"
        board.notice = f"{called(light)}: a light that {where} has no double"
        return
    world, right = light.in_world(viewer), viewer.axes[0]
    if world.places:
        double = world.moved(lambda place: vector(np.array(place) + _BESIDE * board.extent[1] * right))
    else:
        turned: dict[str, Any] = {
            field: vector(np.hypot.reduce(aim) * (np.array(unit_vector(aim)) - 2.0 * _BESIDE * right))
            for field, aim in fields(world, Aim).items()
        }
        double = replace(world, **turned)
    _put(board, double.in_frame(light.frame, viewer))


def _put(board: Surroundings, light: Light) -> None:
    names = [handle.light(board.view.viewer).name for handle in board.rig.handles]
    named = replace(light, name=free_name(light.name or "light", names))
    board.follow(board.rig.add(named))
    board.notice = f"added: {named.name}"


def delete(board: Surroundings) -> None:
    """The selected light gone; `undo` brings it back."""
    if (gizmo := _chosen(board)) is not None:
        board.notice = f"deleted: {called(gizmo.light)}; z brings it back"
        board.rig.remove(gizmo.handle)
