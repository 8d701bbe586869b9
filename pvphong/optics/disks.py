"""Integrals of powers of a cosine over a disk that is seen.

The rim x(ψ) = c + R (cos ψ e₁ + sin ψ e₂), with c = ρ e₁ + H e₃ the way to the middle and e₃ the disk's axis, is an
ellipse to the eye. Along it |x|² = K + M cos ψ has one harmonic, so that ∫ n·(x × x')/|x|² dψ, which gives Lambert's
cosine, is elementary, whole or cut off by the horizon; whole, it is Hamilton and Morgan's (1952). For other powers the
boundary integral of `spherical` is taken over pieces of the rim, short against a lobe's width, where the power shows.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from pvphong.base.vectors import dot, square_of_cross
from pvphong.optics.spherical import (
    ROUGH,
    CosinePower,
    great_arc,
    integral,
    is_tiny,
    regular,
    shows_below,
    tiny_disk,
    whole,
)

# Nodes in a piece of the rim; so many lobe's widths long it is at most; fewest and most pieces.
_NODES, _WIDTHS, _FEWEST, _MOST = 12, 1.5, 8, 4096

# From here on the way to the middle has a direction across the axis.
_ASIDE = 1e-14


def over_disk(form: CosinePower, axis: Any, n: Any, middle: Any, facing: Any, radius: Any) -> Any:
    """1/(π R²) · ∫ max(a·u, 0)ᵏ du over the part of a disk above the horizon, as it is seen from either side.

    Parameters
    ----------
    form : CosinePower
        The power k.
    axis, n : ndarray
        The unit vectors a, and the normals of the horizon, (3, m).
    middle : ndarray
        The ways to the disk's middle, (3, m).
    facing : ndarray
        The disk's axis as a unit vector, (3, 1).
    radius : ndarray
        The disk's, (m,).
    """
    power = form.power
    axis = axis if power else n  # 0⁰ is 1 below the equator too
    slope = radius * np.sqrt(square_of_cross(n, facing + np.zeros_like(n)))
    height = dot(n, middle)
    tiny = is_tiny(radius / np.sqrt(dot(middle, middle)), power)
    is_lambert = form.around == "normal"
    is_cut = np.abs(height) < slope
    result = np.zeros_like(height)
    # the elementary integral loses nothing where all of a disk is seen
    by_nodes = tiny & (is_cut | (not is_lambert))
    for chosen, over in ((~by_nodes, _lambert if is_lambert else _by_pieces), (by_nodes, _by_nodes)):
        (rows,) = np.nonzero(chosen & (height > -slope) & (dot(n, n) > 0.5))
        if len(rows):
            w = (n if is_lambert else axis)[:, rows]
            result[rows] = over(form, w, n[:, rows], middle[:, rows], facing, radius[rows])
    return np.maximum(result, 0.0) / (math.pi * radius * radius)


def _by_nodes(form: CosinePower, axis: Any, n: Any, middle: Any, facing: Any, radius: Any) -> Any:
    return tiny_disk(axis, n, middle, facing + np.zeros_like(middle), radius, form.power)


def _frame(middle: Any, facing: Any) -> tuple[Any, Any, Any, Any, Any]:
    """ρ and H of the way to the middle, e₁, e₂, and e₃, on whose side the disk is."""
    along = dot(middle, facing)
    e3 = np.where(along < 0.0, -facing, facing)
    inside = middle - dot(middle, e3) * e3
    rho = np.sqrt(dot(inside, inside))
    any_way = np.cross(facing, np.eye(3)[:, [int(np.argmin(np.abs(facing)))]], axis=0)
    any_way = any_way / np.sqrt(dot(any_way, any_way))
    is_aside = rho > _ASIDE * np.abs(along)
    e1 = np.where(is_aside, inside / np.where(is_aside, rho, 1.0), any_way)
    e1 = e1 - dot(e1, e3) * e3  # nearly overhead it has been rounded
    e1 = e1 / np.sqrt(dot(e1, e1))
    return rho, np.abs(along), e1, np.cross(e3, e1, axis=0), e3


def _visible(n: Any, middle: Any, e1: Any, e2: Any, radius: Any) -> tuple[Any, Any]:
    """Middle of the rim's arc above the horizon, and half its length; π for all."""
    x, y, height = radius * dot(n, e1), radius * dot(n, e2), dot(n, middle)
    slope = np.sqrt(x * x + y * y)
    crossing = np.sqrt(np.maximum((slope - height) * (slope + height), 0.0))
    return np.arctan2(y, x), np.where(height < slope, np.arctan2(crossing, -height), math.pi)


