"""Stages: compiled code for a light or a reflectance, built around the formula in its file.

A stage processes a block of `BLOCK` vertices: a loop loads a vertex's numbers from the block's rows, calls the formula,
which is inlined, and stores its results. These loops have no branches, so LLVM vectorises them. A stage's closure
(formulas and integers) is part of the key of its code on disk.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pvphong.base.formulas import (
    BRIGHTEST,
    FAINTEST,
    ONE,
    TWO,
    ZERO,
    Power,
    dot,
    formula,
    maximum,
    minimum,
    select,
    sqrt,
    subtract,
    times,
)
from pvphong.optics.area.lobes import POWER, CosinePower, is_whole, lobe_numbers, may_rise, shows
from pvphong.optics.attenuation import divisor
from pvphong.optics.light import Integral, Pattern, PunctualParameters
from pvphong.optics.reflectance import Geometry, Reflectance
from pvphong.shading.kernel.arithmetic import as_type_of, compiled, exp2, inlined, log2_power, shifted
from pvphong.shading.kernel.lanes import WIDTH, load_listed, store, store_listed
from pvphong.shading.kernel.vertices import (
    BLOCK,
    DX,
    DY,
    DZ,
    FIELD,
    FIRST,
    INVERSE_DISTANCE,
    INVERSE_NORMAL,
    NX,
    NY,
    NZ,
    SECOND,
    STRENGTH,
    THIRD,
    TX,
    TY,
    TZ,
    VX,
    VY,
    VZ,
    approach,
)

_NEVER = np.float32(-np.inf)

# Row with the indices of the vertices on which a formula runs. The list may extend into the next row. Nothing else uses
# these rows meanwhile.
LIST = DX

# Row of the cosines n·l until factors are written. In the first factor's row, LLVM would write max(n·l, 0) by a masked
# store, which is slow.
COSINE = THIRD

_STRONGEST = np.float32(2.0**126)
"""Largest strength."""

# Offsets of a formula's parameters, after the numbers of its power (and of a light's position and attenuation).
_OWN_OF_REFLECTANCE, _OWN_OF_LIGHT, _MOST_PARAMETERS = 3, 9, 8

LEAST_NUMBERS = _OWN_OF_LIGHT + _MOST_PARAMETERS
"""Least length of a stage's numbers: that many may be read, even if a formula does not use them."""

_ALL_LOBES = 1 + 2 + 4
"""Result of a reflectance's stage with all lobes: none is known to be 0 everywhere in the block."""


@inlined
def _cosine(rows: Any, i: int) -> Any:
    """Return the cosine n·l at vertex `i`, with the sign of the dot product before normalisation."""
    n_d = dot((rows[NX + i], rows[NY + i], rows[NZ + i]), (rows[DX + i], rows[DY + i], rows[DZ + i]))
    return n_d * (rows[INVERSE_DISTANCE + i] * rows[INVERSE_NORMAL + i])


@inlined
def _geometry(rows: Any, i: int, n_l: Any) -> Geometry:
    """Return the geometry at vertex `i`, for a reflectance's formula. `n_l` is the cosine n·l at this vertex.

    LLVM removes the fields that the formula does not use.
    """
    n, v, scale = (
        (rows[NX + i], rows[NY + i], rows[NZ + i]),
        (rows[VX + i], rows[VY + i], rows[VZ + i]),
        rows[INVERSE_NORMAL + i],
    )
    return Geometry(
        n,
        scale,
        n_l,
        dot(n, v) * scale,
        times((rows[DX + i], rows[DY + i], rows[DZ + i]), rows[INVERSE_DISTANCE + i]),
        v,
        (rows[TX + i], rows[TY + i], rows[TZ + i]),
    )


@inlined
def _parameters(rows: Any, numbers: Any) -> Any:
    """Return the first eight of `numbers`, a formula's parameters, in the type of `rows`.

    A formula may use only some of them.
    """
    return (
        as_type_of(rows, numbers[0]),
        as_type_of(rows, numbers[1]),
        as_type_of(rows, numbers[2]),
        as_type_of(rows, numbers[3]),
        as_type_of(rows, numbers[4]),
        as_type_of(rows, numbers[5]),
        as_type_of(rows, numbers[6]),
        as_type_of(rows, numbers[7]),
    )


