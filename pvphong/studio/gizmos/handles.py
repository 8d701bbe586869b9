"""What a window shows of a light follows from its fields' roles: one class of handles a role.

Each says where the handle is, what a drag of it makes of the light, what can be typed, how the field is drawn, and what
the readout says of it. `LightInScene` is a light of the world with the scene around it: it knows where the light's icon
stands, has its handles, and draws and describes all of it. A role that `_OF_ROLES` does not have has no handle.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from pvphong.base import check
from pvphong.base.color import XYZ_OF_RGB
from pvphong.base.types import ColorLike, Float64Array, rgb
from pvphong.base.vectors import unit_vector
from pvphong.optics.attenuation import distance_of
from pvphong.optics.light import Light
from pvphong.optics.roles import Aim, Angle, Corners, Falloff, Length, Place, Power, Role, Turn, Up
from pvphong.studio.gizmos.drawing import Drawing, circle
from pvphong.studio.gizmos.view import STANDS_OFF, Cursor, DragStart, Scenery, View, vector

ORIGIN = "origin"
"""The handle of a light without a place at its icon; its aim has another one at the target."""

INTENSITY = "intensity"
"""What is typed for a light as a whole, beside the fields that say where it is."""

# The arrow of a light without a place, in scene sizes.
_ARROW = 0.6 * STANDS_OFF
# A direction's own length is the distance of the target where that can be seen and grabbed, in scene sizes.
_NEAREST, _FARTHEST = 0.05, 20.0
# Circles are drawn up to this radius, in scene sizes.
_LARGEST = 1e4
# How long the normal of a front is, in scene sizes, and how many lines fill it.
_NORMAL, _HATCHES = 0.25, 11
# At which fractions of its light spheres are drawn around a light that weakens, how strongly, and what they are called.
_LEFT = ((0.5, 0.9, "1/2 left"), (1.0 / 256.0, 0.35, "1/256 left"))
# An angle stays so many degrees off its limits: a cone of 0° cannot be seen, and one of 90° is none to VTK.
_MARGIN = 0.5
# All turns, and a little more, lest the nearest is at an end. A circle that is seen edge-on has two places under the
# cursor: so many pixels farther counts the one a degree farther.
_TURNS = np.linspace(-190.0, 190.0, 761)
_RELUCTANCE = 0.02


def is_movable(light: Light) -> bool:
    """Whether a hand can move it: a headlight is where the viewer is, and other lights may be the same everywhere."""
    return light.frame != "headlight" and (comes_from_somewhere(light) or bool(light.values(Turn)))


def comes_from_somewhere(light: Light) -> bool:
    """Whether it comes from one place or direction, not from all around."""
    return bool(light.places or light.values(Aim))


def fields(light: Light, kind: type[Role]) -> dict[str, Any]:
    """Name of each of its fields with a role → value."""
    return {field: getattr(light, field) for field, role in light.roles.items() if isinstance(role, kind)}


def luminance(color: ColorLike) -> float:
    """Relative luminance of a linear colour: 1 for white, the Y of CIE XYZ."""
    return float(XYZ_OF_RGB[1] @ rgb(color))


@dataclass(frozen=True)
class LightInScene:
    """A light, as a window shows it.

    Parameters
    ----------
    light : Light
        In the world.
    scenery : Scenery
        The scene around it.
    """

    light: Light
    scenery: Scenery

    @cached_property
    def handles(self) -> dict[str, Handle]:
        """Name of each handle that the light can have → the handle; the field's name, where that name is taken.

        The last is the intensity, which is nowhere: it can only be typed.
        """
        light, found = self.light, dict[str, Handle]()
        for field, role in light.roles.items() if is_movable(light) else ():
            kind = next((of for of_role, of in _OF_ROLES.items() if role.handle and isinstance(role, of_role)), None)
            if kind is not None:
                name = field if role.handle in found else role.handle
                found[name] = kind(self, field, name)
        aim = next(iter(fields(light, Aim)), None)
        if found and aim is not None and not light.places:
            found[ORIGIN] = AimHandle(self, aim, ORIGIN)
        return found | {INTENSITY: Handle(self, INTENSITY, INTENSITY)}

    def points(self, view: View) -> dict[str, Float64Array]:
        """Name of each handle that is shown → where it is."""
        found = {name: handle.point(view) for name, handle in self.handles.items()}
        return {name: point for name, point in found.items() if point is not None}

    @cached_property
    def origin(self) -> Float64Array:
        """Where its icon stands."""
        if self.light.places:
            return np.mean(self.light.places, axis=0)
        if self.along is None and self.light.values(Turn):
            return self.front
        return np.array(self.scenery.anchor) - (0.0 if self.along is None else self.scenery.behind * self.along)

    @cached_property
    def along(self) -> Float64Array | None:
        """Unit vector along its aim, the first if it has several."""
        return next((np.array(unit_vector(direction)) for direction in self.light.values(Aim)), None)

    def reach(self, direction: Any) -> float:
        """How far from its icon a target is shown: as far as the direction is long, where that can be seen."""
        size = self.scenery.size
        if not self.light.values(Place):
            return _ARROW * size
        length = math.hypot(*direction)
        if _NEAREST * size <= length <= _FARTHEST * size:
            return length
        return max(float(np.linalg.norm(self.scenery.center - self.origin)), 0.5 * size)

    def target(self, direction: Any) -> Float64Array:
        """Where it shines to, along a direction of its own."""
        return self.origin + self.reach(direction) * np.array(unit_vector(direction))

    @property
    def front(self) -> Float64Array:
        """Where the front of a light that can be turned stands, on a circle around the scene's middle."""
        light: Any = self.light
        return np.asarray(self.scenery.center + STANDS_OFF * self.scenery.size * light.axes[0])

    @property
    def normal(self) -> Float64Array:
        """Unit normal of its outline, around which that runs counter-clockwise."""
        outline: Any = self.light.outline
        offsets = outline - outline[0]
        return np.array(unit_vector(np.cross(offsets, np.roll(offsets, -1, axis=0)).sum(axis=0).tolist()))

    def held(self, handle: str) -> Scenery:
        """The scenery while a handle is dragged: a light without a place turns around its icon, or its icon around it.

        An icon that stood in front of the scene's middle turns around that.
        """
        icon, grabbed = self.handles.get(ORIGIN), self.handles.get(handle)
        if icon is None or grabbed is None or grabbed.field != icon.field:
            return self.scenery
        behind = STANDS_OFF * self.scenery.size if handle == ORIGIN else 0.0
        anchor = vector(self.origin + behind * np.array(unit_vector(icon.value)))
        return replace(self.scenery, anchor=anchor, behind=behind)

    # -- how it is drawn

    def draw(self, drawing: Drawing, selected: bool, active: str | None = None) -> None:
        """Add it to a drawing; selected: with all that its fields say of its shape; active: the handle that is used.

        Of an outline that is what is normal to its front, and lines across it if the side that is seen glows.
        """
        light, outline = self.light, self.light.outline
        if not is_movable(light):
            return
        drawing.arrow_out_of_sight(self.origin)
        icon = ("bulb" if self.along is None else "lamp") if light.places else "sun"
        drawing.icon(self.origin, icon, self.along)
        if not light.on:
            drawing.crossed(self.origin)
        for name, handle in self.handles.items():
            if name != ORIGIN:  # the icon is there
                handle.draw(drawing, selected if handle.is_always_shown else name == active)
        if outline is None:
            return
        drawing.line(np.concatenate([outline, outline[:1]]), 0.9 if selected else 0.45)
        if not selected:
            return
        tip = self.origin + _NORMAL * self.scenery.size * self.normal
        drawing.line(np.array([self.origin, tip]), 0.9)
        drawing.arrowhead(tip, self.normal, 0.9)
        eye = self.origin + self.scenery.size * drawing.view.towards_eye(self.origin)
        if float(np.ravel(light.arrival(eye[:, None]).strength)[0]) == 0.0:
            return
        # parallel lines from side to side of the outline, which may have inward corners
        offsets = outline - outline[0]
        along = max(offsets, key=np.linalg.norm)
        heights = offsets @ np.cross(self.normal, along)
        ends, tops = np.roll(offsets, -1, axis=0), np.roll(heights, -1)
        for level in np.linspace(heights.min(), heights.max(), _HATCHES + 2)[1:-1]:
            cut = (heights > level) != (tops > level)
            part = (level - heights[cut]) / (tops[cut] - heights[cut])
            points = offsets[cut] + part[:, None] * (ends[cut] - offsets[cut])
            for hatch in points[np.argsort(points @ along)].reshape(-1, 2, 3):
                drawing.line(outline[0] + hatch, 0.2)

    def draw_circles(
        self, drawing: Drawing, radius: float, strength: float, normals: Float64Array | None = None
    ) -> None:
        """Circles around its icon, unless they are too large for any window; by default three, of a sphere."""
        for normal in np.eye(3) if normals is None else normals:
            if radius < _LARGEST * self.scenery.size:
                drawing.line(circle(self.origin, normal, radius), strength)

    # -- what is said of it

    def readout(self, handle: str) -> str:
        """What a drag of a handle is changing, in numbers, and how much light arrives."""
        said = {each.field: each.said for name, each in self.handles.items() if name != ORIGIN or handle == ORIGIN}
        lines = [f"{self.light.name}: {handle}" if self.light.name else handle]
        lines += [line for line, _ in said.values()]
        lines.append(", ".join(numbers for _, numbers in said.values() if numbers))
        return "\n".join(line for line in [*lines, self.arriving] if line)

    @property
    def arriving(self) -> str:
        """How much of the light arrives, as a multiple of its colour, and the luminance of that."""
        light, where, point = self.light, "at the scene's middle", np.array(self.scenery.center)
        if light.is_even:
            where = "everywhere"
        elif light.values(Place) and light.values(Aim):
            where, point = "at the target", self.target(light.values(Aim)[0])
        strength = float(np.ravel(light.arrival(point[:, None]).strength)[0]) * light.intensity * light.on
        return f"{strength:.3g} arriving {where}\nluminance {strength * luminance(light.diffuse):.3g}"


