"""The gizmo of a spot light: its position, its target and the edge of its cone."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pvphong.base.types import Float64Array, Vector
from pvphong.optics.lights import SpotLight
from pvphong.studio.gizmos.drawing import Drawing, circle
from pvphong.studio.gizmos.press import Cursor, Place, Press, aimed, vector
from pvphong.studio.gizmos.view import View

# A direction's own length is the distance of the target where that can be seen and grabbed, in scene sizes.
_NEAREST, _FARTHEST = 0.05, 20.0
# The cone stays a cone: VTK takes 90 degrees for a point light.
_NARROWEST, _WIDEST = 0.5, 89.5


def axis(light: SpotLight) -> Float64Array:
    """Unit vector along the cone's axis."""
    return np.array(light.axis)


def reach(light: SpotLight, place: Place) -> float:
    """How far from the light its target is shown."""
    length = math.hypot(*light.direction)
    if _NEAREST * place.size <= length <= _FARTHEST * place.size:
        return length
    return max(float(np.linalg.norm(np.array(place.center) - light.position)), 0.5 * place.size)


def handles(light: SpotLight, place: Place, view: View) -> dict[str, Float64Array]:
    """Its position, its target, and the edge of the cone as far away as the target, at the side seen best."""
    position, far = np.array(light.position), reach(light, place)
    side = across(axis(light), view, position)
    return {
        "position": position,
        "target": position + far * axis(light),
        "cone": _edge(light, light.cone_angle, side, far),
    }


def across(along: Float64Array, view: View, point: Float64Array) -> Float64Array:
    """Unit vector square to an axis and as nearly as can be in the picture; an axis at the eye: to the right."""
    side = np.cross(along, view.towards_eye(point))
    if np.linalg.norm(side) < 1e-3:
        right = view.viewer.axes[0]
        side = right - (right @ along) * along
    return side / np.linalg.norm(side)


def _edge(light: SpotLight, angle: float | Float64Array, side: Float64Array, far: float) -> Float64Array:
    """Points at a distance from the light and angles in degrees off its axis."""
    turn = np.radians(angle)[..., None]
    return np.array(light.position) + far * (np.cos(turn) * axis(light) + np.sin(turn) * side)


def drag(press: Press, at: Cursor) -> SpotLight:
    """The light that the cursor asks for."""
    light = press.light
    assert isinstance(light, SpotLight)
    if press.handle == "cone":
        return replace(light, cone_angle=_opened(light, press, at))
    if press.handle == "target":
        return replace(light, direction=aimed(press, at, vector(light.position), vector(light.direction)))
    return _moved(light, press, at)


def _moved(light: SpotLight, press: Press, at: Cursor) -> SpotLight:
    """The light in another place, aimed at the same target."""
    position = press.moved_on_grid(at)
    aim = np.array(light.position) + reach(light, press.place) * axis(light) - position
    if np.array_equal(position, light.position) or not aim.any():
        return light
    return replace(light, position=vector(position), direction=vector(aim))


def _opened(light: SpotLight, press: Press, at: Cursor) -> float:
    """The angle at which the cone's edge comes nearest to the cursor on the screen."""
    if not press.motion(at).any():
        return float(light.cone_angle)
    side = across(axis(light), press.view, np.array(light.position))
    far = reach(light, press.place)
    best, width = 0.5 * (_NARROWEST + _WIDEST), _WIDEST - _NARROWEST
    for _ in range(5):  # each round looks 40 times closer, around the best
        angles = np.clip(best + width * np.linspace(-0.5, 0.5, 81), _NARROWEST, _WIDEST)
        off = np.linalg.norm(press.view.project(_edge(light, angles, side, far)) - press.picture(at), axis=1)
        if np.isnan(off).all():
            return float(light.cone_angle)
        best, width = float(angles[np.nanargmin(off)]), width / 20.0
    if at.snapping:
        best = round(best / press.angle_step) * press.angle_step
    return min(max(best, _NARROWEST), _WIDEST)


def draw(drawing: Drawing, light: SpotLight, place: Place, selected: bool) -> None:
    """A lamp and a line to the target; selected: the cone with eight spokes, and where its exponent halves it."""
    position, far = np.array(light.position), reach(light, place)
    along, half = axis(light), math.radians(light.cone_angle)
    drawing.icon(position, "lamp", along)
    drawing.line(np.array([position, position + far * along]), 0.8 if selected else 0.45)
    rim = circle(position + far * math.cos(half) * along, along, far * math.sin(half))
    drawing.line(rim, 1.0 if selected else 0.3)
    if not selected:
        return
    for spoke in rim[:-1].reshape(8, -1, 3)[:, 0]:
        drawing.line(np.array([position, spoke]), 0.6)
    if light.exponent:
        halved = math.acos(2.0 ** (-1.0 / light.exponent))
        if halved < half:
            drawing.line(circle(position + far * math.cos(halved) * along, along, far * math.sin(halved)), 0.5)


def arriving(light: SpotLight, place: Place) -> tuple[str, Vector]:
    """Where the light is measured for the readout: at its target."""
    return "at the target", vector(np.array(light.position) + reach(light, place) * axis(light))
