"""What a light looks like in a window: an icon, and what each role of a field adds to it."""

from __future__ import annotations

import math

import numpy as np

from pvphong.base.types import Float64Array
from pvphong.base.vectors import unit_vector
from pvphong.optics.attenuation import distance_of
from pvphong.optics.light import Light
from pvphong.optics.roles import Aim, Angle, Length, Place, Power, Turn, Up
from pvphong.studio.gizmos.drag_start import Scenery
from pvphong.studio.gizmos.drawing import Drawing, circle
from pvphong.studio.gizmos.shape import axis, falloffs, front, front_normal, is_movable, origin, reach, target

# Circles are drawn up to this radius, in scene sizes.
_LARGEST = 1e4
# How long the normal of a front is, in scene sizes, and how many lines fill it.
_TICK, _HATCHES = 0.25, 11
# At which fractions of its light spheres are drawn around a light that weakens, how strongly, and what they are called.
_LEFT = ((0.5, 0.9, "1/2 left"), (1.0 / 256.0, 0.35, "1/256 left"))


def draw(drawing: Drawing, light: Light, scenery: Scenery, selected: bool) -> None:
    """Add a light of the world to a drawing; selected: with all that its fields say of its shape."""
    if not is_movable(light):
        return
    drawing.beyond(origin(light, scenery))
    is_placed, along = bool(light.places), axis(light)
    drawing.icon(origin(light, scenery), ("bulb" if along is None else "lamp") if is_placed else "sun", along)
    if not light.on:
        drawing.crossed(origin(light, scenery))
    _lines_to_targets(drawing, light, scenery, selected)
    if along is not None:
        _cones(drawing, light, along, scenery, selected)
    if along is not None and selected and not is_placed:
        _rays(drawing, light, along, scenery)
    _sizes(drawing, light, scenery, selected)
    if light.values(Turn):
        _circle_of_turn(drawing, light, scenery, selected)
    if selected:
        _falloffs(drawing, light, scenery)


def _lines_to_targets(drawing: Drawing, light: Light, scenery: Scenery, selected: bool) -> None:
    strength = (0.8 if light.values(Place) else 1.0) if selected else 0.45
    for direction in light.values(Aim):
        drawing.line(np.array([origin(light, scenery), target(light, direction, scenery)]), strength)


def _rays(drawing: Drawing, light: Light, along: Float64Array, scenery: Scenery) -> None:
    """Four with tips, parallel to the line: such light comes from everywhere."""
    start = origin(light, scenery)
    tip = target(light, light.values(Aim)[0], scenery)
    side = drawing.view.across(along, start)
    other = np.cross(along, side)
    for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        offset = 0.1 * scenery.size * (x * side + y * other)
        drawing.line(np.array([start + offset, tip + offset]), 0.6)
        drawing.tip(tip + offset, along, 0.6)


def _cones(drawing: Drawing, light: Light, along: Float64Array, scenery: Scenery, selected: bool) -> None:
    """The rim as far away as the target; selected: with eight spokes, and where a power of the cosine halves it."""
    start, far = origin(light, scenery), reach(light, light.values(Aim)[0], scenery)

    def ring(angle: float) -> Float64Array:
        return circle(start + far * math.cos(angle) * along, along, far * math.sin(angle))

    for degrees in light.values(Angle):
        rim = ring(math.radians(degrees))
        drawing.line(rim, 1.0 if selected else 0.3)
        if not selected:
            continue
        for spoke in rim[:-1].reshape(8, -1, 3)[:, 0]:
            drawing.line(np.array([start, spoke]), 0.6)
        for exponent in light.values(Power):
            halved = math.acos(2.0 ** (-1.0 / exponent)) if exponent else math.inf
            if halved < math.radians(degrees):
                drawing.line(ring(halved), 0.5)


