"""The kernel's loops over polygons that are seen; formulas as in `optics.polygons` and `optics.spherical.great_arc`.

In float32. `shape` holds the polygon in float64: its axis (3), whether its back glows, 1/area, its size, how many
corners and how many nodes there are; then corners' offsets from the middle, nodes' offsets, and nodes' weights, 1 in
sum. Sides are cut off at the horizon. Small polygons are summed at nodes. Vertices are declined that see a thin one, or
one that the horizon cuts more than once.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel import arcs
from pvphong.shading.kernel import vertices as at
from pvphong.shading.kernel.angles32 import angle_above, angle_of
from pvphong.shading.kernel.arithmetic import exp2, inlined, like, log2_power, multiply_add
from pvphong.shading.kernel.caps import reaches
from pvphong.shading.kernel.vertices import BLOCK, NO_LENGTH, dot, mirrored_viewer, square_of, unit_normal

_F = np.float32
_ZERO, _HALF, _ONE, _TWO = _F(0.0), _F(0.5), _F(1.0), _F(2.0)
_TINY = _F(2.0**-126)

# Distances between which ways are as they come, and squares of squares have room.
_NEAREST, _FARTHEST = _F(2.0**-28), _F(2.0**28)

# Size over distance below which Lambert's cosine is taken at nodes.
_SMALL = _F(0.15)

# Area over size and distance below which the sum along sides loses too much.
_THIN = _F(0.2)

# Where a stage's own rows begin: h of the plane, w (3), how an integral is to be taken, the sum, heights of corners.
_BEHIND, _WX, _WY, _WZ, _WANTED, _SUM, _LEAST, _MOST = (at.OWN + k * BLOCK for k in range(8))
# Where corners' order leaves what is above the horizon and comes back, how often that is, and corners of a triangle.
_EXIT, _ENTRANCE, _CROSSINGS, _TRIANGLE = (at.RIM + k * BLOCK for k in (0, 3, 6, 7))

_SMALL_WHOLE, _SMALL_CUT, _LARGE = _F(1.0), _F(2.0), _F(3.0)

# Seven points that have a triangle's moments up to the fifth degree (Radon 1948): what they have of its second and
# third corner, and their weights.
_RADON = (
    (_F(1.0 / 3.0), _F(1.0 / 3.0), _F(9.0 / 40.0)),
    *(
        (_F(x), _F(y), _F((155.0 + sign * math.sqrt(15.0)) / 1200.0))
        for sign in (-1.0, 1.0)
        for place in [(6.0 + sign * math.sqrt(15.0)) / 21.0]
        for x, y in ((place, place), (place, 1.0 - 2.0 * place), (1.0 - 2.0 * place, place))
    ),
)

# In `shape`.
_AXIS, _TWO_SIDED, _PER_AREA, _SIZE, _CORNERS, _COUNT, _OFFSETS = 0, 3, 4, 5, 6, 7, 8


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
            nx, ny, nz = unit_normal(rows, i)
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
    return angle_above(length, along) * (dot(gx, gy, gz, nx, ny, nz) / max(length, _TINY))


@inlined
def polygon_cosine(rows: Any, shape: Any, target: int) -> bool:
    """D²/area · ∫ max(n·u, 0) du into a row, d the distance of the middle; whether no vertex is declined."""
    any_cut, any_small, any_cut_small, any_large, good = False, False, False, False, True
    size, per_area = like(rows, shape[_SIZE]), like(rows, shape[_PER_AREA])
    for i in range(BLOCK):
        is_cut, is_small = rows[_LEAST + i] < _ZERO, size < _SMALL * rows[at.STRENGTH + i]
        is_lit = (rows[_BEHIND + i] != _ZERO) & (rows[at.INVERSE + i] < NO_LENGTH)
        is_thin = _THIN * rows[at.STRENGTH + i] * size * per_area > _ONE
        is_lost = is_lit & is_thin & (not is_small)
        rows[at.DECLINED + i] = _ONE if is_lost else rows[at.DECLINED + i]
        good, any_cut, any_large = (
            good & (not is_lost),
            any_cut | (is_lit & is_cut),
            any_large | (is_lit & (not is_small)),
        )
        any_small = any_small | (is_lit & is_small & (not is_cut))
        any_cut_small = any_cut_small | (is_lit & is_small & is_cut)
        rows[_WANTED + i] = ((_SMALL_CUT if is_cut else _SMALL_WHOLE) if is_small else _LARGE) if is_lit else _ZERO
        rows[_SUM + i] = _ZERO
    if any_large:
        corners = np.int64(shape[_CORNERS])
        for k in range(corners):
            if any_cut:
                _add_cut_side(rows, shape, _offset(rows, shape, (k + corners - 1) % corners), _offset(rows, shape, k))
            else:
                _add_side(rows, _offset(rows, shape, (k + corners - 1) % corners), _offset(rows, shape, k))
    for i in range(BLOCK):
        distance = rows[at.STRENGTH + i]
        summed = _HALF * abs(rows[_SUM + i]) * per_area * (distance * distance)
        rows[target + i] = summed if rows[_WANTED + i] == _LARGE else _ZERO
    if any_small:
        _mean(rows, shape, target, _ONE, False)
    if any_cut_small:
        good = _mean_of_cut(rows, shape, target, _ONE, False) & good
    return good


@inlined
def _add_side(rows: Any, a: Any, b: Any) -> None:
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    for i in range(BLOCK):
        nx, ny, nz = unit_normal(rows, i)
        px, py, pz = rows[at.DX + i] + a[0], rows[at.DY + i] + a[1], rows[at.DZ + i] + a[2]
        rows[_SUM + i] += _lambert_of(px, py, pz, x, y, z, nx, ny, nz)


@inlined
def _cut(rows: Any, i: int, a: Any, b: Any) -> tuple[Any, Any, Any, Any, Any]:
    """Heights over the horizon of a side's two ends, where it crosses that, and from where to where it is above.

    Neighbours take a corner's height to the same bits.
    """
    nx, ny, nz = unit_normal(rows, i)
    dx, dy, dz = rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]
    here = dot(nx, ny, nz, dx + a[0], dy + a[1], dz + a[2])
    there = dot(nx, ny, nz, dx + b[0], dy + b[1], dz + b[2])
    rise = dot(nx, ny, nz, b[0] - a[0], b[1] - a[1], b[2] - a[2])
    cross = min(max(-here / (rise if abs(rise) > _TINY else _TINY), _ZERO), _ONE)
    first = _ZERO if here > _ZERO else (cross if there > _ZERO else _ONE)
    last = _ONE if there > _ZERO else (cross if here > _ZERO else _ZERO)
    return here, there, cross, first, max(first, last)


@inlined
def _add_cut_side(rows: Any, shape: Any, a: Any, b: Any) -> None:
    """What of a side is above the horizon; where it crosses that, its share of the way back along it.

    That is the angle around n from the way to the polygon's plane, along the horizon: the light is within 90° of it.
    """
    ax, ay, az = like(rows, shape[_AXIS]), like(rows, shape[_AXIS + 1]), like(rows, shape[_AXIS + 2])
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    for i in range(BLOCK):
        sign = _ONE if rows[_BEHIND + i] > _ZERO else -_ONE
        nx, ny, nz = unit_normal(rows, i)
        px, py, pz = rows[at.DX + i] + a[0], rows[at.DY + i] + a[1], rows[at.DZ + i] + a[2]
        here, there, cross, first, last = _cut(rows, i, a, b)
        sx, sy, sz = multiply_add(first, x, px), multiply_add(first, y, py), multiply_add(first, z, pz)
        part = last - first
        seen = _lambert_of(sx, sy, sz, part * x, part * y, part * z, nx, ny, nz)
        # the crossing, across n: towards the middle, and sideways
        qx, qy, qz = multiply_add(cross, x, px), multiply_add(cross, y, py), multiply_add(cross, z, pz)
        up = dot(nx, ny, nz, ax, ay, az)
        tx, ty, tz = sign * (ax - up * nx), sign * (ay - up * ny), sign * (az - up * nz)
        ahead = dot(tx, ty, tz, qx, qy, qz)
        aside = dot(ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx, qx, qy, qz)
        around = angle_of(aside, ahead)
        around = around if there > _ZERO else -around
        rows[_SUM + i] += seen + (around if (here > _ZERO) != (there > _ZERO) else _ZERO)


@inlined
def _glow(rows: Any, i: int, axis: Any, p: Any, exponent: Any, is_mirrored: bool) -> Any:
    """D² |axis·p| / |p|³ · (a·u)ᵏ at a place p, a the normal with k = 1 or, for highlights, w."""
    px, py, pz = p
    inverse = _ONE / np.sqrt(max(square_of(px, py, pz), _TINY))
    px, py, pz = px * inverse, py * inverse, pz * inverse
    if is_mirrored:
        less = _HALF * square_of(px - rows[_WX + i], py - rows[_WY + i], pz - rows[_WZ + i])
        raised = exp2(log2_power(_TWO * less, exponent, like(rows, -np.inf)))
        value = raised if less < _ONE else _ZERO
    else:
        value = dot(*unit_normal(rows, i), px, py, pz)
    near = rows[at.STRENGTH + i] * inverse
    return abs(dot(axis[0], axis[1], axis[2], px, py, pz)) * near * near * value


@inlined
def _axis(rows: Any, shape: Any) -> tuple[Any, Any, Any]:
    return like(rows, shape[_AXIS]), like(rows, shape[_AXIS + 1]), like(rows, shape[_AXIS + 2])


@inlined
def _mean(rows: Any, shape: Any, target: int, exponent: Any, is_mirrored: bool) -> None:
    """D²/area · ∫ (a·u)ᵏ du by nodes on whole small polygons."""
    corners, count = np.int64(shape[_CORNERS]), np.int64(shape[_COUNT])
    axis = _axis(rows, shape)
    for i in range(BLOCK):
        rows[_SUM + i] = _ZERO
    for k in range(count):
        x, y, z = _offset(rows, shape, corners + k)
        weight = like(rows, shape[_OFFSETS + 3 * (corners + count) + k])
        for i in range(BLOCK):
            p = rows[at.DX + i] + x, rows[at.DY + i] + y, rows[at.DZ + i] + z
            rows[_SUM + i] = multiply_add(weight, _glow(rows, i, axis, p, exponent, is_mirrored), rows[_SUM + i])
    for i in range(BLOCK):
        rows[target + i] = max(rows[_SUM + i], _ZERO) if rows[_WANTED + i] == _SMALL_WHOLE else rows[target + i]


@inlined
def _mean_of_cut(rows: Any, shape: Any, target: int, exponent: Any, is_mirrored: bool) -> bool:
    """The same of the part above the horizon of small polygons; whether no vertex is declined.

    The part is triangles from the middle to the sides, and to the line along the horizon, with signs: what of them is
    below the horizon cancels.
    """
    corners, axis, good = np.int64(shape[_CORNERS]), _axis(rows, shape), True
    for i in range(BLOCK):
        rows[_SUM + i], rows[_CROSSINGS + i] = _ZERO, _ZERO
    for k in range(corners):
        a, b = _offset(rows, shape, (k + corners - 1) % corners), _offset(rows, shape, k)
        for i in range(BLOCK):
            _, _, _, first, last = _note_crossing(rows, i, a, b)
            _put_if(rows, i, _TRIANGLE, True, *_between(a, b, first))
            _put_if(rows, i, _TRIANGLE + 3 * BLOCK, True, *_between(a, b, last))
        _add_triangle(rows, _TRIANGLE, _TRIANGLE + 3 * BLOCK, axis, exponent, is_mirrored)
    _add_triangle(rows, _EXIT, _ENTRANCE, axis, exponent, is_mirrored)
    per_area = like(rows, shape[_PER_AREA])
    for i in range(BLOCK):
        is_wanted = rows[_WANTED + i] == _SMALL_CUT
        is_lost = is_wanted & (rows[_CROSSINGS + i] > _ONE)
        rows[at.DECLINED + i] = _ONE if is_lost else rows[at.DECLINED + i]
        good = good & (not is_lost)
        rows[target + i] = max(_HALF * rows[_SUM + i] * per_area, _ZERO) if is_wanted else rows[target + i]
    return good


@inlined
def _between(a: Any, b: Any, share: Any) -> tuple[Any, Any, Any]:
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    return multiply_add(share, x, a[0]), multiply_add(share, y, a[1]), multiply_add(share, z, a[2])


@inlined
def _put_if(rows: Any, i: int, place: int, is_wanted: bool, x: Any, y: Any, z: Any) -> None:
    rows[place + i] = x if is_wanted else rows[place + i]
    rows[place + BLOCK + i] = y if is_wanted else rows[place + BLOCK + i]
    rows[place + 2 * BLOCK + i] = z if is_wanted else rows[place + 2 * BLOCK + i]


@inlined
def _note_crossing(rows: Any, i: int, a: Any, b: Any) -> tuple[Any, Any, Any, Any, Any]:
    """As `_cut`; notes where a side leaves what is above the horizon, or comes back, as offsets from the middle."""
    here, there, cross, first, last = _cut(rows, i, a, b)
    leaves, comes = (here > _ZERO) & (not there > _ZERO), (there > _ZERO) & (not here > _ZERO)
    x, y, z = _between(a, b, cross)
    _put_if(rows, i, _EXIT, leaves, x, y, z)
    _put_if(rows, i, _ENTRANCE, comes, x, y, z)
    rows[_CROSSINGS + i] += _ONE if leaves else _ZERO
    return here, there, cross, first, last


@inlined
def _add_triangle(rows: Any, p: int, q: int, axis: Any, exponent: Any, is_mirrored: bool) -> None:
    """Twice a triangle's area, with its sign, times a mean over it: from the middle to two offsets from there."""
    ax, ay, az = axis
    for k in range(len(_RADON)):
        second, third, weight = _RADON[k]
        for i in range(BLOCK):
            ux, uy, uz = rows[p + i], rows[p + BLOCK + i], rows[p + 2 * BLOCK + i]
            vx, vy, vz = rows[q + i], rows[q + BLOCK + i], rows[q + 2 * BLOCK + i]
            area = dot(ax, ay, az, uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx)
            x = multiply_add(second, ux, multiply_add(third, vx, rows[at.DX + i]))
            y = multiply_add(second, uy, multiply_add(third, vy, rows[at.DY + i]))
            z = multiply_add(second, uz, multiply_add(third, vz, rows[at.DZ + i]))
            value = _glow(rows, i, axis, (x, y, z), exponent, is_mirrored)
            rows[_SUM + i] = multiply_add(weight * area, value, rows[_SUM + i])


