"""Sizes of triangles, and sample places in them: patterns, peaks and creases.

At a peak, a light is brightest; at a crease, colours bend or jump. A fixed pattern of samples misses both. Places are
barycentric coordinates. `corners`, shape (m, 3), are the vertices of m triangles.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import threads
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.base.vectors import columns, cross, dot, unit, unit_vector
from pvphong.optics.roles import Aim, Angle, Power
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.inside.lighting import LitVertices, difference, inside_cone, largest, to_viewer

# --- triangles and patterns

# Number of triangles measured together.
_AT_ONCE = 2**13


def sizes(points: Float64Array, corners: IntArray) -> tuple[Float64Array, Float64Array]:
    """Return the longest side and the least height of m triangles, shape (m,) each.

    `points` has the shape (n, 3). `corners`, shape (m, 3), has the indices of each triangle's points. The height is
    zero or NaN if a triangle has no area, or a point that is not finite.
    """
    longest, height = np.empty((2, len(corners)))

    def measure(first: int, last: int) -> None:
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            a, b, c = points.take(corners[first:last], axis=0).transpose(1, 2, 0)
            sides = np.stack([b - a, c - b, a - c])
            scale = np.abs(sides).max(axis=(0, 1), initial=0.0)
            sides /= scale
            most = np.sqrt(np.square(sides).sum(axis=1).max(axis=0))
            vector = cross(sides[0], sides[1])
            longest[first:last], height[first:last] = most * scale, np.sqrt(dot(vector, vector)) / most * scale

    threads.run(measure, len(corners), _AT_ONCE)
    return longest, height


def area(points: Float64Array, corners: IntArray) -> float:
    """Return the total area of triangles. Triangles with a point that is not finite count as 0.

    `points` has the shape (n, 3). `corners`, shape (m, 3), has the indices of each triangle's points.
    """
    longest, height = sizes(points, corners)
    return float(np.nan_to_num(longest * height).sum()) / 2.0


def odd_corner(is_above: BoolArray) -> IntArray:
    """Return the corner (0, 1 or 2) of each triangle whose flag differs from the other two, shape (m,); 0 if all agree.

    `is_above` has the corners' flags, shape (m, 3).
    """
    return (is_above == (is_above.sum(axis=1) == 1)[:, None]).argmax(axis=1)


def lattice(order: int) -> Float64Array:
    """Return all barycentric coordinates, shape (s, 3), that are multiples of 1/order, without the corners."""
    steps = [(i, j, order - i - j) for i in range(order + 1) for j in range(order + 1 - i)]
    return np.array([step for step in steps if max(step) < order]) / order


# --- peaks and creases


class Places(NamedTuple):
    """k places, each in a triangle."""

    rows: IntArray
    """Indices of the triangles, shape (k,)."""

    weights: Float64Array
    """Barycentric coordinates of the places, shape (k, 3)."""


class _AtCorners:
    """Values at the corners of m triangles. They are computed once per vertex, although several triangles share it.

    Attributes
    ----------
    rows : slice or ndarray of int
        Indices of the vertices for which values are computed: at least all vertices of the triangles.
    points, normals : ndarray
        Positions and normals of these vertices, in the world.
    """

    def __init__(self, vertices: LitVertices, corners: IntArray) -> None:
        low, high = int(corners.min(initial=len(vertices.points))), int(corners.max(initial=0)) + 1
        if high - low <= corners.size:  # their vertices are close in memory
            self.rows: slice | IntArray = slice(low, high)
            self._corners = corners - low
        else:
            self.rows, inverse = np.unique(corners, return_inverse=True)
            self._corners = inverse.reshape(corners.shape)
        points, normals = vertices.points[self.rows], vertices.normals[self.rows]
        self.points, self.normals = vertices.lighting.in_world(points, normals)

    def of(self, values: Any) -> Any:
        """Return the values at the corners of the triangles, shape (m, 3, ...).

        `values` has an entry for each vertex in `rows`.
        """
        return np.take(values, self._corners, axis=0)  # takes a quarter of the time of values[...]


def _chords(term: LightTerm, equation: Equation, points: Float64Array, normals: Float64Array) -> Float64Array:
    """Return the chord D of a light's highlight at k points, a vector whose length is 0 at the highlight's peak.

    The highlight is a power of the cosine 1 − |D|²/2. `points`, `normals` and the result have the shape (k, 3). In
    Phong's model, D is the mirror direction of the light minus the unit vector to the viewer; see
    `pvphong.optics.reflectances.highlight`.
    """
    p, n = columns(points), unit(columns(normals))[0]
    v, to_light = to_viewer(p, equation), term.light.arrival(p).direction
    if equation.two_sided:
        n = np.where(dot(n, equation.toward_viewer(v)) < 0.0, -n, n)
    peak = equation.reflectance.peak
    assert peak is not None, "only reflectances with a peak are sharp"
    return np.stack(np.broadcast_arrays(*peak.chord(n, to_light, v)), axis=1)


# Distance from a corner, in barycentric coordinates, within which a peak counts as at the corner.
_AT_CORNER = 2.0**-20


def peaks(vertices: LitVertices, corners: IntArray) -> Iterator[Places]:
    """Yield the places where a light's contribution is largest, in triangles where this is not at a corner.

    At such a peak, the length of a vector that varies over the triangle is smallest. The vector is the chord D of a
    highlight, the offset from a spot's axis, or the offset from a light at a position. `corners`, shape (m, 3), are the
    vertices of m triangles.
    """
    equation, at = vertices.lighting.equation, _AtCorners(vertices, corners)
    for term in equation.terms:
        light, p, offsets = term.light, at.points, []
        for place in light.places:
            offsets.append(p - np.array(place))
        for direction in light.values(Aim) if light.values(Power) else ():
            axis, from_light = unit_vector(direction), p - np.array(light.places[0])
            offsets.append(from_light - np.outer(from_light @ axis, axis))
        found = []
        for each in offsets:
            at_corners = at.of(each)
            rows = np.flatnonzero(~_is_at_corner(at_corners))
            found.append(Places(rows, _shortest(at_corners[rows])))
        if equation.sharpness > 0.0 and equation.has(term, "specular"):
            found.append(_highlight_peaks(term, equation, at))
        for rows, weights in found:
            inside = largest(weights) < 1.0 - _AT_CORNER
            yield Places(rows[inside], weights[inside])


# Step, in barycentric coordinates, of the finite differences of a highlight's chord.
_STEP = 2.0**-12

# Number of Gauss-Newton steps. Each squares the distance to a highlight's peak.
_TURNS = 5

# Half of n |D|² beyond which a highlight of shininess n is below 1e-9.
_INVISIBLE = 21.0


def _highlight_peaks(term: LightTerm, equation: Equation, at: _AtCorners) -> Places:
    """Return the peaks of one light's highlight in triangles larger than the highlight.

    They are found by Gauss-Newton steps. In smaller triangles, the fixed pattern of samples suffices. `at` has the
    values at the triangles' corners.

    Inside a triangle, a chord's length deviates from linear by less than a quarter of the square of its spread over the
    triangle. By this bound, triangles that are too far from the highlight are skipped.
    """
    sharpness = equation.sharpness
    chords = _chords(term, equation, at.points, at.normals)
    spread = largest(difference(at.of(chords), at.of(chords)[:, [1, 2, 0]]))
    rows = np.flatnonzero(~(spread * math.sqrt(sharpness) <= 1.0))
    at_corners, spread = at.of(chords)[rows], spread[rows]
    weights = _shortest(at_corners)
    nearest = np.linalg.norm(_blend(weights, at_corners), axis=1) - spread**2 / 4.0
    is_near = nearest < math.sqrt(2.0 * _INVISIBLE / sharpness)
    rows, weights = rows[is_near], weights[is_near]
    p, n = at.of(at.points)[rows], at.of(at.normals)[rows]
    for _ in range(_TURNS):  # minimise the linear expansion of the chord about the last place
        here = _chords(term, equation, _blend(weights, p), _blend(weights, n))
        expanded = np.empty_like(p)
        for corner in range(3):
            aside = (1.0 - _STEP) * weights
            aside[:, corner] += _STEP
            there = _chords(term, equation, _blend(aside, p), _blend(aside, n))
            expanded[:, corner] = here + (there - here) / _STEP
        weights = _shortest(expanded)
    return Places(rows, weights)


def _blend(weights: Float64Array, at_corners: Float64Array) -> Float64Array:
    return np.einsum("ki,kij->kj", weights, at_corners)


def _shortest(at_corners: Float64Array) -> Float64Array:
    """Return the barycentric coordinates of the shortest blend of three vectors, shape (k, 3), for k triangles.

    `at_corners`, shape (k, 3, 3), has the three vectors of each triangle.

    The three vectors span a triangle, and the shortest blend is this triangle's point nearest to the origin. If the
    foot of the perpendicular from the origin lies inside, it is the nearest point. If not, the nearest point is on one
    of the three sides (C. Ericson: Real-Time Collision Detection (2005), section 5.1.5).
    """
    a, b, c = at_corners.transpose(1, 2, 0)
    ab, ac = b - a, c - a
    # The normal equations of |a + s ab + t ac| -> min.
    g11, g12, g22 = dot(ab, ab), dot(ab, ac), dot(ac, ac)
    h1, h2 = -dot(a, ab), -dot(a, ac)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        determinant = g11 * g22 - g12 * g12
        s, t = (g22 * h1 - g12 * h2) / determinant, (g11 * h2 - g12 * h1) / determinant
        r = 1.0 - s - t
    result = np.stack([r, s, t], axis=1)
    outside = np.flatnonzero(~((r >= 0.0) & (s >= 0.0) & (t >= 0.0)))  # a NaN is outside
    on_sides, lengths = np.zeros((3, len(outside), 3)), np.empty((3, len(outside)))
    for side in range(3):
        p, q = at_corners[outside, side], at_corners[outside, (side + 1) % 3]
        pq = q - p
        square = np.einsum("ki,ki->k", pq, pq)
        along = np.clip(np.einsum("ki,ki->k", -p, pq) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        on_sides[side, :, side], on_sides[side, :, (side + 1) % 3] = 1.0 - along, along
        lengths[side] = np.linalg.norm(p + along[:, None] * pq, axis=1)
    result[outside] = on_sides[lengths.argmin(axis=0), np.arange(len(outside))]
    return result


def _is_at_corner(at_corners: Float64Array) -> BoolArray:
    """Return True for triangles in which the shortest blend of three vectors is one of these vectors, shape (k,).

    `at_corners`, shape (k, 3, 3), has the three vectors of each triangle. If the shortest blend is at a corner, the
    length of the blend increases from this corner along both sides.
    """
    a, b, c = at_corners.transpose(1, 2, 0)
    ab, bc, ca = b - a, c - b, a - c
    at_a = (dot(a, ab) >= 0.0) & (dot(a, ca) <= 0.0)
    at_b = (dot(b, bc) >= 0.0) & (dot(b, ab) <= 0.0)
    at_c = (dot(c, ca) >= 0.0) & (dot(c, bc) <= 0.0)
    return np.asarray(at_a | at_b | at_c)


# Least shininess of a highlight that has no bend where its cosine reaches zero.
_SMOOTH = 2.0


def creases(vertices: LitVertices, corners: IntArray) -> Iterator[Places]:
    """Yield places at creases: in each triangle, places where one of several values changes its sign.

    `corners`, shape (m, 3), are the vertices of m triangles. The values are:

    - n·l, at a light's terminator;
    - n·v, or n along the view axis, where a two-sided surface turns;
    - the angle minus the cone's, at the edge of a spot's cone;
    - a highlight's cosine, at its cutoff;
    - a colour minus 1, where the colour saturates.
    """
    equation, at = vertices.lighting.equation, _AtCorners(vertices, corners)
    p, n = columns(at.points), columns(at.normals)
    toward = equation.toward_viewer(to_viewer(p, equation))
    values: list[FloatArray] = [dot(n, toward)] if equation.two_sided else []
    for term in equation.terms:
        to_light = term.light.arrival(p).direction
        if term.needs_normals:
            values.append(dot(n, to_light))  # with the normal's length, so it is linear under a distant light
        if term.light.values(Aim) and term.light.values(Angle):
            values.append(inside_cone(term.light, p))
        if equation.has(term, "specular") and 0.0 < equation.sharpness < _SMOOTH:
            chord = _chords(term, equation, at.points, at.normals)
            values.append(1.0 - np.einsum("ki,ki->k", chord, chord) / 2.0)
    if vertices.lighting.scene.light_model.clamp:
        values += [channel - 1.0 for channel in vertices.colors[at.rows].T]
    for value in values:
        yield from _sign_changes(at.of(np.broadcast_to(value, len(at.points))))


# Distance of the samples on both sides of a crease from it, as a fraction of a side.
_ASIDE = 2.0**-5


def _sign_changes(values: FloatArray) -> Iterator[Places]:
    """Yield places where a value changes its sign, and places next to these, in all triangles with a change of sign.

    The value is 0 along a line. The crossings of this line with two sides of a triangle are yielded first, then their
    middle, then places slightly to both sides of these three.

    Parameters
    ----------
    values : ndarray
        Shape (m, 3): values at each triangle's corners, linear in between.
    """
    above = values > 0.0
    a, b, c = above.T
    rows = np.flatnonzero((a != b) | (b != c))
    rows = rows[np.isfinite(values[rows]).all(axis=1)]
    values, above = values[rows], above[rows]
    alone = odd_corner(above)
    turn = (alone[:, None] + np.arange(3)) % 3
    values = np.take_along_axis(values, turn, axis=1)
    crossing = values[:, :1] / (values[:, :1] - values[:, 1:])
    for aside in (0.0, -_ASIDE, _ASIDE):
        along = np.clip(crossing + aside, 0.0, 1.0)
        ends = np.zeros((2, len(rows), 3))
        for end in range(2):
            np.put_along_axis(ends[end], turn[:, :1], 1.0 - along[:, end : end + 1], axis=1)
            np.put_along_axis(ends[end], turn[:, end + 1 : end + 2], along[:, end : end + 1], axis=1)
        for weights in (*ends, ends.mean(axis=0)):
            yield Places(rows, weights)
