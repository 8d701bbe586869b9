"""The driver lights vertices block by block: it loads a block, adds light after light, and stores colours.

The equation is passed as records. Its values are arguments of compiled code, so no code is compiled when a light moves
or changes its colour. Branches are taken once per block. The driver does not depend on kinds of lights or reflectances.
Their code is in stages, compiled loops over a block, which the driver calls through pointers, once per block and light.
Only the common cases are built in: a uniform light, and Lambert's factor, which the driver adds without storing it
first.

The driver's loops are simple enough for LLVM to vectorise. Literals are float32: a Python float would widen float32
arithmetic. Where rows are float64, float32 literals are widened, exactly. There is no fast-math: each vertex's bits
follow from IEEE arithmetic on its own numbers. Only `multiply_add` fuses products and sums, in the same way in every
loop.

Arguments that several functions share are described in the module `vertices`. In addition, `varies` is True if the row
`STRENGTH` has the light's strength at each vertex, and False if the strength is 1 at all vertices.

If components are requested, the driver computes the colours as separate shares, one after the other. A share is one
component (ambient, diffuse, specular or emission) of one light's contribution, or of the colour that is independent of
lights.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import carray

from pvphong.base.formulas import BRIGHTEST, ONE, ZERO, dot, inverse_length, square
from pvphong.shading.kernel import vertices as at
from pvphong.shading.kernel.arithmetic import (
    WHOLE32,
    as_type_of,
    call_stage,
    compiled,
    inlined,
    inlined_early,
    multiply_add,
    nowhere,
    shifted,
)
from pvphong.shading.kernel.vertices import BLOCK, in_type, prefetch_to_read, prefetch_to_write, put, vector

_BRIGHTEST = np.float32(BRIGHTEST)


def shade(
    points: Any,
    normals: Any,
    albedo: Any,
    diffuse: Any,
    specular: Any,
    emission: Any,
    channels: Any,
    rgb: Any,
    display: Any,
    settings: Any,
    terms: Any,
    numbers: Any,
    count: int,
    rows: Any,
    wide: Any,
    declined: Any,
) -> bool:
    """Light vertices; return True if none is declined. Declined vertices are marked, and the reference lights them.

    Parameters
    ----------
    points, normals
        Vectors of all vertices, one after the other. A pointer that is not needed may have any value.
    albedo, diffuse, specular, emission
        Colours of all vertices, one after the other, for fields that have a map.
    channels
        Numbers of all vertices, channel after channel. First the visible parts of lights and of the sky, for both sides
        if normals are turned towards the viewer; then maps.
    rgb, display
        Output colours: floats, or bytes if `is_display`.
    settings, terms, numbers
        The equation, packed by `records`.
    count : int
        Number of vertices.
    rows, wide
        Scratch memory: `ROWS` numbers, and 3 · `BLOCK` of float64.
    declined
        A byte per vertex, initially 0; set to 1 for vertices that the reference must light.
    """
    s = carray(settings, (1,))[0]
    lights = carray(terms, (s.count,))
    for i in range(BLOCK):
        rows[at.DECLINED + i] = 0.0
        rows[at.SKY + i] = ONE
    places = wide if s.is_wide else nowhere(wide)
    fill(rows, at.VX, in_type(s.to_eye, rows))
    none = True
    is_uniform = not (s.needs_normals or s.needs_points or s.has_tints or s.sky >= 0 or s.is_apart)
    good = True
    for first in range(0, count, BLOCK):
        size = min(count - first, BLOCK)
        if s.single_lambert_light and size == BLOCK and _shine(normals, first, s, lights[0], rgb):
            continue
        if first == 0 or not is_uniform:  # else all blocks have the first block's colours
            good = _load(first, size, points, normals, channels, s, rows, wide, places)
            _prefetch_colors(first + BLOCK, rgb, display, s)
            if s.is_apart:
                clear(rows, at.LIGHT_R)
                for k in range(4):
                    clear(rows, at.COMPONENTS + 3 * BLOCK * k)
                if s.has_tints:
                    _add_emission(first, size, emission, s, rows)
            for k in range(len(lights)):
                # between lights, because few cache lines can be requested at once
                if k == 1 and s.needs_normals:
                    prefetch_to_read(normals, first + BLOCK)
                if k == 2 and s.needs_points:
                    prefetch_to_read(points, first + BLOCK)
                own = shifted(numbers, (k + 1) * s.stride)
                good = _add_light(first, size, channels, lights[k], s, numbers, own, rows, places) & good
                if lights[k].component >= 0:
                    if s.has_tints and lights[k].component < 3:  # not the emission
                        _tint(first, size, albedo, diffuse, specular, s, rows)
                    _end_share(first, size, rgb, lights[k], s, rows)
            if s.is_apart:
                _end_shares(first, size, rgb, s, rows)
            elif s.has_tints:
                _tint(first, size, albedo, diffuse, specular, s, rows)
                _add_emission(first, size, emission, s, rows)
            _finish(s, rows)
        _store(first, size, rgb, display, s, rows)
        if not good:
            none = False
            for i in range(size):
                declined[first + i] = rows[at.DECLINED + i] != 0.0
            for i in range(BLOCK):
                rows[at.DECLINED + i] = 0.0
    return none


@compiled
def _shine(normals: Any, first: int, s: Any, t: Any, rgb: Any) -> bool:
    """Light a full block by one uniform light with Lambert's factor.

    This takes a third less time than using rows. Return True if all normals can be used without scaling; otherwise the
    colours are invalid.

    Parameters
    ----------
    normals, rgb
        Normals, and output colours, of all vertices.
    first : int
        Index of the block's first vertex.
    s, t
        Records of the settings and of the light.
    """
    low, high, to_light = as_type_of(rgb, s.low), as_type_of(rgb, s.high), in_type(t.to_light, rgb)
    base, color, inverse = in_type(s.base, rgb), in_type(t.colors[0], rgb), inverse_length(square(to_light))
    own, part, lit = in_type(s.own, rgb), shifted(normals, 3 * first), shifted(rgb, 3 * first)
    good = True
    for i in range(BLOCK):
        n = as_type_of(rgb, part[3 * i]), as_type_of(rgb, part[3 * i + 1]), as_type_of(rgb, part[3 * i + 2])
        squared = square(n)
        factor = max(dot(n, to_light) * (inverse * inverse_length(squared)), ZERO)
        lit[3 * i] = _clipped(multiply_add(color[0], factor, base[0] + own[0]), low, high)
        lit[3 * i + 1] = _clipped(multiply_add(color[1], factor, base[1] + own[1]), low, high)
        lit[3 * i + 2] = _clipped(multiply_add(color[2], factor, base[2] + own[2]), low, high)
        good = good & at.is_moderate(squared)
    return good


# --- vertices into the block's rows


@compiled
def fill(rows: Any, start: int, w: Any) -> None:
    """Fill the three rows that begin at offset `start` with the vector or colour `w`."""
    for i in range(BLOCK):
        put(shifted(rows, start), i, w)


@compiled
def clear(rows: Any, start: int) -> None:
    """Fill the three rows that begin at offset `start` with black."""
    for i in range(3 * BLOCK):
        rows[start + i] = ZERO


@compiled
def _begin(rows: Any, target: int, base: Any, own: Any) -> None:
    """Set the colours in the three rows that begin at offset `target`.

    The colour of each vertex is `base` times the visible part of the sky, plus `own`.
    """
    for i in range(BLOCK):
        sky = rows[at.SKY + i]
        rows[target + i] = multiply_add(base[0], sky, own[0])
        rows[target + BLOCK + i] = multiply_add(base[1], sky, own[1])
        rows[target + 2 * BLOCK + i] = multiply_add(base[2], sky, own[2])


@inlined_early
def _load(
    first: int, count: int, points: Any, normals: Any, channels: Any, s: Any, rows: Any, wide: Any, places: Any
) -> bool:
    """Load a block of vertices and initialise its colours; return True if no vertex of the block is declined.

    Parameters
    ----------
    first, count, channels, s, rows, wide
        As in the description of the module `vertices`.
    points, normals
        Vectors of all vertices.
    places
        Memory for the block's points: `wide`, or a null pointer for the rows `PX` to `PZ`.
    """
    good = True
    if s.needs_normals:
        good = at.load_normals(normals, first, count, s, rows, wide)
    if s.needs_points:
        at.load_points(points, first, count, s, rows, places)
    good = at.look_at_viewer(s, rows, places) & good
    if s.tangents >= 0:
        at.load_tangents(shifted(channels, s.tangents * s.channel_length), s.channel_length, first, count, rows)
    if s.field >= 0:
        at.load_channel(shifted(channels, s.field * s.channel_length), first, count, shifted(rows, at.FIELD))
    if s.sky >= 0:
        at.load_seen(channels, s.sky, first, count, s, rows, at.SKY)
    if s.is_split:
        clear(rows, at.OTHER_R)
    if s.unmapped:
        clear(rows, at.UNMAPPED_R)
    if s.has_diffuse:
        clear(rows, at.R)
    _begin(rows, at.AMBIENT_R if s.has_diffuse else at.R, in_type(s.base, rows), in_type(s.own, rows))
    return good


@inlined_early
def _prefetch_colors(first: int, rgb: Any, display: Any, s: Any) -> None:
    """Prefetch the output memory of the block that begins at vertex `first`.

    Writes to memory that is not cached take longest. The output is `display` if `s.is_display` is set, else `rgb`.
    """
    if s.is_display:
        prefetch_to_write(display, first)
    else:
        prefetch_to_write(rgb, first)


# --- a light


@compiled
def _settle_strength(rows: Any, gain: Any) -> None:
    """Multiply the strengths in the row `STRENGTH` by the factor `gain`, and limit the products to `_BRIGHTEST`."""
    for i in range(BLOCK):
        rows[at.STRENGTH + i] = min(rows[at.STRENGTH + i] * gain, _BRIGHTEST)


@inlined
def _strength(rows: Any, i: int, varies: bool) -> Any:
    """Return the light's strength at vertex `i`: from the row `STRENGTH` if `varies`, else 1.

    `varies` is constant in a loop, so LLVM makes two loops of it.
    """
    return rows[at.STRENGTH + i] if varies else ONE


@compiled
def _hide(rows: Any, varies: bool) -> None:
    """Multiply the light's strengths by its visible part at each vertex, the row `VISIBLE`.

    The result is the row `STRENGTH`. If `varies`, this row already has the strengths. If not, all strengths are 1.
    """
    for i in range(BLOCK):
        rows[at.STRENGTH + i] = _strength(rows, i, varies) * rows[at.VISIBLE + i]


@compiled
def _add(rows: Any, target: int, factors: int, varies: bool, color: Any) -> None:
    """Add the light of one lobe: `color` times the lobe's factor and the light's strength at each vertex.

    The factors are in the row at offset `factors`. The sums are the three rows that begin at offset `target`. The
    strengths are in the row `STRENGTH` if `varies`; if not, all are 1.
    """
    for i in range(BLOCK):
        factor = rows[factors + i] * _strength(rows, i, varies)
        rows[target + i] = multiply_add(color[0], factor, rows[target + i])
        rows[target + BLOCK + i] = multiply_add(color[1], factor, rows[target + BLOCK + i])
        rows[target + 2 * BLOCK + i] = multiply_add(color[2], factor, rows[target + 2 * BLOCK + i])


@compiled
def _add_two(rows: Any, varies: bool, color: Any, other: Any) -> None:
    """Add the light of the first two lobes, with the colours `color` and `other`, to the vertices' colours.

    Adding both at once halves the memory traffic. It is possible only if the same maps multiply both lobes. The light's
    strengths are in the row `STRENGTH` if `varies`; if not, all are 1.
    """
    for i in range(BLOCK):
        strength = _strength(rows, i, varies)
        first, second = rows[at.FIRST + i] * strength, rows[at.SECOND + i] * strength
        rows[at.R + i] = multiply_add(other[0], second, multiply_add(color[0], first, rows[at.R + i]))
        rows[at.G + i] = multiply_add(other[1], second, multiply_add(color[1], first, rows[at.G + i]))
        rows[at.B + i] = multiply_add(other[2], second, multiply_add(color[2], first, rows[at.B + i]))


@compiled
def _add_lambert(rows: Any, varies: bool, color: Any, is_uniform: bool, to_light: Any) -> None:
    """Add `color` times max(n·l, 0) and the light's strength to the vertices' colours.

    If `is_uniform`, l is the direction of `to_light`. If not, the rows from `DX` on have vectors to the light. The
    strengths are in the row `STRENGTH` if `varies`; if not, all are 1.
    """
    inverse = inverse_length(square(to_light))
    for i in range(BLOCK):
        d = to_light if is_uniform else vector(shifted(rows, at.DX), i)
        scale = (inverse if is_uniform else rows[at.INVERSE_DISTANCE + i]) * rows[at.INVERSE_NORMAL + i]
        factor = max(dot(vector(shifted(rows, at.NX), i), d) * scale, ZERO) * _strength(rows, i, varies)
        rows[at.R + i] = multiply_add(color[0], factor, rows[at.R + i])
        rows[at.G + i] = multiply_add(color[1], factor, rows[at.G + i])
        rows[at.B + i] = multiply_add(color[2], factor, rows[at.B + i])


@compiled
def _arrive_evenly(rows: Any, to_light: Any) -> None:
    """Fill the rows of D, the vector to a light, with the vector `to_light`, and the row of 1/|D|."""
    inverse = inverse_length(square(to_light))
    for i in range(BLOCK):
        put(shifted(rows, at.DX), i, to_light)
        rows[at.INVERSE_DISTANCE + i] = inverse


@inlined_early
def _add_light(
    first: int, count: int, channels: Any, t: Any, s: Any, numbers: Any, own: Any, rows: Any, points: Any
) -> bool:
    """Add one light to the colours of a block; return True if no vertex of the block is declined.

    Parameters
    ----------
    first, count, channels, t, s, rows, points
        As in the description of the module `vertices`.
    numbers, own
        Numbers that the reflectance's stage reads (`numbers`), and numbers that the light's stage reads (`own`).
    """
    good = True
    to_light = in_type(t.to_light, rows)
    if not t.is_uniform:
        good = call_stage(t.arrives, own, rows, points) != 0
    varies = t.varies
    if varies:
        _settle_strength(rows, as_type_of(rows, t.gain))
    if t.has_ambient:
        _add(rows, at.AMBIENT_R if s.has_diffuse else at.R, at.SKY, varies, in_type(t.ambient, rows))
    if not t.wanted:
        return good
    if t.visible >= 0:
        at.load_seen(channels, t.visible, first, count, s, rows, at.VISIBLE)
        _hide(rows, varies)
        varies = True
    if not t.reflects:
        _add_lambert(rows, varies, in_type(t.colors[0], rows), t.is_uniform, to_light)
        return good
    if t.is_uniform:
        _arrive_evenly(rows, to_light)
    reflected = t.wanted & call_stage(t.reflects, numbers, rows, points)
    if reflected & 3 == 3 and not s.is_split:
        _add_two(rows, varies, in_type(t.colors[0], rows), in_type(t.colors[1], rows))
        reflected &= 4
    for lobe in range(3):
        if reflected & (1 << lobe):
            target = at.OTHER_R if s.is_split and not s.takes_albedo & (1 << lobe) else at.R
            if s.unmapped & (1 << lobe):
                target = at.UNMAPPED_R
            _add(rows, target, at.FIRST + lobe * BLOCK, varies, in_type(t.colors[lobe], rows))
    return good


# --- colours out of the block's rows


@inlined
def _clipped(intensity: Any, low: Any, high: Any) -> Any:
    """Return `intensity` clipped to [`low`, `high`]; NaN stays NaN."""
    return min(max(intensity, low), high)


@inlined
def _byte(intensity: Any) -> Any:
    """Return the byte, 0 to 255, for an intensity in [0, 1], rounded to nearest, ties to even."""
    fraction = _clipped(np.float32(intensity), ZERO, ONE)
    return np.uint8(np.float32(fraction * np.float32(255.0) + WHOLE32).view(np.int32))


@compiled
def _multiply_by_albedo(first: int, count: int, albedo: Any, rows: Any, has_ambient: bool) -> None:
    """Multiply a block's colours by the albedo, clipped to [0, 1]; NaN counts as 0.

    If `has_ambient`, the ambient light is in separate rows, and is multiplied too. The albedo is loaded into the rows
    of the lobes' factors, which are no longer needed. `first` and `count` are as in the module `vertices`.
    """
    at.load_vectors(albedo, first, count, shifted(rows, at.FIRST))
    for i in range(3 * BLOCK):
        given = rows[at.FIRST + i]
        part = min(given, ONE) if given > ZERO else ZERO
        rows[at.R + i] = rows[at.R + i] * part
        if has_ambient:
            rows[at.AMBIENT_R + i] = rows[at.AMBIENT_R + i] * part


@compiled
def _multiply_by_diffuse(first: int, count: int, diffuse: Any, rows: Any, over: Any) -> None:
    """Multiply a block's diffuse light by the map `diffuse` and the factor `over`. Then add the ambient light.

    `first`, `count` and `rows` are as in the module `vertices`.
    """
    at.load_vectors(diffuse, first, count, shifted(rows, at.FIRST))
    for i in range(3 * BLOCK):
        rows[at.R + i] = multiply_add(rows[at.R + i], rows[at.FIRST + i] * over, rows[at.AMBIENT_R + i])


@compiled
def _add_times_map(first: int, count: int, tints: Any, rows: Any, start: int, over: Any) -> None:
    """Add the three rows that begin at offset `start`, times a map and a number, to a block's colours.

    `tints` is the map, a colour for each of all vertices, and `over` is the number. `first` and `count` are as in the
    module `vertices`.
    """
    at.load_vectors(tints, first, count, shifted(rows, at.FIRST))
    for i in range(3 * BLOCK):
        rows[at.R + i] = multiply_add(rows[start + i], rows[at.FIRST + i] * over, rows[at.R + i])


@compiled
def _add_rows(rows: Any, start: int) -> None:
    for i in range(3 * BLOCK):
        rows[at.R + i] = rows[at.R + i] + rows[start + i]


@inlined_early
def _tint(first: int, count: int, albedo: Any, diffuse: Any, specular: Any, s: Any, rows: Any) -> None:
    """Multiply each part of a block's colours by its map, `albedo`, `diffuse` or `specular`, and sum the parts.

    The sum does not include the emission. The maps are pointers to a colour for each of all vertices.
    """
    if s.has_albedo:
        _multiply_by_albedo(first, count, albedo, rows, s.has_diffuse)
    if s.has_diffuse:
        _multiply_by_diffuse(first, count, diffuse, rows, as_type_of(rows, s.over_diffuse))
    if s.has_specular:
        _add_times_map(first, count, specular, rows, at.OTHER_R, as_type_of(rows, s.over_specular))
    elif s.is_split:
        _add_rows(rows, at.OTHER_R)
    if s.unmapped:
        _add_rows(rows, at.UNMAPPED_R)


@inlined_early
def _add_emission(first: int, count: int, emission: Any, s: Any, rows: Any) -> None:
    """Add the emission, times its map if there is one, to a block's colours.

    If the colours include the emission from the start, do nothing.
    """
    if s.has_emission or s.is_split:
        fill(rows, at.OTHER_R, in_type(s.emission, rows))
        if s.has_emission:
            _add_times_map(first, count, emission, rows, at.OTHER_R, as_type_of(rows, s.over_emission))
        else:
            _add_rows(rows, at.OTHER_R)


# --- separate shares


@compiled
def _add_share(rows: Any, start: int) -> None:
    """Add a share, one component of a light's contribution, to the three rows that begin at offset `start`.

    The share is in the rows of the block's colours.
    """
    for i in range(3 * BLOCK):
        rows[start + i] = rows[start + i] + rows[at.R + i]


@inlined_early
def _end_share(first: int, count: int, rgb: Any, t: Any, s: Any, rows: Any) -> None:
    """Add a complete share to the sums of its light and of its component. Clear the rows for the next share.

    A share is one component of a light's contribution; `t` is the record of its last term. If the share is the last of
    its light, store the light's sum in the output, `t.light_at` numbers after `rgb`. `first` and `count` are as in the
    module `vertices`.
    """
    if not t.is_alone:
        _add_share(rows, at.LIGHT_R)
    if t.light_at:
        out, light = shifted(rgb, t.light_at), at.R if t.is_alone else at.LIGHT_R
        prefetch_to_write(out, first + BLOCK)
        _put_rows(first, count, out, rows, light)
        if not t.is_alone:
            clear(rows, at.LIGHT_R)
    _add_share(rows, at.COMPONENTS + 3 * BLOCK * t.component)
    clear(rows, at.R)
    if s.is_split:
        clear(rows, at.OTHER_R)
    if s.unmapped:
        clear(rows, at.UNMAPPED_R)
    if s.has_diffuse:
        clear(rows, at.AMBIENT_R)


@inlined_early
def _end_shares(first: int, count: int, rgb: Any, s: Any, rows: Any) -> None:
    """Store the sum of each component in the output, and write the total into the rows of the block's colours.

    The components are stored `s.components_at` numbers after `rgb`. `first` and `count` are as in the module
    `vertices`.
    """
    for k in range(4):
        if s.components_at[k]:
            component = at.COMPONENTS + 3 * BLOCK * k
            _add_rows(rows, component)
            out = shifted(rgb, s.components_at[k])
            prefetch_to_write(out, first + BLOCK)
            _put_rows(first, count, out, rows, component)


@compiled
def _finish(s: Any, rows: Any) -> None:
    """Raise a block's colours to the power `s.exponent`. Colours below 0 count as 0.

    If the exponent is 1, do nothing.
    """
    if s.exponent != 1.0:
        exponent = as_type_of(rows, s.exponent)
        for i in range(3 * BLOCK):
            rows[at.R + i] = max(rows[at.R + i], ZERO) ** exponent


@compiled
def _put_rows(first: int, count: int, out: Any, rows: Any, start: int) -> None:
    """Store the three rows that begin at offset `start` as vectors of `out`, without clipping.

    `first` is the index of the first vector in `out`, and `count` the number of vectors.
    """
    part = shifted(out, 3 * first)
    for i in range(count):
        part[3 * i] = rows[start + i]
        part[3 * i + 1] = rows[start + BLOCK + i]
        part[3 * i + 2] = rows[start + 2 * BLOCK + i]


@compiled
def _store_floats(first: int, count: int, rgb: Any, s: Any, rows: Any) -> None:
    low, high = as_type_of(rows, s.low), as_type_of(rows, s.high)
    part = shifted(rgb, 3 * first)
    for i in range(count):
        part[3 * i] = _clipped(rows[at.R + i], low, high)
        part[3 * i + 1] = _clipped(rows[at.G + i], low, high)
        part[3 * i + 2] = _clipped(rows[at.B + i], low, high)


@compiled
def _store_bytes(first: int, count: int, display: Any, rows: Any) -> None:
    part = shifted(display, 3 * first)
    for i in range(count):
        part[3 * i] = _byte(rows[at.R + i])
        part[3 * i + 1] = _byte(rows[at.G + i])
        part[3 * i + 2] = _byte(rows[at.B + i])


@inlined_early
def _store(first: int, count: int, rgb: Any, display: Any, s: Any, rows: Any) -> None:
    """Store the colours of a block: bytes in `display` if `s.is_display`, else floats in `rgb`."""
    if s.is_display:
        _store_bytes(first, count, display, rows)
    else:
        _store_floats(first, count, rgb, s, rows)
