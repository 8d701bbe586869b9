"""How much of a light or of the sky is seen: as many rays for each vertex as its own error asks for.

What is looked at is divided into nodes. Eight independent series of them are followed for each vertex, each in an order
in which every beginning is spread evenly: the nodes stand in the order of a tree that halves them by place, and are
taken by reversed bits of their numbers (van der Corput), shifted by a hash of the vertex's number and the series'. So
a vertex's rays depend on nothing else: not on the order of vertices, on threads or on chunks. How far the eight means
are apart is the standard error.

Most vertices see all or nothing. They stop after 16 rays that agree, unless a vertex with which they share a face saw
something else: then a penumbra is near.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.shading.kernel import pool

NODES = 1024
"""Into so many a light with a size is divided, and the sky: a power of two."""

_SERIES = 8
_FIRST = 2 * _SERIES
# Rays of vertices that agree beside others that do not.
_NEAR_OTHERS = 8 * _SERIES
_RAYS_AT_ONCE = 2**18

Ask = Callable[[IntArray, IntArray], tuple[FloatArray, BoolArray]]
"""(vertices (m,), nodes (m, k)) → what each node sends there, and whether it is seen, (m, k) each."""


class Seen(NamedTuple):
    """What n vertices see."""

    part: Float64Array
    """Shape (n,), in [0, 1]: of what is sent."""
    error: Float64Array
    """Shape (n,): its standard error; 0 where all rays agree."""
    rays: int


class _Sums(NamedTuple):
    """For each vertex and series."""

    sent: Float64Array
    seen: Float64Array


def look(
    count: int,
    ask: Ask,
    tolerance: float,
    samples: int | None,
    triangles: NDArray[np.int64],
    brightness: float = 1.0,
) -> Seen:
    """The part that each of `count` vertices sees.

    Parameters
    ----------
    count : int
        Of vertices.
    ask : callable
        Casts rays.
    tolerance : float
        Rays are cast until the standard error of what is seen, not of its part, is at most that.
    samples : int or None
        So many rays for every vertex in place of that, rounded up to a multiple of 8; at most 8192.
    triangles : ndarray
        Shape (m, 3): which vertices share a face.
    brightness : float
        What is seen per unit of what nodes send, where all of them are seen.
    """
    part, error, rays = np.zeros(count), np.zeros(count), np.zeros(count, np.int64)
    unclear = np.zeros(count, bool)
    whole = samples and -(-samples // _SERIES)
    start = whole or _FIRST // _SERIES

    def first(begin: int, end: int) -> None:
        vertices = np.arange(begin, end)
        sums = _followed(vertices, ask, 0, start)
        part[begin:end], error[begin:end] = _estimate(sums, start)
        rays[begin:end] = np.where(sums.sent.any(axis=1), start * _SERIES, 0)
        unclear[begin:end] = error[begin:end] > 0.0

    pool.run(first, count, max(_RAYS_AT_ONCE // (start * _SERIES), 1))
    if whole:
        return Seen(part, error, int(rays.sum()))
    near = _near_others(part, triangles)
    goes_on = np.flatnonzero(unclear | near)

    def more(begin: int, end: int) -> None:
        vertices = goes_on[begin:end]
        sums, done = _followed(vertices, ask, 0, start), start
        left = np.arange(len(vertices))
        while len(left) and done < NODES // _SERIES:
            now = vertices[left]
            added = _followed(now, ask, done, 2 * done)
            sums.sent[left] += added.sent
            sums.seen[left] += added.seen
            done *= 2
            some = _Sums(sums.sent[left], sums.seen[left])
            part[now], error[now] = _estimate(some, done)
            rays[now] = done * _SERIES
            sent = brightness * some.sent.sum(axis=1) / (done * _SERIES)
            is_enough = (error[now] > 0.0) | (done * _SERIES >= _NEAR_OTHERS)
            left = left[~(is_enough & (error[now] * sent <= tolerance))]

    pool.run(more, len(goes_on), 2**12)
    return Seen(part, error, int(rays.sum()) + start * _SERIES * len(goes_on))


def _followed(vertices: IntArray, ask: Ask, begin: int, end: int) -> _Sums:
    """Sums over the nodes of all series from one place in them to another."""
    sent, seen = np.zeros((len(vertices), _SERIES)), np.zeros((len(vertices), _SERIES))
    shifts = _hashed(vertices[:, None] * _SERIES + np.arange(_SERIES))[:, :, None]
    step = max(_RAYS_AT_ONCE // max(len(vertices) * _SERIES, 1), 1)
    for first in range(begin, end, step):
        turns = np.arange(first, min(first + step, end))
        nodes = (_reversed_bits(turns) ^ shifts) % NODES
        weights, are_seen = ask(vertices, nodes.reshape(len(vertices), -1))
        sent += weights.reshape(nodes.shape).sum(axis=2)
        seen += np.where(are_seen, weights, 0.0).reshape(nodes.shape).sum(axis=2)
    return _Sums(sent, seen)


def _estimate(sums: _Sums, length: int) -> tuple[Float64Array, Float64Array]:
    """The part that is seen, and its standard error: that of a ratio of means (Cochran, Sampling Techniques, 1977)."""
    sent, seen = sums.sent.sum(axis=1), sums.seen.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.where(sent > 0.0, seen / sent, 0.0)
        off = sums.seen - part[:, None] * sums.sent
        error = np.sqrt((off * off).sum(axis=1) * (_SERIES / (_SERIES - 1.0))) / sent
    is_mixed = (part > 0.0) & (seen < sent)
    # eight means that happen to be equal say nothing finer than what so many rays can tell
    return np.clip(part, 0.0, 1.0), np.where(is_mixed, np.maximum(error, 0.25 / (length * _SERIES)), 0.0)


def _near_others(part: Float64Array, triangles: NDArray[np.int64]) -> BoolArray:
    """Vertices that share a triangle with one that saw something else."""
    result = np.zeros(len(part), bool)
    corners = part[triangles]
    result[triangles[(corners.min(axis=1) != corners.max(axis=1))] if len(triangles) else triangles] = True
    return result


def _hashed(numbers: IntArray) -> NDArray[np.int64]:
    """Numbers without any pattern, for numbers in any order (the mixing of splitmix64; Steele et al. 2014)."""
    z = numbers.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return ((z ^ (z >> np.uint64(31))) >> np.uint64(40)).astype(np.int64)


def _reversed_bits(turns: IntArray) -> NDArray[np.int64]:
    """The bits of a number below `NODES`, the last one first."""
    result = np.zeros(len(turns), np.int64)
    bits = NODES.bit_length() - 1
    for bit in range(bits):
        result |= ((turns >> bit) & 1) << (bits - 1 - bit)
    return result


def in_tree_order(places: FloatArray) -> IntArray:
    """The order in which places stand in a tree that halves them across their longest side, again and again."""
    order = np.arange(len(places))
    size = len(places)
    while size > 1:
        for begin in range(0, len(places), size):
            some = order[begin : begin + size]
            spans = np.ptp(places[some], axis=0)
            order[begin : begin + size] = some[np.argsort(places[some, np.argmax(spans)], kind="stable")]
        size = -(-size // 2)
    return order
