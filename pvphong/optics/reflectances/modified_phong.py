"""Phong's reflection made into one that conserves energy and is reciprocal."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pvphong.base.float_range import BRIGHTEST
from pvphong.base.types import FloatArray
from pvphong.base.vectors import dot
from pvphong.optics.light import Arrival
from pvphong.optics.reflectance import Lobe, Sightline
from pvphong.optics.reflectances.highlight import largest_power, mirror_distance, power, steepness
from pvphong.optics.reflectances.shiny import HIGHLIGHT, LAMBERT, Shiny, lambert, power_numbers
from pvphong.optics.spherical import CosinePower
from pvphong.optics.surface import Surface


@dataclass(frozen=True)
class ModifiedPhong(Shiny):
    """max(n·l, 0), and (s + 2)/2 · max(r·v, 0)ˢ · max(n·l, 0), s the shininess (Lafortune and Willems 1994).

    As it spreads the same light over a wider or narrower highlight, a shinier one is brighter. It is reciprocal, and
    reflects no more than all light where diffuse and specular together are at most 1.

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
    E. Lafortune, Y. Willems: Using the modified Phong reflectance model for physically based rendering (1994),
    equations 3 and 4, times π: a light of intensity 1 that faces a white surface makes it 1.
    """

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Lambert's, and the highlight."""
        return LAMBERT, HIGHLIGHT._replace(largest=normalisation(self.sharpness))

    def factors(self, surface: Surface, arrival: Arrival, wanted: Sequence[bool]) -> tuple[Any, ...]:
        """By the chord between mirror direction and viewer."""
        raw_n_l = surface.raw_cosine(arrival)
        diffuse = lambert(raw_n_l * surface.inverse_length)
        if not wanted[1]:
            return diffuse, 0.0
        shininess = surface.given("shininess", self.sharpness)
        highlight = power(mirror_distance(surface, arrival.direction, raw_n_l), shininess, 0.0)
        return diffuse, diffuse * highlight * np.asarray(normalisation(shininess), diffuse.dtype)

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """Lambert's alone: the highlight is more than a power."""
        return super().forms[0], None

    def change(self, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:
        """See `normalised_change`."""
        return normalised_change(self.sharpness, lobe, turn, psi, light_moves=light_moves)

    def most(self, lobe: int, sightline: Sightline) -> float:
        """As Phong's, times n·l."""
        theta, phi, psi = sightline
        if lobe == 0:
            return 1.0
        n_l = max(math.cos(theta), 0.0)
        cosine = 2.0 * n_l * max(math.cos(phi), 0.0) - math.cos(psi)
        return n_l * largest_power(cosine, self.sharpness, 0.0) * normalisation(self.sharpness)

    def parameters(self) -> tuple[float, ...]:
        """For the power, and what it is multiplied by."""
        return (*power_numbers(self.sharpness, 0.0), normalisation(self.sharpness))

    def stage(self, toolkit: Any, wanted: Sequence[bool]) -> Callable[..., Any] | None:
        """Phong's, and the product."""
        return _stage(toolkit) if wanted[1] else toolkit.only_lambert

    def chords(self, n: FloatArray, l: FloatArray, v: FloatArray) -> FloatArray:
        """Mirror direction minus viewer."""
        return 2.0 * dot(n, l) * n - l - v


def normalisation(shininess: Any) -> Any:
    """(s + 2)/2, with which the lobe around a direction reflects all light at normal incidence."""
    return np.minimum(0.5 * shininess + 1.0, BRIGHTEST)


def normalised_change(shininess: float, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:  # noqa: ARG001 for any ψ
    """The largest change of a power times n·l and `normalisation`: both fall to 0 at the horizon, so nothing jumps."""
    slope = steepness(shininess) if lobe else 0.0
    change = (slope + light_moves) * turn
    return min(change, 1.0) * (normalisation(shininess) if lobe else 1.0) if change else 0.0


def _stage(toolkit: Any) -> Callable[..., Any]:
    def modified_phong(numbers: Any, rows: Any, _points: Any) -> int:
        dark, scale = toolkit.like(rows, numbers[2]), toolkit.like(rows, numbers[3])
        shines = False
        for i in range(toolkit.BLOCK):
            n_l, _, chord = toolkit.mirror_chord(rows, i)
            rows[toolkit.FIRST + i] = max(n_l, toolkit.ZERO)
            rows[toolkit.SECOND + i] = chord
            shines = shines | ((n_l > toolkit.ZERO) & (chord < dark))
        if not shines:
            return 1
        toolkit.raise_second(rows, numbers[0], numbers[1], numbers[2])
        for i in range(toolkit.BLOCK):
            rows[toolkit.SECOND + i] *= rows[toolkit.FIRST + i] * scale
        return 3

    return modified_phong
