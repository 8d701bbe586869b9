"""The kernel's loop that raises cosines to a power, where their chords' squares are known."""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import exp2, log2_power, plain
from pvphong.shading.kernel.pointers import like
from pvphong.shading.kernel.rows import BLOCK

_ZERO, _NEVER = np.float32(0.0), np.float32(-np.inf)


@plain
def raise_second(rows: Any, exponent: float, log_floor: float, dark: float) -> None:
    """max(1 − |C|²/2, floor)ⁿ in place of |C|² in the second row of factors, and 0 where the first one is 0.

    It is 0 from the squared chord `dark` on too. In two loops, because a processor sees no further ahead than some
    hundred steps, and each step of a polynomial waits for the one before: a third less time than in one.
    """
    n, least, end = like(rows, exponent), like(rows, log_floor), like(rows, dark)
    for i in range(BLOCK):
        square = rows[at.SECOND + i]
        raised = log2_power(square, n, least)
        shows = (square < end) & (rows[at.FIRST + i] > _ZERO)
        rows[at.SECOND + i] = raised if shows else _NEVER
    for i in range(BLOCK):
        y = rows[at.SECOND + i]
        rows[at.SECOND + i] = exp2(y) if y > _NEVER else _ZERO
