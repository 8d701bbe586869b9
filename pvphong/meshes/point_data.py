"""What is given for each point, as an array, its name or a texture, at the points of the surface that is lit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy

from pvphong.base import check
from pvphong.base.color import linear_from_srgb
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.geometry.normals import point_tangents
from pvphong.meshes.surfaces import FeatureAngle, has_faces, polygons, split_sharp_edges, surface
from pvphong.shading.vertices import checked_albedo, checked_map

_TO_POINTS = "mesh.cell_data_to_point_data() turns cell arrays into point arrays."


def surface_and_point_data(
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
    if isinstance(mesh, pv.PolyData) or not arrays:
        whole = surface(mesh)
    else:  # a mesh with points inside: its arrays are carried along to its surface
        carrier = mesh.copy(deep=False)
        for name, value in arrays.items():
            carrier.point_data[f"_pvphong_{name}"] = _checked(name, value, mesh.n_points)
        whole = surface(carrier)
        arrays = {name: whole.point_data.pop(f"_pvphong_{name}") for name in arrays}
    source, points = split_sharp_edges(whole, feature_angle)
    found: dict[str, Any] = dict.fromkeys(given)
    for name, value in given.items():
        if name in arrays:
            found[name] = values_at(name, arrays[name], points, whole.n_points)
        elif is_texture(value):
            found[name] = texture_colors(value, source)
        elif isinstance(value, str):
            if value in mesh.cell_data and value not in source.point_data:
                check.refuse(name, f"{value!r}, a cell array", "a point array", _TO_POINTS)
            found[name] = source.point_data[check.choice(name, value, source.point_data.keys())]
    return source, found


def values_at(name: str, given: Any, points: NDArray[Any] | None, count: int) -> Any:
    """What was given for so many points, at those that `split_sharp_edges` gives."""
    return given if given is None or points is None else _checked(name, given, count)[points]


def _checked(name: str, given: Any, count: int) -> Any:
    """An array with a row for each point."""
    if name == "albedo":
        return checked_albedo(given, count)
    return check.array(name, given, count=count) if name == "tangents" else checked_map(name, given, count)


# vtkTexture's numbers for what is beyond the picture; 3 is its border colour.
_EDGE, _REPEAT, _MIRROR, _BORDER = range(4)
_MAPPED = 1  # its colour mode with a lookup table

# Points that are looked up at once: their texels stay in the caches.
_AT_ONCE = 2**14

_TO_COORDINATES = "mesh.texture_map_to_plane() and mesh.texture_map_to_sphere() give texture coordinates."


def is_texture(given: Any) -> bool:
    """Whether it is a `pyvista.Texture` or a `vtkTexture`; neither is imported for that."""
    return hasattr(given, "GetUseSRGBColorSpace")


def texture_colors(texture: Any, source: pv.PolyData) -> Float64Array:
    """A texture's colours at a surface's points, bilinear between the centres of texels.

    The texture's `wrap` is honoured, `interpolate` and `mipmap` are not: vertices are no pixels. Where it says that its
    colours are sRGB (`texture.UseSRGBColorSpaceOn()`), texels become linear light before they are interpolated, as
    OpenGL 4.6 has it (specification, 8.24); else their numbers are taken as they are. Opacity is left out.

    Parameters
    ----------
    texture : pyvista.Texture or vtkTexture
        An image of 1 to 4 channels, uint8 or floats from 0 to 1.
    source : pyvista.PolyData
        With texture coordinates; a point whose coordinates are not finite is black.

    Returns
    -------
    ndarray
        Shape (n_points, 3).

    Raises
    ------
    ValueError
        If the surface has no texture coordinates, or the texture no such image.
    """
    coordinates = _coordinates(source)
    if coordinates is None:
        allowed = "an array, its name, or a texture for a mesh with texture coordinates"
        check.refuse("albedo", "a texture for a mesh without them", allowed, _TO_COORDINATES)
    texels, wrap = _texels(texture), int(texture.GetWrap())
    border, is_encoded = np.array(texture.GetBorderColor()[:3]), bool(texture.GetUseSRGBColorSpace())
    if texels.dtype == np.uint8:
        steps = np.arange(256) / 255.0
        table = linear_from_srgb(steps) if is_encoded else steps
    result = np.zeros((source.n_points, 3))
    for start in range(0, source.n_points, _AT_ONCE):
        uv = coordinates[start : start + _AT_ONCE].astype(np.float64)
        is_there = np.isfinite(uv).all(axis=1)
        u, v = np.where(is_there, uv.T, 0.0)
        total = result[start : start + _AT_ONCE]
        for row, is_row, part in _neighbours(v, texels.shape[0], wrap):
            for column, is_column, share in _neighbours(u, texels.shape[1], wrap):
                colors = texels[row, column]
                if texels.dtype == np.uint8:
                    colors = np.take(table, colors)
                elif is_encoded:
                    colors = linear_from_srgb(colors.astype(np.float64))
                if wrap == _BORDER:
                    colors = np.where((is_row & is_column)[:, None], colors, border)
                total += (part * share)[:, None] * colors
        total[~is_there] = np.nan
    return result


def texture_version(texture: Any) -> Any:
    """A stamp of a texture and its image that changes with them; cheap to compare."""
    return tuple((part, part.GetMTime()) for part in (texture, texture.GetInput()) if part is not None)


def _coordinates(source: pv.PolyData) -> FloatArray | None:
    """Shape (n_points, 2); None where there are none, or but one for each point."""
    found = source.active_texture_coordinates
    return None if found is None or found.ndim != 2 or found.shape[1] < 2 else np.asarray(found)[:, :2]


def _texels(texture: Any) -> NDArray[Any]:
    """Shape (height, width, 1 or 3): from below to above."""
    image = texture.GetInput()
    scalars = None if image is None else image.GetPointData().GetScalars()
    if texture.GetCubeMap() or scalars is None or image.GetDimensions()[2] != 1:
        check.refuse("albedo", "a texture without one", "a texture with a flat image", "pv.read_texture reads one.")
    if texture.GetColorMode() == _MAPPED:
        remedy = 'texture.color_mode = "direct" takes its numbers as colours.'
        check.refuse("albedo", "a texture with a lookup table", "a texture of colours", remedy)
    values = vtk_to_numpy(scalars)
    if values.dtype != np.uint8 and values.dtype.kind != "f":
        remedy = "Convert 0-255 to uint8, or divide it by 255."
        check.refuse("albedo", f"a texture of {values.dtype}", "a texture of uint8 or floats", remedy)
    width, height, _ = image.GetDimensions()
    texels = values.reshape(height, width, -1)
    return texels[..., :3] if texels.shape[2] > 2 else texels[..., :1]


def _neighbours(place: Float64Array, size: int, wrap: int) -> list[tuple[IntArray, BoolArray, Float64Array]]:
    """The texels before and behind places along an axis: numbers, whether they are those, and weights."""
    # into one period, or next to the picture, so that whole numbers hold it
    reduced = {_REPEAT: place % 1.0, _MIRROR: place % 2.0}.get(wrap, np.clip(place, -1.0, 2.0))
    first = np.floor(reduced * size - 0.5)
    behind = reduced * size - 0.5 - first
    found = []
    for number, weight in ((first.astype(np.intp), 1.0 - behind), (first.astype(np.intp) + 1, behind)):
        if wrap == _REPEAT:
            inside = number % size
        elif wrap == _MIRROR:
            inside = np.minimum(number % (2 * size), 2 * size - 1 - number % (2 * size))
        else:
            inside = np.clip(number, 0, size - 1)
        found.append((inside, inside == number, weight))
    return found


def tangents_from(source: pv.PolyData, normals: Callable[[], FloatArray]) -> Callable[[], FloatArray] | None:
    """What gives the tangents of a surface's points, by its texture coordinates; None where it has none.

    Parameters
    ----------
    source : pyvista.PolyData
        A checked surface.
    normals : callable
        Gives the points' normals.
    """
    coordinates = _coordinates(source)
    if coordinates is None or not has_faces(source):
        return None
    return lambda: point_tangents(source.points, *polygons(source), coordinates, normals())
