"""Integrals of powers of a cosine over a polygon that is seen: Lambert's formula (1760) and Green's theorem.

The polygon is cut off at the horizon first. Then Lambert's cosine is the sum over its sides of half the angle under
which each is seen times the cosine between its plane's normal and n, and other powers are the integrals of
`spherical.great_arc`. Arc tangents and cross products of a corner with its side keep the digits that arc cosines and
unit vectors lose where a light is far away. Where it is so far that the sides' sum loses them too, it is flat and the
cosines hardly vary: nodes of the fifth degree on its triangles are exact.

Arrays are float64: vectors (3, m) for m vertices, corners as offsets from the polygon's middle.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array
from pvphong.base.vectors import dot, square_of_cross
from pvphong.optics.spherical import CosinePower, great_arc, is_tiny, whole

TRIANGLE = (
    (1.0 / 3.0, 1.0 / 3.0, 0.225 / 3.0),
    (0.059715871789769820, 0.470142064105115090, 0.132394152788506181),
    (0.797426985353087322, 0.101286507323456339, 0.125939180544827153),
)
"""Radon's rule of the fifth degree: barycentric coordinate of one corner in turn, that of the others, weight."""

Offsets = Sequence[Float64Array]
"""Of the corners one after the other, each (3, m)."""


def over_polygon(form: CosinePower, axis: Any, n: Any, middle: Any, offsets: Offsets, size: float, area: Any) -> Any:
    """1/area · ∫ max(a·u, 0)ᵏ du over the part of a polygon above the horizon, as it is seen from either side.

    Parameters
    ----------
    form : CosinePower
        The power k.
    axis, n : ndarray
        The unit vectors a, and the normals of the horizon.
    middle : ndarray
        The ways to the polygon's middle.
    offsets : sequence of ndarray
        Of the corners from there.
    size : ndarray
        The length of the longest, shape (m,).
    area : ndarray
        The polygon's, shape (m,).
    """
    power = form.power
    axis = axis if power else n  # 0⁰ is 1 below the equator too
    heights = [dot(n, middle + offset) for offset in offsets]
    above = sum((height > 0.0).astype(int) for height in heights)
    tiny = is_tiny(size / np.sqrt(dot(middle, middle)), power)
    result = np.zeros_like(area)
    for rows, is_cut in ((above == len(offsets), False), ((above > 0) & (above < len(offsets)), True)):
        for chosen, over in ((rows & ~tiny, _by_sides), (rows & tiny, _by_triangles)):
            (taken,) = np.nonzero(chosen)
            if not len(taken):
                continue
            corners: Offsets = [offset[:, taken] for offset in offsets]
            if is_cut:
                corners = list(_cut_off(n[:, taken], corners, [height[taken] for height in heights]))
            w = n if form.around == "normal" else axis
            result[taken] = over(form, w[:, taken], middle[:, taken], corners, area[taken])
    return result


def _cut_off(n: Any, offsets: Offsets, heights: Sequence[Any]) -> Iterator[Any]:
    """The corners above the horizon, and where sides cross it; others repeat the one before."""
    count = len(offsets)
    found = []
    for k in range(count):
        here, there = heights[k - 1], heights[k]
        side = offsets[k] - offsets[k - 1]
        fall = -dot(n, side)
        is_crossing = (here > 0.0) != (there > 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            along = np.where(is_crossing, np.clip(here / fall, 0.0, 1.0), 0.0)
        found += [(is_crossing, offsets[k - 1] + along * side), (there > 0.0, offsets[k])]
    last = found[0][1]
    for is_there, corner in found:
        last = np.where(is_there, corner, last)
    for is_there, corner in found:
        last = np.where(is_there, corner, last)
        yield last


def _by_sides(form: CosinePower, axis: Any, middle: Any, offsets: Offsets, area: Any) -> Any:
    total = np.zeros_like(area)
    for k, offset in enumerate(offsets):
        start, stop = middle + offsets[k - 1], middle + offset
        normal = np.cross(start, offset - offsets[k - 1], axis=0)
        length = np.sqrt(dot(normal, normal))
        seen = np.arctan2(length, dot(start, stop))
        m = normal / np.where(length > 0.0, length, 1.0)
        if form.around == "normal":
            total += 0.5 * seen * dot(m, axis)
            continue
        across = np.sqrt(square_of_cross(axis, m))
        first = np.arctan2(dot(start, np.cross(m, axis, axis=0)), dot(start, axis))
        total += great_arc(dot(axis, m), across, first + 0.5 * seen, 0.5 * seen, form.power + 1.0)
    # its corners run one way around as they are seen from its front, and the other way from its back
    sign = np.sign(_volume(middle, offsets))
    return (np.abs(total) if form.around == "normal" else whole(sign * total) / (form.power + 1.0)) / area


def _volume(middle: Any, offsets: Offsets) -> Any:
    """The way to the middle times the vector area: positive from the back, where corners run clockwise."""
    first = offsets[0]
    area = np.zeros_like(middle)
    for second, third in pairwise(offsets):
        area += np.cross(second - first, third - first, axis=0)
    return dot(middle, area)


def _by_triangles(form: CosinePower, axis: Any, middle: Any, offsets: Offsets, area: Any) -> Any:
    """Nodes on the triangles between the first corner and each side, whose areas have signs."""
    total = np.zeros_like(area)
    first = offsets[0]
    for second, third in pairwise(offsets):
        facing = np.cross(second - first, third - first, axis=0)
        for one, others, weight in TRIANGLE:
            for a, b, c in ((first, second, third), (second, third, first), (third, first, second)):
                x = middle + one * a + others * (b + c)
                square = dot(x, x)
                inverse = 1.0 / np.sqrt(square)
                cosine = np.maximum(dot(axis, x) * inverse, 0.0)
                total += 0.5 * weight * cosine**form.power * dot(facing, x) * inverse / square
    return np.abs(total) / area
