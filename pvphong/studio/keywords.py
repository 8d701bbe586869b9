"""Keywords of PyVista's `Plotter.add_mesh`: some define the material of a lit mesh, others are passed on to PyVista.

Source: `pyvista.Plotter.add_mesh` and `add_composite`. Defaults and precedence are the same as in these methods.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from numbers import Real
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.meshes.blocks import datasets, leaves
from pvphong.meshes.colormaps import lookup_table, scalars_of
from pvphong.meshes.surfaces import FeatureAngle, has_faces
from pvphong.optics.colormap import Colormap
from pvphong.optics.material import Material, as_material

_ALIASES = {"rng": "clim", "colormap": "cmap", "rgba": "rgb", "backface_culling": "culling"}
_MORE = ("feature_angle", "interpolation", "vertex_color", "vertex_style", "vertex_opacity", *_ALIASES)

_PROPERTY = ("ambient", "diffuse", "specular", "specular_power", "metallic", "roughness")
_COLORMAP = (
    "cmap",
    "clim",
    "n_colors",
    "log_scale",
    "nan_color",
    "below_color",
    "above_color",
    "flip_scalars",
    "categories",
    "annotations",
    "component",
    "preference",
)
_BAR = ("show_scalar_bar", "scalar_bar_args")
_LOOK = (
    *("color", "pbr", "texture", "scalars", "rgb", "multi_colors", "nan_opacity", "interpolate_before_map"),
    *(*_PROPERTY, *_COLORMAP, *_BAR),
)
"""Keywords that a material replaces."""

_USUAL = {
    **dict.fromkeys(("flip_scalars", "multi_colors", "categories", "log_scale"), False),
    "n_colors": 256,
    "nan_opacity": 1.0,
    "preference": "point",
}
"""Keyword → its default, for the keywords whose default is not None."""

REFUSED = {
    "backface_params": "Each vertex has one colour for both sides. LightModel(two_sided=True) lights back faces.",
    "emissive": "Additive sprites have no surface to light; draw them with plotter.add_mesh.",
}
"""Keywords that lit meshes do not support, and why."""


class Look(NamedTuple):
    """The result of reading the keywords of `add_mesh`: material, opacity, scalar bar, and options for PyVista."""

    materials: Material | Mapping[str, Material]
    """One material, or a mapping from path of a block to material."""
    feature_angle: FeatureAngle
    opacity: Any
    """An array of one opacity for each vertex or cell, or the name of such an array. None if the whole mesh has a
    single opacity, which is then in `options`.
    """
    bar: ScalarBar | None
    options: dict[str, Any]
    """Keywords passed on to PyVista."""
    silhouette: dict[str, Any] | None
    """Options of `pyvista.Plotter.add_silhouette`, which needs faces that share points; None for no silhouette."""


class ScalarBar(NamedTuple):
    """A scalar bar that shows the unlit colours of a mesh."""

    table: pv.LookupTable
    options: dict[str, Any]
    """Options of `pyvista.Plotter.add_scalar_bar`."""

    def add_to(self, plotter: pv.Plotter) -> None:
        """Draw the bar in a plotter. Later scalar bars of the plotter show the same colours by default."""
        mapper = pv.DataSetMapper(theme=plotter.theme)
        mapper.lookup_table, mapper.scalar_range = self.table, self.table.scalar_range
        plotter.mapper = mapper
        plotter.add_scalar_bar(mapper=mapper, **self.options)


@cache
def _known() -> tuple[str, ...]:
    """Return the names of all keywords of PyVista's `add_mesh`."""
    found = inspect.signature(pv.Plotter.add_mesh).parameters
    return (*(name for name in found if name not in ("self", "mesh", "kwargs")), *_MORE)


def refuse_unknown(options: Mapping[str, Any]) -> None:
    """Raise ``TypeError`` if one of `options` is no keyword of PyVista's `add_mesh`.

    The message suggests a close match.
    """
    for name in options:
        if name in Material.__dataclass_fields__ and name not in _known():
            raise TypeError(f"add_mesh has no keyword {name!r}. Pass material=Material({name}=...).")
        if name not in _known():
            remedy = check.meant(name, (*_known(), "material", "casts_shadows", "refine"))
            raise TypeError(f"add_mesh has no keyword {name!r}. {remedy}".rstrip())


