"""Phong's reflection made into one that conserves energy and is reciprocal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from pvphong.base.float_range import BRIGHTEST
from pvphong.base.formulas import ZERO, formula, maximum
from pvphong.optics.reflectance import HIGHLIGHT, LAMBERT, Geometry, Lobe, Sightline
from pvphong.optics.reflectances.highlight import MIRROR, Shiny, largest_power, steepness
from pvphong.optics.spherical import CosinePower


@formula
def normalised_highlight(own: Any, at: Geometry, highlight: Any) -> Any:
    """max(n·l, 0), and that times a highlight times the one number."""
    n_l = maximum(at.n_l, ZERO)
    return n_l, n_l * highlight * own[0]


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

    peak: ClassVar = MIRROR
    factors = staticmethod(normalised_highlight)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Lambert's, and the highlight."""
        return LAMBERT, HIGHLIGHT._replace(largest=normalisation(self.sharpness))

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

    def parameters(self, maps: Mapping[str, Any]) -> tuple[Any, ...]:
        """What the power is multiplied by."""
        return (normalisation(maps.get("shininess", self.sharpness)),)


def normalisation(shininess: Any) -> Any:
    """(s + 2)/2, with which the lobe around a direction reflects all light at normal incidence."""
    return np.minimum(0.5 * shininess + 1.0, BRIGHTEST)


def normalised_change(shininess: float, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:  # noqa: ARG001 for any ψ
    """The largest change of a power times n·l and `normalisation`: both fall to 0 at the horizon, so nothing jumps."""
    slope = steepness(shininess) if lobe else 0.0
    change = (slope + light_moves) * turn
    return min(change, 1.0) * (normalisation(shininess) if lobe else 1.0) if change else 0.0
