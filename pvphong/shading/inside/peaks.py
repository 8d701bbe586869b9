"""Where inside triangles lights are brightest: samples that no fixed pattern would hit.

A peak is where a vector that varies over the triangle is shortest: the chord D between mirror direction and
viewer (or between half-way direction and normal) for a highlight, the offset from a spot's axis, the offset from
a light at a position.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from pvphong.base.types import BoolArray, Float64Array, IntArray
from pvphong.base.vectors import columns, dot, towards, unit
from pvphong.shading.equation import Equation, LightTerm

# Step, in barycentric coordinates, of the differences by which a highlight's chord is followed.
_STEP = 2.0**-12

# Nearer to a corner than this, a peak is at it.
_AT_CORNER = 2.0**-20

# Each turn squares the distance to a highlight's peak.
_TURNS = 5

# Half of n |D|² beyond which a highlight of shininess n is below 1e-9.
_INVISIBLE = 21.0

Offsets = Callable[[Float64Array, Float64Array], Float64Array]
"""From points and normals (k, 3) to the vectors (k, 3) that are shortest at a peak."""


class Places(NamedTuple):
    """One place in each of some triangles."""

    rows: IntArray
    """(k,): the triangles."""

    weights: Float64Array
    """(k, 3): where in each, in barycentric coordinates."""


def peaks(points: Float64Array, normals: Float64Array, equation: Equation) -> Iterator[Places]:
    """Where every light's share is largest, in triangles that do not have it at a corner.

    Parameters
    ----------
    points, normals : ndarray
        Shape (m, 3, 3): each triangle's corners in the world. Normals need no unit length.
    equation : Equation
        The lights and the viewer.
    """
    sharpness = equation.reflectance.sharpness
    for term in equation.terms:
        for offsets in term.light.offsets(columns(points.reshape(-1, 3))):
            yield _linear_peaks(offsets.T.reshape(points.shape))
        if sharpness > 0.0 and equation.has(term, "specular"):
            yield _highlights(chords(term, equation), points, normals, sharpness)


def to_viewer(points: Float64Array, equation: Equation) -> Float64Array:
    """Unit vectors v to the viewer, (3, k), or (3, 1) where they are all the same, from points (3, k)."""
    return np.array(equation.to_eye)[:, None] if equation.eye is None else towards(equation.eye, points)[0]


def chords(term: LightTerm, equation: Equation) -> Offsets:
    """D, whose half square is one minus the cosine that a highlight is a power of; see `pvphong.shading.reference`."""

    def offsets(points: Float64Array, normals: Float64Array) -> Float64Array:
        p, n = columns(points), unit(columns(normals))[0]
        v, to_light = to_viewer(p, equation), term.light.arrival(p).direction
        if equation.two_sided:
            n = np.where(dot(n, v) < 0.0, -n, n)
        peak = equation.reflectance.peak
        assert peak is not None, "only reflectances with a peak are sharp"
        return np.stack(np.broadcast_arrays(*peak.chord(n, to_light, v)), axis=1)

    return offsets


def _linear_peaks(offsets: Float64Array) -> Places:
    weights = _shortest(offsets)
    rows = np.flatnonzero(_off_corners(weights))
    return Places(rows, weights[rows])


def _highlights(chord: Offsets, points: Float64Array, normals: Float64Array, shininess: float) -> Places:
    """By Gauss-Newton steps, in triangles that are large against the highlight; a fixed pattern serves the others.

    A chord's length bends by less than a quarter of the square of its spread over the triangle, so that
    triangles too far from the highlight are passed over.
    """
    at_corners = _at_corners(chord, points, normals)
    spread = np.abs(at_corners - np.roll(at_corners, 1, axis=1)).max(axis=(1, 2))
    weights = _shortest(at_corners)
    nearest = np.linalg.norm(_blend(weights, at_corners), axis=1)
    large = spread * math.sqrt(shininess) > 1.0
    rows = np.flatnonzero(large & (nearest - spread**2 / 4.0 < math.sqrt(2.0 * _INVISIBLE / shininess)))
    p, n, weights = points[rows], normals[rows], weights[rows]
    for _ in range(_TURNS):
        weights = _shortest(_expanded(chord, p, n, weights))
    keep = _off_corners(weights)
    return Places(rows[keep], weights[keep])


def _expanded(chord: Offsets, points: Float64Array, normals: Float64Array, weights: Float64Array) -> Float64Array:
    """(k, 3, 3): at the corners, the linear expansion of the chords about a place in each triangle."""
    here = chord(_blend(weights, points), _blend(weights, normals))
    result = np.empty_like(points)
    for corner in range(3):
        aside = (1.0 - _STEP) * weights
        aside[:, corner] += _STEP
        there = chord(_blend(aside, points), _blend(aside, normals))
        result[:, corner] = here + (there - here) / _STEP
    return result


def _at_corners(offsets: Offsets, points: Float64Array, normals: Float64Array) -> Float64Array:
    return offsets(points.reshape(-1, 3), normals.reshape(-1, 3)).reshape(points.shape)


def _blend(weights: Float64Array, at_corners: Float64Array) -> Float64Array:
    return np.einsum("ki,kij->kj", weights, at_corners)


def _off_corners(weights: Float64Array) -> BoolArray:
    return weights.max(axis=1) < 1.0 - _AT_CORNER


def _shortest(at_corners: Float64Array) -> Float64Array:
    """Barycentric coordinates (k, 3) of the shortest among the blends of three vectors (k, 3, 3).

    The nearest point of a triangle to the origin: the foot of the perpendicular if it lies inside, else the
    nearest of the three sides' nearest points (C. Ericson: Real-Time Collision Detection (2005), section 5.1.5).
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
    inside = (r >= 0.0) & (s >= 0.0) & (t >= 0.0)  # a NaN is outside
    result = np.stack([r, s, t], axis=1)
    outside = np.flatnonzero(~inside)
    result[outside] = _shortest_on_sides(at_corners[outside])
    return result


def _shortest_on_sides(at_corners: Float64Array) -> Float64Array:
    weights = np.zeros((3, len(at_corners), 3))
    lengths = np.empty((3, len(at_corners)))
    for side in range(3):
        p, q = at_corners[:, side], at_corners[:, (side + 1) % 3]
        pq = q - p
        square = np.einsum("ki,ki->k", pq, pq)
        along = np.einsum("ki,ki->k", -p, pq) / np.where(square > 0.0, square, 1.0)
        along = np.clip(along, 0.0, 1.0)
        weights[side, :, side], weights[side, :, (side + 1) % 3] = 1.0 - along, along
        lengths[side] = np.linalg.norm(p + along[:, None] * pq, axis=1)
    return weights[lengths.argmin(axis=0), np.arange(len(at_corners))]
