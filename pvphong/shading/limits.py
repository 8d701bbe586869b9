"""Bounds on the factors of reflectances, which plans use before any vertex is lit.

A lobe is a summand of a reflectance, such as the diffuse one or a highlight. Its factor multiplies the arriving light.

Three functions dispatch on the kind of reflectance: `most` bounds a lobe's factor, `change` bounds the factor's change
when the light or the viewer turns, and `extremes` returns the bounding reflectances for a map of a field. For kinds
that are not registered, only Lambert lobes have bounds, so plans do not simplify the other lobes.

In order: these functions; highlights that are a power of a cosine; Schlick's weight; microfacets; the others.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import singledispatch
from typing import Any

from pvphong.base.formulas import BRIGHTEST
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics.reflectance import ANYWHERE, LAMBERT, AngleBounds
from pvphong.optics.reflectances import Metal, ModifiedPhong, OrenNayar, Ward
from pvphong.optics.reflectances.blinn_phong import largest_halfway
from pvphong.optics.reflectances.highlight import Shiny
from pvphong.optics.reflectances.microfacets import Microfacets
from pvphong.optics.reflectances.vtk import VtkHeadlight
from pvphong.optics.reflectances.ward import LEAST_HEIGHT


@singledispatch
def most(reflectance: Any, lobe: int, sightline: AngleBounds = ANYWHERE) -> float:  # noqa: ARG001 no bound
    """Return a bound on the factor of the lobe with the index `lobe`; infinite if no bound is known.

    The bound holds for all angles between normal, light and viewer that `sightline` allows.
    """
    return 1.0 if reflectance.lobes[lobe] is LAMBERT else math.inf


@singledispatch
def change(reflectance: Any, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:  # noqa: ARG001 any ψ
    """Return a bound on the change of a lobe's factor if the light or the viewer moves.

    The direction to the light is l, and the direction to the viewer is v. The bound holds for any normal. It is
    infinite if nothing is known.

    Parameters
    ----------
    reflectance : Reflectance
        The reflectance.
    lobe : int
        Index of the lobe.
    turn : float
        Angle of the turn in radians.
    psi : float
        Greatest angle ψ between l and v before the turn, in radians.
    light_moves : bool
        True if l turns, False if v turns.
    """
    if reflectance.lobes[lobe] is LAMBERT:
        return turn if light_moves else 0.0
    return most(reflectance, lobe)


@singledispatch
def extremes(reflectance: Any, field: str, low: float, high: float) -> tuple[Any, ...]:
    """Return a few reflectances whose bounds hold for every reflectance with `field` between `low` and `high`.

    A bound on the factor is the maximum of `most` over these reflectances. A bound on its change is the sum of `change`
    over these reflectances.
    """
    return replace(reflectance, **{field: low}), replace(reflectance, **{field: high})


# --- highlights that are a power of a cosine


def _largest_power(reflectance: Shiny, sightline: AngleBounds) -> float:
    """Return the largest value of a highlight that is a power of a cosine, for all angles that `sightline` allows.

    The light may be on either side of the surface.
    """
    cosine = min(reflectance.peak.most(sightline) * ROUNDED_UP, 1.0)
    return float(max(cosine, reflectance.floor, 0.0) ** reflectance.sharpness)


def _steepness(shininess: float) -> float:
    """Return the largest slope of cosⁿ θ as a function of θ, where n is `shininess`.

    It is √n · ((n − 1)/n)^((n − 1)/2) for n >= 1, infinite for n between 0 and 1, and 0 for n = 0.
    """
    if shininess < 1.0:
        return math.inf if shininess else 0.0
    return math.sqrt(shininess) * (1.0 - 1.0 / shininess) ** (0.5 * (shininess - 1.0))


@most.register
def _most_of_power(reflectance: Shiny, lobe: int, sightline: AngleBounds = ANYWHERE) -> float:
    """Return the bound `most` for a diffuse lobe followed by a highlight that is a power of a cosine.

    For the diffuse lobe, the bound is 1. For the highlight, it is the power at the largest cosine, or 0 if the light is
    below the horizon of every vertex. The arguments are as for `most`.
    """
    if lobe == 0:
        return 1.0
    return _largest_power(reflectance, sightline) if sightline.theta < math.pi / 2 else 0.0


@change.register
def _change_of_power(reflectance: Shiny, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:
    """Return the bound `change` for Lambert's lobe followed by a highlight that is a power of a cosine.

    A highlight changes by at most the power's slope times the turn. If the light moves, a jump is added, because the
    light may cross a vertex's horizon.

    At the horizon, n·l is at most the sine of the turn. The angle from the normal is at least π/2 − turn to the light,
    and at least π/2 − turn − ψ to the viewer. The arguments are as for `change`.
    """
    if lobe == 0:
        return turn if light_moves else 0.0
    widest = min(psi + turn, math.pi)
    result = _steepness(reflectance.sharpness) * turn * reflectance.peak.speed(widest)
    if light_moves:
        theta = max(math.pi / 2 - turn, 0.0)
        result += _largest_power(reflectance, AngleBounds(theta, max(theta - psi, 0.0), widest))
    return min(result * ROUNDED_UP, 1.0)


@extremes.register
def _(reflectance: Shiny, field: str, low: float, high: float) -> tuple[Any, ...]:
    """Return reflectances with the exponents `low` and `high`, which bound those between them.

    If 1 is between them, the greatest exponent below 1 is added, because highlights with exponents between 0 and 1 are
    infinitely steep. `field` is the name of the exponent's field.
    """
    kind: Any = reflectance
    ends = replace(kind, **{field: low}), replace(kind, **{field: high})
    return (*ends, replace(kind, **{field: math.nextafter(1.0, 0.0)})) if low < 1.0 <= high else ends


@most.register
def _(reflectance: ModifiedPhong, lobe: int, sightline: AngleBounds = ANYWHERE) -> float:
    """Return the bound `most` for modified Phong.

    For the diffuse lobe, the bound is 1. For the highlight, it is the bound on the power, times the largest n·l and the
    normalisation. The arguments are as for `most`.
    """
    factor = reflectance.parameters({})[0] * max(math.cos(sightline.theta), 0.0) if lobe else 1.0
    return _most_of_power(reflectance, lobe, sightline) * float(factor)


@change.register
def _(reflectance: ModifiedPhong, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:  # noqa: ARG001
    """Return the bound `change` for modified Phong.

    For the highlight, it bounds the change of the product of the power and n·l, which has no jump at the horizon. The
    arguments are as for `change`.
    """
    if lobe == 0:
        return turn if light_moves else 0.0
    slope = _steepness(reflectance.sharpness) + light_moves
    return min(slope * turn, 1.0) * float(reflectance.parameters({})[0])


@most.register
def _(reflectance: VtkHeadlight, lobe: int, sightline: AngleBounds = ANYWHERE) -> float:
    """Return the bound `most` for VTK's headlight.

    For the diffuse lobe, the bound is 1. For the highlight, it is the largest power. This highlight does not end at the
    horizon, so the light may be on either side of the surface. The arguments are as for `most`.
    """
    return _largest_power(reflectance, sightline) if lobe else 1.0


# --- Schlick's weight (1 − h·l)⁵ of the white part of the reflected light

_WHITENESS_SLOPE = 2.5
"""Largest change of Schlick's weight per radian by which l or v turns. The weight depends on h·l, the cosine of half
the angle between l and v."""


def _most_whiteness(psi: float) -> float:
    """Return the largest Schlick weight (1 − h·l)⁵ if light and viewer are at most `psi` radians apart."""
    return (1.0 - math.cos(0.5 * min(psi, math.pi))) ** 5


@most.register
def _(reflectance: Metal, lobe: int, sightline: AngleBounds = ANYWHERE) -> float:
    """Return the bound `most` for a metal.

    It is the bound of Phong's model. For the white lobe, this bound is multiplied by the largest Schlick weight. The
    arguments are as for `most`.
    """
    white = _most_whiteness(sightline.psi) if lobe == 2 else 1.0
    return _most_of_power(reflectance, lobe, sightline) * white


@change.register
def _(reflectance: Metal, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:
    """Return the bound `change` for a metal.

    For the diffuse lobe, the bound is that of Phong's model. For a highlight, it is the sum of the bounds on the
    changes of Phong's power and of Schlick's weight. The arguments are as for `change`.
    """
    result = _change_of_power(reflectance, lobe, turn, psi, light_moves=light_moves)
    return min(result + _WHITENESS_SLOPE * turn, 1.0) if lobe else result


# --- microfacets


@most.register
def _(reflectance: Microfacets, lobe: int, sightline: AngleBounds = ANYWHERE) -> float:
    """Return the bound `most` for microfacets.

    For the diffuse base, the bound is a constant. For a highlight, it is the microfacets' density D at the largest n·h,
    times the largest masking K = 1/(2β). For the white lobe, this product is multiplied by the largest Schlick weight.
    The arguments are as for `most`.
    """
    if lobe == 0:
        return 1.0 if reflectance.is_faded else 1.15
    alpha, _, _, beta2, _, floor, least, _ = reflectance.parameters({})
    if sightline.theta >= math.pi / 2 and not floor:
        return 0.0
    sine = max(1.0 - max(largest_halfway(sightline) * ROUNDED_UP, 0.0) ** 2, 0.0)
    peak = alpha / max(alpha * alpha + (1.0 - alpha * alpha) * sine, least)
    white = _most_whiteness(sightline.psi) if lobe == 2 else 1.0
    return float(min(peak * peak / (2.0 * math.sqrt(beta2)) * white * ROUNDED_UP, BRIGHTEST))


@change.register
def _(reflectance: Microfacets, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:  # noqa: ARG001
    """Return the bound `change` for microfacets.

    For the diffuse base, the bound follows from the base's slope. For a highlight, it is the highlight's largest value,
    because the slope of the masking is unbounded near the horizon. The arguments are as for `change`.
    """
    if lobe:
        return most(reflectance, lobe)
    faded = 1.0 + _WHITENESS_SLOPE, _WHITENESS_SLOPE
    for_light, for_viewer = faded if reflectance.is_faded else (1.65, 3.0)
    return min((for_light if light_moves else for_viewer) * turn, most(reflectance, 0))


# --- the others


@most.register
def _(reflectance: OrenNayar, lobe: int, sightline: AngleBounds = ANYWHERE) -> float:  # noqa: ARG001 one lobe, all angles
    """Return the bound `most` for Oren and Nayar's model, a bound on the sum of the coefficients A and B.

    The sum is at most 1.125, for sigma = 22°. The arguments are as for `most`.
    """
    return 1.13


@change.register
def _(reflectance: OrenNayar, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:  # noqa: ARG001
    """Return the bound `change` for Oren and Nayar's model.

    The change of the term with A is bounded by its slope. The change of the term with B is bounded by B, because the
    slope of this term is unbounded near the horizon. The arguments are as for `change`.
    """
    a, b = reflectance.parameters({})
    return (a * turn if light_moves else 0.0) + b


@most.register
def _(reflectance: Ward, lobe: int, sightline: AngleBounds = ANYWHERE) -> float:
    """Return the bound `most` for Ward's model: the factor at the largest n·h.

    With s, x, z and E as in `Ward`, and θ the angle from n to s: x/z² is at most 1/z, and |s|²/z² = 1 + tan² θ. The
    product (1 + tan² θ) exp(−E) is at most 1, and decreases with θ if n·v is positive. The arguments are as for `most`.
    """
    if lobe == 0:
        return 1.0
    cosine = largest_halfway(sightline) * ROUNDED_UP
    if sightline.theta >= math.pi / 2 or cosine <= 1e-6:
        return 0.0
    inverse = reflectance.parameters({})
    largest = min(math.prod(inverse) / LEAST_HEIGHT * ROUNDED_UP, BRIGHTEST)
    if sightline.phi > math.pi / 2 or cosine >= 1.0:
        return largest
    tangent2 = 1.0 / cosine**2 - 1.0
    return largest * (1.0 + tangent2) * math.exp(-min(tangent2 * min(inverse) ** 2, 700.0)) * ROUNDED_UP
