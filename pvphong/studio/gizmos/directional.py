"""The gizmo of a directional light: an icon that stands anywhere, and an arrow to a target."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pvphong.base.types import Float64Array, Vector
from pvphong.base.vectors import unit_vector
from pvphong.optics.lights import DirectionalLight
from pvphong.studio.gizmos.drawing import Drawing
from pvphong.studio.gizmos.press import Cursor, Place, Press, aimed, vector
from pvphong.studio.gizmos.view import View

DISTANCE = 0.95
"""How far from the scene's middle the icon stands, and 0.6 of it how long the arrow is, in scene sizes."""


def travel(light: DirectionalLight) -> Float64Array:
    """Unit vector along the light's direction."""
    return np.array(unit_vector(light.direction))


def anchor(light: DirectionalLight, center: Vector, size: float) -> Vector:
    """Where the icon stands at first: in front of the scene, where the light comes from."""
    return vector(np.array(center) - DISTANCE * size * travel(light))


def handles(light: DirectionalLight, place: Place, view: View) -> dict[str, Float64Array]:  # noqa: ARG001 as other kinds
    """The tip of its arrow."""
    return {"target": np.array(place.anchor) + 0.6 * DISTANCE * place.size * travel(light)}


def drag(press: Press, at: Cursor) -> DirectionalLight:
    """The light that the cursor asks for."""
    light = press.light
    assert isinstance(light, DirectionalLight)
    direction = aimed(press, at, press.place.anchor, vector(light.direction))
    return replace(light, direction=direction)


def draw(drawing: Drawing, light: DirectionalLight, place: Place, selected: bool) -> None:
    """A sun and a line to the target; selected: four parallel rays with tips."""
    start, along = np.array(place.anchor), travel(light)
    tip = start + 0.6 * DISTANCE * place.size * along
    drawing.icon(start, "sun")
    drawing.line(np.array([start, tip]), 1.0 if selected else 0.45)
    if selected:
        side = drawing.across(along, start)
        other = np.cross(along, side)
        for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            offset = 0.1 * place.size * (x * side + y * other)
            drawing.line(np.array([start + offset, tip + offset]), 0.6)
            drawing.tip(tip + offset, along, 0.6)


def arriving(light: DirectionalLight, place: Place) -> tuple[str, Vector]:  # noqa: ARG001 as other kinds
    """Where the light is measured for the readout: it is the same everywhere."""
    return "everywhere", place.center
