"""Conversion of lights from VTK and PyVista to pvphong and back, without rounding of colours; VTK's light kit.

Lower packages, such as `optics`, call PyVista and VTK through this module; see `pvphong.base.host`.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import reference
from vtkmodules.vtkRenderingCore import vtkAbstractMapper, vtkLightKit, vtkRenderer

from pvphong.base import check
from pvphong.base.types import ByteArray, Frame, Vector, rgb
from pvphong.base.vectors import unit
from pvphong.meshes import colormaps
from pvphong.optics.colormap import Colormap
from pvphong.optics.light import Light
from pvphong.optics.lights import VtkValues, light_from_values, vtk_values
from pvphong.scene.viewer import Viewer

# Largest ratio of the coordinates' size to the focal point's distance, as a power of two. It limits the error of the
# direction to 2⁻³².
_KEPT_BITS = 20


def as_light(light: Any, viewer: Any = None) -> Light:
    """Convert a `pyvista.Light` or `vtkLight` to a pvphong light. Colours are not rounded.

    The type of the light determines its frame. A scene light gets the frame "world", and its transform matrix is
    applied. A headlight gets the frame "headlight". A camera light, which moves with the viewer, gets the frame
    "camera". With a `viewer`, a camera light is placed in the world instead. The world position that VTK stores for the
    light is not used, because VTK updates this position only when it renders.

    All fields are converted, including those that VTK's shader ignores. `pyvista.Light(color=…)` also sets the ambient
    colour, which the standard convention uses and `LightModel.vtk()` does not. A light with a `shadow_attenuation` of 0
    casts no shadows; shadows of other lights are fully dark.

    A positional light becomes a spot light, or a point light if its cone is 90° or wider. A pvphong light is returned
    unchanged.

    Parameters
    ----------
    light : pyvista.Light, vtkLight or Light
        The light; it is not modified.
    viewer : Viewer, optional
        Viewer that places a camera light in the world.

    Raises
    ------
    ValueError
        If `light` is not a light, or pvphong does not allow its cone, attenuation or direction.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> ph.as_light(pv.Light(position=(0, 0, 5), color="red", light_type="scene light")).diffuse
    (1.0, 0.0, 0.0)
    """
    if viewer is None:
        return from_vtk(light, _camera_distance(light))
    _check_viewer(viewer)
    if _is_moved_headlight(light):  # VTK applies the matrix to the eye and its focal point
        eye, ahead = np.array(viewer.position), np.array(viewer.view_direction) * viewer.distance
        matrix = light.GetTransformMatrix()
        position, focal_point = (matrix.MultiplyPoint((*point, 1.0))[:3] for point in (eye, eye + ahead))
        return _light_at(light, "world", position, _direction(position, focal_point))
    converted = from_vtk(light, viewer.distance)
    if converted is light or converted.frame == "world":
        return converted
    placed = converted.in_world(viewer)
    return placed if converted.frame == "camera" else replace(placed, frame="headlight")


def _check_viewer(viewer: Any) -> None:
    if not isinstance(viewer, Viewer):
        check.refuse("viewer", viewer, "a Viewer", "Convert a camera with Viewer.from_camera(camera).")


def from_vtk(light: Any, distance: float) -> Light:
    """Convert a `pyvista.Light` or `vtkLight` to a pvphong light; a camera light keeps the frame "camera".

    VTK stores the position of a camera light as a multiple of the distance from the viewer's eye to its focal point.
    `distance` is this distance. A pvphong light is returned unchanged.
    """
    if isinstance(light, Light):
        return light
    if not hasattr(light, "GetConeAngle") or not hasattr(light, "GetTransformedPosition"):
        check.refuse("light", light, "a pvphong light, a pyvista.Light or a vtkLight")
    if _is_moved_headlight(light):
        remedy = "Place it in the world with as_light(light, viewer), or use a camera light."
        check.refuse("light", "a headlight with a matrix", "a headlight without a transform matrix", remedy)
    if light.LightTypeIsHeadlight():
        # VTK overwrites a headlight's world coordinates whenever it renders; in eye space they are constant.
        return _light_at(light, "headlight", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    if light.LightTypeIsCameraLight():
        # VTK sets a camera light's transform only when it renders. The coordinates, set by the user, are up to date.
        (x, y, z), focal_point = light.GetPosition(), light.GetFocalPoint()
        in_eye_space = x * distance, y * distance, (z - 1.0) * distance  # inverse of `_place_for_vtk`
        return _light_at(light, "camera", in_eye_space, _direction((x, y, z), focal_point))
    position, focal_point = light.GetTransformedPosition(), light.GetTransformedFocalPoint()
    return _light_at(light, "world", position, _direction(position, focal_point))


def _is_moved_headlight(light: Any) -> bool:
    """Return True for a VTK headlight with a transform matrix other than the identity.

    Such a headlight is not at the viewer's eye: VTK applies the matrix to the position and the direction of the viewer.
    """
    if isinstance(light, Light) or not getattr(light, "LightTypeIsHeadlight", bool)():
        return False
    matrix = light.GetTransformMatrix()
    return matrix is not None and not matrix.IsIdentity()


def _direction(start: Vector, end: Vector) -> Vector:
    return end[0] - start[0], end[1] - start[1], end[2] - start[2]


def _light_at(light: Any, frame: Frame, position: Vector, direction: Vector) -> Light:
    """Convert a VTK light to a pvphong light with another frame, position and direction.

    Colours and falloff are those of the VTK light, `light`.
    """
    common: dict[str, Any] = {
        "diffuse": light.GetDiffuseColor(),
        "specular": light.GetSpecularColor(),
        "ambient": light.GetAmbientColor(),
        "intensity": light.GetIntensity(),
        "on": bool(light.GetSwitch()),
        "casts_shadows": light.GetShadowAttenuation() > 0.0,
        "frame": frame,
    }
    if common["specular"] == common["diffuse"]:
        common["specular"] = None
    falloff = light.GetAttenuationValues(), light.GetConeAngle(), light.GetExponent()
    return light_from_values(VtkValues(bool(light.GetPositional()), direction, position, *falloff), **common)


def _camera_distance(light: Any) -> float:
    """Return the distance from the viewer's eye to its focal point that VTK used when it last placed a camera light.

    The result is 1 if VTK has not placed the light yet.
    """
    matrix = getattr(light, "GetTransformMatrix", lambda: None)()
    if matrix is None:
        return 1.0
    scale = np.array([[matrix.GetElement(row, 0)] for row in range(3)])
    return float(unit(scale)[1][0]) or 1.0


def to_pyvista(light: Light, viewer: Any = None) -> pv.Light:
    """Return a light as a new `pyvista.Light`. `Light.to_pyvista` calls this function, and explains `viewer`."""
    if viewer is not None:
        _check_viewer(viewer)
    result = pv.Light()
    write_light(light, result, viewer)
    return result


def write_light(light: Light, target: Any, viewer: Any = None) -> None:
    """Write the values of a pvphong light, `light`, to `target`, an existing `pyvista.Light` or `vtkLight`.

    The values are those of `Light.to_pyvista`. `viewer` places a light that moves with the camera.
    """
    values = vtk_values(light)
    target.SetLightType({"headlight": 1, "camera": 2, "world": 3}[light.frame])  # VTK_LIGHT_TYPE_HEADLIGHT etc.
    target.SetTransformMatrix(None)
    target.SetDiffuseColor(rgb(light.diffuse))
    target.SetSpecularColor(light.specular_color)
    target.SetAmbientColor(rgb(light.ambient))
    target.SetIntensity(light.intensity)
    target.SetSwitch(light.on)
    if light.casts_shadows != (target.GetShadowAttenuation() > 0.0):  # VTK's shadows may also be partly dark
        target.SetShadowAttenuation(float(light.casts_shadows))
    target.SetPositional(values.is_positional)
    x, y, z = values.direction
    if not values.is_positional:
        target.SetPosition(-x, -y, -z)
        target.SetFocalPoint(0.0, 0.0, 0.0)
        return
    distance = 1.0 if viewer is None else viewer.distance
    position = _place_for_vtk(values.position, light.frame, distance)
    target.SetPosition(position)
    target.SetAttenuationValues(*values.attenuation)
    if values.cone_angle is None:  # at 90° or more VTK applies no cone, for any focal point
        x, y, z = values.position
        target.SetConeAngle(90.0)
        target.SetFocalPoint(_place_for_vtk((x, y, z - 1.0), light.frame, distance))
    else:
        target.SetConeAngle(values.cone_angle)
        target.SetExponent(values.exponent)
        # The focal point must be far enough from the position to keep the precision of the direction.
        bits = math.frexp(max(map(abs, position)))[1] - math.frexp(max(map(abs, values.direction)))[1]
        step = max(1.0, 2.0 ** (bits - _KEPT_BITS))
        target.SetFocalPoint(*(p + d * step for p, d in zip(position, values.direction, strict=True)))


def _place_for_vtk(position: Vector, frame: Frame, distance: float) -> Vector:
    """Convert a position in the given frame to the coordinates that VTK stores for a light.

    A camera light is stored in VTK's camera-light space (vtkCamera::ComputeCameraLightTransform). In this space, the
    eye is at (0, 0, 1) and looks at the focal point, the origin. The unit is the distance from eye to focal point,
    `distance`.
    """
    if frame != "camera":
        return position
    x, y, z = position
    return x / distance, y / distance, z / distance + 1.0


def color_by_name(name: str) -> Vector:
    """Return red, green and blue, in [0, 1], of a colour's name in PyVista or of a hex string.

    Raises
    ------
    ValueError
        If the colour is unknown to PyVista or not opaque.
    """
    red, green, blue, opacity = pv.Color(name).float_rgba
    if opacity != 1.0:
        raise ValueError(f"{name} has an opacity")
    return float(red), float(green), float(blue)


def color_names() -> list[str]:
    """Return PyVista's colour names, without alternative spellings."""
    return list(pv.hex_colors)


