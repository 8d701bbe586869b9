"""A scene as VTK draws it: what VTK's shader cannot draw, and how to give it the rest.

`obstacles` lists what VTK has no words for, each with the nearest that it has. Much of the standard model can be said
in other words: `in_vtk_terms` makes ambient light and emission the material's unlit ambient, a viewer at infinity an
eye far away, a cone of 90° the widest that VTK still takes for one.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from pvphong.base import check
from pvphong.base.types import ColorLike, Float64Array, Vector, rgb
from pvphong.geometry.transform import SingularMatrixWarning, normal_matrix
from pvphong.optics.light import Light, VtkValues
from pvphong.optics.lights import light_from_values, refuse_unless_in_vtk
from pvphong.optics.material import Material, nearest_in_vtk
from pvphong.optics.reflectances.vtk import HIGHEST_POWER
from pvphong.optics.roles import Angle, Power
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading.equation import vtk_tier

LEAST_SCALE, MOST_SCALE = 1e-18, 1e18
"""Beyond these VTK's float32 normals underflow or overflow, and it draws black."""

_WIDEST_CONE = float(np.nextafter(np.float32(90.0), np.float32(0.0)))
"""VTK takes a positional light for a spot only below 90°, in float32."""

_FAR = 1e8
"""In sizes of the mesh: from here every vertex sees the eye in the same direction, to float32."""

_BLACK = light_from_values(VtkValues(False, (0.0, 0.0, -1.0)), diffuse=0.0)


# --- what the questions are asked of ---


def shining(scene: Scene) -> list[Light]:
    """The lights that are on."""
    return [light for light in scene.lights if light.on]


def reflected(reflectance: ColorLike, color: Vector, light: Light) -> Vector:
    """Reflectance times a light's colour times its intensity, channel by channel."""
    red, green, blue = (k * c * light.intensity for k, c in zip(rgb(reflectance), color, strict=True))
    return red, green, blue


def seen_from_infinity(scene: Scene) -> bool:
    """Whether the standard model takes the direction to the viewer for constant."""
    return scene.viewer.parallel or not scene.light_model.local_viewer


def _has_highlights(scene: Scene, material: Material) -> bool:
    return any(any(reflected(material.specular, light.specular_color, light)) for light in shining(scene))


def _is_headlight_tier(scene: Scene) -> bool:
    """Whether a standard scene is what VTK's first tier computes.

    Its highlight is (n·l)^power with l = v along the view axis, where h = (l + v)/|l + v| is l again:
    Blinn-Phong with the viewer at infinity, for a headlight alone.
    """
    lights = shining(scene)
    alone = len(lights) == 1 and lights[0].is_even and lights[0].frame == "headlight"
    return alone and scene.light_model.reflection == "blinn-phong" and seen_from_infinity(scene)


# --- what VTK cannot draw ---

Change = Callable[[Scene, Material], tuple[Scene, Material]]


@dataclass(frozen=True)
class Obstacle:
    """Something that VTK cannot draw.

    Parameters
    ----------
    what : str
        What it is.
    instead : str
        What can be drawn in its place, or what to do about it.
    change : callable, optional
        Makes scene and material over into the nearest without it; None where there is none.
    """

    what: str
    instead: str
    change: Change | None = None


class InexpressibleError(ValueError):
    """A scene that VTK's shader cannot draw.

    Attributes
    ----------
    reasons : tuple of str
        What VTK cannot do.
    scene, material : Scene and Material, or None
        The nearest that it can draw; None where there is none, as for a singular matrix.
    """

    def __init__(self, obstacles: list[Obstacle], scene: Scene, material: Material) -> None:
        self.reasons = tuple(obstacle.what for obstacle in obstacles)
        self.scene: Scene | None = scene
        self.material: Material | None = material
        for obstacle in obstacles:
            if obstacle.change is None:
                self.scene = self.material = None
            elif self.scene is not None and self.material is not None:
                self.scene, self.material = obstacle.change(self.scene, self.material)
        remedy = ", ".join(obstacle.instead for obstacle in obstacles)
        if self.scene is not None:
            remedy = f"The nearest that it can: {remedy} (`.scene` and `.material` of this error)"
        super().__init__(f"scene must be one that VTK can draw; got {'; '.join(self.reasons)}. {remedy}.")


