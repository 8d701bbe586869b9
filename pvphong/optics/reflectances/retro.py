"""Reflection back to the light, as of road signs and safety vests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from pvphong.base.formulas import formula, square, subtract
from pvphong.optics.reflectance import Geometry, Peak
from pvphong.optics.reflectances.modified_phong import ModifiedPhong


@formula
def _back_square(at: Geometry) -> Any:
    """Compute |C|² for the chord C = l − v between the light and the viewer: l·v = 1 − ½|C|²."""
    return square(subtract(at.l, at.v))


BACK = Peak(_back_square, lambda _, l, v: l - v, lambda _: 1.0, lambda surface: surface.to_viewer)
"""Peak where the viewer is in the direction of the light. The largest cosine is always taken as 1, because
`AngleBounds` has no least angle between light and viewer."""


@dataclass(frozen=True)
class Retro(ModifiedPhong):
    """Retroreflection: diffuse max(n·l, 0), and a highlight (s + 2)/2 · max(l·v, 0)ˢ · max(n·l, 0).

    s is the shininess. The reflection is `ModifiedPhong` with the direction to the light in place of the mirror
    direction. It is reciprocal, and conserves energy if diffuse and specular together are at most 1. The highlight is
    brightest with a headlight.

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
    Source of the retroreflective lobe: E. Lafortune, S.-C. Foo, K. Torrance, D. Greenberg: Non-linear approximation of
    reflectance functions (1997), section 4.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> material = ph.Material(specular=0.5, reflectance=ph.Retro(shininess=40))
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight(), material)
    """

    peak: ClassVar = BACK
