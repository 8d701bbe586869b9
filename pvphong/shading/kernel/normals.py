"""Normals of a mesh's points by compiled code: range after range of points, by several threads."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import Float64Array, FloatArray, Weighting
from pvphong.shading.kernel import pool
from pvphong.shading.kernel.face_rows import CHUNK, FACES, ROWS, SUMS, WEIGHTINGS
from pvphong.shading.kernel.running import address

# Faces that a thread surveys at a time.
_SURVEYED = 32 * CHUNK

# Points in a range: few enough that their sums stay in the second-level cache.
_RANGE = 2**14
# Points in the ranges of all threads together where those have to be longer: their sums then take 64 MiB.
_MOST_POINTS = 2**21


def point_normals(
    points: FloatArray,
    connectivity: NDArray[Any],
    offsets: NDArray[Any],
    weighting: Weighting,
    survey: Callable[..., int],
    find: Callable[..., int],
) -> Float64Array | None:
    """As `pvphong.geometry.normals.point_normals`, by compiled code that looks over the faces and that finds normals.

    None where that is to do it: for what it refuses, such as an index that is none of a point's, for faces of more than
    `CORNERS` corners, and for faces of sizes so far apart that squares of their edges leave the range of floats.
    """
    if any(array.ndim != 1 or array.dtype.kind not in "iu" for array in (connectivity, offsets)):
        return None
    corners, starts = (np.require(array, np.int64, ["C", "A"]) for array in (connectivity, offsets))
    if len(starts) == 0 or (starts[0], starts[-1]) != (0, len(corners)):
        return None
    spans = _spans(corners, starts, survey)
    if spans is None or spans[:, 0].min(initial=0) < 0 or spans[:, 1].max(initial=-1) >= len(points):
        return None
    mesh = corners, starts, spans, WEIGHTINGS.index(weighting)
    result = _normals(np.require(points, None, ["C", "A"]), *mesh, find)
    if result is None:
        scaled = _scaled(points, corners)
        return None if scaled is None else _normals(scaled, *mesh, find)
    return result


def _normals(
    points: FloatArray,
    corners: NDArray[np.int64],
    starts: NDArray[np.int64],
    spans: NDArray[np.int64],
    weighting: int,
    find: Callable[..., int],
) -> Float64Array | None:
    """None where faces are too large or too small."""
    result = np.empty((len(points), 3))
    wide_or_not = (points, None) if points.dtype == np.float64 else (None, points)
    mesh = *map(address, (*wide_or_not, corners, starts)), len(starts) - 1, address(spans), weighting
    declined: list[int] = []

    def work(first: int, last: int) -> None:
        scratch = np.empty(FACES, np.int64), np.empty(ROWS), np.zeros((last - first, SUMS))
        if not declined and not find(*mesh, first, last, *map(address, (*scratch, result[first:]))):
            declined.append(first)

    pool.run(work, len(points), _length_of_ranges(spans, len(points)))
    return None if declined else result


def _scaled(points: FloatArray, corners: NDArray[np.int64]) -> Float64Array | None:
    """Points over the power of two that takes the largest coordinate to [0.5, 1); None where that is not exact.

    What no face has or is not finite is NaN: it neither decides about the power nor keeps it from being exact.
    """
    counts = np.zeros(len(points), dtype=bool)
    counts[corners] = True
    counts &= np.isfinite(points).all(axis=1)
    rows = np.where(counts[:, None], points.astype(np.float64, copy=False), np.nan)
    exponent = np.frexp(np.fmax.reduce(np.abs(rows), axis=None, initial=0.0))[1]
    result: Float64Array = np.ldexp(rows, -exponent)
    return result if np.array_equal(np.ldexp(result, exponent), rows, equal_nan=True) else None


def _spans(
    corners: NDArray[np.int64], starts: NDArray[np.int64], survey: Callable[..., int]
) -> NDArray[np.int64] | None:
    """(n, 2) least and greatest index in each chunk of faces; None where a face is not as it should be."""
    n_faces = len(starts) - 1
    found = np.empty((-(-n_faces // CHUNK), 2), np.int64)
    wrong: list[int] = []

    def work(first: int, last: int) -> None:
        if not survey(address(corners), address(starts), first, last, len(corners), address(found)):
            wrong.append(first)

    pool.run(work, n_faces, _SURVEYED)
    return None if wrong else found


def _length_of_ranges(spans: NDArray[np.int64], n_points: int) -> int:
    """Points in a range, so many that few chunks of faces are looked at more than twice."""
    threads, length = pool.count(), _RANGE
    while length * threads < min(n_points, _MOST_POINTS):
        looks = (spans[:, 1] // length - spans[:, 0] // length + 1).sum()
        if looks <= 2 * len(spans):
            break
        length *= 2
    return length
