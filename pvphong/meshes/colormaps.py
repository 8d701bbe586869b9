"""Colours of scalars: a `Colormap` maps an array of a mesh through VTK's lookup table, set up as by PyVista."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from pvphong.base import check
from pvphong.base.types import ByteArray
from pvphong.optics.colormap import Colormap, numbers_of
from pvphong.optics.material import Material

_MAP_SCALARS = 1  # vtkScalarsToColors' colour mode that maps bytes too, instead of using them as colours


def names() -> list[str]:
    """Return the names of the colormaps of Matplotlib and of the other packages that PyVista searches."""
    import matplotlib as mpl
    from pyvista.plotting import colors

    found = [*mpl.colormaps]
    for package in ("colorcet", "cmocean", "cmcrameri"):
        if importlib.util.find_spec(package):
            found += getattr(colors, f"_{package.upper()}_CMAPS", ())
    return found


class Scalars(NamedTuple):
    """The numbers of a mesh that a colormap maps to colours."""

    numbers: Any
    """Real numbers, shape (n,)."""
    of_cells: bool


def scalars_of(name: str, colormap: Colormap, mesh: pv.DataSet) -> Scalars:
    """Return the numbers that a colormap maps, at all points or all cells of a mesh.

    Raises
    ------
    ValueError
        If the array does not exist, exists for both points and cells, has the wrong length or is not numeric. The
        message begins with `name`, the material's field.
    """
    given, preference = colormap.scalars, colormap.preference
    if isinstance(given, str):
        data = {"point": mesh.point_data, "cell": mesh.cell_data}
        having = [where for where, arrays in data.items() if given in arrays]
        if not having:
            arrays = list(dict.fromkeys((*mesh.point_data.keys(), *mesh.cell_data.keys())))
            allowed = f"the name of a point or cell array ({', '.join(arrays) or 'there is none'})"
            check.refuse(f"{name}'s scalars", repr(given), allowed, check.meant(given, arrays))
        if len(having) == 2 and preference is None:
            remedy = 'Pass Colormap(..., preference="point") or preference="cell".'
            check.refuse(
                f"{name}'s scalars",
                f"{given!r}, the name of two arrays",
                "the name of one array, of points or of cells",
                remedy,
            )
        where = preference if preference in having else having[0]
        values, label = np.asarray(data[where][given]), f"{name}'s scalars {given!r}"
    else:
        values, label = np.asarray(given), f"{name}'s scalars"
        lengths = {"point": mesh.n_points, "cell": mesh.n_cells}
        having = [where for where, length in lengths.items() if len(values) == length]
        if not having:
            allowed = f"an array with one row per point ({mesh.n_points}) or per cell ({mesh.n_cells})"
            check.refuse(label, f"{len(values)} rows", allowed)
        where = preference if preference in having else having[0]
    return Scalars(_reduced(label, colormap, values), where == "cell")


def _reduced(label: str, colormap: Colormap, values: Any) -> Any:
    """Return one real number or bool for each row of `values`, shape (n,).

    For a row of several numbers, the result is the number in the column that the colormap selects. If the colormap
    selects no column, the result is the row's norm. Error messages begin with `label`.
    """
    values = numbers_of(label, values)
    if values.dtype.kind == "c":
        values = values.real
    if values.ndim == 2 and colormap.component is not None:
        if colormap.component >= values.shape[1]:
            allowed = f"less than {values.shape[1]}, the number of columns"
            check.refuse(f"{label}: component", colormap.component, allowed)
        values = values[:, colormap.component]
    elif values.ndim == 2:
        values = np.linalg.norm(values, axis=1)
    return values


class Span(NamedTuple):
    """Range of an array of numbers, which a colormap without `clim` needs."""

    low: float
    """Smallest finite number; +infinity if there is none."""
    high: float
    positive: float
    """Smallest finite number above 0; +infinity if there is none."""
    different: tuple[float, ...]
    """Distinct numbers; empty unless the colormap has `categories=True`."""


def span_of(colormap: Colormap, numbers: Any) -> Span:
    """Return the range of the numbers that a colormap maps."""
    finite = numbers[np.isfinite(numbers)] if numbers.dtype.kind == "f" else numbers
    different = np.unique(numbers).tolist() if colormap.categories is True else ()
    if not len(finite):
        return Span(math.inf, -math.inf, math.inf, tuple(different))
    low = float(finite.min())
    positive = low if low > 0.0 else float(np.min(finite, where=finite > 0, initial=_highest(finite.dtype)))
    return Span(low, float(finite.max()), positive, tuple(different))


def _highest(kind: np.dtype[Any]) -> Any:
    return np.inf if kind.kind == "f" else True if kind == np.bool_ else np.iinfo(kind).max


def joined(spans: Iterable[Span]) -> Span:
    """Return the smallest range that contains all the given ranges."""
    found = [*spans, Span(math.inf, -math.inf, math.inf, ())]
    low, high, positive, different = zip(*found, strict=True)
    return Span(min(low), max(high), min(positive), tuple(np.unique(np.concatenate(different)).tolist()))


def over_all(material: Material, meshes: Sequence[pv.DataSet]) -> Material:
    """Return a material whose colormaps all have a `clim`.

    If a colormap has none, it is the range of its array in all meshes.
    In a colormap with `categories=True`, True is replaced by the number of distinct values. A colormap whose array is
    invalid is not changed here; lighting a mesh with it raises the error.
    """
    return spanned(material, {name: spans_in(each, meshes) for name, each in unspanned(material).items()})


def unspanned(material: Material) -> dict[str, Colormap]:
    """Return the colormaps of a material that depend on the numbers of the whole mesh, as field → colormap.

    A colormap depends on these numbers if it has no `clim`, or has `categories=True`.
    """
    maps = {name: each for name, each in material.maps.items() if isinstance(each, Colormap)}
    own = {name: each for name, each in maps.items() if not hasattr(each.cmap, "MapScalars")}
    return {name: each for name, each in own.items() if each.clim is None or each.categories is True}


def spans_in(colormap: Colormap, meshes: Sequence[pv.DataSet]) -> Span:
    """Return the range of a colormap's array over several meshes. Meshes without a valid array are skipped."""
    spans = []
    for mesh in meshes if isinstance(colormap.scalars, str) else ():
        with contextlib.suppress(ValueError):
            numbers = scalars_of("", colormap, mesh).numbers
            if numbers.dtype != np.bool_:
                spans.append(span_of(colormap, numbers))
    return joined(spans)