_STYLES = "surface", "wireframe", "points", "points_gaussian"


def _refuse_misspelt(options: Mapping[str, Any]) -> None:
    """Raise ``ValueError`` if `options` have a name of a colour, style or texture that PyVista does not know.

    PyVista's own message would have many lines.
    """
    for name, value in options.items():
        if isinstance(value, str) and (name == "color" or name.endswith("_color")):
            try:
                pv.Color(value)  # also accepts opacities, as in "#ff000080"
            except ValueError:
                check.color(name, value)
    if options.get("style") is not None:
        check.choice("style", str(options["style"]).lower(), _STYLES)
    if isinstance(options.get("texture"), str):
        remedy = f"Pass pyvista.read_texture({options['texture']!r})."
        check.refuse("texture", options["texture"], "a pyvista.Texture", remedy)


def look_of(
    mesh: Any,
    material: Any,
    feature_angle: FeatureAngle,
    given: Mapping[str, Any],
    theme: Any,
    next_color: Callable[[], Any],
) -> Look:
    """Return the look of a mesh.

    Parameters
    ----------
    mesh : pyvista.DataSet or pyvista.MultiBlock
        The mesh to draw.
    material : Material, str, mapping or None
        The material. If None, the material follows from the keywords, and from PyVista's theme where keywords are
        missing.
    feature_angle : float, "auto" or None
        Angle in degrees between the normals of two faces, above which their edge is sharp. "auto" is 30 if the mesh has
        no point normals, and None if it has. Without a material, "auto" is 0, which is flat shading, unless the theme
        or `pbr` asks for smooth shading. With None, no edge is sharp. `smooth_shading`, `split_sharp_edges` and
        `interpolation` in `given` may replace the angle.
    given : mapping
        PyVista's keywords.
    theme : pyvista.plotting.themes.Theme
        The plotter's theme.
    next_color : callable
        Returns the next colour of PyVista's colour cycle, for a mesh without a colour.

    Raises
    ------
    TypeError
        For a keyword that PyVista does not have.
    ValueError
        If a value is not allowed, two keywords conflict, or a keyword is not supported.
    """
    refuse_unknown(given)
    options = {_ALIASES.get(name, name): value for name, value in given.items()}
    _refuse_misspelt(options)
    for name, reason in REFUSED.items():
        if options.get(name) is not None:
            check.refuse(name, options[name], "omitted for a lit mesh", reason)
    asked = {name: options.pop(name) for name in _LOOK if name in options}
    asked = {name: value for name, value in asked.items() if value is not None and value is not _USUAL.get(name)}
    angle = _angle(feature_angle, options, theme)
    if angle == "auto" and material is None and not theme.smooth_shading and not asked.get("pbr"):
        angle = 0.0  # PyVista's default is flat shading
    outline = options.pop("silhouette", None)
    silhouette = dict(outline) if isinstance(outline, Mapping) else {} if outline else None
    if material is not None:
        for name, value in asked.items():
            remedy = "Put it into the material; Material(albedo=Colormap(...)) replaces scalars."
            check.refuse(name, value, "omitted when material= is given", remedy)
        return Look(_materials(material), angle, _opacity(options), None, options, silhouette)
    return _by_keywords(mesh, asked, angle, options, theme, next_color)._replace(silhouette=silhouette)


def _materials(given: Any) -> Material | Mapping[str, Material]:
    if isinstance(given, Mapping):
        return {name: as_material(each) for name, each in given.items()}
    return as_material(given)


def _angle(given: FeatureAngle, options: dict[str, Any], theme: Any) -> FeatureAngle:
    """Return the angle above which edges are sharp: a number, "auto", or None.

    PyVista's keywords for the angle are removed from `options`.

    Parameters
    ----------
    given : float, "auto" or None
        pvphong's own keyword `feature_angle`.
    options : dict
        PyVista's keywords. Of these, `smooth_shading`, `split_sharp_edges` and `interpolation` define the angle.
    theme : pyvista.plotting.themes.Theme
        The plotter's theme.
    """
    interpolation = options.pop("interpolation", None)
    is_smooth, is_split = options.pop("smooth_shading", None), options.pop("split_sharp_edges", None)
    if is_smooth is None and interpolation is not None:
        is_smooth = str(interpolation).lower() != "flat"
    if is_split:
        return theme.sharp_edges_feature_angle if given == "auto" else given
    return given if is_smooth is None else None if is_smooth else 0.0


