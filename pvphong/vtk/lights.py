"""Lights of VTK's and PyVista's as pvphong's, and the other way round.

Answers the core's questions to PyVista and VTK.

VTK's light kit, as lights.

What float32 does to VTK's physically based shading: an estimate in float64, apart from evaluator and shader.

Symbols as in `pvphong.optics.reflectances.microfacets`. Errors are in roundings of 2⁻²⁴.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkLightKit, vtkRenderer

from pvphong.base import check, host
from pvphong.base.types import Float64Array, Frame, Vector, rgb
from pvphong.base.vectors import unit
from pvphong.optics.light import Light, VtkValues
from pvphong.optics.lights import light_from_values
from pvphong.optics.roles import EyeSpace
from pvphong.scene.viewer import Viewer

# A focal point this many bits closer than the coordinates are large still tells the direction to 2⁻³².
_KEPT_BITS = 20


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
    _check_viewer(viewer)
    if _is_moved_headlight(light):
        return _moved_headlight(light, viewer)
    converted = from_vtk(light, viewer.distance)
    if converted is light or converted.frame == "world":
        return converted
    placed = converted.in_world(viewer)
    return placed if converted.frame == "camera" else replace(placed, frame="headlight")


def _check_viewer(viewer: Any) -> None:
    if not isinstance(viewer, Viewer):
        check.refuse("viewer", viewer, "a Viewer", "Viewer.from_camera(camera) makes one.")


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
    values = VtkValues(
        bool(light.GetPositional()),
        direction,
        position,
        light.GetAttenuationValues(),
        light.GetConeAngle(),
        light.GetExponent(),
    )
    return light_from_values(values, **common)


def _eye_space(point: Vector, distance: float) -> Vector:
    """Inverse of `_place_for_vtk` for a camera light."""
    x, y, z = point
    return x * distance, y * distance, (z - 1.0) * distance


def _camera_distance(light: Any) -> float:
    """The eye's distance that VTK last used to place a camera light, or 1 where it has not placed it yet."""
    matrix = getattr(light, "GetTransformMatrix", lambda: None)()
    if matrix is None:
        return 1.0
    scale = np.array([[matrix.GetElement(row, 0)] for row in range(3)])
    return float(unit(scale)[1][0]) or 1.0


def to_pyvista(light: Light, viewer: EyeSpace | None = None) -> pv.Light:
    """`Light.to_pyvista`."""
    if viewer is not None:
        _check_viewer(viewer)
    result = pv.Light()
    write_light(light, result, viewer)
    return result


def write_light(light: Light, target: Any, viewer: EyeSpace | None = None) -> None:
    """Give an existing `pyvista.Light` or `vtkLight` a light's values, as `Light.to_pyvista` does."""
    values = light.as_vtk()
    {
        "world": target.SetLightTypeToSceneLight,
        "camera": target.SetLightTypeToCameraLight,
        "headlight": target.SetLightTypeToHeadlight,
    }[light.frame]()
    target.SetTransformMatrix(None)
    target.SetDiffuseColor(rgb(light.diffuse))
    target.SetSpecularColor(light.specular_color)
    target.SetAmbientColor(rgb(light.ambient))
    target.SetIntensity(light.intensity)
    target.SetSwitch(light.on)
    target.SetPositional(values.is_positional)
    if values.is_positional:
        _write_place(values, light.frame, 1.0 if viewer is None else viewer.distance, target)
    else:
        x, y, z = values.direction
        target.SetPosition(-x, -y, -z)
        target.SetFocalPoint(0.0, 0.0, 0.0)


def _write_place(values: VtkValues, frame: Frame, distance: float, target: Any) -> None:
    """Position, attenuation and cone, or a cone of 90° and any focal point where there is no cone."""
    target.SetAttenuationValues(*values.attenuation)
    position = _place_for_vtk(values.position, frame, distance)
    target.SetPosition(position)
    if values.cone_angle is None:
        x, y, z = values.position
        target.SetConeAngle(90.0)
        target.SetFocalPoint(_place_for_vtk((x, y, z - 1.0), frame, distance))
    else:
        target.SetConeAngle(values.cone_angle)
        target.SetExponent(values.exponent)
        target.SetFocalPoint(_point_ahead(position, values.direction))


def _place_for_vtk(position: Vector, frame: Frame, distance: float) -> Vector:
    """A position in the coordinates that VTK keeps for a light of this frame.

    VTK's camera-light space has the eye at (0, 0, 1), looks at the origin and counts in units of the
    distance between the two (vtkCamera::ComputeCameraLightTransform).
    """
    if frame != "camera":
        return position
    x, y, z = position
    return x / distance, y / distance, z / distance + 1.0


def _point_ahead(position: Vector, direction: Vector) -> Vector:
    """A point in some direction, far enough from the position that the direction can be told from the two."""
    reach = max(map(abs, direction))
    step = max(1.0, 2.0 ** (math.frexp(max(map(abs, position)))[1] - math.frexp(reach)[1] - _KEPT_BITS))
    x, y, z = (p + d * step for p, d in zip(position, direction, strict=True))
    return x, y, z


