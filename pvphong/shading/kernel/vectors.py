"""Dot products and lengths of vectors, and which of them a loop may use as they come."""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.shading.kernel.arithmetic import inlined, multiply_add
from pvphong.shading.kernel.pointers import like

_ONE = np.float32(1.0)

# Squared lengths between these have lost no bit to underflow, in float32 as in float64.
_LEAST_SQUARE, _MOST_SQUARE = np.float32(2.0**-80), np.float32(2.0**120)

ZERO_SQUARE = np.float32(2.0**-126)
"""Stands in for the square of a zero vector, which then remains zero when it is made unit length."""

NO_LENGTH = np.float32(2.0**62)
"""The inverse length of a normal that is not there is more."""


@inlined
def in_type(vector: Any, rows: Any) -> tuple[Any, Any, Any]:
    """A vector or colour of a record, in the type of rows."""
    return like(rows, vector[0]), like(rows, vector[1]), like(rows, vector[2])


@inlined
def is_moderate(square: Any) -> bool:
    """Whether a vector of that squared length can be used as it is; False for NaN."""
    return (square >= _LEAST_SQUARE) & (square <= _MOST_SQUARE)  # `and` would be a branch


@inlined
def dot(ax: Any, ay: Any, az: Any, bx: Any, by: Any, bz: Any) -> Any:
    """Dot product, summed in the order x, y, z; not fused, for what cancels exactly is to be 0."""
    return ax * bx + ay * by + az * bz


@inlined
def square_of(x: Any, y: Any, z: Any) -> Any:
    """Squared length, summed in the order x, y, z."""
    return multiply_add(z, z, multiply_add(y, y, x * x))


@inlined
def root(square: Any) -> Any:
    """The length of a vector of that squared length."""
    return np.sqrt(square)


@inlined
def inverse_root(square: Any) -> Any:
    """What makes a vector of that squared length unit length."""
    return _ONE / np.sqrt(max(square, ZERO_SQUARE))
