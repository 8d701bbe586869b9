"""Integrals of powers of a cosine over regions of the unit sphere, as integrals along their boundaries.

With z = w·u for a unit vector w and φ the angle around it, Green's theorem gives for any real n >= 0

    ∫ max(z, 0)ⁿ du = 1/(n + 1) · ∮ (1 − max(z, 0)ⁿ⁺¹) dφ

counter-clockwise around a region without −w (Arvo 1995 has it for whole n, by recurrence). Along a circle 1 − zⁿ⁺¹ and
dφ are regular where z is 1, once 1 − z² is divided out of their product; away from there zⁿ⁺¹ is next to 0, and what is
left is the angle. So some Gauss-Legendre nodes where the power shows, and arc tangents elsewhere, are exact.

Symbols: a the angular radius of a cap around the unit vector l, s and C its sine and cosine, c = n·l the cosine between
it and the normal n of the horizon. Arrays are float64, (m,) for m regions, vectors (3, m).
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np

from pvphong.base.types import Float64Array
from pvphong.base.vectors import dot, square_of_cross


class CosinePower(NamedTuple):
    """A lobe's factor max(a·l, 0)ᵏ where n·l > 0, as integrals over a light know it."""

    around: Literal["normal", "mirror"]
    """What a is: the normal, or the direction to the viewer mirrored at it."""

    power: float
    """The k, >= 0."""


# Powers below it are left out.
_NOTHING = 1e-12
# Nodes that are exact to 1e-12 on a Gaussian that is cut off there, and on half of one.
_NODES, _HALF_NODES = 32, 24
ROUGH = 8.0
"""Below this power, integrands are not smooth on the equator of w."""

# Regions of a smaller angular size lose digits along their boundary, but are flat, and powers smooth there, if they are
# at the same time a fraction of a lobe's width.
_TINY, _FRACTION = 1e-5, 0.02
_SERIES = 0.1