# --- host


def _color_by_name(name: str) -> Vector:
    red, green, blue, opacity = pv.Color(name).float_rgba
    if opacity != 1.0:
        raise ValueError(f"{name} has an opacity")
    return float(red), float(green), float(blue)


def answer_the_core() -> None:
    """Say which functions answer; see `pvphong.base.host`."""
    host.answer(
        color_by_name=_color_by_name,
        color_names=lambda: list(pv.hex_colors),
        light_to_pyvista=to_pyvista,
        light_from_vtk=from_vtk,
        light_placed=as_light,
    )


# --- light_kit


_NAMES = ("head", "key", "fill", "back left", "back right")


def light_kit() -> tuple[Light, ...]:
    """The five lights of VTK's light kit, PyVista's default: they ride along with the camera.

    Source: vtkLightKit, whose own defaults these are; Halle and Meng, "LightKit: a lighting system for
    effective visualization" (2003).

    Returns
    -------
    tuple of Light
        "head", a headlight, and "key", "fill", "back left" and "back right" in the camera's frame.
    """
    kit, renderer = vtkLightKit(), vtkRenderer()
    kit.AddLightsToRenderer(renderer)
    kit.Update()
    lights = [from_vtk(light, 1.0) for light in renderer.GetLights()]
    return tuple(replace(light, name=name) for light, name in zip(lights, _NAMES, strict=True))


# --- physical


GAMMA = 2.2
"""The shader raises the sum of all light to 1/2.2."""

_FLOOR = 1e-5
"""Under which no cosine falls there."""

_LEAST = math.sqrt(1e-8 / math.pi)
"""Under which D's denominator does not fall."""

_DIELECTRIC = 0.04


class Cosines(NamedTuple):
    """Of n vertices and one light, and by how much float32 turns the directions that they are of."""

    n_l: Float64Array
    n_v: Float64Array
    n_h: Float64Array
    h_l: Float64Array
    light_turn: Any
    """Of the angle between n and l."""
    eye_turn: Any
    """Of that between n and v."""


def allowed_error(roughness: float) -> float:
    """6 · 2⁻²⁴ / roughness⁴ + 2e-6, relative where a colour is more than 1.

    D's denominator 1 − (1 − α²)(n·h)² is α² = roughness⁴ at the peak. Five or six roundings of n·h and of its
    square count there so much more; D has its square, and the picture its power 1/2.2.
    """
    return 6.0 * 2.0**-24 / max(roughness**4, _LEAST) + 2e-6


def reflected(metallic: float, roughness: float, color: Vector, c: Cosines) -> tuple[Float64Array, Float64Array]:
    """What leaves of white light, shape (n, 3), and its relative error in roundings, likewise."""
    x, y, m = np.maximum(c.n_l, _FLOOR), np.maximum(c.n_v, _FLOOR), metallic
    a = np.array(color)
    f0 = (1.0 - m) * _DIELECTRIC + m * a
    grazing = (1.0 - np.clip(c.h_l, _FLOOR, 1.0))[:, None]
    f = f0 + (1.0 - f0) * grazing**5
    denominator = np.maximum(1.0 - (1.0 - roughness**4) * np.maximum(c.n_h, 0.0) ** 2, _LEAST)
    r2 = roughness**2
    masked = x * np.sqrt(r2 + (1.0 - r2) * y * y) + y * np.sqrt(r2 + (1.0 - r2) * x * x)
    shine = ((r2 / denominator) ** 2 * x / (2.0 * masked))[:, None]
    base = (1.0 - m) * (1.0 - f) * a * x[:, None]
    half_turn = (c.light_turn + c.eye_turn) / (2.0 * np.maximum(c.h_l, 1e-9))
    of_x, of_y = _relative(c.n_l, c.light_turn), _relative(c.n_v, c.eye_turn)
    of_f = 5.0 * grazing**4 * (1.0 - f0) * (_sine(c.h_l) * half_turn + 3.0)[:, None]
    of_cosine = 2.0 * np.maximum(c.n_h, 0.0) * (_sine(c.n_h) * half_turn + 2.0) + 1.5
    of_shine = (of_x + of_y + 2.0 * of_cosine / denominator + 12.0)[:, None]
    light = base + shine * f
    error = base * (of_x[:, None] + 8.0) + (1.0 - m) * a * x[:, None] * of_f + shine * (f * of_shine + of_f)
    return light / math.pi, error / np.maximum(light, np.finfo(np.float64).tiny)


def _relative(cosine: Float64Array, turn: Any) -> Float64Array:
    """Of a cosine that is not below its floor."""
    lost = _sine(cosine) * turn + 3.0
    return np.where(cosine > _FLOOR - lost * 2.0**-24, lost / np.maximum(cosine, _FLOOR), 0.0)


def _sine(cosine: Float64Array) -> Any:
    return np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
