"""Phong's reflection, modified to conserve energy and to be reciprocal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from pvphong.base.formulas import BRIGHTEST, HALF, ONE, ZERO, as_type_of, formula, maximum, minimum
from pvphong.optics.reflectance import Geometry
from pvphong.optics.reflectances.highlight import Shiny, own_shininess
from pvphong.optics.reflectances.phong import MIRROR


@formula
def _normalised_highlight(own: Any, at: Geometry, highlight: Any) -> Any:
    """Return two factors: max(n·l, 0) for the diffuse lobe, and max(n·l, 0) · `highlight` · own[0] for the highlight.

    `highlight` is the power max(r·v, 0)ˢ, and own[0] is the result of `_scale_of`. `at` has the directions at a vertex.
    """
    n_l = maximum(at.n_l, ZERO)
    return n_l, n_l * highlight * own[0]


@formula
def _scale_of(shininess: Any, own: Any) -> Any:  # noqa: ARG001 there are no others
    """Return (s + 2)/2 for the shininess s, as a tuple of one number, limited to `BRIGHTEST`.

    The highlight is multiplied by this number, so that at normal incidence it reflects all light. `own`, the parameters
    for a material without a map of the shininess, is not read.
    """
    return (minimum(HALF * shininess + ONE, as_type_of(shininess, BRIGHTEST)),)


@dataclass(frozen=True)
class ModifiedPhong(Shiny):
    """Modified Phong reflection: diffuse max(n·l, 0), and a highlight (s + 2)/2 · max(r·v, 0)ˢ · max(n·l, 0).

    s is the shininess, and r the mirror direction (Lafortune and Willems 1994). The highlight is normalised: a shinier
    one is narrower and brighter. The reflection is reciprocal, and conserves energy if diffuse and specular together
    are at most 1.

    Parameters
    ----------
    shininess : float, optional
        Exponent s, >= 0; defaults to the material's.

    Raises
    ------
    ValueError
        If the shininess is out of range.

    Notes
    -----
    E. Lafortune, Y. Willems: Using the modified Phong reflectance model for physically based rendering (1994),
    equations 3 and 4, times π: a light of intensity 1 that faces a white surface gives it the colour 1.

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
        """Return (s + 2)/2, the factor of the highlight, for the shininess s or for a map of it in `maps`."""
        scale: tuple[Any, ...] = _scale_of(np.asarray(maps.get("shininess", self.sharpness)), ())
        return scale
