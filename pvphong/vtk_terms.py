"""A scene in VTK's terms: what to give VTK so that it draws the very same colours, or why it cannot.

VTK's shader is a lighting equation of its own. Much of the standard model can be said in it with other words: ambient
light and emission become the material's unlit ambient, a viewer at infinity an eye far away, a cone of 90° the widest
that VTK still takes for one. What cannot is refused, with the nearest scene that can.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pvphong._types import Float64Array, Vector, rgb
from pvphong.lights import DirectionalLight, Light, SpotLight
from pvphong.material import Material
from pvphong.scene import Scene
from pvphong.transform import SingularMatrixWarning, normal_matrix
from pvphong.viewer import Viewer
from pvphong.vtk_oracle import HIGHEST_POWER

_LEAST_SCALE, _MOST_SCALE = 1e-18, 1e18
"""Beyond these VTK's float32 normals underflow or overflow."""

_WIDEST_CONE = float(np.nextafter(np.float32(90.0), np.float32(0.0)))
"""VTK takes a spot for a cone only below 90°, in float32."""

_FAR = 1e8
"""In sizes of the mesh: an eye at this distance sees every vertex under the same angle, to float32."""

_BLACK = DirectionalLight(diffuse=0.0)


class InexpressibleError(ValueError):
    """A scene that VTK's shader has no words for.

    Attributes
    ----------
    reasons : tuple of str
        What VTK cannot do.
    scene, material : Scene and Material, or None
        The nearest scene that VTK can draw; None where there is none, as for a singular matrix.
    """

    def __init__(self, obstacles: list[Obstacle], scene: Scene, material: Material) -> None:
        self.reasons = tuple(obstacle.what for obstacle in obstacles)
        self.scene: Scene | None = scene
        self.material: Material | None = material
        message = f"scene must be one that VTK's shader can draw; got {'; '.join(self.reasons)}."
        if all(obstacle.way_round for obstacle in obstacles):
            for obstacle in obstacles:
                scene, material = obstacle.way_round(scene, material)
            self.scene, self.material = scene, material
            changes = ", ".join(obstacle.instead for obstacle in obstacles)
            message += f" The nearest that it can: {changes} (this error's .scene and .material)."
        else:
            self.scene = self.material = None
            message += "".join(f" {obstacle.instead}" for obstacle in obstacles if not obstacle.way_round)
        super().__init__(message)


Change = Callable[[Scene, Material], tuple[Scene, Material]]


@dataclass(frozen=True)
class Obstacle:
    """Something that VTK cannot do.

    Parameters
    ----------
    what : str
        What it is.
    instead : str
        What to do about it.
    way_round : callable or None
        Changes scene and material into the nearest without it.
    """

    what: str
    instead: str
    way_round: Change | None
