"""Highlights around a peak: by chords, and what bounds their change.

A highlight is a function of a cosine f that is 1 at its peak. With a chord C that is 0 there, f = 1 − ½|C|². Near the
peak |C| is small and known to full precision, while a cosine near 1 has lost the digits that a high shininess asks for.
A `Peak` says where that is; reflectances whose highlight is fⁿ leave the power to the evaluators, because compiled code
is faster with it in a loop of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

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
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics.reflectance import HIGHLIGHT, LAMBERT, Geometry, Lobe, Peak, Reflectance
from pvphong.optics.spherical import CosinePower

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
def _mirror_chord(n: Any, l: Any, v: Any) -> Any:
    return subtract(subtract(times(n, TWO * dot(n, l)), l), v)


@formula
def _halfway_square(at: Geometry) -> Any:
    """|C|² for C = h − n, n·h = 1 − ½|C|²; 2 where l = −v and there is no h."""
    h = times(add(at.l, at.v), like(at.n_l, _LARGER))
    length = square(h)
    chord = square(subtract(times(h, inverse_length(length)), times(at.n, at.scale)))
    return where(length > LEAST_SQUARE, chord, TWO)


@formula
def _halfway_chord(n: Any, l: Any, v: Any) -> Any:
    h = add(l, v)
    return subtract(times(h, inverse_length(square(h))), n)


@formula
def _back_square(at: Geometry) -> Any:
    """|C|² for C = l − v, l·v = 1 − ½|C|²."""
    return square(subtract(at.l, at.v))


@formula
def _back_chord(n: Any, l: Any, v: Any) -> Any:  # noqa: ARG001 for any normal
    return subtract(l, v)


@formula
def _normal_square(at: Geometry) -> Any:
    """|C|² for C = l − n, n·l = 1 − ½|C|²."""
    return square(subtract(at.l, times(at.n, at.scale)))


@formula
def _normal_chord(n: Any, l: Any, v: Any) -> Any:  # noqa: ARG001 for any viewer
    return subtract(l, n)


MIRROR = Peak(_mirror_square, _mirror_chord)
"""Where the viewer stands in the direction r = 2(n·l)n − l in which light is mirrored."""

HALFWAY = Peak(_halfway_square, _halfway_chord)
"""Where the half-way direction h = (l + v)/|l + v| is n."""

BACK = Peak(_back_square, _back_chord)
"""Where the viewer stands beside the light."""

NORMAL = Peak(_normal_square, _normal_chord)
"""Where light falls along the normal."""


# --- Schlick's part of the light that is white


@formula
def whiteness(at: Geometry) -> Any:
    """(1 − h·l)⁵, the part of the way from the reflectance at normal incidence to white (Schlick 1994, equation 15).

    H·l is half the length of l + v. Where l = −v it is 0, and there is no half-way direction.
    """
    rest = maximum(ONE - HALF * sqrt(square(add(at.l, at.v))), ZERO)
    return (rest * rest) * (rest * rest) * rest


WHITENESS_SLOPE = 2.5
"""Its largest change for a turn of l or v by a radian: h·l is the cosine of half the angle between them."""


def most_whiteness(psi: float) -> float:
    """The largest for an angle of at most ψ from light to viewer."""
    return (1.0 - math.cos(0.5 * min(psi, math.pi))) ** 5


# --- reflectances with a power


@formula
def lambert_and_highlight(own: Any, at: Geometry, highlight: Any) -> Any:  # noqa: ARG001 any reflectance's
    """max(n·l, 0), and a highlight where n·l is positive."""
    return maximum(at.n_l, ZERO), where(at.n_l > ZERO, highlight, ZERO)


@dataclass(frozen=True)
class Shiny(Reflectance):
    """Lambert's cosine, and a highlight that is a power of another cosine.

    Parameters
    ----------
    shininess : float, optional
        The exponent n, >= 0; the material's if not given.

    Raises
    ------
    ValueError
        If the shininess is not such a number.
    """

    shininess: float | None = None

    maps: ClassVar[frozenset[str]] = frozenset({"specular", "shininess"})
    factors = staticmethod(lambert_and_highlight)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Lambert's, and the highlight."""
        return LAMBERT, HIGHLIGHT

    def __post_init__(self) -> None:
        if self.shininess is not None:
            object.__setattr__(self, "shininess", check.number("shininess", self.shininess, at_least=0.0))

    def of(self, material: Any) -> Self:
        """With the material's shininess, where it has none of its own."""
        return replace(self, shininess=material.shininess) if self.shininess is None else self

    def power(self, maps: Mapping[str, Any]) -> Power | None:
        """Its shininess, or that of each vertex."""
        return Power(maps.get("shininess", self.sharpness))

    def extremes(self, field: str, low: float, high: float) -> tuple[Self, ...]:
        """With the greatest of those below 1, which are infinitely steep, where none of the ends is it."""
        ends = super().extremes(field, low, high)
        return (*ends, replace(self, shininess=math.nextafter(1.0, 0.0))) if low < 1.0 <= high else ends

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """Lambert's cosine; the highlight's is the kind's own to say."""
        return CosinePower("normal", 1.0), None

    @property
    def sharpness(self) -> float:
        """The shininess."""
        return self.shininess or 0.0


