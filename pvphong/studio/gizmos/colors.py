"""Colours of lights in steps: around the circle of hues, and from cold to warm."""

from __future__ import annotations

import colorsys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from pvphong.base.color import XYZ_OF_RGB
from pvphong.base.types import ColorLike, Vector, rgb
from pvphong.optics.light import Light

_WEIGHTS = XYZ_OF_RGB[1]  # of linear red, green and blue in the relative luminance
# Below this saturation a colour has no hue to be turned, and gets one this strong.
_GREY, _TINTED = 0.01, 0.4
# Of red in one step warmer; blue is divided by it.
_WARMER = 2.0**0.25


def luminance(color: ColorLike) -> float:
    """Relative luminance of a linear colour: 1 for white, the Y of CIE XYZ."""
    return float(_WEIGHTS @ rgb(color))


def hue_turned(color: ColorLike, degrees: float) -> Vector:
    """A colour whose hue is so many degrees further, red to yellow to green; value and saturation stay.

    Grey has no hue: it becomes a light red, or for negative degrees the light violet before it.
    """
    hue, saturation, value = colorsys.rgb_to_hsv(*rgb(color))
    if saturation < _GREY:
        hue, saturation, degrees = 0.0, _TINTED, min(degrees, 0.0)
    return colorsys.hsv_to_rgb((hue + degrees / 360.0) % 1.0, saturation, value)


def warmed(color: ColorLike, steps: float) -> Vector:
    """A colour with more red and less blue, or for negative steps the reverse, of the same luminance."""
    tinted = np.array(rgb(color)) * (_WARMER**steps, 1.0, _WARMER**-steps)
    if not tinted.any():
        return rgb(color)
    red, green, blue = (tinted * (luminance(color) / float(_WEIGHTS @ tinted))).tolist()
    return red, green, blue


def recolored(light: Light, change: Callable[[ColorLike], Vector]) -> Light:
    """A light whose colours are changed, all that it has of its own alike."""
    colors = {"diffuse": light.diffuse, "specular": light.specular, "ambient": light.ambient}
    given = {field: color for field, color in colors.items() if color is not None and any(rgb(color))}
    changed: dict[str, Any] = {field: change(color) for field, color in given.items()}
    return replace(light, **changed)
