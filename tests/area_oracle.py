"""Integrals of powers of a cosine over regions of the unit sphere, by mpmath, for lights with a size.

A region is an intersection of caps {u: a·u >= b}: half-spaces (b = 0) for the sides of a convex polygon and for the
horizon, one cap for a sphere. On the circle at the angle γ from w, each cap is an arc whose ends are arc cosines. The
integral is therefore one over γ, of cosᵏ γ sin γ times the length of the arcs' intersection, split at the angles at
which circles touch or corners lie. A disk is integrated over its area, in strips along the horizon. No boundary
integral is used, unlike in the evaluators.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from itertools import combinations, pairwise
from typing import Any

import mpmath as mp
from mpmath.calculus.quadrature import GaussLegendre
from oracle import cross, dot, minus

_FEW = 1e-25
# Instead of 0⁰, which is 1.
_NO_POWER = 1e-300
# Corners outside a cap do not count; corners close to its edge may, because of rounding.
_BESIDE = 1e-6
# Ends of the pieces of a disk's strip, in lobe widths from the lobe's middle.
_WIDTHS = 3, 8


def exact_vector(values: Any) -> list[Any]:
    return [mp.mpf(float(x)) for x in values]


def unit(a: Sequence[Any]) -> list[Any]:
    length = mp.sqrt(dot(a, a))
    return [x / length for x in a]


def angle(a: Sequence[Any], b: Sequence[Any]) -> Any:
    c = cross(a, b)
    return mp.atan2(mp.sqrt(dot(c, c)), dot(a, b))


def power_over(w: Sequence[Any], power: float, caps: Sequence[tuple[Sequence[Any], Any]]) -> Any:
    """∫ max(w·u, 0)ᵏ du over the intersection of caps (a, b); w and all a of length 1."""
    if not power:  # 1 on the other side of w too
        return power_over(caps[0][0], _NO_POWER, caps)
    first = unit(cross(w, [1, 0, 0] if abs(w[0]) < 0.6 else [0, 1, 0]))
    second = cross(w, first)
    seen = [(angle(w, a), mp.atan2(dot(a, second), dot(a, first)), mp.mpf(b)) for a, b in caps]
    ends = sorted({x for x in _breaks(w, power, caps, seen) if 0 < x < mp.pi / 2})
    around = [(*mp.cos_sin(middle), turn, b) for middle, turn, b in seen]

    def arcs(gamma: Any) -> tuple[Any, list[Any]]:
        cosine, sine = mp.cos_sin(gamma)
        return (cosine**power if power > _NO_POWER else 1) * sine, [_arc(cosine, sine, *cap) for cap in around]

    def integrand(gamma: Any) -> Any:
        weight, found = arcs(gamma)
        return weight * _length(found)

    pieces = pairwise([mp.mpf(0), *ends, mp.pi / 2])
    # arcs appear and vanish at ends only
    return mp.fsum(mp.quad(integrand, piece) for piece in pieces if None not in arcs(sum(piece) / 2)[1])


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
                corner = [p + sign * mp.sqrt(rest) * q for p, q in zip(x, axis, strict=True)]
                if all(dot(corner, e) > f - _BESIDE for e, f in caps):
                    yield angle(w, corner)
    yield from (k / mp.sqrt(power + 1) for k in (1, 2, 4, 7, 11))


def _arc(cosine: Any, sine: Any, along: Any, aside: Any, around: Any, b: Any) -> tuple[Any, Any] | None:
    """Return the middle and half length of the circle's arc in a cap; None if they do not intersect."""
    spread = sine * aside
    height = b - cosine * along
    if abs(height) >= spread:
        return None if height > 0 else (mp.mpf(0), mp.pi)
    return around, mp.acos(height / spread)


def _length(arcs: Sequence[Any]) -> Any:
    """Return the length of the intersection of arcs of a circle."""
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