@inlined
def _shows(square: Any, n_l: Any, dark: Any) -> bool:
    """Return True if a highlight may be greater than 0 at a vertex.

    `square` is the squared length of the highlight's chord, and must be below `dark`. The cosine `n_l` must be above 0,
    unless `dark` is infinite; then the highlight does not end at the horizon.
    """
    return (square < dark) & ((n_l > ZERO) | (dark > TWO))


@compiled
def _take_logarithms(rows: Any, exponent: float, log_floor: float, end: float) -> None:
    """Replace |C|², the squared length of a chord, by log2 of a power of the chord's cosine, in the row `SECOND`.

    The cosine is 1 − |C|²/2, but at least 2 to the power `log_floor`. It is raised to `exponent`. If |C|² is at least
    `end`, the power is 0, and −∞ is written.

    Another loop then calls `_raised`, which returns the power from its logarithm. A processor looks only some hundred
    instructions ahead, and each step of a polynomial depends on the one before. So two loops, for the logarithms and
    for the powers, take a third less time than one.
    """
    n, least, dark = as_type_of(rows, exponent), as_type_of(rows, log_floor), as_type_of(rows, end)
    for i in range(BLOCK):
        square = rows[SECOND + i]
        raised = log2_power(square, n, least)
        rows[SECOND + i] = raised if square < dark else _NEVER


@inlined
def _end_of(exponent: Any) -> Any:
    """Return the least squared chord for which a power of a cosine is 0.

    For an `exponent` greater than 0, this is 2, the squared chord of a right angle. For the exponent 0, no power is 0,
    and the result is infinity.
    """
    return TWO if exponent > ZERO else as_type_of(exponent, np.inf)


@compiled
def _take_logarithms_of_each(rows: Any) -> None:
    """Replace |C|² in the row `SECOND` by the logarithm of a power, as `_take_logarithms` does.

    The exponents are the entries of the row `FIELD`, one for each vertex. There is no floor.
    """
    for i in range(BLOCK):
        n, square = rows[FIELD + i], rows[SECOND + i]
        n = min(max(n, as_type_of(n, FAINTEST)), as_type_of(n, BRIGHTEST)) if n > ZERO else n
        raised = log2_power(square, n, as_type_of(n, -np.inf))
        rows[SECOND + i] = raised if square < _end_of(n) else _NEVER


@inlined
def _raised(rows: Any, i: int) -> Any:
    y = rows[SECOND + i]
    return exp2(y) if y > _NEVER else ZERO


def factors_already_written(_numbers: Any, _rows: Any, _points: Any) -> int:
    """Do nothing. This replaces a reflectance's stage if an area light's stage has already written the factors."""
    return _ALL_LOBES


def reflectance_stage(
    reflectance: Reflectance, wanted: Sequence[bool], *, is_mapped: bool = False
) -> Callable[..., Any]:
    """Return a stage that writes the factors of a reflectance's lobes.

    Its arguments are `numbers`, `rows` and `points`.
    The stage returns an integer whose bits name the lobes that it has written: 1, 2 and 4 for the first, second and
    third lobe. Lobes that are not wanted, or are 0 in the whole block, are not written.

    Parameters
    ----------
    reflectance : Reflectance
        The reflectance.
    wanted : sequence of bool
        For each lobe, True to write its factor.
    is_mapped : bool
        True to read a field of the reflectance, such as the shininess, per vertex from the row `FIELD`. If False, the
        field is one of the numbers.
    """
    factors, mapped, peak = type(reflectance).factors, type(reflectance).mapped, reflectance.peak
    varies = int(is_mapped)
    first, second, third = (int(flag) for flag in (*wanted, False, False)[:3])
    all_of_them = first + 2 * second + 4 * third
    if reflectance.power({}) is None or peak is None or not any(wanted[1:]):

        def reflect(numbers: Any, rows: Any, _points: Any) -> int:
            own = _parameters(rows, shifted(numbers, _OWN_OF_REFLECTANCE))
            for i in range(BLOCK):
                here = mapped(rows[FIELD + i], own) if varies else own
                found = factors(here, _geometry(rows, i, _cosine(rows, i)), ZERO)
                if first:
                    rows[FIRST + i] = found[0]
                if second:
                    rows[SECOND + i] = found[1]
                if third:
                    rows[THIRD + i] = found[2]
            return all_of_them

        return reflect
    square = peak.square

    def reflect_with_power(numbers: Any, rows: Any, _points: Any) -> int:
        dark, shines = as_type_of(rows, numbers[2]), False
        for i in range(BLOCK):
            n_l = _cosine(rows, i)
            chord = square(_geometry(rows, i, n_l))
            rows[COSINE + i], rows[SECOND + i] = n_l, chord
            if varies:
                dark = _end_of(rows[FIELD + i])
            shines = shines | _shows(chord, n_l, dark)
        own = _parameters(rows, shifted(numbers, _OWN_OF_REFLECTANCE))
        if not shines:
            if first:
                for i in range(BLOCK):
                    here = mapped(rows[FIELD + i], own) if varies else own
                    rows[FIRST + i] = factors(here, _geometry(rows, i, rows[COSINE + i]), ZERO)[0]
            return first
        if varies:
            _take_logarithms_of_each(rows)
        else:
            _take_logarithms(rows, numbers[0], numbers[1], numbers[2])
        for i in range(BLOCK):
            here = mapped(rows[FIELD + i], own) if varies else own
            found = factors(here, _geometry(rows, i, rows[COSINE + i]), _raised(rows, i))
            if first:
                rows[FIRST + i] = found[0]
            if second:
                rows[SECOND + i] = found[1]
            if third:
                rows[THIRD + i] = found[2]
        return all_of_them

    return reflect_with_power


