"""Radiance of the sky by direction: Perez' all-weather model, and the CIE's overcast and clear skies.

Each model gives relative radiances. `radiances` scales them, so that an open horizontal surface receives the given
irradiance. Directions are unit vectors whose third component is along the zenith.

Let ζ be the angle of a direction from the zenith, γ its angle from the sun, and Z the sun's angle from the zenith.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, get_args

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array

SkyModel = Literal["perez", "overcast", "clear"]

SOLAR_CONSTANT = 1367.0
"""Mean irradiance of the sun above the atmosphere in W/m², with which Perez' coefficients were fitted."""

# Lower bounds of the clearness ε of Perez' eight kinds of sky, and the coefficients of the parameters a to e of each.
# Source: R. Perez, R. Seals, J. Michalsky, "All-weather model for sky luminance distribution", Solar Energy 50 (1993),
# 235-245, table 1.
_CLEARNESS = np.array([1.0, 1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2])
_PEREZ = np.array(
    [
        1.3525, -0.2576, -0.2690, -1.4366, -0.7670, 0.0007, 1.2734, -0.1233, 2.8000, 0.6004,
        1.2375, 1.0000, 1.8734, 0.6297, 0.9738, 0.2809, 0.0356, -0.1246, -0.5718, 0.9938,
        -1.2219, -0.7730, 1.4148, 1.1016, -0.2054, 0.0367, -3.9128, 0.9156, 6.9750, 0.1774,
        6.4477, -0.1239, -1.5798, -0.5081, -1.7812, 0.1080, 0.2624, 0.0672, -0.2190, -0.4285,
        -1.1000, -0.2515, 0.8952, 0.0156, 0.2782, -0.1812, -4.5000, 1.1766, 24.7219, -13.0812,
        -37.7000, 34.8438, -5.0000, 1.5218, 3.9229, -2.6204, -0.0156, 0.1597, 0.4199, -0.5562,
        -0.5484, -0.6654, -0.2672, 0.7117, 0.7234, -0.6219, -5.6812, 2.6297, 33.3389, -18.3000,
        -62.2500, 52.0781, -3.5000, 0.0016, 1.1477, 0.1062, 0.4659, -0.3296, -0.0876, -0.0329,
        -0.6000, -0.3566, -2.5000, 2.3250, 0.2937, 0.0496, -5.6812, 1.8415, 21.0000, -4.7656,
        -21.5906, 7.2492, -3.5000, -0.1554, 1.4062, 0.3988, 0.0032, 0.0766, -0.0656, -0.1294,
        -1.0156, -0.3670, 1.0078, 1.4051, 0.2875, -0.5328, -3.8500, 3.3750, 14.0000, -0.9999,
        -7.1406, 7.5469, -3.4000, -0.1078, -1.0750, 1.5702, -0.0672, 0.4016, 0.3017, -0.4844,
        -1.0000, 0.0211, 0.5025, -0.5119, -0.3000, 0.1922, 0.7023, -1.6317, 19.0000, -5.0000,
        1.2438, -1.9094, -4.0000, 0.0250, 0.3844, 0.2656, 1.0468, -0.3788, -2.4517, 1.4656,
        -1.0500, 0.0289, 0.4260, 0.3590, -0.3250, 0.1156, 0.7781, 0.0025, 31.0625, -14.5000,
        -46.1148, 55.3750, -7.2312, 0.4050, 13.3500, 0.6234, 1.5000, -0.6426, 1.8564, 0.5636,
    ]
).reshape(8, 5, 4)  # fmt: skip
# Range of the brightness Δ that the fit covers, and its least value for skies with thin clouds, below which the
# radiance at the horizon would be infinite.
_BRIGHTNESS, _LEAST_IN_THIN_CLOUDS = (0.01, 0.6), 0.2
# Least cosine of ζ: nearer to the horizon, the radiance does not change.
_LEAST_COSINE = 0.01
_TIMES_AT_ONCE = 2**20


