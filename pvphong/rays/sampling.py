"""Adaptive sampling of the visible part of a light or of the sky: the error of each vertex sets its number of rays.

Each vertex uses the points of the Sobol sequence in order, scrambled by a hash of the vertex's number
(`pvphong.base.sobol`). So a vertex's rays do not depend on the order of vertices, on threads or on chunks. For even m,
the square is divided into 2ᵐ equal squares, and each contains one of the first 2ᵐ points. For odd m, each half of such
a square contains one. If an edge cuts some of the squares, the error of the visible part falls with the number of rays
to the power ¾.

Points in neighbouring squares see the same, except at the edge of a shadow. Their differences give the standard error,
a conservative estimate (W. G. Cochran, "Sampling techniques", 1977, 5A.12, collapsed strata).

Most vertices see all of a light or nothing. For such a vertex, 16 rays that agree are enough. But if a neighbour on the
same face sees another part, the vertex may be in a penumbra, and 16 rays can miss a small part of the light. Then more
rays are cast, until the part that they can miss is small enough. The least number of rays is 64 for points without
faces and for the sky, because most vertices see a part of the sky, and even a small part may be hidden.
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
"""Largest number of rays from a vertex to one light; a power of two."""

# Largest number of rays if the error sets the number.
_MOST_ADAPTIVE = 1024
# Least number of rays, even if they agree, for vertices without a face, and for vertices next to one that sees more or
# less of the light.
_LEAST_THAT_GO_ON = 64
# Number of vertices that continue at once, over all threads: their rays take at most 64 MB.
_GOING_ON_AT_ONCE = 2**11


# Number of rays that compiled code tests together.
_AT_ONCE = 16


class Cast(NamedTuple):
    """Result of casting rays from m vertices to k points of a light.

    The points have the same k numbers of the Sobol sequence for all vertices.
    """

    sent: FloatArray
    """Unoccluded contribution of each point to each vertex, up to a factor that depends on the vertex, shape (k, m),
    float32."""
    seen: FloatArray
    """Contribution with occlusion: as `sent`, or 0 where the point is hidden."""
    scale: Float64Array
    """Factor that turns a mean of contributions into a colour, shape (m,)."""
    rays: int


CastRays = Callable[[IntArray, int, int], Cast]
"""Function of vertices, shape (m,), and numbers `begin` and `end`. It casts rays from each vertex to the sample points
from number `begin` (inclusive) to `end` (exclusive)."""


class Seen(NamedTuple):
    """Visibility of a light or the sky at n vertices."""

    part: Float64Array
    """Visible part of the light's contribution, in [0, 1], shape (n,)."""
    error: Float64Array
    """Standard error of `part`, shape (n,). It is 0 where all rays agree and no bound in `Around` differs."""
    rays: int
    is_unknown: BoolArray | None = None
    """True where no ray had a contribution, so that `part` is 0, shape (n,). The array is None if this was not
    recorded."""


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
    """Compute the visible part of a light or of the sky for each of `count` vertices.

    Parameters
    ----------
    count : int
        Number of vertices.
    cast : callable
        Casts rays from some vertices to some points of the light; see `CastRays`.
    triangles : ndarray
        Shape (m, 3): the vertices of each face.
    tolerance : float
        Rays are cast until the standard error of the colour is at most the tolerance.
    samples : int or None
        Fixed number of rays per vertex, used instead of the tolerance. It is rounded up to a power of two, and is at
        most `MOST_RAYS`.
    brightness : float
        Brightness of the light. It multiplies the visible part to give a colour.
    least : int
        Least number of rays per vertex, a power of two.
    rays_at_once : int
        Approximate number of rays that a thread casts between checks for interruption.
    around : Around, optional
        Known bounds on the visibility around the vertices, if there are no triangles.
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
        """Record the visible parts of vertices, and their errors, from the weights `sent` and `seen` of their rays.

        Where all rays agree, the error is 0, except at vertices for which `is_at_edge` is True.
        """
        found, its_error = _estimate(sent, seen)
        part[vertices] = found
        error[vertices] = np.where((found > 0.0) & (found < 1.0) | is_at_edge, its_error, 0.0)
        is_unknown[vertices] = ~sent.any(axis=0)

    def at_edge(vertices: IntArray) -> BoolArray:
        """Return True for each vertex whose neighbours may see more or less of the light than the vertex does."""
        if around is None:
            return ~is_alone[vertices]
        return (around.least[vertices] != part[vertices]) | (around.most[vertices] != part[vertices])

    def go_on(vertices: IntArray, sent: FloatArray, seen: FloatArray) -> None:
        """Double the number of rays repeatedly for vertices whose error is too large.

        `sent` and `seen` are the weights of the first rays. The doubling ends at `_MOST_ADAPTIVE` rays per vertex, even
        if the error is still too large.
        """
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
    """Return the visible part from each of m vertices, a ratio of means, and its standard error, shape (m,) each.

    `sent` and `seen`, shape (k, m), are the contributions of k points of the light without and with occlusion, as in
    `Cast`.
    """
    count = len(sent)
    folds = -1, min(count, _AT_ONCE), sent.shape[1]  # partial sums keep the digits of float32
    sum_sent, sum_seen = (each.reshape(folds).sum(axis=1).sum(axis=0, dtype=np.float64) for each in (sent, seen))
    whole = np.where(sum_sent > 0.0, sum_sent, 1.0)
    part = np.clip(sum_seen / whole, 0.0, 1.0)
    off = seen - part.astype(np.float32) * sent
    numbers, apart = np.arange(count), sobol.NEIGHBOURS[count.bit_length() - 1]
    one = numbers[numbers < numbers ^ apart]
    difference = off[one] - off[one ^ apart]
    least = 0.25 * (sum_sent / count) ** 2  # where neighbours agree by chance, or all agree
    error = np.sqrt(np.maximum((difference * difference).sum(axis=0), least)) / whole
    return part, np.where(sum_sent > 0.0, error, 0.0)