def light_stage(
    falloff: Callable[..., Any] | None, weakens: bool, pattern: Pattern | None = None
) -> Callable[..., Any]:
    """Return a stage that writes the vectors to a light, and strengths if they vary.

    Its arguments are `numbers`, `rows` and `points`.
    The stage returns True if no vertex of the block is declined, that is, marked by `approach` for the reference.

    Parameters
    ----------
    falloff : formula or None
        Function of the light's parameters and the unit vector to the light. It returns two numbers: 1 inside the cone
        or 0 outside, and a squared chord. The power of this chord's cosine multiplies the strength. None if the light
        is equally strong in all directions.
    weakens : bool
        True if the strength depends on the distance.
    pattern : Pattern, optional
        Pattern of intensities, whose formulas return a factor for the strength. Only a light without falloff may have
        one.
    """
    measures = int(weakens)

    def arrive(numbers: Any, rows: Any, points: Any) -> bool:
        good = approach(rows, points, numbers[0], numbers[1], numbers[2], measures == 1)
        if measures == 1:
            _weaken(rows, numbers)
        return good

    if pattern is not None:
        place, value = pattern.place, pattern.value

        def arrive_by_pattern(numbers: Any, rows: Any, points: Any) -> bool:
            good = approach(rows, points, numbers[0], numbers[1], numbers[2], measures == 1)
            if measures == 1:
                _weaken(rows, numbers)
            more = shifted(numbers, _OWN_OF_LIGHT + _MOST_PARAMETERS)
            own = (*_parameters(rows, shifted(numbers, _OWN_OF_LIGHT)), *_parameters(rows, more))
            for i in range(BLOCK):
                l = times((rows[DX + i], rows[DY + i], rows[DZ + i]), rows[INVERSE_DISTANCE + i])
                rows[FIRST + i], rows[SECOND + i], rows[THIRD + i] = place(own, l)
            table = shifted(more, _MOST_PARAMETERS)
            for i in range(BLOCK):
                strength = rows[STRENGTH + i] if measures == 1 else ONE
                rows[STRENGTH + i] = strength * value(table, rows[FIRST + i], rows[SECOND + i], rows[THIRD + i])
            return good

        return arrive_by_pattern

    if falloff is None:
        return arrive

    def arrive_in_cone(numbers: Any, rows: Any, points: Any) -> bool:
        good = approach(rows, points, numbers[0], numbers[1], numbers[2], measures == 1)
        if measures == 1:
            _weaken(rows, numbers)
        own = _parameters(rows, shifted(numbers, _OWN_OF_LIGHT))
        for i in range(BLOCK):
            l = times((rows[DX + i], rows[DY + i], rows[DZ + i]), rows[INVERSE_DISTANCE + i])
            rows[FIRST + i], rows[SECOND + i] = falloff(own, l)
        _take_logarithms(rows, numbers[6], numbers[7], numbers[8])
        for i in range(BLOCK):
            strength = rows[STRENGTH + i] if measures == 1 else ONE
            rows[STRENGTH + i] = strength * (rows[FIRST + i] * _raised(rows, i))
        return good

    return arrive_in_cone