def _opacity(options: dict[str, Any]) -> Any:
    """Remove opacities of vertices or cells from the options of `add_mesh`, and return them.

    If `opacity` is a single number or missing, it stays in the options and the result is None.
    """
    opacity, is_reversed = options.get("opacity"), options.pop("use_transparency", False)
    if isinstance(opacity, Real | np.number):
        options["opacity"] = 1.0 - float(opacity) if is_reversed else float(opacity)
        return None
    if opacity is None:
        return None
    options.pop("opacity")
    if is_reversed:
        check.refuse("use_transparency", True, "False unless opacity is a single number", "Pass 1 - opacity.")
    return opacity


def _by_keywords(
    mesh: Any,
    asked: dict[str, Any],
    angle: FeatureAngle,
    options: dict[str, Any],
    theme: Any,
    next_color: Callable[[], Any],
) -> Look:
    texture, color = asked.pop("texture", None), asked.pop("color", None)
    texture = None if texture is False else texture
    scalars, rgb = asked.pop("scalars", None), asked.pop("rgb", None)
    multi_colors = asked.pop("multi_colors", False)
    asked.pop("interpolate_before_map", None)  # colours are per vertex in any case
    is_blocks = isinstance(mesh, pv.MultiBlock)
    if scalars is None and (rgb or (color is None and texture is None)) and not multi_colors:
        scalars = _active(mesh)
    if is_blocks and color is not None:
        scalars = None
    if texture is not None and scalars is not None:
        check.refuse("texture", texture, "omitted when scalars= is given", "Pass only one of the two.")
    if color is None or color is True:
        color = "white" if texture is not None else next_color()
    options["color"] = color  # for legends, and for edges drawn in this colour
    colored = {name: check.number(name, asked.pop(name)) for name in _PROPERTY if name in asked}
    shading = "Physically based rendering" if asked.pop("pbr", False) else None
    prop = pv.Property(theme, interpolation=shading, color=color, **colored)
    material = Material.from_property(prop)
    if texture is not None:
        options["texture"] = texture  # VTK multiplies lit colours by it, texel by texel
        return Look(material, angle, _opacity(options), None, options, None)
    if isinstance(scalars, str) and rgb is None and scalars.endswith(("_rgb", "_rgba")):
        rgb = True
    nan_opacity, show, bar_options = (asked.pop(name, None) for name in ("nan_opacity", *_BAR))
    if scalars is None:
        if rgb:
            check.refuse("rgb", rgb, "omitted without scalars", "Pass scalars= with the name of an array of colours.")
        if multi_colors:
            return Look(_of_each(mesh, colored, multi_colors, theme), angle, _opacity(options), None, options, None)
        return Look(material, angle, _opacity(options), None, options, None)
    material = replace(material, ambient=prop.ambient, diffuse=prop.diffuse)
    if rgb:
        colors, alpha = _colors(mesh, scalars, asked.get("preference", "point"))
        opacity = _opacity(options)
        return Look(replace(material, albedo=colors), angle, alpha if opacity is None else opacity, None, options, None)
    colormap = Colormap(scalars, **{"preference": "point"} | asked)
    meshes = [each for each in leaves(mesh) if not is_blocks or _has(each, str(scalars))] or leaves(mesh)
    found = [scalars_of("add_mesh", colormap, each) for each in meshes]
    numbers = np.concatenate([each.numbers for each in found])
    table = lookup_table("scalars", colormap, numbers)
    if (
        not hasattr(colormap.cmap, "MapScalars")
        and colormap.clim is None
        and np.ptp(table.scalar_range) > 0.0
        and numbers.dtype != np.bool_
    ):
        colormap = replace(colormap, clim=table.scalar_range)  # as in PyVista: edited scalars keep the range
    if any(each.of_cells for each in found):
        angle = 0.0
    opacity, table = _by_transfer(options, mesh, numbers, table, nan_opacity)
    bar = None
    if theme.show_scalar_bar or bar_options if show is None else show:
        usual: dict[str, Any] = {f"{end}_label": end for end in ("above", "below") if f"{end}_color" in asked}
        usual |= {"n_colors": colormap.n_colors} | ({"title": scalars} if isinstance(scalars, str) else {})
        bar = ScalarBar(table, usual | dict(bar_options or {}))
    return Look(replace(material, albedo=colormap), angle, opacity, bar, options, None)


