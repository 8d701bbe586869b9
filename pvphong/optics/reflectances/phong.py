"""Phong's reflection: diffuse, and a highlight around the mirror direction."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from pvphong.base.types import FloatArray
from pvphong.base.vectors import dot
from pvphong.optics.light import Arrival
from pvphong.optics.reflectance import Sightline
from pvphong.optics.reflectances.highlight import largest_power, mirror_change, mirror_distance, power
from pvphong.optics.reflectances.shiny import LIKENESS, Shiny, lambert, power_numbers, shown
from pvphong.optics.spherical import CosinePower
from pvphong.optics.surface import Surface


@dataclass(frozen=True)
class Phong(Shiny):
    """max(n·l, 0), and max(r·v, 0)ⁿ where n·l > 0, with r = 2(n·l)n − l (Phong 1975). Not reciprocal.

    Parameters
    ----------
    shininess : float, optional
        The exponent n, >= 0; the material's if not given.
    floor : float, default 0
        The cosine r·v is taken to be at least this, as VTK's shader does.

    Raises
    ------
    ValueError
        If the shininess is not such a number.
    """

    floor: float = 0.0

    counterpart: ClassVar[tuple[str, float]] = ("blinn-phong", LIKENESS)

    def factors(self, surface: Surface, arrival: Arrival, wanted: Sequence[bool]) -> tuple[Any, ...]:
        """By the chord between mirror direction and viewer."""
        raw_n_l = surface.raw_cosine(arrival)
        n_l = raw_n_l * surface.inverse_length
        diffuse = lambert(n_l)
        if not wanted[1]:
            return diffuse, 0.0
        shininess = surface.given("shininess", self.sharpness)
        return diffuse, shown(power(mirror_distance(surface, arrival.direction, raw_n_l), shininess, self.floor), n_l)

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """Lambert's cosine, and (r·v)ⁿ, which is (l·w)ⁿ for the mirrored v."""
        return super().forms[0], None if self.floor else CosinePower("mirror", self.sharpness)

    def change(self, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:
        """Lambert's cosine changes by no more than the turn."""
        if lobe == 0:
            return turn if light_moves else 0.0
        return mirror_change(self.sharpness, self.floor, turn, psi, light_moves=light_moves)

    def most(self, lobe: int, sightline: Sightline) -> float:
        """With θ, φ and ψ, r·v = 2 cos θ cos φ − cos ψ: it grows with smaller θ and φ and greater ψ."""
        if lobe == 0 or not self.sharpness:
            return 1.0
        theta, phi, psi = sightline
        if theta >= math.pi / 2:
            return 0.0
        return largest_power(
            2.0 * math.cos(theta) * max(math.cos(phi), 0.0) - math.cos(psi), self.sharpness, self.floor
        )

    def parameters(self) -> tuple[float, ...]:
        """For the power: see `power_numbers`."""
        return power_numbers(self.sharpness, self.floor)

    def stage(self, toolkit: Any, wanted: Sequence[bool]) -> Callable[..., Any] | None:
        """By the chord between mirror direction and viewer."""
        return _stage(toolkit) if wanted[1] else toolkit.only_lambert

    def chords(self, n: FloatArray, l: FloatArray, v: FloatArray) -> FloatArray:
        """Mirror direction minus viewer."""
        return np.asarray(2.0 * dot(n, l) * n - l - v)


def _stage(toolkit: Any) -> Callable[..., Any]:
    """max(n·l, 0), and a power of the chord C = 2(n·l)n − l − v."""

    def phong(numbers: Any, rows: Any, _points: Any) -> int:
        dark = toolkit.like(rows, numbers[2])
        shines = False
        for i in range(toolkit.BLOCK):
            n_l, _, chord = toolkit.mirror_chord(rows, i)
            rows[toolkit.FIRST + i] = max(n_l, toolkit.ZERO)
            rows[toolkit.SECOND + i] = chord
            shines = shines | ((n_l > toolkit.ZERO) & (chord < dark))
        if not shines:
            return 1
        toolkit.raise_second(rows, numbers[0], numbers[1], numbers[2])
        return 3

    return phong
