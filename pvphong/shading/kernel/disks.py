"""The kernel's loops over disks that are seen. Where the horizon cuts a large one, vertices are declined.

With the distance of a disk's middle for the unit of length: s its radius, h the cosine off its axis at which it is
seen, c = n·l, z the cosine between n and the axis. The integral along the rim that `optics.disks` has, Hamilton and
Morgan's (1952), is then (z T + 2 h c) / ((1 + s² + S) S), with S² = (1 − s²)² + 4 s² h² and T = S − (1 − s²), in which
nothing cancels. Of a small disk that is cut, what is left is summed at nodes on chords along the horizon, as in
`optics.spherical.tiny_disk`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import inlined, multiply_add
from pvphong.shading.kernel.caps import angle_of
from pvphong.shading.kernel.pointers import like
from pvphong.shading.kernel.rows import BLOCK
from pvphong.shading.kernel.sides import small_sine
from pvphong.shading.kernel.vectors import dot, square_of
from pvphong.shading.kernel.ways import normal_dot

_F = np.float32
_ZERO, _ONE, _TWO, _TINY = _F(0.0), _F(1.0), _F(2.0), _F(2.0**-126)
_PI = _F(math.pi)
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_ALONG, _ALONG_SHARES = tuple(_F(0.125 * (x + 1.0)) for x in _PLACES), tuple(_F(0.5 * x) for x in _WEIGHTS)
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_ACROSS, _ACROSS_SHARES = tuple(_F(x) for x in _PLACES), tuple(_F(x) for x in _WEIGHTS)
# Smaller disks are summed at those nodes, to 1e-6.
_SMALL = _F(0.4)
# Nearer to the rim S has lost digits; so much larger than it is far away, squares of squares have no room.
_BESIDE, _LARGE = _F(0.1), _F(2.0**20)


@inlined
def disk_cosine(rows: Any, shape: Any, target: int) -> bool:
    """D²/area · ∫ max(n·u, 0) du into a row, d the distance of the middle; whether no vertex is declined.

    For ways to the middle, with the distance in the row of strengths. `shape` holds the axis (3), whether the back
    glows, and the radius.
    """
    ax, ay, az = like(rows, shape[0]), like(rows, shape[1]), like(rows, shape[2])
    has_back, radius = shape[3] > 0.0, like(rows, shape[4])
    good, any_cut = True, False
    for i in range(BLOCK):
        inverse, shrink = rows[at.NEARNESS + i], rows[at.INVERSE + i]
        behind = dot(ax, ay, az, rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]) * inverse
        side = _ONE if behind > _ZERO else -_ONE  # of the axis, on which the disk's far side is
        z = side * dot(ax, ay, az, rows[at.NX + i] * shrink, rows[at.NY + i] * shrink, rows[at.NZ + i] * shrink)
        c = normal_dot(rows, i, rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]) * (inverse * shrink)
        s, h = radius * inverse, abs(behind)
        slope = s * np.sqrt(max((_ONE - z) * (_ONE + z), _ZERO))
        is_lit = (has_back | (behind < _ZERO)) & (h > _ZERO) & (c > -slope) & (shrink > _ZERO)
        less = (_ONE - s) * (_ONE + s)
        root = np.sqrt(multiply_add(less, less, _F(4.0) * (s * s) * (h * h)))
        rise = _F(4.0) * (s * s) * (h * h) / (root + less) if less > _ZERO else root - less
        seen = multiply_add(z, rise, _TWO * h * c) / ((_ONE + s * s + root) * root)
        is_cut = is_lit & (c < slope) & (s < _SMALL)
        is_lost = is_lit & (not is_cut) & ((c < slope) | (root < _BESIDE) | (not s < _LARGE))
        any_cut = any_cut | is_cut
        rows[at.OWN + i] = angle_of(np.sqrt(max((slope - c) * (slope + c), _ZERO)), -c) if is_cut else _ZERO
        rows[at.DECLINED + i] = _ONE if is_lost else rows[at.DECLINED + i]
        good = good & (not is_lost)
        rows[target + i] = max(seen, _ZERO) if is_lit & (not is_lost) else _ZERO
    if any_cut:
        _add_cut(rows, ax, ay, az, radius, target)
    return good


@inlined
def _add_cut(rows: Any, ax: Any, ay: Any, az: Any, radius: Any, target: int) -> None:
    """What is left of disks, in place of what stands in a row: where β, in a stage's first own row, is not 0.

    At the angle α <= β off the highest point of the rim is a chord.
    """
    for i in range(BLOCK):
        nx, ny, nz = _normal(rows, i)
        along = dot(ax, ay, az, nx, ny, nz)
        ux, uy, uz = nx - along * ax, ny - along * ay, nz - along * az
        shrink = _ONE / max(np.sqrt(square_of(ux, uy, uz)), _TINY)
        rows[at.OWN + BLOCK + i], rows[at.OWN + 2 * BLOCK + i] = ux * shrink, uy * shrink
        rows[at.OWN + 3 * BLOCK + i], rows[at.OWN + 4 * BLOCK + i] = uz * shrink, _ZERO
    for k in range(len(_ALONG)):
        for j in range(len(_ACROSS)):
            for i in range(BLOCK):
                nx, ny, nz = _normal(rows, i)
                inverse = rows[at.NEARNESS + i]
                s = radius * inverse
                cosine, sine = _turned(_ALONG[k] * rows[at.OWN + i])
                ux, uy, uz = rows[at.OWN + BLOCK + i], rows[at.OWN + 2 * BLOCK + i], rows[at.OWN + 3 * BLOCK + i]
                up, aside = s * cosine, s * sine * _ACROSS[j]
                x = multiply_add(rows[at.DX + i], inverse, multiply_add(up, ux, aside * (ay * uz - az * uy)))
                y = multiply_add(rows[at.DY + i], inverse, multiply_add(up, uy, aside * (az * ux - ax * uz)))
                z = multiply_add(rows[at.DZ + i], inverse, multiply_add(up, uz, aside * (ax * uy - ay * ux)))
                square = square_of(x, y, z)
                seen = max(dot(nx, ny, nz, x, y, z), _ZERO) * abs(dot(ax, ay, az, x, y, z)) / (square * square)
                share = _ALONG_SHARES[k] * _ACROSS_SHARES[j]
                rows[at.OWN + 4 * BLOCK + i] += share * (sine * sine) * seen
    for i in range(BLOCK):
        beta = rows[at.OWN + i]
        cut = rows[at.OWN + 4 * BLOCK + i] * beta / _PI
        rows[target + i] = cut if beta > _ZERO else rows[target + i]


@inlined
def _normal(rows: Any, i: int) -> tuple[Any, Any, Any]:
    shrink = rows[at.INVERSE + i]
    return rows[at.NX + i] * shrink, rows[at.NY + i] * shrink, rows[at.NZ + i] * shrink


@inlined
def _turned(quarter: Any) -> tuple[Any, Any]:
    """Cosine and sine of four times an angle in [0, π/4]."""
    sine = small_sine(quarter)
    twice, rest = _TWO * sine * np.sqrt(_ONE - sine * sine), _ONE - _TWO * sine * sine
    return _ONE - _TWO * twice * twice, _TWO * twice * rest
