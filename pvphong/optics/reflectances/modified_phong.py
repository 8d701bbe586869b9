"""Phong's reflection made into one that conserves energy and is reciprocal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from pvphong.base.formulas import BRIGHTEST, HALF, ONE, ZERO, formula, like, maximum, minimum
from pvphong.optics.reflectance import Geometry
from pvphong.optics.reflectances.highlight import Shiny, own_shininess
from pvphong.optics.reflectances.phong import MIRROR


@formula
def _normalised_highlight(own: Any, at: Geometry, highlight: Any) -> Any:
    """max(n·l, 0), and that times a highlight times the one number."""
    n_l = maximum(at.n_l, ZERO)
    return n_l, n_l * highlight * own[0]


@formula
def _scale_of(shininess: Any, own: Any) -> Any:  # noqa: ARG001 there are no others
    """(s + 2)/2, with which the highlight around a direction reflects all light at normal incidence."""
    return (minimum(HALF * shininess + ONE, like(shininess, BRIGHTEST)),)


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

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> material = ph.Material(specular=0.5, reflectance=ph.ModifiedPhong(shininess=40))
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight(), material)
    """

    shininess: float | None = own_shininess()

    peak: ClassVar = MIRROR
    factors = staticmethod(_normalised_highlight)

    mapped = staticmethod(_scale_of)

    def parameters(self, maps: Mapping[str, Any]) -> tuple[Any, ...]:
        """The scale of the highlight."""
        scale: tuple[Any, ...] = _scale_of(np.asarray(maps.get("shininess", self.sharpness)), ())
        return scale
