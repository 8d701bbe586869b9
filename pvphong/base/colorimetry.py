"""Linear RGB from sRGB's numbers, and as CIE XYZ: primaries of ITU-R BT.709, and D65 as white.

Source: IEC 61966-2-1:1999, the matrix with the four digits that the standard gives it.
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
"""Rows X, Y and Z, columns red, green and blue. Y is the relative luminance: 1 for white."""


def linear(encoded: Float64Array) -> Float64Array:
    """Linear light of sRGB's numbers, of any shape: 0 and 1 stay what they are, and what is outside goes on alike."""
    with np.errstate(invalid="ignore"):
        bent = np.maximum((encoded + 0.055) / 1.055, 0.0) ** 2.4
    return np.where(encoded <= 0.04045, encoded / 12.92, bent)


def xyz(rgb: FloatArray) -> FloatArray:
    """CIE XYZ (n, 3) of linear colours (n, 3), of the same type; values above 1 are as good as others."""
    result: FloatArray = (rgb @ XYZ_OF_RGB.T).astype(rgb.dtype)
    return result
