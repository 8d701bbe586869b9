"""Conversion of lights to and from other notations: homogeneous positions, and the values that VTK's shader reads."""

from __future__ import annotations

import math
from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check
from pvphong.base.types import Vector
from pvphong.optics.attenuation import INVERSE_SQUARE
from pvphong.optics.light import Light
from pvphong.optics.lights.directional import DirectionalLight
from pvphong.optics.lights.environment import EnvironmentLight
from pvphong.optics.lights.photometric import PhotometricLight
from pvphong.optics.lights.point import PointLight, Weakening
from pvphong.optics.lights.sized import Flat
from pvphong.optics.lights.spot import SpotLight

# VTK does not support a cone of 90°.
_NEARLY_90 = 89.999


def light_from_homogeneous(position: Any, **common: Any) -> DirectionalLight | PointLight:
    """Make a light from OpenGL's homogeneous position (x, y, z, w).

    Parameters
    ----------
    position : sequence of float
        If w = 0, the result is a directional light that shines from the direction (x, y, z); else it is a point light
        at (x, y, z)/w (OpenGL 2.1 specification, section 2.14.1).
    **common
        Fields of the light; a point light also takes `attenuation`.

    Raises
    ------
    ValueError
        If `position` is not four finite numbers or is all zero, or if a field is out of range.

    Examples
    --------
    >>> import pvphong as ph
    >>> ph.pipeline.light_from_homogeneous((0, 0, 2, 1)).position
    (0.0, 0.0, 2.0)
    """
    x, y, z, w = check.numbers_in("position", position, 4)
    if w == 0.0:
        if not (x or y or z):
            check.refuse("position", position, "four numbers (x, y, z, w) that are not all zero")
        return DirectionalLight(direction=(-x, -y, -z), **common)
    return PointLight(position=(x / w, y / w, z / w), **common)


class VtkValues(NamedTuple):
    """Values that VTK's shader reads of a light, with coordinates in the light's own frame."""

    is_positional: bool
    direction: Vector
    position: Vector = (0.0, 0.0, 0.0)
    attenuation: Vector = (1.0, 0.0, 0.0)
    cone_angle: float | None = None
    """Half the opening angle in degrees; None for no cone. VTK takes 90° or more as no cone."""
    exponent: float = 0.0


@singledispatch
def vtk_values(light: Any) -> VtkValues:
    """Return the values with which VTK draws a light, or the nearest light that VTK supports.

    To draw and compare a user-defined kind of light, call `vtk_values.register(kind, function)`.

    Raises
    ------
    ValueError
        If VTK has no similar light.
    """
    nearest = nearest_in_vtk(light)
    if nearest is light:
        remedy = "pvphong can evaluate it; to draw it, or to compare it with VTK, call vtk_values.register."
        check.refuse("light", light, "a light that VTK supports", remedy)
    return vtk_values(nearest)


@vtk_values.register
def _(light: DirectionalLight) -> VtkValues:
    """Return VTK's values for a directional light: its direction. VTK ignores the light's angular size."""
    x, y, z = light.direction
    return VtkValues(False, (x, y, z))


@vtk_values.register
def _(light: Weakening) -> VtkValues:
    """Return VTK's values for a point light: its position and attenuation, and no cone."""
    return VtkValues(True, (0.0, 0.0, -1.0), light.position, light.attenuation)


@vtk_values.register
def _(light: SpotLight) -> VtkValues:
    """Return VTK's values for a spot light. VTK takes a cone of 90° as no cone, and clamps exponents to 128."""
    (x, y, z), (px, py, pz), (c, l, q) = light.direction, light.position, light.attenuation
    return VtkValues(True, (x, y, z), (px, py, pz), (c, l, q), light.cone_angle, light.exponent)


def is_in_vtk(light: Light) -> bool:
    """Return True if VTK supports lights of this kind, and the light has no size."""
    return vtk_values.dispatch(type(light)) is not vtk_values.dispatch(object) and not light.has_size


@singledispatch
def nearest_in_vtk(light: Any) -> Light:
    """Return the nearest light that VTK supports.

    This is the light itself if it has no size, and its single node, a light without a size, if it has one. Kinds of
    light with a better replacement are registered below.
    """
    nearest: Light = light.nodes(1)[0]
    return nearest


@nearest_in_vtk.register
def _(light: Flat) -> SpotLight:
    """Return the spot light that replaces a flat light: at its middle, with the widest cone that VTK supports."""
    return SpotLight(light.center, light.normal, _NEARLY_90, 1.0, INVERSE_SQUARE)


@nearest_in_vtk.register
def _(light: PhotometricLight) -> SpotLight | PointLight:
    """Return the light that replaces a measured lamp, with the same flux.

    It is a spot light if the lamp sends most of its light forward, else a point light. A spot light with the intensity
    I along its axis and the exponent e, I cosᵉ γ, has the flux 2π I / (e + 1).
    """
    measured, ahead = light.measured, light.arrival(np.array(light.places[0])[:, None] + light.axes[:1].T)
    along, flux = float(np.ravel(ahead.strength)[0]), measured.lumens
    if 2.0 * math.pi * along <= 0.5 * flux:
        return PointLight(light.position, (0.0, 0.0, 4.0 * math.pi / flux))
    exponent = max(2.0 * math.pi * along / flux - 1.0, 0.0)
    return SpotLight(light.position, light.direction, _NEARLY_90, exponent, (0.0, 0.0, 1.0 / along))


@nearest_in_vtk.register
def _(light: EnvironmentLight) -> DirectionalLight:
    """Return the directional light that replaces an environment.

    It shines from the mean direction of the environment's light.
    """
    return DirectionalLight(direction=light.nodes(1)[0].direction)


def light_from_values(values: VtkValues, **common: Any) -> Light:
    """Make a light from the values that VTK stores.

    A positional light with a cone of 90° or more becomes a point light.

    Parameters
    ----------
    values : VtkValues
        The values.
    **common
        The fields of every light, such as `diffuse` and `name`.

    Raises
    ------
    ValueError
        If pvphong does not allow the cone, attenuation or direction.
    """
    if not values.is_positional:
        return DirectionalLight(direction=values.direction, **common)
    common |= {"position": values.position, "attenuation": values.attenuation}
    if values.cone_angle is None or values.cone_angle >= 90.0:
        return PointLight(**common)
    return SpotLight(direction=values.direction, cone_angle=values.cone_angle, exponent=values.exponent, **common)


def refuse_unless_in_vtk(light: Light, argument: str, allowed: str) -> None:
    """Raise ValueError if VTK does not support a light; the message names the nearest light that VTK supports.

    Parameters
    ----------
    light : Light
        The light.
    argument : str
        Name of the argument, with which the message begins.
    allowed : str
        The allowed lights, which complete the sentence "<argument> must be …".
    """
    if is_in_vtk(light):
        return
    kind, nearest, remedy = type(light).__name__, nearest_in_vtk(light), ""
    if nearest is not light:
        shape = ", ".join(f"{field}={getattr(nearest, field)}" for field in nearest.roles)
        remedy = f"The nearest light in VTK is {type(nearest).__name__}({shape})."
    check.refuse(argument, f"{'an' if kind[0] in 'AEIOU' else 'a'} {kind}", allowed, remedy)
