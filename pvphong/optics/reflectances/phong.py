"""Phong's reflection: diffuse, and a highlight around the mirror direction.

The highlight is a power of r·v = 1 − ½|C|², with the chord C between the mirror direction r and the unit vector v to
the viewer. Evaluators compute the power (`Phong.power`, `pvphong.base.formulas.chord_power`), and the formula
`Shiny.factors` keeps it where n·l > 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from pvphong.base import check
from pvphong.base.formulas import add, cross, dot, formula, multiply_add, square, subtract
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.reflectance import Geometry, Peak
from pvphong.optics.reflectances.highlight import Shiny, own_shininess


@formula
def _mirror_square(at: Geometry) -> Any:
    """Compute |C|² for the chord C = 2(n·l)n − l − v between the mirror direction and the viewer: r·v = 1 − ½|C|².

    It is computed from the parts of C across n and along n: |C|² = |n × (l + v)|² + (n·(l − v))². So it is 0 where n =
    l = v, unaffected by the rounding of |n|.
    """
    along = dot(at.n, subtract(at.l, at.v))
    return multiply_add(along, along, square(cross(at.n, add(at.l, at.v)))) * (at.scale * at.scale)


MIRROR = Peak(
    _mirror_square,
    lambda n, l, v: 2.0 * dot(n, l) * n - l - v,
    lambda line: 2.0 * math.cos(line.theta) * max(math.cos(line.phi), 0.0) - math.cos(line.psi),
    lambda surface: surface.mirrored,
)
"""Peak where the viewer is in the mirror direction r = 2(n·l)n − l: r·v = 2(n·l)(n·v) − l·v."""


@dataclass(frozen=True)
class Phong(Shiny):
    """Phong's reflection: diffuse max(n·l, 0), and a highlight max(r·v, 0)ˢ where n·l > 0 (Phong 1975).

    r = 2(n·l)n − l is the mirror direction. The reflection is not reciprocal.

    Parameters
    ----------
    shininess : float, optional
        Exponent s, >= 0; defaults to the material's.
    floor : float, default 0
        Least value of the cosine r·v, as in VTK's shader.

    Raises
    ------
    ValueError
        If a field is out of range.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> material = ph.Material(specular=0.5, reflectance=ph.Phong(shininess=40))
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight(), material)
    """

    shininess: float | None = own_shininess()
    floor: float = check.field(partial(check.number, at_least=0.0, at_most=1.0), 0.0)

    peak: ClassVar = MIRROR

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """Lambert's cosine, and the highlight (r·v)ˢ = (l·w)ˢ, where w is v mirrored at n."""
        return super().forms[0], None if self.floor else CosinePower("mirror", self.sharpness)
