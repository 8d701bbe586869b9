"""An equation as two arrays of records, the form in which compiled code takes it."""

from __future__ import annotations

import math
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pvphong.base.ranges import BRIGHTEST
from pvphong.base.types import Vector
from pvphong.geometry.transform import normal_matrix
from pvphong.optics.lights import DirectionalLight, Light, PointLight, SpotLight
from pvphong.optics.reflectances import BlinnPhong, Phong
from pvphong.optics.reflectances.vtk import VtkHeadlight
from pvphong.shading.equation import Equation, LightTerm

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
        ("is_sunlit", "?"),
        ("has_phong", "?"),
        ("eye", "3f8"),
        ("to_eye", "3f8"),
        ("matrix", "(3,4)f8"),
        ("w", "f8"),
        ("normal_matrix", "(3,3)f8"),
        ("shininess", "f8"),
        ("floor", "f8"),
        ("log_floor", "f8"),
        ("dark", "f8"),
        ("base", "3f8"),
        ("emission", "3f8"),
        ("low", "f8"),
        ("high", "f8"),
    ],
    align=True,
)
"""What all lights share. `is_sunlit`: there is just one light, dull and parallel, no albedo, and normals are used as
they come. `has_phong`: some light has Phong's highlights. `log_floor`: log2 of `floor`.
`dark`: from this squared chord on, a highlight is 0."""

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
"""One light. `position`: for parallel light a vector towards it, whose inverse length is in the colours where there are
no highlights. `varies`: whether its strength is taken at each vertex; what of it is the same everywhere is in the
colours. `on_light`: what a vertex on the light gets of its strength."""

# Larger scene coordinates, and coefficients further from 1, are left to the reference: float32 could not hold
# their products. (Vertices may be anywhere.)
_LARGEST, _SMALLEST = 2.0**100, 2.0**-100


_KINDS = (DirectionalLight, PointLight, SpotLight)
_LAMPS = (PointLight, SpotLight)

_ORIGIN = (0.0, 0.0, 0.0)
_NO_MATRIX: tuple[Any, float, Any] = (((0.0,) * 4,) * 3, 1.0, ((0.0,) * 3,) * 3)


def fits(equation: Equation) -> bool:
    """Whether compiled code can take the equation: known lights, and numbers within its range."""
    lights = [term.light for term in equation.terms]
    if not all(type(light) in _KINDS for light in lights):
        return False
    if type(equation.reflectance) not in {Phong, BlinnPhong, VtkHeadlight}:
        return False
    numbers = [value for light in lights for value in _coefficients(light)]
    if equation.matrix is not None:
        matrix = equation.matrix
        if matrix[3, :3].any() or matrix[3, 3] == 0.0:
            return False  # the reference says what is wrong with it
        numbers += np.abs(matrix).ravel().tolist()
    positions = [x for light in lights for x in _position(light)] + list(equation.eye or ())
    return (
        all(x == 0.0 or _SMALLEST <= x <= _LARGEST for x in numbers)
        and all(abs(x) <= _LARGEST for x in positions)
        and not any(_is_glaring(term) for term in equation.terms)
    )


def _is_glaring(term: LightTerm) -> bool:
    """Whether a spot's strength would be cut off at `BRIGHTEST` before its falloff brings it down again."""
    light = term.light
    return (
        isinstance(light, SpotLight) and bool(light.exponent) and term.gain > BRIGHTEST * (light.attenuation[0] or 1.0)
    )


def settings(equation: Equation, *, is_wide: bool, has_albedo: bool) -> NDArray[Any]:
    """One record of type `SETTINGS`."""
    matrix, w, normals_matrix = _NO_MATRIX
    turns_normals = False
    if equation.matrix is not None:
        matrix, w = equation.matrix[:3].tolist(), equation.matrix[3, 3]
        if equation.needs_normals and equation.turns_normals:
            turns_normals = True
            normals_matrix = normal_matrix(equation.matrix).tolist()
    base = equation.ambient
    for term in equation.terms:
        if isinstance(term.light, DirectionalLight):
            base = _plus(base, _times(term.ambient, min(term.gain, BRIGHTEST)))
    floor = _floor(equation)
    highlights = {_highlight(term, equation) for term in equation.terms}
    record = {
        "needs_normals": equation.needs_normals,
        "needs_points": equation.needs_points,
        "needs_eye": equation.needs_eye,
        "is_flipped": equation.is_flipped,
        "has_local_facing": equation.local_facing,
        "moves_points": equation.matrix is not None,
        "turns_normals": turns_normals,
        "is_wide": is_wide or equation.matrix is not None,
        "is_sunlit": (
            highlights == {NO_HIGHLIGHT}
            and [type(term.light) for term in equation.terms] == [DirectionalLight]
            and equation.needs_normals
            and not (turns_normals or equation.is_flipped or has_albedo)
        ),
        "has_phong": PHONG in highlights,
        "eye": equation.eye or _ORIGIN,
        "to_eye": equation.to_eye,
        "matrix": matrix,
        "w": w,
        "normal_matrix": normals_matrix,
        "shininess": _exponent(equation.reflectance.sharpness),
        "floor": floor,
        "log_floor": math.log2(floor) if floor else -math.inf,
        "dark": math.inf if floor or not equation.reflectance.sharpness else 2.0,
        "base": base if has_albedo else _plus(base, equation.emission),
        "emission": equation.emission,
        "low": 0.0 if equation.clamp else -math.inf,
        "high": 1.0 if equation.clamp else math.inf,
    }
    return _records(SETTINGS, [record])


