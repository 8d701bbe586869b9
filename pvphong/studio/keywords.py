"""PyVista's keywords of `Plotter.add_mesh` as a material: what a lit mesh takes of them, and what is passed on.

Source: `pyvista.Plotter.add_mesh` and `add_composite`, whose defaults and whose order of decisions these are.
"""

from __future__ import annotations

import inspect
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
from pvphong.meshes.surfaces import FeatureAngle
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
"""What a material says where there is one."""

_USUAL = {
    **dict.fromkeys(("flip_scalars", "multi_colors", "categories", "log_scale"), False),
    "n_colors": 256,
    "nan_opacity": 1.0,
    "preference": "point",
}
"""Defaults that are not None."""

REFUSED = {
    "backface_params": "A vertex has one colour; LightModel(two_sided=True) lights back faces as VTK does without it.",
    "emissive": "Sprites that add up have no surface; plotter.add_mesh draws them.",
}
"""What has no counterpart, and why."""


class Look(NamedTuple):
    """What keywords say of a lit mesh."""

    materials: Material | Mapping[str, Material]
    """For all of it, or by block."""
    feature_angle: FeatureAngle
    opacity: Any
    """A number for each vertex or cell, or the name of such an array; None where all have that of `options`."""
    bar: ScalarBar | None
    options: dict[str, Any]
    """What PyVista is given."""
    silhouette: dict[str, Any] | None
    """Options of `pyvista.Plotter.add_silhouette`, which needs faces that share points; None for none."""


class ScalarBar(NamedTuple):
    """A scalar bar of the colours before light."""

    table: pv.LookupTable
    options: dict[str, Any]
    """As for `pyvista.Plotter.add_scalar_bar`."""

    def add_to(self, plotter: pv.Plotter) -> None:
        """Draw it, and let the plotter's later scalar bars be of these colours too."""
        mapper = pv.DataSetMapper(theme=plotter.theme)
        mapper.lookup_table, mapper.scalar_range = self.table, self.table.scalar_range
        plotter.mapper = mapper
        plotter.add_scalar_bar(mapper=mapper, **self.options)


@cache
def _known() -> tuple[str, ...]:
    """All keywords of PyVista's `add_mesh`."""
    found = inspect.signature(pv.Plotter.add_mesh).parameters
    return (*(name for name in found if name not in ("self", "mesh", "kwargs")), *_MORE)


def refuse_unknown(options: Mapping[str, Any]) -> None:
    """Raise ``TypeError`` for a keyword that PyVista's `add_mesh` does not have; the message has a close match."""
    for name in options:
        if name in Material.__dataclass_fields__ and name not in _known():
            raise TypeError(f"add_mesh has no keyword {name!r}. Material({name}=...) has it.")
        if name not in _known():
            remedy = check.meant(name, (*_known(), "material", "casts_shadows", "refine"))
            raise TypeError(f"add_mesh has no keyword {name!r}. {remedy}".rstrip())


_STYLES = "surface", "wireframe", "points", "points_gaussian"


def _refuse_misspelt(options: Mapping[str, Any]) -> None:
    """Raise ``ValueError`` for words that PyVista does not know, before it says so in many lines."""
    for name, value in options.items():
        if isinstance(value, str) and (name == "color" or name.endswith("_color")):
            try:
                pv.Color(value)  # which has opacities too, as in "#ff000080"
            except ValueError:
                check.color(name, value)
    if options.get("style") is not None:
        check.choice("style", str(options["style"]).lower(), _STYLES)
    if isinstance(options.get("texture"), str):
        remedy = f"pyvista.read_texture({options['texture']!r}) reads it."
        check.refuse("texture", options["texture"], "a pyvista.Texture", remedy)


