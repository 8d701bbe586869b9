"""Handles of lights: one class for each role of a light's field, such as a position or an aim.

A handle class defines the handle's position, the effect of a drag, the values that can be typed, the drawing of the
field and its readout. `LightInScene` combines a light in world coordinates with the scene around it: it places the
light's icon, creates its handles, and draws and describes them. A role that is not in `_OF_ROLES` has no handle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from pvphong.base import check
from pvphong.base.color import luminance
from pvphong.base.types import Float64Array
from pvphong.base.vectors import unit_vector
from pvphong.optics.attenuation import distance_of
from pvphong.optics.light import Light
from pvphong.optics.roles import Aim, Angle, Corners, Falloff, Length, Place, Power, Role, Turn, Up, Width
from pvphong.studio.gizmos.drawing import Drawing, circle
from pvphong.studio.gizmos.view import STANDS_OFF, Cursor, DragStart, Scenery, View, nearest, vector

ORIGIN = "origin"
"""Name of the handle at the icon of a light without a position. The light's aim has another handle, at the target."""

INTENSITY = "intensity"
"""Name of the handle for the light's intensity. It has no position; the intensity can only be typed."""

# Length of the arrow of a light without a position, in scene sizes.
_ARROW = 0.6 * STANDS_OFF
# Range of target distances that can be seen and grabbed, in scene sizes. If the length of a light's direction is in
# this range, this length is the distance of the target.
_NEAREST, _FARTHEST = 0.05, 20.0
# Circles are drawn up to this radius, in scene sizes.
_LARGEST = 1e4
# Length of an area light's normal and of a lamp's largest intensity, in scene sizes; number of lines that fill a front.
_NORMAL, _CURVE, _HATCHES = 0.25, 0.35, 11
# Spheres around a light with attenuation: fraction of the light that remains there, strength of the lines, and label.
_LEFT = ((0.5, 0.9, "1/2 left"), (1.0 / 256.0, 0.35, "1/256 left"))
# Margin between an angle and its limits, in degrees: a cone of 0° is invisible, and VTK does not treat 90° as a cone.
_MARGIN = 0.5
# Angles tried for a turn, in degrees: more than a full turn, so that the best angle is never at an end. A circle seen
# edge-on has two points under the cursor. A penalty of _RELUCTANCE pixels per degree prefers the smaller turn.
_TURNS = np.linspace(-190.0, 190.0, 761)
_RELUCTANCE = 0.02


def is_movable(light: Light) -> bool:
    """Return True if the light can be moved by hand; False for a headlight and a uniform light from all around."""
    return light.frame != "headlight" and (comes_from_somewhere(light) or bool(light.values(Turn)))


def comes_from_somewhere(light: Light) -> bool:
    """Return True if the light comes from a position or direction, not from all around."""
    return bool(light.places or light.values(Aim))


def fields(light: Light, kind: type[Role]) -> dict[str, Any]:
    """Return the fields of a light whose role is an instance of `kind`, as name → value."""
    return {field: getattr(light, field) for field, role in light.roles.items() if isinstance(role, kind)}


