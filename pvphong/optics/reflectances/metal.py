"""Phong's reflection for metals: the highlight has the metal's colour, and is white at grazing angles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from pvphong.base import check
from pvphong.base.formulas import ZERO, as_type_of, formula, select
from pvphong.base.types import ColorLike, rgb
from pvphong.optics.reflectance import HIGHLIGHT, LAMBERT, Geometry, Lobe
from pvphong.optics.reflectances.highlight import (
    Shiny,
    lambert_and_highlight,
    own_shininess,
    part_of_light,
    whiteness,
)
from pvphong.optics.reflectances.phong import MIRROR


@formula
def _parted_highlight(own: Any, at: Geometry, highlight: Any) -> Any:
    """Return the factors of three lobes: diffuse, highlight in the metal's colour, and white highlight.

    The diffuse factor is max(n·l, 0). `highlight` is the power max(r·v, 0)ˢ; where n·l > 0, the factors of the two
    highlights add up to this power. `at` has the directions at a vertex. `own` is not read.
    """
    n_l, shine = lambert_and_highlight(own, at, highlight)
    # the two parts of a smaller highlight may be subnormal
    shine = select(shine > as_type_of(shine, 2.0**-80), shine, ZERO)
    white = shine * whiteness(at)
    return n_l, shine - white, white


@dataclass(frozen=True)
class Metal(Shiny):
    """Phong's reflection with a highlight in the metal's colour, which turns white at grazing angles.

    Diffuse max(n·l, 0), and F · max(r·v, 0)ˢ where n·l > 0, with Schlick's F = C + (1 − C)(1 − h·l)⁵ for the metal's
    colour C and h = (l + v)/|l + v|. The highlight has its own colour: the material's `specular` is not read. The
    material's `diffuse` should be dark, because metals scatter almost nothing. Like Phong's, the reflection is not
    reciprocal.

    Parameters
    ----------
    color : color
        Reflectance at normal incidence, from 0 to 1: gold is about (1.0, 0.78, 0.34), in linear light.
    shininess : float, optional
        Exponent s, >= 0; defaults to the material's.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Notes
    -----
    C. Schlick: An inexpensive BRDF model for physically-based rendering (1994), equation 15. For the shift of a metal's
    colour to white at grazing angles, see R. Cook and K. Torrance: A reflectance model for computer graphics (1982),
    section 5.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> material = ph.Material(reflectance=ph.Metal("gold", shininess=20))
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight(), material)
    """

    color: ColorLike = check.field(part_of_light)
    shininess: float | None = own_shininess()

    maps: ClassVar[frozenset[str]] = frozenset({"shininess"})
    peak: ClassVar = MIRROR
    factors = staticmethod(_parted_highlight)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Lambert's lobe, and the highlight in two lobes: in the metal's colour and in white."""
        tinted = HIGHLIGHT._replace(is_own=True, color=rgb(self.color))
        return LAMBERT, tinted, HIGHLIGHT._replace(is_own=True)