def _sizes(drawing: Drawing, light: Light, scenery: Scenery, selected: bool) -> None:
    """Its outline; where it has none, a circle through its handle that faces the viewer, and selected: a sphere."""
    if light.outline is not None:
        _outline(drawing, light, light.outline, scenery, selected)
        return
    for field, role in light.roles.items():
        if isinstance(role, Length):
            radius = role.share * getattr(light, field)
            _circle(drawing, light, scenery, drawing.view.viewer.axes[2], radius, 0.6 if selected else 0.3)
            if selected:
                _sphere(drawing, light, scenery, radius, 0.9)


def _outline(drawing: Drawing, light: Light, outline: Float64Array, scenery: Scenery, selected: bool) -> None:
    """The line; selected: with what is normal to its front, and hatched if the side that is seen glows."""
    drawing.line(np.concatenate([outline, outline[:1]]), 0.9 if selected else 0.45)
    if not selected:
        return
    middle, normal = origin(light, scenery), front_normal(outline)
    tip = middle + _TICK * scenery.size * normal
    drawing.line(np.array([middle, tip]), 0.9)
    drawing.tip(tip, normal, 0.9)
    eye = middle + scenery.size * drawing.view.towards_eye(middle)
    if float(np.ravel(light.arrival(eye[:, None]).strength)[0]) > 0.0:
        for hatch in _hatches(outline, normal):
            drawing.line(hatch, 0.2)


def _hatches(outline: Float64Array, normal: Float64Array) -> Float64Array:
    """Parallel lines from side to side of an outline, which may have inward corners; shape (m, 2, 3)."""
    offsets, found = outline - outline[0], []
    along = max(offsets, key=np.linalg.norm)
    heights = offsets @ np.cross(normal, along)
    ends, tops = np.roll(offsets, -1, axis=0), np.roll(heights, -1)
    for level in np.linspace(heights.min(), heights.max(), _HATCHES + 2)[1:-1]:
        cut = (heights > level) != (tops > level)
        part = (level - heights[cut]) / (tops[cut] - heights[cut])
        points = offsets[cut] + part[:, None] * (ends[cut] - offsets[cut])
        found += list(points[np.argsort(points @ along)].reshape(-1, 2, 3))
    return outline[0] + np.array(found)


def _circle_of_turn(drawing: Drawing, light: Light, scenery: Scenery, selected: bool) -> None:
    """Around the scene's middle, on which the front of the light stands; selected: with what is up."""
    middle, place = np.array(scenery.center), front(light, scenery)
    up = np.array(unit_vector(light.values(Up)[0]))
    far = float(np.linalg.norm(place - middle))
    drawing.line(circle(middle, up, far), 0.9 if selected else 0.3)
    if selected:
        drawing.line(np.array([place, place + 0.25 * far * (middle - place) / far]), 0.9)
        drawing.line(np.array([middle + 0.7 * far * up, middle + 0.9 * far * up]), 0.6)
        drawing.tip(middle + 0.9 * far * up, up, 0.6)


def _falloffs(drawing: Drawing, light: Light, scenery: Scenery) -> None:
    """Spheres where a half and a 256th of the light is left."""
    for coefficients in falloffs(light).values():
        for fraction, strength, label in _LEFT:
            radius = distance_of(fraction, coefficients)
            if radius is not None and radius < _LARGEST * scenery.size:
                _sphere(drawing, light, scenery, radius, strength)
                drawing.label(origin(light, scenery) + radius * drawing.view.viewer.axes[1], label)


def _sphere(drawing: Drawing, light: Light, scenery: Scenery, radius: float, strength: float) -> None:
    """Three great circles."""
    for normal in np.eye(3):
        _circle(drawing, light, scenery, normal, radius, strength)


def _circle(
    drawing: Drawing, light: Light, scenery: Scenery, normal: Float64Array, radius: float, strength: float
) -> None:
    if radius < _LARGEST * scenery.size:
        drawing.line(circle(origin(light, scenery), normal, radius), strength)
