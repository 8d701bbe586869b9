"""Integrals over the visible part of a polygon, as sums over its sides: Lambert's formula (1760) and Green's theorem.

Each side of the polygon is clipped at the horizon. Every point where the outline crosses the horizon is joined to one
point r of the horizon. These lines close the parts of the outline above the horizon, for any number of crossings.

The two integrals have the arguments of `Integral.formula` in `pvphong.optics.light`.

Symbols: m the vector to the polygon's middle, e the normal of its front; n the normal of the horizon; u a unit
direction, du its solid angle. Corners are offsets from the middle. All lengths are first divided by a power of two
close to the light's distance or its size.
"""

from __future__ import annotations

import math
from typing import Any

from pvphong.base.formulas import (
    add,
    any_of,
    arctan2,
    cross,
    dot,
    formula,
    horner,
    maximum,
    over_its_size,
    select,
    sqrt,
    subtract,
    times,
)
from pvphong.optics.area.lobes import POINT, RAISED, arc_between, seen_as_point, shows, whole

# Layout of a polygon's numbers: the normal e; 1 if the back emits too, else 0; the square root of the area; the length
# of the longest offset; the number of corners; and the corners' offsets.
TWO_SIDED, ROOT, SIZE, COUNT, OFFSETS = range(3, 8)

# Coefficients of (arcsin(√q)/√q − 1)/q for q up to ½, highest power first: from `mpmath.chebyfit`, to 2e-16.
_ARCSINE = (
    0.6629475548369097, -2.277990489441633, 3.7316474816315224, -3.7415993002001366, 2.573508064401593,
    -1.258681300394588, 0.46581061083892006, -0.1174784139555458, 0.033823977477227554, 0.0058919623838489124,
    0.011985559032731258, 0.013929824301362788, 0.017354730668996843, 0.022372086303686842, 0.030381946078023858,
    0.04464285712358516, 0.07500000000008983, 0.1666666666666666,
)  # fmt: skip


@formula
def _offset(own: Any, k: Any, scale: Any) -> Any:
    """Return the offset of corner k from the polygon's middle, times `scale`; k = −1 is the last corner.

    `own` has the polygon's numbers.
    """
    at = OFFSETS + 3 * (k if k >= 0 else int(own[COUNT]) - 1)
    return own[at] * scale, own[at + 1] * scale, own[at + 2] * scale


@formula
def scaled(d: Any, size: float) -> Any:
    """Scale a vector d by a power of two, so that the largest of |x|, |y|, |z| and `size` becomes about 1.

    Return the scaled vector and the power of two. Both are NaN if d is not finite, so that the vertex is unlit.
    """
    far = maximum(maximum(abs(d[0]), abs(d[1])), maximum(abs(d[2]), size))
    scale = select(far < math.inf, over_its_size(far), math.nan)
    return times(d, scale), scale


@formula
def is_glowing(own: Any, m: Any, n: Any, size: Any) -> Any:
    """Return True if a vertex with the normal n can get light from a flat light at the offset m.

    Three conditions must hold: the vertex has a normal; an emitting side of the light faces it; and a sphere of the
    radius `size` around the light is partly above the horizon. `own` has the light's numbers. The first four are the
    normal of its front, and 1 if the back emits too, else 0.
    """
    behind = dot(own, m)
    return ((behind < 0.0) | (behind * own[TWO_SIDED] > 0.0)) & (dot(n, n) > 0.5) & (dot(n, m) > -size)


@formula
def _horizon(own: Any, m: Any, n: Any) -> Any:
    """Return a point r of the horizon, as offset from the polygon's middle. Lines to r close a clipped polygon.

    The horizon cuts the polygon's plane along a line. r is the point of this line nearest to the polygon's middle.

    Parameters
    ----------
    own
        The polygon's numbers.
    m, n
        Vector to the polygon's middle, and normal of the horizon.
    """
    rise = subtract(n, times(own, dot(own, n)))
    return times(rise, -dot(n, m) / maximum(dot(rise, rise), 1e-300))


@formula
def _side(own: Any, scale: Any, n: Any, height: Any, r: Any, is_lit: Any, k: Any) -> Any:
    """Clip side k of a polygon at the horizon.

    Parameters
    ----------
    own, scale
        The polygon's numbers, and the factor by which lengths are scaled.
    n, height
        The normal of the horizon, and n·m.
    r
        The result of `_horizon`.
    is_lit, k
        Mask of the vertices to compute, and index of the corner at which the side ends.

    Returns
    -------
    start, stop
        Offsets of the ends of the part above the horizon.
    closing_start, closing_stop
        Offsets of the ends of the line along the horizon that closes this part.
    pieces : int
        2 if any vertex needs the closing line, else 1.
    """
    a, b = _offset(own, k - 1, scale), _offset(own, k, scale)
    height_a, height_b = height + dot(n, a), height + dot(n, b)
    start, stop, closing_start, closing_stop, pieces = a, b, a, a, 1
    if any_of(is_lit & ((height_a <= 0.0) | (height_b <= 0.0))):
        falls, rises = (height_a > 0.0) & (height_b <= 0.0), (height_a <= 0.0) & (height_b > 0.0)
        along = height_a / select(falls | rises, height_a - height_b, 1.0)
        crossing = add(a, times(subtract(b, a), along))
        start = _choose(rises, crossing, a)
        stop = _choose(falls, crossing, _choose(height_b > 0.0, b, start))
        closing_start = _choose(falls, stop, _choose(rises, r, start))
        closing_stop = _choose(rises, start, _choose(falls, r, start))
        pieces = 2 if any_of(is_lit & (falls | rises)) else 1
    return start, stop, closing_start, closing_stop, pieces


