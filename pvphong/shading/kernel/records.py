"""An equation as records and numbers, packed into bytes: the form in which compiled code takes it.

First each light, as a stage, numbers for it, and a record for the driver; then what all of them share.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable, Sequence
from itertools import chain
from typing import Any, NamedTuple, Protocol

import numpy as np

from pvphong.base.float_range import BRIGHTEST
from pvphong.base.formulas import FORMULAS
from pvphong.base.types import Vector
from pvphong.geometry.transform import normal_matrix
from pvphong.optics.light import Light
from pvphong.optics.reflectance import LAMBERT
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.kernel.stages import (
    LEAST_NUMBERS,
    already_there,
    integral_numbers,
    integral_stage,
    light_numbers,
    light_stage,
    reflectance_numbers,
    reflectance_stage,
)

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
"""One light. `is_even`: the same everywhere, from the direction `way`. `varies`: whether its strength is taken at each
vertex; what of it is the same everywhere is in the colours, and `gain`, a power of two, goes with the strength.
`wanted`: lobes that are not black, as the sum of 1, 2 and 4. `visible`: the channel with its visible part, or -1.
`arrives`, `reflects`: addresses of the stages, 0 for those that the driver has."""


def layout_of(kind: np.dtype[Any]) -> struct.Struct:
    """What packs the fields of a record: NumPy takes ten times as long to make one of a tuple."""
    types = (kind[name] for name in kind.names or ())
    return struct.Struct("@" + "".join(f"{math.prod(each.shape)}{each.base.char}" for each in types))


_LAYOUT_OF_TERM = layout_of(TERM)

MOST_LOBES = 3

_LARGEST = 2.0**100
"""Scene coordinates further out are left to the reference: float32 could not hold squares of sums with them.
(Vertices may be anywhere.)"""

_NOWHERE = (0.0, 0.0, 0.0)

# What a strength that varies is multiplied by in compiled code is between these powers of two, if there are numbers
# that divide it, into which the rest can go.
_LEAST_GAIN, _MOST_GAIN, _IN_FLOAT32 = -20, 100, 126


class Stages(Protocol):
    """Where stages come from."""

    def light(self, function: Any, real: str) -> int:
        """Address of a light's stage for a type of rows."""

    def reflectance(self, function: Any, real: str) -> int:
        """Address of a reflectance's stage for a type of rows."""


class TermCode(NamedTuple):
    """What lights with one term."""

    stage: Callable[..., Any] | None
    """None where the driver does it."""
    numbers: tuple[float, ...] = ()
    """For the stage."""
    varies: bool = False
    """Whether it writes strengths; they are 1 everywhere if not."""
    divisors: slice = slice(0)
    """Those of the numbers that divide the strength: all of them times k make it 1/k of what it was.

    With them a light may be so bright, and so far away, that float32 holds neither by itself."""


Codes = dict[int, TermCode]
"""Identity of a term → its code: most terms are left as they are by a plan, and are asked once for both equations."""

_BY_DRIVER = TermCode(None)


def codes_of_lights(equation: Equation, real: str) -> Codes | None:
    """The code of each light's term; None where one has none, or numbers that are out of its range."""
    codes = {id(term): _code_of(term, equation, real) for term in equation.terms}
    return None if None in codes.values() else codes  # type: ignore[return-value]  # none is None


def _code_of(term: LightTerm, equation: Equation, real: str) -> TermCode | None:
    light = term.light
    if light.is_even and not light.has_size:
        return _BY_DRIVER
    if light.has_size:
        forms = [
            form if any(color) else None for form, color in zip(equation.reflectance.forms, term.colors, strict=True)
        ]
        integrals = [form and light.closed(form) for form in forms]
        if any(each is not None and each.formula not in FORMULAS for each in integrals):
            return None
        code = TermCode(integral_stage(integrals, forms), integral_numbers(term.gain, integrals, forms, real))
        return code if are_in_range(code.numbers[:3]) else None
    placement = light.placement
    if placement is None or not holds(placement.attenuation):
        return None
    weakens = placement.attenuation != (1.0, 0.0, 0.0)
    code = TermCode(
        light_stage(placement.falloff, weakens),
        light_numbers(placement),
        weakens or placement.falloff is not None,
        slice(3, 6 if weakens else 3),
    )
    is_held = are_in_range(placement.position) and (not code.varies or term.gain <= placement.most_gain)
    return code if is_held else None


def holds(numbers: Iterable[Any]) -> bool:
    """Whether float32 holds products of numbers >= 0: each is 0, or not further than 2¹⁰⁰ from 1."""
    for x in numbers:  # noqa: SIM110 as for `are_in_range`: a third of the time
        if x and not 1.0 / _LARGEST <= x <= _LARGEST:
            return False
    return True


def are_in_range(numbers: Iterable[float]) -> bool:
    """Whether compiled code takes such coordinates."""
    for x in numbers:  # noqa: SIM110 asked for each light, and takes a third of the time that `all` does
        if not abs(x) <= _LARGEST:
            return False
    return True


