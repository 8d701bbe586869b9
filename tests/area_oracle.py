"""Integrals of powers of a cosine over regions of the unit sphere, by mpmath, for lights with a size.

A region is what caps {u: a·u >= b} have in common: half-spaces (b = 0) for the sides of a convex polygon and for the
horizon, one cap for a sphere. On the circle at the angle γ from w, each cap is an arc whose ends are arc cosines, so
the integral is one over γ, of cosᵏ γ sin γ times the length of the arcs' intersection, between the angles at which
circles touch or corners lie. No boundary integral comes up.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import mpmath as mp

_FEW = 1e-25


def exact_vector(values: Any) -> list[Any]:
    return [mp.mpf(float(x)) for x in values]


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a: Sequence[Any]) -> list[Any]:
    length = mp.sqrt(dot(a, a))
    return [x / length for x in a]


def minus(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    return [x - y for x, y in zip(a, b, strict=True)]


def angle(a: Sequence[Any], b: Sequence[Any]) -> Any:
    c = cross(a, b)
    return mp.atan2(mp.sqrt(dot(c, c)), dot(a, b))


def mirrored(n: Sequence[Any], v: Sequence[Any]) -> list[Any]:
    return unit([2 * dot(n, v) * x - y for x, y in zip(n, v, strict=True)])


def power_over(w: Sequence[Any], power: float, caps: Sequence[tuple[Sequence[Any], Any]]) -> Any:
    """∫ max(w·u, 0)ᵏ du over what the caps (a, b) have in common; w and all a of length 1."""
    if not power:  # 1 on the other side of w too
        return power_over(caps[0][0], 1e-300, caps)
    first = unit(cross(w, [1, 0, 0] if abs(w[0]) < 0.6 else [0, 1, 0]))
    second = cross(w, first)
    seen = [(angle(w, a), mp.atan2(dot(a, second), dot(a, first)), mp.mpf(b)) for a, b in caps]
    ends = sorted({x for x in _breaks(w, power, caps, seen) if 0 < x < mp.pi / 2})
    total = mp.mpf(0)
    for start, stop in zip([mp.mpf(0), *ends], [*ends, mp.pi / 2], strict=True):
        total += mp.quad(
            lambda gamma: max(mp.cos(gamma), 0) ** power * mp.sin(gamma) * _length([_arc(gamma, *cap) for cap in seen]),
            [start, stop],
        )
    return total


def _breaks(w: Any, power: float, caps: Any, seen: Any) -> Any:
    for middle, _, b in seen:
        yield from (abs(middle - mp.acos(b)), middle + mp.acos(b))
    for (a, b), (c, d) in combinations(caps, 2):  # corners: x·a = b, x·c = d, |x| = 1
        cosine, axis = dot(a, c), cross(a, c)
        square = dot(axis, axis)
        if square < _FEW:
            continue
        x = [((b - d * cosine) * p + (d - b * cosine) * q) / square for p, q in zip(a, c, strict=True)]
        rest = (1 - dot(x, x)) / square
        if rest > 0:
            for sign in (1, -1):
                yield angle(w, [p + sign * mp.sqrt(rest) * q for p, q in zip(x, axis, strict=True)])
    yield from (k / mp.sqrt(power + 1) for k in (1, 2, 4, 7, 11))


def _arc(gamma: Any, middle: Any, around: Any, b: Any) -> tuple[Any, Any] | None:
    """Middle and half length of the circle's arc in a cap; None where there is none."""
    spread = mp.sin(gamma) * mp.sin(middle)
    height = b - mp.cos(gamma) * mp.cos(middle)
    if abs(height) >= spread:
        return None if height > 0 else (mp.mpf(0), mp.pi)
    return around, mp.acos(height / spread)


def _length(arcs: Sequence[Any]) -> Any:
    """Of what arcs of a circle have in common."""
    if None in arcs:
        return mp.mpf(0)
    arcs = [arc for arc in arcs if arc[1] < mp.pi]
    if not arcs:
        return 2 * mp.pi
    (zero, half), *others = arcs
    pieces = [(-half, half)]
    for middle, half in others:
        shift = middle - zero
        shift -= 2 * mp.pi * mp.nint(shift / (2 * mp.pi))
        pieces = [
            (max(low, shift + turn - half), min(high, shift + turn + half))
            for low, high in pieces
            for turn in (-2 * mp.pi, 0, 2 * mp.pi)
        ]
        pieces = [(low, high) for low, high in pieces if low < high]
    return sum((high - low for low, high in pieces), mp.mpf(0))
