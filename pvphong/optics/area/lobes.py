"""Integrals of powers of a cosine over regions of the unit sphere, as integrals along their boundaries.

With z = w·u for unit vectors w and u, du the solid angle of u, and φ the angle around w, Green's theorem gives for any
real k >= 0

    ∫ max(z, 0)ᵏ du = 1/p · ∮ (1 − max(z, 0)ᵖ) dφ,    p = k + 1

counter-clockwise around a region that does not contain −w (Arvo 1995 gives a recurrence for integer k).

Along a great circle, dφ has the factor 1/(1 − z²). The quotient (1 − zᵖ)/(1 − z²) is regular at z = 1. Far from there,
zᵖ is nearly 0, and the integral is an angle. So a few Gauss-Legendre nodes within the lobe, and arc tangents elsewhere,
give the integral up to rounding.
"""

from __future__ import annotations

import math
from functools import cache, lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np

from pvphong.base.formulas import (
    any_of,
    arctan2,
    cosine,
    cross,
    dot,
    formula,
    maximum,
    minimum,
    nearest,
    power_less_one,
    select,
    sine,
    sqrt,
    subtract,
    times,
)
from pvphong.base.types import Float64Array


class CosinePower(NamedTuple):
    """Factor max(a·l, 0)ᵏ by which a part of a reflectance, called a lobe, multiplies light from the direction l.

    Formulas integrate this factor over area lights. It is 0 where n·l <= 0, with n the normal.
    """

    around: Literal["normal", "mirror"]
    """The vector a: the normal, or the direction to the viewer mirrored at the normal."""

    power: float
    """The exponent k, >= 0."""


# Layout of a lobe's numbers:
# - POWER and RAISED: k and p;
# - NOTHING, WINDOW and BEYOND: the cutoff beyond which the lobe is taken as 0, as 1 − z, as an angle, and as 1 − zᵖ;
# - POINT: the angular size below which the lobe treats a light as a point;
# - PIECE: half the angle on a rim that the nodes resolve;
# - SHORT: half the longest arc for which the smaller set of nodes suffices;
# - FEW and FEW_NODES: the number of nodes in the smaller set, and the index of the first;
# - COUNT: the number of nodes in the larger set;
# - from NODES: the nodes on [−1, 1] of the larger set, then of the smaller one, alternating with their weights.
POWER, RAISED, NOTHING, WINDOW, BEYOND, POINT, PIECE, SHORT, FEW, FEW_NODES, COUNT, NODES = range(12)

SMOOTH_FROM = 8.0
"""Least power p whose integrands are smooth. Integrands of lower powers are not smooth on the equator of w, so nodes
are denser there."""


class _Accuracy(NamedTuple):
    """Numbers that define how accurately a lobe zᵖ is integrated. The lobe's value at its middle is 1."""

    nothing: float
    """The zᵖ below which a smooth lobe is taken as 0."""
    nodes: int
    """Number of nodes along an arc for a smooth lobe. Such a lobe is nearly a Gaussian, cut off at `nothing`."""
    crowded_nodes: int
    """Number of nodes for powers below `SMOOTH_FROM`."""
    piece: float
    """Half the length of a curve that the nodes resolve, in lobe widths 1/√p."""
    point: float
    """The angular size, in lobe widths, below which a region is replaced by its middle."""
    few_nodes: int
    """Number of nodes along an arc of at most two lobe widths."""


# The zᵖ below which a lobe is taken as 0 for powers below `SMOOTH_FROM`, in both accuracies.
_NOTHING_AT_LOW_POWERS = 1e-16
# The errors of integrals are about 1e-11; for results in float32, about 1e-7.
_EXACT, _ROUNDED = _Accuracy(1e-12, 32, 64, 5.0, 4e-5, 12), _Accuracy(1e-7, 12, 24, 3.0, 5e-4, 6)


