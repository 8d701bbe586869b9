"""VTK's variant of Phong's reflection (vtkOpenGLPolyDataMapper::ReplaceShaderLight)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from pvphong.base.formulas import ZERO, as_type_of, formula, maximum, select, square, subtract, times
from pvphong.optics.reflectance import HIGHLIGHT, Geometry, Lobe, Peak, Reflectance
from pvphong.optics.reflectances.highlight import Shiny, own_shininess
from pvphong.optics.reflectances.phong import Phong

HIGHEST_POWER = 128.0
"""Largest exponent in vtkProperty and vtkLight, which clamp to [0, 128]."""

# Least cosines in VTK's shader; the second one is for its first tier of code, which handles a single headlight.
_FLOOR, _HEADLIGHT_FLOOR = 1e-5, 1e-6


def vtk_reflectance(shininess: float, *, is_headlight: bool) -> Reflectance:
    """Return the reflectance of VTK's Phong shader, with the shininess limited to 128.

    The shader's code has three tiers. If `is_headlight`, the result is the reflectance of the first tier, for scenes
    with a single headlight. Else it is the reflectance of the other two tiers.
    """
    shininess = min(shininess, HIGHEST_POWER)
    return VtkHeadlight(shininess) if is_headlight else Phong(shininess, _FLOOR)


@formula
def _headlight(own: Any, at: Geometry, highlight: Any) -> Any:  # noqa: ARG001 any reflectance's
    """Return the factor of the diffuse lobe, max(n·l, 1e-6), and of the highlight; both are 0 without a normal.

    The highlight's factor is the argument `highlight`, a power of the cosine n·l. `at` has the directions at a vertex.
    `own` is not read.
    """
    is_there = square(at.n) > ZERO
    cosine = maximum(at.n_l, as_type_of(at.n_l, _HEADLIGHT_FLOOR))
    return select(is_there, cosine, ZERO), select(is_there, highlight, ZERO)


@formula
def _normal_square(at: Geometry) -> Any:
    """Compute |C|² for the chord C = l − n between the light and the normal: n·l = 1 − ½|C|²."""
    return square(subtract(at.l, times(at.n, at.scale)))


NORMAL = Peak(
    _normal_square, lambda n, l, _: l - n, lambda line: math.cos(line.theta), lambda surface: surface.exact_normals
)
"""Peak where the light is in the direction of the normal."""


@dataclass(frozen=True)
class VtkHeadlight(Shiny):
    """Diffuse c and highlight cⁿ with c = max(n·l, 1e-6), as in the first tier of VTK's shader; 0 without a normal.

    Parameters
    ----------
    shininess : float
        Exponent n.
    """

    shininess: float | None = own_shininess()

    # the floor makes the first lobe differ from LAMBERT, which is evaluated without calling this formula
    lobes = Lobe("diffuse", takes_albedo=True, needs_viewer=False), HIGHLIGHT._replace(needs_viewer=False)
    forms = None, None
    floor = _HEADLIGHT_FLOOR
    peak: ClassVar = NORMAL
    factors = staticmethod(_headlight)