@formula
def _choose(condition: Any, a: Any, b: Any) -> Any:
    return select(condition, a[0], b[0]), select(condition, a[1], b[1]), select(condition, a[2], b[2])


@formula
def polygon_irradiance(own: Any, _lobe: Any, d: Any, n: Any, _a: Any) -> Any:
    """Integrate 1/area · max(n·u, 0) du over the part of a polygon light above the horizon: its irradiance.

    The arguments are those of `Integral.formula`. The integral is ½ |Σ f n·Γ|, with Γ = x × y for the ends x and y of a
    side, and f = θ/|Γ| for its angular length θ. Far away, this sum cancels. Wherever the vertex is, the sum of the Γ
    is twice the polygon's vector area, a vector α e along the normal e. So a common value F, close to every f, is
    subtracted: ½ |F α n·e + Σ (f − F) n·Γ|. The difference is f − F = (θ/sin θ − 1)/|x||y| + 1/|x||y| − F, computed by
    differences of squares.
    """
    m, scale = scaled(d, own[SIZE])
    size, root = own[SIZE] * scale, own[ROOT] * scale
    is_lit = is_glowing(own, m, n, size)
    near, height = dot(m, m), dot(n, m)
    per_far, total, area = 1.0 / (near + size * size), 0.0 * scale, 0.0 * scale
    if any_of(is_lit):
        r = _horizon(own, m, n)
        for k in range(int(own[COUNT])):
            start, stop, closing_start, closing_stop, pieces = _side(own, scale, n, height, r, is_lit, k)
            for j in range(pieces):
                if j == 1:
                    start, stop = closing_start, closing_stop
                x, y, side = add(m, start), add(m, stop), subtract(stop, start)
                across = cross(x, side)
                both = sqrt(maximum(dot(x, x) * dot(y, y), 1e-300))  # |x||y|
                inverse = 1.0 / (both * (near + both))  # one division for 1/both and 1/(near + both)
                per_both = inverse * (near + both)
                more_x, more_y = 2.0 * dot(m, start) + dot(start, start), 2.0 * dot(m, stop) + dot(stop, stop)
                rest = size * size - (near * (more_x + more_y) + more_x * more_y) * (inverse * both)
                square = dot(across, across) * (per_both * per_both)
                rest = rest * per_far + angle_over_sine(square, dot(x, y) * per_both)
                total = total + rest * dot(n, across) * per_both
                area = area + dot(own, cross(start, side))
        total = total + area * dot(own, n) * per_far
    return select(is_lit, 0.5 * abs(total) / (root * root) * scale * scale, 0.0)


@formula
def angle_over_sine(square: Any, cosine: Any) -> Any:
    """Return θ/sin θ − 1 for an angle θ in [0, π], given `square` = sin² θ and `cosine` = cos θ.

    Up to 45° it is a polynomial, split in two halves to shorten the chain of dependent operations.
    """
    fourth = square * square
    found = square * (square * horner(fourth, _ARCSINE[::2]) + horner(fourth, _ARCSINE[1::2]))
    is_wide = (square > 0.5) | (cosine < 0.0)
    if any_of(is_wide):
        sine = sqrt(square)
        found = select(is_wide, arctan2(sine, cosine) / maximum(sine, 1e-300) - 1.0, found)
    return found


@formula
def polygon_highlight(own: Any, lobe: Any, d: Any, n: Any, w: Any) -> Any:
    """Integrate 1/area · max(w·u, 0)ᵏ du over the part of a polygon light above the horizon, along its sides.

    The arguments are those of `Integral.formula`. w is the lobe's axis, and k its exponent. If the lobe is much wider
    than the light's angular size, the centroid of the part above the horizon replaces the light.
    """
    m, scale = scaled(d, own[SIZE])
    size, distance = own[SIZE] * scale, sqrt(dot(m, m))
    is_lit = is_glowing(own, m, n, size) & shows(lobe, w, m, distance, size)
    is_point = size < lobe[POINT] * distance
    root = own[ROOT] * scale
    turned, area, middle = 0.0 * scale, 0.0 * scale, times(m, 0.0)
    if any_of(is_lit):
        height, r = dot(n, m), _horizon(own, m, n)
        for k in range(int(own[COUNT])):
            start, stop, closing_start, closing_stop, pieces = _side(own, scale, n, height, r, is_lit, k)
            for j in range(pieces):
                if j == 1:
                    start, stop = closing_start, closing_stop
                side = subtract(stop, start)
                part = dot(own, cross(start, side))
                area, middle = area + part, add(middle, times(add(start, stop), part))
                if any_of(is_lit & ~is_point):
                    turned = turned + arc_between(lobe, w, add(m, start), add(m, stop), side)
    by_sides = whole(select(dot(own, m) > 0.0, turned, -turned)) / lobe[RAISED]
    x = add(m, times(middle, 1.0 / select(area > 0.0, 3.0 * area, 1.0)))
    seen = select(is_point, seen_as_point(lobe, own, w, x) * 0.5 * area, by_sides)
    return select(is_lit, seen / (root * root) * scale * scale, 0.0)
