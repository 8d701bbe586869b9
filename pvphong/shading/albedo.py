"""Albedo: what the material's ambient and diffuse are multiplied by at each vertex."""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import FloatArray

# Colours that were computed may be above 1 by rounding; what is more is 0-255 in disguise.
_MOST = 1.001


def checked_albedo(value: Any, count: int) -> Any:
    """An (n, 3) array of uint8, float32 or float64, one row for each of `count` vertices; copied only if it has to be.

    Raises
    ------
    ValueError
        For another shape, another number of rows, integers other than uint8, or what is no number.
    """
    given = check.real_array("albedo", value, "an (n, 3) array of real numbers")
    if given.ndim == 2 and given.shape[1] == 4:
        check.refuse("albedo", f"an array of shape {given.shape}", "of shape (n, 3)", "Leave out the opacity: [:, :3].")
    if given.dtype.kind in "iu" and given.dtype != np.uint8:
        remedy = "Convert 0-255 to uint8, or divide it by 255."
        check.refuse("albedo", f"an array of {given.dtype}", "uint8 or floats", remedy)
    checked = check.rows if given.dtype == np.uint8 else check.array
    albedo = checked("albedo", given, count=count)
    if given.dtype != np.uint8 and len(albedo) and np.fmax.reduce(albedo, axis=None) > _MOST:
        remedy = "Divide 0-255 by 255, or convert it to uint8."
        check.refuse("albedo", f"floats up to {np.fmax.reduce(albedo, axis=None):g}", "floats from 0 to 1", remedy)
    return albedo


def reflectances(albedo: Any) -> FloatArray:
    """Rows of a checked albedo as numbers in [0, 1]: uint8 counts as 0-255, floats are clipped, a NaN counts as 0."""
    if albedo.dtype == np.uint8:
        return albedo / 255.0
    return np.fmin(np.fmax(albedo, 0.0), 1.0)  # fmax takes 0 before a NaN
