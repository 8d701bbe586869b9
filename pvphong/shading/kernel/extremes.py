"""The least and greatest entries of vectors: the box around a mesh, which a plan asks for."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba.extending import intrinsic

from pvphong.shading.kernel.arithmetic import inlined
from pvphong.shading.kernel.pointers import shifted

# Entries that are compared at once, each in a place of its own: a multiple of three, so that x stays with x, and of
# the length of vectors. More of them would keep memory from being read one line after the other.
_LANES = 48

# Length of the scratch memory: the least and the greatest of each place.
ROWS = 2 * _LANES

_ZERO = np.float32(0.0)


def _choosing(name: str) -> Any:
    """One of LLVM's choices between two numbers of a type; any number where one of them is NaN.

    The builtins' comparisons LLVM makes into stores under a mask, which cost some processors ten times as much.
    """

    @intrinsic
    def choose(_typing: Any, a: Any, b: Any) -> Any:
        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            kind = arguments[0].type
            function = builder.module.declare_intrinsic(f"llvm.{name}", [kind], ir.FunctionType(kind, [kind] * 2))
            return builder.call(function, arguments, fastmath=("nnan", "nsz"))

        return a(a, b), generate

    return choose


_least, _most = _choosing("minnum"), _choosing("maxnum")


@inlined
def _widen_by_four(part: Any, low: Any, high: Any) -> bool:
    """As `_widen`, by four times as many entries: reading and writing the extremes takes longer than comparing."""
    good = True
    for i in range(_LANES):
        a, b, c, d = part[i], part[_LANES + i], part[2 * _LANES + i], part[3 * _LANES + i]
        low[i] = _least(low[i], _least(_least(a, b), _least(c, d)))
        high[i] = _most(high[i], _most(_most(a, b), _most(c, d)))
        good = good & ((a - a) + (b - b) == (c - c) + (d - d))
    return good


@inlined
def _widen(part: Any, count: int, low: Any, high: Any) -> bool:
    good = True
    for i in range(count):
        x = part[i]
        low[i] = _least(low[i], x)
        high[i] = _most(high[i], x)
        good = good & (x - x == _ZERO)
    return good


def find_extremes(array: Any, start: int, stop: int, rows: Any, found: Any) -> bool:
    """Least x, y, z and greatest x, y, z of some vectors; gives whether all entries are finite."""
    low, high = rows, shifted(rows, _LANES)
    for i in range(_LANES):
        low[i], high[i] = np.inf, -np.inf
    good = True
    in_fours = (stop - start) * 3 // (4 * _LANES) * 4 * _LANES
    for first in range(3 * start, 3 * start + in_fours, 4 * _LANES):
        good = good & _widen_by_four(shifted(array, first), low, high)
    for first in range(3 * start + in_fours, 3 * stop, _LANES):
        good = good & _widen(shifted(array, first), min(_LANES, 3 * stop - first), low, high)
    for k in range(3):
        found[k], found[3 + k] = low[k], high[k]
        for i in range(k + 3, _LANES, 3):
            found[k], found[3 + k] = min(found[k], np.float64(low[i])), max(found[3 + k], np.float64(high[i]))
    return good
