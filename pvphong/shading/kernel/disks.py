"""The kernel's loops over disks that are seen.

With the distance of a disk's middle for the unit of length: s its radius, h the cosine off its axis at which it is
seen, c = n·l, z the cosine between n and the axis. Where all of a disk is above the horizon, the integral along the rim
that `optics.disks` has for Lambert's cosine, Hamilton and Morgan's (1952), is (z T + 2 h c) / ((1 + s² + S) S), with
S² = (1 − s²)² + 4 s² h² and T = S − (1 − s²), in which nothing cancels. `rims` has the others.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.shading.kernel import rims
from pvphong.shading.kernel import vertices as at
from pvphong.shading.kernel.arithmetic import inlined, like, multiply_add
from pvphong.shading.kernel.caps import reaches
from pvphong.shading.kernel.vertices import BLOCK, dot, mirrored_viewer, square_of, unit_normal

_F = np.float32
_ZERO, _HALF, _ONE, _TWO, _FOUR = _F(0.0), _F(0.5), _F(1.0), _F(2.0), _F(4.0)
# Smaller disks that are cut are summed at nodes, to 1e-6. 1 − cos² is nothing from here on: cos² is cut off at 0.
_SMALL, _SHOWN = 0.15, 0.9996838
# Nearer to the rim S has lost digits; so much larger than it is far away, squares of squares have no room.
_BESIDE, _LARGE = _F(0.1), _F(2.0**20)

# 1 where the side that glows is seen.
_LIT = at.OWN


@inlined
def see_disk(rows: Any, shape: Any) -> None:
    """How a disk is seen: into the rows of `rims`.

    For ways to the middle. `shape` holds the axis (3), whether the back glows, and the radius.
    """
    ax, ay, az = like(rows, shape[0]), like(rows, shape[1]), like(rows, shape[2])
    has_back, radius = shape[3] > 0.0, like(rows, shape[4])
    for i in range(BLOCK):
        behind = dot(ax, ay, az, rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i])
        side = _ONE if behind > _ZERO else -_ONE  # of the axis, on which the disk's far side is
        rows[rims.EX + i], rows[rims.EY + i], rows[rims.EZ + i] = side * ax, side * ay, side * az
        rows[rims.FORWARD + i], rows[rims.RADIUS + i] = _ONE, radius * rows[at.NEARNESS + i]
        rows[_LIT + i] = _ONE if (behind < _ZERO) | (has_back & (behind > _ZERO)) else _ZERO


@inlined
def disk_cosine(rows: Any, target: int) -> bool:
    """D²/area · ∫ max(n·u, 0) du into a row, d the distance of the middle; whether no vertex is declined."""
    good, any_cut = True, False
    for i in range(BLOCK):
        inverse, s = rows[at.NEARNESS + i], rows[rims.RADIUS + i]
        nx, ny, nz = unit_normal(rows, i)
        ex, ey, ez = rows[rims.EX + i], rows[rims.EY + i], rows[rims.EZ + i]
        dx, dy, dz = rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]
        z, c = dot(nx, ny, nz, ex, ey, ez), dot(nx, ny, nz, dx, dy, dz) * inverse
        h = dot(ex, ey, ez, dx, dy, dz) * inverse
        slope = s * np.sqrt(max((_ONE - z) * (_ONE + z), _ZERO))
        less = (_ONE - s) * (_ONE + s)
        root = np.sqrt(multiply_add(less, less, _FOUR * (s * s) * (h * h)))
        rise = _FOUR * (s * s) * (h * h) / (root + less) if less > _ZERO else root - less
        seen = multiply_add(z, rise, _TWO * h * c) / ((_ONE + s * s + root) * root)
        is_lit = (rows[_LIT + i] > _ZERO) & (c > -slope)
        is_cut = is_lit & (c < slope)
        is_lost = is_lit & (not is_cut) & ((root < _BESIDE) | (not s < _LARGE))
        any_cut, good = any_cut | is_cut, good & (not is_lost)
        rows[at.DECLINED + i] = _ONE if is_lost else rows[at.DECLINED + i]
        rows[target + i] = max(seen, _ZERO) if is_lit & (not is_cut) & (not is_lost) else _ZERO
        rows[rims.FOUND + i] = _ONE if is_cut else _ZERO
        rows[rims.WX + i], rows[rims.WY + i], rows[rims.WZ + i] = nx, ny, nz
    if any_cut:
        good = rims.power_within_rim(rows, _ONE, _SHOWN, _SMALL, True) & good
        for i in range(BLOCK):
            rows[target + i] += rows[rims.FOUND + i]
    return good


@inlined
def disk_power(rows: Any, target: int, exponent: float, shown: float, small: float) -> bool:
    """D²/area · ∫ max(w·u, 0)ⁿ du above the horizon into a row; whether no vertex is declined.

    `shown` is the 1 − z from which zⁿ⁺¹ is nothing, `small` the size over distance below which nodes do.
    """
    nothing = like(rows, shown)
    for i in range(BLOCK):
        wx, wy, wz = mirrored_viewer(rows, i)
        rows[rims.WX + i], rows[rims.WY + i], rows[rims.WZ + i] = wx, wy, wz
        inverse, s = rows[at.NEARNESS + i], min(rows[rims.RADIUS + i], _ONE)
        lx, ly, lz = rows[at.DX + i] * inverse, rows[at.DY + i] * inverse, rows[at.DZ + i] * inverse
        less = min(_HALF * square_of(lx - wx, ly - wy, lz - wz), _TWO)
        is_wanted = (rows[_LIT + i] > _ZERO) & ((s >= _ONE) | reaches(less, s, nothing))
        rows[rims.FOUND + i] = _ONE if is_wanted else _ZERO
    good = rims.power_within_rim(rows, exponent, shown, small, False)
    for i in range(BLOCK):
        rows[target + i] = rows[rims.FOUND + i]
    return good
