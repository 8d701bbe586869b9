"""Blinn's form of Phong's reflection: a highlight around the half-way direction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from pvphong.base.types import FloatArray
from pvphong.base.vectors import unit
from pvphong.optics.light import Arrival
from pvphong.optics.reflectance import Lobe, Reflectance, Sightline
from pvphong.optics.reflectances.highlight import halfway_change, halfway_distance, largest_power, power
from pvphong.optics.reflectances.phong import LIKENESS, MATT_AND_SHINY, lambert, shown
from pvphong.optics.surface import Surface


@dataclass(frozen=True)
class BlinnPhong(Reflectance):
    """max(n·l, 0), and max(n·h, 0)ⁿ where n·l > 0, with h = (l + v)/|l + v| (Blinn 1977; OpenGL 2.1, 2.14.1).

    Parameters
    ----------
    shininess : float, optional
        The exponent n; the material's if not given.
    """

    shininess: float | None = None

    lobes: ClassVar[tuple[Lobe, ...]] = MATT_AND_SHINY
    counterpart: ClassVar[tuple[str, float]] = ("phong", 1.0 / LIKENESS)

    def of(self, shininess: float) -> BlinnPhong:
        """With the material's shininess."""
        return replace(self, shininess=shininess) if self.shininess is None else self

    @property
    def sharpness(self) -> float:
        """The shininess."""
        return self.shininess or 0.0

    def factors(self, surface: Surface, arrival: Arrival, wanted: Sequence[bool]) -> tuple[Any, ...]:
        """By the chord between half-way direction and normal."""
        n_l = surface.raw_cosine(arrival) * surface.inverse_length
        diffuse = lambert(n_l)
        if not wanted[1]:
            return diffuse, 0.0
        return diffuse, shown(power(halfway_distance(surface, arrival.direction), self.sharpness, 0.0), n_l)

    def change(self, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:
        """Lambert's cosine changes by no more than the turn."""
        if lobe == 0:
            return turn if light_moves else 0.0
        return halfway_change(self.sharpness, turn, psi, light_moves=light_moves)

    def most(self, lobe: int, sightline: Sightline) -> float:
        """With θ, φ and ψ, n·h = (cos θ + cos φ) / (2 cos ψ/2): it grows with smaller θ and φ and greater ψ."""
        theta, phi, psi = sightline
        if lobe == 0 or not self.sharpness:
            return 1.0
        if theta >= math.pi / 2:
            return 0.0
        middle = 2.0 * math.cos(psi / 2.0)
        cosine = (math.cos(theta) + math.cos(phi)) / middle if middle > 1e-6 else 1.0
        return largest_power(cosine, self.sharpness, 0.0)

    def chords(self, n: FloatArray, l: FloatArray, v: FloatArray) -> FloatArray:
        """Half-way direction minus normal."""
        return unit(l + v)[0] - n
