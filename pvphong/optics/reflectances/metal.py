"""Metal, whose highlight has the metal's colour."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

from pvphong.base import check
from pvphong.base.types import Color, ColorLike, FloatArray, rgb
from pvphong.optics.light import Arrival
from pvphong.optics.reflectance import Lobe, Reflectance, Sightline
from pvphong.optics.reflectances.fresnel import WHITENESS_SLOPE, most_whiteness, whiteness
from pvphong.optics.reflectances.phong import Phong
from pvphong.optics.reflectances.shiny import HIGHLIGHT, LAMBERT
from pvphong.optics.spherical import CosinePower
from pvphong.optics.surface import Surface


@dataclass(frozen=True)
class Metal(Reflectance):
    """Phong's reflection with a highlight that is tinted by the metal, and white only where light grazes it.

    max(n·l, 0), and F · max(r·v, 0)ˢ where n·l > 0, with Schlick's F = C + (1 − C)(1 − h·l)⁵ for the metal's colour C
    and h = (l + v)/|l + v|. The colour of the highlight is its own: the material's `specular` is not read, and its
    `diffuse` should be dark, for metals scatter next to nothing. Not reciprocal, as Phong's.

    Parameters
    ----------
    color : color
        What it reflects at normal incidence, from 0 to 1: gold is about (1.0, 0.78, 0.34), in linear light.
    shininess : float, optional
        The exponent s, >= 0; the material's if not given.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Notes
    -----
    C. Schlick: An inexpensive BRDF model for physically-based rendering (1994), equation 15. That a metal's colour
    shifts to white at grazing angles is R. Cook and K. Torrance: A reflectance model for computer graphics (1982),
    section 5.
    """

    color: ColorLike
    shininess: float | None = None

    maps: ClassVar[frozenset[str]] = frozenset({"shininess"})

    def __post_init__(self) -> None:
        object.__setattr__(self, "color", part_of_light("color", self.color))
        object.__setattr__(self, "shininess", Phong(self.shininess).shininess)

    def of(self, material: Any) -> Self:
        """With the material's shininess, where it has none of its own."""
        return replace(self, shininess=Phong(self.shininess).of(material).shininess)

    def extremes(self, field: str, low: float, high: float) -> tuple[Self, ...]:
        """Phong's."""
        return tuple(replace(self, shininess=each.shininess) for each in Phong().extremes(field, low, high))

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Lambert's, and the highlight in the metal's colour and in white."""
        tinted = HIGHLIGHT._replace(is_own=True, color=rgb(self.color))
        return LAMBERT, tinted, HIGHLIGHT._replace(is_own=True)

    def stand_in(self, material: Any) -> tuple[str, Any] | None:
        """Phong's highlight in the metal's colour, also where light grazes it."""
        return "Phong for Metal", replace(material, specular=self.color, reflectance=Phong(self.shininess))

    def factors(self, surface: Surface, arrival: Arrival, wanted: Sequence[bool]) -> tuple[Any, ...]:
        """Phong's, parted by Schlick's."""
        diffuse, highlight = Phong(self.shininess).factors(surface, arrival, (True, any(wanted[1:])))
        if not any(wanted[1:]):
            return diffuse, 0.0, 0.0
        white = highlight * whiteness(surface, arrival.direction)
        return diffuse, highlight - white, white

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """Lambert's alone."""
        return Phong(self.shininess).forms[0], None, None

    @property
    def sharpness(self) -> float:
        """The shininess."""
        return self.shininess or 0.0

    def change(self, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:
        """Phong's, and Schlick's."""
        change = Phong(self.shininess).change(min(lobe, 1), turn, psi, light_moves=light_moves)
        return min(change + WHITENESS_SLOPE * turn, 1.0) if lobe else change

    def most(self, lobe: int, sightline: Sightline) -> float:
        """Phong's, times the largest part that is white."""
        white = most_whiteness(sightline.psi) if lobe == 2 else 1.0
        return Phong(self.shininess).most(min(lobe, 1), sightline) * white

    def parameters(self) -> tuple[float, ...]:
        """For the power."""
        return Phong(self.shininess).parameters()

    def stage(self, toolkit: Any, wanted: Sequence[bool]) -> Callable[..., Any] | None:
        """Phong's, parted by Schlick's."""
        return _stage(toolkit) if any(wanted[1:]) else toolkit.only_lambert

    def chords(self, n: FloatArray, l: FloatArray, v: FloatArray) -> FloatArray:
        """Mirror direction minus viewer."""
        return Phong(self.shininess).chords(n, l, v)


def part_of_light(name: str, value: Any) -> Color:
    """A checked colour of at most 1 in each channel."""
    color = check.color(name, value)
    if max(rgb(color)) > 1.0:
        check.refuse(name, value, "a part of the light, at most 1 in each channel", "Divide 0-255 values by 255.")
    return color


def _stage(toolkit: Any) -> Callable[..., Any]:
    def metal(numbers: Any, rows: Any, _points: Any) -> int:
        dark, half, least = toolkit.like(rows, numbers[2]), toolkit.like(rows, 0.5), toolkit.like(rows, 2.0**-80)
        shines = False
        for i in range(toolkit.BLOCK):
            n_l, middle, chord = toolkit.mirror_chord(rows, i)
            rows[toolkit.FIRST + i] = max(n_l, toolkit.ZERO)
            rows[toolkit.SECOND + i] = chord
            rows[toolkit.THIRD + i] = middle
            shines = shines | ((n_l > toolkit.ZERO) & (chord < dark))
        if not shines:
            return 1
        toolkit.raise_second(rows, numbers[0], numbers[1], numbers[2])
        for i in range(toolkit.BLOCK):
            highlight = rows[toolkit.SECOND + i]
            highlight = (
                highlight if highlight > least else toolkit.ZERO
            )  # less may be no normal number once it is parted
            rest = max(toolkit.ONE - half * toolkit.root(rows[toolkit.THIRD + i]), toolkit.ZERO)
            white = highlight * (((rest * rest) * (rest * rest)) * rest)
            rows[toolkit.SECOND + i] = highlight - white
            rows[toolkit.THIRD + i] = white
        return 7

    return metal
