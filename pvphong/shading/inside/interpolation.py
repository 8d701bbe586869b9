"""How far colours interpolated across triangles are from the lit ones: samples, and what they miss.

The colour inside a triangle is the linear blend of the colours at its corners. The truth is the lighting
equation at the blended point with the blended normal, made unit length: per-pixel shading.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import NamedTuple

import numpy as np

from pvphong.base.types import BoolArray, Float64Array, IntArray
from pvphong.geometry.transform import normal_matrix, transform_points
from pvphong.shading.inside.creases import creases, sign_changes
from pvphong.shading.inside.lit_vertices import Lighting, LitVertices, sizes
from pvphong.shading.inside.peaks import Places, peaks

# Samples that are held in memory at a time.
_SAMPLES = 2**18

# Over a triangle, the ratio of a normal's two lengths may vary by this much and change no colour.
_SAME_RATIO = 1e-4

# Halvings of a distance after which a difference that is still there is a jump.
_HALVINGS = 20

# An error from which on triangles are searched for jumps.
_LARGE = 1.0 / 255.0


def _lattice(order: int) -> Float64Array:
    """Barycentric coordinates (s, 3) in multiples of 1/order, without the corners."""
    steps = [(i, j, order - i - j) for i in range(order + 1) for j in range(order + 1 - i)]
    return np.array([step for step in steps if max(step) < order]) / order


_FIRST = np.concatenate([_lattice(2), np.full((1, 3), 1.0 / 3.0)])
_MORE = np.array([weights for weights in _lattice(4) if (weights * 2.0 % 1.0).any()])
_ALL = np.concatenate([_FIRST, _MORE])
_DENSE = _lattice(8)


def first_errors(vertices: LitVertices, corners: IntArray, lighting: Lighting) -> Float64Array:
    """Largest error (m,) of triangles (m, 3) at middles of sides, centroids, and where colours peak, bend or jump."""
    result = _errors(vertices, corners, _FIRST, lighting)
    step = _SAMPLES // 8
    for start in range(0, len(corners), step):
        part = corners[start : start + step]
        places = chain(_peaks(vertices, part, lighting), _creases(vertices, part, lighting))
        worst = _worst_of(places, vertices, part, lighting)
        result[start + worst.rows] = np.maximum(result[start + worst.rows], worst.errors)
    return result


def more_errors(vertices: LitVertices, corners: IntArray, lighting: Lighting) -> Float64Array:
    """Largest error (m,) at further samples, and with the stored normals blended."""
    result = _errors(vertices, corners, _MORE, lighting)
    rows = np.flatnonzero(_blend_differently(vertices, corners))
    others = replace(vertices, normals=vertices.stored)
    for errors in (first_errors(others, corners[rows], lighting), _errors(others, corners[rows], _MORE, lighting)):
        result[rows] = np.maximum(result[rows], errors)
    return result


def dense_errors(vertices: LitVertices, corners: IntArray, lighting: Lighting) -> Float64Array:
    """Largest error (m,) at samples so dense that hardly anything lies between them."""
    return _errors(vertices, corners, _DENSE, lighting)


def all_errors(vertices: LitVertices, corners: IntArray, lighting: Lighting) -> Float64Array:
    """Largest error (m,) at every sample; 0 in triangles without an area, or with a point that is not finite."""
    result = np.zeros(len(corners))
    rows = np.flatnonzero(sizes(vertices.points[corners])[1] > 0.0)
    shown = corners[rows]
    errors = np.maximum(first_errors(vertices, shown, lighting), more_errors(vertices, shown, lighting))
    large = np.flatnonzero(errors >= _LARGE)
    errors[large] = np.maximum(errors[large], jumps(vertices, shown[large], lighting).errors)
    result[rows] = errors
    return result


@dataclass(frozen=True)
class Jumps:
    """The largest step of the colour that was found in each of some triangles."""

    sizes: Float64Array
    """(m,): difference of the colours on its two sides; 0 where colours are continuous."""

    errors: Float64Array
    """(m,): the error beside it."""


def jumps(vertices: LitVertices, corners: IntArray, lighting: Lighting) -> Jumps:
    """Look for steps of the colour, which no splitting would cure."""
    result = Jumps(np.zeros(len(corners)), np.zeros(len(corners)))
    step = _SAMPLES // len(_ALL)
    for start in range(0, len(corners), step):
        part = slice(start, start + step)
        result.sizes[part], result.errors[part] = _jumps(vertices, corners[part], lighting)
    return result


def _jumps(vertices: LitVertices, corners: IntArray, lighting: Lighting) -> tuple[Float64Array, Float64Array]:
    """From the worst sample to the corner whose colour differs most from it: the half that keeps more of the
    difference, again and again. What is left of the difference is a jump.
    """
    near = _worst_place(vertices, corners, lighting)
    near_color = _truth(vertices, corners, near[:, None], lighting)[:, 0]
    at_corners = lighting.shown(vertices.colors[corners])
    corner = _largest(at_corners - near_color[:, None]).argmax(axis=1)
    far, far_color = np.eye(3)[corner], at_corners[np.arange(len(corners)), corner]
    for _ in range(_HALVINGS):
        middle = (near + far) / 2.0
        color = _truth(vertices, corners, middle[:, None], lighting)[:, 0]
        near_half = (_largest(color - near_color) >= _largest(color - far_color))[:, None]
        far, far_color = np.where(near_half, middle, far), np.where(near_half, color, far_color)
        near, near_color = np.where(near_half, near, middle), np.where(near_half, near_color, color)
    beside = _misses(vertices, corners, np.stack([near, far], axis=1), lighting)
    return _largest(far_color - near_color), beside.max(axis=1)


class _Worst(NamedTuple):
    rows: IntArray
    weights: Float64Array
    errors: Float64Array


def _worst_place(vertices: LitVertices, corners: IntArray, lighting: Lighting) -> Float64Array:
    """Barycentric coordinates (m, 3) of the sample with the largest error; peaks are left out."""
    missed = _misses(vertices, corners, _ALL, lighting)
    result, errors = _ALL[missed.argmax(axis=1)], missed.max(axis=1)
    worst = _worst_of(_creases(vertices, corners, lighting), vertices, corners, lighting)
    worse = worst.errors > errors[worst.rows]
    result[worst.rows[worse]] = worst.weights[worse]
    return result


def _worst_of(places: Iterable[Places], vertices: LitVertices, corners: IntArray, lighting: Lighting) -> _Worst:
    """In each triangle that has any of the places, the one with the largest error."""
    places = list(places)
    rows = np.concatenate([np.empty(0, dtype=np.intp), *(place.rows for place in places)])
    weights = np.concatenate([np.empty((0, 3)), *(place.weights for place in places)])
    errors = _misses(vertices, corners[rows], weights[:, None], lighting)[:, 0]
    order = np.lexsort([errors, rows])
    last = order[np.diff(rows[order], append=-1) != 0]  # of each row
    return _Worst(rows[last], weights[last], errors[last])


def _peaks(vertices: LitVertices, corners: IntArray, lighting: Lighting) -> Iterator[Places]:
    return peaks(*_in_world(vertices, corners, lighting), lighting.equation)


def _creases(vertices: LitVertices, corners: IntArray, lighting: Lighting) -> Iterator[Places]:
    yield from creases(*_in_world(vertices, corners, lighting), lighting.equation)
    if lighting.scene.light_model.clamp:
        for channel in range(3):
            yield from sign_changes(vertices.colors[corners, channel] - 1.0)


def _in_world(vertices: LitVertices, corners: IntArray, lighting: Lighting) -> tuple[Float64Array, Float64Array]:
    """Points and normals (m, 3, 3) of triangles; the matrix takes the normals' lengths along."""
    points, normals, matrix = vertices.points[corners], vertices.normals[corners], lighting.matrix
    if matrix is None:
        return points, normals
    return transform_points(points.reshape(-1, 3), matrix).reshape(points.shape), normals @ normal_matrix(matrix).T


