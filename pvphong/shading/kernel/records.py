"""Records: an equation packed into bytes, in the form that compiled code reads.

Each light becomes a stage (compiled code), the stage's numbers, and a record for the driver. The settings that all
lights share are another record.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from operator import itemgetter
from typing import Any, NamedTuple, cast

import numpy as np

from pvphong.base.formulas import BRIGHTEST, FORMULAS, add, times
from pvphong.geometry.transform import normal_matrix
from pvphong.optics.maps import COLORS
from pvphong.optics.reflectance import LAMBERT
from pvphong.shading.equation import Equation, LightTerm, Share
from pvphong.shading.kernel.code import Library
from pvphong.shading.kernel.stages import (
    LEAST_NUMBERS,
    factors_already_written,
    integral_numbers,
    integral_stage,
    light_numbers,
    light_stage,
    reflectance_numbers,
    reflectance_stage,
)
from pvphong.shading.vertices import Tint

TERM = np.dtype(
    [
        ("is_uniform", "?"),
        ("varies", "?"),
        ("has_ambient", "?"),
        ("wanted", "i8"),
        ("visible", "i8"),
        ("arrives", "i8"),
        ("reflects", "i8"),
        ("gain", "f8"),
        ("to_light", "3f8"),
        ("ambient", "3f8"),
        ("colors", "(3,3)f8"),
        ("is_alone", "?"),
        ("component", "i8"),
        ("light_at", "i8"),
    ],
    align=True,
)
"""Record of a light.

- `is_uniform`: True for light from the direction `to_light`
- `varies`: True if the light's strength is computed per vertex; constant factors are in the colours
- `gain`: a power of two that multiplies the strength
- `wanted`: lobes other than black, as the sum of 1, 2 and 4
- `visible`: channel of the light's visible part, or -1
- `arrives`, `reflects`: addresses of the stages, 0 for stages that are built into the driver. For an area light,
  `arrives` is `integral_stage`, which writes the reflectance's factors too, and `reflects` is `factors_already_written`

The last fields are for separate shares, the components of the lights' contributions:

