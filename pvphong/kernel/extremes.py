"""The least and greatest entries of vectors: the box around a mesh, which a plan asks for."""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.kernel.arithmetic import inlined, plain
from pvphong.kernel.rows import BLOCK

# Entries that are compared at once, each in a place of its own: a multiple of three, so that x stays with x.
_LANES = 3 * BLOCK
_NARROW = 24

# Length of the scratch memory: the least and the greatest of each place.
ROWS = 2 * _LANES

_ZERO = np.float32(0.0)


@inlined
def _widen(part: Any, low: Any, high: Any) -> bool:
    good = True
    for i in range(len(part)):
        x = part[i]
        low[i] = min(low[i], x)
        high[i] = max(high[i], x)
        good = good & (x - x == _ZERO)
    return good


@plain
def find_extremes(array: Any, start: int, stop: int, rows: Any, found: Any) -> None:
    """Least x, y, z and greatest x, y, z of some vectors; all NaN where any entry is not finite."""
    low, high = rows[:_LANES], rows[_LANES:]
    for i in range(_LANES):
        low[i], high[i] = np.inf, -np.inf
    good = True
    for first in range(3 * start, 3 * stop, _LANES):
        good = good & _widen(array[first : min(first + _LANES, 3 * stop)], low, high)
    width = _LANES
    while width > _NARROW:  # in halves, which keep x with x, because many entries at once take less time
        width //= 2
        for i in range(width):
            low[i] = min(low[i], low[width + i])
            high[i] = max(high[i], high[width + i])
    for k in range(3):
        found[k], found[3 + k] = low[k], high[k]
        for i in range(k + 3, width, 3):
            found[k], found[3 + k] = min(found[k], low[i]), max(found[3 + k], high[i])
    if not good:
        found[:6] = np.nan
