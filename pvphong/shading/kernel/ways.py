"""The kernel's loops over ways D from vertices to a position, and over the directions to the viewer made of them.

They take points far and near: where squares of D could leave the range of floats, D is scaled by a power of two,
each by its own. That is exact, so a vertex has the same bits in any unit of length. `points` are float64 where they
stand beside rows of float32, else nowhere, and then in the rows themselves.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import inlined, multiply_add, plain
from pvphong.shading.kernel.loading import exponent_of, is_finite
from pvphong.shading.kernel.pointers import is_nowhere, like
from pvphong.shading.kernel.rows import BLOCK
from pvphong.shading.kernel.vectors import ZERO_SQUARE, dot, inverse_root, is_moderate, square_of

_ZERO, _ONE, _TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)

# Distances between which float32 holds what light weakens by; and the most that it is strengthened.
_NEAREST, _FARTHEST, _STRONGEST = np.float32(2.0**-110), np.float32(2.0**120), np.float32(2.0**126)


@inlined
def normal_dot(rows: Any, i: int, x: Any, y: Any, z: Any) -> Any:
    """N·(x, y, z)."""
    return dot(rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i], x, y, z)


@inlined
def unit_normal(rows: Any, i: int) -> tuple[Any, Any, Any]:
    """N as a unit vector; 0 where there is none."""
    shrink = rows[at.INVERSE + i]
    return rows[at.NX + i] * shrink, rows[at.NY + i] * shrink, rows[at.NZ + i] * shrink


@inlined
def mirrored_viewer(rows: Any, i: int) -> tuple[Any, Any, Any]:
    """The direction to the viewer mirrored at n, as a unit vector."""
    nx, ny, nz = unit_normal(rows, i)
    vx, vy, vz = rows[at.VX + i], rows[at.VY + i], rows[at.VZ + i]
    twice = _TWO * dot(nx, ny, nz, vx, vy, vz)
    x, y, z = twice * nx - vx, twice * ny - vy, twice * nz - vz
    unit = inverse_root(square_of(x, y, z))
    return x * unit, y * unit, z * unit


@inlined
def _wide_way(rows: Any, points: Any, i: int, x: float, y: float, z: float) -> tuple[Any, Any, Any]:
    return like(rows, x - points[i]), like(rows, y - points[BLOCK + i]), like(rows, z - points[2 * BLOCK + i])


@inlined
def _in_two(rows: Any, x: float) -> tuple[Any, Any]:
    """A coordinate as a sum of two numbers of the rows' type."""
    high = like(rows, x)
    return high, like(rows, x - np.float64(high))


@inlined
def _way(rows: Any, i: int, x: Any, y: Any, z: Any) -> tuple[Any, Any, Any]:
    """Right to the last bit that matters: the first difference is exact wherever the second number counts."""
    return (x[0] - rows[at.PX + i]) + x[1], (y[0] - rows[at.PY + i]) + y[1], (z[0] - rows[at.PZ + i]) + z[1]


@inlined
def _keep(rows: Any, i: int, dx: Any, dy: Any, dz: Any) -> bool:
    square = square_of(dx, dy, dz)
    rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i] = dx, dy, dz
    rows[at.NEARNESS + i] = inverse_root(square)
    return is_moderate(square)


@inlined
def _keep_measured(rows: Any, i: int, dx: Any, dy: Any, dz: Any) -> bool:
    square = square_of(dx, dy, dz)
    distance = np.sqrt(max(square, ZERO_SQUARE))
    rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i] = dx, dy, dz
    rows[at.NEARNESS + i] = _ONE / distance
    rows[at.STRENGTH + i] = distance
    return is_moderate(square)


@plain
def _approach(rows: Any, points: Any, x: float, y: float, z: float) -> bool:
    good = True
    if is_nowhere(points):
        two_x, two_y, two_z = _in_two(rows, x), _in_two(rows, y), _in_two(rows, z)
        for i in range(BLOCK):
            good = good & _keep(rows, i, *_way(rows, i, two_x, two_y, two_z))
    else:
        for i in range(BLOCK):
            good = good & _keep(rows, i, *_wide_way(rows, points, i, x, y, z))
    return good


@plain
def _approach_measured(rows: Any, points: Any, x: float, y: float, z: float) -> bool:
    good = True
    if is_nowhere(points):
        two_x, two_y, two_z = _in_two(rows, x), _in_two(rows, y), _in_two(rows, z)
        for i in range(BLOCK):
            good = good & _keep_measured(rows, i, *_way(rows, i, two_x, two_y, two_z))
    else:
        for i in range(BLOCK):
            good = good & _keep_measured(rows, i, *_wide_way(rows, points, i, x, y, z))
    return good


@inlined
def _scaled_difference(rows: Any, target: float, coordinate: float, exponent: int, is_wide: bool) -> Any:
    """Target − coordinate over 2^exponent, rounded where `_way` or `_wide_way` rounds it."""
    if not is_wide:
        high, low = _in_two(rows, target)
        scaled_high = like(rows, math.ldexp(np.float64(high), -exponent))
        scaled_low = like(rows, math.ldexp(np.float64(low), -exponent))
        scaled = (scaled_high - like(rows, math.ldexp(coordinate, -exponent))) + scaled_low
        if math.isfinite(scaled):
            return scaled
        # so near each other that coordinates scaled like their difference overflow; the difference is exact then
    return like(rows, math.ldexp(target - coordinate, -exponent))


