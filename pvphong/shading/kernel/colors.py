"""The kernel's loops over colours: what light leaves a surface is added up, tinted, clipped and stored.

Each is simple enough for LLVM to vectorise. Literals are float32: a Python float would widen float32 arithmetic, and
these are widened, exactly, where rows are float64. There is no fast-math: each vertex's bits are what IEEE arithmetic
makes of its own numbers. Products and sums are fused by `multiply_add` alone, and so alike in every loop; where terms
that cancel exactly must leave 0 they are not fused.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.base.float_range import BRIGHTEST
from pvphong.shading.kernel import vertices as at
from pvphong.shading.kernel.arithmetic import WHOLE32, inlined, like, multiply_add, plain, shifted
from pvphong.shading.kernel.vertices import BLOCK, dot, in_type, inverse_root, is_moderate, normal_dot, square_of

_ZERO, _ONE, _BRIGHTEST = np.float32(0.0), np.float32(1.0), np.float32(BRIGHTEST)


@inlined
def _reflectance(albedo: Any) -> Any:
    """In [0, 1], and 0 for a NaN."""
    return min(albedo, _ONE) if albedo > _ZERO else _ZERO


@inlined
def clipped(intensity: Any, low: Any, high: Any) -> Any:
    """In [low, high], for all but NaN."""
    return min(max(intensity, low), high)


@plain
def tint(rows: Any) -> None:
    """Colour times albedo plus highlights."""
    for i in range(BLOCK):
        rows[at.R + i] = rows[at.R + i] * _reflectance(rows[at.ALBEDO_R + i]) + rows[at.HR + i]
        rows[at.G + i] = rows[at.G + i] * _reflectance(rows[at.ALBEDO_G + i]) + rows[at.HG + i]
        rows[at.B + i] = rows[at.B + i] * _reflectance(rows[at.ALBEDO_B + i]) + rows[at.HB + i]


@plain
def encode(rows: Any, exponent: Any) -> None:
    """Colours raised to a power."""
    for i in range(3 * BLOCK):
        rows[at.R + i] = max(rows[at.R + i], _ZERO) ** exponent


@plain
def join(rows: Any, low: Any, high: Any, rgb: Any, start: int, count: int) -> None:
    """Colours, clipped to [low, high], one after the other."""
    part = shifted(rgb, 3 * start)
    for i in range(count):
        part[3 * i] = clipped(rows[at.R + i], low, high)
        part[3 * i + 1] = clipped(rows[at.G + i], low, high)
        part[3 * i + 2] = clipped(rows[at.B + i], low, high)


@inlined
def _byte(intensity: Any) -> Any:
    """0-255 for an intensity clipped to [0, 1]: the nearest, and of two equally near the even one."""
    fraction = clipped(np.float32(intensity), _ZERO, _ONE)
    return np.uint8(np.float32(fraction * np.float32(255.0) + WHOLE32).view(np.int32))


@plain
def join_bytes(rows: Any, display: Any, start: int, count: int) -> None:
    """`join` for uint8."""
    part = shifted(display, 3 * start)
    for i in range(count):
        part[3 * i] = _byte(rows[at.R + i])
        part[3 * i + 1] = _byte(rows[at.G + i])
        part[3 * i + 2] = _byte(rows[at.B + i])


# --- adding what a light leaves


@plain
def fill(rows: Any, start: int, x: Any, y: Any, z: Any) -> None:
    """The same vector or colour in three rows."""
    for i in range(BLOCK):
        rows[start + i] = x
        rows[start + BLOCK + i] = y
        rows[start + 2 * BLOCK + i] = z


@inlined
def _add(rows: Any, i: int, factor: Any, red: Any, green: Any, blue: Any) -> None:
    rows[at.R + i] = multiply_add(red, factor, rows[at.R + i])
    rows[at.G + i] = multiply_add(green, factor, rows[at.G + i])
    rows[at.B + i] = multiply_add(blue, factor, rows[at.B + i])


@inlined
def _strength(rows: Any, i: int, gain: Any) -> Any:
    return min(rows[at.STRENGTH + i] * gain, _BRIGHTEST)


@plain
def add_evenly(rows: Any, red: Any, green: Any, blue: Any) -> None:
    """Add a colour."""
    for i in range(BLOCK):
        _add(rows, i, _ONE, red, green, blue)


@plain
def add_strength(rows: Any, gain: Any, red: Any, green: Any, blue: Any) -> None:
    """Add a colour times the light's strength."""
    for i in range(BLOCK):
        _add(rows, i, _strength(rows, i, gain), red, green, blue)


# --- what blocks light


@plain
def fill_under_sky(rows: Any, red: Any, green: Any, blue: Any, own_red: Any, own_green: Any, own_blue: Any) -> None:
    """A colour times the sky's open part, plus another colour, in place of what is there."""
    for i in range(BLOCK):
        sky = rows[at.SKY + i]
        rows[at.R + i] = multiply_add(red, sky, own_red)
        rows[at.G + i] = multiply_add(green, sky, own_green)
        rows[at.B + i] = multiply_add(blue, sky, own_blue)


@plain
def add_sky(rows: Any, red: Any, green: Any, blue: Any) -> None:
    """Add a colour times the sky's open part."""
    for i in range(BLOCK):
        _add(rows, i, rows[at.SKY + i], red, green, blue)


@plain
def add_strength_under_sky(rows: Any, gain: Any, red: Any, green: Any, blue: Any) -> None:
    """`add_strength`, times the sky's open part."""
    for i in range(BLOCK):
        _add(rows, i, _strength(rows, i, gain) * rows[at.SKY + i], red, green, blue)


