"""Rough diffuse reflection, as of clay, plaster or the moon."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import rgb
from pvphong.base.vectors import dot
from pvphong.optics.light import Arrival
from pvphong.optics.reflectance import Lobe, Reflectance
from pvphong.optics.reflectances.phong import Phong
from pvphong.optics.surface import Surface


@dataclass(frozen=True)
class OrenNayar(Reflectance):
    """A surface of small matt facets in all orientations, in place of Lambert's; it has no highlight.

    The qualitative model of Oren and Nayar, "Generalization of Lambert's reflectance model" (1994), equation 30. With
    α the greater and β the smaller of the angles from n to l and to v, and φ the angle between l and v around n, it is
    cos θ · (A + B · max(cos φ, 0) · sin α · tan β). It is reciprocal but for the cosine that every reflectance has. At
    a sigma of 10 and grazing angles a white surface reflects up to 1.5 % more than all light; more than that never.

    Parameters
    ----------
    sigma : float
        Standard deviation of the facets' slopes, in degrees, 0 to 90; 0 is Lambert's reflection, 20 is clay.

    Raises
    ------
    ValueError
        If `sigma` is out of range.
    """

    sigma: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "sigma", check.number("sigma", self.sigma, at_least=0.0, at_most=90.0))

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """A + B is at most 1.125, where sigma is 22°."""
        return (Lobe("diffuse", takes_albedo=True, needs_viewer=True, largest=1.13),)

    @property
    def coefficients(self) -> tuple[float, float]:
        """A and B."""
        variance = math.radians(self.sigma) ** 2
        return 1.0 - 0.5 * variance / (variance + 0.33), 0.45 * variance / (variance + 0.09)

    def stand_in(self, material: Any) -> tuple[str, Any] | None:
        """Lambert's cosine, that reflects as much in all: A + B (2/3 − 64/(45π))."""
        a, b = self.coefficients
        whole = a + b * (2.0 / 3.0 - 64.0 / (45.0 * math.pi))
        color = tuple(channel * whole for channel in rgb(material.diffuse))
        return "Lambert for Oren-Nayar", replace(material, diffuse=color, specular=0.0, reflectance=Phong())

    def factors(self, surface: Surface, arrival: Arrival, wanted: Sequence[bool]) -> tuple[Any, ...]:  # noqa: ARG002
        """With cos φ sin α sin β = l·v − (n·l)(n·v), and cos β the greater of n·l and n·v: no angle is computed."""
        n, l, v = surface.normals, arrival.direction, surface.to_viewer
        real = n.dtype.type
        a, b = map(real, self.coefficients)
        n_l = np.maximum(surface.raw_cosine(arrival) * surface.inverse_length, real(0.0))
        n_v = dot(n, v)
        along = np.maximum(dot(l, v) - n_l * n_v, real(0.0))
        steepest = np.maximum(n_l, n_v)
        tangent = np.divide(along, steepest, out=np.zeros_like(along), where=steepest > 0.0)
        # sin α tan β is unbounded where both are grazing, and n·l times it at most 1
        return (n_l * a + b * np.minimum(n_l * tangent, real(1.0)),)

    def change(self, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:  # noqa: ARG002 one lobe
        """Next to the horizon its second part has no bound on its slope, but it is never more than B."""
        a, b = self.coefficients
        return (a * turn if light_moves else 0.0) + b

    def parameters(self) -> tuple[float, ...]:
        """A and B."""
        return self.coefficients

    def stage(self, toolkit: Any, wanted: Sequence[bool]) -> Callable[..., Any] | None:  # noqa: ARG002 one lobe
        """As `factors`."""
        return _stage(toolkit)


def _stage(toolkit: Any) -> Callable[..., Any]:
    def oren_nayar(numbers: Any, rows: Any, _points: Any) -> int:
        a, b = toolkit.like(rows, numbers[0]), toolkit.like(rows, numbers[1])
        for i in range(toolkit.BLOCK):
            dx, dy, dz = rows[toolkit.DX + i], rows[toolkit.DY + i], rows[toolkit.DZ + i]
            inverse, shrink = rows[toolkit.NEARNESS + i], rows[toolkit.INVERSE + i]
            n_d = toolkit.normal_dot(rows, i, dx, dy, dz)
            l_v = toolkit.dot(rows[toolkit.VX + i], rows[toolkit.VY + i], rows[toolkit.VZ + i], dx, dy, dz) * inverse
            n_l = max(n_d * (inverse * shrink), toolkit.ZERO)
            n_v = rows[toolkit.FACING + i] * shrink
            along, steepest = max(l_v - n_l * n_v, toolkit.ZERO), max(n_l, n_v)
            tangent = along / steepest if steepest > toolkit.ZERO else toolkit.ZERO
            rows[toolkit.FIRST + i] = n_l * a + b * min(n_l * tangent, toolkit.ONE)
        return 1

    return oren_nayar
