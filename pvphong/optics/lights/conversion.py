"""Lights from other notations: VTK's and PyVista's light objects, and homogeneous positions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import Frame, Vector
from pvphong.base.vectors import unit
from pvphong.optics.light import EyeSpace, Light
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


def as_light(light: Any, viewer: EyeSpace | None = None) -> Light:
    """A pvphong light from a `pyvista.Light` or `vtkLight`, its colours unrounded.

    A scene light gives frame "world", through its transform matrix if it has one; a headlight gives
    frame "headlight". A camera light rides along with the viewer and gives frame "camera"; where a
    `viewer` is given it is put where that viewer has it in the world, whatever VTK last knew (VTK brings
    a camera light's world position up to date only when it renders).

    Every field is taken over, also those that VTK's shader ignores: `pyvista.Light(color=…)` sets the ambient
    colour too, which counts in the standard convention and does not in `LightModel.vtk()`.

    VTK's positional lights become spot lights, or point lights where the cone is 90° or wider. A light of
    pvphong's own is given back as it is.

    Parameters
    ----------
    light : pyvista.Light, vtkLight or Light
        The light; it is not modified.
    viewer : Viewer, optional
        Places a camera light in the world.

    Raises
    ------
    ValueError
        If `light` is none of these, or its cone, attenuation or direction is not one that pvphong allows.
    """
    if viewer is None:
        return from_vtk(light, _camera_distance(light))
    if _is_moved_headlight(light):
        return _moved_headlight(light, viewer)
    converted = from_vtk(light, viewer.distance)
    if converted is light or converted.frame == "world":
        return converted
    placed = converted.in_world(viewer)
    return placed if converted.frame == "camera" else replace(placed, frame="headlight")


def from_vtk(light: Any, distance: float) -> Light:
    """`as_light` for a camera whose eye is `distance` from its focal point; camera lights stay camera lights."""
    if isinstance(light, Light):
        return light
    if not hasattr(light, "GetConeAngle") or not hasattr(light, "GetTransformedPosition"):
        check.refuse("light", light, "a pvphong light, a pyvista.Light or a vtkLight")
    if _is_moved_headlight(light):
        remedy = "as_light(light, viewer) places it in the world; a light that rides along is a camera light."
        check.refuse("light", "a headlight with one", "a headlight without a transform matrix", remedy)
    if light.LightTypeIsHeadlight():
        # VTK overwrites its coordinates at every frame; in eye space they are always these.
        return _with_shape(light, "headlight", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    if light.LightTypeIsCameraLight():
        # Its transform is VTK's own, and stale; its untransformed coordinates are the user's.
        position, focal_point = light.GetPosition(), light.GetFocalPoint()
        return _with_shape(light, "camera", _eye_space(position, distance), _between(position, focal_point))
    position, focal_point = light.GetTransformedPosition(), light.GetTransformedFocalPoint()
    return _with_shape(light, "world", position, _between(position, focal_point))


def _is_moved_headlight(light: Any) -> bool:
    """Whether VTK would move the viewer's position and direction by a matrix of the light's."""
    if isinstance(light, Light) or not getattr(light, "LightTypeIsHeadlight", bool)():
        return False
    matrix = light.GetTransformMatrix()
    return matrix is not None and not matrix.IsIdentity()


def _moved_headlight(light: Any, viewer: EyeSpace) -> Light:
    """The headlight in the world, as VTK draws it: the eye and what it looks at, transformed."""
    eye, ahead = np.array(viewer.position), np.array(viewer.view_direction) * viewer.distance
    matrix = light.GetTransformMatrix()
    position, focal_point = (matrix.MultiplyPoint((*point, 1.0))[:3] for point in (eye, eye + ahead))
    return _with_shape(light, "world", position, _between(position, focal_point))


def _between(start: Vector, end: Vector) -> Vector:
    return end[0] - start[0], end[1] - start[1], end[2] - start[2]


def _with_shape(light: Any, frame: Frame, position: Vector, direction: Vector) -> Light:
    common: dict[str, Any] = {
        "diffuse": light.GetDiffuseColor(),
        "specular": light.GetSpecularColor(),
        "ambient": light.GetAmbientColor(),
        "intensity": light.GetIntensity(),
        "on": bool(light.GetSwitch()),
        "frame": frame,
    }
    if common["specular"] == common["diffuse"]:
        common["specular"] = None
    if not light.GetPositional():
        return DirectionalLight(direction=direction, **common)
    common |= {"position": position, "attenuation": light.GetAttenuationValues()}
    if light.GetConeAngle() >= 90.0:
        return PointLight(**common)
    return SpotLight(direction=direction, cone_angle=light.GetConeAngle(), exponent=light.GetExponent(), **common)


def _eye_space(point: Vector, distance: float) -> Vector:
    """Inverse of `place_for_vtk` for a camera light."""
    x, y, z = point
    return x * distance, y * distance, (z - 1.0) * distance


def _camera_distance(light: Any) -> float:
    """The eye's distance that VTK last used to place a camera light, or 1 where it has not placed it yet."""
    matrix = getattr(light, "GetTransformMatrix", lambda: None)()
    if matrix is None:
        return 1.0
    scale = np.array([[matrix.GetElement(row, 0)] for row in range(3)])
    return float(unit(scale)[1][0]) or 1.0
