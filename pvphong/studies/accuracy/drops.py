"""What it means to leave out an effect, whatever the error: rewritings of the lighting equation.

A light's attenuation, direction and spot factor are then taken at the middle of the mesh.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pvphong.base.types import Float64Array
from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.shading.equation import Equation, LightTerm

Drop = Callable[[Equation, Float64Array], Equation]

_BLACK = (0.0, 0.0, 0.0)
_SHINIER = 4.0
"""Blinn-Phong needs about four times the shininess for the same highlight; see `Material.for_blinn_phong`."""


def without_highlights(equation: Equation, _middle: Float64Array) -> Equation:
    """Without specular reflection."""
    return _each(equation, lambda term: replace(term, specular=_BLACK))


def with_infinite_viewer(equation: Equation, _middle: Float64Array) -> Equation:
    """With the viewer at infinity, along the view axis: what `LightModel(local_viewer=False)` asks for."""
    return replace(equation, eye=None, local_facing=False)


def with_other_reflection(equation: Equation, _middle: Float64Array) -> Equation:
    """With Blinn-Phong in place of Phong or the other way round, and the shininess converted."""
    if equation.reflection == "phong":
        return replace(equation, reflection="blinn-phong", shininess=equation.shininess * _SHINIER)
    return replace(equation, reflection="phong", shininess=equation.shininess / _SHINIER)


def with_directional_lights(equation: Equation, middle: Float64Array, farther_than: float = 0.0) -> Equation:
    """With every positional light beyond a distance as a directional one."""

    def flattened(term: LightTerm) -> LightTerm:
        light = term.light
        if not isinstance(light, (PointLight, SpotLight)) or not math.dist(light.position, middle) > farther_than:
            return term
        arrival = light.arrival(middle[:, None])
        x, y, z = (-arrival.direction[:, 0]).tolist()
        strength = float(np.broadcast_to(arrival.strength, 1)[0])
        return replace(term, light=DirectionalLight(direction=(x, y, z)), gain=term.gain * strength)

    return _each(equation, flattened)


def _without_cones(equation: Equation, _middle: Float64Array) -> Equation:
    def opened(term: LightTerm) -> LightTerm:
        if not isinstance(term.light, SpotLight):
            return term
        return replace(term, light=PointLight(position=term.light.position, attenuation=term.light.attenuation))

    return _each(equation, opened)


def _without_attenuation(equation: Equation, middle: Float64Array) -> Equation:
    def even(term: LightTerm) -> LightTerm:
        light = term.light
        if not isinstance(light, (PointLight, SpotLight)):
            return term
        as_point = PointLight(position=light.position, attenuation=light.attenuation)
        strength = float(np.broadcast_to(as_point.arrival(middle[:, None]).strength, 1)[0])
        return replace(term, light=replace(light, attenuation=(1.0, 0.0, 0.0)), gain=term.gain * strength)

    return _each(equation, even)


def _each(equation: Equation, change: Callable[[LightTerm], LightTerm]) -> Equation:
    return replace(equation, terms=tuple(change(term) for term in equation.terms))


DROPS: dict[str, Drop] = {
    "emission": lambda equation, _: replace(equation, emission=_BLACK),
    "ambient": lambda equation, _: replace(equation, ambient=_BLACK),
    "lights": lambda equation, _: replace(equation, terms=()),
    "cone": _without_cones,
    "specular": without_highlights,
    "attenuation": _without_attenuation,
    "position": with_directional_lights,
    "local viewer": with_infinite_viewer,
    "diffuse": lambda equation, _: _each(equation, lambda term: replace(term, diffuse=_BLACK)),
    "two-sided": lambda equation, _: replace(equation, two_sided=False),
    "normal transform": lambda equation, _: replace(equation, turns_normals=False),
}
"""How each of the plan's effects is left out."""


def without_light(equation: Equation, index: int) -> Equation:
    """The equation without one of the scene's lights."""
    return replace(equation, terms=tuple(term for term in equation.terms if term.index != index))