def look_of(
    mesh: Any,
    material: Any,
    feature_angle: FeatureAngle,
    given: Mapping[str, Any],
    theme: Any,
    next_color: Callable[[], Any],
) -> Look:
    """What a mesh is to look like.

    Parameters
    ----------
    mesh : pyvista.DataSet or pyvista.MultiBlock
        What is drawn.
    material : Material, str, mapping or None
        None: the keywords, and what they leave out PyVista's theme, say it.
    feature_angle : float, "auto" or None
        As for `mesh.phong.shade`.
    given : mapping
        PyVista's keywords.
    theme : pyvista.plotting.themes.Theme
        The plotter's.
    next_color : callable
        Gives PyVista's next colour for a mesh that has none.

    Raises
    ------
    TypeError
        For a keyword that PyVista does not have.
    ValueError
        If a value is not allowed, two say the same thing, or a keyword has no counterpart.
    """
    refuse_unknown(given)
    options = {_ALIASES.get(name, name): value for name, value in given.items()}
    _refuse_misspelt(options)
    for name, reason in REFUSED.items():
        if options.get(name) is not None:
            check.refuse(name, options[name], "left out for a lit mesh", reason)
    asked = {name: options.pop(name) for name in _LOOK if name in options}
    asked = {name: value for name, value in asked.items() if value is not None and value is not _USUAL.get(name)}
    angle = _angle(feature_angle, options, theme)
    if angle == "auto" and material is None and not theme.smooth_shading and not asked.get("pbr"):
        angle = 0.0  # as PyVista draws what is not asked to be smooth
    outline = options.pop("silhouette", None)
    silhouette = dict(outline) if isinstance(outline, Mapping) else {} if outline else None
    if material is not None:
        for name, value in asked.items():
            remedy = "Either the material says it, or keywords do: Material(albedo=Colormap(...)) has scalars."
            check.refuse(name, value, "left out where there is a material", remedy)
        return Look(_materials(material), angle, _opacity(options), None, options, silhouette)
    return _by_keywords(mesh, asked, angle, options, theme, next_color)._replace(silhouette=silhouette)


def _materials(given: Any) -> Material | Mapping[str, Material]:
    if isinstance(given, Mapping):
        return {name: as_material(each) for name, each in given.items()}
    return as_material(given)


def _angle(given: FeatureAngle, options: dict[str, Any], theme: Any) -> FeatureAngle:
    """Where edges are sharp, by PyVista's keywords for that."""
    interpolation = options.pop("interpolation", None)
    is_smooth, is_split = options.pop("smooth_shading", None), options.pop("split_sharp_edges", None)
    if is_smooth is None and interpolation is not None:
        is_smooth = str(interpolation).lower() != "flat"
    if is_split:
        return theme.sharp_edges_feature_angle if given == "auto" else given
    return given if is_smooth is None else None if is_smooth else 0.0


def _opacity(options: dict[str, Any]) -> Any:
    """Take an opacity for each vertex out of the options; None where there is but one number."""
    opacity, is_reversed = options.get("opacity"), options.pop("use_transparency", False)
    if isinstance(opacity, Real | np.number):
        options["opacity"] = 1.0 - float(opacity) if is_reversed else float(opacity)
        return None
    if opacity is None:
        return None
    options.pop("opacity")
    if is_reversed:
        check.refuse("use_transparency", True, "False where opacity is not one number", "Give 1 - opacity.")
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
    asked.pop("interpolate_before_map", None)  # colours are those of vertices in any case
    is_blocks = isinstance(mesh, pv.MultiBlock)
    if scalars is None and (rgb or (color is None and texture is None)) and not multi_colors:
        scalars = _active(mesh)
    if is_blocks and color is not None:
        scalars = None
    if texture is not None and scalars is not None:
        check.refuse("texture", texture, "left out beside scalars", "A mesh is coloured by one of them.")
    if color is None or color is True:
        color = "white" if texture is not None else next_color()
    options["color"] = color  # for legends, and for edges that are drawn in it
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
            check.refuse("rgb", rgb, "left out where there are no scalars", "scalars=... names an array of colours.")
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
        colormap = replace(colormap, clim=table.scalar_range)  # it stays when the scalars are edited, as PyVista's does
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
    """The name of the active scalars; of blocks that which all have in common."""
    if not isinstance(mesh, pv.MultiBlock):
        return mesh.active_scalars_name
    names = {each.active_scalars_name for each in leaves(mesh)}
    return names.pop() if len(names) == 1 else None


