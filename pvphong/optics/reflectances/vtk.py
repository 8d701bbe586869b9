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

# Least cosines in the shader; the second one is for its first tier.
_FLOOR, _HEADLIGHT_FLOOR = 1e-5, 1e-6


def vtk_reflectance(shininess: float, *, is_headlight: bool) -> Reflectance:
    """Return the shader's reflectance: in its first tier, for a single headlight, or in the others."""
    shininess = min(shininess, HIGHEST_POWER)
    return VtkHeadlight(shininess) if is_headlight else Phong(shininess, _FLOOR)


@formula
def _headlight(own: Any, at: Geometry, highlight: Any) -> Any:  # noqa: ARG001 any reflectance's
    """Compute max(n·l, floor) and the highlight; both are 0 without a normal, where the floor does not apply."""
    is_there = square(at.n) > ZERO
    cosine = maximum(at.n_l, as_type_of(at.n_l, _HEADLIGHT_FLOOR))
    return select(is_there, cosine, ZERO), select(is_there, highlight, ZERO)


@formula
def _normal_square(at: Geometry) -> Any:
    """Compute |C|² for C = l − n, n·l = 1 − ½|C|²."""
    return square(subtract(at.l, times(at.n, at.scale)))


NORMAL = Peak(
    _normal_square, lambda n, l, _: l - n, lambda line: math.cos(line.theta), lambda surface: surface.exact_normals
)
"""Peak where light falls along the normal."""


@dataclass(frozen=True)
class VtkHeadlight(Shiny):
    """Diffuse c and highlight cⁿ with c = max(n·l, 1e-6): the shader's first tier; 0 without a normal.

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