def _rim(middle: Any, e1: Any, e2: Any, radius: Any, psi: Any) -> Any:
    return middle + radius * (np.cos(psi) * e1 + np.sin(psi) * e2)


def _lambert(form: CosinePower, axis: Any, n: Any, middle: Any, facing: Any, radius: Any) -> Any:  # noqa: ARG001
    rho, H, e1, e2, e3 = _frame(middle, facing)
    K, M = rho * rho + H * H + radius * radius, 2.0 * radius * rho
    least, most = (rho - radius) ** 2 + H * H, (rho + radius) ** 2 + H * H  # K ∓ M
    S = np.sqrt(least) * np.sqrt(most)
    x, y, z = dot(n, e1), dot(n, e2), dot(n, e3)
    center, visible = _visible(n, middle, e1, e2, radius)
    with np.errstate(divide="ignore", invalid="ignore"):
        even, cosine = 2.0 * math.pi / S, -2.0 * math.pi * M / (S * (K + S))
        seen = 0.5 * radius * (z * radius * even + (z * rho - H * x) * cosine)
    (rows,) = np.nonzero(visible < math.pi)
    if len(rows):
        rho, H, K, M, S, radius = (a[rows] for a in (rho, H, K, M, S, radius))
        x, y, z = x[rows], y[rows], z[rows]
        first, last = center[rows] - visible[rows], center[rows] + visible[rows]
        ends = [_elementary(psi, K, M, S, least[rows], most[rows]) for psi in (first, last)]
        even, cosine = (b - a for a, b in zip(*ends, strict=True))
        sine = _logarithm(first, last, K, M)
        arc = 0.5 * radius * (z * radius * even + (z * rho - H * x) * cosine - H * y * sine)
        start, stop = (_rim(middle[:, rows], e1[:, rows], e2[:, rows], radius, psi) for psi in (last, first))
        across = np.cross(start, stop, axis=0)
        seen[rows] = arc + 0.5 * np.arctan2(dot(across, n[:, rows]), dot(start, stop))
    return np.abs(seen)


def _elementary(psi: Any, K: Any, M: Any, S: Any, least: Any, most: Any) -> tuple[Any, Any]:
    """∫ dψ/(K + M cos ψ) and ∫ cos ψ dψ/(K + M cos ψ) from 0."""
    turns = np.round(psi / (2.0 * math.pi))
    half = 0.5 * psi - math.pi * turns
    r = np.sqrt(least / most)
    sine, cosine = np.sin(half), np.cos(half)
    lag = np.arctan2(2.0 * M / (most * (1.0 + r)) * sine * cosine, cosine * cosine + r * sine * sine)
    per_m = np.where(M > 0.0, lag / np.where(M > 0.0, M, 1.0), sine * cosine / K)
    return (psi - 2.0 * lag) / S, -psi * M / (S * (K + S)) + 2.0 * K * per_m / S


def _logarithm(first: Any, last: Any, K: Any, M: Any) -> Any:
    """∫ sin ψ dψ/(K + M cos ψ)."""
    fall = 2.0 * np.sin(0.5 * (first + last)) * np.sin(0.5 * (last - first))  # cos(first) − cos(last)
    ratio = fall / (K + M * np.cos(first))
    return np.where(M > 0.0, -np.log1p(-M * ratio) / np.where(M > 0.0, M, 1.0), ratio)


