"""The kernel's loop over disks that are seen. Where the horizon cuts one, vertices are declined.

With the distance of a disk's middle for the unit of length: s its radius, h the cosine off its axis at which it is
seen, c = n·l, z the cosine between n and the axis. The integral along the rim that `optics.disks` has, Hamilton and
Morgan's (1952), is then (z T + 2 h c) / ((1 + s² + S) S), with S² = (1 − s²)² + 4 s² h² and T = S − (1 − s²), in which
nothing cancels.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import multiply_add, plain
from pvphong.shading.kernel.pointers import like
from pvphong.shading.kernel.rows import BLOCK
from pvphong.shading.kernel.vectors import dot
from pvphong.shading.kernel.ways import normal_dot

_F = np.float32
_ZERO, _ONE, _TWO = _F(0.0), _F(1.0), _F(2.0)
# Nearer to the rim S has lost digits; so much larger than it is far away, squares of squares have no room.
_BESIDE, _LARGE = _F(0.1), _F(2.0**20)


@plain
def disk_cosine(rows: Any, shape: Any, target: int) -> bool:
    """D²/area · ∫ max(n·u, 0) du into a row, d the distance of the middle; whether no vertex is declined.

    For ways to the middle, with the distance in the row of strengths. `shape` holds the axis (3), whether the back
    glows, and the radius.
    """
    ax, ay, az = like(rows, shape[0]), like(rows, shape[1]), like(rows, shape[2])
    has_back, radius = shape[3] > 0.0, like(rows, shape[4])
    good = True
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
        is_lost = is_lit & ((c < slope) | (root < _BESIDE) | (not s < _LARGE))
        rows[at.DECLINED + i] = _ONE if is_lost else rows[at.DECLINED + i]
        good = good & (not is_lost)
        rows[target + i] = max(seen, _ZERO) if is_lit & (not is_lost) else _ZERO
    return good
