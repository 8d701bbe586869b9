"""Surfaces of small mirrors: Trowbridge and Reitz' distribution (GGX), Smith's masking, Schlick's Fresnel.

Symbols: n the normal, l and v unit vectors to light and viewer, h = (l + v)/|l + v|, θ the angle between n and h,
x = n·l, y = n·v, and S = (1 − h·l)⁵. The highlight is F · g. Without Schlick's factor F, and times π as in all of
pvphong, it is

    g = D · K,   D = (α / (α² cos² θ + sin² θ))²,   K = x / (2 (x √(β² + (1 − β²) y²) + y √(β² + (1 − β²) x²)))

D is Trowbridge and Reitz' distribution (Walter et al., Microfacet models for refraction through rough surfaces, 2007,
equation 33). K is Smith's height-correlated masking (Heitz, Understanding the masking-shadowing function, 2014,
equation 99), divided by 4 n·l n·v and multiplied by n·l. GGX has β = α; PBR, like VTK, has β = √α.

F = F₀(1 − S) + S has two parts, which are two lobes: one in the colour F₀, and one in white.

Near the peak, cos² θ has lost the digits that a small α needs. So the code uses sin² θ = |n × (l + v)|² / |l + v|²,
which keeps full precision.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any, ClassVar

import numpy as np

from pvphong.base.formulas import (
    BRIGHTEST,
    HALF,
    LEAST_SQUARE,
    ONE,
    ZERO,
    add,
    as_type_of,
    cross,
    formula,
    maximum,
    minimum,
    multiply_add,
    select,
    sqrt,
    square,
)
from pvphong.optics.directions import Directions, by_halves
from pvphong.optics.maps import number_or_map
from pvphong.optics.reflectance import Geometry, Reflectance
from pvphong.optics.reflectances.blinn_phong import HALFWAY
from pvphong.optics.reflectances.highlight import (
    whiteness,
)
from pvphong.optics.surface import Surface

_LEAST_ALPHA = 1e-15
"""Least α. At this α, the highlight is narrower than the resolution of float64 directions, and α² fits in float32."""

COUPLED = 28.0 / 23.0


@formula
def _cosines(own: Any, at: Geometry) -> Any:
    """Return the cosines x = n·l and y = n·v, but at least the least cosine, own[5]. x is 0 where n or l is zero.

    `own` has the numbers that `Microfacets.parameters` returns, and `at` the directions at a vertex.
    """
    x, y = maximum(at.n_l, own[5]), maximum(at.n_v, own[5])
    return select((square(at.n) > ZERO) & (square(at.l) > ZERO), x, ZERO), y


@formula
def _highlight(own: Any, at: Geometry, x: Any, y: Any) -> Any:
    """Return two factors: g(1 − S), the part of the highlight in the colour F₀, and gS, its white part.

    `own` has the numbers that `Microfacets.parameters` returns, and `at` the directions at a vertex. x and y are the
    results of `_cosines`.
    """
    alpha, alpha2, rest, beta2, beyond, least = own[0], own[1], own[2], own[3], own[4], own[6]
    s = add(at.l, at.v)
    length = square(s)
    across = square(cross(at.n, s)) * (at.scale * at.scale)
    is_above = (length > LEAST_SQUARE) & (at.n_l + at.n_v > ZERO)
    sine = select(is_above, minimum(across / length, ONE), ONE)  # sin² θ
    peak = alpha / maximum(multiply_add(rest, sine, alpha2), least)
    masked = multiply_add(x, sqrt(multiply_add(beyond * y, y, beta2)), y * sqrt(multiply_add(beyond * x, x, beta2)))
    is_lit = x > ZERO
    shine = peak * peak * (HALF * x / masked)
    shine = select(is_lit, minimum(shine, as_type_of(x, BRIGHTEST)), ZERO)
    white = shine * whiteness(at)
    return shine - white, white


@formula
def faded(own: Any, at: Geometry, highlight: Any) -> Any:  # noqa: ARG001 it is no power
    """Return the factors of three lobes: a diffuse base, and the highlight in the colour F₀ and in white.

    The base x(1 − tS) is Lambert's reflection of the light that facets transmit. `own` has the numbers that
    `Microfacets.parameters` returns, and `at` the directions at a vertex; `highlight` is not read.
    """
    x, y = _cosines(own, at)
    tinted, white = _highlight(own, at, x, y)
    return x * (ONE - own[7] * whiteness(at)), tinted, white


@formula
def _seen(cosine: Any) -> Any:
    """Compute 1 − (1 − c/2)⁵ for a cosine c, a factor of the base in `coupled`."""
    rest = ONE - HALF * maximum(cosine, ZERO)
    return ONE - (rest * rest) * (rest * rest) * rest


@formula
def coupled(own: Any, at: Geometry, highlight: Any) -> Any:  # noqa: ARG001 it is no power
    """Return the factors of three lobes: a reciprocal diffuse base, and the highlight in the colour F₀ and in white.

    The base is 28/23 · x(1 − (1 − x/2)⁵)(1 − (1 − y/2)⁵). It keeps the total reflectance at most 1: Ashikhmin and
    Shirley, An anisotropic Phong BRDF model, 2000, equation 5. `own` has the numbers that `Microfacets.parameters`
    returns, and `at` the directions at a vertex; `highlight` is not read.
    """
    x, y = _cosines(own, at)
    tinted, white = _highlight(own, at, x, y)
    return as_type_of(x, COUPLED) * x * _seen(x) * _seen(y), tinted, white


ROUGHNESS = partial(number_or_map, above=0.0, at_most=1.0, remedy="0.1 is polished, 0.5 satin, 1 matt.")
"""Check of a roughness."""


class Microfacets(Reflectance):
    """Reflectance of small mirrors: a highlight in two colours over a diffuse base.

    The base is that of the formula `faded` or `coupled`. Each subclass has the field `roughness`.
    """

    roughness: float

    maps: ClassVar[frozenset[str]] = frozenset({"roughness"})
    peak: ClassVar = HALFWAY

    cutoffs: ClassVar[tuple[float, float]] = (0.0, 0.0)
    """Least values of the cosines n·l and n·v, and of the denominator in D."""

    def fade(self, maps: Mapping[str, Any]) -> Any:  # noqa: ARG002 constant by default
        """Return the number t in the factor x(1 − tS) of a `faded` base; by default, 1.

        `maps` has numbers per vertex in place of fields, as for `Reflectance.parameters`.
        """
        return 1.0

    @property
    def alpha(self) -> float:
        """The α of the distribution D. The field `roughness` must be a number, not a map."""
        return float(self.parameters({})[0])

    @property
    def is_faded(self) -> bool:
        """True if the diffuse base is that of the formula `faded`, False if it is that of `coupled`."""
        return type(self).factors is faded

    def directions(self, surface: Surface) -> Directions:
        """Return an importance sampling of the highlight at the vertices of `surface`.

        Directions are chosen by the distribution of the facets' slopes (Walter et al. 2007, equations 35 and 36).
        """
        alpha = self.parameters(surface.maps)[0]

        def slopes(x: Any, y: Any) -> tuple[Any, Any]:
            steep = alpha / np.sqrt(np.maximum(1.0 - x * x - y * y, 2.0**-30))
            return x * steep, y * steep

        def density(x: Any, y: Any) -> Any:
            peak = 1.0 / (alpha + (x / alpha * x + y / alpha * y))
            return peak * peak / math.pi

        return by_halves(surface.exact_normals, surface.to_viewer, slopes, density)

    @property
    def sharpness(self) -> float:
        """Sharpness of the highlight, 4/α²: near its peak, the distribution D is proportional to exp(−2 θ²/α²)."""
        return min(4.0 / self.alpha**2, BRIGHTEST)

    def parameters(self, maps: Mapping[str, Any]) -> tuple[Any, ...]:
        """Return the eight numbers that the formulas read.

        These are α, α², 1 − α², β², 1 − β², the least cosine, the least denominator of D, and t. If `maps` has a map of
        the roughness, the first five are arrays of numbers per vertex.
        """
        rest = (*(0.0,) * 5, *self.cutoffs, self.fade(maps))
        found: tuple[Any, ...] = type(self).mapped(np.asarray(maps.get("roughness", self.roughness)), rest)
        return found


@formula
def alpha_of(roughness: Any) -> Any:
    """Return the α of the distribution for a roughness that is perceptually linear: α = roughness²."""
    return maximum(roughness * roughness, as_type_of(roughness, _LEAST_ALPHA))
