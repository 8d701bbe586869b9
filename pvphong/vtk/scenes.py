"""Conversion of scenes to VTK's terms, and refusal of scenes that VTK's shader cannot draw.

`refuse_inexpressible` reports the features of a scene that VTK cannot draw, and the nearest scene that it can draw. VTK
can draw most of the standard convention. For this, `in_vtk_terms` converts ambient light and emission to the material's
unlit ambient, a viewer at infinity to a distant eye, and a cone of 90° to the widest cone that VTK supports.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from pvphong.base import check
from pvphong.base.types import ColorLike, Float64Array, Vector, rgb
from pvphong.geometry.transform import SingularMatrixWarning, normal_matrix
from pvphong.optics.light import Light
from pvphong.optics.lights import VtkValues, light_from_values, refuse_unless_in_vtk, vtk_values
from pvphong.optics.material import Material, nearest_in_vtk
from pvphong.optics.reflectances.likeness import LIKENESS, in_vtk
from pvphong.optics.reflectances.vtk import HIGHEST_POWER
from pvphong.optics.roles import Angle, Power
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading.equation import vtk_tier

LEAST_SCALE, MOST_SCALE = 1e-18, 1e18
"""Range of scales of a matrix. Outside it, VTK's float32 normals underflow or overflow, and VTK draws black."""

_WIDEST_CONE = float(np.nextafter(np.float32(90.0), np.float32(0.0)))
"""Widest cone of a spot light in VTK, which compares it with 90° in float32."""

_FAR = 1e8
"""Distance, in sizes of the mesh, of an eye that stands for infinity: the direction to it is constant in float32."""

_BLACK = light_from_values(VtkValues(False, (0.0, 0.0, -1.0)), diffuse=0.0)


# --- properties of scenes ---


def shining(scene: Scene) -> list[Light]:
    """Return the scene's lights that are switched on."""
    return [light for light in scene.lights if light.on]


def reflected(reflectance: ColorLike, color: Vector, light: Light) -> Vector:
    """Multiply a reflectance, one of the light's colours and the light's intensity, channel by channel."""
    red, green, blue = (k * c * light.intensity for k, c in zip(rgb(reflectance), color, strict=True))
    return red, green, blue


def seen_from_infinity(scene: Scene) -> bool:
    """Return True if all vertices of a scene have the same direction to the viewer.

    `scene` must have the standard convention.
    """
    return scene.viewer.parallel or not scene.light_model.local_viewer


def _has_highlights(scene: Scene, material: Material) -> bool:
    return any(any(reflected(material.specular, light.specular_color, light)) for light in shining(scene))


def _is_headlight_tier(scene: Scene) -> bool:
    """Return True if VTK's shader draws a scene of the standard convention with its code for a single headlight.

    In this code, the first tier of the shader, l = v, along the view axis, and the highlight is (n·l)^power. Because
    h = (l + v)/|l + v| is then equal to l, this is Blinn-Phong shading for a single headlight, with the viewer at
    infinity.
    """
    lights = shining(scene)
    alone = len(lights) == 1 and lights[0].is_uniform and lights[0].frame == "headlight"
    return alone and scene.light_model.reflection == "blinn-phong" and seen_from_infinity(scene)


# --- what VTK cannot draw ---


class InexpressibleError(ValueError):
    """Raised for a scene that VTK's shader cannot draw.

    Attributes
    ----------
    reasons : tuple of str
        Features that VTK does not support.
    scene, material : Scene and Material, or None
        The nearest scene and material that VTK can draw; None if there are none, for example with a singular matrix.
    message : str
        Text of the error, without the words that point to the attributes `scene` and `material`.
    """

    def __init__(self, reasons: Iterable[str], remedies: Iterable[str], nearest: tuple[Scene, Material] | None) -> None:
        self.reasons = tuple(reasons)
        self.scene: Scene | None = nearest[0] if nearest else None
        self.material: Material | None = nearest[1] if nearest else None
        remedy = ", ".join(remedies)
        if nearest:
            remedy = f"The nearest scene that it can draw: {remedy}"
        self.message = f"scene must be a scene that VTK can draw; got {'; '.join(self.reasons)}. {remedy}."
        attributes = " (`.scene` and `.material` of this error)." if nearest else "."
        super().__init__(self.message.removesuffix(".") + attributes)


