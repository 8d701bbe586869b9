"""Surfaces of small mirrors: Trowbridge and Reitz' distribution, Smith's masking, Schlick's Fresnel.

Symbols: n the normal, l and v unit vectors to light and viewer, h = (l + v)/|l + v|, θ the angle between n and h, x =
n·l, y = n·v, and S = (1 − h·l)⁵. A facet's factor, times π as everywhere here, is

    g = D · K,   D = (α / (α² cos² θ + sin² θ))²,   K = x / (2 (x √(β² + (1 − β²) y²) + y √(β² + (1 − β²) x²)))

with Trowbridge and Reitz' D (Walter et al., Microfacet models for refraction through rough surfaces, 2007, equation
33) and Smith's height-correlated masking over 4 n·l n·v (Heitz, Understanding the masking-shadowing function, 2014,
equation 99) times n·l. Theory has β = α. Of F = F₀(1 − S) + S, the first part has the colour F₀, the second is white.

Near the peak sin² θ = |n × (l + v)|² / |l + v|² is known to full precision, where cos² θ has lost the digits that a
small α asks for.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from pvphong.base import check
from pvphong.base.float_range import BRIGHTEST
from pvphong.base.types import FloatArray, rgb
from pvphong.base.vectors import dot, square_of_cross, unit
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics.light import Arrival
from pvphong.optics.reflectance import Lobe, Reflectance, Sightline
from pvphong.optics.reflectances.fresnel import WHITENESS_SLOPE, most_whiteness, whiteness
from pvphong.optics.reflectances.highlight import square
from pvphong.optics.reflectances.phong import Phong
from pvphong.optics.surface import Surface

_LEAST_ALPHA = 1e-15
"""Its highlights are narrower than float64 can tell directions apart, and its square is within float32's range."""

_COUPLED = 28.0 / 23.0

Base = Literal["faded", "coupled"]
"""What is under the facets: Lambert's reflection of what they let in, x(1 − S); or one that is reciprocal and leaves
the sum at most 1, 28/23 · x(1 − (1 − x/2)⁵)(1 − (1 − y/2)⁵) (Ashikhmin and Shirley, An anisotropic Phong BRDF model,
2000, equation 5)."""


class Facets(NamedTuple):
    """How rough they are, and where cosines are cut off."""

    alpha: Any
    """Of the distribution, above 0."""

    beta: Any
    """Of the masking."""

    floor: float = 0.0
    """N·l and n·v are taken to be at least this."""

    least: float = 0.0
    """The denominator in D is taken to be at least this."""


