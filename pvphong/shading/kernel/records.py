"""An equation as two arrays of records and one of numbers, the form in which compiled code takes it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from operator import itemgetter
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from pvphong.base.ranges import BRIGHTEST
from pvphong.base.types import Float64Array, Vector
from pvphong.geometry.extent import ANYWHERE
from pvphong.geometry.transform import normal_matrix
from pvphong.optics.light import Light, Stage
from pvphong.shading.equation import Equation, LightTerm

SETTINGS = np.dtype(
    [
        ("needs_normals", "?"),
        ("needs_points", "?"),
        ("needs_eye", "?"),
        ("is_flipped", "?"),
        ("has_local_facing", "?"),
        ("has_lobes_of_viewer", "?"),
        ("moves_points", "?"),
        ("is_wide", "?"),
        ("turns_normals", "?"),
        ("has_albedo", "?"),
        ("is_display", "?"),
        ("is_sunlit", "?"),
        ("is_even", "?"),
        ("count", "i8"),
        ("stride", "i8"),
        ("sky", "i8"),
        ("tangents", "i8"),
        ("channel_length", "i8"),
        ("takes_albedo", "i8"),
        ("eye", "3f8"),
        ("to_eye", "3f8"),
        ("matrix", "(3,4)f8"),
        ("w", "f8"),
        ("normal_matrix", "(3,3)f8"),
        ("base", "3f8"),
        ("own", "3f8"),
        ("emission", "3f8"),
        ("exponent", "f8"),
        ("low", "f8"),
        ("high", "f8"),
    ],
    align=True,
)
"""What all lights share. `is_sunlit`: there is just one light, even and with Lambert's factor alone, no albedo, and
normals are used as they come. `is_even`: every vertex has the same colour. `count`: of lights. `stride`: how many
numbers each stage has. `sky`, `tangents`: the channel with the open part of the sky, and the first of three with
tangents, or -1. `channel_length`: from one channel to the next. `own`: a colour beside `base` that the sky has no part
in. `is_wide`: points are float64 beside rows of float32. `takes_albedo`: lobes that do, as the sum of 1, 2 and 4.
`exponent`: the sum of all light is raised to it."""

TERM = np.dtype(
    [
        ("is_even", "?"),
        ("varies", "?"),
        ("has_ambient", "?"),
        ("wanted", "i8"),
        ("visible", "i8"),
        ("arrives", "i8"),
        ("reflects", "i8"),
        ("gain", "f8"),
        ("way", "3f8"),
        ("ambient", "3f8"),
        ("colors", "(3,3)f8"),
    ],
    align=True,
)
"""One light. `is_even`: the same everywhere, from the direction `way`, whose inverse length is in the colours where
Lambert's factor is added straight. `varies`: whether its strength is taken at each vertex; what of it is the same
everywhere is in the colours, and `gain`, a power of two, goes with the strength. `wanted`: lobes that are not black,
as the sum of 1, 2 and 4. `visible`: the channel with its visible part, or -1. `arrives`, `reflects`: addresses of
the stages, 0 for those that the driver has."""

_LARGEST = 2.0**100
"""Scene coordinates further out are left to the reference: float32 could not hold squares of sums with them.
(Vertices may be anywhere.)"""

_ORIGIN = (0.0, 0.0, 0.0)
_NO_MATRIX: tuple[Any, float, Any] = (((0.0,) * 4,) * 3, 1.0, ((0.0,) * 3,) * 3)
_MOST_LOBES = 3

# What a strength that varies is multiplied by in compiled code is between these powers of two, if there are numbers
# that divide it, into which the rest can go.
_LEAST_GAIN, _MOST_GAIN, _IN_FLOAT32 = -20, 100, 126


class Stages(Protocol):
    """Where stages come from."""

    @property
    def toolkit(self) -> Any:
        """What they are written with."""

    def light(self, function: Any, real: str) -> int:
        """Address of a light's stage for a type of rows."""

    def reflectance(self, function: Any, real: str) -> int:
        """Address of a reflectance's stage for a type of rows."""


class Records(NamedTuple):
    """What the driver reads of an equation."""

    settings: NDArray[Any]
    """One of type `SETTINGS`."""
    terms: NDArray[Any]
    """Of type `TERM`, one for each light."""
    numbers: Float64Array
    """Of the reflectance's stage, then of each light's; a row each."""