def refuse_inexpressible(scene: Scene, material: Material, matrix: Float64Array | None) -> None:
    """Raise `InexpressibleError` for a scene that VTK cannot draw.

    An unsupported light or reflectance raises ValueError. A feature of colours or highlights is allowed if it has no
    effect, such as a light's specular colour if the material has no specular. Other features, such as a shininess above
    VTK's highest power, are refused even without an effect.
    """
    for index, light in enumerate(scene.lights):
        refuse_unless_in_vtk(light, f"lights[{index}]", "a light that VTK supports")
    is_physical = material.reflectance is not None
    if material.reflectance is not None and in_vtk(material.reflectance) is None:
        allowed = "None or PBR in VTK"
        check.refuse("reflectance", material.reflectance, allowed, nearest_in_vtk(material))
    given = scene.light_model
    obstacles: dict[str, str] = {}  # unsupported feature → replacement or remedy
    lights, viewer, model, nearest = list(scene.lights), scene.viewer, given, material  # of the nearest scene

    if matrix is not None:
        obstacles |= _obstacles_of_matrix(matrix)
    is_drawn = not obstacles
    if matrix is not None and given.convention == "vtk" and given.two_sided and np.linalg.det(matrix) < 0.0:
        what = "a mirrored surface (VTK turns its normals away from the eye and draws it black)"
        obstacles[what] = "LightModel.vtk(two_sided=False), as VTK draws points"
        model = replace(model, two_sided=False)
    if given.is_global:
        obstacles["shadows, ambient occlusion or bounces"] = "none of these"
        model = model.without_rays()
    if is_physical and given.convention == "standard":  # VTK's physically based shading has its own units
        what = "PBR in the standard convention (VTK divides by π and raises the colour to the power 1/2.2)"
        obstacles[what], model = "LightModel.vtk()", LightModel.vtk(model.two_sided)
    if is_physical and any(rgb(material.emission)):
        obstacles["emission of a physically based material"] = "emission=0"
        nearest = replace(nearest, emission=0.0)
    if not is_physical and given.convention == "standard":
        for index, light in enumerate(scene.lights):
            if not light.on:
                continue
            if any(reflected(material.ambient, rgb(light.ambient), light)):
                what = f"ambient light from lights[{index}] (ambient={light.ambient})"
                lights[index] = replace(lights[index], ambient=0.0)
                obstacles[what] = f"lights[{index}] with ambient=0"
                if light.is_uniform:  # its ambient light is constant, so the light model's ambient can include it
                    obstacles[what] = f"LightModel.ambient increased by the ambient of lights[{index}]"
                    red, green, blue = np.add(rgb(model.ambient), reflected(1.0, rgb(light.ambient), light)).tolist()
                    model = replace(model, ambient=(red, green, blue))
            both = (reflected(material.specular, color, light) for color in (light.specular_color, rgb(light.diffuse)))
            if len(set(both)) > 1:
                what = f"highlights of lights[{index}] that differ from its diffuse colour (specular={light.specular})"
                obstacles[what] = f"lights[{index}] with specular=None"
                lights[index] = replace(lights[index], specular=None)
        if _has_highlights(scene, material) and not _is_headlight_tier(scene):
            if given.reflection == "blinn-phong":
                phong = material.shininess / LIKENESS
                obstacles["Blinn-Phong highlights (VTK's are Phong's)"] = f"reflection='phong' with shininess={phong:g}"
                model, nearest = replace(model, reflection="phong"), replace(nearest, shininess=phong)
            if seen_from_infinity(scene) and not all(light.is_uniform for light in shining(scene)):
                what = "highlights for a viewer at infinity with positional lights (VTK's viewer is local)"
                obstacles[what] = "local_viewer=True and parallel=False"
                model, viewer = replace(model, local_viewer=True), replace(viewer, parallel=False)
    if material.shininess > HIGHEST_POWER and not is_physical:
        what = f"a shininess of {material.shininess:g} (VTK clamps powers to {HIGHEST_POWER:g})"
        obstacles[what] = f"shininess at most {HIGHEST_POWER:g}"
        nearest = replace(nearest, shininess=min(nearest.shininess, HIGHEST_POWER))
    for index, light in enumerate(scene.lights):
        exponent = vtk_values(light).exponent
        if light.on and exponent > HIGHEST_POWER:
            what = f"an exponent of {exponent:g} in lights[{index}] (VTK clamps exponents to {HIGHEST_POWER:g})"
            obstacles[what] = f"lights[{index}] with exponent={HIGHEST_POWER:g}"
            lights[index] = lights[index].with_values(Power, HIGHEST_POWER)
    if obstacles:
        drawn = replace(scene, lights=lights, viewer=viewer, light_model=model), nearest
        raise InexpressibleError(obstacles.keys(), obstacles.values(), drawn if is_drawn else None)


