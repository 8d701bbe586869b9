"""Blinn's variant of Phong's reflection: a highlight around the half-way direction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from pvphong.base.formulas import (
    LEAST_SQUARE,
    TWO,
    add,
    as_type_of,
    formula,
    inverse_length,
    select,
    square,
    subtract,
    times,
)
from pvphong.base.vectors import unit
from pvphong.optics.reflectance import AngleBounds, Geometry, Peak
from pvphong.optics.reflectances.highlight import Shiny, own_shininess

_LARGER = 2.0**60
"""Factor of l + v that keeps its square from underflowing where l and v are nearly opposite; exact, a power of two."""


@formula
def _halfway_square(at: Geometry) -> Any:
    """Compute |C|² for the chord C = h − n between the half-way direction and the normal: n·h = 1 − ½|C|².

    Where l = −v, there is no h, and the result is 2.
    """
    h = times(add(at.l, at.v), as_type_of(at.n_l, _LARGER))
    length = square(h)
    chord = square(subtract(times(h, inverse_length(length)), times(at.n, at.scale)))
    return select(length > LEAST_SQUARE, chord, TWO)


def largest_halfway(line: AngleBounds) -> float:
    """Return the largest n·h that is possible within the bounds `line` on the angles θ, φ and ψ of `AngleBounds`.

    n·h = (cos θ + cos φ) / (2 cos ψ/2) grows with smaller θ and φ and with greater ψ. The direction h is the middle of
    the arc from l to v, so its angle from n is at least θ − ψ/2 and φ − ψ/2.
    """
    theta, phi, psi = line
    nearest = math.cos(max(theta - 0.5 * psi, phi - 0.5 * psi, 0.0))
    middle = 2.0 * math.cos(0.5 * psi)
    return min((math.cos(theta) + math.cos(phi)) / middle, nearest) if middle > 1e-6 else nearest


HALFWAY = Peak(
    _halfway_square,
    lambda n, l, v: unit(l + v)[0] - n,
    largest_halfway,
    None,
    lambda psi: 0.5 / max(math.cos(0.5 * psi), 1e-6),
)
"""Peak where the half-way direction h = (l + v)/|l + v| is n. h is the middle of the arc from l to v."""


@dataclass(frozen=True)
class BlinnPhong(Shiny):
    """Blinn's reflection: diffuse max(n·l, 0), and a highlight max(n·h, 0)ˢ where n·l > 0, with h = (l + v)/|l + v|.

    Sources: Blinn 1977; OpenGL 2.1 specification, section 2.14.1.

    Parameters
    ----------
    shininess : float, optional
        Exponent s, >= 0; defaults to the material's.

    Raises
    ------
    ValueError
        If the shininess is out of range.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> material = ph.Material(specular=0.5, reflectance=ph.BlinnPhong(shininess=160))
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight(), material)
    """

    shininess: float | None = own_shininess()

    peak: ClassVar = HALFWAY