@plain
def block(rows: Any, gain: Any, varies: bool) -> None:
    """Strengths, gain included, times the light's visible part; the visible part alone where it has no strengths."""
    if varies:
        for i in range(BLOCK):
            rows[at.STRENGTH + i] = _strength(rows, i, gain) * rows[at.VISIBLE + i]
    else:
        for i in range(BLOCK):
            rows[at.STRENGTH + i] = rows[at.VISIBLE + i]


# --- Lambert's factor alone, straight from normals and ways


@inlined
def lambert(rows: Any, i: int) -> Any:
    """max(n·l, 0)."""
    n_d = normal_dot(rows, i, rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i])
    return max(n_d * (rows[at.NEARNESS + i] * rows[at.INVERSE + i]), _ZERO)


@plain
def add_lambert(rows: Any, red: Any, green: Any, blue: Any) -> None:
    """Add a colour times max(n·l, 0)."""
    for i in range(BLOCK):
        _add(rows, i, lambert(rows, i), red, green, blue)


@plain
def add_weakened(rows: Any, gain: Any, red: Any, green: Any, blue: Any) -> None:
    """`add_lambert`, times the strength."""
    for i in range(BLOCK):
        _add(rows, i, lambert(rows, i) * _strength(rows, i, gain), red, green, blue)


@plain
def add_parallel(rows: Any, red: Any, green: Any, blue: Any, x: Any, y: Any, z: Any) -> None:
    """`add_lambert` for the same way (x, y, z) to the light everywhere, whose inverse length is in the colour."""
    for i in range(BLOCK):
        n_l = max(normal_dot(rows, i, x, y, z) * rows[at.INVERSE + i], _ZERO)
        _add(rows, i, n_l, red, green, blue)


@plain
def add_parallel_weakened(rows: Any, red: Any, green: Any, blue: Any, x: Any, y: Any, z: Any) -> None:
    """`add_parallel`, times the strength."""
    for i in range(BLOCK):
        n_l = max(normal_dot(rows, i, x, y, z) * rows[at.INVERSE + i], _ZERO)
        _add(rows, i, n_l * rows[at.STRENGTH + i], red, green, blue)


# --- factors of lobes, as a reflectance's stage leaves them


@plain
def weaken(rows: Any, factors: int, gain: Any) -> None:
    """Multiply a lobe's factors by the strength."""
    for i in range(BLOCK):
        rows[factors + i] *= _strength(rows, i, gain)


@plain
def add_lobe(rows: Any, factors: int, target: int, red: Any, green: Any, blue: Any) -> None:
    """Add a colour times a lobe's factors to the rows of a colour."""
    for i in range(BLOCK):
        factor = rows[factors + i]
        rows[target + i] = multiply_add(red, factor, rows[target + i])
        rows[target + BLOCK + i] = multiply_add(green, factor, rows[target + BLOCK + i])
        rows[target + 2 * BLOCK + i] = multiply_add(blue, factor, rows[target + 2 * BLOCK + i])


@plain
def add_two(rows: Any, red: Any, green: Any, blue: Any, other_red: Any, other_green: Any, other_blue: Any) -> None:
    """The first two lobes at half the traffic, where no albedo keeps them apart."""
    for i in range(BLOCK):
        first, second = rows[at.FIRST + i], rows[at.SECOND + i]
        rows[at.R + i] = multiply_add(other_red, second, multiply_add(red, first, rows[at.R + i]))
        rows[at.G + i] = multiply_add(other_green, second, multiply_add(green, first, rows[at.G + i]))
        rows[at.B + i] = multiply_add(other_blue, second, multiply_add(blue, first, rows[at.B + i]))


@plain
def add_three(rows: Any, r1: Any, g1: Any, b1: Any, r2: Any, g2: Any, b2: Any, r3: Any, g3: Any, b3: Any) -> None:
    """All three lobes likewise."""
    for i in range(BLOCK):
        first, second, third = rows[at.FIRST + i], rows[at.SECOND + i], rows[at.THIRD + i]
        red = multiply_add(r2, second, multiply_add(r1, first, rows[at.R + i]))
        green = multiply_add(g2, second, multiply_add(g1, first, rows[at.G + i]))
        blue = multiply_add(b2, second, multiply_add(b1, first, rows[at.B + i]))
        rows[at.R + i] = multiply_add(r3, third, red)
        rows[at.G + i] = multiply_add(g3, third, green)
        rows[at.B + i] = multiply_add(b3, third, blue)


# --- one even light and Lambert's factor alone


@plain
def shine_on(normals: Any, start: int, s: Any, t: Any, rgb: Any) -> bool:
    """Light a whole block from vertex `start` on.

    Gives whether all normals can be used as they come; else these colours are useless.
    """
    low, high = like(rgb, s.low), like(rgb, s.high)
    (lx, ly, lz), (red, green, blue) = in_type(t.way, rgb), in_type(t.colors[0], rgb)
    base_red, base_green, base_blue = in_type(s.base, rgb)
    part, lit = shifted(normals, 3 * start), shifted(rgb, 3 * start)
    good = True
    for i in range(BLOCK):
        x, y, z = like(rgb, part[3 * i]), like(rgb, part[3 * i + 1]), like(rgb, part[3 * i + 2])
        square = square_of(x, y, z)
        n_l = max(dot(x, y, z, lx, ly, lz) * inverse_root(square), _ZERO)
        lit[3 * i] = clipped(multiply_add(red, n_l, base_red), low, high)
        lit[3 * i + 1] = clipped(multiply_add(green, n_l, base_green), low, high)
        lit[3 * i + 2] = clipped(multiply_add(blue, n_l, base_blue), low, high)
        good = good & is_moderate(square)
    return good