@inlined
def polygon_power(rows: Any, shape: Any, target: int, exponent: float, shown: float, small: float) -> bool:
    """D²/area · ∫ max(w·u, 0)ⁿ du above the horizon into a row; whether no vertex is declined.

    `shown` is the 1 − z from which zⁿ⁺¹ is nothing, `small` the size over distance below which nodes do.
    """
    nothing, tiny = like(rows, shown), like(rows, small)
    size, per_area = like(rows, shape[_SIZE]), like(rows, shape[_PER_AREA])
    good, any_small, any_cut_small, any_large, any_cut = True, False, False, False, False
    for i in range(BLOCK):
        wx, wy, wz = mirrored_viewer(rows, i)
        rows[_WX + i], rows[_WY + i], rows[_WZ + i] = wx, wy, wz
        inverse, distance = rows[at.NEARNESS + i], rows[at.STRENGTH + i]
        lx, ly, lz = rows[at.DX + i] * inverse, rows[at.DY + i] * inverse, rows[at.DZ + i] * inverse
        less = min(_HALF * square_of(lx - wx, ly - wy, lz - wz), _TWO)
        s = min(size / distance, _ONE)
        is_seen = (rows[_BEHIND + i] != _ZERO) & (rows[at.INVERSE + i] < NO_LENGTH)
        is_reached = is_seen & ((s >= _ONE) | reaches(less, s, nothing))
        is_small, is_cut = size < tiny * distance, rows[_LEAST + i] <= _ZERO
        is_lost = is_reached & (not is_small) & (_HALF * tiny * distance * size * per_area > _ONE)
        rows[at.DECLINED + i] = _ONE if is_lost else rows[at.DECLINED + i]
        good = good & (not is_lost)
        any_small = any_small | (is_reached & is_small & (not is_cut))
        any_cut_small = any_cut_small | (is_reached & is_small & is_cut)
        any_large, any_cut = any_large | (is_reached & (not is_small)), any_cut | (is_reached & (not is_small) & is_cut)
        rows[_WANTED + i] = ((_SMALL_CUT if is_cut else _SMALL_WHOLE) if is_small else _LARGE) if is_reached else _ZERO
        rows[target + i] = _ZERO
    if any_large:
        good = _along_sides(rows, shape, target, like(rows, exponent) + _ONE, nothing, any_cut) & good
    if any_small:
        _mean(rows, shape, target, like(rows, exponent), True)
    if any_cut_small:
        good = _mean_of_cut(rows, shape, target, like(rows, exponent), True) & good
    return good