@dataclass(frozen=True)
class LightInScene:
    """A light, and centre and size of the scene in which a window shows the light.

    Parameters
    ----------
    light : Light
        The light, in world coordinates.
    scenery : Scenery
        Centre and size of the scene.
    """

    light: Light
    scenery: Scenery

    @cached_property
    def handles(self) -> dict[str, Handle]:
        """Handles of the light, as name → handle.

        A handle has the name that its role defines. If another handle has this name already, it has the name of its
        field instead. The last handle is for the intensity. This handle has no position, and the intensity can only be
        typed.
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
        """Return the world position of each visible handle, by the handle's name."""
        return {name: point for name, each in self.handles.items() if (point := each.point(view)) is not None}

    @cached_property
    def origin(self) -> Float64Array:
        """World position of the icon."""
        if self.light.places:
            return np.mean(self.light.places, axis=0)
        if self.along is None and self.light.values(Turn):
            return self.front
        return np.array(self.scenery.anchor) - (0.0 if self.along is None else self.scenery.behind * self.along)

    @cached_property
    def along(self) -> Float64Array | None:
        """Unit vector in which the light shines (its first aim); None if the light has no aim."""
        return next((np.array(unit_vector(direction)) for direction in self.light.values(Aim)), None)

    def reach(self, direction: Any) -> float:
        """Return the distance from the light's icon to the target of an aim.

        `direction` is the vector in the aim's field. For a light with a position, this is the length of `direction`. If
        this length is too short or too long, it is about the distance to the scene's centre. For any other light, it is
        a fixed fraction of the scene's size.
        """
        size = self.scenery.size
        if not self.light.values(Place):
            return _ARROW * size
        length = math.hypot(*direction)
        if _NEAREST * size <= length <= _FARTHEST * size:
            return length
        return max(float(np.linalg.norm(self.scenery.center - self.origin)), 0.5 * size)

    def target(self, direction: Any) -> Float64Array:
        """Return the world position of an aim's target. `direction` is the vector in the aim's field."""
        return self.origin + self.reach(direction) * np.array(unit_vector(direction))

    @property
    def front(self) -> Float64Array:
        """World position of the mark that shows the front of an environment light.

        The mark is on a circle around the scene's centre, and its direction from the centre is the light's first axis.
        """
        light: Any = self.light
        return np.asarray(self.scenery.center + STANDS_OFF * self.scenery.size * light.axes[0])

    @property
    def normal(self) -> Float64Array:
        """Unit normal of a flat light's front. Seen from the front, the outline runs counter-clockwise."""
        outline: Any = self.light.outline
        offsets = outline - outline[0]
        return np.array(unit_vector(np.cross(offsets, np.roll(offsets, -1, axis=0)).sum(axis=0).tolist()))

    def held(self, handle: str) -> Scenery:
        """Return centre, size and anchor of the scene for a drag of the handle named `handle`.

        The anchor is the point around which the drag turns the light.

        A light without a position turns around its icon if the target is dragged. If the icon is dragged, the light
        turns around a point in front of the icon, at first the scene's centre.
        """
        icon, grabbed = self.handles.get(ORIGIN), self.handles.get(handle)
        if icon is None or grabbed is None or grabbed.field != icon.field:
            return self.scenery
        behind = STANDS_OFF * self.scenery.size if handle == ORIGIN else 0.0
        anchor = vector(self.origin + behind * np.array(unit_vector(icon.value)))
        return replace(self.scenery, anchor=anchor, behind=behind)

    # -- drawing

    def draw(self, drawing: Drawing, selected: bool, active: str | None = None) -> None:
        """Add the light to a drawing. If it is selected, add its full shape.

        The shape includes the curves of its intensities. For an area light, it includes the normal, and hatching if the
        visible side emits. `active` is the name of the handle in use.
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
            if name != ORIGIN:  # the icon marks it
                handle.draw(drawing, selected if handle.is_always_shown else name == active)
        for curve in light.curves if selected else ():
            drawing.line(self.origin + _CURVE * self.scenery.size * curve, 0.6)
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
        # hatching: parallel lines across the outline, which need not be convex
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
        """Add circles with the given radius around the icon. Circles much larger than the scene are left out.

        `strength`, from 0 to 1, is the circles' brightness. `normals` are their unit normals, shape (n, 3). By default,
        three circles show a sphere.
        """
        for normal in np.eye(3) if normals is None else normals:
            if radius < _LARGEST * self.scenery.size:
                drawing.line(circle(self.origin, normal, radius), strength)

    # -- readout

    def readout(self, handle: str) -> str:
        """Return the text that is shown while `handle` is dragged: the light's numbers, and how much light arrives."""
        said = {each.field: each.said for name, each in self.handles.items() if name != ORIGIN or handle == ORIGIN}
        lines = [f"{self.light.name}: {handle}" if self.light.name else handle]
        lines += [line for line, _ in said.values()]
        lines.append(", ".join(numbers for _, numbers in said.values() if numbers))
        return "\n".join(line for line in [*lines, self.arriving] if line)

    @property
    def arriving(self) -> str:
        """Text that tells how much light arrives at the target, or at the scene's centre for a light without a target.

        The amount is given as a multiple of the light's colour, and as a luminance.
        """
        light, where, point = self.light, "at the scene's centre", np.array(self.scenery.center)
        if light.is_uniform:
            where = "everywhere"
        elif light.values(Place) and light.values(Aim):
            where, point = "at the target", self.target(light.values(Aim)[0])
        strength = float(np.ravel(light.arrival(point[:, None]).strength)[0]) * light.intensity * light.on
        return f"{strength:.3g} arriving {where}\nluminance {strength * luminance(light.diffuse):.3g}"


