"""The default scene of a mesh: three lights and a viewer that suit the mesh.

If lights, or a scene without a viewer, are given, only a viewer is added to them.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base.types import MatrixLike, VectorLike
from pvphong.geometry.extent import corners_of
from pvphong.geometry.transform import transform_points
from pvphong.meshes.blocks import leaves, map_blocks
from pvphong.meshes.surfaces import shallow_copy, surface
from pvphong.scene.light_model import LightModel
from pvphong.scene.presets import key_fill_rim
from pvphong.scene.scene import Scene, SceneLike, as_scene
from pvphong.scene.viewer import Viewer, finite_box
from pvphong.shading.vertices import Vertices

_MARGIN = 1.05
_BACK = np.array([1.0, 1.0, 1.0]) / math.sqrt(3.0)  # towards the eye
_RIGHT = np.array([-1.0, 1.0, 0.0]) / math.sqrt(2.0)
_UP = np.cross(_BACK, _RIGHT)


def default_scene(
    mesh: pv.DataSet | pv.MultiBlock, aspect: float = 4 / 3, *, matrix: MatrixLike | None = None
) -> Scene:
    """Return a scene with key, fill and rim light, and PyVista's default view of the mesh.

    The viewer looks at the centre of the mesh from PyVista's default direction (1, 1, 1), with z up. Its distance is
    the smallest at which the bounding box fits into the image. The lights move with the viewer. The key light is warm
    and comes from the upper left. The fill light is weaker and cool, comes from the right, and reaches all surfaces
    that face the viewer. The rim light comes from behind. A mesh with open edges shows its back faces, so its scene is
    lit two-sided.

    Parameters
    ----------
    mesh : pyvista.DataSet or pyvista.MultiBlock
        A dataset with a surface, or several.
    aspect : float, default 4/3
        Width divided by height of the image into which the bounding box must fit.
    matrix : array_like, optional
        (4, 4) model matrix; the scene is for the transformed mesh.

    Returns
    -------
    Scene
        The scene, which can be used directly, or saved and edited.

    Raises
    ------
    ValueError
        If the mesh has no surface, or `matrix` is not a model matrix.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> [light.name for light in ph.default_scene(pv.Sphere()).lights]
    ['key', 'fill', 'rim']
    """
    parts = leaves(map_blocks(mesh, surface)) if isinstance(mesh, pv.MultiBlock) else [surface(mesh)]
    is_open = any(part.n_open_edges for part in parts)
    if matrix is not None:
        parts = [_moved(part, matrix) for part in parts]
    # PyVista cannot find the bounds of blocks that include tables
    bounds = parts[0].bounds if len(parts) == 1 else pv.MultiBlock(parts).bounds
    return default_scene_of(bounds, is_open=is_open, aspect=aspect)


def _moved(part: pv.PolyData, matrix: MatrixLike) -> pv.PolyData:
    """Return a surface whose points are transformed by a model matrix, in float64."""
    moved = shallow_copy(part)
    moved.points = transform_points(part.points, matrix)
    return moved


def default_scene_of(bounds: VectorLike, *, is_open: bool, aspect: float = 4 / 3) -> Scene:
    """Return the default scene for meshes with these bounds: x_min, x_max, y_min, y_max, z_min, z_max.

    `is_open` is True if a mesh has open edges, so that both sides are lit. `aspect` is the
    width of the image divided by its height.
    """
    far, (low, high) = Viewer.framing(bounds), finite_box(bounds)
    center, radius = np.array(far.focal_point), far.parallel_scale
    # distance at which all corners of the box are inside the image, with a margin
    half = 0.5 * (high - low)
    corners = corners_of(-half, half)
    right, up, back = (corners @ axis for axis in (_RIGHT, _UP, _BACK))
    slope = math.tan(math.radians(0.5 * Viewer.view_angle)) / _MARGIN
    distance = float(np.max(back + np.maximum(np.abs(right) / aspect, np.abs(up)) / slope))
    distance = max(distance, 0.1 * radius)
    clipping_range = max(distance - radius, 0.01 * distance), distance + radius
    viewer = replace(far, position=center + distance * _BACK, clipping_range=clipping_range)
    return Scene(lights=key_fill_rim(), viewer=viewer, light_model=LightModel(two_sided=is_open))


def scene_for(mesh: Any, given: SceneLike | None, matrix: MatrixLike | None = None) -> Scene:
    """Return the scene in which a mesh is lit, with a viewer: the given scene, or else the result of `default_scene`.

    Parameters
    ----------
    mesh : pyvista.DataSet or pyvista.MultiBlock
        Checked surfaces.
    given : Scene, light, or sequence of lights, optional
        The scene, or its lights. Without a viewer, `Viewer.framing` for the mesh is added.
    matrix : array_like, optional
        (4, 4) model matrix; the viewer and the default lights are for the transformed mesh.

    Raises
    ------
    ValueError
        If `given` or `matrix` is invalid.
    """
    if given is None:
        return default_scene(mesh, matrix=matrix)

    def bounds() -> VectorLike:
        parts = [Vertices(part.points, None).bounds(matrix) for part in leaves(mesh)]
        if not parts:
            return pv.MultiBlock().bounds
        low, high = np.fmin.reduce(parts)[::2], np.fmax.reduce(parts)[1::2]  # parts without bounds have NaN
        return np.stack([low, high], axis=1).ravel()

    return as_scene(given, bounds)
