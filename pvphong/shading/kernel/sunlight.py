"""One even light and Lambert's factor alone, from normals straight to colours.

Such a scene waits for memory, and one loop from memory to memory waits for it less than the passes over a block do:
a fifth to a third of the time. It gives the passes' bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.shading.kernel.arithmetic import multiply_add, plain
from pvphong.shading.kernel.colors import clipped
from pvphong.shading.kernel.pointers import like, shifted
from pvphong.shading.kernel.rows import BLOCK
from pvphong.shading.kernel.vectors import dot, in_type, inverse_root, is_moderate, square_of

_ZERO = np.float32(0.0)


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
