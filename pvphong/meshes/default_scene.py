"""A viewer and three lights that suit any mesh: what the command line uses where no scene is given."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pyvista as pv

from pvphong.base.types import Float64Array
from pvphong.meshes.pictures import leaves
from pvphong.optics.lights import DirectionalLight
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer

_VIEW_ANGLE = 30.0
_MARGIN = 1.05
_BACK = np.array([1.0, 1.0, 1.0]) / math.sqrt(3.0)  # towards the eye
_RIGHT = np.array([-1.0, 1.0, 0.0]) / math.sqrt(2.0)
_UP = np.cross(_BACK, _RIGHT)


def default_scene(mesh: pv.PolyData | pv.MultiBlock, aspect: float = 4 / 3) -> Scene:
    """Key, fill and rim light, and PyVista's first view of the mesh.

    The viewer looks at the centre from where PyVista puts its camera, from the direction (1, 1, 1) with z up,
    as near as the bounding box allows. The lights ride along with it: a warm
    key from the upper left, a weak cool fill from the right, a rim light from behind. A mesh with open edges
    shows its backs and is lit two-sided.

    Parameters
    ----------
    mesh : pyvista.PolyData or pyvista.MultiBlock
        A checked surface, or several.
    aspect : float, default 4/3
        Width over height of the picture into which the bounding box fits.

    Returns
    -------
    Scene
        To be used as it is, or saved and edited.
    """
    return Scene(
        lights=[
            DirectionalLight(direction=(1.0, -1.0, -1.4), diffuse=(0.95, 0.93, 0.9), frame="camera", name="key"),
            DirectionalLight(direction=(-1.0, 0.1, -0.8), diffuse=(0.18, 0.2, 0.24), frame="camera", name="fill"),
            DirectionalLight(direction=(-0.4, -1.0, 0.9), diffuse=(0.35, 0.35, 0.35), frame="camera", name="rim"),
        ],
        viewer=_viewer(np.array(mesh.bounds), aspect),
        light_model=LightModel(two_sided=any(surface.n_open_edges for surface in leaves(mesh))),
    )


def _viewer(bounds: Float64Array, aspect: float) -> Viewer:
    low, high = bounds[::2], bounds[1::2]
    if not np.isfinite(bounds).all() or (low > high).any():
        low, high = np.zeros(3), np.ones(3)
    center, half = 0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low
    smallest = 1e-9 * float(np.abs(center).max())  # a single point far out: the eye must not fall on it
    radius = max(float(np.linalg.norm(half)), smallest) or 1.0
    distance = max(_fitting_distance(half, aspect), 0.1 * radius)
    return Viewer(
        position=center + distance * _BACK,
        focal_point=center,
        up=(0.0, 0.0, 1.0),
        view_angle=_VIEW_ANGLE,
        parallel_scale=radius,
        clipping_range=(max(distance - radius, 0.01 * distance), distance + radius),
    )


def _fitting_distance(half: Float64Array, aspect: float) -> float:
    """From how far away a box with these half edges fits into the picture, with a margin."""
    corners = half * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    right, up, back = (corners @ axis for axis in (_RIGHT, _UP, _BACK))
    slope = math.tan(math.radians(0.5 * _VIEW_ANGLE)) / _MARGIN
    return float(np.max(back + np.maximum(np.abs(right) / aspect, np.abs(up)) / slope))