def radiances(
    model: SkyModel,
    to_sky: Float64Array,
    level: Float64Array,
    sun: Float64Array,
    direct_normal: Float64Array,
    diffuse_horizontal: Float64Array,
    extraterrestrial: Float64Array | float = SOLAR_CONSTANT,
) -> Float64Array:
    """Return the radiance of the sky in W/m²/sr at t times in k directions, shape (t, k).

    Parameters
    ----------
    model : {"perez", "overcast", "clear"}
        Distribution of the radiance.
    to_sky : ndarray
        Unit vectors above the horizon, shape (k, 3).
    level : ndarray
        Integrals of cos ζ over the k parts of the sky that `to_sky` represents, shape (k,). Radiances times `level`,
        summed over the parts, give exactly the diffuse horizontal irradiance.
    sun : ndarray
        Unit vectors to the sun, shape (t, 3). A sun below the horizon counts as on it.
    direct_normal, diffuse_horizontal : ndarray
        Irradiances in W/m², shape (t,).
    extraterrestrial : ndarray or float
        Irradiance of the sun above the atmosphere in W/m², shape (t,) or one number.
    """
    relative = _MODELS[check.choice("model", model, get_args(SkyModel))]
    sun = np.where(sun[:, 2:] < 0.0, sun * (1.0, 1.0, 0.0), sun)
    sun = sun / np.maximum(np.linalg.norm(sun, axis=1, keepdims=True), 1e-12)
    above = np.broadcast_to(np.asarray(extraterrestrial, np.float64), len(sun))
    result, step = np.empty((len(sun), len(to_sky))), max(_TIMES_AT_ONCE // max(len(to_sky), 1), 1)
    for first in range(0, len(sun), step):
        some = slice(first, first + step)
        found = relative(to_sky, sun[some], direct_normal[some], diffuse_horizontal[some], above[some])
        scale = diffuse_horizontal[some] / np.maximum(found @ level, 1e-300)
        np.multiply(found, scale[:, None], out=result[some])
    return result


def _perez(
    to_sky: Float64Array, sun: Float64Array, direct: Float64Array, diffuse: Float64Array, above: Float64Array
) -> Float64Array:
    """Return Perez' relative radiance (1 + a exp(b / cos ζ)) (1 + c exp(d γ) + e cos² γ), at least 0, shape (t, k).

    The coefficients a to e depend on the clearness ε and the brightness Δ, by the formulas of R. Perez et al.,
    "Modeling daylight availability and irradiance components from direct and global irradiance", Solar Energy 44
    (1990), 271-289. The air mass is that of F. Kasten, "A new table and approximation formula for the relative optical
    air mass" (1966).

    Parameters
    ----------
    to_sky, sun : ndarray
        Unit vectors to the parts of the sky, shape (k, 3), and to the sun, shape (t, 3).
    direct, diffuse, above : ndarray
        Irradiances in W/m², shape (t,): direct normal, diffuse horizontal, and that of the sun above the atmosphere.
    """
    z = np.arccos(np.clip(sun[:, 2], 0.0, 1.0))
    mass = 1.0 / (sun[:, 2] + 0.15 * (93.885 - np.degrees(z)) ** -1.253)
    brightness = np.clip(diffuse * mass / above, *_BRIGHTNESS)
    cubed = 1.041 * z**3
    clearness = (1.0 + direct / np.maximum(diffuse, 1e-9) + cubed) / (1.0 + cubed)
    kind = np.searchsorted(_CLEARNESS, clearness, side="right") - 1
    is_thin = (kind >= 1) & (kind <= 4)
    brightness = np.where(is_thin, np.maximum(brightness, _LEAST_IN_THIN_CLOUDS), brightness)
    table = _PEREZ[np.maximum(kind, 0)].transpose(1, 2, 0)  # (5, 4, t)
    a, b, c, d, e = table[:, 0] + table[:, 1] * z + brightness * (table[:, 2] + table[:, 3] * z)
    is_overcast, of_c, of_d = kind <= 0, table[2], table[3]
    with np.errstate(over="ignore", invalid="ignore"):  # in the rows that are not chosen
        overcast_c = np.exp((brightness * (of_c[0] + of_c[1] * z)) ** of_c[2]) - of_c[3]
        overcast_d = of_d[2] + brightness * of_d[3] - np.exp(brightness * (of_d[0] + of_d[1] * z))
    c, d = np.where(is_overcast, overcast_c, c), np.where(is_overcast, overcast_d, d)
    a, b, c, d, e = (each[:, None] for each in (a, b, c, d, e))
    to_sun = np.clip(sun @ to_sky.T, -1.0, 1.0)
    gradation = 1.0 + a * np.exp(b / np.maximum(to_sky[:, 2], _LEAST_COSINE))
    return np.maximum(gradation * (1.0 + c * np.exp(d * np.arccos(to_sun)) + e * to_sun * to_sun), 0.0)


def _overcast(to_sky: Float64Array, sun: Float64Array, *_: Float64Array) -> Float64Array:
    """Return the relative radiance of the overcast sky, 1 + 2 cos ζ, shape (t, k).

    `to_sky` has k unit vectors to the sky, and `sun` t unit vectors to the sun. Sources: P. Moon and D. Spencer,
    "Illumination from a non-uniform sky", 1942; CIE S 011/E:2003.
    """
    return np.broadcast_to(1.0 + 2.0 * to_sky[:, 2], (len(sun), len(to_sky)))


def _clear(to_sky: Float64Array, sun: Float64Array, *_: Float64Array) -> Float64Array:
    """Return the relative radiance of the clear sky, shape (t, k).

    It is (0.91 + 10 exp(−3γ) + 0.45 cos² γ) (1 − exp(−0.32 / cos ζ)). `to_sky` has k unit vectors to the sky, and `sun`
    t unit vectors to the sun. Sources: CIE 22, 1973; R. Kittler 1967.
    """
    to_sun = np.clip(sun @ to_sky.T, -1.0, 1.0)
    indicatrix = 0.91 + 10.0 * np.exp(-3.0 * np.arccos(to_sun)) + 0.45 * to_sun * to_sun
    return np.asarray(indicatrix * (1.0 - np.exp(-0.32 / np.maximum(to_sky[:, 2], _LEAST_COSINE))))


_MODELS: dict[str, Callable[..., Float64Array]] = {"perez": _perez, "overcast": _overcast, "clear": _clear}


def ground_radiance(albedo: float, sun_height: float, direct_normal: float, diffuse_horizontal: float) -> float:
    """Return the radiance in W/m²/sr of open ground that reflects diffusely.

    Parameters
    ----------
    albedo : float
        Fraction of the light that the ground reflects.
    sun_height : float
        Sine of the sun's altitude.
    direct_normal, diffuse_horizontal : float
        Irradiances in W/m².
    """
    return albedo * (diffuse_horizontal + direct_normal * max(sun_height, 0.0)) / math.pi
