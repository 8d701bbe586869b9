"""Linear RGB as CIE XYZ: sRGB's primaries, which are those of ITU-R BT.709, and its white, D65.

Source: IEC 61966-2-1:1999, the matrix with the four digits that the standard gives it.
"""

from __future__ import annotations

import numpy as np

from pvphong.base.types import FloatArray

XYZ_OF_RGB = np.array(
    [
        [0.4124, 0.3576, 0.1805],
        [0.2126, 0.7152, 0.0722],
        [0.0193, 0.1192, 0.9505],
    ]
)
"""Rows X, Y and Z, columns red, green and blue. Y is the relative luminance: 1 for white."""


def xyz(rgb: FloatArray) -> FloatArray:
    """CIE XYZ (n, 3) of linear colours (n, 3), of the same type; values above 1 are as good as others."""
    result: FloatArray = (rgb @ XYZ_OF_RGB.T).astype(rgb.dtype)
    return result
