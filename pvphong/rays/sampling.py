"""How much of a light or of the sky is seen: as many rays for each vertex as its own error requires.

Each vertex takes the points of Sobol's sequence one after the other, scrambled by a hash of its number
(`pvphong.base.sobol`). So a vertex's rays depend on nothing else: not on the order of vertices, on threads or on
chunks. The first 2ᵐ points are alone in squares of equal size, or in halves of such. The error of a part of which an
edge cuts some squares falls with the number of rays to the power ¾.

Two points whose squares are neighbours see the same, except at the edge of a shadow. Their differences are
the standard error; it is on the large side (W. G. Cochran, "Sampling techniques", 1977, 5A.12, collapsed strata).

Most vertices see all of a light or nothing. They stop after 16 rays that agree, unless a vertex with which they share a
face saw something else: then a penumbra is near, and rays that agree may have missed its last part. So these go on too,
until a part that so many miss is small enough. Of the sky most see a part, be it a small one that is hidden: for it,
and where there are no faces, they stop after 64.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base import sobol, threads
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.shading.visibility import Around

MOST_RAYS = sobol.MOST
"""The most rays from a vertex to one light; a power of two."""

# So many where the number follows from the error.
_MOST_ADAPTIVE = 1024
# The least of vertices that go on: of those in no face where rays agree, and beside others that saw something else.
_LEAST_THAT_GO_ON = 64
# Vertices that go on at once, over all threads: what their rays saw takes 64 MB at most.
_GOING_ON_AT_ONCE = 2**11


# Rays that compiled code tests together.
_AT_ONCE = 16


class Cast(NamedTuple):
    """What rays to points of a light, of the same numbers for each of some vertices, found."""

    sent: FloatArray
    """Shape (k, m), float32: what each of k points sends to each vertex, but for a factor."""
    seen: FloatArray
    """That, or 0 where the point is hidden."""
    scale: Float64Array
    """Shape (m,): the factor that makes a mean of what is sent a colour."""
    rays: int


CastRays = Callable[[IntArray, int, int], Cast]
"""Casts rays from vertices (m,) to the points from one number to another."""


class Seen(NamedTuple):
    """What n vertices see."""

    part: Float64Array
    """Shape (n,), in [0, 1]: of what is sent."""
    error: Float64Array
    """Shape (n,): its standard error; 0 where all rays agree, unless what is seen around was given and is different."""
    rays: int
    is_unknown: BoolArray | None = None
    """Shape (n,): where no ray was sent that could arrive; the part is 0 there. None where that is not told."""


def look(
    count: int,
    cast: CastRays,
    triangles: NDArray[np.int64],
    *,
    tolerance: float,
    samples: int | None,
    brightness: float,
    least: int,
    rays_at_once: int,
    around: Around | None = None,
) -> Seen:
    """The part that each of `count` vertices sees.

    Parameters
    ----------
    count : int
        Of vertices.
    cast : callable
        Casts rays.
    triangles : ndarray
        Shape (m, 3): which vertices share a face.
    tolerance : float
        Rays are cast until the standard error of the colour is at most that.
    samples : int or None
        So many rays for every vertex in place of that: the next power of two, at most `MOST_RAYS`.
    brightness : float
        Of the light: a factor of its colours.
    least : int
        Rays that every vertex gets, a power of two.
    rays_at_once : int
        So many that a thread casts before it can be interrupted, about.
    around : Around, optional
        What is known around the vertices, where there are no triangles.
    """
    is_adaptive = samples is None
    first = least if samples is None else min(1 << (samples - 1).bit_length(), MOST_RAYS)
    part, error, rays, is_unknown = np.zeros(count), np.zeros(count), list[int](), np.zeros(count, bool)
    is_alone, goal = np.ones(count, bool), None if around is None else around.goal
    is_alone[triangles] = False

    def cast_points(vertices: IntArray, begin: int, end: int) -> tuple[FloatArray, FloatArray, Float64Array]:
        step = max(rays_at_once // max(len(vertices), 1) // _AT_ONCE, 1) * _AT_ONCE
        parts = list[Cast]()
        for start in range(begin, end, step):
            threads.go_on()
            parts.append(cast(vertices, start, min(start + step, end)))
        rays.extend(each.rays for each in parts)
        return np.concatenate([p.sent for p in parts]), np.concatenate([p.seen for p in parts]), parts[0].scale

    def estimate(vertices: IntArray, sent: FloatArray, seen: FloatArray, is_at_edge: BoolArray) -> None:
        """Without an error where rays agree, but for those that may be at the edge of a penumbra."""
        found, its_error = _estimate(sent, seen)
        part[vertices] = found
        error[vertices] = np.where((found > 0.0) & (found < 1.0) | is_at_edge, its_error, 0.0)
        is_unknown[vertices] = ~sent.any(axis=0)

    def at_edge(vertices: IntArray) -> BoolArray:
        """Those around which something else is seen than rays that agree said."""
        if around is None:
            return ~is_alone[vertices]
        return (around.least[vertices] != part[vertices]) | (around.most[vertices] != part[vertices])

    def go_on(vertices: IntArray, sent: FloatArray, seen: FloatArray) -> None:
        """Twice as many rays again and again, for those whose error is still too large."""
        done = first
        while len(vertices) and done < _MOST_ADAPTIVE:
            more_sent, more_seen, scale = cast_points(vertices, done, 2 * done)
            sent, seen = np.concatenate([sent, more_sent]), np.concatenate([seen, more_seen])
            estimate(vertices, sent, seen, at_edge(vertices))
            done *= 2
            bright = brightness * scale * sent.mean(axis=0)
            is_sure = error[vertices] * bright <= tolerance
            if goal is not None:
                is_sure |= goal.at(vertices).is_reached(part[vertices], error[vertices])
            is_unsure = ~is_sure if done >= _LEAST_THAT_GO_ON else np.ones(len(vertices), bool)
            vertices, sent, seen = vertices[is_unsure], sent[:, is_unsure], seen[:, is_unsure]

    at_once = max(_GOING_ON_AT_ONCE // threads.count(), 1)

    def begin(start: int, stop: int) -> None:
        vertices = np.arange(start, stop)
        sent, seen, _ = cast_points(vertices, 0, first)
        estimate(vertices, sent, seen, np.zeros(len(vertices), bool))
        unsure = np.flatnonzero((error[start:stop] > 0.0) | is_alone[start:stop]) if is_adaptive else vertices[:0]
        for at in range(0, len(unsure), at_once):
            some = unsure[at : at + at_once]
            go_on(vertices[some], sent[:, some], seen[:, some])

    def begin_again(start: int, stop: int) -> None:
        sent, seen, _ = cast_points(near[start:stop], 0, first)
        go_on(near[start:stop], sent, seen)

    threads.run(begin, count, max(rays_at_once // first, 1))
    if not is_adaptive:
        return Seen(part, error, sum(rays), is_unknown)
    is_near = np.zeros(count, bool)
    corners = part[triangles]
    is_near[triangles[corners.min(axis=1) != corners.max(axis=1)]] = True
    near = np.flatnonzero(is_near & ((part == 0.0) | (part == 1.0)))
    threads.run(begin_again, len(near), at_once)
    if around is None:
        error[(part == 0.0) | (part == 1.0)] = 0.0
    return Seen(part, error, sum(rays), is_unknown)


def _estimate(sent: FloatArray, seen: FloatArray) -> tuple[Float64Array, Float64Array]:
    """The part that is seen of what points send, (k, m) each: a ratio of means, and its standard error, (m,) each."""
    count = len(sent)
    folds = -1, min(count, _AT_ONCE), sent.shape[1]  # so that sums of float32 keep their digits
    sum_sent, sum_seen = (each.reshape(folds).sum(axis=1).sum(axis=0, dtype=np.float64) for each in (sent, seen))
    whole = np.where(sum_sent > 0.0, sum_sent, 1.0)
    part = np.clip(sum_seen / whole, 0.0, 1.0)
    off = seen - part.astype(np.float32) * sent
    numbers, apart = np.arange(count), sobol.NEIGHBOURS[count.bit_length() - 1]
    one = numbers[numbers < numbers ^ apart]
    difference = off[one] - off[one ^ apart]
    least = 0.25 * (sum_sent / count) ** 2  # where neighbours happen to agree, or all do
    error = np.sqrt(np.maximum((difference * difference).sum(axis=0), least)) / whole
    return part, np.where(sum_sent > 0.0, error, 0.0)
