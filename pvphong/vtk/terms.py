"""A scene in VTK's terms: what to give VTK so that it draws the very same colours.

Much of the standard model can be said in VTK's shader with other words: ambient light and emission become the
material's unlit ambient, a viewer at infinity becomes an eye far away, a cone of 90° the widest that VTK still
takes for one. `pvphong.vtk.obstacles` says what cannot.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array, Vector, rgb
from pvphong.optics.light import Light, VtkValues
from pvphong.optics.lights import light_from_values
from pvphong.optics.material import Material
from pvphong.optics.roles import Angle
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading.assembly import vtk_tier
from pvphong.vtk.obstacles import has_highlights, is_headlight_tier, seen_from_infinity, shining

_WIDEST_CONE = float(np.nextafter(np.float32(90.0), np.float32(0.0)))
"""VTK takes a positional light for a spot only below 90°, in float32."""

_FAR = 1e8
"""In sizes of the mesh: from here every vertex sees the eye in the same direction, to float32."""

_BLACK = light_from_values(VtkValues(False, (0.0, 0.0, -1.0)), diffuse=0.0)


@dataclass(frozen=True)
class Terms:
    """What VTK is given.

    Parameters
    ----------
    lights : tuple of Light
        All but ambient and specular colours count.
    material : Material
        Its ambient is unlit; it has no emission.
    viewer : Viewer
        Always local.
    tier : int
        Which of the shader's three tiers lights it; 0 where it draws unlit.
    conversions : tuple of str
        What was said in other words, a phrase each.
    """

    lights: tuple[Light, ...]
    material: Material
    viewer: Viewer
    tier: int
    conversions: tuple[str, ...]


def in_vtk_terms(scene: Scene, material: Material, center: Float64Array, size: float) -> Terms:
    """A scene and material that VTK draws in the colours of the given ones.

    Parameters
    ----------
    scene, material
        Nothing in them may be inexpressible; see `pvphong.vtk.obstacles.refuse_inexpressible`.
    center : ndarray
        Shape (3,): the middle of the mesh in the world.
    size : float
        The mesh's largest extent in the world.
    """
    if scene.light_model.convention == "vtk":
        lights, viewer = tuple(scene.lights), scene.viewer
        said: list[str] = []
        unlit = rgb(material.ambient)
    else:
        lights, viewer, said = _standard(scene, material, center, size)
        unlit = _times(material.ambient, scene.light_model.ambient)
        if unlit != rgb(material.ambient):
            said.append("ambient light times the material's ambient as VTK's ambient, which no light multiplies")
    if any(rgb(material.emission)):
        said.append("emission as a part of VTK's ambient")
    red, green, blue = (a + e for a, e in zip(unlit, rgb(material.emission), strict=True))
    given = replace(material, ambient=(red, green, blue), emission=0.0)
    return Terms(lights, given, viewer, vtk_tier(lights), tuple(said))


def _standard(
    scene: Scene, material: Material, center: Float64Array, size: float
) -> tuple[tuple[Light, ...], Viewer, list[str]]:
    said = []
    lights, viewer = shining(scene), scene.viewer
    narrowed = [_with_a_cone(light) for light in lights]
    if narrowed != lights:
        said.append(f"cones of 90° as {_WIDEST_CONE:.6f}°, VTK's widest")
        lights = narrowed
    if is_headlight_tier(scene):
        said.append("a headlight alone, which VTK lights by Blinn-Phong with the viewer at infinity")
        return tuple(lights), viewer, said
    if seen_from_infinity(scene) and has_highlights(scene, material):
        said.append("the viewer at infinity as an eye far away")
        lights = [light.in_world(viewer) for light in lights]
        viewer = _far_away(viewer, center, size)
    if vtk_tier(lights) < 2:
        said.append(
            "a black light added, without which VTK would " + ("draw unlit", "simplify highlights")[vtk_tier(lights)]
        )
        lights = [*lights, _BLACK]
    return tuple(lights), viewer, said


def _with_a_cone(light: Light) -> Light:
    angle = light.as_vtk().cone_angle
    if angle is None or angle <= _WIDEST_CONE:
        return light
    return light.with_values(Angle, _WIDEST_CONE)


def _far_away(viewer: Viewer, center: Float64Array, size: float) -> Viewer:
    position = center - np.array(viewer.view_direction) * _FAR * (size or 1.0)
    return Viewer(position=position.tolist(), focal_point=center.tolist(), up=viewer.up)


def _times(reflectance: Any, light: Any) -> Vector:
    red, green, blue = (k * a for k, a in zip(rgb(reflectance), rgb(light), strict=True))
    return red, green, blue