def refuse_inexpressible(scene: Scene, material: Material, matrix: Float64Array | None) -> None:
    """Raise `InexpressibleError` if VTK's shader cannot draw the scene, ValueError for a light or reflectance it lacks.

    What has no effect is no obstacle: the specular colour of a light on a material without specular, say.
    """
    for index, light in enumerate(scene.lights):
        refuse_unless_in_vtk(light, f"lights[{index}]", "a light that VTK has")
    if material.reflectance is not None and material.reflectance.in_vtk() is None:
        allowed = "None or PBR where VTK is to draw it"
        check.refuse("reflectance", material.reflectance, allowed, nearest_in_vtk(material))
    found = list(obstacles(scene, material, matrix))
    if found:
        raise InexpressibleError(found, scene, material)


def obstacles(scene: Scene, material: Material, matrix: Float64Array | None) -> Iterator[Obstacle]:
    """What VTK cannot draw of a scene whose lights and reflectance it has, where it has an effect."""
    model = scene.light_model
    if matrix is not None:
        yield from _obstacles_of_matrix(matrix, turns_normals=model.convention == "vtk" and model.two_sided)
    if model.needs_rays:
        yield Obstacle("shadows or ambient occlusion", "the same without them", _with_model(LightModel.without_rays))
    if material.reflectance is not None:  # VTK's physically based shading, which has its own units
        if model.convention == "standard":
            what = "PBR in the standard convention (VTK's is darker by π, and raised to 1/2.2)"
            vtks = _with_model(lambda model: LightModel.vtk(model.two_sided))
            yield Obstacle(what, "LightModel.vtk()", vtks)
        if any(rgb(material.emission)):
            what = "emission of a physically based material"
            yield Obstacle(what, "emission=0", lambda scene, material: (scene, replace(material, emission=0.0)))
    elif model.convention == "standard":
        yield from _obstacles_of_standard(scene, material)
    if material.shininess > HIGHEST_POWER and material.reflectance is None:
        what = f"a shininess of {material.shininess:g} (VTK clamps powers to {HIGHEST_POWER:g})"
        yield Obstacle(what, f"shininess at most {HIGHEST_POWER:g}", _with_power_in_reach)
    for index, light in enumerate(scene.lights):
        if light.on and (exponent := light.as_vtk().exponent) > HIGHEST_POWER:
            what = f"an exponent of {exponent:g} in lights[{index}] (VTK clamps them to {HIGHEST_POWER:g})"
            clamped = _with_light(index, lambda light: light.with_values(Power, HIGHEST_POWER))
            yield Obstacle(what, f"lights[{index}] with exponent={HIGHEST_POWER:g}", clamped)


def _obstacles_of_matrix(matrix: Float64Array, *, turns_normals: bool) -> Iterator[Obstacle]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", SingularMatrixWarning)
        normal_matrix(matrix)  # refuses what no evaluator takes
    linear = matrix[:3, :3] / matrix[3, 3]
    scales = np.linalg.svd(linear, compute_uv=False)
    if caught:
        remedy = "Use a small scale in place of 0"
        yield Obstacle("a matrix that flattens space (VTK leaves it uninverted for normals)", remedy)
    elif scales.min() < LEAST_SCALE or scales.max() > MOST_SCALE:
        what = f"a matrix that scales by {scales.min():.3g} to {scales.max():.3g} (VTK then draws black)"
        yield Obstacle(what, f"Scale mesh, lights and viewer alike, to between {LEAST_SCALE:g} and {MOST_SCALE:g}")
    if turns_normals and np.linalg.det(linear) < 0.0:
        what = "a mirrored surface (VTK draws it black, having turned its normals away from the eye)"
        one_sided = _with_model(lambda model: replace(model, two_sided=False))
        yield Obstacle(what, "LightModel.vtk(two_sided=False), as it draws points", one_sided)


def _obstacles_of_standard(scene: Scene, material: Material) -> Iterator[Obstacle]:
    """What the standard convention's lights and highlights have that VTK's shader has not."""
    for index, light in enumerate(scene.lights):
        if not light.on:
            continue
        if any(reflected(material.ambient, rgb(light.ambient), light)):
            what = f"ambient light of its own from lights[{index}] (ambient={light.ambient})"
            if light.is_even:
                instead = f"LightModel.ambient brighter by that of lights[{index}]"
                yield Obstacle(what, instead, _with_ambient_in_model(index))
            else:
                dark = _with_light(index, lambda light: replace(light, ambient=0.0))
                yield Obstacle(what, f"lights[{index}] with ambient=0", dark)
        both = (reflected(material.specular, color, light) for color in (light.specular_color, rgb(light.diffuse)))
        if len(set(both)) > 1:
            what = f"highlights of lights[{index}] in another colour than its diffuse (specular={light.specular})"
            plain = _with_light(index, lambda light: replace(light, specular=None))
            yield Obstacle(what, f"lights[{index}] with specular=None", plain)
    if not _has_highlights(scene, material) or _is_headlight_tier(scene):
        return
    if scene.light_model.reflection == "blinn-phong":
        instead = f"reflection='phong' with shininess={material.shininess / 4.0:g}"
        yield Obstacle("Blinn-Phong highlights (VTK's are Phong's)", instead, _as_phong)
    if seen_from_infinity(scene) and not all(light.is_even for light in shining(scene)):
        what = "highlights for a viewer at infinity beside lights with a position (VTK's viewer is local)"
        yield Obstacle(what, "local_viewer=True and parallel=False", _with_local_viewer)


