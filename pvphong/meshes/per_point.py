"""What is given for each point of a mesh, as an array or by its name, at the points of the surface that is lit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.meshes.edges import FeatureAngle, split_sharp_edges
from pvphong.meshes.surfaces import surface
from pvphong.meshes.textures import is_texture, texture_colors
from pvphong.shading.albedo import checked_albedo
from pvphong.shading.maps import checked_map

_TO_POINTS = "mesh.cell_data_to_point_data() turns cell arrays into point arrays."


def surface_with(
    mesh: pv.DataSet, given: Mapping[str, Any], feature_angle: FeatureAngle = None
) -> tuple[pv.PolyData, dict[str, Any]]:
    """The surface, split along its sharp edges, and what was given, at its points.

    Parameters
    ----------
    mesh : pyvista.DataSet
        It is not modified.
    given : mapping
        Argument's name → array with a row for each point of the mesh, the name of a point array, a texture, or None.
    feature_angle : float, "auto" or None
        As for `split_sharp_edges`.

    Raises
    ------
    ValueError
        If the mesh has no surface, or no array of a name, or an array has not a row for each point; or for a texture
        without texture coordinates.
    """
    arrays = {k: value for k, value in given.items() if not (isinstance(value, str | None) or is_texture(value))}
    for name, value in arrays.items():
        if isinstance(value, np.ndarray) and len(value) == mesh.n_cells != mesh.n_points:
            got = f"{len(value)} rows, one per cell"
            check.refuse(name, got, f"one per point, {mesh.n_points} rows", _TO_POINTS)
    whole, found = (surface(mesh), arrays) if isinstance(mesh, pv.PolyData) or not arrays else _carry(mesh, arrays)
    source, points = split_sharp_edges(whole, feature_angle)
    found = {name: at_points(name, value, points, whole.n_points) for name, value in found.items()}
    return source, {name: _found(name, value, mesh, source) for name, value in given.items()} | found


def at_points(name: str, given: Any, points: NDArray[Any] | None, count: int) -> Any:
    """What was given for so many points, at those that `split_sharp_edges` gives."""
    return given if given is None or points is None else _checked(name, given, count)[points]


def _found(name: str, given: Any, mesh: pv.DataSet, source: pv.PolyData) -> Any:
    """What the surface has itself: of an array's name the array, of a texture its colours."""
    if is_texture(given):
        return texture_colors(given, source)
    if not isinstance(given, str):
        return None
    if given in mesh.cell_data and given not in source.point_data:
        check.refuse(name, f"{given!r}, a cell array", "a point array", _TO_POINTS)
    return source.point_data[check.choice(name, given, source.point_data.keys())]


def _carry(mesh: pv.DataSet, arrays: Mapping[str, Any]) -> tuple[pv.PolyData, dict[str, Any]]:
    """Arrays for a mesh with points inside, carried along to its surface."""
    carrier = mesh.copy(deep=False)
    for name, value in arrays.items():
        carrier.point_data[f"_pvphong_{name}"] = _checked(name, value, mesh.n_points)
    source = surface(carrier)
    return source, {name: source.point_data.pop(f"_pvphong_{name}") for name in arrays}


def _checked(name: str, given: Any, count: int) -> Any:
    """An array with a row for each point."""
    if name == "albedo":
        return checked_albedo(given, count)
    return check.array(name, given, count=count) if name == "tangents" else checked_map(name, given, count)
