"""VTK's reading of Phong's reflection (vtkOpenGLPolyDataMapper::ReplaceShaderLight)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from pvphong.base.types import FloatArray
from pvphong.optics.light import Arrival
from pvphong.optics.reflectance import Lobe, Reflectance
from pvphong.optics.reflectances.highlight import mirror_change, power, square
from pvphong.optics.reflectances.phong import Phong
from pvphong.optics.reflectances.shiny import HIGHLIGHT, LAMBERT, Shiny, power_numbers
from pvphong.optics.spherical import CosinePower
from pvphong.optics.surface import Surface

HIGHEST_POWER = 128.0
"""vtkProperty and vtkLight keep exponents in [0, 128]."""

# The shader cuts cosines off at these; the second one is its first tier's.
_FLOOR, _HEADLIGHT_FLOOR = 1e-5, 1e-6


def vtk_reflectance(shininess: float, *, is_headlight: bool) -> Reflectance:
    """What the shader computes in its first tier, for a headlight alone, or in the others."""
    shininess = min(shininess, HIGHEST_POWER)
    return VtkHeadlight(shininess) if is_headlight else Phong(shininess, _FLOOR)


@dataclass(frozen=True)
class VtkHeadlight(Shiny):
    """c and cⁿ with c = max(n·l, 1e-6): the shader's first tier; 0 without a normal.

    Parameters
    ----------
    shininess : float
        The exponent n.
    """

    floor: ClassVar[float] = _HEADLIGHT_FLOOR

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Neither needs the viewer."""
        return LAMBERT, HIGHLIGHT._replace(needs_viewer=False)

    def factors(self, surface: Surface, arrival: Arrival, wanted: Sequence[bool]) -> tuple[Any, ...]:  # noqa: ARG002
        """By the chord between normal and light."""
        real = surface.raw.dtype.type
        n_l = surface.raw_cosine(arrival) * surface.inverse_length
        is_there = surface.inverse_length > 0.0  # the floor is not for a normal that is not there
        distance = real(0.5) * square(surface.normals - arrival.direction)
        highlight = power(distance, self.sharpness, self.floor)
        return np.maximum(n_l, real(self.floor)) * is_there, highlight * is_there

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """None: both have a floor."""
        return None, None

    def change(self, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:
        """As Phong's; this tier's light has no position, and is never turned."""
        if lobe == 0:
            return turn if light_moves else 0.0
        return mirror_change(self.sharpness, self.floor, turn, psi, light_moves=light_moves)

    def parameters(self) -> tuple[float, ...]:
        """For the power, and the floor."""
        return (*power_numbers(self.sharpness, self.floor), self.floor)

    def stage(self, toolkit: Any, wanted: Sequence[bool]) -> Callable[..., Any] | None:  # noqa: ARG002 they are one
        """By the chord between normal and light."""
        return _headlight(toolkit)

    def chords(self, n: FloatArray, l: FloatArray, v: FloatArray) -> FloatArray:  # noqa: ARG002 no viewer
        """Light minus normal."""
        return l - n


def _headlight(toolkit: Any) -> Callable[..., Any]:
    """max(n·l, floor), but 0 where there is no n, and a power of the chord C = n − l."""

    def headlight(numbers: Any, rows: Any, _points: Any) -> int:
        floor = toolkit.like(rows, numbers[3])
        for i in range(toolkit.BLOCK):
            nx, ny, nz = rows[toolkit.NX + i], rows[toolkit.NY + i], rows[toolkit.NZ + i]
            dx, dy, dz = rows[toolkit.DX + i], rows[toolkit.DY + i], rows[toolkit.DZ + i]
            shrink, inverse = rows[toolkit.INVERSE + i], rows[toolkit.NEARNESS + i]
            n_l = max(toolkit.dot(nx, ny, nz, dx, dy, dz) * (inverse * shrink), floor)
            rows[toolkit.FIRST + i] = n_l if toolkit.square_of(nx, ny, nz) > toolkit.ZERO else toolkit.ZERO
            rows[toolkit.SECOND + i] = toolkit.square_of(
                nx * shrink - dx * inverse,
                ny * shrink - dy * inverse,
                nz * shrink - dz * inverse,
            )
        toolkit.raise_second(rows, numbers[0], numbers[1], numbers[2])
        return 3

    return headlight