class Handle:
    """A field of a light in a window. Drags and typed values give a new light of the world.

    By itself it stands for a number that is nowhere, and can only be typed.

    Parameters
    ----------
    shown : LightInScene
        The light.
    field : str
        Which of its fields.
    name : str
        The handle's.
    """

    _number_format = ""
    """How `name` and `value` are written in the readout's line of sizes and angles; "" where they are not."""

    def __init__(self, shown: LightInScene, field: str, name: str) -> None:
        self.shown, self.field, self.name = shown, field, name
        self.light, self.scenery = shown.light, shown.scenery
        self.value: Any = getattr(shown.light, field)
        self.role: Any = shown.light.roles.get(field)

    def point(self, view: View) -> Float64Array | None:  # noqa: ARG002 it is nowhere
        """Where the handle is; None where there is none."""
        return None

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """The light after the cursor has moved there."""
        raise NotImplementedError

    @property
    def numbers(self) -> dict[str, float]:
        """Label → number, in the order in which they are typed."""
        return {self.name: self.value}

    def typed(self, numbers: dict[str, float]) -> Light:
        """The light with all of these numbers; ValueError if it allows no such value."""
        return self.with_value(numbers[self.name])

    is_always_shown: ClassVar[bool] = True
    """Whether a selected light has what the field says of its shape; else only one whose handle is hovered or used."""

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """Add what the field says of the light's shape to a drawing."""

    @property
    def said(self) -> tuple[str, str]:
        """A line of the readout of its own, for places and directions, and what it adds to that of sizes and angles."""
        return "", self._number_format.format(name=self.name, value=self.value)

    def with_value(self, value: Any) -> Light:
        """The light with another value of the field."""
        return replace(self.light, **{self.field: value})