def colormap_names() -> list[str]:
    """Return the names of the colormaps of Matplotlib and of other installed packages."""
    return colormaps.names()


def mapped_colors(name: str, colormap: Colormap) -> ByteArray:
    """Return the 8-bit colours, shape (n, 3), of a colormap whose `scalars` are an array, not a name.

    `name` is the name of the material's field; messages of errors begin with it.
    """
    return colormaps.mapped(name, colormap)


def mapper_colors(mapper: Any) -> ByteArray | None:
    """Return the 8-bit colours, shape (n, 3), that a VTK mapper gives the points or cells of its mesh.

    The result is None if the mapper gives no colours, so that the actor's property colours the whole mesh.
    """
    if mapper is None or not mapper.GetScalarVisibility():
        return None
    mapper.Update()  # the mapper may not have been rendered yet
    how = mapper.GetScalarMode(), mapper.GetArrayAccessMode(), mapper.GetArrayId(), mapper.GetArrayName()
    of_cells: Any = reference(0)  # set by VTK
    scalars = vtkAbstractMapper.GetAbstractScalars(mapper.GetInput(), *how, of_cells)
    table = mapper.GetLookupTable()
    if scalars is None or table is None:
        return None
    # `mapper.MapScalars` returns no colours of points if the mapper interpolates scalars before mapping
    mapped = table.MapScalars(scalars, mapper.GetColorMode(), mapper.GetArrayComponent())
    return np.array(vtk_to_numpy(mapped), np.uint8)[:, :3]


def light_kit() -> tuple[Light, ...]:
    """Return the five lights of VTK's light kit, PyVista's default, which move with the camera.

    Source: the defaults of vtkLightKit; Halle and Meng, "LightKit: a lighting system for effective visualization"
    (2003).

    Returns
    -------
    tuple of Light
        "head", a headlight, and "key", "fill", "back left" and "back right" in the camera frame.

    Examples
    --------
    >>> import pvphong as ph
    >>> [light.frame for light in ph.light_kit()]
    ['headlight', 'camera', 'camera', 'camera', 'camera']
    """
    kit, renderer = vtkLightKit(), vtkRenderer()
    kit.AddLightsToRenderer(renderer)
    kit.Update()
    named = zip(renderer.GetLights(), ("head", "key", "fill", "back left", "back right"), strict=True)
    return tuple(replace(from_vtk(light, 1.0), name=name) for light, name in named)
