"""The kernel's integrals over disks above the horizon, as they are seen; and over caps, as disks across their middle.

The rim x(δ) = M + r (cos δ u + sin δ t), u the way up in the disk's plane, is above the horizon for |δ| <= β. The
boundary integral of `optics.spherical` is taken along that in pieces of 16 nodes, and back along the horizon; with
G = w × x, its integrand is G·x' (1 − zᵖ) / |G|², and zᵖ is (1 − |G|²/|x|²)^(p/2): nothing cancels next to w. Small
disks lose digits that way; they are summed at nodes on chords along the horizon, as in `optics.spherical.tiny_disk`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel import arcs
from pvphong.shading.kernel import vertices as at
from pvphong.shading.kernel.angles32 import angle_above, cosine_and_sine
from pvphong.shading.kernel.arithmetic import WHOLE32, exp2, exp2_less_one32, inlined, like, log2_power, multiply_add
from pvphong.shading.kernel.vertices import BLOCK, dot, square_of, unit_normal

_F = np.float32
_ZERO, _QUARTER, _HALF, _ONE, _TWO = _F(0.0), _F(0.25), _F(0.5), _F(1.0), _F(2.0)
_PI, _TINY = _F(math.pi), _F(2.0**-126)
# Of a vector across another, from rounding alone.
_LEVEL = _F(1e-6)

# |M|, r, the axis e with e·M > 0, w; 1 where an integral is wanted, then the integral. Set by the caller.
FORWARD, RADIUS, EX, EY, EZ, WX, WY, WZ, FOUND = (at.RIM + k * BLOCK for k in range(9))
# u, β; how many pieces are wanted, then one over their number; the least sin² of the angle off −w; the sum.
_UX, _UY, _UZ, _BETA, _PART, _OPPOSITE, _SUM = (at.RIM + k * BLOCK for k in range(9, 16))

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_PLACES, _SHARES = tuple(_F(x) for x in _NODES), tuple(_F(x) for x in _WEIGHTS)
# So many widths of a lobe does half a piece measure at most: a Gaussian is right to 1e-7 then. Powers count as 25 at
# least, for u itself turns along the rim. What wants more pieces is left to the reference.
_WIDTHS, _SMOOTH, _MOST = _F(5.0), _F(25.0), 24
# Pieces that start from here on, over their number, are beyond the last one.
_BEFORE_END = _F(0.99)

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_ALONG, _ALONG_SHARES = tuple(_F(0.125 * (x + 1.0)) for x in _NODES), tuple(_F(0.5 * x) for x in _WEIGHTS)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_ACROSS, _ACROSS_SHARES = tuple(_F(x) for x in _NODES), tuple(_F(x) for x in _WEIGHTS)

# What is to be done with a vertex: FOUND until it is.
_BY_NODES, _BY_RIM = _ONE, _TWO


@inlined
def power_within_rim(rows: Any, exponent: Any, shown: float, small: float, is_cosine: bool) -> bool:
    """1/(π r²) · ∫ max(w·u, 0)ⁿ du above the horizon where FOUND is 1; whether no vertex is declined.

    `shown` is the 1 − z from which zⁿ⁺¹ is nothing, `small` the r/|M| below which disks are summed at nodes. If
    `is_cosine`, w is the normal, and n is 1.
    """
    power = like(rows, exponent) + _ONE
    good, any_small, any_large, any_cut = _look(rows, power, like(rows, small))
    if any_large:
        good = _along_rim(rows, power, is_cosine) & good
        if any_cut:
            _along_horizon(rows, like(rows, shown))
            if not is_cosine:  # on the horizon that is nothing
                arcs.end_arc(rows, power)
        for i in range(BLOCK):
            r, turn = rows[RADIUS + i], multiply_add(rows[_SUM + i], rows[_BETA + i], rows[arcs.TURNED + i])
            by_rim = arcs.whole_of(turn) / (power * _PI * max(r * r, _TINY))
            rows[FOUND + i] = by_rim if rows[FOUND + i] == _BY_RIM else rows[FOUND + i]
            rows[_SUM + i] = _ZERO
    if any_small:
        _on_chords(rows, like(rows, exponent), like(rows, small), is_cosine)
    return good


@inlined
def _look(rows: Any, power: Any, tiny: Any) -> tuple[bool, bool, bool, bool]:
    """What of a rim is above the horizon, and what is to be done: into FOUND.

    Gives whether no vertex is declined, whether some disk is small, whether some is large, and whether the horizon
    cuts one of these.
    """
    good, any_small, any_large, any_cut = True, False, False, False
    roughly = np.sqrt(max(power, _SMOOTH)) / _WIDTHS
    for i in range(BLOCK):
        nx, ny, nz = unit_normal(rows, i)
        ex, ey, ez, f, r = rows[EX + i], rows[EY + i], rows[EZ + i], rows[FORWARD + i], rows[RADIUS + i]
        mx, my, mz = _middle(rows, i)
        up, ux, uy, uz = _across(nx, ny, nz, ex, ey, ez)
        is_level = up < _LEVEL  # any way across e will do
        tx, ty, tz = (_ONE, _ZERO, _ZERO) if abs(ex) < _HALF else (_ZERO, _ONE, _ZERO)
        ux, uy, uz = tx if is_level else ux, ty if is_level else uy, tz if is_level else uz
        _, ux, uy, uz = _across(ux, uy, uz, ex, ey, ez)  # once more, for nearly level it has been rounded
        rows[_UX + i], rows[_UY + i], rows[_UZ + i] = ux, uy, uz
        height, slope = dot(nx, ny, nz, mx, my, mz), r * up
        is_cut = abs(height) < slope
        beta = angle_above(np.sqrt(max((slope - height) * (slope + height), _ZERO)), -height) if is_cut else _PI
        over = dot(ex, ey, ez, mx, my, mz)
        off = np.sqrt(max((f - over) * (f + over), _ZERO)) - r  # from the rim to the foot of the vertex, in the plane
        wanted = beta * r * roughly / max(np.sqrt(multiply_add(off, off, over * over)), _TINY)
        is_small, has_normal = r < tiny * f, square_of(nx, ny, nz) > _HALF
        is_wanted = (rows[FOUND + i] > _ZERO) & (height > -slope) & has_normal
        is_lost = is_wanted & (not is_small) & (not wanted < _F(_MOST))
        is_done = is_wanted & (not is_small) & (not is_lost)
        good = good & (not is_lost)
        rows[at.DECLINED + i] = _ONE if is_lost else rows[at.DECLINED + i]
        any_large, any_cut = any_large | is_done, any_cut | (is_done & is_cut)
        any_small = any_small | (is_wanted & is_small)
        rows[_BETA + i], rows[_PART + i], rows[_OPPOSITE + i] = beta, wanted, _ONE
        rows[_SUM + i], rows[arcs.TURNED + i] = _ZERO, _ZERO
        rows[FOUND + i] = _BY_RIM if is_done else (_BY_NODES if is_wanted & is_small else _ZERO)
    return good, any_small, any_large, any_cut


@inlined
def _across(x: Any, y: Any, z: Any, ex: Any, ey: Any, ez: Any) -> tuple[Any, Any, Any, Any]:
    """Length of the part of a vector across e, and its unit vector."""
    along = dot(x, y, z, ex, ey, ez)
    x, y, z = x - along * ex, y - along * ey, z - along * ez
    length = np.sqrt(square_of(x, y, z))
    unit = _ONE / max(length, _TINY)
    return length, x * unit, y * unit, z * unit


@inlined
def _middle(rows: Any, i: int) -> tuple[Any, Any, Any]:
    """M."""
    size = rows[FORWARD + i] * rows[at.NEARNESS + i]
    return rows[at.DX + i] * size, rows[at.DY + i] * size, rows[at.DZ + i] * size


@inlined
def _upward(rows: Any, i: int) -> tuple[Any, Any, Any, Any, Any, Any]:
    """U and t."""
    ux, uy, uz = rows[_UX + i], rows[_UY + i], rows[_UZ + i]
    ex, ey, ez = rows[EX + i], rows[EY + i], rows[EZ + i]
    return ux, uy, uz, ey * uz - ez * uy, ez * ux - ex * uz, ex * uy - ey * ux


@inlined
def _along_rim(rows: Any, power: Any, is_cosine: bool) -> bool:
    """The integral along the rim over β; whether no vertex is declined, for −w is next to the rim."""
    least, half_power, good, part = like(rows, -np.inf), _HALF * power, True, _ONE
    for i in range(BLOCK):
        pieces = max((rows[_PART + i] + _HALF + WHOLE32) - WHOLE32, _ONE)
        rows[_PART + i] = _ONE / (pieces if rows[FOUND + i] == _BY_RIM else _ONE)
    for i in range(BLOCK):
        part = min(part, rows[_PART + i])
    for piece in range(int(_HALF + _ONE / part)):
        for k in range(len(_PLACES)):
            ahead, passed, weight = _F(2 * piece + 1) + _PLACES[k], _F(piece), _SHARES[k]
            for i in range(BLOCK):
                part = rows[_PART + i]
                place = min(multiply_add(ahead, part, -_ONE), _ONE)
                share = weight * part if passed * part < _BEFORE_END else _ZERO
                ux, uy, uz, tx, ty, tz = _upward(rows, i)
                wx, wy, wz = rows[WX + i], rows[WY + i], rows[WZ + i]
                mx, my, mz = _middle(rows, i)
                r = rows[RADIUS + i]
                cosine, sine = cosine_and_sine(_QUARTER * place * rows[_BETA + i])
                x = multiply_add(r, multiply_add(cosine, ux, sine * tx), mx)
                y = multiply_add(r, multiply_add(cosine, uy, sine * ty), my)
                z = multiply_add(r, multiply_add(cosine, uz, sine * tz), mz)
                gx, gy, gz = wy * z - wz * y, wz * x - wx * z, wx * y - wy * x
                forward = cosine * dot(gx, gy, gz, tx, ty, tz) - sine * dot(gx, gy, gz, ux, uy, uz)
                across, along = max(square_of(gx, gy, gz), _TINY), dot(wx, wy, wz, x, y, z)
                q = min(across / max(square_of(x, y, z), _TINY), _ONE)
                shown = q if is_cosine else -exp2_less_one32(log2_power(_TWO * q, half_power, least))
                shown = shown if along > _ZERO else _ONE
                rows[_SUM + i] = multiply_add(share, r * forward * shown / across, rows[_SUM + i])
                rows[_OPPOSITE + i] = min(rows[_OPPOSITE + i], _ONE if along > _ZERO else q)
    for i in range(BLOCK):
        is_lost = (rows[FOUND + i] == _BY_RIM) & (rows[_OPPOSITE + i] < _QUARTER)
        rows[at.DECLINED + i] = _ONE if is_lost else rows[at.DECLINED + i]
        good = good & (not is_lost)
    return good


@inlined
def _along_horizon(rows: Any, nothing: Any) -> None:
    """The way back along the horizon where that cuts a rim.

    Ahead, and to the side −t, the rim's ends are at (a, ±b − M·t).
    """
    for i in range(BLOCK):
        nx, ny, nz = unit_normal(rows, i)
        ux, uy, uz, tx, ty, tz = _upward(rows, i)
        mx, my, mz = _middle(rows, i)
        gx, gy, gz = ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx
        cosine, sine = cosine_and_sine(_QUARTER * rows[_BETA + i])
        r = rows[RADIUS + i]
        a = multiply_add(r * cosine, dot(gx, gy, gz, ux, uy, uz), dot(gx, gy, gz, mx, my, mz))
        b, middle = r * sine, dot(tx, ty, tz, mx, my, mz)
        w = rows[WX + i], rows[WY + i], rows[WZ + i]
        arcs.begin_along_horizon(rows, i, (nx, ny, nz), (gx, gy, gz), w, (a, -middle - b), (a, b - middle), nothing)
        arcs.keep_if(rows, i, (rows[_BETA + i] < _PI) & (rows[FOUND + i] == _BY_RIM))


@inlined
def _on_chords(rows: Any, exponent: Any, tiny: Any, is_cosine: bool) -> None:
    """The integral at nodes where that was chosen. At the angle α <= β off the rim's highest point is a chord."""
    least = like(rows, -np.inf)
    for k in range(len(_ALONG)):
        for j in range(len(_ACROSS)):
            for i in range(BLOCK):
                ux, uy, uz, tx, ty, tz = _upward(rows, i)
                mx, my, mz = _middle(rows, i)
                cosine, sine = cosine_and_sine(_ALONG[k] * rows[_BETA + i])
                up, aside = rows[RADIUS + i] * cosine, rows[RADIUS + i] * sine * _ACROSS[j]
                x = multiply_add(up, ux, multiply_add(aside, tx, mx))
                y = multiply_add(up, uy, multiply_add(aside, ty, my))
                z = multiply_add(up, uz, multiply_add(aside, tz, mz))
                inverse = _ONE / np.sqrt(max(square_of(x, y, z), _TINY))
                facing = dot(rows[EX + i], rows[EY + i], rows[EZ + i], x, y, z) * inverse
                wx, wy, wz = rows[WX + i], rows[WY + i], rows[WZ + i]
                if is_cosine:
                    raised = max(dot(wx, wy, wz, x, y, z) * inverse, _ZERO)
                else:
                    less = _HALF * square_of(x * inverse - wx, y * inverse - wy, z * inverse - wz)
                    raised = exp2(log2_power(_TWO * less, exponent, least)) if less < _ONE else _ZERO
                share = _ALONG_SHARES[k] * _ACROSS_SHARES[j] * (sine * sine)
                rows[_SUM + i] = multiply_add(share * raised, facing * (inverse * inverse), rows[_SUM + i])
    for i in range(BLOCK):
        is_wanted = (rows[FOUND + i] == _BY_NODES) & (rows[RADIUS + i] < tiny * rows[FORWARD + i])
        rows[FOUND + i] = rows[_SUM + i] * rows[_BETA + i] / _PI if is_wanted else rows[FOUND + i]