def fits(equation: Equation, toolkit: Any, real: str, *, has_albedo: bool) -> bool:
    """Whether compiled code can take the equation: all have stages, and numbers are within its range."""
    lobes = equation.reflectance.lobes
    if equation.maps or (has_albedo and any(lobe.tint for lobe in lobes)):
        return False
    if len(lobes) > _MOST_LOBES or equation.reflectance.stage(toolkit, (True,) * len(lobes)) is None:
        return False
    if equation.matrix is not None:
        matrix = equation.matrix
        if matrix[3, :3].any() or matrix[3, 3] == 0.0:
            return False  # the reference says what is wrong with it
        if not toolkit.holds(np.abs(matrix).ravel().tolist()):
            return False
    return _are_in_range(equation.eye or ()) and all(_fits(term, equation, toolkit, real) for term in equation.terms)


def _fits(term: LightTerm, equation: Equation, toolkit: Any, real: str) -> bool:
    if term.light.is_even and not term.is_whole:
        return True
    if term.is_whole:
        stage, numbers = _of_whole(term, equation, toolkit) if real == "float32" else (None, ())
    else:
        stage, numbers = term.light.stage(toolkit), term.light.parameters()
    if stage is None or not _are_in_range(numbers):
        return False
    return not stage.varies or term.gain <= stage.most_gain


def _of_whole(term: LightTerm, equation: Equation, toolkit: Any) -> tuple[Stage | None, tuple[float, ...]]:
    """Stage and numbers of a light with a size, for the lobes that are wanted of it."""
    forms = tuple(
        form if any(color) else None for form, color in zip(equation.reflectance.forms, term.colors, strict=True)
    )
    return term.light.closed_stage(toolkit, forms), term.light.closed_parameters(forms)


def _are_in_range(numbers: Iterable[float]) -> bool:
    return all(abs(x) <= _LARGEST for x in numbers)


def records_of(
    equation: Equation,
    stages: Stages,
    real: str,
    *,
    is_wide: bool,
    has_albedo: bool,
    is_display: bool,
    channel_length: int = 0,
) -> Records:
    """An equation that `fits`, for rows of a type; `is_wide` if vertices are stored in a wider one."""
    matrix, w, normals_matrix = _NO_MATRIX
    turns_normals = False
    if equation.matrix is not None:
        matrix, w = equation.matrix[:3].tolist(), equation.matrix[3, 3]
        if equation.needs_normals and equation.turns_normals:
            turns_normals = True
            normals_matrix = normal_matrix(equation.matrix).tolist()
    base, terms, numbers = equation.ambient, [], [equation.reflectance.parameters()]
    for term in equation.terms:
        record, own, everywhere = _term(term, equation, stages, real)
        base = _plus(base, everywhere)
        terms.append(record)
        numbers.append(own)
    stride = max(map(len, numbers))
    settings = {
        "needs_normals": equation.needs_normals,
        "needs_points": equation.needs_points,
        "needs_eye": equation.needs_eye,
        "is_flipped": equation.is_flipped,
        "has_local_facing": equation.local_facing,
        "has_lobes_of_viewer": equation.has_highlights,
        "moves_points": equation.matrix is not None,
        "is_wide": equation.needs_points and (is_wide or equation.matrix is not None),
        "turns_normals": turns_normals,
        "has_albedo": has_albedo,
        "is_display": is_display,
        "is_sunlit": (
            [(record["is_even"], record["wanted"], record["reflects"], record["visible"]) for record in terms]
            == [(True, 1, 0, -1)]
            and not (turns_normals or equation.is_flipped or equation.is_occluded or has_albedo or is_display)
        ),
        "is_even": not (equation.needs_normals or equation.needs_points or equation.is_occluded or has_albedo),
        "count": len(terms),
        "stride": stride,
        "sky": equation.lights if equation.is_occluded else -1,
        "tangents": equation.channels["tangents"].start if equation.needs_tangents else -1,
        "channel_length": channel_length,
        "takes_albedo": _sum_of(lobe.takes_albedo for lobe in equation.reflectance.lobes),
        "eye": equation.eye or _ORIGIN,
        "to_eye": equation.to_eye,
        "matrix": matrix,
        "w": w,
        "normal_matrix": normals_matrix,
        "base": base if has_albedo or equation.is_occluded else _plus(base, equation.emission),
        "own": _ORIGIN if has_albedo else equation.emission,
        "emission": equation.emission,
        "exponent": 1.0 / equation.gamma,
        "low": 0.0 if equation.clamp else -math.inf,
        "high": 1.0 if equation.clamp else math.inf,
    }
    table = np.array([[*own, *(0.0,) * (stride - len(own))] for own in numbers])
    return Records(_records(SETTINGS, [settings]), _records(TERM, terms), table)


