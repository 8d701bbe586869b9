"""Conversions of colours: sRGB to linear RGB and back, linear RGB to CIE XYZ, and temperatures to linear RGB.

The primaries are those of ITU-R BT.709, and the white point is D65. Source: IEC 61966-2-1:1999. The matrix has four
digits, as in the standard.
"""

from __future__ import annotations

import numpy as np

from pvphong.base import check
from pvphong.base.types import ColorLike, Float64Array, FloatArray
from pvphong.base.types import rgb as channels_of

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
    """Convert sRGB values, an array of any shape, to linear light. Values outside [0, 1] follow the same curve."""
    with np.errstate(invalid="ignore"):
        curve = np.maximum((encoded + 0.055) / 1.055, 0.0) ** 2.4
    return np.where(encoded <= 0.04045, encoded / 12.92, curve)


def srgb_from_linear(linear: FloatArray) -> Float64Array:
    """Convert linear light, an array of any shape, to sRGB values; negative numbers stay negative."""
    with np.errstate(invalid="ignore"):
        curve = 1.055 * np.maximum(linear, 0.0) ** (1.0 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, curve)


def xyz_from_rgb(rgb: FloatArray) -> FloatArray:
    """Convert linear colours, shape (n, 3), to CIE XYZ of the same shape and type; values above 1 are allowed."""
    result: FloatArray = (rgb @ XYZ_OF_RGB.T).astype(rgb.dtype)
    return result


def luminance(color: ColorLike) -> float:
    """Return the relative luminance of a linear colour, the Y of CIE XYZ: 1 for white."""
    return float(XYZ_OF_RGB[1] @ channels_of(color))


def kelvin(temperature: float) -> tuple[float, float, float]:
    """Return the linear colour of a black body, such as a lamp's filament.

    A candle has about 1900 K, a bulb 2700 K, a halogen lamp 3200 K, daylight 5500 to 6500 K, a blue sky 10,000 K and
    more. Colours outside the gamut of the primaries are clipped to it.

    Parameters
    ----------
    temperature : float
        Temperature in kelvin, from 1667 to 25000.

    Returns
    -------
    tuple of float
        Red, green and blue; the largest of them is 1, so that the colour tints a light and does not dim it.

    Raises
    ------
    ValueError
        If the temperature is out of range.

    Examples
    --------
    >>> import pvphong as ph
    >>> bulb = ph.PointLight(position=(0, 0, 2), diffuse=ph.kelvin(2700))
    >>> [round(channel, 2) for channel in bulb.diffuse]
    [1.0, 0.42, 0.1]

    Notes
    -----
    The chromaticity is that of the cubic splines by Kim et al. (2002, US patent 7,024,034), for the CIE 1931 observer.
    """
    t = check.number("temperature", temperature, at_least=1667.0, at_most=25000.0)
    x = float(np.polyval(_X_OF_INVERSE[0] if t <= 4000.0 else _X_OF_INVERSE[1], 1e3 / t))
    y = float(np.polyval(_Y_OF_X[0] if t <= 2222.0 else _Y_OF_X[1] if t <= 4000.0 else _Y_OF_X[2], x))
    rgb = np.maximum(np.linalg.solve(XYZ_OF_RGB, [x / y, 1.0, (1.0 - x - y) / y]), 0.0)
    red, green, blue = (rgb / rgb.max()).tolist()
    return red, green, blue


_X_OF_INVERSE = (-0.2661239, -0.2343589, 0.8776956, 0.179910), (-3.0258469, 2.1070379, 0.2226347, 0.240390)
_Y_OF_X = (
    (-1.1063814, -1.34811020, 2.18555832, -0.20219683),
    (-0.9549476, -1.37418593, 2.09137015, -0.16748867),
    (3.0817580, -5.87338670, 3.75112997, -0.37001483),
)
"""Coefficients of the chromaticity x as a polynomial in 1000 K/T, below and above 4000 K; and of y as a polynomial in
x, below 2222 K, below 4000 K and above."""
