"""Lights in other notations: homogeneous positions, and the values that VTK's shader knows of a light."""

from __future__ import annotations

from functools import singledispatch
from typing import Any, NamedTuple

from pvphong.base import check
from pvphong.base.types import Vector
from pvphong.optics.attenuation import INVERSE_SQUARE
from pvphong.optics.light import Light
from pvphong.optics.lights.directional import DirectionalLight
from pvphong.optics.lights.environment import EnvironmentLight
from pvphong.optics.lights.point import PointLight, Weakening
from pvphong.optics.lights.sized import Flat
from pvphong.optics.lights.spot import SpotLight

# VTK has no cone of 90°.
_NEARLY_90 = 89.999


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

    Examples
    --------
    >>> import pvphong as ph
    >>> ph.pipeline.light_from_homogeneous((0, 0, 2, 1)).position
    (0.0, 0.0, 2.0)
    """
    x, y, z, w = check.numbers_in("position", position, 4)
    if w == 0.0:
        if not (x or y or z):
            check.refuse("position", position, "(x, y, z, w) that is not all zero")
        return DirectionalLight(direction=(-x, -y, -z), **common)
    return PointLight(position=(x / w, y / w, z / w), **common)


class VtkValues(NamedTuple):
    """A light in the values that VTK's shader knows, coordinates in the light's own frame."""

    is_positional: bool
    direction: Vector
    position: Vector = (0.0, 0.0, 0.0)
    attenuation: Vector = (1.0, 0.0, 0.0)
    cone_angle: float | None = None
    """Half the opening in degrees; None where there is no cone, as VTK has it from 90° on."""
    exponent: float = 0.0


@singledispatch
def vtk_values(light: Any) -> VtkValues:
    """A light in VTK's values; of one that VTK has not, those of the nearest.

    A kind of your own can be drawn and compared once it is registered here: `vtk_values.register(kind, function)`.

    Raises
    ------
    ValueError
        If there is none.
    """
    nearest = nearest_in_vtk(light)
    if nearest is light:
        remedy = "It can be evaluated and planned; a kind with `vtk_values` can also be drawn and compared."
        check.refuse("light", light, "one that VTK has", remedy)
    return vtk_values(nearest)


@vtk_values.register
def _(light: DirectionalLight) -> VtkValues:
    """Its direction."""
    x, y, z = light.direction
    return VtkValues(False, (x, y, z))


@vtk_values.register
def _(light: Weakening) -> VtkValues:
    """Position and attenuation; VTK's point light is a spot without a cone."""
    return VtkValues(True, (0.0, 0.0, -1.0), light.position, light.attenuation)


@vtk_values.register
def _(light: SpotLight) -> VtkValues:
    """All its fields. VTK takes a cone of 90° for none, and keeps exponents up to 128."""
    (x, y, z), (px, py, pz), (c, l, q) = light.direction, light.position, light.attenuation
    return VtkValues(True, (x, y, z), (px, py, pz), (c, l, q), light.cone_angle, light.exponent)


def is_in_vtk(light: Light) -> bool:
    """Whether VTK has such a light itself."""
    return vtk_values.dispatch(type(light)) is not vtk_values.dispatch(object)


@singledispatch
def nearest_in_vtk(light: Any) -> Light:
    """The nearest light without a size, as VTK may have it; a light itself if it has none."""
    nearest: Light = light.nodes(1)[0]
    return nearest


@nearest_in_vtk.register
def _(light: Flat) -> SpotLight:
    """A spot light in its middle, with a cone that VTK has."""
    return SpotLight(light.center, light.normal, _NEARLY_90, 1.0, INVERSE_SQUARE)


@nearest_in_vtk.register
def _(light: EnvironmentLight) -> DirectionalLight:
    """Parallel light from where it is brightest on average."""
    return DirectionalLight(direction=light.nodes(1)[0].direction)


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
    if is_in_vtk(light):
        return
    kind, nearest, remedy = type(light).__name__, nearest_in_vtk(light), ""
    if nearest is not light:
        shape = ", ".join(f"{field}={getattr(nearest, field)}" for field in nearest.roles)
        remedy = f"The nearest that VTK has is {type(nearest).__name__}({shape})."
    check.refuse(argument, f"{'an' if kind[0] in 'AEIOU' else 'a'} {kind}", allowed, remedy)
