"""Light that bounces from surface to surface, as a series of diffuse reflections.

Symbols: S the direct light that vertices reflect, plus their emission; T the transport operator, which gathers mean
colours (`pvphong.rays.transport`); ρ the diffuse albedo, the reflection of a uniform white sky; A the reflected ambient
light. After n bounces a vertex sends

    B = S + ρT S + (ρT)² S + … + (ρT)ⁿ (S + A),

the first terms of the Neumann series of B = S + ρT B (C. Goral et al., "Modeling the interaction of light between
diffuse surfaces", 1984), with constant ambient light for the omitted terms. Only direct light has highlights.

In order: the equations for S, A and ρ, which the same evaluators run; and the series.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pvphong.base import check
from pvphong.base.types import FloatArray, Vector
from pvphong.optics.lights import EnvironmentLight
from pvphong.shading.equation import BLACK, Equation, LightTerm, in_parts

Gather = Callable[[FloatArray], FloatArray]
"""Function from the colours that vertices send, (n, k), to the mean colours that the vertices see, (n, k)."""

# Allowed excess of the albedo over 1. _ROUNDED is the error of a sum over nodes of the white sky. _FITTED is for a fit
# such as Oren and Nayar's, which reflects up to 1.018 at grazing angles.
_ROUNDED, _FITTED = 0.01, 0.03
# The series ends when a bounce changes the sum by at most this fraction.
_NOTHING = 2.0**-26


class Radiosity(NamedTuple):
    """Light that n vertices send by diffuse reflection and emission, and their diffuse albedo."""

    direct: FloatArray
    """Shape (n, 3): S, the direct light that vertices reflect, plus their emission."""
    ambient: FloatArray
    """Shape (n, 3): A, the reflected ambient light."""
    scattered: FloatArray
    """Shape (n, 3): ρ, the diffuse albedo."""

    @classmethod
    def of_all(cls, parts: list[Radiosity]) -> Radiosity:
        """Concatenate the arrays of several meshes."""
        return cls(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


# --- equations


def without_ambient(equation: Equation) -> Equation:
    """Return the equation without the ambient light of the light model and of the lights."""
    terms = tuple(replace(term, ambient=BLACK) if any(term.ambient) else term for term in equation.terms)
    return replace(equation, ambient=BLACK, terms=terms)


def direct_light(equation: Equation) -> Equation:
    """Return the equation without ambient light and without clamping. The series adds the ambient light later."""
    return replace(without_ambient(equation), bounces=0, clamp=False)


def directly_lit(equation: Equation) -> Equation:
    """Return the equation of S: diffuse reflection of direct light, and emission, without clamping."""
    direct = direct_light(equation)
    terms = tuple(direct.without(term, "specular") for term in direct.terms)
    return replace(direct, terms=tuple(term for term in terms if not term.is_black))


def ambient_alone(equation: Equation) -> Equation:
    """Return the equation of A: ambient light alone, without clamping."""
    black = (BLACK,) * len(equation.reflectance.lobes)
    terms = tuple(replace(term, colors=black) for term in equation.terms if any(term.ambient))
    return replace(equation, terms=terms, emission=BLACK, bounces=0, clamp=False)


def diffuse_white(equation: Equation) -> tuple[Vector, ...]:
    """Return a colour for each lobe: the material's own if the lobe is diffuse, else black."""
    diffuse = equation.lobes_of["diffuse"]
    return tuple(color if k in diffuse else BLACK for k, color in enumerate(equation.colors))


def under_white_sky(equation: Equation) -> Equation:
    """Return the equation of ρ: diffuse reflection of a uniform white sky that nothing hides, without clamping."""
    sky = LightTerm(EnvironmentLight(), 0, "white sky", False, BLACK, diffuse_white(equation), 1.0)
    alone = replace(direct_light(equation), terms=(sky,), lights=max(equation.lights, 1), emission=BLACK)
    return in_parts(replace(alone, is_occluded=False))


def without_gain(scattered: FloatArray, equation: Equation) -> FloatArray:
    """Return the diffuse albedo `scattered`, shape (n, 3), clipped to at most 1.

    The computed albedo may exceed 1 slightly, by its numerical error. This error is larger if diffuse reflection in
    `equation` depends on the viewer.

    Raises
    ------
    ValueError
        If a vertex reflects more light than arrives, so that the series diverges.
    """
    most = float(scattered.max(initial=0.0))
    if most > 1.0 + (_FITTED if equation.diffuse_needs_viewer else _ROUNDED):
        got = f"a material with a total reflectance of {most:.3g}"
        remedy = "Reduce diffuse times albedo to at most 1."
        check.refuse("material", got, "a material with a total reflectance of at most 1, if light bounces", remedy)
    return np.minimum(scattered, 1.0)


# --- the series


def bounced(sent: Radiosity, gather: Gather, count: int, *, apart: bool) -> FloatArray:
    """Return the light that has bounced up to `count` times.

    Parameters
    ----------
    sent : Radiosity
        Light that all vertices send.
    gather : callable
        Function that multiplies by T: it takes the colours that vertices send, and returns the mean colours that
        vertices see.
    count : int
        Number of bounces, at least 1.
    apart : bool
        True to return each bounce separately. If False, the series may end early, when the sum no longer changes.

    Returns
    -------
    ndarray
        Shape (count, n, 3), or (1, n, 3) for the sum. The last row includes the remaining ambient light.
    """
    if not apart:
        found, sends = np.zeros_like(sent.direct), sent.direct + sent.ambient
        for _ in range(count):
            before, found = found, sent.scattered * gather(sends)
            if np.abs(found - before).max(initial=0.0) <= _NOTHING * found.max(initial=0.0):
                break
            sends = sent.direct + found
        return found[None]
    both, scattered = np.hstack([sent.direct, sent.ambient]), np.hstack([sent.scattered, sent.scattered])
    bounces = np.zeros((count, *sent.direct.shape), sent.direct.dtype)
    for k in range(count):
        both = scattered * gather(both)
        bounces[k] = both[:, :3]
        if not both.any():
            break
    bounces[-1] += both[:, 3:]
    return bounces
