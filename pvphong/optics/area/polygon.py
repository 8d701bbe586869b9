"""Integrals over a polygon that is seen: Lambert's formula (1760) and Green's theorem, side by side.

The polygon is cut off at the horizon, side by side: what of a side is above the horizon, and where it crosses that, the
way along the horizon from or to one point r of it. So any number of crossings is closed, and what is below cancels.

Symbols: m the way to the polygon's middle, o the corners' offsets from there, e the normal of its front; n the normal of
the horizon. All lengths are first divided by a power of two that is next to the light's distance or its size.
"""

from __future__ import annotations

from typing import Any

from pvphong.base.formulas import (
    add,
    any_of,
    arctan2,
    cross,
    dot,
    formula,
    maximum,
    minimum,
    over_its_size,
    sqrt,
    subtract,
    times,
    where,
)
from pvphong.optics.area.lobes import POINT, RAISED, arc_between, seen_as_point, shows, whole

# What formulas read of a polygon: e, 1 if its back glows too, the root of its area, the length of its longest offset,
# how many corners it has, and their offsets.
TWO_SIDED, ROOT, SIZE, COUNT, OFFSETS = range(3, 8)


@formula
def _offset(own: Any, k: Any, scale: Any) -> Any:
    """Of the corner k."""
    at = OFFSETS + 3 * k
    return own[at] * scale, own[at + 1] * scale, own[at + 2] * scale


@formula
def scaled(d: Any, size: float) -> Any:
    """A way over a power of two, and one over that power."""
    far = maximum(maximum(abs(d[0]), abs(d[1])), maximum(abs(d[2]), size))
    scale = over_its_size(far)
    return times(d, scale), scale


@formula
def is_glowing(own: Any, m: Any, n: Any) -> Any:
    """Whether a side of a flat light that glows is seen, and there is a normal."""
    behind = dot(own, m)
    return ((behind < 0.0) | (behind * own[TWO_SIDED] > 0.0)) & (dot(n, n) > 0.5)


@formula
def _horizon(own: Any, m: Any, n: Any) -> Any:
    """Offset of r, the point next to the middle on the horizon's line in the polygon's plane."""
    rise = subtract(n, times(own, dot(own, n)))
    return times(rise, -dot(n, m) / maximum(dot(rise, rise), 1e-300))


@formula
def _part(own: Any, m: Any, n: Any, scale: Any, k: Any) -> Any:
    """Offsets between which a side is above the horizon, whether it crosses that downwards, and upwards."""
    count = int(own[COUNT])
    a, b = _offset(own, (k + count - 1) % count, scale), _offset(own, k, scale)
    side = subtract(b, a)
    here, there = dot(n, add(m, a)), dot(n, add(m, b))
    falls, rises = (here > 0.0) & (there <= 0.0), (there > 0.0) & (here <= 0.0)
    fall = -dot(n, side)
    along = minimum(maximum(here / where(falls | rises, fall, 1.0), 0.0), 1.0)
    crossing = add(a, times(side, along))
    is_below = (here <= 0.0) & (there <= 0.0)
    start = _choose(rises, crossing, a)
    stop = _choose(is_below, a, _choose(falls, crossing, b))
    return start, stop, falls, rises


@formula
def _choose(condition: Any, a: Any, b: Any) -> Any:
    return where(condition, a[0], b[0]), where(condition, a[1], b[1]), where(condition, a[2], b[2])