def _with_light(index: int, made: Callable[[Light], Light]) -> Change:
    def change(scene: Scene, material: Material) -> tuple[Scene, Material]:
        lights = list(scene.lights)
        lights[index] = made(lights[index])
        return replace(scene, lights=lights), material

    return change


def _with_model(made: Callable[[LightModel], LightModel]) -> Change:
    return lambda scene, material: (replace(scene, light_model=made(scene.light_model)), material)


def _with_ambient_in_model(index: int) -> Change:
    """A directional light's ambient is the same everywhere, as is the light model's: the colours stay what they are."""

    def change(scene: Scene, material: Material) -> tuple[Scene, Material]:
        light, model = list(scene.lights)[index], scene.light_model
        red, green, blue = np.add(rgb(model.ambient), reflected(1.0, rgb(light.ambient), light)).tolist()
        brighter = replace(scene, light_model=replace(model, ambient=(red, green, blue)))
        return _with_light(index, lambda light: replace(light, ambient=0.0))(brighter, material)

    return change


def _as_phong(scene: Scene, material: Material) -> tuple[Scene, Material]:
    """A quarter of the shininess, the inverse of `Material.for_blinn_phong`."""
    phong = replace(scene.light_model, reflection="phong")
    return replace(scene, light_model=phong), replace(material, shininess=material.shininess / 4.0)


def _with_local_viewer(scene: Scene, material: Material) -> tuple[Scene, Material]:
    model, viewer = replace(scene.light_model, local_viewer=True), replace(scene.viewer, parallel=False)
    return replace(scene, light_model=model, viewer=viewer), material


def _with_power_in_reach(scene: Scene, material: Material) -> tuple[Scene, Material]:
    return scene, replace(material, shininess=min(material.shininess, HIGHEST_POWER))


# --- the rest, in VTK's terms ---


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
        Nothing in them may be inexpressible; see `refuse_inexpressible`.
    center : ndarray
        Shape (3,): the middle of the mesh in the world.
    size : float
        The mesh's largest extent in the world.
    """
    lights, viewer, conversions = list(scene.lights), scene.viewer, []
    ambient, emission = np.array(rgb(material.ambient)), np.array(rgb(material.emission))
    if scene.light_model.convention == "standard":
        lights = [_within_widest_cone(light) for light in shining(scene)]
        if lights != shining(scene):
            conversions.append(f"cones of 90° as {_WIDEST_CONE:.6f}°, VTK's widest")
        if _is_headlight_tier(scene):
            conversions.append("a headlight alone, which VTK lights by Blinn-Phong with the viewer at infinity")
        else:
            if seen_from_infinity(scene) and _has_highlights(scene, material):
                conversions.append("the viewer at infinity as an eye far away")
                lights = [light.in_world(viewer) for light in lights]
                far = center - np.array(viewer.view_direction) * _FAR * (size or 1.0)
                viewer = Viewer(position=far.tolist(), focal_point=center.tolist(), up=viewer.up)
            if (tier := vtk_tier(lights)) < 2:
                otherwise = ("draw unlit", "simplify highlights")[tier]
                conversions.append(f"a black light added, without which VTK would {otherwise}")
                lights.append(_BLACK)
        unlit = ambient * rgb(scene.light_model.ambient)
        if (unlit != ambient).any():
            conversions.append("ambient light times the material's ambient as VTK's ambient, which no light multiplies")
        ambient = unlit
    if emission.any():
        conversions.append("emission as a part of VTK's ambient")
    red, green, blue = (ambient + emission).tolist()
    given = replace(material, ambient=(red, green, blue), emission=0.0)
    return Terms(tuple(lights), given, viewer, vtk_tier(lights), tuple(conversions))


def _within_widest_cone(light: Light) -> Light:
    angle = light.as_vtk().cone_angle
    return light if angle is None or angle <= _WIDEST_CONE else light.with_values(Angle, _WIDEST_CONE)
