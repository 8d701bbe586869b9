"""Integrals over the visible part of a disk, of a sphere, and of a round patch of the sky.

A sphere is seen as the disk across its nearer cap, and a patch of the sky as a sphere.

Symbols: m the vector to the centre, e the axis with e·m > 0, r the radius; n the normal of the horizon; u the unit
vector upward in the disk's plane, and t = e × u; ω a unit direction in integrals, and dω its solid angle. All lengths
are first divided by a power of two close to the light's distance or its size.

The rim x(δ) = m + r (cos δ u + sin δ t) is above the horizon for |δ| <= β. Along the rim, |x|² has a single harmonic.
So ∫ n·(x × x')/|x|² dδ, which gives Lambert's cosine, is elementary, whether the horizon cuts the disk or not; for a
whole disk it is Hamilton and Morgan's formula (1952). For other powers, the boundary integral of `lobes` follows pieces
of the rim that are short compared with a lobe's width, and returns along the horizon.
"""

from __future__ import annotations

import math
from typing import Any

from pvphong.base.formulas import (
    add,
    any_of,
    arctan2,
    cosine,
    cross,
    dot,
    formula,
    horner,
    largest,
    log1p,
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
from pvphong.optics.area.lobes import (
    COUNT,
    NODES,
    PIECE,
    POINT,
    RAISED,
    SMOOTH_FROM,
    arc_between,
    seen_as_point,
    shows,
    whole,
)
from pvphong.optics.area.polygon import is_glowing, scaled

# Layout of a disk's numbers: the normal of its front; 1 if its back emits too, else 0; the radius.
RADIUS = 4
# Largest number of pieces of the rim.
_MOST_PIECES = 2000.0


@formula
def _upward(n: Any, m: Any, e: Any, r: Any) -> Any:
    """Describe how the horizon cuts a disk: return the unit vectors u and t, the angle β, and |n × e|.

    u is upward in the disk's plane, and t = e × u. The rim m + r (cos δ u + sin δ t) is above the horizon for |δ| <= β.

    Parameters
    ----------
    n, m, e
        Normal of the horizon; vector to the disk's centre; axis of the disk, with e·m > 0.
    r
        Radius of the disk.
    """
    rise = subtract(n, times(e, dot(n, e)))
    steep = sqrt(dot(rise, rise))
    is_level = steep < 1e-14  # any direction across e serves as u
    is_along_x = abs(e[0]) > 0.6
    x, y = select(is_along_x, 0.0, 1.0), select(is_along_x, 1.0, 0.0)
    rise = select(is_level, x, rise[0]), select(is_level, y, rise[1]), select(is_level, 0.0, rise[2])
    rise = subtract(rise, times(e, dot(rise, e)))
    u = times(rise, 1.0 / maximum(sqrt(dot(rise, rise)), 1e-300))
    height, slope = dot(n, m), r * steep
    crossing = sqrt(maximum((slope - height) * (slope + height), 0.0))
    beta = select(height < slope, arctan2(crossing, -height), math.pi)
    return u, cross(e, u), beta, steep


@formula
def _rim(m: Any, u: Any, t: Any, r: Any, delta: Any) -> Any:
    """Return the point x(δ) = m + r (cos δ u + sin δ t) of a disk's rim, and the derivative x'(δ), for δ = `delta`.

    m is the vector to the disk's centre, r its radius; u and t are from `_upward`.
    """
    ahead, aside = r * cosine(delta), r * sine(delta)
    x = m[0] + ahead * u[0] + aside * t[0], m[1] + ahead * u[1] + aside * t[1], m[2] + ahead * u[2] + aside * t[2]
    return x, (ahead * t[0] - aside * u[0], ahead * t[1] - aside * u[1], ahead * t[2] - aside * u[2])


@formula
def _above(m: Any, u: Any, r: Any, beta: Any) -> Any:
    """Return the fraction of a disk's area above the horizon, and the vector from the vertex to this part's centroid.

    m is the vector to the disk's centre, r its radius; u and β, `beta`, are from `_upward`.
    """
    area = beta - sine(beta) * cosine(beta)
    lift = sine(beta) * sine(beta) * sine(beta) / (1.5 * maximum(area, 1e-300))
    return area / math.pi, add(m, times(u, r * lift))


# --- Lambert's cosine


@formula
def disk_irradiance(own: Any, _lobe: Any, d: Any, n: Any, _w: Any) -> Any:
    """Integrate 1/(π r²) · max(n·ω, 0) dω over the part of a disk light above the horizon.

    The arguments are those of `Integral.formula`; `own` has the disk's numbers. A whole disk gives (z T + 2 H c) / ((K
    + S) S), with m the vector to the centre, e the axis, H = e·m, z = n·e, c = n·m and K = |m|² + r². S is the product
    of the least and the greatest distance to the rim. T = S − (|m|² − r²) is computed without cancellation.
    """
    m, scale = scaled(d, own[RADIUS])
    r = own[RADIUS] * scale
    is_lit = is_glowing(own, m, n, r)
    e = times(own, select(dot(own, m) < 0.0, -1.0, 1.0))
    H, z, height = dot(e, m), dot(n, e), dot(n, m)
    level = subtract(m, times(e, H))
    rho = sqrt(dot(level, level))
    least, most = (rho - r) * (rho - r) + H * H, (rho + r) * (rho + r) + H * H
    K, S = dot(m, m) + r * r, maximum(sqrt(least * most), 1e-300)
    beyond = dot(m, m) - r * r
    T = select(beyond > 0.0, 4.0 * r * r * H * H / maximum(S + beyond, 1e-300), S - beyond)
    seen = (z * T + 2.0 * H * height) / ((K + S) * S)
    slope = r * sqrt(maximum((1.0 - z) * (1.0 + z), 0.0))
    is_cut = is_lit & (abs(height) < slope)
    if any_of(is_cut):
        u, t, beta, steep = _upward(n, m, e, r)
        middle = arctan2(dot(e, cross(level, u)), dot(level, u))
        even, along, across = _elementary(middle, beta, K, 2.0 * r * rho, S, least, most)
        inward = z * rho - H * steep * cosine(middle)
        arc = r * (z * r * even + inward * along - H * steep * sine(middle) * across)
        x, _ = _rim(m, u, t, r, beta)
        closing = times(t, -2.0 * r * sine(beta))
        arc = 0.5 * abs(arc + arctan2(dot(n, cross(x, closing)), dot(x, add(x, closing)))) / (math.pi * r * r)
        area, middle = _above(m, u, r, beta)
        inverse = 1.0 / maximum(sqrt(dot(middle, middle)), 1e-300)
        as_point = area * maximum(dot(n, middle), 0.0) * abs(dot(e, middle)) * (inverse * inverse) * (inverse * inverse)
        seen = select(is_cut, select(r * r < 1e-10 * dot(m, m), as_point, arc), seen)  # the sum loses digits far away
    return select(is_lit & (height > -slope), maximum(seen, 0.0) * scale * scale, 0.0)


@formula
def _elementary(middle: Any, beta: Any, K: Any, M: Any, S: Any, least: Any, most: Any) -> Any:
    """Return three integrals over ψ from middle − β to middle + β: of 1, cos ψ and sin ψ, each over K + M cos ψ.

    ψ is the angle along a disk's rim from the rim's farthest point, and `beta` is β. The squared distance to the rim is
    K + M cos ψ, between `least` and `most`; S is √(least · most).
    """
    first, last = middle - beta, middle + beta
    ratio = sqrt(least / most)
    (lag, per_m), (before, before_per_m) = _lag(last, K, M, most, ratio), _lag(first, K, M, most, ratio)
    even = (2.0 * beta - 2.0 * (lag - before)) / S
    along = (2.0 * K * (per_m - before_per_m) - 2.0 * beta * M / (K + S)) / S
    fall = 2.0 * sine(middle) * sine(beta) / maximum(K + M * cosine(first), 1e-300)  # cos first − cos last
    across = select(M > 0.0, -log1p(-M * fall) / maximum(M, 1e-300), fall)
    return even, along, across


@formula
def _lag(psi: Any, K: Any, M: Any, most: Any, ratio: Any) -> Any:
    """Return two numbers: ½ψ − φ, where tan φ = ratio · tan ½ψ; and this difference divided by M.

    ψ is `psi`, and `ratio` is √(least/most). The arguments K, M and `most` are as for `_elementary`.
    """
    half = 0.5 * psi - math.pi * nearest(psi * (0.5 / math.pi))
    ahead, aside = cosine(half), sine(half)
    lag = arctan2(2.0 * M / (most * (1.0 + ratio)) * aside * ahead, ahead * ahead + ratio * aside * aside)
    return lag, select(M > 0.0, lag / maximum(M, 1e-300), aside * ahead / K)


# Coefficients of 1/3 − T²/5 + T⁴/7 … = (1 − (atan T)/T) / T², highest power first.
_ARCTAN_REST = tuple((-1.0) ** (k + 1) / (2 * k + 1) for k in range(10, 0, -1))


@formula
def sphere_irradiance(own: Any, _lobe: Any, d: Any, n: Any, _w: Any) -> Any:
    """Integrate max(n·ω, 0) dω / (π r²) over the visible part of a sphere light of radius r (Snyder 1996).

    The arguments are those of `Integral.formula`; `own` has the radius. Let s and C be the sine and cosine of the
    sphere's angular radius, |d| the distance to its centre, and c the cosine of the angle between n and the direction
    to the centre. If the sphere is entirely above the horizon, the result is c/|d|². If the horizon cuts it, the result
    is (c · atan2(W, −C c) + T − (T − atan T)/s²) / (π |d|²), with W = √(s² − c²) and T = W/C. The result is computed
    without cancellation, however small the sphere is.
    """
    m, s, C, distance, scale, is_lit = _cap(own, d, n)
    c = dot(n, m) / distance
    is_cut = is_lit & (abs(c) < s)
    seen = maximum(c, 0.0)
    if any_of(is_cut):
        W = sqrt(maximum((s - c) * (s + c), 0.0))
        T = W / maximum(C, 1e-300)
        square = minimum(T * T, 0.01)
        series = horner(square, _ARCTAN_REST)
        ratio = W / maximum(s * C, 1e-300)
        large = (arctan2(W, C) - C * W) / maximum(s * s, 1e-300)
        rest = select(T < 0.1, T * (1.0 - series * ratio * ratio), large)
        seen = select(is_cut, (c * arctan2(W, -C * c) + rest) / math.pi, seen)
    return select(is_lit, seen / (distance * distance) * scale * scale, 0.0)


@formula
def _cap(own: Any, d: Any, n: Any) -> Any:
    """Describe a sphere light as seen from a vertex.

    d is the offset from the vertex to the sphere's centre, n the normal, and own[0] the radius. Return the scaled
    offset m, the sine and cosine of the sphere's angular radius, |m|, the factor by which lengths were scaled, and
    whether the vertex is lit. A vertex is lit if it is outside the sphere and has a normal.
    """
    m, scale = scaled(d, own[0])
    r, distance = own[0] * scale, maximum(sqrt(dot(m, m)), 1e-100)
    s = minimum(r / distance, 1.0)
    C = sqrt(maximum((distance - r) / distance, 0.0) * (1.0 + s))
    return m, s, C, distance, scale, (distance > r) & (dot(n, n) > 0.5)


# --- light from far away
#
# A round patch of the sky of angular radius α is seen as a sphere of radius s = sin α at distance 1, from everywhere.
# Its numbers are s, then the unit vector to its middle. Offsets of vertices are not read.


@formula
def _to_middle(own: Any, n: Any) -> Any:
    """Return the unit vector to the middle of a patch of the sky, repeated for each column of the normals n.

    `own` has the patch's numbers.
    """
    nothing = 0.0 * n[0]
    return own[1] + nothing, own[2] + nothing, own[3] + nothing


@formula
def patch_irradiance(own: Any, lobe: Any, _d: Any, n: Any, w: Any) -> Any:
    """Integrate 1/(π s²) · max(n·ω, 0) dω over the part of a round patch of the sky above the horizon.

    The arguments are those of `Integral.formula`. s is the sine of the patch's angular radius.
    """
    return sphere_irradiance(own, lobe, _to_middle(own, n), n, w)


# --- powers


@formula
def disk_highlight(own: Any, lobe: Any, d: Any, n: Any, w: Any) -> Any:
    """Integrate 1/(π r²) · max(w·ω, 0)ᵏ dω over the part of a disk light above the horizon.

    The arguments are those of `Integral.formula`. w is the lobe's axis, and k its exponent.
    """
    m, scale = scaled(d, own[RADIUS])
    e = times(own, select(dot(own, m) < 0.0, -1.0, 1.0))
    r = own[RADIUS] * scale
    return _within_rim(lobe, w, n, m, e, r, is_glowing(own, m, n, r)) * scale * scale


@formula
def sphere_highlight(own: Any, lobe: Any, d: Any, n: Any, w: Any) -> Any:
    """Integrate max(w·ω, 0)ᵏ dω / (π r²) over the part of a sphere light above the horizon.

    The arguments are those of `Integral.formula`. w is the lobe's axis, and k its exponent. A sphere is seen as a disk.
    The disk's radius is the sine of the sphere's angular radius, and its distance the cosine.
    """
    m, s, C, distance, scale, is_lit = _cap(own, d, n)
    l = times(m, 1.0 / distance)
    return _within_rim(lobe, w, n, times(l, C), l, s, is_lit) / (distance * distance) * scale * scale


@formula
def patch_highlight(own: Any, lobe: Any, _d: Any, n: Any, w: Any) -> Any:
    """Integrate 1/(π s²) · max(w·ω, 0)ᵏ dω over the part of a round patch of the sky above the horizon.

    The arguments are those of `Integral.formula`. s is the sine of the patch's angular radius, w the lobe's axis, and k
    its exponent.
    """
    return sphere_highlight(own, lobe, _to_middle(own, n), n, w)


@formula
def _within_rim(lobe: Any, w: Any, n: Any, m: Any, e: Any, r: Any, is_lit: Any) -> Any:
    """Integrate 1/(π r²) · max(w·ω, 0)ᵏ dω over the part of a disk above the horizon; 0 where `is_lit` is False.

    If the lobe is much wider than the light's angular size, the centroid of the part above the horizon replaces the
    light.

    Parameters
    ----------
    lobe : sequence of float
        From `lobe_numbers`.
    w, n
        Axis of the lobe, and normal of the horizon.
    m, e, r
        Vector to the disk's centre; axis of the disk, with e·m > 0; radius.
    is_lit
        Mask of the vertices that may get light.
    """
    distance = sqrt(dot(m, m))
    is_lit = is_lit & shows(lobe, w, m, distance, r)
    is_point = r < lobe[POINT] * distance
    seen = 0.0 * r
    if any_of(is_lit):
        u, t, beta, steep = _upward(n, m, e, r)
        is_lit = is_lit & (dot(n, m) > -r * steep)
        is_cut = is_lit & (beta < math.pi)
        area, middle = _above(m, u, r, beta)
        seen = seen_as_point(lobe, e, w, middle) * area
        is_long = is_lit & ~is_point
        if any_of(is_long):
            by_rim = _along_rim(lobe, w, m, e, u, t, r, beta, is_long)
            if any_of(is_cut & is_long):
                x, _ = _rim(m, u, t, r, beta)
                closing = times(t, -2.0 * r * sine(beta))
                by_rim = by_rim + select(is_cut, arc_between(lobe, w, x, add(x, closing), closing), 0.0)
            seen = select(is_point, seen, whole(by_rim) / (lobe[RAISED] * math.pi * r * r))
    return select(is_lit, seen, 0.0)


@formula
def _along_rim(lobe: Any, w: Any, m: Any, e: Any, u: Any, t: Any, r: Any, beta: Any, is_long: Any) -> Any:
    """Integrate (1 − max(z, 0)ᵖ) dφ along the part of a disk's rim above the horizon, piece by piece.

    z is the cosine with the lobe's axis w, and φ the angle around w. For low powers, the rim is split at the equator of
    w.

    Parameters
    ----------
    lobe : sequence of float
        From `lobe_numbers`.
    w
        Axis of the lobe.
    m, e, r
        Vector to the disk's centre; axis of the disk, with e·m > 0; radius.
    u, t, beta
        From `_upward`.
    is_long
        Mask of the vertices to compute.
    """
    over = dot(e, m)
    level = subtract(m, times(e, over))
    off = sqrt(dot(level, level)) - r
    wide = r / maximum(
        sqrt(off * off + over * over), 1e-6 * r
    )  # angle under which the vertex sees a radian of the rim, at its closest
    low, high, parts = beta, beta, 1
    if lobe[RAISED] < SMOOTH_FROM:
        ahead, aside, height = r * dot(w, u), r * dot(w, t), dot(w, m)
        rest = ahead * ahead + aside * aside - height * height
        half, middle = arctan2(sqrt(maximum(rest, 0.0)), -height), arctan2(aside, ahead)
        one, other = _kept(middle - half, beta), _kept(middle + half, beta)
        low, high, parts = minimum(one, other), maximum(one, other), 3
    turned = 0.0 * r
    for j in range(parts):
        first, last = -beta, low
        if j == 1:
            first, last = low, high
        elif j == 2:
            first, last = high, beta
        length = last - first
        wanted = minimum(0.5 * length * wide / lobe[PIECE], _MOST_PIECES)
        count = select(is_long, nearest(wanted + 0.5), 0.0)
        half = 0.5 * length / maximum(count, 1.0)
        for k in range(largest(count)):
            is_there, center = count > 1.0 * k, first + half * (2.0 * k + 1.0)
            x, ahead = _rim(m, u, t, r, center)
            size = r * half
            is_shown = is_there & shows(lobe, w, x, sqrt(dot(x, x)), size)
            if parts == 3:
                is_shown = is_shown & (dot(w, x) > 0.0)
            start, _ = _rim(m, u, t, r, center - half)
            stop, _ = _rim(m, u, t, r, center + half)
            chord = times(ahead, 2.0 * sine(half))
            level = dot(start, stop) - dot(w, start) * dot(w, stop)
            turn = arctan2(dot(w, cross(start, chord)), level)
            if any_of(is_shown):
                nodes = 0.0 * r
                for i in range(int(lobe[COUNT])):
                    x, ahead = _rim(m, u, t, r, center + half * lobe[NODES + 2 * i])
                    square = dot(x, x)
                    gap = subtract(times(x, 1.0 / sqrt(square)), w)
                    less = minimum(maximum(0.5 * dot(gap, gap), 1e-300), 1.99)
                    dense = -power_less_one(less, lobe[RAISED]) / (less * (2.0 - less))
                    nodes = nodes + lobe[NODES + 2 * i + 1] * dense * dot(w, cross(x, ahead)) / square
                turn = select(is_shown, nodes * half, turn)
            turned = turned + select(is_there, turn, 0.0)
    return turned


@formula
def _kept(angle: Any, beta: Any) -> Any:
    """Wrap an angle to [−π, π], and clamp it to [−β, β]; β is `beta`."""
    angle = angle - 2.0 * math.pi * nearest(angle * (0.5 / math.pi))
    return minimum(maximum(angle, -beta), beta)