@dataclass(frozen=True)
class Microfacets(Reflectance):
    """A diffuse base under a highlight of microfacets, in two colours."""

    maps: ClassVar[frozenset[str]] = frozenset({"roughness"})

    @abstractmethod
    def facets_of(self, roughness: Any) -> Facets:
        """Its microfacets, for a roughness or an array of them."""

    @property
    @abstractmethod
    def facets(self) -> Facets:
        """Those of its own roughness."""

    @property
    @abstractmethod
    def base(self) -> Base:
        """What is under them."""

    def _lobes(self, diffuse: Lobe, tinted: Lobe, white: Lobe) -> tuple[Lobe, ...]:
        """The base, and the highlight in its two colours, with their largest factors."""
        largest = self._largest
        base = 1.0 if self.base == "faded" else 1.15
        return diffuse._replace(largest=base), tinted._replace(largest=largest), white._replace(largest=largest)

    @property
    def _largest(self) -> float:
        """D is at most 1/α², K at most 1/(2β)."""
        alpha, beta, _, least = self.facets
        return min((alpha / max(alpha * alpha, least)) ** 2 / (2.0 * beta) * ROUNDED_UP, BRIGHTEST)

    def factors(self, surface: Surface, arrival: Arrival, wanted: Sequence[bool]) -> tuple[Any, ...]:
        """As at the module's head."""
        n, l, v = surface.normals, arrival.direction, surface.to_viewer
        real = n.dtype.type
        facets = self.facets_of(surface.maps["roughness"]) if "roughness" in surface.maps else self.facets
        floor = real(facets.floor)
        x = np.maximum(surface.raw_cosine(arrival) * surface.inverse_length, floor)
        y = np.maximum(dot(n, v), floor)
        x *= (surface.inverse_length > 0.0) & (square(l) > 0.0)
        white = whiteness(surface, l)
        base = x * (real(1.0) - white) if self.base == "faded" else real(_COUPLED) * x * _seen(x) * _seen(y)
        if not any(wanted[1:]):
            return base, 0.0, 0.0
        shine = _shine(facets, n, l + v, x, y)
        white = shine * white
        return base, shine - white, white

    def stand_in(self, material: Any) -> tuple[str, Any] | None:
        """Phong's highlight, as high and half as high at the same angles where light and viewer are above the surface.

        Lambert's cosine under it reflects as much in all as the coupled base, which is 23/28.
        There g is 1/(4α²) at its peak and half of that where sin² θ = (√2 − 1)α², which is cos (2θ)ⁿ = ½ for
        n = ln 4 / (4 (√2 − 1) α²).
        """
        base, tinted, _ = self.lobes
        square = self.facets.alpha**2
        whole = 1.0 if self.base == "faded" else 1.0 / _COUPLED
        diffuse = tuple(a * b * whole for a, b in zip(rgb(material.diffuse), base.color, strict=True))
        specular = tuple(channel / (4.0 * square) for channel in tinted.color)
        fitted = Phong(min(math.log(4.0) / (4.0 * (math.sqrt(2.0) - 1.0) * square), BRIGHTEST))
        return "Phong for microfacets", replace(material, diffuse=diffuse, specular=specular, reflectance=fitted)

    def change(self, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:  # noqa: ARG002 for any ψ
        """Next to the horizon the masking has no bound on its slope, but a highlight is never more than its largest."""
        if lobe:
            return self._largest
        if self.base == "faded":
            return min((WHITENESS_SLOPE + light_moves) * turn, 1.0)
        return min((1.65 if light_moves else 3.0) * turn, 1.15)

    def most(self, lobe: int, sightline: Sightline) -> float:
        """N·h is at most (cos θ + cos φ) / (2 cos ψ/2), as for Blinn-Phong."""
        theta, phi, psi = sightline
        alpha, _, floor, least = self.facets
        if lobe == 0:
            return self.lobes[0].largest
        if theta >= math.pi / 2 and not floor:
            return 0.0
        middle = 2.0 * math.cos(psi / 2.0)
        cosine = (math.cos(theta) + math.cos(phi)) / middle if middle > 1e-6 else 1.0
        sine = max(1.0 - max(cosine * ROUNDED_UP, 0.0) ** 2, 0.0)
        peak = alpha / max(alpha * alpha + (1.0 - alpha * alpha) * sine, least)
        white = most_whiteness(psi) if lobe == 2 else 1.0
        return min(peak * peak / (2.0 * self.facets.beta) * white * ROUNDED_UP, self._largest)

    @property
    def sharpness(self) -> float:
        """D is about exp(−2 θ²/α²) at its peak."""
        return min(4.0 / self.facets.alpha**2, BRIGHTEST)

    def chords(self, n: FloatArray, l: FloatArray, v: FloatArray) -> FloatArray:
        """Half-way direction minus normal."""
        return unit(l + v)[0] - n

    def parameters(self) -> tuple[float, ...]:
        """α, α², 1 − α², β², 1 − β², and where cosines are cut off."""
        alpha, beta, floor, least = self.facets
        return alpha, alpha * alpha, 1.0 - alpha * alpha, beta * beta, 1.0 - beta * beta, floor, least

    def stage(self, toolkit: Any, wanted: Sequence[bool]) -> Callable[..., Any] | None:
        """As `factors`."""
        return _stage(toolkit, int(self.base == "coupled"), int(any(wanted[1:])))


def alpha_of(roughness: Any) -> Any:
    """The α of a roughness that looks even: its square."""
    return np.maximum(roughness * roughness, _LEAST_ALPHA)


def _shine(facets: Facets, n: FloatArray, s: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """D times K, s being l + v."""
    alpha, beta, _, least = (np.asarray(number, n.dtype) for number in facets)
    length, one = square(s), n.dtype.type(1.0)
    with np.errstate(invalid="ignore"):
        sine = np.where((length > 0.0) & (dot(n, s) > 0.0), np.minimum(square_of_cross(n, s) / length, one), one)
        peak = alpha / np.maximum(alpha * alpha + (one - alpha * alpha) * sine, least)
        masked = x * _masking(y, beta) + y * _masking(x, beta)
        shine = peak * peak * (n.dtype.type(0.5) * x / masked)
    return np.where(x > 0.0, np.minimum(shine, n.dtype.type(BRIGHTEST)), n.dtype.type(0.0))


def check_roughness(value: Any) -> float:
    """A roughness above 0 and at most 1."""
    return check.number("roughness", value, above=0.0, at_most=1.0, remedy="0.1 is polished, 0.5 satin, 1 matt.")


def _masking(cosine: FloatArray, beta: Any) -> Any:
    return np.sqrt(beta * beta + (beta.dtype.type(1.0) - beta * beta) * cosine * cosine)


def _seen(cosine: FloatArray) -> Any:
    """1 − (1 − c/2)⁵ for a cosine c."""
    rest = cosine.dtype.type(1.0) - cosine.dtype.type(0.5) * np.maximum(cosine, 0.0)
    return cosine.dtype.type(1.0) - rest**5


def _stage(toolkit: Any, is_coupled: int, shines: int) -> Callable[..., Any]:
    def microfacets(numbers: Any, rows: Any, _points: Any) -> int:
        alpha, alpha2 = toolkit.like(rows, numbers[0]), toolkit.like(rows, numbers[1])
        rest, beta2 = toolkit.like(rows, numbers[2]), toolkit.like(rows, numbers[3])
        beyond, floor = toolkit.like(rows, numbers[4]), toolkit.like(rows, numbers[5])
        least, half = toolkit.like(rows, numbers[6]), toolkit.like(rows, 0.5)
        coupled, bright = toolkit.like(rows, _COUPLED), toolkit.like(rows, BRIGHTEST)
        for i in range(toolkit.BLOCK):
            shrink = rows[toolkit.INVERSE + i]
            raw, across, square = toolkit.halfway_sines(rows, i)
            facing = rows[toolkit.FACING + i]
            x, y = max(raw * shrink, floor), max(facing * shrink, floor)
            x = x if shrink < toolkit.NO_LENGTH else toolkit.ZERO
            if is_coupled:
                of_x, of_y = toolkit.ONE - half * x, toolkit.ONE - half * y
                of_x = toolkit.ONE - (of_x * of_x) * (of_x * of_x) * of_x
                of_y = toolkit.ONE - (of_y * of_y) * (of_y * of_y) * of_y
                rows[toolkit.FIRST + i] = coupled * x * of_x * of_y
            grazing = max(toolkit.ONE - half * toolkit.root(square), toolkit.ZERO)
            white = (grazing * grazing) * (grazing * grazing) * grazing
            if not is_coupled:
                rows[toolkit.FIRST + i] = x * (toolkit.ONE - white)
            if shines:
                sine = across * (shrink * shrink) / max(square, toolkit.ZERO_SQUARE)
                is_there = (square > toolkit.ZERO_SQUARE) & (raw + facing > toolkit.ZERO)
                sine = min(sine, toolkit.ONE) if is_there else toolkit.ONE
                peak = alpha / max(toolkit.multiply_add(rest, sine, alpha2), least)
                of_x = toolkit.root(toolkit.multiply_add(beyond * x, x, beta2))
                of_y = toolkit.root(toolkit.multiply_add(beyond * y, y, beta2))
                shine = peak * peak * (half * x / toolkit.multiply_add(x, of_y, y * of_x))
                shine = min(shine, bright) if x > toolkit.ZERO else toolkit.ZERO
                white = shine * white
                rows[toolkit.SECOND + i] = shine - white
                rows[toolkit.THIRD + i] = white
        return 7 if shines else 1

    return microfacets