def _by_pieces(form: CosinePower, axis: Any, n: Any, middle: Any, facing: Any, radius: Any) -> Any:
    """The rim in pieces, and back along the horizon; vertices that need about as many pieces at a time."""
    power = form.power + 1.0
    rho, H, e1, e2, _ = _frame(middle, facing)
    center, visible = _visible(n, middle, e1, e2, radius)
    nearest = np.hypot(rho - radius, H)
    wide = np.minimum(radius / nearest, 1e6) * max(math.sqrt(power), 2.0) / _WIDTHS
    wanted = np.ceil(np.log2(np.clip(2.0 * visible * wide, _FEWEST, _MOST))).astype(int)
    turned = np.zeros_like(radius)
    for level in np.unique(wanted):
        (rows,) = np.nonzero(wanted == level)
        step = visible[rows] / 2.0**level
        part = axis[:, rows], middle[:, rows], e1[:, rows], e2[:, rows], radius[rows]
        for k in range(2**level):
            piece = center[rows] + (2 * k + 1 - 2.0**level) * step
            turned[rows] += _piece(*part, piece, step, power)
    (rows,) = np.nonzero(visible < math.pi)
    if len(rows):
        w, m = axis[:, rows], n[:, rows]
        start, stop = (
            _rim(middle[:, rows], e1[:, rows], e2[:, rows], radius[rows], center[rows] + sign * visible[rows])
            for sign in (1.0, -1.0)
        )
        seen = np.arctan2(dot(m, np.cross(start, stop, axis=0)), dot(start, stop))
        across = np.sqrt(square_of_cross(w, m))
        first = np.arctan2(dot(start, np.cross(m, w, axis=0)), dot(start, w))
        arc = great_arc(dot(w, m), across, first + 0.5 * seen, 0.5 * np.abs(seen), power)
        turned[rows] += np.sign(seen) * arc
    return whole(turned) / power


def _piece(w: Any, middle: Any, e1: Any, e2: Any, radius: Any, psi: Any, half: Any, power: float) -> Any:
    """∫ (1 − max(z, 0)ᵖ) dφ along pieces of the rim."""
    first, last = (_rim(middle, e1, e2, radius, psi + sign * half) for sign in (-1.0, 1.0))
    turned = np.arctan2(dot(w, np.cross(first, last, axis=0)), dot(first, last) - dot(w, first) * dot(w, last))
    x = _rim(middle, e1, e2, radius, psi)
    size = np.sqrt(dot(x, x))
    cosine = dot(w, x) / size
    reach = np.arctan2(radius * half, np.maximum(size - radius * half, 1e-300))
    window = np.arccos(1.0 - shows_below(power)) + reach
    (rows,) = np.nonzero(np.arccos(np.clip(cosine, -1.0, 1.0)) < window)
    if not len(rows):
        return turned
    w, middle, e1, e2, radius, psi, half = (a[..., rows] for a in (w, middle, e1, e2, radius, psi, half))

    def integrand(angle: Any) -> Any:
        x = _rim(middle, e1, e2, radius, angle)
        ahead = radius * (np.cos(angle) * e2 - np.sin(angle) * e1)
        square = dot(x, x)
        gap = x / np.sqrt(square) - w
        return dot(w, np.cross(x, ahead, axis=0)) / square * regular(0.5 * dot(gap, gap), power)

    if power >= ROUGH:
        turned[rows] = integral(psi, half, False, _NODES, integrand)
        return turned
    ends = [psi - half, *_on_equator(*_visible(w, middle, e1, e2, radius), psi, half), psi + half]
    turned[rows] = sum(
        integral(0.5 * (start + stop), 0.5 * (stop - start), True, _NODES, integrand) for start, stop in pairwise(ends)
    )
    return turned


def _on_equator(center: Any, visible: Any, psi: Any, half: Any) -> Any:
    """Where the rim crosses the equator of w, kept within a piece, in their order."""
    crossings = [center - visible, center + visible]
    turns = [np.round((psi - crossing) / (2.0 * math.pi)) for crossing in crossings]
    kept = [
        np.clip(crossing + 2.0 * math.pi * turn, psi - half, psi + half)
        for crossing, turn in zip(crossings, turns, strict=True)
    ]
    return np.sort(kept, axis=0)