def _has(mesh: pv.DataSet, name: str) -> bool:
    return name in mesh.point_data or name in mesh.cell_data


def _active(mesh: Any) -> str | None:
    """Return the name of a mesh's active scalars; None if there are none.

    For a MultiBlock, return the name if it is the same in all blocks.
    """
    if not isinstance(mesh, pv.MultiBlock):
        return mesh.active_scalars_name
    names = {each.active_scalars_name for each in leaves(mesh)}
    return names.pop() if len(names) == 1 else None


def _of_each(blocks: Any, colored: Mapping[str, Any], colors: Any, theme: Any) -> Mapping[str, Material]:
    """Return the material of each block, with PyVista's keyword `multi_colors`, as path of the block → material.

    Parameters
    ----------
    blocks : pyvista.MultiBlock
        The blocks.
    colored : mapping
        Keywords of `pyvista.Property` for all blocks.
    colors : Any
        Value of `multi_colors`: True, or the colours to use.
    theme : pyvista.plotting.themes.Theme
        The plotter's theme.
    """
    from pyvista.plotting.colors import get_cycler

    if not isinstance(blocks, pv.MultiBlock):
        check.refuse("multi_colors", colors, "omitted for a mesh without blocks")
    # Each nested MultiBlock also takes a colour, before its children, as in VTK's composite datasets.
    nodes, cycle = list(_nodes(blocks)), iter(get_cycler("default" if colors is True else colors))
    given = {id(node): each["color"] for node, each in zip(nodes, cycle, strict=False)}
    props = {path: pv.Property(theme, color=given[id(each)], **colored) for path, each in datasets(blocks)}
    return {path: Material.from_property(prop) for path, prop in props.items()}


def _nodes(block: Any) -> Iterator[Any]:
    """Yield a block and, if it is a MultiBlock, all blocks inside, depth first."""
    yield block
    if isinstance(block, pv.MultiBlock):
        for each in block:
            yield from _nodes(each)


def _colors(mesh: Any, scalars: Any, preference: str) -> tuple[Any, Float64Array | None]:
    """Return the colours and opacities that an array gives with `rgb=True`.

    Parameters
    ----------
    mesh : pyvista.DataSet or pyvista.MultiBlock
        The mesh.
    scalars : str or array_like
        The array, with 3 or 4 columns, or its name.
    preference : {"point", "cell"}
        Where to look first, if both point and cell data have an array with this name.

    Returns
    -------
    colors : Any
        Value for `Material.albedo`.
    opacities : ndarray or None
        An opacity for each vertex or cell, if the array has 4 columns; None if it has 3.
    """
    if isinstance(scalars, str):
        rows = _named(mesh, scalars, preference)
        if rows is None:
            return scalars, None  # each block has its own array
    else:
        rows = np.asarray(scalars)
    if rows.ndim != 2 or rows.shape[1] not in (3, 4):
        check.refuse("scalars", f"an array of shape {rows.shape}", "an array of shape (n, 3) or (n, 4) when rgb=True")
    if rows.dtype.kind in "iu" and rows.dtype != np.uint8:
        rows = np.clip(rows, 0, 255).astype(np.uint8)
        return rows[:, :3], rows[:, 3] / 255.0 if rows.shape[1] == 4 else None
    if rows.shape[1] == 3:
        return scalars, None
    return rows[:, :3], rows[:, 3] / 255.0 if rows.dtype == np.uint8 else np.asarray(rows[:, 3], np.float64)