@compiled
def _weaken(rows: Any, numbers: Any) -> None:
    """Replace the distances in the row `STRENGTH` by strengths, using the attenuation's coefficients in `numbers`."""
    constant, linear = as_type_of(rows, numbers[3]), as_type_of(rows, numbers[4])
    quadratic = as_type_of(rows, numbers[5])
    for i in range(BLOCK):
        rows[STRENGTH + i] = minimum(ONE / divisor(constant, linear, quadratic, rows[STRENGTH + i]), _STRONGEST)


# Flags of vertices: the whole light is above the horizon, or the horizon may cut the light.
_WHOLE, _CUT = 1.0, 2.0

# Offset of the first integral's numbers: after the light's place, gain and radius, and the offsets of the second
# integral's numbers and of both lobes' numbers.
_OWN_OF_INTEGRAL = 8


def integral_stage(integrals: Sequence[Integral | None], forms: Sequence[CosinePower | None]) -> Callable[..., Any]:
    """Return a stage that writes the integrals of lobes over an area light, and returns 1.

    Its arguments are `numbers`, `rows` and `points`. Formulas run only on vertices where the light may be above the
    horizon and a lobe reaches the light. The indices of these vertices are listed in the row `LIST`, and the vertices
    are taken from the block eight at a time.

    Parameters
    ----------
    integrals : sequence of Integral or None
        For each lobe, its integral over the light; None for a lobe that is not wanted.
    forms : sequence of CosinePower or None
        For each lobe, the lobe as a power of a cosine; None for a lobe that is not wanted. At most one is around the
        normal, and at most one around the mirrored viewer.
    """
    lobes = list(zip((FIRST, SECOND, THIRD), integrals, forms, strict=False))
    found = {form.around: (row, each.formula) for row, each, form in lobes if each is not None and form is not None}
    (normal_row, around_normal), (mirror_row, around_mirror) = (
        found.get(around, (-1, _nothing)) for around in ("normal", "mirror")
    )

    def integrate(numbers: Any, rows: Any, points: Any) -> int:
        gain = numbers[3]
        own, second = shifted(numbers, _OWN_OF_INTEGRAL), shifted(numbers, int(numbers[5]))
        lobe, second_lobe = shifted(own, int(numbers[6])), shifted(second, int(numbers[7]))
        place, radius = (numbers[0], numbers[1], numbers[2]), numbers[4]
        for i in range(BLOCK):
            rows[LIST + i] = as_type_of(rows, i)
        for i in range(0, BLOCK, WIDTH):
            d, n = _towards(place, rows, points, i)
            is_lit, flag = may_rise(n, d, radius), select(is_whole(n, d, radius), _WHOLE, _CUT)
            if normal_row >= 0:
                store(rows, normal_row + i, select(is_lit, flag, 0.0))
            if mirror_row >= 0:
                reaches = is_lit & shows(second_lobe, _axis(second_lobe, rows, i, n), d, sqrt(dot(d, d)), radius)
                store(rows, mirror_row + i, select(reaches, flag, 0.0))
        if normal_row >= 0:
            for k in range(0, _list(rows, normal_row), WIDTH):
                d, n = _towards(place, rows, points, k)
                found = minimum(around_normal(own, lobe, d, n, n) * gain, BRIGHTEST)
                store_listed(rows, normal_row, LIST + k, found)
        if mirror_row >= 0:
            for k in range(0, _list(rows, mirror_row), WIDTH):
                d, n = _towards(place, rows, points, k)
                found = around_mirror(second, second_lobe, d, n, _axis(second_lobe, rows, k, n))
                store_listed(rows, mirror_row, LIST + k, minimum(found * gain, BRIGHTEST))
        return 1

    return integrate


@inlined
def _towards(place: Any, rows: Any, points: Any, k: int) -> Any:
    """Return the vectors from eight vertices to the position `place`, and the unit normals of these vertices.

    The vertices are those whose indices are the entries `k` to `k` + 7 of the row `LIST`.
    """
    return subtract(place, _listed(points, 0, rows, k)), _unit(_listed(rows, NX, rows, k))