def _obstacles_of_matrix(matrix: Float64Array) -> dict[str, str]:
    """Return the reasons why VTK cannot draw with a model matrix, as reason → remedy; empty if VTK can.

    The remedies are instructions to the user, because no similar matrix can replace the model matrix.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", SingularMatrixWarning)
        normal_matrix(matrix)  # raises for matrices that no evaluator accepts
    if caught:
        what = "a matrix that flattens space (VTK does not invert it for normals)"
        return {what: "Use a small scale in place of 0"}
    scales = np.linalg.svd(matrix[:3, :3] / matrix[3, 3], compute_uv=False)
    if scales.min() < LEAST_SCALE or scales.max() > MOST_SCALE:
        what = f"a matrix that scales by {scales.min():.3g} to {scales.max():.3g} (VTK then draws black)"
        return {
            what: f"Scale mesh, lights and viewer alike, so that the matrix scales by {LEAST_SCALE:g} to {MOST_SCALE:g}"
        }
    return {}


# --- conversion to VTK's terms ---


@dataclass(frozen=True)
class Terms:
    """A scene as VTK draws it.

    Parameters
    ----------
    lights : tuple of Light
        The lights; their ambient and specular colours are ignored.
    material : Material
        The material, without emission; its ambient is added unlit.
    viewer : Viewer
        The viewer, which is local.
    tier : int
        Number, 1 to 3, of the tier of the shader's code that computes the scene; 0 if the mesh is drawn unlit.
    conversions : tuple of str
        Descriptions of the conversions that were made.
    """

    lights: tuple[Light, ...]
    material: Material
    viewer: Viewer
    tier: int
    conversions: tuple[str, ...]


def in_vtk_terms(scene: Scene, material: Material, center: Float64Array, size: float) -> Terms:
    """Convert a scene and material so that VTK draws them in the same colours.

    Parameters
    ----------
    scene : Scene
        Scene that VTK can draw with the material; see `refuse_inexpressible`.
    material : Material
        Material that VTK can draw.
    center : ndarray
        Centre of the mesh in the world, shape (3,).
    size : float
        Largest extent of the mesh in the world.
    """
    lights, viewer, conversions = list(scene.lights), scene.viewer, []
    ambient, emission = np.array(rgb(material.ambient)), np.array(rgb(material.emission))
    if scene.light_model.convention == "standard":
        angles = (vtk_values(light).cone_angle or 0.0 for light in shining(scene))
        lights = [
            light.with_values(Angle, _WIDEST_CONE) if angle > _WIDEST_CONE else light
            for light, angle in zip(shining(scene), angles, strict=True)
        ]
        if lights != shining(scene):
            conversions.append(f"cones of 90° as {_WIDEST_CONE:.6f}°, VTK's widest")
        if _is_headlight_tier(scene):
            conversions.append("a single headlight, for which VTK uses Blinn-Phong with the viewer at infinity")
        else:
            if seen_from_infinity(scene) and _has_highlights(scene, material):
                conversions.append("the viewer at infinity as a distant eye")
                lights = [light.in_world(viewer) for light in lights]
                far = center - np.array(viewer.view_direction) * _FAR * (size or 1.0)
                viewer = Viewer(position=far.tolist(), focal_point=center.tolist(), up=viewer.up)
            if (tier := vtk_tier(lights)) < 2:
                otherwise = ("draw unlit", "simplify highlights")[tier]
                conversions.append(f"an added black light, without which VTK would {otherwise}")
                lights.append(_BLACK)
        unlit = ambient * rgb(scene.light_model.ambient)
        if (unlit != ambient).any():
            conversions.append("ambient light times the material's ambient as VTK's unlit ambient")
        ambient = unlit
    if emission.any():
        conversions.append("emission as part of VTK's ambient")
    red, green, blue = (ambient + emission).tolist()
    given = replace(material, ambient=(red, green, blue), emission=0.0)
    return Terms(tuple(lights), given, viewer, vtk_tier(lights), tuple(conversions))