class Handle:
    """Handle of one field of a light in a window. `dragged` and `typed` return the changed light in world coordinates.

    This base class is for a number that can only be typed. Its handle has no position in the window.

    Parameters
    ----------
    shown : LightInScene
        The light.
    field : str
        Name of the light's field.
    name : str
        Name of the handle.
    """

    _number_format = ""
    """Format of the handle's part of the readout, with `name` and `value`; "" for no part."""

    def __init__(self, shown: LightInScene, field: str, name: str) -> None:
        self.shown, self.field, self.name = shown, field, name
        self.light, self.scenery = shown.light, shown.scenery
        self.value: Any = getattr(shown.light, field)
        self.role: Any = shown.light.roles.get(field)

    def point(self, view: View) -> Float64Array | None:  # noqa: ARG002 no position
        """Return the world position of the handle in a view; None if it has none."""
        return None

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """Return the changed light for a drag from `start`, where the handle was grabbed, to the present `cursor`."""
        raise NotImplementedError

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers that can be typed, in the order of typing: label → current number."""
        return {self.name: self.value}

    def typed(self, numbers: dict[str, float]) -> Light:
        """Return the light with the typed numbers (label → number). Raise ``ValueError`` if a number is not allowed."""
        return self.with_value(numbers[self.name])

    is_always_shown: ClassVar[bool] = True
    """True to draw the field's shape for every selected light; False to draw it only while the handle is hovered or
    used."""

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """Add the shape of the field, such as a cone, to a drawing. If the light is selected, add more lines."""

    @property
    def said(self) -> tuple[str, str]:
        """The handle's two texts for the readout next to the cursor; "" for no text.

        The first is a line for a position or direction. The second is an entry in the line of sizes and angles.
        """
        return "", self._number_format.format(name=self.name, value=self.value)

    def with_value(self, value: Any) -> Light:
        """Return the light with `value` in the handle's field."""
        return replace(self.light, **{self.field: value})


class PlaceHandle(Handle):
    """Handle of a light's position, or of the centre of its corners, which move together.

    The light keeps its target.
    """

    @property
    def middle(self) -> Float64Array:
        """Centre of the position or corners, as a world point."""
        return np.mean(np.atleast_2d(self.value), axis=0)

    def typed(self, numbers: dict[str, float]) -> Light:
        """Return the light moved to the typed coordinates, and still aimed at its target.

        If the typed coordinates are those of the target, the light is returned unchanged.
        """
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

    def point(self, view: View) -> Float64Array:  # noqa: ARG002 the same in all views
        """Return the world position of the light's centre."""
        return self.middle

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """Return the light, moved by a drag from `start` to `cursor`. A snapping cursor rounds the coordinates."""
        point = start.moved(cursor)
        if cursor.snapping:
            stays = np.abs(point - start.point) <= 1e-9 * self.scenery.size
            point = np.where(stays, start.point, np.round(point / start.grid) * start.grid)
        return self.typed(dict(zip("xyz", point.tolist(), strict=True)))

    @property
    def numbers(self) -> dict[str, float]:
        """Coordinates of the centre, as x, y, z → number."""
        return dict(zip("xyz", vector(self.middle), strict=True))

    @property
    def said(self) -> tuple[str, str]:
        """A line with the coordinates of the centre, and "" for sizes and angles."""
        return f"{self.name} {_tuple_of(self.middle)}", ""


class AimHandle(Handle):
    """Handle of an aim, the direction in which a light shines. The handle is at the target.

    A light without a position has a second such handle at its icon. Its aim is typed as angles.
    """

    @property
    def _sign(self) -> float:
        """1 for the handle at the target, −1 for the handle at the icon, from where the light comes."""
        return -1.0 if self.name == ORIGIN else 1.0

    def point(self, view: View) -> Float64Array:  # noqa: ARG002 the same in all views
        """Return the world position of the target, or of the icon for the handle at the icon."""
        return self.shown.origin if self.name == ORIGIN else self.shown.target(self.value)

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """Return the light, turned by a drag from `start` to `cursor`. A snapping cursor rounds both angles."""
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
        """Coordinates of the target. For a light without a position, azimuth and elevation of its direction.

        The handle at the icon has the angles of the opposite direction, from which the light comes.
        """
        if self.light.values(Place):
            return dict(zip("xyz", vector(self.shown.target(self.value)), strict=True))
        return dict(zip(("azimuth", "elevation"), _angles_of(self._sign * np.array(self.value)), strict=True))

    def typed(self, numbers: dict[str, float]) -> Light:
        """Return the light aimed at the typed coordinates, or along the typed angles. The direction's length stays.

        A light that is itself at the coordinates is returned unchanged.
        """
        if self.light.values(Place):
            aim = np.array(list(numbers.values())) - self.shown.origin
        else:
            elevation = check.number("elevation", numbers["elevation"], at_least=-90.0, at_most=90.0)
            direction = math.hypot(*self.value) * _direction_of(numbers["azimuth"], elevation)
            aim = self._sign * direction + 0.0  # avoids −0
        return self.with_value(vector(aim)) if aim.any() else self.light

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """Add a line to the target; for a selected light without a position, also four parallel arrows."""
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
        """Texts for the target and its distance, or for direction and angles of a light without a position."""
        if self.light.values(Place):
            target = self.shown.target(self.value)
            return f"{self.name} {_tuple_of(target)}", f"distance {self.shown.reach(self.value):.4g}"
        azimuth, elevation = self.numbers.values()
        direction = f"{self.field} {_tuple_of(unit_vector(self.value))}"
        return direction, f"azimuth {azimuth:.1f}°, elevation {elevation:.1f}°"


