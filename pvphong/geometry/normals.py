"""Unit normals of polygons, of meshes' points, of planes and of implicit surfaces.

Meshes come as plain arrays here, in VTK's form: `connectivity` lists the point indices of all faces one after
the other, and `offsets` says where each face starts. What has no normal gets the zero vector, which is unlit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NoReturn, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pvphong.base import check
from pvphong.base.float_range import common_integers
from pvphong.base.types import Float64Array, Weighting
from pvphong.geometry.faces import FaceBlock, Faces
from pvphong.geometry.transform import normalize, normalize_columns

# How a weight grows with the size of its face: as length to this power.
_POWER: dict[str, int] = {"angle": 0, "area": 2, "max": -2}

# A sum of weighted normals is made of rounding alone where it is at most this many times the sum of the weights.
_NOISE = 16 * 2.0**-53

# The level of a point that no face touches: below every other, and far from the integers' end.
_NO_LEVEL = -(2**20)

# Points whose sums are made unit vectors at once.
_POINTS_AT_ONCE = 2**14


def polygon_normals(points: ArrayLike, connectivity: ArrayLike, offsets: ArrayLike) -> Float64Array:
    """Unit normals of the polygons of a mesh; the order of the corners, counter-clockwise, gives the front.

    Edges are subtracted in float64 before they are multiplied, and scaled by a power of two where their
    products would leave its range. For a triangle with longest edge L and least height h the error is within
    8 * 2**-53 * L / h wherever the mesh lies in the world.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), any real type.
    connectivity : array_like of int
        The point indices of all faces, one face after the other.
    offsets : array_like of int
        Shape (n_faces + 1,): where each face starts in `connectivity`, and the end. Faces may have any number
        of corners; a polygon that is not flat has the normal of its projected areas (Newell's).

    Returns
    -------
    ndarray
        Shape (n_faces, 3), float64. A face without an area (fewer than 3 corners, duplicate or collinear
        points, an area that is lost in the rounding of its own edges) or with a point that is not finite has
        the zero vector.

    Raises
    ------
    ValueError
        If an index is none of a point's, with the face and the index, or if the arrays do not fit together.
    """
    faces = Faces(points, connectivity, offsets)
    result = np.zeros((faces.count, 3))
    for block in faces.blocks():
        areas = block.area_vectors()
        normalize_columns(areas, areas)
        result[block.faces] = areas.T
    return result


def point_normals(
    points: ArrayLike, connectivity: ArrayLike, offsets: ArrayLike, weighting: Weighting = "angle"
) -> Float64Array:
    """Unit normals of the points of a mesh: weighted means of the normals of the faces around each.

    Parameters
    ----------
    points, connectivity, offsets : array_like
        As for `polygon_normals`.
    weighting : {"angle", "area", "max"}
        A face's weight at a corner: its angle there [1]_, which no other way of cutting the same surface into
        faces can change, 180° at a point that stands where the one before or after it does; its area; or sine of the
        angle / product of the two edges' lengths [2]_, which is exact on a sphere.

    Returns
    -------
    ndarray
        Shape (n, 3), float64, one row per point. A point has the zero vector if no face with a normal touches
        it or if its weighted normals cancel. A face without a normal has no weight, so that a NaN spoils
        no neighbour. Renumbering the points changes no bit; another order of the faces may change the last.

    Raises
    ------
    ValueError
        As `polygon_normals`, or for another weighting.

    References
    ----------
    .. [1] G. Thürmer, C. A. Wüthrich: Computing vertex normals from polygonal facets. Journal of Graphics
       Tools 3 (1998), 43-46.
    .. [2] N. Max: Weights for computing vertex normals from facet normals. Journal of Graphics Tools 4
       (1999), 1-6.
    """
    check.choice("weighting", weighting, get_args(Weighting))
    faces = Faces(points, connectivity, offsets)
    levels = _levels(faces, _POWER[weighting])
    sums, total = np.zeros((faces.n_points, 3)), np.zeros(faces.n_points)
    for block in faces.blocks():
        areas = block.area_vectors()
        weights = _weights(block, areas, weighting)
        if levels is not None:
            weights = np.ldexp(weights, _POWER[weighting] * block.exponents - levels[block.corners].T)
        normalize_columns(areas, areas)
        index, terms = block.corners.ravel(), np.empty(block.corners.shape)  # face by face, as they are added
        np.abs(weights, out=terms.T)
        np.add.at(total, index, terms.ravel())
        for axis in range(3):
            np.multiply(weights, areas[axis], out=terms.T)
            np.add.at(sums[:, axis], index, terms.ravel())
    for start in range(0, faces.n_points, _POINTS_AT_ONCE):
        part = slice(start, start + _POINTS_AT_ONCE)
        _finish(sums[part].T, total[part])
    return sums


def _finish(sums: Float64Array, total: Float64Array) -> None:
    """Make the columns of sums unit vectors; those that are made of rounding alone become zero."""
    noise = np.logical_and.reduce(np.abs(sums) <= _NOISE * total, axis=0)
    if noise.any():
        sums[:, noise] = 0.0
    normalize_columns(sums, sums)


def plane_normal(*plane: Any) -> Float64Array:
    """Unit normal of a plane from its coefficients, or from three of its points.

    ``plane_normal(a, b, c)`` and ``plane_normal(a, b, c, d)`` take the plane ax + by + cz + d = 0;
    ``plane_normal(p, q, r)`` takes points, three numbers each. Either also comes as one sequence or array.

    Parameters
    ----------
    *plane : float or array_like
        Three or four coefficients, or three points. Seen from the front, p, q, r run counter-clockwise.

    Returns
    -------
    ndarray
        Shape (3,), float64: computed exactly from the given numbers and rounded once, so that points that are
        only nearly collinear give the right normal too.

    Raises
    ------
    ValueError
        If a, b and c are all zero, the points are exactly collinear, or something is not a finite number.
    """
    items = plane[0] if len(plane) == 1 else plane
    if not isinstance(items, (list, tuple, np.ndarray)) or len(items) not in (3, 4):
        _refuse_plane(items)
    if len(items) == 3 and all(np.ndim(item) == 1 for item in items):
        p, q, r = (check.vector(name, item) for name, item in zip("pqr", items, strict=True))
        return _exact_unit(_exact_cross(p, q, r), f"p={p}, q={q}, r={r}", "three points that are not collinear")
    if any(np.ndim(item) != 0 for item in items):
        _refuse_plane(items)
    coefficients = check.numbers_in("plane", items, len(items))
    return _exact_unit(common_integers(coefficients[:3]), str(coefficients), "coefficients with a, b, c not all zero")


def implicit_normals(gradient: Callable[[Float64Array], ArrayLike] | ArrayLike, points: ArrayLike) -> Float64Array:
    """Unit normals of an implicit surface f(x, y, z) = 0 at points on it: the direction of its gradient.

    Parameters
    ----------
    gradient : callable or array_like
        Takes (n, 3) float64 points and gives the (n, 3) gradients of f there; or those gradients themselves.
        For the unit sphere, f = x² + y² + z² - 1, that is ``lambda p: p`` up to a factor.
    points : array_like
        Shape (n, 3), any real type. The callable gets a copy.

    Returns
    -------
    ndarray
        Shape (n, 3), float64. Where the gradient is zero (a cone's tip) or not finite, the normal is zero.

    Raises
    ------
    ValueError
        If `points` is not (n, 3), or the gradients are not (n, 3) real numbers.
    """
    rows = check.array("points", points)
    gradients = gradient(rows.astype(np.float64)) if callable(gradient) else gradient
    return normalize(check.array("gradient", gradients, count=len(rows)))


def _weights(block: FaceBlock, areas: Float64Array, weighting: Weighting) -> Float64Array:
    """(k, m) weights of a block's corners, in units of 2**(power * exponents); zero in a face without a normal."""
    if weighting == "area":
        return np.broadcast_to(np.sqrt(_dot(areas, areas)), block.corners.T.shape)
    before = np.roll(block.edges, 1, axis=1)
    crosses = _cross(before, block.edges)
    sines = np.sqrt(_dot(crosses, crosses))  # times the two edges' lengths, as are the cosines
    if len(sines) > 3:  # a reflex corner turns against the face's normal; a triangle has none
        np.negative(sines, out=sines, where=_dot(crosses, areas[:, None]) < 0.0)
    if weighting == "angle":
        cosines = _dot(before, block.edges)
        cosines += 0.0  # no -0, or a corner on a doubled point would turn by 0° or 180° as its axes' signs have it
        weights = np.arctan2(sines, np.negative(cosines, out=cosines))
        if len(sines) > 3:
            weights[weights < 0.0] += 2.0 * math.pi
    else:
        squares = _dot(block.edges, block.edges)
        products = squares * np.roll(squares, 1, axis=0)
        weights = np.divide(sines, products, out=np.zeros_like(sines), where=products >= np.finfo(np.float64).tiny)
    degenerate = ~areas.any(axis=0)
    if degenerate.any():
        weights[:, degenerate] = 0.0
    return weights


def _levels(faces: Faces, power: int) -> NDArray[np.int32] | None:
    """Exponents (n,) that keep every point's sum of weights in range; None where none is needed, as nearly always."""
    if power == 0 or not any(block.exponents.any() for block in faces.blocks()):
        return None
    levels = np.full(faces.n_points, _NO_LEVEL, dtype=np.int32)
    for block in faces.blocks():
        own = np.where(block.area_vectors().any(axis=0), power * block.exponents, _NO_LEVEL)
        np.maximum.at(levels, block.corners.ravel(), np.repeat(own, block.corners.shape[1]))
    return levels


def _dot(a: Float64Array, b: Float64Array) -> Float64Array:
    result: Float64Array = a[0] * b[0]
    result += a[1] * b[1]
    result += a[2] * b[2]
    return result


def _cross(a: Float64Array, b: Float64Array) -> Float64Array:
    result = np.empty_like(a)
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        np.multiply(a[one], b[two], out=result[axis])
        result[axis] -= a[two] * b[one]
    return result


def _exact_cross(*points: tuple[float, float, float]) -> list[int]:
    """(q - p) × (r - p), exactly, times a positive factor."""
    integers = common_integers([coordinate for point in points for coordinate in point])
    a, b, c = (integers[3 + axis] - integers[axis] for axis in range(3))
    d, e, f = (integers[6 + axis] - integers[axis] for axis in range(3))
    return [b * f - c * e, c * d - a * f, a * e - b * d]


def _exact_unit(normal: list[int], got: str, allowed: str) -> Float64Array:
    if not any(normal):
        check.refuse("plane", got, allowed)
    square = sum(entry * entry for entry in normal)
    guard = 64  # bits of the root beyond the integers' own, so that its truncation does not show
    root = math.isqrt(square << 2 * guard)
    return np.array([(entry << guard) / root for entry in normal])


def _refuse_plane(items: object) -> NoReturn:
    check.refuse("plane", items, "(a, b, c), (a, b, c, d) or three points", "Each point has three numbers.")
