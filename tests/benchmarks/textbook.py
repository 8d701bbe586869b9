"""The scene and the vertices that evaluators are measured on, and the textbook's formula to hold them against."""

import numpy as np

from pvphong.optics.lights import PointLight
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.studies.accuracy.peers import textbook_colors as shade

__all__ = ["measured_scene", "shade", "vertices"]


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
