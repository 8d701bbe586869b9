"""Values of a material's maps at the points of the lit surface. A map is an array, an array's name or a texture."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy

from pvphong.base import check, host, threads
from pvphong.base.color import linear_from_srgb
from pvphong.base.processes import reading
from pvphong.base.types import ByteArray, Float64Array, FloatArray, IntArray
from pvphong.geometry.normals import point_tangents
from pvphong.meshes.colormaps import colors_by, lookup_table, scalars_of
from pvphong.meshes.surfaces import FeatureAngle, has_faces, polygons, split_sharp_edges, surface
from pvphong.optics.colormap import Colormap
from pvphong.optics.maps import COLORS, SHINIEST, AnyMap, Map, NamedColor, is_image_path, is_texture
from pvphong.optics.material import Material

_TO_POINTS = "mesh.cell_data_to_point_data() converts cell arrays to point arrays."
_TO_FACES = f"feature_angle=0 (--feature-angle 0) gives each face its own points; {_TO_POINTS}"


def surface_and_maps(
    mesh: pv.DataSet, material: Material, feature_angle: FeatureAngle = None
) -> tuple[pv.PolyData, dict[str, Any], Any]:
    """Extract a mesh's surface, split it along sharp edges, and evaluate a material's maps and tangents at its points.

    Parameters
    ----------
    mesh : pyvista.DataSet
        The mesh; it is not modified.
    material : Material
        The material. An array in its fields has one row for each point of the mesh; a name is that of a point array.
    feature_angle : float, "auto" or None
        Edges are split if the normals of their faces differ by more than this angle, in degrees; see
        `split_sharp_edges`.

    Returns
    -------
    source : pyvista.PolyData
        The surface.
    maps : dict
        Field → array with one row for each point of the surface.
    tangents : ndarray or None
        Tangents of the surface's points, shape (n, 3), or None if the material has none.

    Raises
    ------
    ValueError
        If the mesh has no surface, an array does not exist or has the wrong length, or texture coordinates for a
        texture are missing.
    """
    given: dict[str, Any] = given_maps(material, mesh)
    mapped = {name: given.pop(name) for name in list(given) if isinstance(given[name], Colormap)}
    arrays = {
        name: value.source for name, value in given.items() if isinstance(value, Map) and not is_texture(value.source)
    }
    if isinstance(mesh, pv.PolyData) or not arrays:
        whole = surface(mesh)
    else:  # some points may not be on the surface, so VTK transfers the arrays to it
        carrier = mesh.copy(deep=False)
        for name, value in arrays.items():
            carrier.point_data[f"_pvphong_{name}"] = _checked(name, value, mesh)
        whole = surface(carrier)
        given |= {name: whole.point_data.pop(f"_pvphong_{name}") for name in arrays}
    source, points = split_sharp_edges(whole, feature_angle)
    found = {name: values_at(name, value, whole, source, points) for name, value in given.items()}
    found |= {name: colors_at(name, each, mesh, whole, source, points) for name, each in mapped.items()}
    return source, found, found.pop("tangents", None)


def given_maps(material: Material, mesh: pv.DataSet | None = None) -> dict[str, AnyMap]:
    """Return the maps of a material, and its tangents if they are a map, as field → map.

    If a colour is given by its name, and the mesh has a point array of that name, the array's name is the map.
    """
    named: dict[str, AnyMap] = {}
    for field in COLORS if mesh is not None else ():
        color = getattr(material, field)
        if isinstance(color, NamedColor) and _has_numbers(mesh, color.name):
            named[field] = color.name
    return named | material.maps | ({} if material.tangents is None else {"tangents": material.tangents})


def names_taken(material: Material, mesh: pv.DataSet) -> dict[str, str]:
    """Return the meaning of each name that a material has in a colour field, as field → text.

    The text tells how the name was understood: as a colour, an array, an image or a colormap. An example is "the array
    'height'".
    """
    maps = given_maps(material, mesh)
    given: dict[str, Any] = {name: maps.get(name, getattr(material, name)) for name in COLORS}
    kinds = ((Colormap, "a"), (NamedColor, "the colour"), (str, "the array"))
    return {
        field: f"{'the image' if is_image_path(value) and value not in mesh.point_data else words} {value!r}"
        for field, value in given.items()
        for kind, words in kinds
        if isinstance(value, kind)
    }


def _has_numbers(mesh: Any, name: str) -> bool:
    """Return True if a mesh has a numeric point or cell array of this name."""
    arrays = [data.GetArray(name) for data in (mesh.GetPointData(), mesh.GetCellData())]
    return any(array is not None for array in arrays)  # None for an array of strings, which is not a vtkDataArray


def values_at(name: str, given: Any, whole: pv.PolyData, source: pv.PolyData, points: NDArray[Any] | None) -> Any:
    """Return a map's values at the points of a surface that may have been split along sharp edges.

    Parameters
    ----------
    name : str
        Name of the material's field that has the map.
    given : Map, array_like, texture or str
        The map. An array has a row for each point, or for each cell, of the surface before splitting.
    whole, source : pyvista.PolyData
        The surface before its edges were split, and after.
    points : ndarray or None
        For each point of `source`, its index in `whole`; None if no edge was split.
    """
    value = given.source if isinstance(given, Map) else given
    if isinstance(value, str) and value not in source.point_data:
        if is_image_path(value):
            from pvphong.meshes.files import read_texture  # loaded only if a file is read

            with reading(value):
                value = read_texture(value, name)
        elif value in whole.cell_data:
            return _of_faces(name, source.cell_data[value], source)
        else:
            _refuse_unknown(name, value, source)
    if isinstance(value, str):
        return np.asarray(source.point_data[value])
    if is_texture(value):
        return _of_texture(name, value, source)
    if len(value) == whole.n_cells != whole.n_points and name != "tangents":
        return _of_faces(name, value, source)
    return _checked(name, value, whole) if points is None else _checked(name, value, whole)[points]


def opacity_at(
    given: Any, mesh: pv.DataSet, whole: pv.PolyData, source: pv.PolyData, points: NDArray[Any] | None
) -> FloatArray:
    """Return opacities at a surface's points, from 0 for transparent to 1.

    Parameters
    ----------
    given : Map, array_like or str
        Array of opacities from 0 to 1, one for each point or cell of the mesh, or the name of such an array. uint8
        values are divided by 255. Opacities per cell are allowed only if each face has its own points.
    mesh : pyvista.DataSet
        The user's mesh.
    whole, source : pyvista.PolyData
        The mesh's surface before its edges were split, and after.
    points : ndarray or None
        For each point of `source`, its index in `whole`; None if no edge was split.
    """
    value = given.source if isinstance(given, Map) else given
    if isinstance(value, str):
        names = [*mesh.point_data.keys(), *mesh.cell_data.keys()]
        if value not in names:
            allowed = f"a number, an array, or an array's name ({', '.join(names) or 'there are none'})"
            check.refuse("opacity", repr(value), allowed, check.meant(value, names))
        value = mesh.point_data[value] if value in mesh.point_data else mesh.cell_data[value]
    rows = check.real_array("opacity", value, "a number, or an array with one for each point or cell")
    if rows.size != len(np.atleast_1d(rows)) or rows.size not in (mesh.n_points, mesh.n_cells):
        allowed = f"a number, or an array with one for each point ({mesh.n_points}) or cell ({mesh.n_cells})"
        check.refuse("opacity", f"an array of shape {rows.shape}", allowed)
    found: Any = rows.ravel() / 255.0 if rows.dtype == np.uint8 else rows.ravel()
    if not (found.min(initial=0.0) >= 0.0 and found.max(initial=0.0) <= 1.0):  # true for NaN too
        remedy = "Divide 0-255 values by 255, or convert them to uint8."
        check.refuse("opacity", f"numbers from {found.min():g} to {found.max():g}", "numbers from 0 to 1", remedy)
    of_cells = rows.size != mesh.n_points
    return np.asarray(_carried("opacity", found, mesh, whole, source, points, of_cells=of_cells), np.float64)


def colors_at(
    name: str,
    colormap: Colormap,
    mesh: pv.DataSet,
    whole: pv.PolyData,
    source: pv.PolyData,
    points: NDArray[Any] | None,
) -> ByteArray:
    """Map a mesh's scalars to colours, and return them at the points of its surface, shape (n, 3).

    Parameters
    ----------
    name : str
        Name of the material's field that has the colormap, for error messages.
    colormap : Colormap
        The colormap; if it has no range, the range of the scalars of the whole mesh is used.
    mesh : pyvista.DataSet
        The mesh with the scalars.
    whole, source : pyvista.PolyData
        The mesh's surface before its edges were split, and after.
    points : ndarray or None
        For each point of `source`, its index in `whole`; None if no edge was split.
    """
    numbers, of_cells = scalars_of(name, colormap, mesh)
    table = lookup_table(name, colormap, numbers)
    return colors_by(table, _carried(name, numbers, mesh, whole, source, points, of_cells=of_cells))


def _carried(
    name: str,
    rows: Any,
    mesh: pv.DataSet,
    whole: pv.PolyData,
    source: pv.PolyData,
    points: NDArray[Any] | None,
    *,
    of_cells: bool,
) -> Any:
    """Transfer the rows of an array from a mesh to the points of its surface.

    Parameters
    ----------
    name : str
        Name of the material's field that has the array, for error messages.
    rows : ndarray
        A row for each point or, if `of_cells`, for each cell of the mesh.
    mesh : pyvista.DataSet
        The mesh.
    whole, source : pyvista.PolyData
        The mesh's surface before its edges were split, and after.
    points : ndarray or None
        For each point of `source`, its index in `whole`; None if no edge was split.
    of_cells : bool
        True for rows of cells. Faces must then not share points.
    """
    if not isinstance(mesh, pv.PolyData | pv.PointSet):  # the surface has only some of the points and cells
        data, of = (whole.cell_data, "Cell") if of_cells else (whole.point_data, "Point")
        rows = rows[np.asarray(data[f"vtkOriginal{of}Ids"])]
    if of_cells:
        return _of_faces(name, rows, source)
    return rows if points is None else rows[points]


def _of_faces(name: str, values: Any, source: pv.PolyData) -> Any:
    """Transfer an array with one row per face or cell of a surface to the surface's points.

    Raise ValueError if faces share points. The message names the material's field, `name`.
    """
    connectivity, offsets = polygons(source)
    faces = np.asarray(values)
    if len(faces) == source.n_cells:
        faces = faces[source.n_verts + source.n_lines :]
    if len(faces) != len(offsets) - 1 or len(np.unique(connectivity)) != len(connectivity):
        allowed = "an array with one row per point, because faces share points"
        check.refuse(name, f"{len(values)} rows, one per cell", allowed, _TO_FACES)
    found = np.zeros((source.n_points, *faces.shape[1:]), faces.dtype)
    found[connectivity] = np.repeat(faces, np.diff(offsets), axis=0)
    return found


def _refuse_unknown(name: str, value: str, source: pv.PolyData) -> NoReturn:
    """Raise ValueError for a text that is not the name of a point array; the message suggests similar names.

    Parameters
    ----------
    name : str
        Name of the material's field.
    value : str
        The text in this field.
    source : pyvista.PolyData
        The surface with the arrays.
    """
    names = list(source.point_data.keys())
    remedy = check.meant(value, [*names, *(host.answers().color_names() if name in COLORS else ())])
    check.refuse(name, repr(value), f"the name of a point array ({', '.join(names) or 'there are none'})", remedy)


def _of_texture(name: str, texture: Any, source: pv.PolyData) -> FloatArray:
    """Return the values of a texture at a surface's points, for the material's field `name`.

    For a field of colours these are the texture's colours, and for a field of numbers its grey levels. For the
    shininess, the grey levels are multiplied by `SHINIEST`.
    """
    if name == "tangents":
        check.refuse(name, "a texture", "a point array, or its name")
    colors = texture_colors(texture, source, name)
    if name in COLORS:
        return colors
    if not (colors == colors[:, :1]).all():
        remedy = "Select a channel, for example with pv.Texture(image[:, :, 1])."
        check.refuse(name, "a texture of colours", "a texture with one channel, or a grey texture", remedy)
    return colors[:, 0] * (SHINIEST if name == "shininess" else 1.0)


def _checked(name: str, given: Any, mesh: pv.DataSet) -> Any:
    """Return `given`, the value of the field `name`, as an array. Raise ValueError unless it has one row per point."""
    if len(given) == mesh.n_cells != mesh.n_points:
        allowed = f"an array with one row per point, {mesh.n_points} rows"
        check.refuse(name, f"{len(given)} rows, one per cell", allowed, _TO_FACES)
    count = mesh.n_points
    if name == "tangents":
        return check.array(name, given, count=count)
    rows = check.real_array(name, given, "an array of real numbers")
    if len(np.atleast_1d(rows)) != count:
        is_grid = rows.ndim == 3 and rows.shape[0] * rows.shape[1] == count
        remedy = "Reorder it to a StructuredGrid's points with array.reshape(-1, 3, order='F')." if is_grid else ""
        got = f"an array of shape {rows.shape}" if is_grid else f"{len(np.atleast_1d(rows))} rows"
        check.refuse(name, got, f"an array with one row per point, {count} rows", remedy)
    return rows


# vtkTexture's wrap modes, which define the colour outside the image; with mode 3 it is the border colour.
_EDGE, _REPEAT, _MIRROR, _BORDER = range(4)
_BEYOND: tuple[Any, ...] = ("edge", "wrap", "symmetric", "constant")  # the corresponding modes of `numpy.pad`
_MAPPED = 1  # vtkTexture's colour mode with a lookup table

# Number of points that are looked up at once: few enough that their texels stay in the caches.
_AT_ONCE = 2**14

_TO_COORDINATES = "mesh.texture_map_to_plane() and mesh.texture_map_to_sphere() compute texture coordinates."


def texture_colors(texture: Any, source: pv.PolyData, name: str = "albedo") -> Float64Array:
    """Return a texture's colours at a surface's points, interpolated bilinearly between the centres of texels.

    The texture's `wrap` is used. Its `interpolate` and `mipmap` are ignored, because vertices are not pixels; opacity
    is ignored too. If the texture is marked as sRGB (`texture.UseSRGBColorSpaceOn()`), texels are converted to linear
    before interpolation, as in OpenGL 4.6 (specification, 8.24). Texels of all other textures are used unchanged.

    Parameters
    ----------
    texture : pyvista.Texture or vtkTexture
        An image with 1 to 4 channels, uint8 or floats from 0 to 1.
    source : pyvista.PolyData
        A surface with texture coordinates. The colour of a point is NaN if its coordinates are not finite; it is then
        lit as black.
    name : str, default "albedo"
        Field of the material, for error messages.

    Returns
    -------
    ndarray
        Shape (n_points, 3).

    Raises
    ------
    ValueError
        If the surface has no texture coordinates, or the image is missing or invalid.
    """
    coordinates = _coordinates(source)
    if coordinates is None:
        allowed = "an array, its name, or a texture for a mesh with texture coordinates"
        check.refuse(name, "a texture for a mesh without texture coordinates", allowed, _TO_COORDINATES)
    planes, wrap = _planes(texture, name), int(texture.GetWrap())
    border, is_encoded = texture.GetBorderColor(), bool(texture.GetUseSRGBColorSpace())
    (_, height, width), is_bytes = planes.shape, planes.dtype == np.uint8
    flat = planes.reshape(len(planes), -1)
    rows, columns = _texel_numbers(height, wrap), _texel_numbers(width, wrap)
    steps = np.arange(256) / 255.0
    table = linear_from_srgb(steps) if is_encoded else steps
    result = np.empty((source.n_points, 3))

    def look_up(first: int, last: int) -> None:
        u, v = coordinates[first:last].T.astype(np.float64, order="C")
        is_there = np.isfinite(u) & np.isfinite(v)
        u[~is_there] = v[~is_there] = 0.0
        total = np.zeros((3, last - first))
        for row, part in _neighbours(v, rows, wrap):
            for column, share in _neighbours(u, columns, wrap):
                texel, weight = row * width + column, part * share
                is_beyond = (row < 0) | (column < 0) if wrap == _BORDER else None
                for channel, sum_of_channel in enumerate(total):
                    values: Any = np.take(flat[channel % len(flat)], texel, mode="wrap")
                    if is_bytes:
                        values = np.take(table, values)
                    elif is_encoded:
                        values = linear_from_srgb(values.astype(np.float64))
                    if is_beyond is not None:
                        values = np.where(is_beyond, border[channel], values)
                    sum_of_channel += weight * values
        total[:, ~is_there] = np.nan
        result[first:last] = total.T

    threads.run(look_up, source.n_points, _AT_ONCE)
    return result


def texture_version(texture: Any) -> Any:
    """Return a value that changes when a texture or its image is modified or replaced; cheap to compute and compare."""
    return tuple((part, part.GetMTime()) for part in (texture, texture.GetInput()) if part is not None)


def _coordinates(source: pv.PolyData) -> FloatArray | None:
    """Return the texture coordinates of a surface's points, shape (n_points, 2).

    Return None if there are no texture coordinates, or if they have only one number per point.
    """
    found = source.GetPointData().GetTCoords()
    return None if found is None or found.GetNumberOfComponents() < 2 else vtk_to_numpy(found)[:, :2]


def _planes(texture: Any, name: str) -> NDArray[Any]:
    """Return a texture's texels, shape (1 or 3, height, width), with the bottom row first. Opacity is left out.

    Raise ValueError for the field `name` if the texture has no flat image of uint8 or float colours.
    """
    image = texture.GetInput()
    scalars = None if image is None else image.GetPointData().GetScalars()
    if texture.GetCubeMap() or scalars is None or image.GetDimensions()[2] != 1:
        check.refuse(
            name, "a texture without a flat image", "a texture with a flat image", "Read it with pv.read_texture."
        )
    if texture.GetColorMode() == _MAPPED:
        remedy = 'To use its numbers as colours, set texture.color_mode = "direct".'
        check.refuse(name, "a texture with a lookup table", "a texture of colours", remedy)
    values = vtk_to_numpy(scalars)
    if values.dtype != np.uint8 and values.dtype.kind != "f":
        remedy = "Convert 0-255 values to uint8, or divide them by 255."
        check.refuse(name, f"a texture of {values.dtype}", "a texture of uint8 or floats", remedy)
    width, height, _ = image.GetDimensions()
    texels = values.reshape(height, width, -1)
    return np.ascontiguousarray(texels[..., : 3 if texels.shape[2] > 2 else 1].transpose(2, 0, 1))


def _texel_numbers(size: int, wrap: int) -> IntArray:
    """Return the indices of the texels along one axis of an image, extended by one index before and two after.

    `size` is the number of texels along the axis. The added indices are the texels that are used outside the image.
    They depend on `wrap`, VTK's mode for coordinates outside the image. An index of −1 means the border colour.
    """
    return np.pad(np.arange(1, size + 1), (1, 2), _BEYOND[wrap]) - 1  # "constant" pads with 0


def _neighbours(place: Float64Array, numbers: IntArray, wrap: int) -> list[tuple[IntArray, Float64Array]]:
    """Return the two texels along one axis that are nearest to each of n places: two pairs of indices and weights.

    Parameters
    ----------
    place : ndarray
        Texture coordinates along the axis, shape (n,); the image is [0, 1].
    numbers : ndarray
        Result of `_texel_numbers` for the axis.
    wrap : int
        VTK's mode for places outside the image.
    """
    size = len(numbers) - 3
    if wrap == _REPEAT:
        place = place % 1.0
    elif wrap == _MIRROR:
        place = 1.0 - np.abs(place % 2.0 - 1.0)
    middles = np.clip(np.clip(place, -1.0, 2.0) * size - 0.5, -1.0, size)
    first = np.floor(middles).astype(np.intp)
    behind = middles - first
    return [(numbers[first + 1], 1.0 - behind), (numbers[first + 2], behind)]


def tangents_from(source: pv.PolyData, normals: Callable[[], FloatArray]) -> Callable[[], FloatArray] | None:
    """Return a function that computes the tangents of a surface's points from its texture coordinates.

    The result is None if the surface has no faces or no texture coordinates.

    Parameters
    ----------
    source : pyvista.PolyData
        A checked surface.
    normals : callable
        Function that returns the points' normals.
    """
    coordinates = _coordinates(source)
    if coordinates is None or not has_faces(source):
        return None
    return lambda: point_tangents(source.points, *polygons(source), coordinates, normals())
