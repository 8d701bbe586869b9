"""Lights from other notations: homogeneous positions, and the values that VTK keeps of a light; which ones it has."""

from __future__ import annotations

from typing import Any

from pvphong.base import check
from pvphong.optics.light import Light, VtkValues
from pvphong.optics.lights.directional import DirectionalLight
from pvphong.optics.lights.point import PointLight
from pvphong.optics.lights.spot import SpotLight


def light_from_homogeneous(position: Any, **common: Any) -> DirectionalLight | PointLight:
    """A light from OpenGL's homogeneous position (x, y, z, w).

    Parameters
    ----------
    position : sequence of float
        w = 0 gives a directional light that shines from (x, y, z), any other w a point light at
        (x, y, z)/w (OpenGL 2.1 specification, section 2.14.1).
    **common
        Fields of the light; a point light takes `attenuation` too.

    Raises
    ------
    ValueError
        If `position` is not four finite numbers, if (x, y, z) is zero where w is, or if a field is
        out of range.
    """
    x, y, z, w = check.numbers_in("position", position, 4)
    if w == 0.0:
        if not (x or y or z):
            check.refuse("position", position, "(x, y, z, w) that is not all zero")
        return DirectionalLight(direction=(-x, -y, -z), **common)
    return PointLight(position=(x / w, y / w, z / w), **common)


def light_from_values(values: VtkValues, **common: Any) -> Light:
    """The light that VTK makes of its values: a positional light whose cone is 90° or wider has none.

    Parameters
    ----------
    values : VtkValues
        Place and shape.
    **common
        The fields of every light.

    Raises
    ------
    ValueError
        If cone, attenuation or direction is not one that pvphong allows.
    """
    if not values.is_positional:
        return DirectionalLight(direction=values.direction, **common)
    common |= {"position": values.position, "attenuation": values.attenuation}
    if values.cone_angle is None or values.cone_angle >= 90.0:
        return PointLight(**common)
    return SpotLight(direction=values.direction, cone_angle=values.cone_angle, exponent=values.exponent, **common)


def refuse_unless_in_vtk(light: Light, argument: str, allowed: str) -> None:
    """Raise ValueError, which names the argument and the nearest light that VTK has, unless VTK has this one."""
    if type(light).as_vtk is not Light.as_vtk:
        return
    kind, nearest, remedy = type(light).__name__, light.nearest_in_vtk, ""
    if nearest is not light:
        shape = ", ".join(f"{field}={getattr(nearest, field)}" for field in nearest.roles)
        remedy = f"The nearest that VTK has is {type(nearest).__name__}({shape})."
    check.refuse(argument, f"{'an' if kind[0] in 'AEIOU' else 'a'} {kind}", allowed, remedy)