def _of_each(blocks: Any, colored: Mapping[str, Any], colors: Any, theme: Any) -> Mapping[str, Material]:
    """A material for each block, its colours as PyVista's `multi_colors` gives them one after the other."""
    from pyvista.plotting.colors import get_cycler

    if not isinstance(blocks, pv.MultiBlock):
        check.refuse("multi_colors", colors, "left out for a mesh without blocks")
    # the blocks themselves count too, the whole first, as among the attributes of VTK's composite datasets
    nodes, cycle = list(_nodes(blocks)), iter(get_cycler("default" if colors is True else colors))
    given = {id(node): each["color"] for node, each in zip(nodes, cycle, strict=False)}
    props = {path: pv.Property(theme, color=given[id(each)], **colored) for path, each in datasets(blocks)}
    return {path: Material.from_property(prop) for path, prop in props.items()}


def _nodes(block: Any) -> Iterator[Any]:
    """A block, and all in it."""
    yield block
    if isinstance(block, pv.MultiBlock):
        for each in block:
            yield from _nodes(each)


def _colors(mesh: Any, scalars: Any, preference: str) -> tuple[Any, Float64Array | None]:
    """A map of colours, and of RGBA its opacities."""
    if isinstance(scalars, str):
        rows = _named(mesh, scalars, preference)
        if rows is None:
            return scalars, None  # of blocks, each has its own
    else:
        rows = np.asarray(scalars)
    if rows.ndim != 2 or rows.shape[1] not in (3, 4):
        check.refuse("scalars", f"an array of shape {rows.shape}", "(n, 3) or (n, 4) where rgb is True")
    if rows.dtype.kind in "iu" and rows.dtype != np.uint8:
        rows = np.clip(rows, 0, 255).astype(np.uint8)
        return rows[:, :3], rows[:, 3] / 255.0 if rows.shape[1] == 4 else None
    if rows.shape[1] == 3:
        return scalars, None
    return rows[:, :3], rows[:, 3] / 255.0 if rows.dtype == np.uint8 else np.asarray(rows[:, 3], np.float64)


def _named(mesh: Any, name: str, preference: str) -> Any:
    """An array of a mesh by its name; None for blocks."""
    if isinstance(mesh, pv.MultiBlock):
        return None
    data = (mesh.point_data, mesh.cell_data)
    for arrays in data if preference == "point" else reversed(data):
        if name in arrays:
            return np.asarray(arrays[name])
    names = list(dict.fromkeys(name for arrays in data for name in arrays.keys()))  # noqa: SIM118 it lists them
    allowed = f"the name of a point or cell array ({', '.join(names) or 'there is none'})"
    return check.refuse("scalars", repr(name), allowed, check.meant(name, names))


def _by_transfer(
    options: dict[str, Any], mesh: Any, numbers: Any, table: pv.LookupTable, nan_opacity: float | None
) -> tuple[Any, pv.LookupTable]:
    """An opacity for each point or cell, as given or by the scalars, and the table with what that takes."""
    given = options.get("opacity")
    is_named = isinstance(given, str) and isinstance(mesh, pv.DataSet) and _has(mesh, given)
    if isinstance(given, np.ndarray | Sequence) and not isinstance(given, str) and isinstance(mesh, pv.DataSet):
        is_named = len(given) in (mesh.n_points, mesh.n_cells)
    if is_named or ((given is None or isinstance(given, Real | np.number)) and nan_opacity is None):
        return _opacity(options), table
    if isinstance(mesh, pv.MultiBlock):
        check.refuse("opacity", given, "one number for blocks")
    own = pv.LookupTable()
    own.DeepCopy(table)
    if isinstance(given, str | np.ndarray | Sequence):
        try:
            steps = pv.opacity_transfer_function(given, own.n_values)
        except (ValueError, KeyError):  # neither the name of one
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
