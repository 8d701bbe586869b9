"""The kernel's loops over polygons that are seen; formulas as in `optics.polygons` and `optics.spherical.great_arc`.

In float32. `shape` holds the polygon in float64: its axis (3), whether its back glows, 1/area, its size, how many
corners and how many nodes there are; then corners' offsets from the middle, nodes' offsets, and nodes' weights, 1 in
sum. Sides are cut off at the horizon for Lambert's cosine. Where the lobe of a power reaches a polygon that the horizon
cuts, vertices are declined, and where one is small or thin that is to be summed along its sides.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import exp2, exp2_less_one32, inlined, log2_power, multiply_add
from pvphong.shading.kernel.caps import angle_of
from pvphong.shading.kernel.pointers import like
from pvphong.shading.kernel.rows import BLOCK
from pvphong.shading.kernel.vectors import dot, square_of

_F = np.float32
_ZERO, _HALF, _ONE, _TWO = _F(0.0), _F(0.5), _F(1.0), _F(2.0)
_PI, _TWO_PI = _F(math.pi), _F(2.0 * math.pi)
_TINY = _F(2.0**-126)

# Distances between which ways are as they come, and squares of squares have room.
_NEAREST, _FARTHEST = _F(2.0**-28), _F(2.0**28)

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_PLACES, _SHARES = tuple(_F(x) for x in _NODES), tuple(_F(x) for x in _WEIGHTS)

# sin x / x for |x| <= π/4 as a polynomial in x², by `mpmath.chebyfit` with 40 digits: 3e-9.
_SINE = tuple(_F(c) for c in (-0.00019503904, 0.0083320355, -0.16666651, 1.0))

# Size over distance below which Lambert's cosine is taken at nodes.
_SMALL = _F(0.15)

# Area over size and distance below which the sum along sides loses too much.
_THIN = _F(0.15)

# Where a stage's own rows begin: h of the plane, w (3), whether the lobe reaches the light, the sum.
_BEHIND, _WX, _WY, _WZ, _REACH, _SUM, _LEAST, _MOST = (at.OWN + k * BLOCK for k in range(8))

# In `shape`.
_AXIS, _TWO_SIDED, _PER_AREA, _SIZE, _CORNERS, _COUNT, _OFFSETS = 0, 3, 4, 5, 6, 7, 8


@inlined
def small_sine(x: Any) -> Any:
    """For |x| <= π/4."""
    square = x * x
    total = _SINE[0]
    for k in range(1, len(_SINE)):
        total = multiply_add(total, square, _SINE[k])
    return x * total


@inlined
def _turned(y: Any, x: Any) -> Any:
    """Angle of a point, in [−π, π]."""
    found = angle_of(abs(y), x)
    return -found if y < _ZERO else found


@inlined
def _normal(rows: Any, i: int) -> tuple[Any, Any, Any]:
    shrink = rows[at.INVERSE + i]
    return rows[at.NX + i] * shrink, rows[at.NY + i] * shrink, rows[at.NZ + i] * shrink


@inlined
def see_polygon(rows: Any, shape: Any) -> bool:
    """Which side is seen, and how much of it is above the horizon; whether no vertex is declined.

    For ways to the middle, with the distance in the row of strengths.
    """
    ax, ay, az = like(rows, shape[_AXIS]), like(rows, shape[_AXIS + 1]), like(rows, shape[_AXIS + 2])
    has_back = shape[_TWO_SIDED] > 0.0
    corners = np.int64(shape[_CORNERS])
    good = True
    for i in range(BLOCK):
        dx, dy, dz, distance = rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i], rows[at.STRENGTH + i]
        behind = dot(ax, ay, az, dx, dy, dz)
        rows[_BEHIND + i] = behind if has_back | (behind < _ZERO) else _ZERO
        fits = (distance > _NEAREST) & (distance < _FARTHEST)
        rows[at.DECLINED + i] = rows[at.DECLINED + i] if fits else _ONE
        good = good & fits
        rows[_LEAST + i], rows[_MOST + i] = _F(np.inf), _F(-np.inf)
    for k in range(corners):
        x, y, z = _offset(rows, shape, k)
        for i in range(BLOCK):
            nx, ny, nz = _normal(rows, i)
            height = dot(nx, ny, nz, rows[at.DX + i] + x, rows[at.DY + i] + y, rows[at.DZ + i] + z)
            rows[_LEAST + i], rows[_MOST + i] = min(rows[_LEAST + i], height), max(rows[_MOST + i], height)
    for i in range(BLOCK):
        rows[_BEHIND + i] = rows[_BEHIND + i] if rows[_MOST + i] > _ZERO else _ZERO
    return good


@inlined
def _offset(rows: Any, shape: Any, k: Any) -> tuple[Any, Any, Any]:
    at_k = _OFFSETS + 3 * k
    return like(rows, shape[at_k]), like(rows, shape[at_k + 1]), like(rows, shape[at_k + 2])


@inlined
def _lambert_of(px: Any, py: Any, pz: Any, ex: Any, ey: Any, ez: Any, nx: Any, ny: Any, nz: Any) -> Any:
    """The angle under which a side e from p is seen, times the cosine between its plane's normal and n."""
    gx, gy, gz = py * ez - pz * ey, pz * ex - px * ez, px * ey - py * ex
    length = np.sqrt(square_of(gx, gy, gz))
    along = dot(px, py, pz, px + ex, py + ey, pz + ez)
    return angle_of(length, along) * (dot(gx, gy, gz, nx, ny, nz) / max(length, _TINY))


