"""Highlights around a peak, by chords.

A highlight is a function of a cosine f that is 1 at its peak. With a chord C that is 0 there, f = 1 − ½|C|². Near the
peak |C| is small and known to full precision, while a cosine near 1 has lost the digits that a high shininess needs.
A `Peak` says where that is, in the file of the reflectance that is known by it: `phong.py`, `blinn_phong.py`,
`retro.py`. Reflectances whose highlight is fⁿ leave the power to the evaluators, because compiled code is faster with
it in a loop of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, Self

import numpy as np

from pvphong.base import check
from pvphong.base.formulas import HALF, ONE, ZERO, Power, add, formula, maximum, sqrt, square, where
from pvphong.base.types import Color, rgb
from pvphong.optics.area.sampling import Directions, around, by_halves
from pvphong.optics.maps import number_or_map
from pvphong.optics.reflectance import (
    HIGHLIGHT,
    LAMBERT,
    Geometry,
    Lobe,
    Peak,
    Reflectance,
)
from pvphong.optics.surface import Surface

_SHARPEST = 2.0**40
"""Directions of float64 are not chosen by a higher power."""

# --- Schlick's part of the light that is white


@formula
def whiteness(at: Geometry) -> Any:
    """(1 − h·l)⁵, the share of the range from the reflectance at normal incidence to white (Schlick 1994, equation 15).

    The cosine h·l is half the length of l + v. Where l = −v it is 0, and there is no half-way direction.
    """
    rest = maximum(ONE - HALF * sqrt(square(add(at.l, at.v))), ZERO)
    return (rest * rest) * (rest * rest) * rest


def part_of_light(name: str, value: Any) -> Color:
    """A checked colour of at most 1 in each channel."""
    color = check.color(name, value)
    if max(rgb(color)) > 1.0:
        check.refuse(name, value, "a part of the light, at most 1 in each channel", "Divide 0-255 values by 255.")
    return color


# --- reflectances with a power


@formula
def lambert_and_highlight(own: Any, at: Geometry, highlight: Any) -> Any:  # noqa: ARG001 any reflectance's
    """max(n·l, 0), and a highlight where n·l is positive."""
    return maximum(at.n_l, ZERO), where(at.n_l > ZERO, highlight, ZERO)


@formula
def unchanged(shininess: Any, own: Any) -> Any:  # noqa: ARG001 only the power has it
    """The parameters of a reflectance that has its shininess in its power alone."""
    return own


def own_shininess() -> Any:
    """A field with a shininess; None, its default, means the material's."""
    return check.field(_shininess_or_none, None)


def _shininess_or_none(name: str, value: Any) -> Any:
    return None if value is None else number_or_map(name, value, at_least=0.0)


class Shiny(Reflectance):
    """Lambert's cosine, and a highlight that is a power of the cosine around its peak.

    Each kind has the field `shininess`, whose default None means the material's.
    """

    shininess: float | None
    floor: float = 0.0
    """The cosine is taken to be at least this."""

    peak: ClassVar[Peak]
    maps: ClassVar[frozenset[str]] = frozenset({"specular", "shininess"})
    factors = staticmethod(lambert_and_highlight)
    mapped = staticmethod(unchanged)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Lambert's, and the highlight."""
        return LAMBERT, HIGHLIGHT

    def of(self, material: Any) -> Self:
        """A copy with the material's shininess, where it has none of its own."""
        own: dict[str, Any] = {"shininess": material.shininess}
        return replace(self, **own) if self.shininess is None else self

    def power(self, maps: Mapping[str, Any]) -> Power:
        """Its shininess, or that of each vertex; and its floor."""
        return Power(maps.get("shininess", self.sharpness), self.floor)

    def directions(self, surface: Surface) -> Directions:
        """By the power itself, around its peak."""
        exponent = np.minimum(self.power(surface.maps).exponent, _SHARPEST)
        if self.peak.axis is not None:
            return around(self.peak.axis(surface), exponent)

        def slopes(x: Any, y: Any) -> tuple[Any, Any]:
            inner = np.clip(x * x + y * y, 1e-300, 1.0 - 2.0**-30)
            steep = np.sqrt(np.expm1(-2.0 / (exponent + 1.0) * np.log1p(-inner)) / inner)
            return x * steep, y * steep

        def density(x: Any, y: Any) -> Any:
            return (exponent + 1.0) / (2.0 * math.pi) * np.exp(-0.5 * (exponent + 3.0) * np.log1p(x * x + y * y))

        return by_halves(surface.exact_normals, surface.to_viewer, slopes, density)

    @property
    def sharpness(self) -> float:
        """The shininess."""
        return self.shininess or 0.0
