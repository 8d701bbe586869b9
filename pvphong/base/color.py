"""Conversions of colours: sRGB to linear RGB and back, and linear RGB to CIE XYZ.

The primaries are those of ITU-R BT.709, and the white point is D65. Source: IEC 61966-2-1:1999. The matrix has four
digits, as in the standard.
"""

from __future__ import annotations

import numpy as np

from pvphong.base.types import Float64Array, FloatArray

XYZ_OF_RGB = np.array(
    [
        [0.4124, 0.3576, 0.1805],
        [0.2126, 0.7152, 0.0722],
        [0.0193, 0.1192, 0.9505],
    ]
)
"""Matrix from linear RGB to XYZ. Rows are X, Y and Z, columns red, green and blue. Y is the relative luminance: 1 for
white."""


def linear_from_srgb(encoded: Float64Array) -> Float64Array:
    """Convert sRGB values of any shape to linear light; values outside [0, 1] follow the same curve."""
    with np.errstate(invalid="ignore"):
        curve = np.maximum((encoded + 0.055) / 1.055, 0.0) ** 2.4
    return np.where(encoded <= 0.04045, encoded / 12.92, curve)


def srgb_from_linear(linear: FloatArray) -> Float64Array:
    """Convert linear light of any shape to sRGB values; negative numbers stay negative."""
    with np.errstate(invalid="ignore"):
        curve = 1.055 * np.maximum(linear, 0.0) ** (1.0 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, curve)


def xyz_from_rgb(rgb: FloatArray) -> FloatArray:
    """Convert linear colours, shape (n, 3), to CIE XYZ of the same shape and type; values above 1 are allowed."""
    result: FloatArray = (rgb @ XYZ_OF_RGB.T).astype(rgb.dtype)
    return result
