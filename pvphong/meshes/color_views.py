"""Lit colours in other terms, as point arrays: hue, saturation and value, or CIE XYZ."""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.color import xyz_from_rgb
from pvphong.base.types import FloatArray
from pvphong.meshes.sharing import sharing
from pvphong.meshes.surfaces import surface

ColorSpace = Literal["hsv", "xyz"]


def color_view(mesh: pv.DataSet, space: ColorSpace, *, name: str = "phong") -> pv.PolyData:
    """A new mesh with its lit colours in other terms, as the point array ``<name>_<space>``.

    Colours are taken as what pvphong's are: linear red, green and blue, of sRGB's primaries.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A lit mesh, as from `mesh.phong.shade`; it is not modified. Of other than PolyData the surface is taken.
    space : {"hsv", "xyz"}
        "hsv": hue, from 0 for red by 1/3 for green and 2/3 for blue to 1 for red again, 0 for greys; saturation, from
        0 for grey to 1; and value, the largest channel. Value is above 1 where the colour is; hue and saturation do
        not depend on how bright it is. Source: Matplotlib's `rgb_to_hsv`, at each colour's own brightness.
        "xyz": CIE X, Y and Z for a white of luminance 1, D65; Y is the relative luminance. Source: IEC 61966-2-1.
    name : str, default "phong"
        The point array of colours, shape (n_points, 3), floats >= 0.

    Returns
    -------
    pyvista.PolyData
        With the new array, of the colours' own type, as its active scalars. It shares everything else with the mesh,
        as results of `shade` do.

    Raises
    ------
    ValueError
        If there is no such array or space, the array holds no colours as above, or Matplotlib, which "hsv" needs, is
        not installed.
    """
    convert = {"hsv": _hsv, "xyz": xyz_from_rgb}[check.choice("space", space, get_args(ColorSpace))]
    source = mesh if isinstance(mesh, pv.PolyData) else surface(mesh)
    result = sharing(source)
    result.point_data[f"{name}_{space}"] = convert(_colors(source, name))
    result.set_active_scalars(f"{name}_{space}", preference="point")
    return result


def _colors(mesh: pv.PolyData, name: str) -> FloatArray:
    found: Any = np.asarray(mesh.point_data[check.choice("name", name, mesh.point_data.keys())])
    allowed = "an array of lit colours: three floats >= 0 per point"
    if found.shape != (mesh.n_points, 3) or found.dtype.kind != "f":
        check.refuse("name", f"{name}, an array of {found.dtype} of shape {found.shape}", allowed)
    if not (np.isfinite(found) & (found >= 0.0)).all():
        check.refuse("name", f"{name}, an array with a negative number, NaN or infinity", allowed)
    return found


def _hsv(rgb: FloatArray) -> FloatArray:
    """Hue, saturation, value; of colours above 1 they are those of the same colour at full brightness, value aside."""
    try:
        from matplotlib.colors import rgb_to_hsv
    except ImportError as error:
        raise ValueError('Hue, saturation and value need Matplotlib: pip install "pvphong[plot]".') from error
    above = np.maximum(rgb.max(axis=1, keepdims=True), rgb.dtype.type(1.0))
    result: FloatArray = rgb_to_hsv(rgb / above)
    result[:, 2:] *= above
    return result