def spanned(material: Material, spans: Mapping[str, Span]) -> Material:
    """Return a material whose colormaps all have a `clim`.

    If a colormap has none, it is the range of its field in `spans`.
    In a colormap with `categories=True`, True is replaced by the number of distinct values in the range.

    Parameters
    ----------
    material : Material
        The material.
    spans : mapping
        Field → range of the numbers that the field's colormap maps.
    """
    found = {}
    for name, span in spans.items():
        colormap = material.maps[name]
        if not isinstance(colormap, Colormap):
            continue
        low = span.positive if colormap.log_scale and span.low <= 0.0 else span.low
        if colormap.clim is None and low < span.high:
            colormap = replace(colormap, clim=(low, span.high))
        if colormap.categories is True and span.different:
            colormap = replace(colormap, categories=len(span.different))
        found[name] = colormap
    return material.with_values(found)


def lookup_table(name: str, colormap: Colormap, numbers: Any, span: Span | None = None) -> pv.LookupTable:
    """Return the lookup table with which a colormap maps an array of numbers.

    The table is set up as by `pyvista.DataSetMapper.set_scalars`, in the same order.

    Parameters
    ----------
    name : str
        Name of the material's field that has the colormap, for error messages.
    colormap : Colormap
        The colormap.
    numbers : ndarray
        The numbers to map, shape (n,).
    span : Span, optional
        Range for a colormap without `clim`; by default the range of `numbers`.

    Raises
    ------
    ValueError
        If a range is needed, but all numbers are NaN or infinite.
    """
    if hasattr(colormap.cmap, "MapScalars"):
        colormap.cmap.Build()
        return colormap.cmap
    is_bool = numbers.dtype == np.bool_
    if is_bool or colormap.clim is not None:
        low, high = (-0.5, 1.5) if is_bool else colormap.clim
        if colormap.log_scale and low <= 0.0:  # as in PyVista; a range found from the numbers is handled below
            low = sys.float_info.min
    else:
        is_known = span is not None or len(numbers)
        low, high = (
            _found_range(name, span or span_of(colormap, numbers), colormap.log_scale) if is_known else (0.0, 1.0)
        )
    count = 2 if is_bool else colormap.n_colors
    if colormap.categories is not False:
        is_counted = colormap.categories is True
        count = len((span or span_of(colormap, numbers)).different) if is_counted else colormap.categories
    table, theme = pv.LookupTable(), pv.global_theme
    table.scalar_range = low, high
    if isinstance(colormap.cmap, tuple):
        table.apply_cmap(_listed(colormap.cmap), len(colormap.cmap))
    else:
        table.apply_cmap(theme.cmap if colormap.cmap is None else colormap.cmap, count)
    if colormap.flip_scalars:
        table.values[:] = table.values[::-1]
    table.nan_color = theme.nan_color if colormap.nan_color is None else colormap.nan_color
    for outside in ("above", "below"):
        color = getattr(colormap, f"{outside}_color")
        if color is not None:
            setattr(table, f"{outside}_range_color", color)
    table.log_scale = colormap.log_scale
    if is_bool:
        table.annotations = {0.0: "False", 1.0: "True"}
    if colormap.annotations is not None:
        table.annotations = dict(colormap.annotations)
    table.Build()  # without it, colours of NaN and outside the range are outdated, as in `LookupTable.__call__`
    return table


