"""Errors of colours that are interpolated across triangles: the largest error in each triangle, and jumps.

Colours are compared at a fixed pattern of samples, and at peaks and creases, which no fixed pattern hits (see
`places`).

Several functions have the argument `enough`, a size of error. Errors above `enough` are exact. Errors below it may be
underestimated, which saves rays to lights with a size; so may a larger error on a side at which the light jumps, if it
is small inside. `corners`, shape (m, 3), are the vertices of m triangles.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import chain

import numpy as np

from pvphong.base import text, threads
from pvphong.base.types import Float64Array, IntArray
from pvphong.shading.inside.lighting import ComparedColors, LitVertices, blended, difference, largest, lit_inside
from pvphong.shading.inside.places import Places, creases, lattice, peaks, sizes

# Samples per block of a thread. The second number is for samples that may take a thousand rays each: small blocks
# report progress often.
_SAMPLES, _SAMPLES_BY_RAYS = 2**17, 2**12

_FIRST = np.concatenate([lattice(2), np.full((1, 3), 1.0 / 3.0)])
_MORE = np.array([weights for weights in lattice(4) if (weights * 2.0 % 1.0).any()])
_ALL = np.concatenate([_FIRST, _MORE])
DENSE = lattice(8)
"""Dense samples in a triangle. Errors between these samples are hardly larger than at them."""

# Each normal has two lengths: `LitVertices.normals` and `LitVertices.stored`. If their ratio varies over a triangle by
# at most this fraction, blends of both kinds of normals have practically the same direction.
_SAME_RATIO = 1e-4

# Number of bisections of a distance. A difference that remains after them is a jump.
_HALVINGS = 20

# Number of standard errors below which a difference counts as noise, which no splitting reduces.
_SURE = 3.0

# Least error of triangles that are searched for jumps.
_LARGE = 1.0 / 255.0


def _errors_at(
    vertices: LitVertices, corners: IntArray, weights: Float64Array, enough: float | None = None
) -> Float64Array:
    """Return the difference of interpolated and exact colours at places, shape (m, s), in the worst channel.

    `weights` are the barycentric coordinates of s places in each triangle, shape (m, s, 3) or (s, 3). Lights with a
    size are sampled. Only the part of a difference that exceeds the noise of the samples counts. With `enough`,
    differences below it may be underestimated. `corners`, shape (m, 3), are the vertices of m triangles.
    """
    shape = len(corners), weights.shape[-2]
    colors = blended(vertices.colors, corners, weights, *vertices.lighting.limits).reshape(*shape, 3)
    if not vertices.lighting.soft:
        return difference(colors, lit_inside(vertices, corners, weights)[0])
    noise_of_corners = _SURE * blended(vertices.noise[:, None], corners, weights).reshape(shape)
    # The noise of the rays at the place is not part of the threshold: `Goal.is_reached` accounts for it.
    compared = None if enough is None else ComparedColors(colors, enough + noise_of_corners)
    truth, noise = lit_inside(vertices, corners, weights, compared)
    return np.maximum(difference(colors, truth) - _SURE * noise - noise_of_corners, 0.0)


def first_errors(vertices: LitVertices, corners: IntArray, enough: float | None = None) -> Float64Array:
    """Return the largest error in each triangle at the middles of sides, centroids, peaks and creases, shape (m,).

    `corners`, shape (m, 3), are the vertices of m triangles. With `enough`, errors below it may be underestimated. This
    saves rays.
    """
    result = pattern_errors(_FIRST, vertices, corners, enough)

    def look(part: slice) -> None:
        there = vertices, corners[part]
        rows, _, errors = _worst(chain(peaks(*there), creases(*there)), *there, enough)
        result[part][rows] = np.maximum(result[part][rows], errors)

    _in_parts(look, vertices, len(corners), 8)
    return result


def more_errors(vertices: LitVertices, corners: IntArray, enough: float | None = None) -> Float64Array:
    """Return the largest error in each triangle at the samples that `first_errors` does not take, shape (m,).

    `corners`, shape (m, 3), are the vertices of m triangles. With `enough`, errors below it may be underestimated.

    The renderer blends the normals that are stored in the mesh. If these blends have other directions than blends of
    `vertices.normals`, the errors at all samples are also computed with the stored normals.
    """
    result = pattern_errors(_MORE, vertices, corners, enough)
    length, stored = (np.linalg.norm(normals, axis=1) for normals in (vertices.normals, vertices.stored))
    ratio = np.divide(length, stored, out=np.ones_like(length), where=stored > 0.0)
    if ratio.max(initial=0.0) - ratio.min(initial=math.inf) <= _SAME_RATIO * ratio.min(initial=math.inf):
        return result
    ratio = ratio.take(corners)
    most = largest(ratio)
    rows = np.flatnonzero(most + largest(-ratio) > _SAME_RATIO * most)  # the directions of the blends differ
    others = vertices.as_stored, corners[rows]
    errors = np.maximum(first_errors(*others, enough), pattern_errors(_MORE, *others, enough))
    result[rows] = np.maximum(result[rows], errors)
    return result


def all_errors(vertices: LitVertices, corners: IntArray) -> Float64Array:
    """Return the largest error in each triangle at all samples and next to jumps, shape (m,).

    `corners`, shape (m, 3), are the vertices of m triangles. The error is 0 in triangles without an area or with a
    point that is not finite.
    """
    result = np.zeros(len(corners))
    rows = np.flatnonzero(sizes(vertices.points, corners)[1] > 0.0)
    shown = corners if len(rows) == len(corners) else corners[rows]
    errors = np.maximum(first_errors(vertices, shown), more_errors(vertices, shown))
    large = np.flatnonzero(errors >= _LARGE)
    _, beside_jumps = jumps(vertices, shown[large])
    errors[large] = np.maximum(errors[large], beside_jumps)
    result[rows] = errors
    return result


def jumps(vertices: LitVertices, corners: IntArray) -> tuple[Float64Array, Float64Array]:
    """Return the size of the colour's jump in each triangle, and the error next to the jump, shape (m,) each.

    `corners`, shape (m, 3), are the vertices of m triangles. Splitting triangles cannot reduce a jump. The search
    starts with a segment from the worst sample, peaks excluded, to the corner whose colour differs most from that
    sample's. It bisects the segment repeatedly, and keeps the half with the larger difference of colours. The
    difference that remains is the jump.
    """
    steps, errors = np.zeros((2, len(corners)))

    def look(part: slice) -> None:
        some = corners[part]
        at_samples = _errors_at(vertices, some, _ALL)
        near = _ALL[at_samples.argmax(axis=1)]
        rows, weights, at_creases = _worst(creases(vertices, some), vertices, some)
        is_worse = at_creases > at_samples.max(axis=1)[rows]
        near[rows[is_worse]] = weights[is_worse]
        near_color = lit_inside(vertices, some, near[:, None])[0][:, 0]
        at_corners = vertices.lighting.shown(vertices.colors[some])
        corner = difference(at_corners, near_color[:, None]).argmax(axis=1)
        far, far_color = np.eye(3)[corner], at_corners[np.arange(len(some)), corner]
        for _ in range(_HALVINGS):
            middle = (near + far) / 2.0
            color = lit_inside(vertices, some, middle[:, None])[0][:, 0]
            near_half = (difference(color, near_color) >= difference(color, far_color))[:, None]
            far, far_color = np.where(near_half, middle, far), np.where(near_half, color, far_color)
            near, near_color = np.where(near_half, near, middle), np.where(near_half, near_color, color)
        steps[part] = difference(far_color, near_color)
        if vertices.lighting.soft:
            noise = lit_inside(vertices, some, np.stack([near, far], axis=1))[1].sum(axis=1)
            steps[part] = np.maximum(steps[part] - _SURE * noise, 0.0)
        errors[part] = _errors_at(vertices, some, np.stack([near, far], axis=1)).max(axis=1)

    _in_parts(look, vertices, len(corners), len(_ALL))
    return steps, errors


def pattern_errors(
    pattern: Float64Array, vertices: LitVertices, corners: IntArray, enough: float | None = None
) -> Float64Array:
    """Return the largest error in each triangle at the places of `pattern`, shape (m,).

    `pattern` are barycentric coordinates, shape (s, 3), with the permutations of each of its places, as `lattice` gives
    them. `corners`, shape (m, 3), are the vertices of m triangles. With `enough`, errors below it may be
    underestimated: under lights with a size, the places on a side that several triangles share are then sampled in one
    of them. Another triangle samples its own only if the error there or inside it exceeds `enough`: from each side of
    the foot of a wall, for example, other parts of the light are visible.
    """
    if enough is None or not vertices.lighting.soft:
        return _largest_errors(pattern, vertices, corners, enough)
    inside, on_first_side = pattern[(pattern > 0.0).all(axis=1)], pattern[pattern[:, 2] == 0.0]
    result = _largest_errors(inside, vertices, corners, enough)
    turned = corners[:, [[0, 1, 2], [1, 2, 0], [2, 0, 1]]].reshape(-1, 3)  # each side as the first one
    low, high = np.sort(turned[:, :2], axis=1).T
    _, first, side = np.unique(low * len(vertices.points) + high, return_index=True, return_inverse=True)
    of_sides = _largest_errors(on_first_side, vertices, turned[first], enough)[side]
    others = (of_sides > enough) | np.repeat(result > enough, 3)
    others[first] = False
    of_sides[others] = _largest_errors(on_first_side, vertices, turned[others], enough)
    return np.maximum(result, largest(of_sides.reshape(-1, 3)))


def _largest_errors(
    pattern: Float64Array, vertices: LitVertices, corners: IntArray, enough: float | None
) -> Float64Array:
    """Return the result of `pattern_errors`, with samples at all places of the pattern in all triangles."""
    result = np.zeros(len(corners))

    def look(part: slice) -> None:
        result[part] = largest(_errors_at(vertices, corners[part], pattern, enough))

    if len(pattern):
        _in_parts(look, vertices, len(corners), len(pattern))
    return result


def _worst(
    places: Iterable[Places], vertices: LitVertices, corners: IntArray, enough: float | None = None
) -> tuple[IntArray, Float64Array, Float64Array]:
    """Return the place with the largest error in each triangle that contains any of the places.

    Parameters
    ----------
    places : iterable of Places
        Places in triangles; a triangle may have several.
    vertices : LitVertices
        Vertices of the mesh.
    corners : ndarray of int
        Vertices of all triangles, shape (m, 3).
    enough : float, optional
        Errors below `enough` may be underestimated. By default, no error is.

    Returns
    -------
    rows : ndarray of int
        Indices of the triangles that contain places, shape (k,).
    weights : ndarray
        Place of the largest error in each of these triangles, shape (k, 3).
    errors : ndarray
        Error at this place, shape (k,).
    """
    places = list(places)
    rows = np.concatenate([np.empty(0, dtype=np.intp), *(place.rows for place in places)])
    weights = np.concatenate([np.empty((0, 3)), *(place.weights for place in places)])
    errors = _errors_at(vertices, corners[rows], weights[:, None], enough)[:, 0]
    order = np.lexsort([errors, rows])
    last = order[np.diff(rows[order], append=-1) != 0]  # of each row
    return rows[last], weights[last], errors[last]


def _in_parts(look: Callable[[slice], None], vertices: LitVertices, triangles: int, samples: int) -> None:
    """Call `look` with one slice of the triangles after the other, on all cores, until all triangles are covered.

    `triangles` is the number of all triangles, and `samples` the number of samples that `look` takes in each.
    """
    handling = np.geterr()  # a new thread starts with NumPy's defaults
    step = (_SAMPLES_BY_RAYS if vertices.lighting.soft else _SAMPLES) // samples
    own = threads.count() if triangles <= step else 1  # several parts share the threads

    def work(first: int, last: int) -> None:
        with np.errstate(**handling), threads.limited(own):
            look(slice(first, last))

    with text.about("colours inside triangles"):
        threads.run(work, triangles, step)
