"""The text beside a handle that is being dragged."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.base.types import Vector, rgb
from pvphong.optics.light import Light
from pvphong.optics.roles import Aim, Angle, Corners, Length, Place, Turn
from pvphong.studio.gizmos.colors import luminance
from pvphong.studio.gizmos.drag_start import Scenery, vector
from pvphong.studio.gizmos.shape import ORIGIN, falloffs, fields, handle_names, middle_of, reach, target
from pvphong.studio.gizmos.typed import angles_of


def readout(light: Light, handle: str, scenery: Scenery) -> str:
    """What a drag is changing, in numbers, and how much light arrives.

    Parameters
    ----------
    light : Light
        As it is now, in the world.
    handle : str
        The handle that is dragged.
    scenery : Scenery
        The scene.
    """
    lines = [f"{light.name}: {handle}" if light.name else handle, *_vectors(light, scenery)]
    if scalars := _scalars(light, handle, scenery):
        lines.append(", ".join(scalars))
    lines += [f"{field} {_numbers(value)}" for field, value in falloffs(light).items()]
    return "\n".join([*lines, arriving_line(light, scenery)])


def arriving_line(light: Light, scenery: Scenery) -> str:
    """How much of a light of the world arrives, as a multiple of its colour, and the luminance of that."""
    where, point = arriving(light, scenery)
    strength = float(np.ravel(light.arrival(np.array(point)[:, None]).strength)[0]) * light.intensity * light.on
    return f"{strength:.3g} arriving {where}\nluminance {strength * luminance(rgb(light.diffuse)):.3g}"


def arriving(light: Light, scenery: Scenery) -> tuple[str, Vector]:
    """Where the light is measured."""
    if light.is_even:
        return "everywhere", scenery.center
    if light.values(Place) and light.values(Aim):
        return "at the target", vector(target(light, light.values(Aim)[0], scenery))
    return "at the scene's middle", scenery.center


def _vectors(light: Light, scenery: Scenery) -> list[str]:
    """Its places; its targets, or the directions of a light that is nowhere."""
    lines = [f"{field} {_numbers(place)}" for field, place in fields(light, Place).items()]
    lines += [f"{_label(light, field)} {_numbers(middle_of(light, field))}" for field in fields(light, Corners)]
    for field, direction in fields(light, Aim).items():
        if light.values(Place):
            lines.append(f"{_label(light, field)} {_numbers(target(light, direction, scenery))}")
        else:
            lines.append(f"{field} {_numbers(np.array(direction) / math.hypot(*direction))}")
    return lines


def _scalars(light: Light, handle: str, scenery: Scenery) -> list[str]:
    """Distances or angles of its aims, at the icon of where it comes from; its sizes, its angles, its turn."""
    found: list[str] = []
    for direction in light.values(Aim):
        if light.values(Place):
            found.append(f"distance {reach(light, direction, scenery):.4g}")
        else:
            azimuth, elevation = angles_of(np.negative(direction) if handle == ORIGIN else direction)
            found.append(f"azimuth {azimuth:.1f}°, elevation {elevation:.1f}°")
    found += [f"{_label(light, field)} {length:.4g}" for field, length in fields(light, Length).items()]
    return found + [
        f"{_label(light, field)} {angle:.1f}°" for role in (Angle, Turn) for field, angle in fields(light, role).items()
    ]


def _label(light: Light, field: str) -> str:
    return handle_names(light).get(field, field)


def _numbers(values: Any) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in np.asarray(values, dtype=np.float64).tolist()) + ")"
