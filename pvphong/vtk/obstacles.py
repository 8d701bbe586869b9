"""What VTK's shader has no words for, and the nearest scene that it can draw."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import ColorLike, Float64Array, Vector, rgb
from pvphong.geometry.transform import SingularMatrixWarning, normal_matrix
from pvphong.optics.light import Light
from pvphong.optics.material import Material, nearest_in_vtk
from pvphong.optics.reflectances.vtk import HIGHEST_POWER
from pvphong.optics.roles import Power
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene

LEAST_SCALE, MOST_SCALE = 1e-18, 1e18
"""Beyond these VTK's float32 normals underflow or overflow, and it draws black."""

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
    _refuse_unknown(scene, material)
    obstacles = [*_of_matrix(scene, matrix), *_of_rays(scene)]
    if material.reflectance is not None:
        obstacles += _of_physical(scene, material)
    elif scene.light_model.convention == "standard":
        obstacles += [*_of_colors(scene, material), *_of_highlights(scene, material)]
    obstacles += _of_powers(scene, material)
    if obstacles:
        raise InexpressibleError(obstacles, scene, material)


def _refuse_unknown(scene: Scene, material: Material) -> None:
    for index, light in enumerate(scene.lights):
        if obstacle := light.vtk_obstacle:
            check.refuse(f"lights[{index}]", obstacle.what, "a light that VTK has", obstacle.remedy)
    if not is_vtks(material):
        allowed = "None or PBR where VTK is to draw it"
        check.refuse("reflectance", material.reflectance, allowed, nearest_in_vtk(material))


def is_vtks(material: Material) -> bool:
    """Whether VTK has the material's reflectance."""
    return material.reflectance is None or material.reflectance.in_vtk() is not None


def _of_physical(scene: Scene, material: Material) -> Iterator[Obstacle]:
    """Of VTK's physically based shading, which has its own units and no emission."""
    if scene.light_model.convention == "standard":
        what = "PBR in the standard convention (VTK's is darker by π, and raised to 1/2.2)"
        yield Obstacle(what, "LightModel.vtk()", _as_vtks)
    if any(rgb(material.emission)):
        yield Obstacle("emission of a physically based material", "emission=0", _without_emission)


def _of_rays(scene: Scene) -> Iterator[Obstacle]:
    model = scene.light_model
    if model.needs_rays:

        def without(scene: Scene, material: Material) -> tuple[Scene, Material]:
            return replace(scene, light_model=model.without_rays()), material

        yield Obstacle("shadows or ambient occlusion", "the same without them", without)


def shining(scene: Scene) -> list[Light]:
    """The lights that are on."""
    return [light for light in scene.lights if light.on]


def has_highlights(scene: Scene, material: Material) -> bool:
    """Whether any light that is on makes a highlight."""
    return any(any(reflected(material.specular, light.specular_color, light)) for light in shining(scene))


def reflected(reflectance: ColorLike, color: Vector, light: Light) -> Vector:
    """Reflectance times a light's colour times its intensity, channel by channel."""
    red, green, blue = (k * c * light.intensity for k, c in zip(rgb(reflectance), color, strict=True))
    return red, green, blue


def seen_from_infinity(scene: Scene) -> bool:
    """Whether the standard model takes the direction to the viewer for constant."""
    return scene.viewer.parallel or not scene.light_model.local_viewer


def is_headlight_tier(scene: Scene) -> bool:
    """Whether a standard scene is what VTK's first tier computes.

    Its highlight is (n·l)^power with l = v along the view axis, where h = (l + v)/|l + v| is l again:
    Blinn-Phong with the viewer at infinity, for a headlight alone.
    """
    lights = shining(scene)
    alone = len(lights) == 1 and lights[0].is_even and lights[0].frame == "headlight"
    return alone and scene.light_model.reflection == "blinn-phong" and seen_from_infinity(scene)


def _of_colors(scene: Scene, material: Material) -> Iterator[Obstacle]:
    for index, light in enumerate(scene.lights):
        if not light.on:
            continue
        if any(reflected(material.ambient, rgb(light.ambient), light)):
            what = f"ambient light of its own from lights[{index}] (ambient={light.ambient})"
            if light.is_even:
                yield Obstacle(what, f"LightModel.ambient brighter by that of lights[{index}]", _ambient_moved(index))
            else:
                yield Obstacle(what, f"lights[{index}] with ambient=0", _with_light(index, ambient=0.0))
        both = (reflected(material.specular, color, light) for color in (light.specular_color, rgb(light.diffuse)))
        if len(set(both)) > 1:
            what = f"highlights of lights[{index}] in another colour than its diffuse (specular={light.specular})"
            yield Obstacle(what, f"lights[{index}] with specular=None", _with_light(index, specular=None))


