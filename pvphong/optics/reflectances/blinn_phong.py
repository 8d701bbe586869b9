"""Blinn's form of Phong's reflection: a highlight around the half-way direction."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from pvphong.base.types import FloatArray
from pvphong.base.vectors import unit
from pvphong.optics.light import Arrival
from pvphong.optics.reflectance import Sightline
from pvphong.optics.reflectances.highlight import halfway_change, halfway_distance, largest_power, power
from pvphong.optics.reflectances.shiny import LIKENESS, Shiny, lambert, power_numbers, shown
from pvphong.optics.surface import Surface


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

    counterpart: ClassVar[tuple[str, float]] = ("phong", 1.0 / LIKENESS)

    def factors(self, surface: Surface, arrival: Arrival, wanted: Sequence[bool]) -> tuple[Any, ...]:
        """By the chord between half-way direction and normal."""
        n_l = surface.raw_cosine(arrival) * surface.inverse_length
        diffuse = lambert(n_l)
        if not wanted[1]:
            return diffuse, 0.0
        shininess = surface.given("shininess", self.sharpness)
        return diffuse, shown(power(halfway_distance(surface, arrival.direction), shininess, 0.0), n_l)

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

    def parameters(self) -> tuple[float, ...]:
        """For the power: see `power_numbers`."""
        return power_numbers(self.sharpness, 0.0)

    def stage(self, toolkit: Any, wanted: Sequence[bool]) -> Callable[..., Any] | None:
        """By the chord between half-way direction and normal."""
        return _stage(toolkit) if wanted[1] else toolkit.only_lambert

    def chords(self, n: FloatArray, l: FloatArray, v: FloatArray) -> FloatArray:
        """Half-way direction minus normal."""
        return unit(l + v)[0] - n


def _stage(toolkit: Any) -> Callable[..., Any]:
    """max(n·l, 0), and a power of the chord C = h − n; |C|² is 2 where l = −v and there is no h.

    l + v is scaled by a power of two, which makes room for its square where they are nearly opposite.
    """

    def blinn_phong(numbers: Any, rows: Any, _points: Any) -> int:
        dark, larger = toolkit.like(rows, numbers[2]), toolkit.like(rows, 2.0**60)
        shines = False
        for i in range(toolkit.BLOCK):
            nx, ny, nz = rows[toolkit.NX + i], rows[toolkit.NY + i], rows[toolkit.NZ + i]
            dx, dy, dz = rows[toolkit.DX + i], rows[toolkit.DY + i], rows[toolkit.DZ + i]
            shrink, inverse = rows[toolkit.INVERSE + i], rows[toolkit.NEARNESS + i]
            n_l = toolkit.dot(nx, ny, nz, dx, dy, dz) * (inverse * shrink)
            hx = toolkit.multiply_add(dx, inverse, rows[toolkit.VX + i]) * larger
            hy = toolkit.multiply_add(dy, inverse, rows[toolkit.VY + i]) * larger
            hz = toolkit.multiply_add(dz, inverse, rows[toolkit.VZ + i]) * larger
            square = toolkit.square_of(hx, hy, hz)
            unit_length = toolkit.inverse_root(square)
            chord = toolkit.square_of(
                hx * unit_length - nx * shrink,
                hy * unit_length - ny * shrink,
                hz * unit_length - nz * shrink,
            )
            chord = chord if square > toolkit.ZERO_SQUARE else toolkit.TWO
            rows[toolkit.FIRST + i] = max(n_l, toolkit.ZERO)
            rows[toolkit.SECOND + i] = chord
            shines = shines | ((n_l > toolkit.ZERO) & (chord < dark))
        if not shines:
            return 1
        toolkit.raise_second(rows, numbers[0], numbers[1], numbers[2])
        return 3

    return blinn_phong