class Record(NamedTuple):
    """One of type `TERM`; `colors` are in one piece."""

    is_even: bool
    varies: bool
    has_ambient: bool
    wanted: int
    visible: int
    arrives: int
    reflects: int
    gain: float
    way: Vector
    ambient: Vector
    colors: list[float]


def joined(records: Iterable[Record]) -> bytes:
    """Records one after the other."""
    return b"".join([_LAYOUT_OF_TERM.pack(*each[:-3], *each.way, *each.ambient, *each.colors) for each in records])


class _Lobes(NamedTuple):
    """What is wanted of a reflectance, and its stage's address: 0 for none, and where it is Lambert's of the driver."""

    wanted: int
    address: int
    is_lambert: bool = False


class Coder:
    """Makes the records of an equation's terms; each stage is asked for but once."""

    def __init__(self, equation: Equation, codes: Codes, stages: Stages, real: str) -> None:
        self._equation, self._codes, self._stages, self._real = equation, codes, stages, real
        self._arrives: dict[Any, int] = {}
        self._reflects: dict[tuple[bool, ...], _Lobes] = {}

    def record(self, term: LightTerm) -> tuple[Record, tuple[float, ...]]:
        """A term's record, and the numbers for its stage."""
        code = self._codes.get(id(term)) or _code_of(term, self._equation, self._real)
        assert code is not None
        stage, numbers, varies, divisors = code
        if stage is None:
            return self._even(term), numbers
        gain, lobes = 1.0, self._lobes(term)
        strength = 1.0 if term.light.has_size else term.gain  # its stage's factors have that
        if varies:
            strength, exponent = _parted(strength)
            kept = min(exponent, _IN_FLOAT32)
            if numbers[divisors]:
                kept = min(max(exponent, _LEAST_GAIN), _MOST_GAIN)
                numbers = _divided(numbers, divisors, 2.0 ** (exponent - kept))
            gain = 2.0**kept
        else:
            strength = min(strength, BRIGHTEST)
        return Record(
            is_even=False,
            varies=varies,
            has_ambient=any(term.ambient),
            wanted=lobes.wanted,
            visible=term.index if term.is_shadowed else -1,
            arrives=self._light(stage),
            reflects=lobes.address,
            gain=gain,
            way=_NOWHERE,
            ambient=_times(term.ambient, strength),
            colors=_colors(term, strength),
        ), numbers

    def _even(self, term: LightTerm) -> Record:
        """Of a light that arrives everywhere alike: the driver has its ambient colour elsewhere."""
        way, arriving, _ = _even_arrival(term.light)
        strength = min(term.gain * arriving, BRIGHTEST)
        lobes = self._lobes(term)
        return Record(
            is_even=True,
            varies=False,
            has_ambient=False,
            wanted=lobes.wanted,
            visible=term.index if term.is_shadowed else -1,
            arrives=0,
            reflects=lobes.address,
            gain=1.0,
            way=way,
            ambient=_times(term.ambient, strength),
            colors=_colors(term, strength),
        )

    def _light(self, function: Any) -> int:
        """The address of a light's stage."""
        if function not in self._arrives:
            self._arrives[function] = self._stages.light(function, self._real)
        return self._arrives[function]

    def _lobes(self, term: LightTerm) -> _Lobes:
        """What adds a term's lobes; a light with a size has a stage that writes their factors too."""
        wanted = term.shines
        if term.light.has_size:
            return _Lobes(sum_of(wanted), self._stages.reflectance(already_there, self._real))
        if wanted not in self._reflects:
            reflectance = self._equation.reflectance
            is_lambert = wanted[0] and True not in wanted[1:] and reflectance.lobes[0] is LAMBERT
            address = 0
            if True in wanted and not is_lambert:
                address = self._stages.reflectance(reflectance_stage(reflectance, wanted), self._real)
            self._reflects[wanted] = _Lobes(sum_of(wanted), address, is_lambert)
        return self._reflects[wanted]


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


def _even_arrival(light: Light) -> tuple[Vector, float, float]:
    """Way, strength and inverse length of a light that arrives everywhere alike."""
    way, strength, inverse_length = light.arrival(np.zeros((3, 1)))
    x, y, z = way[:, 0].tolist()
    return (x, y, z), np.asarray(strength).item(), np.asarray(inverse_length).item()


def _colors(term: LightTerm, factor: float) -> list[float]:
    """Of three lobes; those that are not there are black."""
    channels = [channel * factor for color in term.colors for channel in color]
    return channels + [0.0] * (3 * MOST_LOBES - len(channels))


def sum_of(flags: Iterable[bool]) -> int:
    """Flags as one number, the first as 1, the next as 2, then 4."""
    return sum([1 << k for k, flag in enumerate(flags) if flag])


def _times(color: Vector, factor: float) -> Vector:
    red, green, blue = color
    return red * factor, green * factor, blue * factor


