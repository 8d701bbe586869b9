"""Reflection back to the light, as of road signs and safety vests."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pvphong.base.types import FloatArray
from pvphong.optics.light import Arrival
from pvphong.optics.reflectance import Lobe, Sightline
from pvphong.optics.reflectances.highlight import power, square
from pvphong.optics.reflectances.modified_phong import normalisation, normalised_change
from pvphong.optics.reflectances.shiny import HIGHLIGHT, LAMBERT, Shiny, lambert, power_numbers
from pvphong.optics.spherical import CosinePower
from pvphong.optics.surface import Surface


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

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Lambert's, and the highlight."""
        return LAMBERT, HIGHLIGHT._replace(largest=normalisation(self.sharpness))

    def factors(self, surface: Surface, arrival: Arrival, wanted: Sequence[bool]) -> tuple[Any, ...]:
        """By the chord between the ways to light and viewer."""
        diffuse = lambert(surface.raw_cosine(arrival) * surface.inverse_length)
        if not wanted[1]:
            return diffuse, 0.0
        real = diffuse.dtype.type
        distance = real(0.5) * square(arrival.direction - surface.to_viewer)
        distance = np.broadcast_to(distance, diffuse.shape).copy()
        shininess = surface.given("shininess", self.sharpness)
        return diffuse, diffuse * power(distance, shininess, 0.0) * np.asarray(normalisation(shininess), real)

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

    def parameters(self) -> tuple[float, ...]:
        """For the power, and what it is multiplied by."""
        return (*power_numbers(self.sharpness, 0.0), normalisation(self.sharpness))

    def stage(self, toolkit: Any, wanted: Sequence[bool]) -> Callable[..., Any] | None:
        """By the chord between the ways to light and viewer."""
        return _stage(toolkit) if wanted[1] else toolkit.only_lambert

    def chords(self, n: FloatArray, l: FloatArray, v: FloatArray) -> FloatArray:  # noqa: ARG002 for any normal
        """Way to the light minus way to the viewer."""
        return l - v


def _stage(toolkit: Any) -> Callable[..., Any]:
    def retro(numbers: Any, rows: Any, _points: Any) -> int:
        dark, scale = toolkit.like(rows, numbers[2]), toolkit.like(rows, numbers[3])
        shines = False
        for i in range(toolkit.BLOCK):
            dx, dy, dz = rows[toolkit.DX + i], rows[toolkit.DY + i], rows[toolkit.DZ + i]
            inverse = rows[toolkit.NEARNESS + i]
            n_l = toolkit.normal_dot(rows, i, dx, dy, dz) * (inverse * rows[toolkit.INVERSE + i])
            chord = toolkit.square_of(
                dx * inverse - rows[toolkit.VX + i],
                dy * inverse - rows[toolkit.VY + i],
                dz * inverse - rows[toolkit.VZ + i],
            )
            rows[toolkit.FIRST + i] = max(n_l, toolkit.ZERO)
            rows[toolkit.SECOND + i] = chord
            shines = shines | ((n_l > toolkit.ZERO) & (chord < dark))
        if not shines:
            return 1
        toolkit.raise_second(rows, numbers[0], numbers[1], numbers[2])
        for i in range(toolkit.BLOCK):
            rows[toolkit.SECOND + i] *= rows[toolkit.FIRST + i] * scale
        return 3

    return retro