- `is_alone`: True if the light has no other share
- `component`: index in `COMPONENTS` of the share that this term completes, or -1
- `light_at`: offset from the colours to the array of the light if this term completes the light, else 0"""


def _packer(kind: np.dtype[Any]) -> Callable[..., bytes]:
    """Return a function that packs the values of a record's fields into bytes.

    It takes the values in the fields' order. NumPy would take ten times as long.
    """
    types = (kind[name] for name in kind.names or ())
    return struct.Struct("@" + "".join(f"{math.prod(each.shape)}{each.base.char}" for each in types)).pack


_pack_term = _packer(TERM)

_NO_END = False, -1, 0

COMPONENTS = "ambient", "diffuse", "specular", "emission"

MOST_LOBES = 3

_LARGEST = 2.0**100
"""Largest coordinate of a light or the eye that compiled code accepts. float32 could not hold the squares of larger
sums. Vertices may be anywhere."""

_NOWHERE, _IDENTITY = (0.0, 0.0, 0.0), np.eye(4)

# Range of exponents of the gain in compiled code, if the stage has divisors that can take the rest; and the largest
# exponent otherwise.
_LEAST_GAIN, _MOST_GAIN, _IN_FLOAT32 = -20, 100, 126


class TermCode(NamedTuple):
    """Compiled code for one term, that is, one light in the equation."""

    stage: Callable[..., Any] | None
    """The stage; None if the driver has it built in."""
    numbers: tuple[float, ...] = ()
    """Numbers that the stage reads."""
    varies: bool = False
    """True if the stage writes strengths; otherwise strengths are 1."""
    divisors: slice = slice(0)
    """Slice of `numbers` with the three coefficients of the attenuation. Dividing them by k multiplies the strength by
    k. This admits lights so bright and so far away that float32 holds neither their intensity nor their attenuation."""


_BY_DRIVER = TermCode(None)


def _code_of(term: LightTerm, equation: Equation, real: str) -> TermCode | None:
    light = term.light
    if light.is_uniform and not light.has_size:
        return _BY_DRIVER
    if light.has_size:
        forms = [
            form if any(color) else None for form, color in zip(equation.reflectance.forms, term.colors, strict=True)
        ]
        integrals = [form and light.analytic_integral(form) for form in forms]
        if any(each is not None and each.formula not in FORMULAS for each in integrals):
            return None
        code = TermCode(integral_stage(integrals, forms), integral_numbers(term.gain, integrals, forms, real))
        return code if are_in_range(code.numbers[:3]) else None
    placement = light.placement
    if placement is None or not {placement.falloff, *(placement.pattern or ())[:2]} <= {None, *FORMULAS}:
        return None
    if not holds(placement.attenuation):
        return None
    weakens = placement.attenuation != (1.0, 0.0, 0.0)
    code = TermCode(
        light_stage(placement.falloff, weakens, placement.pattern),
        light_numbers(placement),
        weakens or placement.falloff is not None or placement.pattern is not None,
        slice(3, 6 if weakens else 3),
    )
    is_held = are_in_range(placement.position) and (not code.varies or term.gain <= placement.most_gain)
    return code if is_held else None


def holds(numbers: Iterable[Any]) -> bool:
    """Return True if float32 can hold products of these numbers: each is 0, or between 2⁻¹⁰⁰ and 2¹⁰⁰."""
    for x in numbers:  # noqa: SIM110 as for `are_in_range`: a third of the time
        if x and not 1.0 / _LARGEST <= x <= _LARGEST:
            return False
    return True


def are_in_range(numbers: Iterable[float]) -> bool:
    """Return True if compiled code accepts the coordinates: none exceeds 2¹⁰⁰ in magnitude, and none is NaN."""
    for x in numbers:  # noqa: SIM110 runs for each light, and takes a third of the time that `all` does
        if not abs(x) <= _LARGEST:
            return False
    return True


def sum_of(flags: Iterable[bool]) -> int:
    """Return the integer whose bits are the flags, the lowest bit first."""
    return sum([1 << k for k, flag in enumerate(flags) if flag])


# --- settings


SETTINGS = np.dtype(
    [
        ("needs_normals", "?"),
        ("needs_points", "?"),
        ("needs_eye", "?"),
        ("is_flipped", "?"),
        ("has_local_facing", "?"),
        ("moves_points", "?"),
        ("is_wide", "?"),
        ("turns_normals", "?"),
        ("has_tints", "?"),
        ("is_split", "?"),
        ("has_albedo", "?"),
        ("has_diffuse", "?"),
        ("has_specular", "?"),
        ("has_emission", "?"),
        ("is_display", "?"),
        ("single_lambert_light", "?"),
        ("is_apart", "?"),
        ("count", "i8"),
        ("stride", "i8"),
        ("sky", "i8"),
        ("behind", "i8"),
        ("tangents", "i8"),
        ("field", "i8"),
        ("channel_length", "i8"),
        ("takes_albedo", "i8"),
        ("unmapped", "i8"),
        ("w", "f8"),
        ("over_diffuse", "f8"),
        ("over_specular", "f8"),
        ("over_emission", "f8"),
        ("exponent", "f8"),
        ("low", "f8"),
        ("high", "f8"),
        ("eye", "3f8"),
        ("to_eye", "3f8"),
        ("matrix", "(3,4)f8"),
        ("normal_matrix", "(3,3)f8"),
        ("base", "3f8"),
        ("own", "3f8"),
        ("emission", "3f8"),
        ("components_at", "4i8"),
    ],
    align=True,
)
"""Record of the settings that all lights share: numbers, then vectors.

