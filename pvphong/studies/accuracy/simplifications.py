"""Rewritings of the lighting equation that the report prices, beside what effects leave out of it themselves."""

from __future__ import annotations

import math
from dataclasses import replace

from pvphong.base.types import Vector
from pvphong.optics.light import POSITION_EFFECT, Light
from pvphong.optics.roles import Place
from pvphong.shading.equation import Equation
from pvphong.shading.plan.effects import EFFECTS

WITHOUT = {effect.name: effect.without for effect in EFFECTS}
"""Name of each of the plan's effects → equation, point → the equation without it."""


def far_lights_directional(equation: Equation, middle: Vector, farther_than: float) -> Equation:
    """With every light beyond a distance as a directional one."""
    whole, flat = equation.terms, WITHOUT[POSITION_EFFECT](equation, middle).terms
    terms = zip(whole, flat, strict=True)
    return replace(equation, terms=tuple(b if is_beyond(a.light, middle, farther_than) else a for a, b in terms))


def is_beyond(light: Light, middle: Vector, distance: float) -> bool:
    """Whether a light stands farther away than a distance."""
    places = light.values(Place)
    return bool(places) and all(math.dist(place, middle) > distance for place in places)


def without_light(equation: Equation, index: int) -> Equation:
    """The equation without one of the scene's lights."""
    return replace(equation, terms=tuple(term for term in equation.terms if term.index != index))