@inlined
def polygon_cosine(rows: Any, shape: Any, target: int) -> bool:
    """D²/area · ∫ max(n·u, 0) du into a row, d the distance of the middle; whether no vertex is declined."""
    corners, is_cut, any_small, any_large, good = np.int64(shape[_CORNERS]), False, False, False, True
    size = like(rows, shape[_SIZE])
    for i in range(BLOCK):
        rows[_SUM + i] = _ZERO
        is_lit = rows[_BEHIND + i] != _ZERO
        is_small = size < _SMALL * rows[at.STRENGTH + i]
        is_cut = is_cut | (is_lit & (rows[_LEAST + i] < _ZERO))
        any_small = any_small | (is_lit & is_small & (rows[_LEAST + i] >= _ZERO))
        any_large = any_large | (is_lit & (not is_small))
        is_lost = is_lit & is_small & (rows[_LEAST + i] < _ZERO)
        rows[at.DECLINED + i] = _ONE if is_lost else rows[at.DECLINED + i]
        good = good & (not is_lost)
    if any_large | is_cut:
        for k in range(corners):
            a, b, c = _offset(rows, shape, (k + corners - 1) % corners)
            x, y, z = _offset(rows, shape, k)
            if is_cut:
                _add_cut_side(rows, shape, a, b, c, x - a, y - b, z - c)
            else:
                _add_side(rows, a, b, c, x - a, y - b, z - c)
    if any_small:
        _mean(rows, shape, target, _ONE, _ZERO)
    per_area = like(rows, shape[_PER_AREA])
    for i in range(BLOCK):
        distance = rows[at.STRENGTH + i]
        is_small = (size < _SMALL * distance) & (rows[_LEAST + i] >= _ZERO)
        is_lost = (rows[_BEHIND + i] != _ZERO) & (not is_small) & (_THIN * distance * size * per_area > _ONE)
        rows[at.DECLINED + i] = _ONE if is_lost else rows[at.DECLINED + i]
        good = good & (not is_lost)
        summed = _HALF * abs(rows[_SUM + i]) * per_area * (distance * distance)
        found = rows[target + i] if any_small & is_small else summed
        rows[target + i] = found if rows[_BEHIND + i] != _ZERO else _ZERO
    return good