@inlined
def _along_sides(rows: Any, shape: Any, target: int, power: Any, nothing: Any, any_cut: bool) -> bool:
    """The same by the integral along the sides and the horizon, of large polygons; whether no vertex is declined."""
    corners, per_area, good = np.int64(shape[_CORNERS]), like(rows, shape[_PER_AREA]), True
    for i in range(BLOCK):
        rows[arcs.TURNED + i], rows[_CROSSINGS + i] = _ZERO, _ZERO
    for k in range(corners):
        a, b = _offset(rows, shape, (k + corners - 1) % corners), _offset(rows, shape, k)
        if any_cut:
            _begin_cut_side(rows, a, b, nothing)
        else:
            _begin_side(rows, a, b, nothing)
        arcs.end_arc(rows, power)
    for i in range(BLOCK):
        rows[_SUM + i] = rows[arcs.TURNED + i] if rows[_BEHIND + i] > _ZERO else -rows[arcs.TURNED + i]
        rows[arcs.TURNED + i] = _ZERO
    if any_cut:
        _begin_horizon(rows, nothing)
        arcs.end_arc(rows, power)
    for i in range(BLOCK):
        is_wanted = rows[_WANTED + i] == _LARGE
        is_lost = is_wanted & (rows[_CROSSINGS + i] > _ONE)
        rows[at.DECLINED + i] = _ONE if is_lost else rows[at.DECLINED + i]
        good = good & (not is_lost)
        distance = rows[at.STRENGTH + i]
        large = arcs.whole_of(rows[_SUM + i] + rows[arcs.TURNED + i]) / power * per_area * (distance * distance)
        rows[target + i] = large if is_wanted else rows[target + i]
    return good