class AngleHandle(Handle):
    """Handle of an angle from the aim, such as the half-angle of a cone.

    The handle is on the cone's rim at the target's distance, on the side that the viewer sees best.
    """

    _number_format = "{name} {value:.1f}°"

    def _edge(self, degrees: Any, view: View) -> Float64Array:
        """Return the points at angles of `degrees` from the aim, at the target's distance, on the side seen best."""
        middle, along, turn = self.shown.origin, self.shown.along, np.radians(degrees)[..., None]
        assert along is not None
        far, side = self.shown.reach(self.light.values(Aim)[0]), view.across(along, middle)
        return middle + far * (np.cos(turn) * along + np.sin(turn) * side)

    def point(self, view: View) -> Float64Array | None:
        """Return the world position of the handle on the cone's rim; None for a light without an aim."""
        return None if self.shown.along is None else self._edge(self.value, view)

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """Return the light with the angle whose rim is nearest to the cursor. A snapping cursor rounds the angle."""
        least, most = self.role.least + _MARGIN, self.role.most - _MARGIN
        tried = np.linspace(least, most, 81)
        best = nearest(start, cursor, lambda degrees: self._edge(degrees, start.view), tried)
        if best is None:
            return self.light
        if cursor.snapping:
            best = round(best / start.angle_step) * start.angle_step
        return self.with_value(min(max(best, least), most))

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """Add the cone's rim at the target's distance.

        If selected, add lines from the light to the rim, and the circle of half intensity.
        """
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


class WidthHandle(Handle):
    """Apparent diameter of a light without a position. It can only be typed: the icon would hide a small rim."""

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """Add a circle around the icon, as large as the light looks from the target."""
        if self.shown.along is not None and self.value:
            size = self.shown.reach(self.light.values(Aim)[0]) * math.tan(math.radians(0.5 * self.value))
            drawing.line(circle(self.shown.origin, self.shown.along, size), 1.0 if selected else 0.3)

    @property
    def said(self) -> tuple[str, str]:
        """No text for a position or direction, and a text with the diameter if it is not 0."""
        return "", f"{self.name} {self.value:.4g}°" if self.value else ""


class LengthHandle(Handle):
    """Handle of a size, such as a radius or width.

    Its distance from the light's centre is the fraction `role.share` of the size. It is to the right of the centre or
    above it. If the light is flat, the handle is in the light's plane.
    """

    _number_format = "{name} {value:.4g}"

    def _side(self, view: View) -> Float64Array:
        """Return the unit vector from the light's centre to the handle, in the light's plane if the light is flat."""
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
        """Return the world position of the handle."""
        return self.shown.origin + self.role.share * self.value * self._side(view)

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """Return the light with the size that puts the handle under the cursor.

        If the light has an up vector, the handle moves only along the light's axis number `role.axis`.
        """
        distance = _distance(self, start, cursor, self._side(start.view) if self.light.values(Up) else None)
        return self.light if distance is None else self.with_value(distance / self.role.share)

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """Add a circle through the handle. If selected, add a sphere too. Add nothing for a light with an outline."""
        if self.light.outline is None:
            radius = self.role.share * self.value
            self.shown.draw_circles(drawing, radius, 0.6 if selected else 0.3, drawing.view.viewer.axes[2:])
            if selected:
                self.shown.draw_circles(drawing, radius, 0.9)