def _listed(colors: tuple[Any, ...]) -> Any:
    """Return a Matplotlib colormap with the given colours.

    A name such as "g" is looked up in Matplotlib first, then in PyVista, as PyVista itself does.
    """
    from matplotlib.colors import ListedColormap, is_color_like

    return ListedColormap([each if is_color_like(each) else pv.Color(each).float_rgb for each in colors])


def _found_range(name: str, span: Span, log_scale: bool) -> tuple[float, float]:
    """Return the ends of a lookup table's range for a colormap without `clim`.

    Raise ValueError if there is no such range.

    Parameters
    ----------
    name : str
        Name of the material's field that has the colormap, for error messages.
    span : Span
        Range of the numbers.
    log_scale : bool
        True if the table is logarithmic. If `span` then contains negative numbers, the range begins at the smallest
        positive number.
    """
    if span.low > span.high:
        remedy = "With clim=(0, 1), they are drawn in the colour of NaN."
        check.refuse(f"{name}'s scalars", "only NaN or infinity", "finite in some rows if clim is omitted", remedy)
    if not log_scale or span.low >= 0.0:
        return span.low, span.high
    if not span.high > 0.0:
        allowed, remedy = "an array with numbers > 0 for log_scale", "Omit log_scale, or pass clim."
        check.refuse(f"{name}'s scalars", f"numbers up to {span.high:g}", allowed, remedy)
    return span.positive, span.high  # VTK prints an error for a logarithmic range with both signs


def colors_by(table: Any, numbers: Any) -> ByteArray:
    """Return the 8-bit colours, shape (n, 3), with which VTK draws n numbers through a lookup table."""
    if numbers.dtype == np.bool_ or numbers.dtype == np.float16 or numbers.dtype.itemsize > 8:
        numbers = numbers.astype(np.float64)
    if not len(numbers):
        return np.zeros((0, 3), np.uint8)
    plain = np.ascontiguousarray(numbers, numbers.dtype.newbyteorder("="))
    mapped = table.MapScalars(numpy_to_vtk(plain), _MAP_SCALARS, -1)
    return vtk_to_numpy(mapped).reshape(len(numbers), -1)[:, :3].copy()


_SCALE = "_colormap"
"""Suffix of the name of the field array that describes the scalar bar of the unlit colours. The name of the lit colours
precedes the suffix.
"""


