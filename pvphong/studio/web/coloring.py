"""Colouring by an array: the choice of array, colormap and range in the studio's page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.meshes.colormaps import colors_by, lookup_table, spans_in
from pvphong.meshes.surfaces import ORIGINAL_POINT
from pvphong.optics.colormap import Colormap
from pvphong.studio.web.fields import number_in

_STEPS = 16
"""Number of colours in the gradient that shows a colormap."""


def arrays_of(meshes: Sequence[pv.DataSet]) -> dict[str, str]:
    """Return the numeric arrays that the meshes have, as name → "point" or "cell"."""
    found: dict[str, str] = {}
    for mesh in meshes:
        for where, data in (("point", mesh.point_data), ("cell", mesh.cell_data)):
            hidden = {ORIGINAL_POINT}
            if where == "point":
                hidden |= {data.active_normals_name, data.active_texture_coordinates_name}
            for name in data:
                if np.asarray(data[name]).dtype.kind in "fiu" and name not in hidden and not name.startswith("vtk"):
                    found.setdefault(name, where)
    return found


def chosen(before: Any, meshes: Sequence[pv.DataSet], scalars: Any, cmap: Any, low: Any, high: Any) -> Colormap:
    """Return the colormap that the user has chosen in the page.

    Parameters
    ----------
    before : object
        The current albedo. If no `cmap` is given, its colormap is kept.
    meshes : sequence of pyvista.DataSet
        The meshes with the array.
    scalars, cmap : str
        Names of the array and of the colormap.
    low, high : float, str or None
        Ends of the range, as numbers or text. None or "" means the end of the array's own range.

    Raises
    ------
    ValueError
        If there is no such array or colormap, or the range is invalid.
    """
    arrays = arrays_of(meshes)
    known = before.cmap if isinstance(before, Colormap) else None
    colormap = Colormap(check.choice("array", scalars, arrays), cmap or known, preference=arrays[scalars])
    ends = [None if end in (None, "") else number_in(name, end) for name, end in (("low", low), ("high", high))]
    span = spans_in(colormap, meshes)
    own = (span.low, span.high)
    if ends == [None, None] and (len(meshes) == 1 or not own[0] < own[1]):
        return colormap  # without limits, the range changes with the array
    first, last = (found if end is None else end for end, found in zip(ends, own, strict=True))
    return replace(colormap, clim=(first, last))


def shown(albedo: Any, meshes: Sequence[pv.DataSet]) -> dict[str, Any]:
    """Return the page's entry for a material's albedo: names of arrays, and name, range and colours of the colormap.

    `albedo` is the field `Material.albedo`. Unless it is a colormap of a named array, only the names of arrays are set.
    """
    entry: dict[str, Any] = {"arrays": list(arrays_of(meshes)), "scalars": "", "cmap": "", "gradient": ""}
    entry |= {"low": None, "high": None}
    if not isinstance(albedo, Colormap) or not isinstance(albedo.scalars, str):
        return entry
    try:
        table = lookup_table("albedo", albedo, np.empty(0), spans_in(albedo, meshes))
    except ValueError:  # the array is missing; the view reports that the mesh cannot be lit
        return entry
    low, high = table.GetRange()
    colors = ", ".join(f"#{bytes(color).hex()}" for color in colors_by(table, np.linspace(low, high, _STEPS)))
    cmap = pv.global_theme.cmap if albedo.cmap is None else albedo.cmap
    entry |= {"scalars": albedo.scalars, "cmap": cmap if isinstance(cmap, str) else "", "low": low, "high": high}
    return entry | {"gradient": f"linear-gradient(to right, {colors})"}
