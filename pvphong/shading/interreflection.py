"""Light that bounces from surface to surface, as a series of diffuse reflections.

Symbols: S what vertices send on of direct light, and emit; T how light goes between vertices, as a gathering of mean
colours (`pvphong.rays.transport`); ρ what a vertex reflects diffusely of white light from all around; A the ambient
light that it reflects. After n bounces a vertex sends

    B = S + ρT S + (ρT)² S + … + (ρT)ⁿ (S + A),

the first terms of the Neumann series of B = S + ρT B (C. Goral et al., "Modeling the interaction of light between
diffuse surfaces", 1984), with the constant ambient light for those that are left out. Highlights are direct light's.

In order: the equations that give S, A and ρ, by the evaluators that give all else; and the series.
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
"""The mean colours that vertices see, (n, k), of what they send, (n, k)."""

# So much more than 1 may a sum over nodes of the white sky make a reflectance; and a fit such as Oren and Nayar's,
# which reflects up to 1.018 where it is seen at a grazing angle.
_ROUNDED, _FITTED = 0.01, 0.03
# What no longer changes the sum, as a share of it.
_NOTHING = 2.0**-26


class Sent(NamedTuple):
    """What n vertices send before light has bounced, and what they reflect."""

    direct: FloatArray
    """Shape (n, 3): S."""
    ambient: FloatArray
    """Shape (n, 3): A."""
    scattered: FloatArray
    """Shape (n, 3): ρ."""

    @classmethod
    def of_all(cls, parts: list[Sent]) -> Sent:
        """Those of several meshes, one after the other."""
        return cls(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


# --- equations


def without_ambient(equation: Equation) -> Equation:
    """The equation without ambient light, the light model's and the lights'."""
    terms = tuple(replace(term, ambient=BLACK) if any(term.ambient) else term for term in equation.terms)
    return replace(equation, ambient=BLACK, terms=terms)


def direct_light(equation: Equation) -> Equation:
    """The equation of what has not bounced, unclamped: without ambient light, which only the series holds."""
    return replace(without_ambient(equation), bounces=0, clamp=False)


def directly_lit(equation: Equation) -> Equation:
    """Of S: diffuse reflection and emission, unclamped."""
    direct = direct_light(equation)
    terms = tuple(direct.without(term, "specular") for term in direct.terms)
    return replace(direct, terms=tuple(term for term in terms if not term.is_black))


def ambient_alone(equation: Equation) -> Equation:
    """Of A: ambient light alone, unclamped."""
    black = (BLACK,) * len(equation.reflectance.lobes)
    terms = tuple(replace(term, colors=black) for term in equation.terms if any(term.ambient))
    return replace(equation, terms=terms, emission=BLACK, bounces=0, clamp=False)


def diffuse_white(equation: Equation) -> tuple[Vector, ...]:
    """The colours of the lobes in white light, of those that reflect diffusely."""
    diffuse = equation.lobes_of["diffuse"]
    return tuple(color if k in diffuse else BLACK for k, color in enumerate(equation.colors))


def under_white_sky(equation: Equation) -> Equation:
    """Of ρ: diffuse reflection of white light from all around that nothing blocks, unclamped."""
    sky = LightTerm(EnvironmentLight(), 0, "white sky", False, BLACK, diffuse_white(equation), 1.0)
    alone = replace(direct_light(equation), terms=(sky,), lights=max(equation.lights, 1), emission=BLACK)
    return in_parts(replace(alone, is_occluded=False))


def without_gain(scattered: FloatArray, equation: Equation) -> FloatArray:
    """What is reflected of white light by an equation's surface, at most 1.

    Raises
    ------
    ValueError
        Where a vertex would reflect more light than arrives: a series of that has no end.
    """
    most = float(scattered.max(initial=0.0))
    if most > 1.0 + (_FITTED if equation.diffuse_needs_viewer else _ROUNDED):
        got = f"one that reflects {most:.3g} times what arrives"
        remedy = "Its diffuse colour times albedo is to be at most 1."
        check.refuse("material", got, "one that reflects no more light than arrives, where light bounces", remedy)
    return np.minimum(scattered, 1.0)


# --- the series


def bounced(sent: Sent, gather: Gather, count: int, *, apart: bool) -> FloatArray:
    """What has bounced, up to so many times.

    Parameters
    ----------
    sent : Sent
        Of all vertices.
    gather : callable
        Multiplies by T.
    count : int
        At least 1.
    apart : bool
        Whether each bounce is given for itself; it ends early else, where nothing more changes.

    Returns
    -------
    ndarray
        Shape (count, n, 3), or (1, n, 3) for the sum; the rest of the ambient light is in the last.
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
