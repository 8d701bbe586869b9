"""Highlights as functions of the chord to their peak.

A highlight is a function of a cosine f that is 1 at its peak. With a chord C that is 0 there, f = 1 − ½|C|². Near the
peak, a cosine near 1 has lost the digits that a high shininess needs, while |C| is small and has full precision.
`phong.py`, `blinn_phong.py` and `retro.py` each define a `Peak`. Reflectances whose highlight is fⁿ leave the power to
the evaluators, because compiled code is faster with the power in a separate loop.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, Self

import numpy as np

from pvphong.base import check
from pvphong.base.formulas import HALF, ONE, ZERO, Power, add, formula, maximum, select, sqrt, square
from pvphong.base.types import Color, rgb
from pvphong.optics.directions import Directions, around, by_halves
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
"""Largest power for importance sampling, limited by the resolution of float64 directions."""

# --- Schlick's white part of the reflectance


@formula
def whiteness(at: Geometry) -> Any:
    """Compute (1 − h·l)⁵, by which a reflectance turns from its colour at normal incidence to white.

    `at` has the directions at a vertex. The cosine h·l is half the length of l + v. If l = −v, there is no half-way
    direction h, and the cosine is taken as 0. Source: Schlick 1994, equation 15.
    """
    rest = maximum(ONE - HALF * sqrt(square(add(at.l, at.v))), ZERO)
    return (rest * rest) * (rest * rest) * rest


def part_of_light(name: str, value: Any) -> Color:
    """Check the value of the field `name`: a colour of at most 1 in each channel."""
    color = check.color(name, value)
    if max(rgb(color)) > 1.0:
        check.refuse(name, value, "a reflectance of at most 1 in each channel", "Divide 0-255 values by 255.")
    return color


# --- reflectances with a power


@formula
def lambert_and_highlight(own: Any, at: Geometry, highlight: Any) -> Any:  # noqa: ARG001 any reflectance's
    """Return the factor of the diffuse lobe, max(n·l, 0), and the factor of the highlight.

    The highlight's factor is the argument `highlight`, the power of the cosine around the peak, where n·l > 0; else it
    is 0. `at` has the directions at a vertex. `own`, the parameters of the reflectance, is not read.
    """
    return maximum(at.n_l, ZERO), select(at.n_l > ZERO, highlight, ZERO)


@formula
def unchanged(shininess: Any, own: Any) -> Any:  # noqa: ARG001 only the power depends on it
    """Return `own`, the parameters of a reflectance, unchanged: they do not depend on the shininess.

    This is `Reflectance.mapped` for reflectances in which a map of the shininess changes only the power.
    """
    return own


def own_shininess() -> Any:
    """Declare a field for a shininess. Its default is None and means the material's shininess."""
    return check.field(_shininess_or_none, None)


def _shininess_or_none(name: str, value: Any) -> Any:
    return None if value is None else number_or_map(name, value, at_least=0.0)


class Shiny(Reflectance):
    """Base class of reflectances with Lambert's diffuse cosine and a highlight that is a power of a cosine.

    The cosine is that of the angle from the highlight's peak. Each subclass has the field `shininess`, whose default,
    None, means the material's shininess.
    """

    shininess: float | None
    floor: float = 0.0
    """Least value of the cosine around the peak."""

    peak: ClassVar[Peak]
    maps: ClassVar[frozenset[str]] = frozenset({"specular", "shininess"})
    factors = staticmethod(lambert_and_highlight)
    mapped = staticmethod(unchanged)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Lambert's lobe, and the lobe of the highlight."""
        return LAMBERT, HIGHLIGHT

    def of(self, material: Any) -> Self:
        """Return this reflectance, with the material's shininess if its own shininess is None."""
        own: dict[str, Any] = {"shininess": material.shininess}
        return replace(self, **own) if self.shininess is None else self

    def power(self, maps: Mapping[str, Any]) -> Power:
        """Return the highlight as a power of the cosine around its peak.

        The exponent is the shininess. If `maps` has a map of the shininess, the exponents are the map's numbers.
        """
        return Power(maps.get("shininess", self.sharpness), self.floor)

    def directions(self, surface: Surface) -> Directions:
        """Return an importance sampling of the highlight at the vertices of `surface`.

        Directions are chosen by the power of the cosine around the highlight's peak.
        """
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
        """The shininess; 0 if it is None."""
        return self.shininess or 0.0
