"""The text beside a handle that is being dragged."""

from __future__ import annotations

import math

import numpy as np

from pvphong.optics.lights import DirectionalLight, Light, PointLight, SpotLight
from pvphong.studio.gizmos.kinds import kind_of
from pvphong.studio.gizmos.press import Place


def readout(light: Light, handle: str, place: Place) -> str:
    """What a drag is changing, in numbers, and how much light arrives.

    Parameters
    ----------
    light : Light
        As it is now, in the world.
    handle : str
        The handle that is dragged.
    place : Place
        The scene.
    """
    lines = [f"{light.name}: {handle}" if light.name else handle, *_geometry(light)]
    where, point = kind_of(light).arriving(light, place)
    strength = float(np.ravel(light.arrival(np.array(point)[:, None]).strength)[0]) * light.intensity
    return "\n".join([*lines, f"{strength if light.on else 0.0:.3g} arriving {where}"])


def _geometry(light: Light) -> list[str]:
    lines = []
    if isinstance(light, (PointLight, SpotLight)):
        lines.append("position " + _numbers(light.position))
    if isinstance(light, SpotLight):
        lines.append("target " + _numbers(np.array(light.position) + light.direction))
        lines.append(f"distance {math.dist((0, 0, 0), light.direction):.4g}, cone {light.cone_angle:.1f}°")
    elif isinstance(light, DirectionalLight):
        x, y, z = np.array(light.direction) / math.dist((0, 0, 0), light.direction)
        lines.append("direction " + _numbers((x, y, z)))
        lines.append(f"azimuth {math.degrees(math.atan2(y, x)):.1f}°, elevation {math.degrees(math.asin(z)):.1f}°")
    elif isinstance(light, PointLight):
        lines.append("attenuation " + _numbers(light.attenuation))
    return lines


def _numbers(values: object) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in np.asarray(values, dtype=np.float64).tolist()) + ")"
