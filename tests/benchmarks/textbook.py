"""The lighting model as a textbook writes it in NumPy: what the evaluator is measured against.

Whole (n, 3) float64 arrays, vectors normalised by their norms, the mirror direction, `np.power`, `np.clip`. It is
right for comfortable numbers and for nothing else: no zero normals, no huge or tiny vectors, no light on a vertex.
"""

import numpy as np

from pvphong.lights import PointLight
from pvphong.material import Material
from pvphong.scene import Scene
from pvphong.viewer import Viewer


def measured_scene():
    """Three point lights with highlights and attenuation around the unit sphere."""
    lights = [
        PointLight(position=(2.0, 1.0, 2.5), attenuation=(0.5, 0.1, 0.05), diffuse=(1.0, 0.9, 0.8)),
        PointLight(position=(-2.0, 1.5, 1.0), attenuation=(1.0, 0.0, 0.1), diffuse=(0.3, 0.4, 0.9), intensity=1.5),
        PointLight(position=(0.5, -2.0, 2.0), attenuation=(0.2, 0.3, 0.1), specular=(1.0, 0.5, 0.2)),
    ]
    material = Material(ambient=0.1, diffuse=(0.6, 0.5, 0.4), specular=0.5, shininess=30, emission=0.01)
    return Scene(lights=lights, viewer=Viewer(position=(1.0, 0.5, 4.0))), material


def vertices(count, dtype=np.float64):
    """Points on the unit sphere, and normals that are a little off."""
    rng = np.random.default_rng(0)
    points = normalised(rng.normal(size=(count, 3)))
    normals = points + 0.1 * rng.normal(size=(count, 3))
    return points.astype(dtype), normals.astype(dtype)


def normalised(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def shade(points, normals, scene, material):
    """Colours (n, 3) of a scene of point lights with attenuation, a local viewer and Phong reflection."""
    points, normals = points.astype(np.float64), normalised(normals.astype(np.float64))
    to_viewer = normalised(np.array(scene.viewer.position) - points)
    color = np.zeros_like(points) + np.multiply(material.ambient, scene.light_model.ambient) + material.emission
    for light in scene.lights:
        to_light = np.array(light.position) - points
        distance = np.linalg.norm(to_light, axis=1, keepdims=True)
        to_light = to_light / distance
        constant, linear, quadratic = light.attenuation
        strength = light.intensity / (constant + linear * distance + quadratic * distance**2)
        n_dot_l = np.sum(normals * to_light, axis=1, keepdims=True)
        mirror = 2.0 * n_dot_l * normals - to_light
        r_dot_v = np.sum(mirror * to_viewer, axis=1, keepdims=True)
        highlight = np.where(n_dot_l > 0.0, np.power(np.maximum(r_dot_v, 0.0), material.shininess), 0.0)
        diffuse = np.multiply(material.diffuse, light.diffuse) * np.maximum(n_dot_l, 0.0)
        color = color + strength * (diffuse + np.multiply(material.specular, light.specular_color) * highlight)
    return np.clip(color, 0.0, 1.0)