def _records(kind: np.dtype[Any], values: list[dict[str, Any]]) -> NDArray[Any]:
    """Records of a type from the values of their fields: a field at a time would take several times as long."""
    assert kind.names is not None
    return np.array(list(map(itemgetter(*kind.names), values)), kind)


def _term(
    term: LightTerm, equation: Equation, stages: Stages, real: str
) -> tuple[dict[str, Any], tuple[float, ...], Vector]:
    """Record and numbers of a light, and what it adds everywhere."""
    wanted = tuple(map(any, term.colors))
    function = stages.toolkit.already_there
    if not term.is_whole:
        function = equation.reflectance.stage(stages.toolkit, wanted) if any(wanted) else None
    is_lambert = function is stages.toolkit.only_lambert
    record: dict[str, Any] = {
        "is_even": term.light.is_even and not term.is_whole,
        "varies": False,
        "has_ambient": False,
        "wanted": _sum_of(wanted),
        "visible": term.index if term.is_shadowed else -1,
        "arrives": 0,
        "reflects": 0 if function is None or is_lambert else stages.reflectance(function, real),
        "gain": 1.0,
        "way": _ORIGIN,
        "ambient": term.ambient,
    }
    if record["is_even"]:
        way, strength, inverse_length = _even_arrival(term.light)
        strength = min(term.gain * strength, BRIGHTEST)
        colors = _colors(term, strength * inverse_length if is_lambert else strength)
        return record | {"way": way, "colors": colors}, (), _times(term.ambient, strength)
    light, factor = _simplest(term.light)
    if term.is_whole:
        stage, numbers = _of_whole(term, equation, stages.toolkit)
    else:
        stage, numbers = light.stage(stages.toolkit), light.parameters()
    strength = term.gain * factor
    assert stage is not None
    record |= {"arrives": stages.light(stage.function, real), "has_ambient": any(term.ambient)}
    if stage.varies:
        strength, exponent = _parted(strength)
        kept = min(exponent, _IN_FLOAT32)
        if numbers[stage.divisors]:
            kept = min(max(exponent, _LEAST_GAIN), _MOST_GAIN)
            numbers = _divided(numbers, stage.divisors, 2.0 ** (exponent - kept))
        record |= {"varies": True, "gain": 2.0**kept}
    else:
        strength = min(strength, BRIGHTEST)
    record |= {"ambient": _times(term.ambient, strength), "colors": _colors(term, strength)}
    return record, numbers, _ORIGIN


def _parted(number: float) -> tuple[float, int]:
    """What is 1 or more and less than 2, and the power of two."""
    mantissa, exponent = math.frexp(number)
    return 2.0 * mantissa, exponent - 1


def _divided(numbers: tuple[float, ...], those: slice, factor: float) -> tuple[float, ...]:
    """Some of the numbers over a factor; they may leave float32's range for that."""
    if factor == 1.0:
        return numbers
    changed = list(numbers)
    changed[those] = [number / factor for number in numbers[those]]
    return tuple(changed)


def _simplest(light: Light) -> tuple[Light, float]:
    """The same light to the last bit, with a strength that is the same everywhere taken out of it.

    It then goes into the colours, also for a light whose strength varies for other reasons: these are the bits of
    the simpler light that a plan may make of it.
    """
    for effect in sorted(light.effects):
        choice = light.simpler(effect, ANYWHERE, exactly=True)
        if choice is not None and choice.make is not None:
            return choice.make(), choice.factor
    return light, 1.0


def _even_arrival(light: Light) -> tuple[Vector, float, float]:
    """Way, strength and inverse length of a light that arrives everywhere alike."""
    way, strength, inverse_length = light.arrival(np.zeros((3, 1)))
    x, y, z = way[:, 0].tolist()
    return (x, y, z), float(np.ravel(strength)[0]), float(np.ravel(inverse_length)[0])


def _colors(term: LightTerm, factor: float) -> list[Vector]:
    """Of three lobes; those that are not there are black."""
    missing = _MOST_LOBES - len(term.colors)
    return [*(_times(color, factor) for color in term.colors), *[_ORIGIN] * missing]


def _sum_of(flags: Iterable[bool]) -> int:
    return sum(1 << k for k, flag in enumerate(flags) if flag)


def _plus(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _times(color: Vector, factor: float) -> Vector:
    red, green, blue = color
    return red * factor, green * factor, blue * factor
