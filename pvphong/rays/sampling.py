"""How much of a light or of the sky is seen: as many rays for each vertex as its own error requires.

What is looked at is divided into nodes, in the order of a tree that halves them by place. Each vertex takes them in an
order of its own, in which the first 2^k nodes are one from each 2^k-th part of the tree: van der Corput's, scrambled as
Owen does it ("Randomly permuted (t,m,s)-nets", 1995) by a hash of the vertex's number, as Laine and Karras do
("Stratified sampling for stochastic transparency", 2011). So a vertex's rays depend on nothing else: not on the order
of vertices, on threads or on chunks; and no node is taken twice.

Two nodes from neighbouring parts of the tree see the same, except at the edge of a shadow. Their differences are
the standard error; it is on the large side (W. G. Cochran, "Sampling techniques", 1977, 5A.12, collapsed strata).

Most vertices see all of a light or nothing. They stop after 16 rays that agree, unless a vertex with which they share a
face saw something else: then a penumbra is near. Of the sky most see a part, be it a small one that is hidden: for it,
and where there are no faces, they stop after 64.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base import threads
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray

MOST_RAYS = 4096
"""The most rays from a vertex to one target, which is divided into so many nodes; a power of two."""

# So many where the number follows from the error.
_MOST_ADAPTIVE = 1024
# Rays of vertices that agree beside others that do not.
_NEAR_OTHERS = 64
_RAYS_AT_ONCE = 2**18
_GOING_ON_AT_ONCE = 2**11

Cast = Callable[[IntArray, IntArray], tuple[FloatArray, BoolArray]]
"""(vertices (m,), nodes (m, k)) → what each node sends there, and whether it is seen, (m, k) each."""


class Seen(NamedTuple):
    """What n vertices see."""

    part: Float64Array
    """Shape (n,), in [0, 1]: of what is sent."""
    error: Float64Array
    """Shape (n,): its standard error; 0 where all rays agree."""
    rays: int


def look(
    count: int,
    cast: Cast,
    triangles: NDArray[np.int64],
    *,
    tolerance: float,
    samples: int | None,
    brightness: float,
    least: int,
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
        Rays are cast until the standard error of what is seen is at most that.
    samples : int or None
        So many rays for every vertex in place of that: the next power of two, at most `MOST_RAYS`.
    brightness : float
        What is seen of all that nodes send, over the mean of it.
    least : int
        Rays that every vertex gets, a power of two.
    """
    is_adaptive = samples is None
    first = least if samples is None else min(1 << (samples - 1).bit_length(), MOST_RAYS)
    part, error, rays = np.zeros(count), np.zeros(count), np.zeros(count, np.int64)

    def go_on(vertices: IntArray, sent: FloatArray, seen: FloatArray) -> None:
        """Twice as many rays again and again, for those whose error is still too large."""
        done = first
        while len(vertices) and done < _MOST_ADAPTIVE:
            more = _cast_turns(cast, vertices, done, 2 * done)
            rays[vertices] += np.count_nonzero(more[0], axis=1)
            sent, seen = (np.concatenate(pair, axis=1) for pair in zip((sent, seen), more, strict=True))
            part[vertices], error[vertices] = _estimate(sent, seen)
            done *= 2
            bright = brightness * sent.mean(axis=1)
            is_unsure = (done < _NEAR_OTHERS) | (error[vertices] * bright > tolerance)
            vertices, sent, seen = vertices[is_unsure], sent[is_unsure], seen[is_unsure]

    def begin(start: int, stop: int) -> None:
        vertices = np.arange(start, stop)
        sent, seen = _cast_turns(cast, vertices, 0, first)
        rays[vertices] += np.count_nonzero(sent, axis=1)
        part[vertices], error[vertices] = _estimate(sent, seen)
        unsure = np.flatnonzero(error[start:stop] > 0.0) if is_adaptive else vertices[:0]
        for at in range(0, len(unsure), _GOING_ON_AT_ONCE):
            some = unsure[at : at + _GOING_ON_AT_ONCE]
            go_on(vertices[some], sent[some], seen[some])

    def begin_again(start: int, stop: int) -> None:
        go_on(near[start:stop], *_cast_turns(cast, near[start:stop], 0, first))

    threads.run(begin, count, max(_RAYS_AT_ONCE // first, 1))
    if not is_adaptive:
        return Seen(part, error, int(rays.sum()))
    is_near = np.ones(count, bool)  # in no triangle, or in one with a vertex that saw something else
    is_near[triangles] = False
    corners = part[triangles]
    is_near[triangles[corners.min(axis=1) != corners.max(axis=1)]] = True
    near = np.flatnonzero(is_near & ((part == 0.0) | (part == 1.0)))
    threads.run(begin_again, len(near), _GOING_ON_AT_ONCE)
    return Seen(part, error, int(rays.sum()) + first * len(near))


def _estimate(sent: FloatArray, seen: FloatArray) -> tuple[Float64Array, Float64Array]:
    """The part that is seen of what nodes send, (m, k) each: a ratio of means, and its standard error, (m,) each."""
    count = sent.shape[1]
    sum_sent, sum_seen = (each.sum(axis=1, dtype=np.float64) for each in (sent, seen))
    whole = np.where(sum_sent > 0.0, sum_sent, 1.0)
    part = np.clip(sum_seen / whole, 0.0, 1.0)
    if count == 1:
        return part, np.zeros(len(part))
    off = seen - part[:, None] * sent
    apart = off[:, : count // 2] - off[:, count // 2 :]  # halves the tree's parts, so pairs them with neighbours
    least = 0.25 * (sum_sent / count) ** 2  # where pairs happen to agree, though not all do
    error = np.sqrt(np.maximum((apart * apart).sum(axis=1), least)) / whole
    return part, np.where((part > 0.0) & (part < 1.0), error, 0.0)


def _cast_turns(cast: Cast, vertices: IntArray, begin: int, end: int) -> tuple[FloatArray, FloatArray]:
    """What the nodes from one turn to another send to vertices, and what of it these see, (m, end - begin) each."""
    step = max(_RAYS_AT_ONCE // max(len(vertices), 1), 1)
    parts = []
    for first in range(begin, end, step):
        sent, are_seen = cast(vertices, _nodes(vertices, np.arange(first, min(first + step, end))))
        parts.append((sent, np.where(are_seen, sent, sent.dtype.type(0.0))))
    sent, seen = (np.concatenate(each, axis=1) for each in zip(*parts, strict=True))
    return sent, seen


# For each number below `MOST_RAYS` that whose bits are its own, the last one first.
_BITS = MOST_RAYS.bit_length() - 1
_REVERSED = np.array([int(f"{number:0{_BITS}b}"[::-1], 2) for number in range(MOST_RAYS)])


def _nodes(vertices: IntArray, turns: IntArray) -> NDArray[np.int64]:
    """Which nodes vertices (m,) take in their turns (k,), shape (m, k)."""
    # numbers without any pattern, for vertices in any order (the mixing of splitmix64; Steele et al. 2014)
    z = (vertices.astype(np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    seed = ((z ^ (z >> np.uint64(31))) >> np.uint64(32)).astype(np.uint32)[:, None]
    x = np.broadcast_to(turns.astype(np.uint32), (len(vertices), len(turns))) + np.uint32(0)
    x ^= x * np.uint32(0x3D20ADEA)
    x += seed
    x *= (seed >> np.uint32(16)) | np.uint32(1)
    x ^= x * np.uint32(0x05526C56)
    x ^= x * np.uint32(0x53A22864)
    return _REVERSED[x & np.uint32(MOST_RAYS - 1)]


def in_tree_order(places: FloatArray) -> IntArray:
    """The order of places in a tree that halves them across their longest side, again and again."""
    order = np.arange(len(places))
    size = len(places)
    while size > 1:
        for begin in range(0, len(places), size):
            some = order[begin : begin + size]
            spans = np.ptp(places[some], axis=0)
            order[begin : begin + size] = some[np.argsort(places[some, np.argmax(spans)], kind="stable")]
        size = -(-size // 2)
    return order
