"""The kernel's integrals along arcs of great circles: sides of polygons, and the horizon.

They are of 1 − max(z, 0)ᵖ over dφ, the angle around w, in float32; formulas as in `optics.spherical.great_arc`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel import vertices as at
from pvphong.shading.kernel.angles32 import angle_above, angle_of, small_sine
from pvphong.shading.kernel.arithmetic import exp2_less_one32, inlined, like, log2_power, multiply_add
from pvphong.shading.kernel.vertices import BLOCK, dot, square_of

_F = np.float32
_ZERO, _HALF, _ONE, _TWO = _F(0.0), _F(0.5), _F(1.0), _F(2.0)
_TWO_PI, _TINY = _F(2.0 * math.pi), _F(2.0**-126)

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_PLACES, _SHARES = tuple(_F(x) for x in _NODES), tuple(_F(x) for x in _WEIGHTS)

# 1 − |w × m|, |w × m|, w·m; the middle of the part where the power shows and half its length; the sum over all arcs.
_POLE, _ACROSS, _ALONG, _MIDDLE, _HALF_LENGTH, TURNED = (at.ARC + k * BLOCK for k in range(6))


@inlined
def _turn(rise: Any, first: Any, last: Any) -> Any:
    """∫ dφ along an arc between two angles in [−π/2, π/2], for |w·m| = `rise`."""
    sf, sl = small_sine(_HALF * first), small_sine(_HALF * last)
    cf, cl = np.sqrt(max(_ONE - sf * sf, _ZERO)), np.sqrt(max(_ONE - sl * sl, _ZERO))
    sine_first, sine_last = _TWO * sf * cf, _TWO * sl * cl
    cosine_first, cosine_last = _ONE - _TWO * sf * sf, _ONE - _TWO * sl * sl
    over = rise * (sine_last * cosine_first - cosine_last * sine_first)
    return angle_above(max(over, _ZERO), rise * rise * cosine_first * cosine_last + sine_first * sine_last)


@inlined
def begin_arc(
    rows: Any, i: int, length: Any, pq: Any, wp: Any, wq: Any, aside: Any, along: Any, across: Any, nothing: Any
) -> None:
    """Add what a vertex's arc from p to q, counter-clockwise around the unit vector m, has where the power is nothing.

    Parameters
    ----------
    length, pq, wp, wq, aside
        |p × q|, p·q, w·p, w·q, and p·(m × w).
    along, across
        w·m, and |w × m|.
    nothing
        The 1 − z from which zᵖ is nothing.
    """
    seen = angle_above(length, pq)
    pole = along * along / (_ONE + across)
    start = angle_of(aside, wp)
    stop = start + seen
    turns = (_TWO_PI if start + stop < -_TWO_PI else _ZERO) - (_TWO_PI if start + stop > _TWO_PI else _ZERO)
    height = min(max((nothing - pole) / max(_TWO * across, _TINY), _ZERO), _HALF)
    window = _TWO * angle_above(np.sqrt(height), np.sqrt(_ONE - height))
    start, stop = start + turns, stop + turns
    first, last = min(max(start, -window), window), min(max(stop, -window), window)
    is_all = (first == start) & (last == stop)
    whole = angle_above(abs(along) * length, pq - wp * wq)
    rest = _ZERO if is_all else whole - _turn(abs(along), first, last)
    rows[TURNED + i] += -rest if along < _ZERO else rest
    rows[_POLE + i], rows[_ACROSS + i], rows[_ALONG + i] = pole, across, along
    rows[_MIDDLE + i], rows[_HALF_LENGTH + i] = _HALF * (first + last), _HALF * (seen if is_all else last - first)


@inlined
def begin_along_horizon(
    rows: Any,
    i: int,
    normal: tuple[Any, Any, Any],
    ahead: tuple[Any, Any, Any],
    w: tuple[Any, Any, Any],
    p: tuple[Any, Any],
    q: tuple[Any, Any],
    nothing: Any,
) -> None:
    """As `begin_arc`, of the horizon: p and q are along its unit vector `ahead`, and along normal × ahead."""
    nx, ny, nz = normal
    gx, gy, gz = ahead
    wx, wy, wz = w
    front = dot(wx, wy, wz, gx, gy, gz)
    side = dot(wx, wy, wz, ny * gz - nz * gy, nz * gx - nx * gz, nx * gy - ny * gx)
    across = np.sqrt(square_of(ny * wz - nz * wy, nz * wx - nx * wz, nx * wy - ny * wx))
    length = max(p[0] * q[1] - p[1] * q[0], _ZERO)
    wp, wq = p[0] * front + p[1] * side, q[0] * front + q[1] * side
    aside = p[1] * front - p[0] * side
    begin_arc(
        rows,
        i,
        length,
        p[0] * q[0] + p[1] * q[1],
        wp,
        wq,
        aside,
        dot(wx, wy, wz, nx, ny, nz),
        across,
        nothing,
    )


@inlined
def keep_if(rows: Any, i: int, is_kept: bool) -> None:
    """Leave out a vertex's arc, which is the only one yet."""
    for row in (TURNED, _POLE, _ACROSS, _ALONG, _MIDDLE, _HALF_LENGTH):
        rows[row + i] = rows[row + i] if is_kept else _ZERO


@inlined
def end_arc(rows: Any, power: Any) -> None:
    """Add what the arcs have where the power shows."""
    least = like(rows, -np.inf)
    for k in range(len(_PLACES)):
        for i in range(BLOCK):
            half = rows[_HALF_LENGTH + i]
            sine = small_sine(_HALF * multiply_add(half, _PLACES[k], rows[_MIDDLE + i]))
            less = max(multiply_add(_TWO * rows[_ACROSS + i] * sine, sine, rows[_POLE + i]), _TINY)
            shown = -exp2_less_one32(log2_power(_TWO * less, power, least)) if less < _ONE else _ONE
            part = rows[_ALONG + i] * half * _SHARES[k]
            rows[TURNED + i] = multiply_add(part, shown / (less * (_TWO - less)), rows[TURNED + i])


@inlined
def whole_of(turn: Any) -> Any:
    """The integral around a region from those along its arcs: if −w is inside, a turn is missing."""
    return max(turn + _TWO_PI if turn < -_ONE else turn, _ZERO)