@inlined
def _axis(lobe: Any, rows: Any, k: int, n: Any) -> Any:
    """Return the axis of a lobe at eight vertices: the direction to the viewer, mirrored at the normal.

    For a lobe with the power 0, the axis is the normal itself. The vertices are those whose indices are the entries `k`
    to `k` + 7 of the row `LIST`; `n` has their unit normals.
    """
    if lobe[POWER] > 0.0:  # 0⁰ is 1 in the whole hemisphere around n
        v = _unit(_listed(rows, VX, rows, k))
        return _unit(subtract(times(n, 2.0 * dot(n, v)), v))
    return n


@inlined
def _listed(array: Any, start: int, rows: Any, k: int) -> Any:
    """Return the vectors of eight vertices from the three rows of `array` that begin at offset `start`.

    The vertices are those whose indices are the entries `k` to `k` + 7 of the row `LIST` of `rows`.
    """
    return (
        load_listed(array, start, rows, LIST + k),
        load_listed(array, start + BLOCK, rows, LIST + k),
        load_listed(array, start + 2 * BLOCK, rows, LIST + k),
    )


@compiled
def _list(rows: Any, flags: int) -> int:
    """Write the indices of the vertices whose flag is not 0 to the row `LIST`. Return the length of the list.

    `flags` is the offset of the row of flags. Vertices with the flag `_WHOLE` come first, then those with `_CUT`.

    Cutting a light by the horizon doubles the time of all eight vertices that are taken at once. So whole and cut
    lights are not mixed in a group of eight. The last group of either kind is padded with its first vertex, which also
    prevents `load_listed` from treating it as consecutive.
    """
    count = 0
    for flag in (_WHOLE, _CUT):
        for i in range(BLOCK):
            rows[LIST + count] = as_type_of(rows, i)
            count += 1 if rows[flags + i] == flag else 0
        for _ in range(-count % WIDTH):
            rows[LIST + count] = rows[LIST + count // WIDTH * WIDTH]
            count += 1
    return count


@formula
def _nothing(_own: Any, _lobe: Any, d: Any, _n: Any, _a: Any) -> Any:
    return 0.0 * d[0]


@formula
def _unit(w: Any) -> Any:
    return times(w, 1.0 / sqrt(maximum(dot(w, w), 1e-300)))


def integral_numbers(
    gain: float, integrals: Sequence[Integral | None], forms: Sequence[CosinePower | None], real: str
) -> tuple[float, ...]:
    """Return the numbers that the stage from `integral_stage` reads. `real` is the type of the arithmetic.

    In order: the light's place, the gain and the light's radius; the offsets of the second integral's numbers and of
    both lobes' numbers; the numbers of the integral and lobe around the normal; then those around the mirrored viewer.
    `integrals` and `forms` are as for `integral_stage`; `gain` multiplies the integrals.
    """
    place, radius = (0.0, 0.0, 0.0), 0.0
    parts: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {"normal": ((), ()), "mirror": ((), ())}
    for each, form in zip(integrals, forms, strict=True):
        if each is not None and form is not None:
            parts[form.around] = each.numbers, lobe_numbers(form.power, rounded=real == "float32")
            place, radius = each.place, each.radius
    (own, lobe), (second, second_lobe) = parts["normal"], parts["mirror"]
    ahead = _OWN_OF_INTEGRAL + len(own) + len(lobe)
    starts = float(ahead), float(len(own)), float(len(second))
    return (*place, gain, radius, *starts, *own, *lobe, *second, *second_lobe)


def light_numbers(light: PunctualParameters) -> tuple[float, ...]:
    """Return the numbers that the stage from `light_stage` reads."""
    power = light.power or Power(0.0)
    own = light.parameters if light.pattern is None else (*light.pattern.parameters, *light.pattern.table)
    return *light.position, *light.attenuation, *power.numbers, *own


def reflectance_numbers(reflectance: Reflectance) -> tuple[float, ...]:
    """Return the numbers that the stage from `reflectance_stage` reads."""
    power = reflectance.power({}) or Power(0.0)
    return *power.numbers, *reflectance.parameters({})