@inlined
def _add_side(rows: Any, a: Any, b: Any, c: Any, x: Any, y: Any, z: Any) -> None:
    for i in range(BLOCK):
        nx, ny, nz = _normal(rows, i)
        px, py, pz = rows[at.DX + i] + a, rows[at.DY + i] + b, rows[at.DZ + i] + c
        rows[_SUM + i] += _lambert_of(px, py, pz, x, y, z, nx, ny, nz)


@inlined
def _add_cut_side(rows: Any, shape: Any, a: Any, b: Any, c: Any, x: Any, y: Any, z: Any) -> None:
    """What of a side is above the horizon; where it crosses that, its share of the way back along it.

    That is the angle around n from the way to the polygon's plane, along the horizon: the light is within 90° of it.
    """
    ax, ay, az = like(rows, shape[_AXIS]), like(rows, shape[_AXIS + 1]), like(rows, shape[_AXIS + 2])
    for i in range(BLOCK):
        sign = _ONE if rows[_BEHIND + i] > _ZERO else -_ONE
        nx, ny, nz = _normal(rows, i)
        dx, dy, dz = rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]
        px, py, pz = dx + a, dy + b, dz + c
        here, rise = dot(nx, ny, nz, px, py, pz), dot(nx, ny, nz, x, y, z)
        there = dot(nx, ny, nz, px + x, py + y, pz + z)
        cross = min(max(-here / (rise if abs(rise) > _TINY else _TINY), _ZERO), _ONE)
        first = _ZERO if here > _ZERO else (cross if there > _ZERO else _ONE)
        last = _ONE if there > _ZERO else (cross if here > _ZERO else _ONE)
        sx, sy, sz = multiply_add(first, x, px), multiply_add(first, y, py), multiply_add(first, z, pz)
        part = max(last - first, _ZERO)
        seen = _lambert_of(sx, sy, sz, part * x, part * y, part * z, nx, ny, nz)
        # the crossing, across n: towards the middle, and sideways
        qx, qy, qz = multiply_add(cross, x, px), multiply_add(cross, y, py), multiply_add(cross, z, pz)
        up = dot(nx, ny, nz, ax, ay, az)
        tx, ty, tz = sign * (ax - up * nx), sign * (ay - up * ny), sign * (az - up * nz)
        ahead = dot(tx, ty, tz, qx, qy, qz)
        aside = dot(ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx, qx, qy, qz)
        around = _turned(aside, ahead)
        around = around if there > _ZERO else -around
        rows[_SUM + i] += seen + (around if (here > _ZERO) != (there > _ZERO) else _ZERO)


@inlined
def _mean(rows: Any, shape: Any, target: int, exponent: Any, mirror: Any) -> None:
    """D²/area · ∫ max(a·u, 0)ᵏ du at nodes, for the normal or, where `mirror` is 1, the mirrored viewer."""
    corners, count = np.int64(shape[_CORNERS]), np.int64(shape[_COUNT])
    least = like(rows, -np.inf)
    ax, ay, az = like(rows, shape[_AXIS]), like(rows, shape[_AXIS + 1]), like(rows, shape[_AXIS + 2])
    for i in range(BLOCK):
        rows[target + i] = _ZERO
    for k in range(count):
        x, y, z = _offset(rows, shape, corners + k)
        weight = like(rows, shape[_OFFSETS + 3 * (corners + count) + k])
        for i in range(BLOCK):
            px, py, pz = rows[at.DX + i] + x, rows[at.DY + i] + y, rows[at.DZ + i] + z
            inverse = _ONE / np.sqrt(max(square_of(px, py, pz), _TINY))
            px, py, pz = px * inverse, py * inverse, pz * inverse
            nx, ny, nz = _normal(rows, i)
            wx, wy, wz = rows[_WX + i], rows[_WY + i], rows[_WZ + i]
            less = _HALF * square_of(px - wx, py - wy, pz - wz)
            raised = exp2(log2_power(_TWO * less, exponent, least)) if less < _ONE else _ZERO
            value = raised if mirror > _ZERO else max(dot(nx, ny, nz, px, py, pz), _ZERO)
            near = rows[at.STRENGTH + i] * inverse
            glow = abs(dot(ax, ay, az, px, py, pz)) * near * near * weight
            rows[target + i] = multiply_add(glow, value, rows[target + i])