def put_scale(lit: pv.DataSet, name: str, material: Material, mesh: pv.DataSet) -> None:
    """Store a scalar bar of the unlit colours in a lit mesh. If the material has no colormap, remove a stored bar.

    Parameters
    ----------
    lit : pyvista.DataSet
        Mesh to change. The scalar bar is the field array ``NAME_colormap``, a JSON text that files can store.
    name : str
        Name of the array of lit colours.
    material : Material
        The material. The colormap of its albedo is used, or else its first colormap.
    mesh : pyvista.DataSet
        The mesh before lighting.
    """
    lit.GetFieldData().RemoveArray(f"{name}{_SCALE}")
    maps = sorted(material.maps.items(), key=lambda item: item[0] != "albedo")
    colormaps = [(field, each) for field, each in maps if isinstance(each, Colormap)]
    for field, colormap in colormaps[:1]:
        table = lookup_table(field, colormap, scalars_of(field, colormap, mesh).numbers)
        if not isinstance(table, pv.LookupTable):
            return
        colors = {f"{which}_color": getattr(table, f"{which}_range_color") for which in ("below", "above")}
        found = {
            "title": colormap.scalars if isinstance(colormap.scalars, str) else "",
            "clim": list(table.scalar_range),
            "colors": [f"#{bytes(color[:3]).hex()}" for color in np.asarray(table.values)],
            "log_scale": table.log_scale,
            "annotations": {str(number): text for number, text in table.annotations.items()},
            **{which: color.hex_rgb for which, color in colors.items() if color is not None},
        }
        lit.field_data[f"{name}{_SCALE}"] = json.dumps(found)


def scale_of(lit: pv.DataSet, name: str) -> tuple[str, pv.LookupTable] | None:
    """Return the title and the lookup table of the scalar bar that `put_scale` stored in a lit mesh.

    `name` is that of the array of lit colours. The result is None if no valid scalar bar is stored.
    """
    kept = lit.field_data.get(f"{name}{_SCALE}")
    if kept is None:
        return None
    try:
        found = json.loads(str(np.asarray(kept).ravel()[0] if np.ndim(kept) else kept))
        table = pv.LookupTable(values=[pv.Color(color).int_rgba for color in found["colors"]])
        table.scalar_range, table.log_scale = found["clim"], found["log_scale"]
        table.annotations = {float(number): text for number, text in found["annotations"].items()}
        for which in ("below", "above"):
            setattr(table, f"{which}_range_color", found.get(f"{which}_color"))
        table.Build()
        return str(found["title"]), table
    except (ValueError, TypeError, KeyError, AttributeError):  # an array of this name that pvphong did not write
        return None


def mapped(name: str, colormap: Colormap) -> ByteArray:
    """Return the 8-bit colours, shape (n, 3), of a colormap whose `scalars` are an array, not a name.

    Errors begin with `name`, the material's field.
    """
    if isinstance(colormap.scalars, str):
        allowed = "a Colormap of an array if there is no mesh"
        check.refuse(name, repr(colormap), allowed, "Array names need a mesh; pass Colormap(array, ...).")
    numbers = numbers_in(name, colormap, np.asarray(colormap.scalars))
    return colors_by(lookup_table(name, colormap, numbers), numbers)


def numbers_in(name: str, colormap: Colormap, values: Any) -> Any:
    """Return the numbers, shape (n,), that a colormap maps: one for each row of `values`.

    `values` is the colormap's array or a part of it. Errors begin with `name`, the material's field.
    """
    return _reduced(f"{name}'s scalars", colormap, values)


# --- light in units

# Colours from no light to the most, which users of Ladybug Tools and other programs for daylight know.
_OF_LIGHT = (
    *("#4b6ba9", "#7393ca", "#aac8f7", "#c1d5d0", "#f5ef67"),
    *("#fce64a", "#ef9c15", "#ea7b00", "#ea4a00", "#ea2600"),
)
# Round numbers, for the steps of a scalar bar.
_ROUND = 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0


def scale_of_light(largest: float, most: float | None = None) -> dict[str, Any]:
    """Return the options `cmap` and `clim` of PyVista's `add_mesh` for pictures of light in units.

    Parameters
    ----------
    largest : float
        Largest value in the picture. The scale ends at a round number that is at least as large.
    most : float, optional
        End of the scale, in place of the round number.
    """
    from matplotlib.colors import LinearSegmentedColormap  # late, as it takes a third of a second

    top = most or 1.0
    if not most and largest > 0.0:
        size = 10.0 ** math.floor(math.log10(largest / 10.0))
        top = 10.0 * next(step * size for step in _ROUND if 10.0 * step * size >= largest * (1.0 - 1e-9))
    return {"cmap": LinearSegmentedColormap.from_list("light", _OF_LIGHT), "clim": (0.0, top)}
