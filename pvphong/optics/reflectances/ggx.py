"""Rough glass, lacquer and metal: microfacets with the Trowbridge-Reitz distribution, known as GGX.

`microfacets.py` has the formula of the highlight.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pvphong.base import check
from pvphong.base.formulas import ONE, formula
from pvphong.base.types import ColorLike, Vector, rgb
from pvphong.optics.reflectance import HIGHLIGHT, Lobe
from pvphong.optics.reflectances.highlight import part_of_light
from pvphong.optics.reflectances.microfacets import ROUGHNESS, Microfacets, alpha_of, coupled


@formula
def _same_roughness(roughness: Any, own: Any) -> Any:
    """Return the parameters of `Microfacets` for a roughness, with β = α in the masking.

    `own` has parameters for another roughness; those that do not depend on the roughness are copied.
    """
    alpha = alpha_of(roughness)
    square = alpha * alpha
    return alpha, square, ONE - square, square, ONE - square, own[5], own[6], own[7]


@dataclass(frozen=True)
class GGX(Microfacets):
    """Highlight of microfacets that shadow and mask each other, over a diffuse base.

    The highlight is D·K·F as in `pvphong.optics.reflectances.microfacets`, for α = β = roughness². It has its own
    colour: the material's `specular` is not read. The base is the material's `diffuse`, reduced by the light that the
    highlight reflects (Ashikhmin and Shirley 2000). Highlight and base are reciprocal. If `diffuse` is at most 1, the
    surface never reflects more light than arrives; rough surfaces lose some, because light that bounces between facets
    is not counted. For a metal, `diffuse` should be 0.

    Parameters
    ----------
    roughness : float
        0 < roughness <= 1: 0.1 is polished, 0.5 satin, 1 matt.
    f0 : color, default 0.04
        Reflectance at normal incidence, from 0 to 1: 0.04 for glass, plastic and paint; the metal's colour for a metal.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> material = ph.Material(reflectance=ph.GGX(roughness=0.3))
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight(), material)
    """

    roughness: float = check.field(ROUGHNESS)
    f0: ColorLike = check.field(part_of_light, 0.04)

    factors = staticmethod(coupled)
    mapped = staticmethod(_same_roughness)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """The lobe of the base, and the highlight in two lobes: in the colour of `f0`, and in white."""
        red, green, blue = rgb(self.f0)
        left: Vector = (1.0 - red, 1.0 - green, 1.0 - blue)
        base = Lobe("diffuse", takes_albedo=True, needs_viewer=True, color=left)
        return base, HIGHLIGHT._replace(is_own=True, color=(red, green, blue)), HIGHLIGHT._replace(is_own=True)
