"""Blinn's form of Phong's reflection: a highlight around the half-way direction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from pvphong.optics.reflectance import Sightline
from pvphong.optics.reflectances.highlight import (
    HALFWAY,
    LIKENESS,
    Shiny,
    halfway_change,
    largest_halfway,
    largest_power,
)


@dataclass(frozen=True)
class BlinnPhong(Shiny):
    """max(n·l, 0), and max(n·h, 0)ⁿ where n·l > 0, with h = (l + v)/|l + v| (Blinn 1977; OpenGL 2.1, 2.14.1).

    Parameters
    ----------
    shininess : float, optional
        The exponent n, >= 0; the material's if not given.

    Raises
    ------
    ValueError
        If the shininess is not such a number.
    """

    peak: ClassVar = HALFWAY
    counterpart: ClassVar[tuple[str, float]] = ("phong", 1.0 / LIKENESS)

    def change(self, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:
        """Lambert's cosine changes by no more than the turn."""
        if lobe == 0:
            return turn if light_moves else 0.0
        return halfway_change(self.sharpness, turn, psi, light_moves=light_moves)

    def most(self, lobe: int, sightline: Sightline) -> float:
        """At the largest n·h."""
        theta, phi, psi = sightline
        if lobe == 0 or not self.sharpness:
            return 1.0
        if theta >= math.pi / 2:
            return 0.0
        return largest_power(largest_halfway(theta, phi, psi), self.sharpness, 0.0)