@inlined
def _begin_side(rows: Any, a: Any, b: Any, nothing: Any) -> None:
    """A side's arc, counter-clockwise around the normal of its plane."""
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    for i in range(BLOCK):
        px, py, pz = rows[at.DX + i] + a[0], rows[at.DY + i] + a[1], rows[at.DZ + i] + a[2]
        _begin_part(rows, i, (px, py, pz), (px, py, pz), (px + x, py + y, pz + z), (x, y, z), _ONE, nothing)


@inlined
def _begin_cut_side(rows: Any, a: Any, b: Any, nothing: Any) -> None:
    """What of it is above the horizon."""
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    for i in range(BLOCK):
        _, _, _, first, last = _note_crossing(rows, i, a, b)
        px, py, pz = rows[at.DX + i] + a[0], rows[at.DY + i] + a[1], rows[at.DZ + i] + a[2]
        start = multiply_add(first, x, px), multiply_add(first, y, py), multiply_add(first, z, pz)
        stop = multiply_add(last, x, px), multiply_add(last, y, py), multiply_add(last, z, pz)
        _begin_part(rows, i, (px, py, pz), start, stop, (x, y, z), last - first, nothing)


@inlined
def _begin_part(rows: Any, i: int, corner: Any, start: Any, stop: Any, side: Any, part: Any, nothing: Any) -> None:
    """The arc from `start` to `stop`, which is a part of a side off a corner."""
    px, py, pz = corner
    x, y, z = side
    wx, wy, wz = rows[_WX + i], rows[_WY + i], rows[_WZ + i]
    gx, gy, gz = py * z - pz * y, pz * x - px * z, px * y - py * x
    length = max(np.sqrt(square_of(gx, gy, gz)), _TINY)
    mx, my, mz = gx / length, gy / length, gz / length
    cx, cy, cz = my * wz - mz * wy, mz * wx - mx * wz, mx * wy - my * wx
    arcs.begin_arc(
        rows,
        i,
        length * part,
        dot(start[0], start[1], start[2], stop[0], stop[1], stop[2]),
        dot(wx, wy, wz, start[0], start[1], start[2]),
        dot(wx, wy, wz, stop[0], stop[1], stop[2]),
        dot(start[0], start[1], start[2], cx, cy, cz),
        dot(wx, wy, wz, mx, my, mz),
        np.sqrt(square_of(cx, cy, cz)),
        nothing,
    )


