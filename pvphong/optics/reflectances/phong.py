"""Phong's reflection: diffuse, and a highlight around the mirror direction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from pvphong.base.formulas import Power
from pvphong.optics.reflectance import Sightline
from pvphong.optics.reflectances.highlight import LIKENESS, MIRROR, Shiny, largest_power, mirror_change
from pvphong.optics.spherical import CosinePower


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

    peak: ClassVar = MIRROR
    counterpart: ClassVar[tuple[str, float]] = ("blinn-phong", LIKENESS)

    def power(self, maps: Mapping[str, Any]) -> Power:
        """The shininess, and VTK's floor."""
        return Power(maps.get("shininess", self.sharpness), self.floor)

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