@cache
def gauss_legendre(count: int) -> tuple[Float64Array, Float64Array]:
    """Nodes and weights on [−1, 1]."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights


def angle(a: Float64Array, b: Float64Array) -> Any:
    """Between unit vectors, to full precision at 0 and π too."""
    return np.arctan2(np.sqrt(square_of_cross(a, b)), dot(a, b))


def is_tiny(size: Any, power: float) -> Any:
    """Whether regions of such angular sizes are points for all but the last digits."""
    return (size < _TINY) & (size * math.sqrt(power + 1.0) < _FRACTION)


# -- along an arc


def regular(less: Any, power: float) -> Any:
    """(1 − zᵖ) / (1 − z²), p the power, for less = 1 − z."""
    with np.errstate(divide="ignore", invalid="ignore"):
        regular = -np.expm1(power * np.log1p(-np.minimum(less, 1.0))) / (less * (2.0 - less))
    return np.where(less > 0.0, regular, 0.5 * power)


def shows_below(power: float) -> float:
    """The 1 − z from which on zᵖ is left out."""
    return -math.expm1(math.log(_NOTHING) / power)


def integral(middle: Any, half: Any, is_rough: Any, count: int, integrand: Any) -> Any:
    """Of a function on intervals, at whose ends it may be as rough as a low power is at 0."""
    total = np.zeros_like(half)
    for node, weight in zip(*gauss_legendre(count if is_rough is False else 2 * count), strict=True):
        if is_rough is not False:  # nodes crowd at the ends
            weight = np.where(is_rough, 1.5 * weight * (1.0 - node * node), weight)
            node = np.where(is_rough, 0.5 * node * (3.0 - node * node), node)
        total += weight * integrand(middle + half * node)
    return total * half


def great_arc(along: Any, across: Any, middle: Any, half: Any, power: float) -> Any:
    """∫ (1 − max(z, 0)ᵖ) dφ along arcs of great circles, counter-clockwise around their poles m.

    Parameters
    ----------
    along, across : ndarray
        w·m, and |w × m|.
    middle, half : ndarray
        Their middle, measured from where they are next to w, in radians, and half their length, less than π/2.
    power : float
        The p, >= 1.
    """
    middle = middle - 2.0 * math.pi * np.round(middle / (2.0 * math.pi))
    first, last = middle - half, middle + half
    pole = along * along / (1.0 + across)  # 1 − across

    def integrand(y: Any) -> Any:
        return regular(pole + 2.0 * across * np.sin(0.5 * y) ** 2, power)

    with np.errstate(divide="ignore", invalid="ignore"):
        height = np.clip((shows_below(power) - pole) / across, 0.0, 1.0)  # 1 − cos y at the window's ends
    window = 2.0 * np.arcsin(np.sqrt(0.5 * np.where(across > 0.0, height, 0.0)))
    start, stop = np.clip(first, -window, window), np.clip(last, -window, window)
    is_left_out = (start != first) | (stop != last)
    length = np.where(is_left_out, stop - start, 2.0 * half)  # ends have lost digits of short arcs
    is_rough = power < ROUGH and is_left_out
    shown = along * integral(0.5 * (start + stop), 0.5 * length, is_rough, _NODES, integrand)
    return _turn(along, first, last, 2.0 * half) - _turn(along, start, stop, length) + shown


def _turn(along: Any, first: Any, last: Any, length: Any) -> Any:
    """∫ dφ along such an arc."""
    rise = np.abs(along)
    turned = np.arctan2(
        rise * np.sin(length),
        rise * rise * np.cos(first) * np.cos(last) + np.sin(first) * np.sin(last),
    )
    return np.where(along < 0.0, -turned, turned)


def whole(turned: Any) -> Any:
    """The integral around a region from those along its arcs: if −w is inside, a turn is missing."""
    return np.maximum(np.where(turned < -1.0, turned + 2.0 * math.pi, turned), 0.0)


def share_above(sine: Any, power: float) -> Any:
    """The part above the horizon of a lobe max(w·u, 0)ᵏ, k the power, for the sine of w's elevation over it.

    Projected from its middle, the lobe is Student's t distribution: along a line it has the density cosᵏ of the angle.
    """
    height = np.arcsin(np.clip(np.asarray(sine, np.float64), -1.0, 1.0))
    window = math.acos(math.exp(math.log(_NOTHING) / power))

    def up_to(angles: Any) -> Any:
        shown = np.minimum(angles, window)
        return integral(0.5 * shown, 0.5 * shown, power < ROUGH, _HALF_NODES, lambda a: np.cos(a) ** power)

    return 0.5 + 0.5 * np.copysign(up_to(np.abs(height)) / up_to(np.array(0.5 * math.pi)), height)


# -- a cap, which is how a sphere is seen


def cap_cosine(c: Any, s: Any, C: Any) -> Any:
    """∫ max(n·u, 0) du / (π s²) over caps (Snyder 1996), for a normal at the angle arccos c from their middle.

    It is c where all of a cap is above the horizon. Where this cuts it, with W = √(s² − c²) and T = W/C, it is
    (c · atan2(W, −C c) + T − (T − atan T)/s²) / π: nothing of it cancels, however small the cap.
    """
    is_cut = np.abs(c) < s
    W = np.sqrt(np.where(is_cut, (s - c) * (s + c), 0.0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        cut = (c * np.arctan2(W, -C * c) + _less_arctan(W, s, C)) / math.pi
    return np.where(is_cut, cut, np.maximum(c, 0.0) * (s > 0.0))


def _less_arctan(W: Any, s: Any, C: Any) -> Any:
    """T − (T − atan T)/s² for T = W/C, in a form for small T, by a series, and one for large T."""
    T = W / C
    square = T * T
    series = np.zeros_like(T)
    for k in range(10, 0, -1):
        series = (-1.0) ** (k + 1) / (2 * k + 1) + square * series
    small = T * (1.0 - series * (W / (s * C)) ** 2)
    large = (np.arctan2(W, C) - C * W) / (s * s)
    return np.where(T < _SERIES, small, large)


def cap_power(w: Float64Array, n: Float64Array, l: Float64Array, s: Any, C: Any, power: float) -> Any:
    """∫ max(w·u, 0)ᵏ du / (π s²) over caps above the horizon, k the power, for unit vectors w; 0 for a zero n."""
    c = dot(n, l)
    result = np.zeros_like(c)
    seen = (c > -s) & (s > 0.0) & (dot(n, n) > 0.5)
    tiny = is_tiny(s, power)
    axis = w if power else n  # 0⁰ is 1 below the equator too
    for rows, over in ((np.flatnonzero(seen & ~tiny), _large_cap), (np.flatnonzero(seen & tiny), _tiny_cap)):
        if len(rows):
            result[rows] = over(axis[:, rows], n[:, rows], l[:, rows], c[rows], s[rows], C[rows], power)
    return result


def _cut(c: Any, s: Any) -> Any:
    """W, √(s² − c²) where the horizon cuts the cap, else 0."""
    return np.sqrt(np.maximum((s - c) * (s + c), 0.0))


def _large_cap(w: Any, n: Any, l: Any, c: Any, s: Any, C: Any, power: float) -> Any:
    """Around the part of the circle above the horizon, and back along the horizon."""
    W = _cut(c, s)
    visible = np.where(c < s, np.arctan2(W, -C * c), math.pi)
    turn = dot(l, np.cross(w, n, axis=0))
    middle = np.arctan2(turn, dot(w, n) - dot(w, l) * c)
    turned = _circle(angle(w, l), np.arctan2(s, C), middle, visible, power + 1.0)
    (rows,) = np.nonzero(W)
    if len(rows):
        w, n, l, c, W, C, turn = w[:, rows], n[:, rows], l[:, rows], c[rows], W[rows], C[rows], turn[rows]
        along, across = dot(w, n), np.sqrt(square_of_cross(w, n))
        middle = np.arctan2(-turn, dot(w, l) - along * c)
        turned[rows] += great_arc(along, across, middle, np.arctan2(W, C), power + 1.0)
    return whole(turned) / ((power + 1.0) * math.pi * s * s)


def _circle(gamma: Any, a: Any, middle: Any, visible: Any, power: float) -> Any:
    """∫ (1 − max(z, 0)ᵖ) dφ along circles of angular radius a at the angle γ from w.

    Parameters
    ----------
    gamma, a : ndarray
        The angles.
    middle, visible : ndarray
        The middle of the arc, measured around the circle from where it is next to w, and half the arc's length.
    power : float
        The p, >= 1.
    """
    nearest = 2.0 * np.sin(0.5 * (gamma - a)) ** 2
    spread = 2.0 * np.sin(gamma) * np.sin(a)
    inward, rest = np.sin(a) * np.sin(a - gamma), 2.0 * np.sin(a) * np.cos(a) * np.sin(gamma)

    def integrand(chi: Any) -> Any:
        square = np.sin(0.5 * chi) ** 2
        return (inward + rest * square) * regular(nearest + spread * square, power)

    with np.errstate(divide="ignore", invalid="ignore"):
        height = np.clip((shows_below(power) - nearest) / spread, 0.0, 1.0)
    is_near = nearest < shows_below(power)
    window = 2.0 * np.arcsin(np.sqrt(np.where(spread > 0.0, height, is_near)))

    def seen_from_w(chi: Any) -> tuple[Any, Any]:
        """The circle's point at χ, across w: outwards in the plane of w and the circle's middle, and sideways."""
        outward = np.sin(a - gamma) - 2.0 * np.sin(a) * np.cos(gamma) * np.sin(0.5 * chi) ** 2
        return outward, np.sin(a) * np.sin(chi)

    def up_to(chi: Any) -> Any:
        shown = np.minimum(chi, window)
        is_rough = power < ROUGH and shown < chi
        turned = integral(0.5 * shown, 0.5 * shown, is_rough, _HALF_NODES, integrand)
        (x, y), (outward, sideways) = seen_from_w(shown), seen_from_w(chi)
        return turned + np.arctan2(x * sideways - y * outward, x * outward + y * sideways)

    half_turn = up_to(np.full_like(window, math.pi))
    turned = 2.0 * half_turn
    (rows,) = np.nonzero(visible < math.pi)
    if len(rows):
        nearest, spread, inward, rest, window, gamma, a = (
            x[rows] for x in (nearest, spread, inward, rest, window, gamma, a)
        )
        turned[rows] = 0.0
        for sign in (1.0, -1.0):
            chi = middle[rows] + sign * visible[rows]
            turns = np.round(chi / (2.0 * math.pi))
            chi -= 2.0 * math.pi * turns
            turned[rows] += sign * (2.0 * turns * half_turn[rows] + np.sign(chi) * up_to(np.abs(chi)))
    return turned


def _tiny_cap(w: Any, n: Any, l: Any, c: Any, s: Any, C: Any, power: float) -> Any:  # noqa: ARG001 it is flat
    return tiny_disk(w, n, l, l, s, power) / (math.pi * s * s)


def tiny_disk(w: Any, n: Any, middle: Any, facing: Any, radius: Any, power: float) -> Any:
    """∫ max(w·u, 0)ᵏ du over the part above the horizon of disks that are far away.

    By nodes on chords across n, at places cos α along n, 0 <= α <= β.

    Parameters
    ----------
    w, n : ndarray
        The unit vectors, and the normals of the horizon.
    middle, facing : ndarray
        The ways to the disks' middles, and unit vectors along their axes.
    radius : ndarray
        Theirs, (m,).
    power : float
        The k.
    """
    level = np.cross(facing, n, axis=0)
    slope = np.sqrt(dot(level, level))
    level = np.where(slope > 0.0, level / np.where(slope > 0.0, slope, 1.0), 0.0)
    upward = np.cross(level, facing, axis=0)
    height, slope = dot(n, middle), radius * slope
    beta = np.where(height < slope, np.arctan2(_cut(height, slope), -height), math.pi)
    total = np.zeros_like(height)
    for node, weight in zip(*gauss_legendre(12), strict=True):
        alpha = 0.5 * beta * (1.0 + node)
        for chord, share in zip(*gauss_legendre(4), strict=True):
            x = middle + radius * (np.cos(alpha) * upward + np.sin(alpha) * chord * level)
            square = dot(x, x)
            inverse = 1.0 / np.sqrt(square)
            z = np.maximum(dot(w, x) * inverse, 0.0)
            seen = np.abs(dot(facing, x)) * inverse / square
            total += 0.5 * beta * weight * share * np.sin(alpha) ** 2 * z**power * seen
    return total * radius * radius
