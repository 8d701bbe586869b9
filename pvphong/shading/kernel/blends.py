"""Blends of a mesh's vertices at places inside its triangles, compiled, and the differences of colours there."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types

from pvphong.base.types import Float64Array, IntArray
from pvphong.shading.kernel.arithmetic import inlined
from pvphong.shading.kernel.code import Library
from pvphong.shading.kernel.evaluation import address

_DOUBLES = types.CPointer(types.float64)
_INTEGERS = types.CPointer(types.int64)


@inlined
def _clipped(x: Any, low: Any, high: Any) -> Any:
    return low if x < low else (high if x > high else x)  # a NaN stays


def blend(
    values: Any,
    width: int,
    limits: Any,
    corners: Any,
    sides: int,
    weights: Any,
    stride: int,
    places: int,
    count: int,
    blends: Any,
) -> int:
    """Interpolate rows of numbers at places inside faces; return `count`.

    Parameters
    ----------
    values, width, limits
        A row of `width` numbers for each vertex. The numbers are clipped to the two `limits` first.
    corners, sides
        `sides` vertices for each face.
    weights, stride
        A weight for each corner, place after place. `stride` is the distance from the first weight of one face to the
        first weight of the next face: 0 if all faces share the weights.
    places, count : int
        Number of places in a face, and number of faces.
    blends
        Output: a row for each place, face after face.
    """
    low, high = limits[0], limits[1]
    for i in range(count):
        for k in range(places):
            at, to = i * stride + sides * k, (i * places + k) * width
            for j in range(width):
                blends[to + j] = weights[at] * _clipped(values[corners[sides * i] * width + j], low, high)
            for c in range(1, sides):
                weight, start = weights[at + c], corners[sides * i + c] * width
                for j in range(width):
                    blends[to + j] += weight * _clipped(values[start + j], low, high)
    return count


def compare(colors: Any, others: Any, count: int, differences: Any) -> int:
    """Compute the largest absolute difference of a channel for each of `count` pairs of colours; return `count`.

    The difference is NaN if a channel is NaN.
    """
    for i in range(count):
        most = abs(colors[3 * i] - others[3 * i])
        for k in range(3 * i + 1, 3 * i + 3):
            off = abs(colors[k] - others[k])
            most = off if off > most or math.isnan(off) else most
        differences[i] = most
    return count


def blend_code(library: Library) -> Callable[..., int]:
    """Return `blend`, compiled."""
    return library.call(
        blend,
        lambda: types.intp(
            _DOUBLES, types.intp, _DOUBLES, _INTEGERS, types.intp, _DOUBLES, *(types.intp,) * 3, _DOUBLES
        ),
    )


def compare_code(library: Library) -> Callable[..., int]:
    """Return `compare`, compiled."""
    return library.call(compare, lambda: types.intp(_DOUBLES, _DOUBLES, types.intp, _DOUBLES))


def blended(
    library: Library,
    values: Float64Array,
    corners: IntArray,
    weights: Float64Array,
    low: float = -math.inf,
    high: float = math.inf,
) -> Float64Array:
    """Clip the values of vertices, and interpolate between vertices; see `pvphong.shading.inside.lighting.blended`."""
    values, weights = np.require(values, np.float64, ["C"]), np.require(weights, np.float64, ["C"])
    corners = np.require(corners, np.int64, ["C"])
    (count, sides), places, width = corners.shape, weights.shape[-2], values.shape[1]
    result = np.empty((count * places, width))
    limits, stride = np.array([low, high]), 0 if weights.ndim == 2 else sides * places
    faces = address(corners), sides, address(weights), stride, places, count
    blend_code(library)(address(values), width, address(limits), *faces, address(result))
    return result


def differences(library: Library, colors: Float64Array, others: Float64Array) -> Float64Array:
    """Return the largest absolute difference of a channel between each pair of colours, shape (n,).

    `colors` and `others` have the shape (n, 3) and are C-contiguous.
    """
    result = np.empty(len(colors))
    compare_code(library)(address(colors), address(others), len(colors), address(result))
    return result