def terms(equation: Equation) -> NDArray[Any]:
    """One record of type `TERM` for each light."""
    return _records(TERM, [_term(term, equation) for term in equation.terms])


def _records(kind: np.dtype[Any], values: list[dict[str, Any]]) -> NDArray[Any]:
    """Records of a type from the values of their fields: a field at a time would take several times as long."""
    assert kind.names is not None
    return np.array(list(map(itemgetter(*kind.names), values)), kind)


def _term(term: LightTerm, equation: Equation) -> dict[str, Any]:
    light = term.light
    constant, linear, quadratic = _coefficients(light)
    record: dict[str, Any] = {
        "is_parallel": False,
        "varies": False,
        "has_cone": False,
        "has_ambient": False,
        "needs_normals": any(term.colors[0]) or any(term.colors[1]),
        "highlight": _highlight(term, equation),
        "position": _position(light),
        "axis": _ORIGIN,
        "edge": 0.0,
        "exponent": 0.0,
        "dark": 0.0,
        "constant": 1.0,
        "linear": 0.0,
        "quadratic": 0.0,
        "gain": 1.0,
        "on_light": 1.0,
    }
    matt = 1.0
    if isinstance(light, DirectionalLight):
        way, inverse_length = light.way
        record |= {"is_parallel": True, "position": way}
        matt = inverse_length if record["highlight"] == NO_HIGHLIGHT else 1.0
    elif linear or quadratic or any(term.ambient):
        record |= {"varies": True, "has_ambient": any(term.ambient)}
    if isinstance(light, SpotLight):
        record |= _cone(light)
    if linear or quadratic:
        record |= _attenuated(term)
        strength = 1.0
    else:  # in its colours also for a spot: these are the bits of the point light that a plan may make of it
        strength = min(term.gain / constant, BRIGHTEST)
    return record | {
        "ambient": _times(term.ambient, strength),
        "diffuse": _times(term.colors[0], strength * matt),
        "specular": _times(term.colors[1], strength),
    }


def _attenuated(term: LightTerm) -> dict[str, Any]:
    """Strength by distance.

    The gain is brought between 2^-21 and 2^100, and the rest of it goes into the coefficients, which may leave
    float32's range for that. Where they sum to 0 or less than a normal number, the strength is beyond `BRIGHTEST`;
    where they are infinite, it is below 2^-60.
    """
    constant, linear, quadratic = _coefficients(term.light)
    exponent = math.frexp(term.gain)[1]
    excess = 2.0 ** (exponent - min(max(exponent, -20), 100))
    return {
        "constant": constant / excess,
        "linear": linear / excess,
        "quadratic": quadratic / excess,
        "gain": term.gain / excess,
    }


def _cone(light: SpotLight) -> dict[str, Any]:
    return {
        "has_cone": True,
        "varies": True,
        "on_light": float(light.cone_angle == 90.0 and light.exponent == 0.0),
        "axis": light.axis,
        "edge": 4.0 * math.sin(math.radians(light.cone_angle) / 2.0) ** 2,
        "exponent": _exponent(light.exponent),
        "dark": 2.0 if light.exponent else math.inf,
    }


def _highlight(term: LightTerm, equation: Equation) -> int:
    if isinstance(equation.reflectance, VtkHeadlight):
        return HEADLIGHT
    if not any(term.colors[1]):
        return NO_HIGHLIGHT
    return PHONG if isinstance(equation.reflectance, Phong) else BLINN_PHONG


def _floor(equation: Equation) -> float:
    return getattr(equation.reflectance, "floor", 0.0)


def _plus(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _times(color: Vector, factor: float) -> Vector:
    red, green, blue = color
    return red * factor, green * factor, blue * factor


def _exponent(value: float) -> float:
    """Within float32, and not 0 unless it is 0."""
    return value and max(float(np.finfo(np.float32).tiny), min(value, BRIGHTEST))


def _position(light: Light) -> Vector:
    if isinstance(light, _LAMPS):
        x, y, z = light.position
        return x, y, z
    return _ORIGIN


def _coefficients(light: Light) -> Vector:
    if isinstance(light, _LAMPS):
        constant, linear, quadratic = light.attenuation
        return constant, linear, quadratic
    return 1.0, 0.0, 0.0