@plain
def _scale_ways(rows: Any, points: Any, x: float, y: float, z: float, is_measured: bool) -> bool:
    """Bring D to moderate lengths; whether no vertex is declined: on the position, not finite, or |D| out of range."""
    good, is_wide = True, not is_nowhere(points)
    for i in range(BLOCK):
        if is_moderate(square_of(rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i])):
            continue
        px, py, pz = np.float64(rows[at.PX + i]), np.float64(rows[at.PY + i]), np.float64(rows[at.PZ + i])
        if is_wide:
            px, py, pz = points[i], points[BLOCK + i], points[2 * BLOCK + i]
        exponent = exponent_of(x - px, y - py, z - pz) if is_finite(x - px, y - py, z - pz) else 0
        rows[at.DX + i] = _scaled_difference(rows, x, px, exponent, is_wide)
        rows[at.DY + i] = _scaled_difference(rows, y, py, exponent, is_wide)
        rows[at.DZ + i] = _scaled_difference(rows, z, pz, exponent, is_wide)
        square = square_of(rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i])
        rows[at.NEARNESS + i] = inverse_root(square)
        is_there = is_moderate(square)
        if is_measured:
            distance = like(rows, math.ldexp(np.float64(np.sqrt(square)), exponent))
            rows[at.STRENGTH + i] = distance
            is_there = is_there and distance >= _NEAREST and distance <= _FARTHEST
        if not is_there:
            rows[at.DECLINED + i] = 1.0
            good = False
    return good


@plain
def approach(rows: Any, points: Any, x: float, y: float, z: float) -> bool:
    """D towards a position, with 1/|D|; whether no vertex is declined."""
    return _approach(rows, points, x, y, z) or _scale_ways(rows, points, x, y, z, False)


@plain
def approach_measured(rows: Any, points: Any, x: float, y: float, z: float) -> bool:
    """`approach`, with |D| in the row of strengths."""
    return _approach_measured(rows, points, x, y, z) or _scale_ways(rows, points, x, y, z, True)


@plain
def attenuate(rows: Any, constant: float, linear: float, quadratic: float) -> None:
    """1 / (c + l·d + q·d²) in place of d in the row of strengths; finite where the sum has underflowed."""
    c, l, q = like(rows, constant), like(rows, linear), like(rows, quadratic)
    for i in range(BLOCK):
        distance = rows[at.STRENGTH + i]
        weakening = multiply_add(multiply_add(q, distance, l), distance, c)
        rows[at.STRENGTH + i] = min(_ONE / weakening, _STRONGEST)


@plain
def measure_ways(rows: Any) -> None:
    """1/|D| for D that did not come from `approach`."""
    for i in range(BLOCK):
        rows[at.NEARNESS + i] = inverse_root(square_of(rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]))


@plain
def look(rows: Any) -> None:
    """V along ways to the eye."""
    for i in range(BLOCK):
        inverse = rows[at.NEARNESS + i]
        rows[at.VX + i] = rows[at.DX + i] * inverse
        rows[at.VY + i] = rows[at.DY + i] * inverse
        rows[at.VZ + i] = rows[at.DZ + i] * inverse


@plain
def face(rows: Any) -> None:
    """N·v."""
    for i in range(BLOCK):
        rows[at.FACING + i] = normal_dot(rows, i, rows[at.VX + i], rows[at.VY + i], rows[at.VZ + i])


@inlined
def _unit_cross(ax: Any, ay: Any, az: Any, bx: Any, by: Any, bz: Any) -> tuple[Any, Any, Any]:
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    inverse = inverse_root(square_of(x, y, z))
    return x * inverse, y * inverse, z * inverse


@plain
def straighten_tangents(rows: Any) -> None:
    """Tangents that are not quite across n made so, (n × t) × n, and unit length; zero where they are along n."""
    for i in range(BLOCK):
        inverse = rows[at.INVERSE + i]
        nx, ny, nz = rows[at.NX + i] * inverse, rows[at.NY + i] * inverse, rows[at.NZ + i] * inverse
        bx, by, bz = _unit_cross(nx, ny, nz, rows[at.TX + i], rows[at.TY + i], rows[at.TZ + i])
        rows[at.TX + i], rows[at.TY + i], rows[at.TZ + i] = _unit_cross(bx, by, bz, nx, ny, nz)


@plain
def turn_normals(rows: Any, by_axis: bool) -> None:
    """Replace n by −n where it points away from v, or from the axis to the viewer."""
    toward = at.AX if by_axis else at.VX
    for i in range(BLOCK):
        x, y, z = rows[toward + i], rows[toward + BLOCK + i], rows[toward + 2 * BLOCK + i]
        # a product is quicker than a store under a mask
        sign = -_ONE if normal_dot(rows, i, x, y, z) < _ZERO else _ONE
        rows[at.NX + i] *= sign
        rows[at.NY + i] *= sign
        rows[at.NZ + i] *= sign
