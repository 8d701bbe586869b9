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

    None where that is to do it: for indices that are none of a point's or offsets that do not rise, which it refuses,
    for faces of more than `CORNERS` corners, and for those whose edges' squares would leave the range of floats.
    """
    corners, starts = (np.require(array, np.int64, ["C", "A"]) for array in (connectivity, offsets))
    vertices = np.require(points, None, ["C", "A"])
    if len(starts) == 0 or (starts[0], starts[-1]) != (0, len(corners)):
        return None
    n_points, n_faces = len(points), len(starts) - 1
    spans = _spans(corners, starts, survey)
    if spans is None or spans[:, 0].min(initial=0) < 0 or spans[:, 1].max(initial=-1) >= n_points:
        return None
    result = np.empty((n_points, 3))
    wide_or_not = (vertices, None) if points.dtype == np.float64 else (None, vertices)
    mesh = *map(address, (*wide_or_not, corners, starts)), n_faces, address(spans), WEIGHTINGS.index(weighting)
    declined: list[int] = []

    def work(first: int, last: int) -> None:
        scratch = np.empty(FACES, np.int64), np.empty(ROWS), np.zeros((last - first, SUMS))
        if not declined and not find(*mesh, first, last, *map(address, (*scratch, result[first:]))):
            declined.append(first)

    pool.run(work, n_points, _length_of_ranges(spans, n_points))
    return None if declined else result


def _spans(corners: NDArray[Any], starts: NDArray[Any], survey: Callable[..., int]) -> NDArray[np.int64] | None:
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