@inlined
def _begin_horizon(rows: Any, nothing: Any) -> None:
    """The way back along the horizon of polygons that it cuts, from where one leaves it to where one comes back."""
    for i in range(BLOCK):
        nx, ny, nz = unit_normal(rows, i)
        is_ahead = rows[_BEHIND + i] > _ZERO  # else corners go round clockwise
        start, stop = _at_horizon(rows, i, _EXIT), _at_horizon(rows, i, _ENTRANCE)
        px, py, pz = (start[0], start[1], start[2]) if is_ahead else (stop[0], stop[1], stop[2])
        qx, qy, qz = (stop[0], stop[1], stop[2]) if is_ahead else (start[0], start[1], start[2])
        length = max(np.sqrt(square_of(px, py, pz)), _TINY)
        gx, gy, gz = px / length, py / length, pz / length
        side = dot(ny * gz - nz * gy, nz * gx - nx * gz, nx * gy - ny * gx, qx, qy, qz)
        w = rows[_WX + i], rows[_WY + i], rows[_WZ + i]
        ahead = dot(gx, gy, gz, qx, qy, qz)
        arcs.begin_along_horizon(rows, i, (nx, ny, nz), (gx, gy, gz), w, (length, _ZERO), (ahead, side), nothing)
        arcs.keep_if(rows, i, rows[_CROSSINGS + i] > _ZERO)


@inlined
def _at_horizon(rows: Any, i: int, place: int) -> tuple[Any, Any, Any]:
    x, y, z = rows[place + i], rows[place + BLOCK + i], rows[place + 2 * BLOCK + i]
    return rows[at.DX + i] + x, rows[at.DY + i] + y, rows[at.DZ + i] + z