@inlined
def polygon_power(rows: Any, shape: Any, target: int, exponent: float, shown: float, small: float) -> bool:
    """D²/area · ∫ max(w·u, 0)ⁿ du above the horizon into a row; whether no vertex is declined.

    `shown` is the 1 − z from which zⁿ⁺¹ is nothing, `small` the size over distance below which nodes do.
    """
    nothing, tiny = like(rows, shown), like(rows, small)
    size, per_area = like(rows, shape[_SIZE]), like(rows, shape[_PER_AREA])
    good, any_small, any_large = True, False, False
    for i in range(BLOCK):
        nx, ny, nz = _normal(rows, i)
        vx, vy, vz = rows[at.VX + i], rows[at.VY + i], rows[at.VZ + i]
        twice = _TWO * dot(nx, ny, nz, vx, vy, vz)
        wx, wy, wz = twice * nx - vx, twice * ny - vy, twice * nz - vz
        unit = _ONE / np.sqrt(max(square_of(wx, wy, wz), _TINY))
        wx, wy, wz = wx * unit, wy * unit, wz * unit
        rows[_WX + i], rows[_WY + i], rows[_WZ + i] = wx, wy, wz
        inverse, distance = rows[at.NEARNESS + i], rows[at.STRENGTH + i]
        lx, ly, lz = rows[at.DX + i] * inverse, rows[at.DY + i] * inverse, rows[at.DZ + i] * inverse
        less = min(_HALF * square_of(lx - wx, ly - wy, lz - wz), _TWO)
        s = min(size / distance, _ONE)
        cosine = np.sqrt(max(_ONE - s * s, _ZERO))
        off = np.sqrt(less * (_TWO - less)) * cosine - (_ONE - less) * s
        near = (_ONE - less) * cosine + np.sqrt(less * (_TWO - less)) * s
        nearest = off * off / (_ONE + near) if near > _ZERO else _ONE - near
        is_seen = (rows[_BEHIND + i] != _ZERO) & (rows[at.INVERSE + i] > _ZERO)
        reaches = is_seen & ((nearest < nothing) | (off < _ZERO) | (s >= _ONE))
        is_small = size < tiny * distance
        is_cut = reaches & (
            (rows[_LEAST + i] <= _ZERO) | ((not is_small) & (_THIN * distance * size * per_area > _ONE))
        )
        rows[at.DECLINED + i] = _ONE if is_cut else rows[at.DECLINED + i]
        good = good & (not is_cut)
        any_small, any_large = any_small | (reaches & is_small), any_large | (reaches & (not is_small))
        rows[_REACH + i] = (_ONE if is_small else _TWO) if reaches else _ZERO
        rows[_SUM + i] = _ZERO
    if any_small:
        _mean(rows, shape, target, like(rows, exponent), _ONE)
    if any_large:
        corners, power = np.int64(shape[_CORNERS]), like(rows, exponent) + _ONE
        for k in range(corners):
            a, b, c = _offset(rows, shape, (k + corners - 1) % corners)
            x, y, z = _offset(rows, shape, k)
            _add_arc(rows, a, b, c, x - a, y - b, z - c, power, nothing)
        for i in range(BLOCK):
            distance = rows[at.STRENGTH + i]
            turned = rows[_SUM + i] if rows[_BEHIND + i] > _ZERO else -rows[_SUM + i]
            turned = turned + _TWO_PI if turned < -_ONE else turned
            large = max(turned, _ZERO) / power * per_area * (distance * distance)
            rows[target + i] = large if rows[_REACH + i] == _TWO else rows[target + i]
    for i in range(BLOCK):
        rows[target + i] = rows[target + i] if rows[_REACH + i] > _ZERO else _ZERO
    return good