@formula
def polygon_cosine(own: Any, _lobe: Any, d: Any, n: Any, _w: Any) -> Any:
    """1/area · ∫ max(n·u, 0) du over the part above the horizon.

    It is ½ |Σ f_i n·Γ_i|, with Γ = x × y for the ends of side i and f = θ/|Γ|, θ the angle under which it is seen. The
    sum of the Γ is twice the vector area α e, whatever m; so a mean F of the f is taken out, ½ |F α n·e + Σ (f_i − F)
    n·Γ_i|, and f − F = (θ/sin θ − 1)/|x||y| + 1/|x||y| − F by differences of squares: nothing cancels however far away.
    """
    m, scale = scaled(d, own[SIZE])
    is_lit = is_glowing(own, m, n)
    far, total, area = dot(m, m) + (own[SIZE] * scale) * (own[SIZE] * scale), 0.0 * scale, 0.0 * scale
    if any_of(is_lit):
        r = _horizon(own, m, n)
        for k in range(int(own[COUNT])):
            start, stop, falls, rises = _part(own, m, n, scale, k)
            more = 1
            if any_of(is_lit & (falls | rises)):
                more = 2
            for j in range(more):
                if j == 1:
                    start, stop = _choose(falls, stop, r), _choose(rises, start, r)
                x, y = add(m, start), add(m, stop)
                across = cross(x, subtract(stop, start))
                length = sqrt(dot(across, across))
                both = maximum(sqrt(dot(x, x) * dot(y, y)), 1e-300)
                more_x, more_y = _more(m, start), _more(m, stop)
                near = dot(m, m)
                rest = far - near - (near * (more_x + more_y) + more_x * more_y) / (near + both)
                rest = rest / (both * far) + _angle_over_sine(length, dot(x, y), both) / both
                total = total + rest * dot(n, across)
                area = area + dot(own, cross(start, stop))
        total = total + area * dot(own, n) / far
    root = own[ROOT] * scale
    return where(is_lit, 0.5 * abs(total) / (root * root) * scale * scale, 0.0)


@formula
def _more(m: Any, offset: Any) -> Any:
    """|m + o|² − |m|²."""
    return 2.0 * dot(m, offset) + dot(offset, offset)


@formula
def _angle_over_sine(length: Any, level: Any, both: Any) -> Any:
    """θ/sin θ − 1 for sin θ = length/both and cos θ = level/both; near 0 by the series of the arc sine."""
    ratio = length / both
    square = ratio * ratio
    series = 6435.0 / 557056.0 + 0.0 * square
    for term in (143.0 / 10240.0, 231.0 / 13312.0, 63.0 / 2816.0, 35.0 / 1152.0, 5.0 / 112.0, 3.0 / 40.0, 1.0 / 6.0):
        series = series * square + term
    large = arctan2(length, level) * both / maximum(length, 1e-300) - 1.0
    return where((square < 0.01) & (level > 0.0), series * square, large)


@formula
def polygon_power(own: Any, lobe: Any, d: Any, n: Any, w: Any) -> Any:
    """1/area · ∫ max(w·u, 0)ᵏ du over the part above the horizon, along its sides.

    To a lobe that is much wider than the light is seen, the light is a point: the middle of what is above the horizon.
    """
    m, scale = scaled(d, own[SIZE])
    size, distance = own[SIZE] * scale, sqrt(dot(m, m))
    is_lit = is_glowing(own, m, n) & shows(lobe, w, m, distance, size)
    is_point = size < lobe[POINT] * distance
    root = own[ROOT] * scale
    turned, area, middle = 0.0 * scale, 0.0 * scale, times(m, 0.0)
    if any_of(is_lit):
        r = _horizon(own, m, n)
        for k in range(int(own[COUNT])):
            start, stop, falls, rises = _part(own, m, n, scale, k)
            more = 1
            if any_of(is_lit & (falls | rises)):
                more = 2
            for j in range(more):
                if j == 1:
                    start, stop = _choose(falls, stop, r), _choose(rises, start, r)
                part = dot(own, cross(start, stop))
                area, middle = area + part, add(middle, times(add(start, stop), part))
                if any_of(is_lit & ~is_point):
                    turned = turned + arc_between(lobe, w, add(m, start), add(m, stop), subtract(stop, start))
    by_sides = whole(where(dot(own, m) > 0.0, turned, -turned)) / lobe[RAISED]
    x = add(m, times(middle, 1.0 / where(area > 0.0, 3.0 * area, 1.0)))
    seen = where(is_point, seen_as_point(lobe, own, w, x) * 0.5 * area, by_sides)
    return where(is_lit, seen / (root * root) * scale * scale, 0.0)
