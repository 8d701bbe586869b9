"""Phong's reflection: diffuse, and a highlight around the mirror direction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from pvphong.base.types import FloatArray
from pvphong.base.vectors import dot
from pvphong.optics.light import Arrival
from pvphong.optics.reflectance import Lobe, Reflectance, Sightline
from pvphong.optics.reflectances.highlight import largest_power, mirror_change, mirror_distance, power
from pvphong.optics.surface import Surface

MATT_AND_SHINY = (
    Lobe("diffuse", takes_albedo=True, needs_viewer=False),
    Lobe("specular", takes_albedo=False, needs_viewer=True),
)
"""Lambert's cosine, and a highlight."""

LIKENESS = 4.0
"""Blinn-Phong needs about this many times the shininess for the same highlight; see `Material.for_blinn_phong`."""


@dataclass(frozen=True)
class Phong(Reflectance):
    """max(n·l, 0), and max(r·v, 0)ⁿ where n·l > 0, with r = 2(n·l)n − l (Phong 1975). Not reciprocal.

    Parameters
    ----------
    shininess : float, optional
        The exponent n; the material's if not given.
    floor : float, default 0
        The cosine r·v is taken to be at least this, as VTK's shader does.
    """

    shininess: float | None = None
    floor: float = 0.0

    lobes: ClassVar[tuple[Lobe, ...]] = MATT_AND_SHINY
    counterpart: ClassVar[tuple[str, float]] = ("blinn-phong", LIKENESS)

    def of(self, shininess: float) -> Phong:
        """With the material's shininess."""
        return replace(self, shininess=shininess) if self.shininess is None else self

    @property
    def sharpness(self) -> float:
        """The shininess."""
        return self.shininess or 0.0

    def factors(self, surface: Surface, arrival: Arrival, wanted: Sequence[bool]) -> tuple[Any, ...]:
        """By the chord between mirror direction and viewer."""
        raw_n_l = surface.raw_cosine(arrival)
        n_l = raw_n_l * surface.inverse_length
        diffuse = lambert(n_l)
        if not wanted[1]:
            return diffuse, 0.0
        return diffuse, shown(
            power(mirror_distance(surface, arrival.direction, raw_n_l), self.sharpness, self.floor), n_l
        )

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

    def chords(self, n: FloatArray, l: FloatArray, v: FloatArray) -> FloatArray:
        """Mirror direction minus viewer."""
        return np.asarray(2.0 * dot(n, l) * n - l - v)


def lambert(n_l: Any) -> Any:
    """max(n·l, 0)."""
    return np.maximum(n_l, n_l.dtype.type(0.0))


def shown(highlight: Any, n_l: Any) -> Any:
    """A highlight where n·l is positive, else 0."""
    return highlight * (n_l > 0.0)