class PlaceHandle(Handle):
    """A place, or corners by their middle. A light that is moved keeps its target."""

    @property
    def middle(self) -> Float64Array:
        """Where it is."""
        return np.mean(np.atleast_2d(self.value), axis=0)

    def typed(self, numbers: dict[str, float]) -> Light:
        """The light elsewhere, aimed at the same target; as it is where that is the target itself."""
        point = np.array(list(numbers.values()))
        offset = point - self.middle
        if not offset.any():
            return self.light
        is_place = isinstance(self.role, Place)
        moved = vector(point) if is_place else tuple(vector(np.add(corner, offset)) for corner in self.value)
        changes: dict[str, Any] = {self.field: moved}
        for field, direction in fields(self.light, Aim).items():
            if self.field == next(iter(fields(self.light, Place)), None):
                aim = self.shown.target(direction) - point
                if not aim.any():
                    return self.light
                changes[field] = vector(aim)
        return replace(self.light, **changes)

    def point(self, view: View) -> Float64Array:  # noqa: ARG002 it is seen from everywhere
        """The light's middle."""
        return self.middle

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """Moved with the cursor; snapping: to the grid, but for coordinates in which it does not move."""
        point = start.moved(cursor)
        if cursor.snapping:
            stays = np.abs(point - start.point) <= 1e-9 * self.scenery.size
            point = np.where(stays, start.point, np.round(point / start.grid) * start.grid)
        return self.typed(dict(zip("xyz", point.tolist(), strict=True)))

    @property
    def numbers(self) -> dict[str, float]:
        """Coordinates."""
        return dict(zip("xyz", vector(self.middle), strict=True))

    @property
    def said(self) -> tuple[str, str]:
        """The middle."""
        return f"{self.name} {_tuple_of(self.middle)}", ""


