"""Highlights around a peak: by chords, and what bounds their change.

A highlight is a function of a cosine f that is 1 at its peak. With a chord C that is 0 there, f = 1 − ½|C|². Near the
peak |C| is small and known to full precision, while a cosine near 1 has lost the digits that a high shininess needs.
A `Peak` says where that is; reflectances whose highlight is fⁿ leave the power to the evaluators, because compiled code
is faster with it in a loop of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, Self

import numpy as np

from pvphong.base import check
from pvphong.base.formulas import (
    HALF,
    LEAST_SQUARE,
    ONE,
    TWO,
    ZERO,
    Power,
    add,
    cross,
    dot,
    formula,
    inverse_length,
    like,
    maximum,
    multiply_add,
    sqrt,
    square,
    subtract,
    times,
    where,
)
from pvphong.base.types import Color, rgb
from pvphong.base.vectors import unit
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics.area.sampling import Directions, around, by_halves
from pvphong.optics.maps import number_or_map
from pvphong.optics.reflectance import (
    ANYWHERE,
    HIGHLIGHT,
    LAMBERT,
    Geometry,
    Lobe,
    Peak,
    Reflectance,
    Sightline,
)
from pvphong.optics.surface import Surface

_SHARPEST = 2.0**40
"""Directions of float64 are not chosen by a higher power."""

LIKENESS = 4.0
"""Blinn-Phong needs about this many times the shininess for the same highlight; see `Material.for_blinn_phong`."""

_LARGER = 2.0**60
"""Makes room for the square of l + v where they are nearly opposite; a power of two, so that it changes no bit."""


# --- where highlights are


@formula
def _mirror_square(at: Geometry) -> Any:
    """|C|² for C = 2(n·l)n − l − v, r·v = 1 − ½|C|², taken apart across n and along it.

    |C|² = |n × (l + v)|² + (n·(l − v))² is 0 where n = l = v, and leaves out the rounding of |n|.
    """
    along = dot(at.n, subtract(at.l, at.v))
    return multiply_add(along, along, square(cross(at.n, add(at.l, at.v)))) * (at.scale * at.scale)


@formula
def _halfway_square(at: Geometry) -> Any:
    """|C|² for C = h − n, n·h = 1 − ½|C|²; 2 where l = −v and there is no h."""
    h = times(add(at.l, at.v), like(at.n_l, _LARGER))
    length = square(h)
    chord = square(subtract(times(h, inverse_length(length)), times(at.n, at.scale)))
    return where(length > LEAST_SQUARE, chord, TWO)


@formula
def _back_square(at: Geometry) -> Any:
    """|C|² for C = l − v, l·v = 1 − ½|C|²."""
    return square(subtract(at.l, at.v))


@formula
def _normal_square(at: Geometry) -> Any:
    """|C|² for C = l − n, n·l = 1 − ½|C|²."""
    return square(subtract(at.l, times(at.n, at.scale)))


def largest_halfway(line: Sightline) -> float:
    """The largest n·h = (cos θ + cos φ) / (2 cos ψ/2): it grows with smaller θ and φ and greater ψ.

    H is the middle of the arc from l to v, so its angle from n is no less than θ − ψ/2, and than φ − ψ/2.
    """
    theta, phi, psi = line
    nearest = math.cos(max(theta - 0.5 * psi, phi - 0.5 * psi, 0.0))
    middle = 2.0 * math.cos(0.5 * psi)
    return min((math.cos(theta) + math.cos(phi)) / middle, nearest) if middle > 1e-6 else nearest


MIRROR = Peak(
    _mirror_square,
    lambda n, l, v: 2.0 * dot(n, l) * n - l - v,
    lambda line: 2.0 * math.cos(line.theta) * max(math.cos(line.phi), 0.0) - math.cos(line.psi),
    lambda surface: surface.mirrored,
)
"""Where the viewer is in the direction r = 2(n·l)n − l in which light is mirrored: r·v = 2(n·l)(n·v) − l·v."""

HALFWAY = Peak(
    _halfway_square,
    lambda n, l, v: unit(l + v)[0] - n,
    largest_halfway,
    None,
    lambda psi: 0.5 / max(math.cos(0.5 * psi), 1e-6),
)
"""Where the half-way direction h = (l + v)/|l + v| is n. It is the middle of the arc from l to v."""

BACK = Peak(_back_square, lambda _, l, v: l - v, lambda _: 1.0, lambda surface: surface.to_viewer)
"""Where the viewer is beside the light. Nothing is known of the least angle between them."""

NORMAL = Peak(
    _normal_square, lambda n, l, _: l - n, lambda line: math.cos(line.theta), lambda surface: surface.exact_normals
)
"""Where light falls along the normal."""


# --- Schlick's part of the light that is white


@formula
def whiteness(at: Geometry) -> Any:
    """(1 − h·l)⁵, the share of the range from the reflectance at normal incidence to white (Schlick 1994, equation 15).

    The cosine h·l is half the length of l + v. Where l = −v it is 0, and there is no half-way direction.
    """
    rest = maximum(ONE - HALF * sqrt(square(add(at.l, at.v))), ZERO)
    return (rest * rest) * (rest * rest) * rest


WHITENESS_SLOPE = 2.5
"""Its largest change for a turn of l or v by a radian: h·l is the cosine of half the angle between them."""


def most_whiteness(psi: float) -> float:
    """The largest for an angle of at most ψ from light to viewer."""
    return (1.0 - math.cos(0.5 * min(psi, math.pi))) ** 5


def part_of_light(name: str, value: Any) -> Color:
    """A checked colour of at most 1 in each channel."""
    color = check.color(name, value)
    if max(rgb(color)) > 1.0:
        check.refuse(name, value, "a part of the light, at most 1 in each channel", "Divide 0-255 values by 255.")
    return color


# --- reflectances with a power


def steepness(shininess: float) -> float:
    """The largest slope of cosⁿ θ: √n · ((n − 1)/n)^((n − 1)/2) for n >= 1; unbounded below 1, except at 0."""
    if shininess < 1.0:
        return math.inf if shininess else 0.0
    return math.sqrt(shininess) * (1.0 - 1.0 / shininess) ** (0.5 * (shininess - 1.0))


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

    def most(self, lobe: int, sightline: Sightline = ANYWHERE) -> float:
        """1, and where light can arrive at all, the power at the largest cosine."""
        if lobe == 0:
            return 1.0
        return self.largest_power(sightline) if sightline.theta < math.pi / 2 else 0.0

    def largest_power(self, sightline: Sightline) -> float:
        """The largest power of a cosine, on either side of the surface."""
        return float(max(min(self.peak.most(sightline) * ROUNDED_UP, 1.0), self.floor, 0.0) ** self.sharpness)

    def change(self, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:
        """The power's slope times the turn; where the light moves, a vertex may also change sides.

        There n·l is at most the sine of the turn, and the angle from normal to viewer no less than the rest up to ψ.
        """
        if lobe == 0:
            return super().change(lobe, turn, psi, light_moves=light_moves)
        widest = min(psi + turn, math.pi)
        change = steepness(self.sharpness) * turn * self.peak.speed(widest)
        if light_moves:
            theta = max(math.pi / 2 - turn, 0.0)
            change += self.largest_power(Sightline(theta, max(theta - psi, 0.0), widest))
        return min(change * ROUNDED_UP, 1.0)

    def extremes(self, field: str, low: float, high: float) -> tuple[Self, ...]:
        """Also the greatest exponent below 1, where highlights are infinitely steep, unless it is one of the ends."""
        ends = super().extremes(field, low, high)
        return (*ends, replace(self, **{field: math.nextafter(1.0, 0.0)})) if low < 1.0 <= high else ends