- `has_tints`: any of the four maps of colours exists
- `single_lambert_light`: there is one light, uniform and with Lambert's factor only
- `is_apart`: shares, the components of the lights' contributions, are separate
- `components_at`: offsets of the components' arrays from the colours
- `is_split`: lobes with albedo and lobes without it have separate sums
- `count`: number of lights
- `stride`: number of numbers per stage
- `sky`: channel of the visible part of the sky, or -1
- `behind`: offset from a visibility channel to that of the other side, or 0 if normals are not turned
- `tangents`: first of three channels of tangents, or -1
- `field`: channel of the map of a reflectance's field, or -1
- `channel_length`: offset between channels
- `takes_albedo`: lobes that the albedo multiplies, as the sum of 1, 2 and 4
- `unmapped`: lobes that no map multiplies although maps multiply others, as such a sum
- `own`: colour like `base`, but independent of the sky
- `over_diffuse` and so on: factors of a map's colours
- `exponent`: power to which the sum of all light is raised"""

_pack_settings = _packer(SETTINGS)
_scalars_of, _vectors_of = (
    itemgetter(*[name for name in SETTINGS.names or () if bool(SETTINGS[name].shape) is has_axes])
    for has_axes in (False, True)
)


class Apart(NamedTuple):
    """Shares to store separately, and the offsets of their arrays from the array of colours, counted in elements.

    A share is one component of a light's contribution.
    """

    shares: Sequence[Share]
    lights: Mapping[int | None, int]
    """Offset for each light. The key None stands for the colour that is independent of lights."""
    components: Sequence[int]
    """Offsets in the order of `COMPONENTS`."""


class Records(NamedTuple):
    """An equation, packed for the driver."""

    settings: bytes
    """One record of type `SETTINGS`."""
    terms: bytes
    """Records of type `TERM`, one for each light."""
    numbers: bytes
    """Numbers of the reflectance's stage, then of each light's stage: a row for each stage, padded with zeros."""


def codes_of(equation: Equation, real: str) -> list[TermCode] | None:
    """Return the code of each term of an equation; `real` is the type of the arithmetic.

    Return None if compiled code does not support the equation: a stage is missing, or a number is out of range.
    """
    lobes = equation.reflectance.lobes
    if "metallic" in equation.maps and equation.reflectance.parameters({})[7] != 1.0:
        return None  # where surfaces are nearly black, the base depends on the map too
    if equation.maps and type(equation.reflectance).mapped not in FORMULAS:
        return None
    if len(lobes) > MOST_LOBES or type(equation.reflectance).factors not in FORMULAS:
        return None
    matrix = equation.matrix
    if matrix is not None and (matrix[3, :3].any() or matrix[3, 3] == 0.0 or not holds(np.abs(matrix).flat)):
        return None  # the reference raises the error
    if not are_in_range(equation.eye or ()):
        return None
    codes = [_code_of(term, equation, real) for term in equation.terms]
    return None if None in codes else cast("list[TermCode]", codes)


def blends(equation: Equation, tints: Mapping[str, Tint]) -> bool:
    """Return True if maps do more to a lobe's colour than to multiply it by the maps of albedo and diffuse.

    The colours of the first two lobes are then passed to compiled code as maps. `tints` is the result of
    `Vertices.tints`.
    """
    varies = "metallic" in equation.maps or "albedo" in tints or "diffuse" in tints
    return varies and any(lobe.tint for lobe in equation.reflectance.lobes)


def records_of(
    equation: Equation,
    codes: Sequence[TermCode],
    library: Library,
    stored: str,
    real: str,
    tints: Mapping[str, Tint],
    *,
    is_display: bool,
    channel_length: int = 0,
    apart: Apart | None = None,
) -> Records:
    """Pack an equation into records for the driver.

    Parameters
    ----------
    equation : Equation
        The equation. With `apart`, its terms must be the terms of `apart.shares`, in their order.
    codes
        Result of `codes_of`.
    library : Library
        Compiles the stages, or raises NotCompiled.
    stored, real : str
        Type of the vertices, and type of the rows: "float32" or "float64".
    tints
        Result of `Vertices.tints`.
    is_display : bool
        True if colours are stored as bytes.
    channel_length : int
        Number of entries of each visibility or map channel: the number of all vertices.
    apart : Apart, optional
        Shares to store separately. Shares without terms are added to the records.
    """
    reflectance, base = equation.reflectance, equation.ambient
    field = next((name for name in equation.maps if name != "metallic"), "")
    terms, numbers = [], [reflectance_numbers(reflectance)]
    addresses: dict[Any, int] = {}  # each stage is looked up once
    lambert_alone, is_blend = list[bool](), blends(equation, tints)
    ends = [_NO_END] * len(equation.terms)
    if apart is not None:
        alone, ends = _ends(apart)
        unused, dark = (0, -1, 0, 0, 1.0, *_NOWHERE), (0.0,) * 3 * MOST_LOBES
        for end in alone:  # shares that are independent of lights, as terms
            is_ambient = end[1] == COMPONENTS.index("ambient")
            ambient = equation.ambient if is_ambient else _NOWHERE
            terms.append(_pack_term(True, False, is_ambient, *unused, *ambient, *dark, *end))
            numbers.append(())
    for term, (stage, own, varies, divisors), end in zip(equation.terms, codes, ends, strict=True):
        strength, gain, to_light = min(term.gain, BRIGHTEST), 1.0, _NOWHERE
        if term.light.has_size:
            strength = 1.0  # included in its stage's factors
        if stage is None:
            arrival = term.light.arrival(np.zeros((3, 1)))
            to_light = arrival.to_light[:, 0].tolist()
            strength = min(term.gain * np.asarray(arrival.strength).item(), BRIGHTEST)
            base = base if apart else add(base, times(term.ambient, strength))
        elif stage not in addresses:
            addresses[stage] = library.stage(stage, real)
        if varies:
            strength, gain, own = _gain_apart(term.gain, own, divisors)
        wanted, reflects = term.shines, 0
        is_lambert = reflectance.lobes[0] is LAMBERT and True not in wanted[1:]
        if term.light.has_size:
            reflects = library.stage(factors_already_written, real)
        elif True in wanted and not is_lambert:
            if wanted not in addresses:
                addresses[wanted] = library.stage(reflectance_stage(reflectance, wanted, is_mapped=bool(field)), real)
            reflects = addresses[wanted]
        lambert_alone.append(stage is None and sum_of(wanted) == 1 and not reflects and not term.is_shadowed)
        colors = [channel * strength for color in term.colors for channel in color]
        terms.append(
            _pack_term(
                stage is None,
                varies,
                (stage is not None or apart is not None) and any(term.ambient),
                sum_of(wanted),
                term.index if term.is_shadowed else -1,
                0 if stage is None else addresses[stage],
                reflects,
                gain,
                *to_light,
                *times(term.ambient, strength),
                *colors,
                *(0.0,) * (3 * MOST_LOBES - len(colors)),
                *end,
            )
        )
        numbers.append(own)
    stride = max(LEAST_NUMBERS, *map(len, numbers))
    matrix = _IDENTITY if equation.matrix is None else equation.matrix
    turns_normals = equation.matrix is not None and equation.needs_normals and equation.turns_normals
    single_lambert_light = lambert_alone == [True] and not (
        turns_normals
        or equation.is_flipped
        or equation.is_occluded
        or equation.gamma != 1.0
        or tints
        or is_display
        or apart
    )
    has_size = any(term.light.has_size for term in equation.terms)  # area lights' stages read points in float64
    is_wide = has_size or stored == "float64" or equation.matrix is not None
    scalars: dict[str, float] = {
        "needs_normals": equation.needs_normals,
        "needs_points": equation.needs_points,
        "needs_eye": equation.needs_eye,
        "is_flipped": equation.is_flipped,
        "has_local_facing": equation.local_facing,
        "moves_points": equation.matrix is not None,
        "is_wide": is_wide,
        "turns_normals": turns_normals,
        "has_tints": bool(tints) or is_blend,
        "is_split": bool(tints.keys() - {"emission"}) or is_blend,
        **{f"has_{name}": name in tints or (is_blend and name in ("diffuse", "specular")) for name in COLORS},
        "is_display": is_display,
        "single_lambert_light": single_lambert_light,
        "is_apart": apart is not None,
        "count": len(terms),
        "stride": stride,
        "sky": equation.lights if equation.is_occluded else -1,
        "behind": equation.lights + 1 if equation.is_flipped and equation.needs_visibility else 0,
        "tangents": equation.channels["tangents"].start if "tangents" in equation.channels else -1,
        "field": equation.channels[field].start if field in equation.channels else -1,
        "channel_length": channel_length,
        "takes_albedo": 1 if is_blend else sum_of(lobe.takes_albedo for lobe in reflectance.lobes),
        "unmapped": 4 if is_blend else 0,
        "w": matrix[3, 3],
        "over_diffuse": 1.0 if is_blend or "diffuse" not in tints else 1.0 / tints["diffuse"].most,
        "over_specular": 1.0 if is_blend or "specular" not in tints else 1.0 / tints["specular"].most,
        "over_emission": 1.0 / tints["emission"].most if "emission" in tints else 1.0,
        "exponent": 1.0 / equation.gamma,
        "low": 0.0 if equation.clamp else -math.inf,
        "high": 1.0 if equation.clamp else math.inf,
    }
    vectors: dict[str, Sequence[float]] = {
        "eye": equation.eye or _NOWHERE,
        "to_eye": equation.to_eye,
        "matrix": matrix[:3].ravel().tolist(),
        "normal_matrix": normal_matrix(matrix).ravel().tolist() if turns_normals else (0.0,) * 9,
        "base": _NOWHERE if apart else base,
        "own": _NOWHERE if tints or is_blend else equation.emission,
        "emission": equation.emission,
        "components_at": (0,) * len(COMPONENTS) if apart is None else apart.components,
    }
    packed = _pack_settings(*_scalars_of(scalars), *chain.from_iterable(_vectors_of(vectors)))
    rows = [number for own in numbers for number in (*own, *(0.0,) * (stride - len(own)))]
    return Records(packed, b"".join(terms), struct.pack(f"{len(rows)}d", *rows))


def _ends(apart: Apart) -> tuple[list[tuple[bool, int, int]], list[tuple[bool, int, int]]]:
    """Return the values of the last three fields of `TERM`, (is_alone, component, light_at), in two lists.

    The first list has an entry for each share that is independent of lights. The second list has an entry for each term
    of the other shares. Only the last term of a share has values; its other terms have `_NO_END`.
    """
    alone, ends = list[tuple[bool, int, int]](), list[tuple[bool, int, int]]()
    lights = [share.light for share in apart.shares]
    for share, next_light in zip(apart.shares, (*lights[1:], -1), strict=True):
        light_at = apart.lights[share.light] if share.light != next_light else 0
        end = lights.count(share.light) == 1, COMPONENTS.index(share.component), light_at
        if share.terms:
            ends += [*[_NO_END] * (len(share.terms) - 1), end]
        else:
            alone.append(end)
    return alone, ends


def _gain_apart(gain: float, numbers: tuple[float, ...], divisors: slice) -> tuple[float, float, tuple[float, ...]]:
    """Split a gain into a factor from 1 to 2 and a power of two. Return both, and the new numbers of the stage.

    The factor multiplies the colours, and the power of two multiplies the strength at each vertex. If float32 cannot
    hold the power, a part of it divides the numbers in the slice `divisors`, the coefficients of the attenuation.
    """
    mantissa, exponent = math.frexp(gain)
    kept = min(exponent - 1, _IN_FLOAT32)
    if numbers[divisors]:
        kept = min(max(exponent - 1, _LEAST_GAIN), _MOST_GAIN)
        divided = (number / 2.0 ** (exponent - 1 - kept) for number in numbers[divisors])
        numbers = *numbers[: divisors.start], *divided, *numbers[divisors.stop :]
    return 2.0 * mantissa, 2.0**kept, numbers