def _of_highlights(scene: Scene, material: Material) -> Iterator[Obstacle]:
    if not has_highlights(scene, material) or is_headlight_tier(scene):
        return
    if scene.light_model.reflection == "blinn-phong":
        power = material.shininess / 4.0
        instead = f"reflection='phong' with shininess={power:g}"
        yield Obstacle("Blinn-Phong highlights (VTK's are Phong's)", instead, _as_phong)
    positional = [light for light in shining(scene) if not light.is_even]
    if seen_from_infinity(scene) and positional:
        what = "highlights for a viewer at infinity beside lights with a position (VTK's viewer is local)"
        yield Obstacle(what, "local_viewer=True and parallel=False", _with_local_viewer)


def _of_powers(scene: Scene, material: Material) -> Iterator[Obstacle]:
    if material.shininess > HIGHEST_POWER and material.reflectance is None:
        what = f"a shininess of {material.shininess:g} (VTK clamps powers to {HIGHEST_POWER:g})"
        yield Obstacle(what, f"shininess at most {HIGHEST_POWER:g}", _with_power_in_reach)
    for index, light in enumerate(scene.lights):
        if light.on and (exponent := light.as_vtk().exponent) > HIGHEST_POWER:
            what = f"an exponent of {exponent:g} in lights[{index}] (VTK clamps them to {HIGHEST_POWER:g})"
            change = _changing(index, lambda light: light.with_values(Power, HIGHEST_POWER))
            yield Obstacle(what, f"lights[{index}] with exponent={HIGHEST_POWER:g}", change)


def _of_matrix(scene: Scene, matrix: Float64Array | None) -> Iterator[Obstacle]:
    if matrix is None:
        return
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
    model = scene.light_model
    if model.convention == "vtk" and model.two_sided and np.linalg.det(linear) < 0.0:
        what = "a mirrored surface (VTK draws it black, having turned its normals away from the eye)"
        yield Obstacle(what, "LightModel.vtk(two_sided=False), as it draws points", _one_sided)


def _with_light(index: int, **fields: Any) -> Change:
    return _changing(index, lambda light: replace(light, **fields))


def _changing(index: int, made: Callable[[Light], Light]) -> Change:
    def change(scene: Scene, material: Material) -> tuple[Scene, Material]:
        lights = list(scene.lights)
        lights[index] = made(lights[index])
        return replace(scene, lights=lights), material

    return change


def _ambient_moved(index: int) -> Change:
    """A directional light's ambient is the same everywhere, as is the light model's: the colours stay what they are."""

    def change(scene: Scene, material: Material) -> tuple[Scene, Material]:
        light = list(scene.lights)[index]
        more = reflected(1.0, rgb(light.ambient), light)
        red, green, blue = (a + b for a, b in zip(rgb(scene.light_model.ambient), more, strict=True))
        brighter = _with_model(ambient=(red, green, blue))
        return _with_light(index, ambient=0.0)(*brighter(scene, material))

    return change


def _with_model(**fields: Any) -> Change:
    def change(scene: Scene, material: Material) -> tuple[Scene, Material]:
        return replace(scene, light_model=replace(scene.light_model, **fields)), material

    return change


def _as_vtks(scene: Scene, material: Material) -> tuple[Scene, Material]:
    return replace(scene, light_model=LightModel.vtk(scene.light_model.two_sided)), material


def _without_emission(scene: Scene, material: Material) -> tuple[Scene, Material]:
    return scene, replace(material, emission=0.0)


_one_sided = _with_model(two_sided=False)


def _as_phong(scene: Scene, material: Material) -> tuple[Scene, Material]:
    """A quarter of the shininess, the inverse of `Material.for_blinn_phong`."""
    return _with_model(reflection="phong")(scene, replace(material, shininess=material.shininess / 4.0))


def _with_local_viewer(scene: Scene, material: Material) -> tuple[Scene, Material]:
    near = replace(scene, viewer=replace(scene.viewer, parallel=False))
    return _with_model(local_viewer=True)(near, material)


def _with_power_in_reach(scene: Scene, material: Material) -> tuple[Scene, Material]:
    return scene, replace(material, shininess=min(material.shininess, HIGHEST_POWER))