class AimHandle(Handle):
    """An aim, at the target, or at the icon of a light without a place. Without a place it is typed by angles."""

    @property
    def _sign(self) -> float:
        """Of the direction from the icon to the handle's other end: at the icon it is turned by where it comes from."""
        return -1.0 if self.name == ORIGIN else 1.0

    def point(self, view: View) -> Float64Array:  # noqa: ARG002 it is seen from everywhere
        """The target, or the icon's place."""
        return self.shown.origin if self.name == ORIGIN else self.shown.target(self.value)

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """The light aimed by the handle's new place; snapping: in steps of azimuth and elevation about z."""
        goal = start.moved(cursor)
        if np.array_equal(goal, start.point):
            return self.light
        stays = np.array(self.scenery.anchor) if self.name == ORIGIN else self.shown.origin
        aim = self._sign * (goal - stays)
        if cursor.snapping and aim.any():
            step = start.angle_step
            azimuth, elevation = (round(angle / step) * step for angle in _angles_of(aim))
            aim = float(np.linalg.norm(aim)) * _direction_of(azimuth, elevation)
        return self.with_value(vector(aim)) if aim.any() else self.light

    @property
    def numbers(self) -> dict[str, float]:
        """The target's coordinates, or the angles of a direction; at the icon those of where the light comes from."""
        if self.light.values(Place):
            return dict(zip("xyz", vector(self.shown.target(self.value)), strict=True))
        return dict(zip(("azimuth", "elevation"), _angles_of(self._sign * np.array(self.value)), strict=True))

    def typed(self, numbers: dict[str, float]) -> Light:
        """Aimed there, unless it is there itself; a direction stays as long as it was."""
        if self.light.values(Place):
            aim = np.array(list(numbers.values())) - self.shown.origin
        else:
            elevation = check.number("elevation", numbers["elevation"], at_least=-90.0, at_most=90.0)
            direction = math.hypot(*self.value) * _direction_of(numbers["azimuth"], elevation)
            aim = self._sign * direction + 0.0  # and no −0
        return self.with_value(vector(aim)) if aim.any() else self.light

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """A line to the target; selected, without a place: four with tips beside it, for it comes from everywhere."""
        is_placed, start, tip = bool(self.light.values(Place)), self.shown.origin, self.shown.target(self.value)
        drawing.line(np.array([start, tip]), (0.8 if is_placed else 1.0) if selected else 0.45)
        if not selected or self.light.places:
            return
        along = np.array(unit_vector(self.value))
        side = drawing.view.across(along, start)
        for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            offset = 0.1 * self.scenery.size * (x * side + y * np.cross(along, side))
            drawing.line(np.array([start + offset, tip + offset]), 0.6)
            drawing.arrowhead(tip + offset, along, 0.6)

    @property
    def said(self) -> tuple[str, str]:
        """The target and how far away it is; of a light that is nowhere the direction and its angles."""
        if self.light.values(Place):
            target = self.shown.target(self.value)
            return f"{self.name} {_tuple_of(target)}", f"distance {self.shown.reach(self.value):.4g}"
        azimuth, elevation = self.numbers.values()
        direction = f"{self.field} {_tuple_of(unit_vector(self.value))}"
        return direction, f"azimuth {azimuth:.1f}°, elevation {elevation:.1f}°"