def _errors(vertices: LitVertices, corners: IntArray, samples: Float64Array, lighting: Lighting) -> Float64Array:
    """Largest error (m,) at samples (s, 3) that are the same for all triangles."""
    result = np.zeros(len(corners))
    step = _SAMPLES // len(samples)
    for start in range(0, len(corners), step):
        part = slice(start, start + step)
        result[part] = _misses(vertices, corners[part], samples, lighting).max(axis=1)
    return result


def _misses(vertices: LitVertices, corners: IntArray, weights: Float64Array, lighting: Lighting) -> Float64Array:
    """(m, s): difference of blended and lit colours, in the worst channel, at weights (s, 3) or (m, s, 3)."""
    blended = weights @ lighting.shown(vertices.colors[corners])
    return _largest(blended - _truth(vertices, corners, weights, lighting))


def _truth(vertices: LitVertices, corners: IntArray, weights: Float64Array, lighting: Lighting) -> Float64Array:
    points, normals = weights @ vertices.points[corners], weights @ vertices.normals[corners]
    shades = None if vertices.shades is None else (weights @ vertices.shades[corners]).reshape(-1, 3)
    colors = lighting.colors(points.reshape(-1, 3), normals.reshape(-1, 3), shades)
    return lighting.shown(colors).reshape(points.shape)


def _largest(colors: Float64Array) -> Float64Array:
    return np.abs(colors).max(axis=-1)


def _blend_differently(vertices: LitVertices, corners: IntArray) -> BoolArray:
    """Where the two lengths of the normals are in different proportions at the corners."""
    length, stored = (np.linalg.norm(normals, axis=1) for normals in (vertices.normals, vertices.stored))
    ratio = np.divide(length, stored, out=np.ones_like(length), where=stored > 0.0)[corners]
    result: BoolArray = np.ptp(ratio, axis=1) > _SAME_RATIO * ratio.max(axis=1)
    return result
