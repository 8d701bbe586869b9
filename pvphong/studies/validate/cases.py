"""Fixed list of scenes that a report compares with VTK. Lights are placed relative to the mesh's centre and size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pyvista as pv
from pyvista import examples

from pvphong.base.types import Float64Array
from pvphong.optics.lights import DirectionalLight, Light, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.optics.reflectances import PBR
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer

MESHES: dict[str, Callable[[], pv.PolyData]] = {
    "airplane": examples.load_airplane,
    "ant": examples.load_ant,
    "nut": examples.load_nut,
}
"""Meshes from PyVista's bundled examples."""

MATERIALS = {
    "matte": Material(ambient=0.2, diffuse=(0.8, 0.5, 0.3)),
    "plastic": Material(ambient=0.1, diffuse=(0.2, 0.3, 0.7), specular=0.5, shininess=30.0),
    "gold": Material.named("gold"),
    "mirror": Material(ambient=0.05, diffuse=0.15, specular=(0.9, 0.8, 0.7), shininess=128.0, emission=0.02),
    "satin metal": Material(diffuse=(1.0, 0.78, 0.34), reflectance=PBR(metallic=1.0, roughness=0.4)),
    "polished metal": Material(diffuse=(0.95, 0.64, 0.54), reflectance=PBR(metallic=1.0, roughness=0.2)),
    "lacquer": Material(diffuse=(0.6, 0.05, 0.05), reflectance=PBR(metallic=0.3, roughness=0.35)),
    "clay": Material(diffuse=(0.7, 0.4, 0.3), reflectance=PBR(roughness=1.0)),
}

_LINEAR = {
    "identity": np.eye(3),
    "rigid": np.array([[1.0, -2.0, 2.0], [2.0, -1.0, -2.0], [2.0, 2.0, 1.0]]) / 3.0,
    "scaled": np.diag([0.4, 1.0, 2.5]),
    "sheared": np.array([[1.0, 0.7, 0.0], [0.0, 1.0, -0.5], [0.0, 0.0, 1.0]]),
    "mirrored": np.diag([1.0, -1.0, 0.8]),
}

_WARM = (1.0, 0.85, 0.6)
_FROM = (0.8, -0.6, 0.9)
"""Position of the lights in the world frame."""
_ASIDE = (0.4, 0.5, 0.0)
"""Position of the lights in the camera frame; the camera is about one mesh length away."""

PICTURED: dict[str, Light] = {
    "sun": DirectionalLight(direction=(-1.0, 0.5, -0.8), intensity=0.9),
    "lamp": PointLight(position=(1.0, -1.2, 1.4), attenuation=(0.4, 0.2, 0.1), diffuse=(1.0, 0.9, 0.7)),
}
"""Lights of the report's pictures."""

_LIGHTS: dict[str, Light] = {
    "sun": DirectionalLight(direction=(-1.0, 0.6, -1.1), diffuse=_WARM),
    "lamp": PointLight(position=_FROM, diffuse=_WARM),
    "fading lamp": PointLight(position=_FROM, attenuation=(0.3, 0.3, 0.4), diffuse=_WARM),
    "spot": SpotLight(position=_FROM, direction=(-0.8, 0.6, -0.9), cone_angle=20.0, exponent=5.0, diffuse=_WARM),
    "sun of the camera": DirectionalLight(direction=(0.5, -0.6, -1.0), frame="camera"),
    "lamp of the camera": PointLight(position=_ASIDE, frame="camera"),
    "spot of the camera": SpotLight(
        position=_ASIDE, direction=(-0.4, -0.5, -1.2), cone_angle=25.0, exponent=2.0, frame="camera"
    ),
    "headlight": DirectionalLight(frame="headlight", intensity=0.9),
    "lamp on the head": PointLight(frame="headlight", attenuation=(0.2, 0.4, 0.2)),
    "black sun": DirectionalLight(direction=(0.0, 0.0, -1.0), diffuse=0.0),
}

_MODELS = {
    "standard model": LightModel(ambient=(0.3, 0.25, 0.2)),
    "two-sided standard model": LightModel(two_sided=True),
    "standard model with the viewer far away": LightModel(local_viewer=False),
    "VTK's model": LightModel.vtk(two_sided=False),
    "two-sided VTK model": LightModel.vtk(),
}


