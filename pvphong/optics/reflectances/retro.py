"""Reflection back to the light, as of road signs and safety vests."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from pvphong.optics.reflectance import HIGHLIGHT, LAMBERT, Lobe, Sightline
from pvphong.optics.reflectances.highlight import BACK, Shiny
from pvphong.optics.reflectances.modified_phong import normalisation, normalised_change, normalised_highlight
from pvphong.optics.spherical import CosinePower


@dataclass(frozen=True)
class Retro(Shiny):
    """max(n·l, 0), and (s + 2)/2 · max(l·v, 0)ˢ · max(n·l, 0), s the shininess: brightest where the light comes from.

    It is `ModifiedPhong` with the way to the light in place of the mirror direction: reciprocal, and no more than all
    light is reflected where diffuse and specular together are at most 1. A headlight shows all of it.

    Parameters
    ----------
    shininess : float, optional
        The exponent s, >= 0; the material's if not given.

    Raises
    ------
    ValueError
        If the shininess is not such a number.

    Notes
    -----
    The lobe around the way back is one of those of E. Lafortune, S.-C. Foo, K. Torrance, D. Greenberg: Non-linear
    approximation of reflectance functions (1997), section 4.
    """

    peak: ClassVar = BACK
    factors = staticmethod(normalised_highlight)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Lambert's, and the highlight."""
        return LAMBERT, HIGHLIGHT._replace(largest=normalisation(self.sharpness))

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """Lambert's alone."""
        return super().forms[0], None

    def change(self, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:
        """As for `ModifiedPhong`: the angle between l and v changes by no more than the turn."""
        return normalised_change(self.sharpness, lobe, turn, psi, light_moves=light_moves)

    def most(self, lobe: int, sightline: Sightline) -> float:
        """Nothing is known of the least angle from light to viewer."""
        return max(math.cos(sightline.theta), 0.0) * normalisation(self.sharpness) if lobe else 1.0

    def parameters(self, maps: Mapping[str, Any]) -> tuple[Any, ...]:
        """What the power is multiplied by."""
        return (normalisation(maps.get("shininess", self.sharpness)),)