class AngleHandle(Handle):
    """An angle off the aim: at the edge, as far away as the target, at the side seen best."""

    _number_format = "{name} {value:.1f}°"

    def _edge(self, degrees: Any, view: View) -> Float64Array:
        """Points that far off the aim."""
        middle, along, turn = self.shown.origin, self.shown.along, np.radians(degrees)[..., None]
        assert along is not None
        far, side = self.shown.reach(self.light.values(Aim)[0]), view.across(along, middle)
        return middle + far * (np.cos(turn) * along + np.sin(turn) * side)

    def point(self, view: View) -> Float64Array | None:
        """At the edge."""
        return None if self.shown.along is None else self._edge(self.value, view)

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """The light at whose angle the edge comes nearest to the cursor on the screen; snapping: in steps."""
        least, most = self.role.least + _MARGIN, self.role.most - _MARGIN
        tried = np.linspace(least, most, 81)
        best = _nearest(start, cursor, lambda degrees: self._edge(degrees, start.view), tried)
        if best is None:
            return self.light
        if cursor.snapping:
            best = round(best / start.angle_step) * start.angle_step
        return self.with_value(min(max(best, least), most))

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """The rim as far away as the target; selected: with eight spokes, and where a power of the cosine halves it."""
        along, start = self.shown.along, self.shown.origin
        if along is None:
            return
        far = self.shown.reach(self.light.values(Aim)[0])

        def ring(angle: float) -> Float64Array:
            return circle(start + far * math.cos(angle) * along, along, far * math.sin(angle))

        rim = ring(math.radians(self.value))
        drawing.line(rim, 1.0 if selected else 0.3)
        if not selected:
            return
        for spoke in rim[:-1].reshape(8, -1, 3)[:, 0]:
            drawing.line(np.array([start, spoke]), 0.6)
        for exponent in self.light.values(Power):
            halved = math.acos(2.0 ** (-1.0 / exponent)) if exponent else math.inf
            if halved < math.radians(self.value):
                drawing.line(ring(halved), 0.5)


class LengthHandle(Handle):
    """A size: at its share of it, to the right or above, on the outline of a light that has one."""

    _number_format = "{name} {value:.4g}"

    def _side(self, view: View) -> Float64Array:
        """Unit vector from the light's middle to the handle: in its plane if it has one."""
        light: Any = self.light
        shown = view.viewer.axes[self.role.axis]
        if light.values(Up):
            side = light.axes[1 + self.role.axis]
        elif light.outline is not None:
            side = view.level(self.shown.normal)
        else:
            return shown
        return np.asarray(side if side @ shown >= 0.0 else -side)

    def point(self, view: View) -> Float64Array:
        """At the share."""
        return self.shown.origin + self.role.share * self.value * self._side(view)

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """The light of whose length the handle's share is as far as the cursor is, along its own axis if it has one."""
        distance = _distance(self, start, cursor, self._side(start.view) if self.light.values(Up) else None)
        return self.light if distance is None else self.with_value(distance / self.role.share)

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """Without an outline a circle through the handle that faces the viewer; selected: a sphere, too."""
        if self.light.outline is None:
            radius = self.role.share * self.value
            self.shown.draw_circles(drawing, radius, 0.6 if selected else 0.3, drawing.view.viewer.axes[2:])
            if selected:
                self.shown.draw_circles(drawing, radius, 0.9)


class FalloffHandle(Handle):
    """A falloff to all sides alike: to the right, where half the light is left.

    A light with an aim has none: its target says how far it is meant to reach.
    """

    is_always_shown = False  # its spheres are circles across all of the window

    @cached_property
    def _half(self) -> float | None:
        """The distance at which half the light is left."""
        return None if self.light.values(Aim) else distance_of(0.5, self.value)

    def point(self, view: View) -> Float64Array | None:
        """To the right."""
        return None if self._half is None else self.shown.origin + self._half * view.viewer.axes[0]

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """The light of which half is left at the cursor's distance."""
        distance = _distance(self, start, cursor)
        return self.light if distance is None else self.typed({"half left at": distance})

    @property
    def numbers(self) -> dict[str, float]:
        """The distance."""
        return {"half left at": self._half or math.inf}

    def typed(self, numbers: dict[str, float]) -> Light:
        """Half left there: linear and quadratic coefficient scaled."""
        distance = check.number("half left at", numbers["half left at"], above=0.0)
        if self._half is None:
            return self.light
        (constant, linear, quadratic), shrink = self.value, self._half / distance
        return self.with_value((constant, linear * shrink, quadratic * shrink * shrink))

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """Spheres where a half and a 256th of the light is left, while they are asked for."""
        for fraction, strength, label in _LEFT if selected and not self.light.values(Aim) else ():
            radius = distance_of(fraction, self.value)
            if radius is not None and radius < _LARGEST * self.scenery.size:
                self.shown.draw_circles(drawing, radius, strength)
                drawing.label(self.shown.origin + radius * drawing.view.viewer.axes[1], label)

    @property
    def said(self) -> tuple[str, str]:
        """The coefficients."""
        return "" if self.light.values(Aim) else f"{self.field} {_tuple_of(self.value)}", ""