@cache
def gauss_legendre(count: int) -> tuple[Float64Array, Float64Array]:
    """Return the nodes, in [−1, 1], and the weights of Gauss-Legendre quadrature with `count` nodes."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights


@lru_cache(maxsize=128)
def lobe_numbers(power: float, *, rounded: bool = False) -> tuple[float, ...]:
    """Return the numbers by which formulas integrate the lobe max(z, 0)ᵏ, with k = `power`.

    A comment at the beginning of the file describes their layout. By default, the numbers suit results in float64. If
    `rounded`, they suit results in float32, with fewer quadrature nodes.
    """
    accuracy, raised = _ROUNDED if rounded else _EXACT, power + 1.0
    is_smooth = raised >= SMOOTH_FROM
    least = accuracy.nothing if is_smooth else _NOTHING_AT_LOW_POWERS
    nothing, width = -math.expm1(math.log(least) / raised), 1.0 / math.sqrt(raised)
    nodes, weights = gauss_legendre(accuracy.nodes if is_smooth else accuracy.crowded_nodes)
    if not is_smooth:
        nodes, weights = 0.5 * nodes * (3.0 - nodes * nodes), 1.5 * weights * (1.0 - nodes * nodes)
    few = np.stack(gauss_legendre(accuracy.few_nodes), axis=1)
    piece = accuracy.piece * min(width, 0.14)  # the other factors of an integrand are smooth over this angle
    own = power, raised, nothing, math.acos(1.0 - nothing), 1.0 - least, accuracy.point * width, piece
    counts = width if is_smooth else 0.0, float(len(few)), float(NODES + 2 * len(nodes)), float(len(nodes))
    return (*own, *counts, *np.stack([nodes, weights], axis=1).ravel().tolist(), *few.ravel().tolist())


@formula
def great_arc(lobe: Any, along: Any, across: Any, first: Any, length: Any) -> Any:
    """Integrate (1 − max(z, 0)ᵖ) dφ along arcs of great circles, counter-clockwise around their poles m.

    z is the cosine with the lobe's axis w, and φ the angle around w. At the angle y from the point closest to w,
    z = across · cos y and dφ = along · dy / (1 − z²). With pole = 1 − across, 1 − z is
    pole + 2 across sin² y/2; both are computed without cancellation. If only one long side of a thin light is beyond
    the lobe's cutoff, a step of zᵖ at the cutoff would be as large as the integral. So beyond the cutoff zᵖ keeps its
    value at the cutoff.

    Parameters
    ----------
    lobe : sequence of float
        From `lobe_numbers`.
    along, across
        The products w·m and |w × m|.
    first, length
        Start of the arc, measured from the point closest to w; and its length, which is less than π; in radians.
    """
    middle = first + 0.5 * length
    middle = middle - 2.0 * math.pi * nearest(middle * (0.5 / math.pi))
    first, last = middle - 0.5 * length, middle + 0.5 * length
    pole = along * along / (1.0 + across)
    square = minimum(
        maximum(0.5 * (lobe[NOTHING] - pole) / maximum(across, 1e-300), 0.0), 0.5
    )  # sin² of half the window
    window = 2.0 * arctan2(sqrt(square), sqrt(1.0 - square))
    start, stop = minimum(maximum(first, -window), window), minimum(maximum(last, -window), window)
    is_shown_all = (start <= first) & (stop >= last)
    shown = select(is_shown_all, length, stop - start)  # the difference of the ends cancels for short arcs
    total = 0.0 * shown
    if any_of(shown > 0.0):
        center, half = 0.5 * (start + stop), 0.5 * shown
        is_short = half <= lobe[SHORT]
        if any_of(is_short):
            total = _by_nodes(lobe, int(lobe[FEW_NODES]), int(lobe[FEW]), pole, across, center, half)
        if any_of(~is_short):
            by_all = _by_nodes(lobe, NODES, int(lobe[COUNT]), pole, across, center, half)
            total = select(is_short, total, by_all)
        total = total * along * half
    if any_of(~is_shown_all):
        rise = abs(along)
        rest = lobe[BEYOND] * (_turn(rise, first, last, length) - _turn(rise, start, stop, shown))
        total = total + select(is_shown_all, 0.0, select(along < 0.0, -rest, rest))
    return total


@formula
def _by_nodes(lobe: Any, at: int, count: int, pole: Any, across: Any, center: Any, half: Any) -> Any:
    """Compute twice the mean of (1 − max(z, 0)ᵖ) / (1 − z²) over an arc of a great circle, by quadrature.

    z is the cosine with the lobe's axis w.

    Parameters
    ----------
    lobe : sequence of float
        From `lobe_numbers`.
    at, count : int
        Index in `lobe` of the first node, and number of nodes.
    pole, across
        1 − |w × m| and |w × m| for the arc's pole m.
    center, half
        Middle of the arc, measured from the point closest to w; and half its length.
    """
    total = 0.0 * half
    for k in range(count):
        height = sine(0.5 * (center + half * lobe[at + 2 * k]))
        less = maximum(pole + 2.0 * across * height * height, 1e-300)
        total = total - lobe[at + 2 * k + 1] * power_less_one(less, lobe[RAISED]) / (less * (2.0 - less))
    return total


@formula
def _turn(rise: Any, first: Any, last: Any, length: Any) -> Any:
    """Integrate dφ along an arc of a great circle with the pole m; φ is the angle around the lobe's axis w.

    Parameters
    ----------
    rise
        The absolute value |w·m|.
    first, last, length
        Start and end of the arc, measured from the point closest to w, and the difference of both; in radians.
    """
    level = rise * rise * cosine(first) * cosine(last) + sine(first) * sine(last)
    return arctan2(rise * sine(length), level)


@formula
def arc_between(lobe: Any, w: Any, x: Any, y: Any, side: Any) -> Any:
    """Integrate (1 − max(z, 0)ᵖ) dφ along the great-circle arc from the direction of x to that of y, by `great_arc`.

    z is the cosine with the lobe's axis w, and φ the angle around w. `lobe` is from `lobe_numbers`. `side` is the
    vector y − x; it is an argument, because digits would cancel in the difference of x and y.
    """
    across = cross(x, side)
    length = sqrt(dot(across, across))
    m = times(across, 1.0 / maximum(length, 1e-300))
    ahead = cross(m, w)
    seen, first = arctan2(length, dot(x, y)), arctan2(dot(x, ahead), dot(x, w))
    return great_arc(lobe, dot(w, m), sqrt(dot(ahead, ahead)), first, seen)


@formula
def shows(lobe: Any, w: Any, m: Any, distance: Any, size: Any) -> Any:
    """Return True if a lobe may reach a sphere.

    `lobe` is from `lobe_numbers`, w is the lobe's axis, and m the offset from the vertex to the sphere's centre.
    `distance` is |m|, and `size` the sphere's radius. With α the angle between w and m, β the angular radius of the
    sphere, and ω the lobe's cutoff angle, the lobe may reach the sphere if sin(α − β − ω) < 0. The result is True for
    NaN, and for a vertex inside the sphere.
    """
    aside, ahead = cross(w, m), dot(w, m)
    off, clear = sqrt(dot(aside, aside)), sqrt(maximum((distance - size) * (distance + size), 0.0))
    cosine_of_end, sine_of_end = 1.0 - lobe[NOTHING], sqrt(lobe[NOTHING] * (2.0 - lobe[NOTHING]))
    sine_less, cosine_less = off * clear - ahead * size, ahead * clear + off * size  # of α − β, times |m|²
    return ~(size < distance) | (sine_less * cosine_of_end < cosine_less * sine_of_end)


@formula
def may_rise(n: Any, m: Any, size: Any) -> Any:
    """Return True if a sphere may be partly above the horizon of a vertex.

    n is the vertex's normal, m the offset from the vertex to the sphere's centre, and `size` the sphere's radius. The
    result is True for NaN, and for an infinite radius, such as that of a sky.
    """
    return ~(dot(n, m) <= -size)


@formula
def is_whole(n: Any, m: Any, size: Any) -> Any:
    """Return True if a sphere is entirely above the horizon of a vertex.

    n is the vertex's normal, m the offset from the vertex to the sphere's centre, and `size` the sphere's radius.
    """
    return dot(n, m) > size


@formula
def seen_as_point(lobe: Any, e: Any, w: Any, x: Any) -> Any:
    """Integrate max(w·u, 0)ᵏ du over the directions u to a small flat area at the offset x; divide by the area.

    `lobe` is from `lobe_numbers` and has the exponent k. e is the normal of the area, and w the lobe's axis.
    """
    square = dot(x, x)
    inverse = 1.0 / sqrt(maximum(square, 1e-300))
    gap = subtract(times(x, inverse), w)
    return (1.0 + power_less_one(0.5 * dot(gap, gap), lobe[POWER])) * abs(dot(e, x)) * inverse * inverse * inverse


@formula
def whole(turned: Any) -> Any:
    """Return the boundary integral around a region; `turned` is the sum of the integrals along its arcs.

    If the region contains −w, the sum lacks a full turn and is negative. Then 2π is added.
    """
    return maximum(select(turned < -1.0, turned + 2.0 * math.pi, turned), 0.0)