@cache
def _nodes(precision: int) -> list[tuple[Any, Any]]:
    """Return the 24 Gauss-Legendre nodes and their weights."""
    return GaussLegendre(mp.mp).calc_nodes(4, precision)


def _nodes_between(start: Any, stop: Any) -> Iterator[tuple[Any, Any]]:
    """Return Gauss-Legendre nodes on an interval, and their weights."""
    half = (stop - start) / 2
    for node, weight in _nodes(mp.mp.prec + 15):
        yield start + half * (1 + node), half * weight


def power_over_disk(w: Any, power: float, n: Any, middle: Any, facing: Any, radius: Any) -> Any:
    """∫ max(w·u, 0)ᵏ du over the part of a disk above the horizon; w, n and facing of length 1.

    A point of it is x = middle + s e₁ + t e₂, du = |middle · facing| ds dt / |x|³, and n·x is the same for all t. With
    s = radius · cos α strips end at ± radius · sin α, and everything is smooth between the horizon, the equator of w,
    and multiples of the lobe's width off where w goes.
    """
    height = dot(middle, facing)
    e2 = cross(facing, n)
    flat = dot(e2, e2) < _FEW
    e2 = unit(cross(facing, [1, 0, 0] if abs(facing[0]) < 0.6 else [0, 1, 0]) if flat else e2)
    e1 = cross(e2, facing)
    up, slope = dot(n, middle), 0 if flat else dot(n, e1)
    lowest = -radius if slope == 0 else max(-up / slope, -radius)  # e₁ is up
    if lowest >= radius or (flat and up <= 0):
        return mp.mpf(0)
    base, ahead, aside = dot(w, middle), dot(w, e1), dot(w, e2)
    strips, pieces = _marks(w, power, middle, facing, (e1, e2), radius)
    strips += _on_rim(base, ahead, aside, radius)
    ends = sorted({mp.mpf(0), mp.acos(lowest / radius), *(mp.acos(s / radius) for s in strips if lowest < s < radius)})
    total = mp.mpf(0)
    for start, stop in pairwise(ends):
        for alpha, weight in _nodes_between(start, stop):
            s, half = radius * mp.cos(alpha), radius * mp.sin(alpha)
            first, last, level = -half, half, base + s * ahead
            if power and aside:
                first, last = (max(first, -level / aside), last) if aside > 0 else (first, min(last, -level / aside))
            elif power and level <= 0:
                continue
            square = dot(middle, middle) + s * s + 2 * s * dot(middle, e1)
            slant = 2 * dot(middle, e2)
            for low, high in pairwise(sorted({first, last, *(t for t in pieces if first < t < last)})):
                for t, share in _nodes_between(low, high) if first < last else ():
                    far = mp.sqrt(square + t * (slant + t))
                    total += weight * half * share * ((level + t * aside) / far) ** power / far**3
    return total * abs(height)


def _marks(w: Any, power: float, middle: Any, facing: Any, plane: Any, radius: Any) -> tuple[list[Any], list[Any]]:
    """Return the ends of strips, and of their pieces, around the lobe's middle on the disk's plane."""
    along = dot(w, facing)
    far = dot(middle, facing) / along if along else mp.mpf(-1)
    if far <= 0:
        return [], []
    width = far / mp.sqrt(power + 1) / abs(along)
    goes = minus([far * x for x in w], middle)
    return tuple(
        [x for k in _WIDTHS for x in (dot(goes, e) - k * width, dot(goes, e) + k * width) if abs(x) < radius]
        for e in plane
    )


def _on_rim(base: Any, ahead: Any, aside: Any, radius: Any) -> list[Any]:
    """Return the s at which the line base + s · ahead + t · aside = 0 meets the rim."""
    square = ahead * ahead + aside * aside
    rest = square * radius * radius - base * base
    if rest <= 0:
        return []
    return [(-base * ahead + sign * aside * mp.sqrt(rest)) / square for sign in (1, -1)]
