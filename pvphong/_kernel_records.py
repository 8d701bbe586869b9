"""An equation as two arrays of records, the form in which compiled code takes it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pvphong import _check
from pvphong._types import Vector
from pvphong._vectors import unit
from pvphong.equation import BRIGHTEST, Equation, LightTerm
from pvphong.lights import DirectionalLight, Light, PointLight, SpotLight
from pvphong.transform import normal_matrix

NO_HIGHLIGHT, PHONG, BLINN_PHONG, HEADLIGHT = range(4)
"""Kinds of highlight."""

SETTINGS = np.dtype(
    [
        ("needs_normals", "?"),
        ("needs_points", "?"),
        ("needs_eye", "?"),
        ("is_flipped", "?"),
        ("has_local_facing", "?"),
        ("moves_points", "?"),
        ("turns_normals", "?"),
        ("is_wide", "?"),
        ("eye", "3f8"),
        ("to_eye", "3f8"),
        ("matrix", "(3,4)f8"),
        ("w", "f8"),
        ("normal_matrix", "(3,3)f8"),
        ("shininess", "f8"),
        ("floor", "f8"),
        ("dark", "f8"),
        ("base", "3f8"),
        ("emission", "3f8"),
        ("low", "f8"),
        ("high", "f8"),
    ],
    align=True,
)
"""What all lights share. `dark`: from this squared chord on, a highlight is 0."""

TERM = np.dtype(
    [
        ("is_parallel", "?"),
        ("varies", "?"),
        ("has_cone", "?"),
        ("has_ambient", "?"),
        ("needs_normals", "?"),
        ("highlight", "i8"),
        ("position", "3f8"),
        ("axis", "3f8"),
        ("edge", "f8"),
        ("exponent", "f8"),
        ("dark", "f8"),
        ("constant", "f8"),
        ("linear", "f8"),
        ("quadratic", "f8"),
        ("gain", "f8"),
        ("on_light", "f8"),
        ("ambient", "3f8"),
        ("diffuse", "3f8"),
        ("specular", "3f8"),
    ],
    align=True,
)
"""One light. `position`: for parallel light the unit vector towards it. `varies`: whether its strength is taken
at each vertex; else the strength is in the colours. `on_light`: what a vertex on the light gets of its strength."""

# Larger scene coordinates, and coefficients further from 1, are left to the reference: float32 could not hold
# their products. (Vertices may be anywhere.)
_LARGEST, _SMALLEST = 2.0**100, 2.0**-100


def fits(equation: Equation) -> bool:
    """Whether compiled code can take the equation: known lights, and numbers within its range."""
    numbers = [value for term in equation.terms for value in _coefficients(term.light)]
    if equation.matrix is not None:
        matrix = _check.matrix4("matrix", equation.matrix)
        if matrix[3, :3].any() or matrix[3, 3] == 0.0:
            return False  # the reference says what is wrong with it
        numbers += np.abs(matrix).ravel().tolist()
    positions = [x for term in equation.terms for x in _position(term.light)] + list(equation.eye or ())
    return (
        all(isinstance(term.light, DirectionalLight | PointLight | SpotLight) for term in equation.terms)
        and all(x == 0.0 or _SMALLEST <= x <= _LARGEST for x in numbers)
        and all(abs(x) <= _LARGEST for x in positions)
    )


def settings(equation: Equation, *, is_wide: bool, has_albedo: bool) -> NDArray[Any]:
    """One record of type `SETTINGS`."""
    records = np.zeros(1, SETTINGS)
    s = records[0]
    for name in ("needs_normals", "needs_points", "needs_eye", "is_flipped", "to_eye", "emission"):
        s[name] = getattr(equation, name)
    s["has_local_facing"] = equation.local_facing
    if equation.eye is not None:
        s["eye"] = equation.eye
    s["is_wide"] = is_wide or equation.matrix is not None
    if equation.matrix is not None:
        _set_matrix(s, equation)
    s["shininess"], s["floor"] = _exponent(equation.shininess), equation.cosine_floor
    s["dark"] = math.inf if equation.cosine_floor or not equation.shininess else 2.0
    parallel = [term for term in equation.terms if isinstance(term.light, DirectionalLight)]
    everywhere = [_times(term.ambient, min(term.gain, BRIGHTEST)) for term in parallel]
    base = np.sum([equation.ambient, *everywhere], axis=0)
    s["base"] = base if has_albedo else base + equation.emission
    s["low"], s["high"] = (0.0, 1.0) if equation.clamp else (-math.inf, math.inf)
    return records


def _set_matrix(s: Any, equation: Equation) -> None:
    matrix = _check.matrix4("matrix", equation.matrix)
    s["moves_points"], s["matrix"], s["w"] = True, matrix[:3], matrix[3, 3]
    if equation.needs_normals and equation.turns_normals:
        s["turns_normals"], s["normal_matrix"] = True, normal_matrix(matrix)


def terms(equation: Equation) -> NDArray[Any]:
    """One record of type `TERM` for each light."""
    records = np.zeros(len(equation.terms), TERM)
    for t, term in zip(records, equation.terms, strict=True):
        t["needs_normals"] = any(term.diffuse) or any(term.specular)
        t["highlight"] = _highlight(equation) if any(term.specular) else NO_HIGHLIGHT
        if equation.headlight_only:
            t["highlight"] = HEADLIGHT
        if isinstance(term.light, DirectionalLight):
            t["is_parallel"] = True
            t["position"] = -unit(np.array(term.light.direction, dtype=np.float64)[:, None])[0][:, 0]
            _set_colors(t, term, min(term.gain, BRIGHTEST))
        else:
            _set_positional(t, term)
    return records


def _set_positional(t: Any, term: LightTerm) -> None:
    constant, linear, quadratic = _coefficients(term.light)
    t["position"] = _position(term.light)
    t["has_cone"] = isinstance(term.light, SpotLight)
    t["has_ambient"] = any(term.ambient)
    t["varies"] = linear or quadratic or t["has_cone"] or t["has_ambient"]
    # A gain beyond float32's range goes into the coefficients; one that underflows there belongs to a strength that
    # is cut off at the most anyway.
    excess = max(term.gain / BRIGHTEST, 1.0)
    t["gain"] = term.gain / excess
    t["constant"], t["linear"], t["quadratic"] = constant / excess, linear / excess, quadratic / excess
    t["on_light"] = 1.0
    _set_colors(t, term, 1.0 if t["varies"] else min(term.gain / constant, BRIGHTEST))
    if isinstance(term.light, SpotLight):
        t["on_light"] = float(term.light.cone_angle == 90.0 and term.light.exponent == 0.0)
        t["axis"] = unit(np.array(term.light.direction, dtype=np.float64)[:, None])[0][:, 0]
        t["edge"] = 4.0 * math.sin(math.radians(term.light.cone_angle) / 2.0) ** 2
        t["exponent"] = _exponent(term.light.exponent)
        t["dark"] = 2.0 if term.light.exponent else math.inf


def _set_colors(t: Any, term: LightTerm, strength: float) -> None:
    for name in ("ambient", "diffuse", "specular"):
        t[name] = _times(getattr(term, name), strength)


def _highlight(equation: Equation) -> int:
    return PHONG if equation.reflection == "phong" else BLINN_PHONG


def _times(color: Vector, factor: float) -> Vector:
    red, green, blue = color
    return red * factor, green * factor, blue * factor


def _exponent(value: float) -> float:
    """Within float32, and not 0 unless it is 0."""
    return value and max(float(np.finfo(np.float32).tiny), min(value, BRIGHTEST))


def _position(light: Light) -> Vector:
    if isinstance(light, PointLight | SpotLight):
        x, y, z = light.position
        return x, y, z
    return 0.0, 0.0, 0.0


def _coefficients(light: Light) -> Vector:
    if isinstance(light, PointLight | SpotLight):
        constant, linear, quadratic = light.attenuation
        return constant, linear, quadratic
    return 1.0, 0.0, 0.0