@inlined
def _turn(rise: Any, first: Any, last: Any) -> Any:
    """∫ dφ along an arc between two angles in [−π/2, π/2], for |w·m| = `rise`."""
    sf, sl = small_sine(_HALF * first), small_sine(_HALF * last)
    cf, cl = np.sqrt(max(_ONE - sf * sf, _ZERO)), np.sqrt(max(_ONE - sl * sl, _ZERO))
    sine_first, sine_last = _TWO * sf * cf, _TWO * sl * cl
    cosine_first, cosine_last = _ONE - _TWO * sf * sf, _ONE - _TWO * sl * sl
    over = rise * (sine_last * cosine_first - cosine_last * sine_first)
    return angle_of(max(over, _ZERO), rise * rise * cosine_first * cosine_last + sine_first * sine_last)


@inlined
def _add_arc(rows: Any, a: Any, b: Any, c: Any, x: Any, y: Any, z: Any, power: Any, nothing: Any) -> None:
    """∫ (1 − max(z, 0)ᵖ) dφ along a side, counter-clockwise around the normal of its plane."""
    least = like(rows, -np.inf)
    for i in range(BLOCK):
        px, py, pz = rows[at.DX + i] + a, rows[at.DY + i] + b, rows[at.DZ + i] + c
        wx, wy, wz = rows[_WX + i], rows[_WY + i], rows[_WZ + i]
        gx, gy, gz = py * z - pz * y, pz * x - px * z, px * y - py * x
        length = max(np.sqrt(square_of(gx, gy, gz)), _TINY)
        qx, qy, qz = px + x, py + y, pz + z
        seen = angle_of(length, dot(px, py, pz, qx, qy, qz))
        mx, my, mz = gx / length, gy / length, gz / length
        along = dot(wx, wy, wz, mx, my, mz)
        cx, cy, cz = my * wz - mz * wy, mz * wx - mx * wz, mx * wy - my * wx
        across = np.sqrt(square_of(cx, cy, cz))
        pole = along * along / (_ONE + across)
        start = _turned(dot(px, py, pz, cx, cy, cz), dot(px, py, pz, wx, wy, wz))
        stop = start + seen
        turns = (_TWO_PI if start + stop < -_TWO_PI else _ZERO) - (_TWO_PI if start + stop > _TWO_PI else _ZERO)
        height = min(max((nothing - pole) / max(_TWO * across, _TINY), _ZERO), _HALF)
        window = _TWO * angle_of(np.sqrt(height), np.sqrt(_ONE - height))
        start, stop = start + turns, stop + turns
        first, last = min(max(start, -window), window), min(max(stop, -window), window)
        is_all = (first == start) & (last == stop)
        ahead = dot(wx, wy, wz, px, py, pz) * dot(wx, wy, wz, qx, qy, qz)
        whole = angle_of(abs(along) * length, dot(px, py, pz, qx, qy, qz) - ahead)
        rest = _ZERO if is_all else whole - _turn(abs(along), first, last)
        rows[_SUM + i] += -rest if along < _ZERO else rest
        rows[at.SINE + i], rows[at.COSINE + i], rows[at.TILT + i] = pole, across, along
        rows[_LEAST + i], rows[_MOST + i] = _HALF * (first + last), _HALF * (seen if is_all else last - first)
    for k in range(len(_PLACES)):
        for i in range(BLOCK):
            half = rows[_MOST + i]
            sine = small_sine(_HALF * multiply_add(half, _PLACES[k], rows[_LEAST + i]))
            less = max(multiply_add(_TWO * rows[at.COSINE + i] * sine, sine, rows[at.SINE + i]), _TINY)
            shown = -exp2_less_one32(log2_power(_TWO * less, power, least)) if less < _ONE else _ONE
            part = rows[at.TILT + i] * half * _SHARES[k]
            rows[_SUM + i] = multiply_add(part, shown / (less * (_TWO - less)), rows[_SUM + i])