@dataclass(frozen=True)
class Case:
    """One scene on one mesh, described by names.

    Parameters
    ----------
    mesh, material : str
        Keys of `MESHES` and `MATERIALS`.
    lights : tuple of str
        Keys of `_LIGHTS`.
    model : str
        Key of `_MODELS`.
    matrix : str
        Key of `_LINEAR`, a kind of model matrix.
    parallel : bool
        True for parallel projection, False for perspective.
    """

    mesh: str
    material: str
    lights: tuple[str, ...]
    model: str
    matrix: str = "identity"
    parallel: bool = False

    @property
    def title(self) -> str:
        """Description of the scene."""
        parts = [" and ".join(self.lights) or "no light", self.model]
        parts += [] if self.matrix == "identity" else [f"{self.matrix} actor"]
        parts += ["parallel projection"] if self.parallel else []
        return ", ".join(parts)

    def scene(self, mesh: pv.PolyData) -> Scene:
        """Return the scene for a mesh.

        The scene is made for a mesh of length 1 at the origin, then moved and scaled to fit this mesh.
        """
        size, center = mesh.length, np.array(mesh.center)
        eye = center + size * np.array([0.8, -0.8, 0.7])
        viewer = Viewer(position=eye.tolist(), focal_point=mesh.center, up=(0.0, 0.1, 1.0), parallel=self.parallel)
        lights = []
        for name in self.lights:
            light: Any = _LIGHTS[name]
            if not light.is_uniform:
                constant, linear, quadratic = light.attenuation
                around = center if light.frame == "world" else np.zeros(3)
                position = tuple((around + size * np.array(light.position)).tolist())
                light = replace(light, position=position, attenuation=(constant, linear / size, quadratic / size**2))
            lights.append(light)
        return Scene(lights, viewer, _MODELS[self.model])

    def transform(self, mesh: pv.PolyData) -> Float64Array:
        """Return the model matrix for a mesh, shape (4, 4). The mesh's centre stays in its place."""
        linear, middle = _LINEAR[self.matrix], np.array(mesh.center)
        matrix = np.eye(4)
        matrix[:3, :3] = linear
        matrix[:3, 3] = middle - linear @ middle
        return matrix


CASES = (
    Case("airplane", "gold", ("headlight",), "VTK's model"),
    Case("ant", "plastic", ("headlight",), "VTK's model", "sheared", parallel=True),
    Case("nut", "plastic", ("headlight", "black sun"), "VTK's model", "scaled"),
    Case("airplane", "mirror", (), "VTK's model"),
    Case("ant", "matte", ("sun",), "two-sided VTK model"),
    Case("airplane", "plastic", ("sun",), "standard model", "sheared"),
    Case("nut", "mirror", ("sun",), "standard model", "mirrored"),
    Case("ant", "gold", ("sun",), "standard model with the viewer far away", parallel=True),
    Case("airplane", "mirror", ("sun of the camera",), "two-sided standard model", "rigid"),
    Case("nut", "gold", ("sun", "sun of the camera", "headlight"), "VTK's model", "mirrored", parallel=True),
    Case("airplane", "plastic", ("lamp",), "standard model"),
    Case("ant", "mirror", ("lamp",), "two-sided VTK model", "scaled"),
    Case("nut", "gold", ("fading lamp",), "two-sided standard model", "sheared"),
    Case("airplane", "gold", ("fading lamp",), "VTK's model", "mirrored", parallel=True),
    Case("ant", "gold", ("lamp of the camera",), "standard model", "rigid"),
    Case("nut", "plastic", ("lamp on the head",), "standard model", "scaled"),
    Case("airplane", "mirror", ("spot",), "standard model"),
    Case("ant", "plastic", ("spot",), "VTK's model", "sheared"),
    Case("nut", "matte", ("spot of the camera",), "standard model", "mirrored", parallel=True),
    Case("ant", "mirror", ("spot of the camera", "sun"), "VTK's model", parallel=True),
    Case("airplane", "lacquer", ("headlight",), "VTK's model", "sheared"),
    Case("ant", "satin metal", ("sun", "sun of the camera"), "two-sided VTK model", parallel=True),
    Case("nut", "polished metal", ("fading lamp", "spot"), "VTK's model", "mirrored"),
    Case("airplane", "clay", ("sun", "fading lamp", "spot", "headlight"), "two-sided VTK model", "scaled"),
    Case("airplane", "plastic", ("sun", "fading lamp", "spot", "headlight"), "two-sided standard model", "scaled"),
)
"""Cases that cover all kinds of lights, of VTK's shader, of frames, matrices, projections, materials and models."""
