"""Rough diffuse reflection, as of clay, plaster or the moon."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from pvphong.base import check
from pvphong.base.formulas import ONE, ZERO, dot, formula, maximum, minimum, select
from pvphong.optics.reflectance import Geometry, Lobe, Reflectance


@formula
def _rough_diffuse(own: Any, at: Geometry, highlight: Any) -> Any:  # noqa: ARG001 it has none
    """Return the factor of the diffuse lobe: cos θ · (A + B · max(cos φ, 0) · sin α · tan β).

    The docstring of `OrenNayar` defines the angles. Only their cosines are computed: cos φ sin α sin β = l·v −
    (n·l)(n·v), and cos β is the greater of n·l and n·v. `own` has A and B, and `at` the directions at a vertex.
    `highlight` is not read, because there is no highlight.
    """
    a, b = own[0], own[1]
    n_l = maximum(at.n_l, ZERO)
    along = maximum(dot(at.l, at.v) - n_l * at.n_v, ZERO)
    steepest = maximum(n_l, at.n_v)
    tangent = select(steepest > ZERO, along / steepest, ZERO)
    # sin α tan β is unbounded where both are grazing, but its product with n·l is at most 1
    return (n_l * a + b * minimum(n_l * tangent, ONE),)


@dataclass(frozen=True)
class OrenNayar(Reflectance):
    """Rough diffuse surface of small Lambertian facets in all orientations, without a highlight.

    The qualitative model of Oren and Nayar, "Generalization of Lambert's reflectance model" (1994), equation 30. With
    θ the angle from n to l, α the greater and β the smaller of the angles from n to l and to v, and φ the angle between
    l and v around n, the reflection is cos θ · (A + B · max(cos φ, 0) · sin α · tan β). The reflection is reciprocal,
    apart from the factor cos θ, which every reflectance has. At grazing angles, a white surface reflects up to 1.5 %
    more light than arrives; sigma = 10 is the worst case.

    Parameters
    ----------
    sigma : float
        Standard deviation of the facets' slopes, in degrees, 0 to 90; 0 is Lambert's reflection, 20 is clay.

    Raises
    ------
    ValueError
        If `sigma` is out of range.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> material = ph.Material(reflectance=ph.OrenNayar(sigma=30))
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight(), material)
    """

    sigma: float = check.field(partial(check.number, at_least=0.0, at_most=90.0), unit="°")

    lobes = (Lobe("diffuse", takes_albedo=True, needs_viewer=True),)
    factors = staticmethod(_rough_diffuse)

    def parameters(self, maps: Mapping[str, Any]) -> tuple[float, float]:  # noqa: ARG002 it has no maps
        """Return the coefficients A and B of the formula; no field may be a map, so `maps` is not read."""
        variance = math.radians(self.sigma) ** 2
        return 1.0 - 0.5 * variance / (variance + 0.33), 0.45 * variance / (variance + 0.09)