class TurnHandle(Handle):
    """A turn around what is up: at the light's front, on a circle around the scene's middle."""

    _number_format = "{name} {value:.1f}°"

    def point(self, view: View) -> Float64Array:  # noqa: ARG002 it is seen from everywhere
        """At the front."""
        return self.shown.front

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """The light whose front comes nearest to the cursor on the screen; snapping: in steps of degrees."""
        light: Any = self.light
        middle, (ahead, right, _) = np.array(self.scenery.center), light.axes
        far = float(np.linalg.norm(start.point - middle))

        def fronts(turns: Any) -> Float64Array:
            turns = np.radians(turns)[:, None]
            return np.asarray(middle + far * (np.cos(turns) * ahead - np.sin(turns) * right))

        turn = _nearest(start, cursor, fronts, _TURNS, _RELUCTANCE)
        if turn is None:
            return light
        degrees = self.value + turn
        if cursor.snapping:
            degrees = round(degrees / start.angle_step) * start.angle_step
        return self.with_value(math.remainder(degrees, 360.0))

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """The circle; selected: with what is up."""
        middle, place = np.array(self.scenery.center), self.shown.front
        up = np.array(unit_vector(self.light.values(Up)[0]))
        far = float(np.linalg.norm(place - middle))
        drawing.line(circle(middle, up, far), 0.9 if selected else 0.3)
        if selected:
            drawing.line(np.array([place, place + 0.25 * (middle - place)]), 0.9)
            drawing.line(np.array([middle + 0.7 * far * up, middle + 0.9 * far * up]), 0.6)
            drawing.arrowhead(middle + 0.9 * far * up, up, 0.6)


_OF_ROLES: dict[type[Role], type[Handle]] = {
    Place: PlaceHandle,
    Corners: PlaceHandle,
    Aim: AimHandle,
    Angle: AngleHandle,
    Length: LengthHandle,
    Falloff: FalloffHandle,
    Turn: TurnHandle,
}


def _nearest(
    start: DragStart,
    cursor: Cursor,
    places: Callable[[Any], Float64Array],
    tried: Float64Array,
    reluctance: float = 0.0,
) -> float | None:
    """The number in a range whose place comes nearest to the cursor on the screen.

    Parameters
    ----------
    start, cursor
        The drag.
    places : callable
        From numbers, shape (n,), to points, shape (n, 3).
    tried : numpy.ndarray
        From the least number to the largest, in steps so fine that the nearest is found.
    reluctance : float, default 0
        So many pixels farther counts a place for each 1 that its number is off zero.

    Returns
    -------
    float or None
        None where the cursor has not moved, or no place is seen.
    """
    if not start.motion(cursor).any():
        return None
    best, limits, step = 0.0, (tried[0], tried[-1]), float(tried[1] - tried[0])
    for _ in range(5):  # each round looks 20 times closer, around the best
        off = np.linalg.norm(start.view.project(places(tried)) - start.picture(cursor), axis=1)
        if np.isnan(off).all():
            return None
        best = float(tried[np.nanargmin(off + reluctance * np.abs(tried))])
        tried = np.clip(best + step * np.linspace(-1.0, 1.0, 41), *limits)
        step /= 20.0
    return best


def _distance(handle: Handle, start: DragStart, cursor: Cursor, along: Float64Array | None = None) -> float | None:
    """How far from the light the cursor is, > 0, along an axis or else parallel to the picture; snapping: in steps."""
    middle, view = handle.shown.origin, start.view
    if not view.is_ahead(middle) or not start.motion(cursor).any():
        return None
    if along is None:
        distance = float(np.linalg.norm(view.facing(middle, start.picture(cursor)) - middle))
    else:
        distance = float((view.along(np.array(start.point), along, start.motion(cursor)) - middle) @ along)
    if cursor.snapping:
        distance = max(round(distance / start.grid), 1) * start.grid
    return max(distance, 1e-6 * handle.scenery.size)


def _angles_of(direction: Any) -> tuple[float, float]:
    """Azimuth about z from x towards y, and elevation above the plane of the two, in degrees."""
    x, y, z = unit_vector(direction)
    return math.degrees(math.atan2(y, x)), math.degrees(math.asin(max(-1.0, min(1.0, z))))


def _direction_of(azimuth: float, elevation: float) -> Float64Array:
    """The unit vector with these angles in degrees; exact along the axes."""
    around, up = math.radians(azimuth), math.radians(elevation)
    parts = np.array([math.cos(up) * math.cos(around), math.cos(up) * math.sin(around), math.sin(up)])
    return np.where(np.abs(parts) < 1e-15, 0.0, parts)


def _tuple_of(values: Any) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in np.asarray(values, dtype=np.float64).tolist()) + ")"