# --- what all lights share


SETTINGS = np.dtype(
    [
        ("needs_normals", "?"),
        ("needs_points", "?"),
        ("needs_eye", "?"),
        ("is_flipped", "?"),
        ("has_local_facing", "?"),
        ("has_lobes_of_viewer", "?"),
        ("moves_points", "?"),
        ("turns_normals", "?"),
        ("has_albedo", "?"),
        ("is_display", "?"),
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
"""What all lights share. `count`: of lights. `stride`: how many numbers each stage has. `sky`, `tangents`: the channel
with the open part of the sky, and the first of three with tangents, or -1. `channel_length`: from one channel to the
next. `own`: a colour beside `base` that the sky has no part in. `takes_albedo`: lobes that do, as the sum of 1, 2 and
4. `exponent`: the sum of all light is raised to it."""

_LAYOUT_OF_SETTINGS = layout_of(SETTINGS)

_ORIGIN = (0.0, 0.0, 0.0)
_NO_MATRIX: tuple[Sequence[float], float, Sequence[float]] = (0.0,) * 12, 1.0, (0.0,) * 9


class Records(NamedTuple):
    """What the driver reads of an equation."""

    settings: bytes
    """One of type `SETTINGS`."""
    terms: bytes
    """Of type `TERM`, one for each light."""
    numbers: bytes
    """Floats of the reflectance's stage, then of each light's; a row each, filled up with zeros."""


def codes_of(equation: Equation, real: str, *, has_albedo: bool) -> Codes | None:
    """The code of each of its lights; None where compiled code cannot take the equation.

    It can if all lights and the reflectance have stages, and numbers are within its range.
    """
    lobes = equation.reflectance.lobes
    if equation.maps or (has_albedo and any(lobe.tint for lobe in lobes)):
        return None
    if len(lobes) > MOST_LOBES or type(equation.reflectance).factors not in FORMULAS:
        return None
    if equation.matrix is not None:
        matrix = equation.matrix
        if matrix[3, :3].any() or matrix[3, 3] == 0.0:
            return None  # the reference says what is wrong with it
        if not holds(np.abs(matrix).ravel().tolist()):
            return None
    return codes_of_lights(equation, real) if are_in_range(equation.eye or ()) else None


def records_of(
    equation: Equation,
    codes: Codes,
    stages: Stages,
    real: str,
    *,
    has_albedo: bool,
    is_display: bool,
    channel_length: int = 0,
) -> Records:
    """An equation for rows of a type.

    Codes are those of this equation, or of the whole one of which a plan has left it.
    """
    matrix, w, normals_matrix = _NO_MATRIX
    turns_normals = equation.matrix is not None and equation.needs_normals and equation.turns_normals
    if equation.matrix is not None:
        matrix, w = equation.matrix[:3].ravel().tolist(), equation.matrix[3, 3]
        if turns_normals:
            normals_matrix = normal_matrix(equation.matrix).ravel().tolist()
    coder = Coder(equation, codes, stages, real)
    base, numbers = equation.ambient, [reflectance_numbers(equation.reflectance)]
    lights: list[Record] = []
    for term in equation.terms:
        record, own = coder.record(term)
        if record.is_even:
            base = _plus(base, record.ambient)
        lights.append(record)
        numbers.append(own)
    stride = max(LEAST_NUMBERS, *map(len, numbers))
    scalars = {
        "needs_normals": equation.needs_normals,
        "needs_points": equation.needs_points,
        "needs_eye": equation.needs_eye,
        "is_flipped": equation.is_flipped,
        "has_local_facing": equation.local_facing,
        "has_lobes_of_viewer": equation.has_highlights,
        "moves_points": equation.matrix is not None,
        "turns_normals": turns_normals,
        "has_albedo": has_albedo,
        "is_display": is_display,
        "count": len(lights),
        "stride": stride,
        "sky": equation.lights if equation.is_occluded else -1,
        "tangents": equation.channels["tangents"].start if equation.needs_tangents else -1,
        "channel_length": channel_length,
        "takes_albedo": sum_of(lobe.takes_albedo for lobe in equation.reflectance.lobes),
    }
    vectors = {
        "eye": equation.eye or _ORIGIN,
        "to_eye": equation.to_eye,
        "matrix": matrix,
        "w": (w,),
        "normal_matrix": normals_matrix,
        "base": base,
        "own": _ORIGIN if has_albedo else equation.emission,
        "emission": equation.emission,
        "exponent": (1.0 / equation.gamma,),
        "low": (0.0 if equation.clamp else -math.inf,),
        "high": (1.0 if equation.clamp else math.inf,),
    }
    rows = [number for own in numbers for number in (*own, *(0.0,) * (stride - len(own)))]
    settings = _LAYOUT_OF_SETTINGS.pack(*scalars.values(), *chain.from_iterable(vectors.values()))
    return Records(settings, joined(lights), struct.pack(f"{len(rows)}d", *rows))


def _plus(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]