class FalloffHandle(Handle):
    """Handle of a falloff that is the same in all directions.

    The handle is to the right of the light, where half of the light remains. A light with an aim has no such handle:
    its target shows its range.
    """

    is_always_shown = False  # the spheres would cross the whole window

    @cached_property
    def _half(self) -> float | None:
        """Distance at which half of the light remains; None for a light with an aim or a constant falloff."""
        return None if self.light.values(Aim) else distance_of(0.5, self.value)

    def point(self, view: View) -> Float64Array | None:
        """Return the world point to the right of the light where half of it remains; None if there is no such point."""
        return None if self._half is None else self.shown.origin + self._half * view.viewer.axes[0]

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """Return the light with the falloff that leaves half of the light at the cursor's distance."""
        distance = _distance(self, start, cursor)
        return self.light if distance is None else self.typed({"half left at": distance})

    @property
    def numbers(self) -> dict[str, float]:
        """The distance at which half of the light remains, as label → number."""
        return {"half left at": self._half or math.inf}

    def typed(self, numbers: dict[str, float]) -> Light:
        """Return the light with the falloff that leaves half of the light at the typed distance.

        The linear and quadratic coefficients are scaled. A light with an aim or with a constant falloff is returned
        unchanged.
        """
        distance = check.number("half left at", numbers["half left at"], above=0.0)
        if self._half is None:
            return self.light
        (constant, linear, quadratic), shrink = self.value, self._half / distance
        return self.with_value((constant, linear * shrink, quadratic * shrink * shrink))

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """Add spheres at the distances where 1/2 and 1/256 of the intensity remain, if the light is selected."""
        for fraction, strength, label in _LEFT if selected and not self.light.values(Aim) else ():
            radius = distance_of(fraction, self.value)
            if radius is not None and radius < _LARGEST * self.scenery.size:
                self.shown.draw_circles(drawing, radius, strength)
                drawing.label(self.shown.origin + radius * drawing.view.viewer.axes[1], label)

    @property
    def said(self) -> tuple[str, str]:
        """A line with the falloff's coefficients, and "" for sizes and angles."""
        return "" if self.light.values(Aim) else f"{self.field} {_tuple_of(self.value)}", ""


class TurnHandle(Handle):
    """Handle of an environment's rotation around the up axis. It is a mark on a circle around the scene's centre.

    The mark shows where the front of the environment is.
    """

    _number_format = "{name} {value:.1f}°"

    def point(self, view: View) -> Float64Array:  # noqa: ARG002 the same in all views
        """Return the world position of the mark that shows the front of the light."""
        return self.shown.front

    def dragged(self, start: DragStart, cursor: Cursor) -> Light:
        """Return the light, turned so that its front is nearest to the cursor. A snapping cursor rounds the angle."""
        light: Any = self.light
        middle, (ahead, right, _) = np.array(self.scenery.center), light.axes
        far = float(np.linalg.norm(start.point - middle))

        def fronts(turns: Any) -> Float64Array:
            turns = np.radians(turns)[:, None]
            return np.asarray(middle + far * (np.cos(turns) * ahead - np.sin(turns) * right))

        turn = nearest(start, cursor, fronts, _TURNS, _RELUCTANCE)
        if turn is None:
            return light
        degrees = self.value + turn
        if cursor.snapping:
            degrees = round(degrees / start.angle_step) * start.angle_step
        return self.with_value(math.remainder(degrees, 360.0))

    def draw(self, drawing: Drawing, selected: bool) -> None:
        """Add the circle on which the handle moves. If selected, add the handle and the up axis."""
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
    Width: WidthHandle,
    Length: LengthHandle,
    Falloff: FalloffHandle,
    Turn: TurnHandle,
}


def _distance(handle: Handle, start: DragStart, cursor: Cursor, along: Float64Array | None = None) -> float | None:
    """Return the distance, > 0, between the light and a handle that is dragged from `start` to the cursor.

    The distance is measured along the unit vector `along`, or by default parallel to the picture. A snapping cursor
    rounds the distance to the grid. Return None if the cursor has not moved, or the light is not in front of the eye.
    """
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
    """Return a direction's azimuth (about z, from x to y) and elevation (above the xy plane), in degrees."""
    x, y, z = unit_vector(direction)
    return math.degrees(math.atan2(y, x)), math.degrees(math.asin(max(-1.0, min(1.0, z))))


def _direction_of(azimuth: float, elevation: float) -> Float64Array:
    """Return the unit vector with an azimuth and an elevation in degrees, exact for multiples of 90°."""
    around, up = math.radians(azimuth), math.radians(elevation)
    parts = np.array([math.cos(up) * math.cos(around), math.cos(up) * math.sin(around), math.sin(up)])
    return np.where(np.abs(parts) < 1e-15, 0.0, parts)


def _tuple_of(values: Any) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in np.asarray(values, dtype=np.float64).tolist()) + ")"
