"""The kernel's loops that take colours out of a block's rows: times the albedo, clipped, as floats or as bytes."""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import WHOLE32, inlined, plain
from pvphong.shading.kernel.pointers import shifted
from pvphong.shading.kernel.rows import BLOCK

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)


@inlined
def _reflectance(albedo: Any) -> Any:
    """In [0, 1], and 0 for a NaN."""
    return min(albedo, _ONE) if albedo > _ZERO else _ZERO


@inlined
def clipped(intensity: Any, low: Any, high: Any) -> Any:
    """In [low, high], for all but NaN."""
    return min(max(intensity, low), high)


@plain
def tint(rows: Any) -> None:
    """Colour times albedo plus highlights."""
    for i in range(BLOCK):
        rows[at.R + i] = rows[at.R + i] * _reflectance(rows[at.ALBEDO_R + i]) + rows[at.HR + i]
        rows[at.G + i] = rows[at.G + i] * _reflectance(rows[at.ALBEDO_G + i]) + rows[at.HG + i]
        rows[at.B + i] = rows[at.B + i] * _reflectance(rows[at.ALBEDO_B + i]) + rows[at.HB + i]


@plain
def encode(rows: Any, exponent: Any) -> None:
    """Colours raised to a power."""
    for i in range(3 * BLOCK):
        rows[at.R + i] = max(rows[at.R + i], _ZERO) ** exponent


@plain
def join(rows: Any, low: Any, high: Any, rgb: Any, start: int, count: int) -> None:
    """Colours, clipped to [low, high], one after the other."""
    part = shifted(rgb, 3 * start)
    for i in range(count):
        part[3 * i] = clipped(rows[at.R + i], low, high)
        part[3 * i + 1] = clipped(rows[at.G + i], low, high)
        part[3 * i + 2] = clipped(rows[at.B + i], low, high)


@inlined
def _byte(intensity: Any) -> Any:
    """0-255 for an intensity clipped to [0, 1]: the nearest, and of two equally near the even one."""
    fraction = clipped(np.float32(intensity), _ZERO, _ONE)
    return np.uint8(np.float32(fraction * np.float32(255.0) + WHOLE32).view(np.int32))


@plain
def join_bytes(rows: Any, display: Any, start: int, count: int) -> None:
    """`join` for uint8."""
    part = shifted(display, 3 * start)
    for i in range(count):
        part[3 * i] = _byte(rows[at.R + i])
        part[3 * i + 1] = _byte(rows[at.G + i])
        part[3 * i + 2] = _byte(rows[at.B + i])
