"""Sharp edges: points are duplicated along them, so that each side has normals of its own."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.meshes.surfaces import has_faces, has_normals

FeatureAngle = float | Literal["auto"] | None
"""Degrees between the normals of two faces from which their common edge is sharp; see `split_sharp_edges`."""

ORIGINAL_POINT = "pvphong_original_point"
"""Name of the point array that says which point each one was before edges were split."""

# What Blender's "smooth by angle" takes, and PyVista's `split_sharp_edges`.
_AUTO = 30.0
_VTKS_NUMBERS = "pyvistaOriginalPointIds"


def split_sharp_edges(mesh: pv.PolyData, feature_angle: FeatureAngle) -> tuple[pv.PolyData, NDArray[np.int64] | None]:
    """A surface whose points are duplicated along its sharp edges.

    Source: vtkPolyDataNormals, whose splitting this is, without the orientation that it would give faces.

    Parameters
    ----------
    mesh : pyvista.PolyData
        A checked surface; it is not modified.
    feature_angle : float, "auto" or None
        Edges whose faces' normals are further apart than that, in degrees, 0 to 180, are split; 0 is flat shading.
        Point normals that the mesh has are then left out, for they are those of points that are not split. "auto"
        takes 30 where the mesh has no point normals of its own, and splits nothing where it has. None splits nothing.

    Returns
    -------
    surface : pyvista.PolyData
        The mesh itself where nothing is to be split; else a new one with all arrays carried along, and the point array
        ``pvphong_original_point``, int64: which point each was, also if the mesh had been split before. Triangle
        strips become triangles.
    points : ndarray or None
        Shape (n_points,): which of the mesh's points each one was; None for the mesh itself.

    Raises
    ------
    ValueError
        If the angle is not allowed.
    """
    if feature_angle is None or not has_faces(mesh):
        return mesh, None
    is_auto = isinstance(feature_angle, str) and feature_angle == "auto"
    if isinstance(feature_angle, str) and not is_auto:
        check.refuse("feature_angle", feature_angle, 'degrees from 0 to 180, "auto" or None')
    if is_auto and has_normals(mesh):
        return mesh, None
    angle = _AUTO if is_auto else check.number("feature_angle", feature_angle, at_least=0.0, at_most=180.0)
    split, points = _split(mesh, angle)
    return (mesh, None) if is_auto and split.n_points == mesh.n_points else (split, points)


def _split(mesh: pv.PolyData, angle: float) -> tuple[pv.PolyData, NDArray[np.int64]]:
    bare = mesh.copy(deep=False)
    if has_normals(mesh):
        del bare.point_data[mesh.point_data.active_normals_name]
    others = bare.point_data.get("Normals")  # the filter writes its own in place of it
    options: dict[str, Any] = dict.fromkeys(
        ("cell_normals", "consistent_normals", "auto_orient_normals", "non_manifold_traversal", "flip_normals"), False
    )
    split = bare.compute_normals(point_normals=True, split_vertices=True, feature_angle=angle, **options)
    points = np.asarray(split.point_data.pop(_VTKS_NUMBERS)).astype(np.int64, copy=False)
    del split.point_data["Normals"]
    if others is not None:
        split.point_data["Normals"] = np.asarray(others)[points]
    before = mesh.point_data.get(ORIGINAL_POINT)
    split.point_data[ORIGINAL_POINT] = points if before is None else np.asarray(before)[points]
    return split, points
