"""The lighting model as a textbook writes it in NumPy: a peer to be compared with."""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray, MatrixLike, rgb
from pvphong.geometry.transform import transform_normals, transform_points
from pvphong.optics.light import VtkValues
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.shading.screen import refuse_rays


def refuse_unknown(scene: Scene, material: Material) -> None:
    """Raise ``ValueError`` for a scene or a material that the textbook formula does not know."""
    if scene.light_model.convention != "standard":
        check.refuse("convention", scene.light_model.convention, "'standard' for the textbook formula")
    for index, light in enumerate(scene.lights):
        light.refuse_unless_in_vtk(f"lights[{index}]", "one that the textbook knows")
    refuse_rays(scene, "for the textbook formula")
    if material.reflectance is not None:
        check.refuse("reflectance", material.reflectance, "None for the textbook formula")


def textbook_colors(
    points: FloatArray, normals: FloatArray, scene: Scene, material: Material, matrix: MatrixLike | None = None
) -> Float64Array:
    """The lighting model as a textbook writes it in NumPy.

    Whole (n, 3) float64 arrays, vectors divided by their norms, the mirror direction, `np.power`, `np.clip`. It is
    right for comfortable numbers and for nothing else: no zero normals, no huge or tiny vectors, no light on a
    vertex.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3).
    scene, material, matrix
        As for `evaluate`; the light model's convention is "standard".

    Returns
    -------
    ndarray
        Shape (n, 3), float64.

    Raises
    ------
    ValueError
        For another convention.
    """
    refuse_unknown(scene, material)
    model = scene.light_model
    p = points.astype(np.float64) if matrix is None else transform_points(points.astype(np.float64), matrix)
    n = _unit(normals.astype(np.float64) if matrix is None else transform_normals(normals, matrix))
    v = _to_viewer(p, scene)
    if model.two_sided:
        n = np.where(_dot(n, v) < 0.0, -n, n)
    color = np.zeros_like(p) + np.multiply(rgb(material.ambient), rgb(model.ambient)) + rgb(material.emission)
    for light in scene.world_lights:
        if light.on:
            color += _share(light, p, n, v, scene, material)
    return np.clip(color, 0.0, 1.0) if model.clamp else color


def _to_viewer(p: Float64Array, scene: Scene) -> Any:
    viewer = scene.viewer
    if scene.light_model.local_viewer and not viewer.parallel:
        return _unit(np.array(viewer.position) - p)
    return -np.array([viewer.view_direction])


def _share(light: Any, p: Float64Array, n: Float64Array, v: Any, scene: Scene, material: Material) -> Any:
    """One light's ambient, diffuse and specular reflection, (n, 3)."""
    to_light, strength = _arrival(light.as_vtk(), p)
    n_l = _dot(n, to_light)
    is_phong = scene.light_model.reflection == "phong"
    cosine = _dot(2.0 * n_l * n - to_light, v) if is_phong else _dot(n, _unit(to_light + v))
    highlight = np.where(n_l > 0.0, np.power(np.maximum(cosine, 0.0), material.shininess), 0.0)
    ambient = np.multiply(rgb(material.ambient), rgb(light.ambient))
    diffuse = np.multiply(rgb(material.diffuse), rgb(light.diffuse)) * np.maximum(n_l, 0.0)
    specular = np.multiply(rgb(material.specular), light.specular_color) * highlight
    return light.intensity * strength * (ambient + diffuse + specular)


def _arrival(light: VtkValues, p: Float64Array) -> tuple[Any, Any]:
    """Unit vectors to the light, and its attenuation times its spot factor."""
    if not light.is_positional:
        return -_unit(np.array([light.direction])), 1.0
    to_light = np.array(light.position) - p
    distance = np.linalg.norm(to_light, axis=1, keepdims=True)
    to_light = to_light / distance
    constant, linear, quadratic = light.attenuation
    strength = 1.0 / (constant + linear * distance + quadratic * distance**2)
    if light.cone_angle is not None:
        cosine = _dot(-to_light, _unit(np.array([light.direction])))
        inside = cosine >= np.cos(np.radians(light.cone_angle))
        strength = np.where(inside, strength * np.maximum(cosine, 0.0) ** light.exponent, 0.0)
    return to_light, strength


def _unit(vectors: Any) -> Any:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _dot(a: Any, b: Any) -> Any:
    return np.sum(a * b, axis=1, keepdims=True)