def _named(mesh: Any, name: str, preference: str) -> Any:
    """Return the mesh's point or cell array `name`; None for a MultiBlock.

    If both exist, `preference`, "point" or "cell", decides. A name that does not exist raises ValueError.
    """
    if isinstance(mesh, pv.MultiBlock):
        return None
    data = (mesh.point_data, mesh.cell_data)
    for arrays in data if preference == "point" else reversed(data):
        if name in arrays:
            return np.asarray(arrays[name])
    names = list(dict.fromkeys(name for arrays in data for name in arrays.keys()))  # noqa: SIM118 iterating differs
    allowed = f"the name of a point or cell array ({', '.join(names) or 'the mesh has none'})"
    return check.refuse("scalars", repr(name), allowed, check.meant(name, names))


def _by_transfer(
    options: dict[str, Any], mesh: Any, numbers: Any, table: pv.LookupTable, nan_opacity: float | None
) -> tuple[Any, pv.LookupTable]:
    """Return the opacities of a mesh whose scalars are drawn through a colormap.

    An opacity that is an array, or the name of an array, is returned as it is. Otherwise each scalar is mapped to an
    opacity by PyVista's transfer function, and NaN to `nan_opacity`. The keywords that are used are removed from
    `options`.

    Parameters
    ----------
    options : dict
        Keywords of `add_mesh`, such as `opacity`.
    mesh : pyvista.DataSet or pyvista.MultiBlock
        The mesh.
    numbers : ndarray
        The scalars, one number for each point or cell.
    table : pyvista.LookupTable
        The lookup table of the colormap.
    nan_opacity : float or None
        Opacity for NaN.

    Returns
    -------
    opacity : Any
        An opacity for each point or cell, or the name of an array; None if the opacity is a single number.
    table : pyvista.LookupTable
        The table, with opacities, for the scalar bar.
    """
    given = options.get("opacity")
    is_named = isinstance(given, str) and isinstance(mesh, pv.DataSet) and _has(mesh, given)
    if isinstance(given, np.ndarray | Sequence) and not isinstance(given, str) and isinstance(mesh, pv.DataSet):
        is_named = len(given) in (mesh.n_points, mesh.n_cells)
    if is_named or ((given is None or isinstance(given, Real | np.number)) and nan_opacity is None):
        return _opacity(options), table
    if isinstance(mesh, pv.MultiBlock):
        check.refuse("opacity", given, "a single number for a MultiBlock")
    own = pv.LookupTable()
    own.DeepCopy(table)
    if isinstance(given, str | np.ndarray | Sequence):
        try:
            steps = pv.opacity_transfer_function(given, own.n_values)
        except (ValueError, KeyError):  # not the name of a transfer function
            return _opacity(options), table
        own.apply_opacity(255 - steps if options.pop("use_transparency", False) else steps)
        options.pop("opacity")
    if nan_opacity is not None:
        own.nan_opacity = nan_opacity
    own.Build()
    mapped = own.MapScalars(numpy_to_vtk(np.ascontiguousarray(numbers, np.float64)), 1, -1)
    found = vtk_to_numpy(mapped).reshape(len(numbers), -1)[:, 3] / 255.0
    number = options.pop("opacity", None)
    return found * (1.0 if number is None else float(number)), own


def is_bare(mesh: Any) -> bool:
    """Return True if VTK draws a mesh unlit.

    Such a mesh has no faces. It is unlit if it has lines, or if its points have no normals.
    """
    if not isinstance(mesh, pv.PolyData | pv.PointSet) or not mesh.n_points:
        return False
    if isinstance(mesh, pv.PolyData) and has_faces(mesh):
        return False
    return (isinstance(mesh, pv.PolyData) and mesh.n_lines > 0) or mesh.point_data.active_normals_name is None


def as_mesh(given: Any, *, copies: bool) -> Any:
    """Convert `given`, any value that PyVista's `add_mesh` accepts, to a mesh.

    The value can be a dataset, blocks, a VTK object, points, or a path. With `copies`, the result is a shallow copy.
    """
    mesh = pv.read(given) if isinstance(given, str | os.PathLike) else given
    if not isinstance(mesh, pv.DataSet | pv.MultiBlock) and (
        isinstance(mesh, np.ndarray) or hasattr(mesh, "GetDataObjectType")
    ):
        mesh = pv.wrap(mesh)
    return mesh.copy(deep=False) if copies else mesh