# --- bounds on how highlights change


def steepness(shininess: float) -> float:
    """The largest slope of cosⁿ θ: √n · ((n − 1)/n)^((n − 1)/2) for n >= 1; unbounded below 1, except at 0."""
    if shininess == 0.0:
        return 0.0
    if shininess < 1.0:
        return math.inf
    if shininess == 1.0:
        return 1.0
    return math.sqrt(shininess) * ((shininess - 1.0) / shininess) ** ((shininess - 1.0) / 2.0)


def mirror_change(shininess: float, floor: float, turn: float, psi: float, *, light_moves: bool) -> float:
    """The largest change of (r·v)ⁿ when l or v turns by `turn`, for an angle of at most ψ from light to viewer.

    R turns as much as l does, and (r·v)ⁿ changes by no more than `steepness` times the turn. Where the light moves, a
    vertex may also change sides: there n·l is at most sin δ, so r·v = 2(n·l)(n·v) − l·v is at most 2 sin δ − cos ψ, and
    the highlight that is switched is at most that to the n.
    """
    delta = math.sin(min(turn, math.pi / 2))
    switched = 2.0 * delta - math.cos(min(psi + turn, math.pi))
    return _with_switch(steepness(shininess) * turn, switched, shininess, floor, light_moves)


def halfway_change(shininess: float, turn: float, psi: float, *, light_moves: bool) -> float:
    """`mirror_change` for (n·h)ⁿ.

    H is the middle of the arc from l to v and turns by at most turn / (2 cos ψ/2); at n·l ≈ 0,
    n·h = (n·l + n·v) / (2 cos ψ/2) is at most sin ψ/2 + sin δ / cos ψ/2.
    """
    delta = math.sin(min(turn, math.pi / 2))
    middle = math.cos(min(psi + turn, math.pi) / 2.0)
    if middle <= 1e-6:
        return 1.0
    switched = math.sin(psi / 2.0) + delta / middle
    return _with_switch(steepness(shininess) * turn / (2.0 * middle), switched, shininess, 0.0, light_moves)


def _with_switch(change: float, switched: float, shininess: float, floor: float, light_moves: bool) -> float:
    if light_moves:
        change += min(max(switched, floor, 0.0), 1.0) ** shininess
    return min(change * ROUNDED_UP, 1.0)


def largest_power(cosine: float, shininess: float, floor: float) -> float:
    """Of a cosine that is at most so much: at most so much to the n."""
    return float(max(min(cosine * ROUNDED_UP, 1.0), floor, 0.0) ** shininess)


def largest_halfway(theta: float, phi: float, psi: float) -> float:
    """The largest n·h = (cos θ + cos φ) / (2 cos ψ/2): it grows with smaller θ and φ and greater ψ."""
    middle = 2.0 * math.cos(psi / 2.0)
    return (math.cos(theta) + math.cos(phi)) / middle if middle > 1e-6 else 1.0
