"""The gizmo of a point light: its position, and where its light has weakened."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pvphong.base.types import Float64Array, Vector
from pvphong.optics.lights import PointLight
from pvphong.studio.gizmos.drawing import Drawing, circle
from pvphong.studio.gizmos.press import Cursor, Place, Press, vector
from pvphong.studio.gizmos.view import View


def handles(light: PointLight, place: Place, view: View) -> dict[str, Float64Array]:  # noqa: ARG001 as other kinds
    """Its position; and the radius at half the light, if it weakens."""
    position = np.array(light.position)
    radius = falls_to(light, 0.5)
    if radius is None:
        return {"position": position}
    return {"position": position, "radius": position + radius * view.viewer.axes[0]}


def falls_to(light: PointLight, fraction: float) -> float | None:
    """The distance at which 1 / (c + l·d + q·d²) is a fraction of what it is at the light, if there is one.

    Where c is 0 it has no bounds at the light, and the fraction is of 1.
    """
    constant, linear, quadratic = light.attenuation
    rest = (constant or 1.0) / fraction - constant
    if quadratic:
        root = math.sqrt(linear * linear + 4.0 * quadratic * rest)
        return 2.0 * rest / (linear + root)
    return rest / linear if linear else None


def drag(press: Press, at: Cursor) -> PointLight:
    """The light that the cursor asks for."""
    light = press.light
    assert isinstance(light, PointLight)
    if press.handle == "radius":
        return _resized(light, press, at)
    return replace(light, position=vector(press.moved_on_grid(at)))


def _resized(light: PointLight, press: Press, at: Cursor) -> PointLight:
    """Linear and quadratic coefficient scaled so that half the light is left at the cursor's distance."""
    old = falls_to(light, 0.5)
    if old is None or not press.view.is_ahead(light.position) or not press.motion(at).any():
        return light
    reached = press.view.facing(light.position, press.picture(at))
    new = float(np.linalg.norm(reached - np.array(light.position)))
    if at.snapping:
        new = max(round(new / press.grid), 1) * press.grid
    shrink = old / max(new, 1e-6 * press.place.size)
    constant, linear, quadratic = light.attenuation
    return replace(light, attenuation=(constant, linear * shrink, quadratic * shrink * shrink))


def draw(drawing: Drawing, light: PointLight, place: Place, selected: bool) -> None:
    """A bulb; selected: three great circles each where a half and a 256th of the light is left."""
    position = np.array(light.position)
    drawing.icon(position, "bulb")
    if not selected:
        return
    for fraction, strength in ((0.5, 0.9), (1.0 / 256.0, 0.35)):
        radius = falls_to(light, fraction)
        if radius is not None and radius < 1e4 * place.size:
            for normal in np.eye(3):
                drawing.line(circle(position, normal, radius), strength)


def arriving(light: PointLight, place: Place) -> tuple[str, Vector]:  # noqa: ARG001 as other kinds
    """Where the light is measured for the readout: in the middle of the scene."""
    return "at the scene's middle", place.center
