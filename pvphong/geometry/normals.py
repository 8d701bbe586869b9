"""Unit normals of polygons and points of a mesh, and tangents of points.

Meshes are plain arrays here, in VTK's form: `connectivity` lists the point indices of all faces one after the other,
and `offsets` gives the start of each face in `connectivity`. A point or face without a normal gets the zero vector and
is unlit.

In order:

- `Faces` checks the faces, and yields blocks of faces with the same number of corners. In each block, edges are scaled
  into a safe range.
- Normals of faces.
- Normals of points.
- Tangents of points.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pvphong.base import check, threads
from pvphong.base.types import Float64Array, IntArray, Weighting
from pvphong.base.vectors import columns, cross, dot, unit

# Corners per block, few enough that its arrays stay in a core's cache.
_BLOCK_CORNERS = 3 * 8192

# Faces whose longest edge is in this range are not scaled: fourth powers of edges do not overflow or underflow, even in
# slivers.
LEAST_SPAN, MOST_SPAN = 2.0**-100, 2.0**100

# Coordinates beyond this are divided by 4 before subtraction, so that no edge overflows.
_FAR = 2.0**1000

# A component of an area vector may be rounding error only: each product of two rounded edges has 3 roundings of
# 2**-53, and their difference one more. So a component up to this factor times the sum of its terms counts as 0.
NOISE_OF_AREA = 4 * 2.0**-53

# A sum of weighted normals up to this factor times the sum of the weights is rounding error; tangents also have the
# rounding errors of texture coordinates.
NOISE_OF_SUM, _NOISE_OF_TANGENTS = 16 * 2.0**-53, 2.0**-40

# A weight scales with the size of its face as length to this power.
_POWER: dict[str, int] = {"angle": 0, "area": 2, "max": -2}

# Level of a point without faces: below every other level, and far from integer overflow.
_NO_LEVEL = -(2**20)

# Points whose sums are normalized at once.
_POINTS_AT_ONCE = 2**14


@dataclass(frozen=True)
class FaceBlock:
    """Faces with the same number k of corners.

    Attributes
    ----------
    faces : ndarray
        Shape (m,), indices of the faces in the mesh.
    corners : ndarray
        Shape (m, k), point indices of the corners.
    edges : ndarray
        Shape (3, k, m): vectors from each corner to the next, in units of 2**exponents; zero in a face with a point
        that is not finite.
    spokes : ndarray
        Shape (3, k - 2, m): vectors from corner 0 to corners 1 … k - 2, in the same units.
    exponents : ndarray
        Shape (m,), exponents of the unit of each face; 0 for faces of usual size.
    """

    faces: IntArray
    corners: IntArray
    edges: Float64Array
    spokes: Float64Array
    exponents: NDArray[np.int32]

    def area_vectors(self) -> Float64Array:
        """Return vectors along the faces' normals, as long as twice the areas, shape (3, m); zero for degenerate faces.

        The vectors are in units of 2**(2 * exponents). Each is the sum of spoke × edge over the fan of triangles around
        corner 0, where a spoke is a vector from corner 0 to another corner. Newell's sum over the points (M. E. Newell,
        in Sutherland et al. 1974) loses digits far from the origin; this sum uses differences of points. The last
        triangle of the fan uses the edge back to corner 0. So for a triangular face, the vector is the cross product of
        the two edges at corner 0.
        """
        count = self.spokes.shape[1]
        total = np.zeros((3, len(self.faces)))
        terms = np.zeros_like(total)
        for spoke in range(count):
            side = self.edges[:, spoke + 1] if spoke < count - 1 else -self.edges[:, -1]
            for axis in range(3):
                one, two = (axis + 1) % 3, (axis + 2) % 3
                forth = self.spokes[one, spoke] * side[two]
                back = self.spokes[two, spoke] * side[one]
                total[axis] += forth - back
                terms[axis] += np.abs(forth) + np.abs(back)
        degenerate = np.logical_and.reduce(np.abs(total) <= NOISE_OF_AREA * terms, axis=0)
        if degenerate.any():
            total[:, degenerate] = 0.0
        return total


class Faces:
    """Polygons of a mesh, with checked indices.

    Parameters
    ----------
    points : array_like
        Shape (n, 3).
    connectivity : array_like of int
        Point indices of all faces, one face after the other.
    offsets : array_like of int
        Shape (n_faces + 1,): the start of each face in `connectivity`, and the end of the last.

    Raises
    ------
    ValueError
        For an index out of range (the message names the face), or for arrays that do not fit together.
    """

    def __init__(self, points: ArrayLike, connectivity: ArrayLike, offsets: ArrayLike) -> None:
        rows = check.array("points", points)
        self.connectivity, self.offsets = _integers("connectivity", connectivity), _integers("offsets", offsets)
        self.count, self.n_points, end = len(self.offsets) - 1, len(rows), len(self.connectivity)
        self.sizes = np.diff(self.offsets)  # number of corners per face
        if not len(self.offsets) or self.offsets[0] or self.offsets[-1] != end or self.sizes.min(initial=0) < 0:
            allowed = f"indices that rise from 0 to the connectivity's length, {end}"
            got = np.array2string(self.offsets, threshold=9)
            check.refuse("offsets", got, allowed, "Give the start of each face, and the end of the last.")
        if end and not (self.connectivity.min() >= 0 and self.connectivity.max() < self.n_points):
            first = int(np.flatnonzero((self.connectivity < 0) | (self.connectivity >= self.n_points))[0])
            face = int(np.searchsorted(self.offsets, first, side="right")) - 1
            allowed = f"indices of the {self.n_points} points, from 0 to {self.n_points - 1}"
            check.refuse(
                "connectivity",
                f"index {self.connectivity[first]} in face {face}",
                allowed if self.n_points else "empty if there are no points",
                "The faces may come from a file or code that counts points differently, for example from 1.",
            )
        self._rows = np.ascontiguousarray(rows)  # otherwise each block would copy them

    def blocks(self) -> Iterator[FaceBlock]:
        """Yield blocks of faces with the same number of corners; faces with fewer than 3 corners are skipped."""
        for size, alike, step in self._of_equal_size():
            for start in range(0, len(alike), step):
                yield self._block(alike[start : start + step], size)

    def in_blocks(self, work: Callable[[FaceBlock], object]) -> None:
        """Call the function `work` with each block that `blocks` yields, on all cores and in any order."""
        for size, alike, step in self._of_equal_size():
            threads.run(lambda first, last: work(self._block(alike[first:last], size)), len(alike), step)  # noqa: B023 it ends before the next size

    @cached_property
    def are_triangles(self) -> bool:
        """True if every face of the mesh is a triangle."""
        return bool((self.sizes == 3).all())

    def _of_equal_size(self) -> Iterator[tuple[int, IntArray, int]]:
        """Group the faces by their number of corners. Faces with fewer than 3 corners are left out.

        Yield for each group the number of corners, the indices of its faces, and the number of faces to process at
        once.
        """
        are_alike = self.count > 0 and bool((self.sizes == self.sizes[0]).all())
        for size in self.sizes[:1].tolist() if are_alike else np.unique(self.sizes).tolist():
            if size >= 3:
                alike = np.arange(self.count) if are_alike else np.flatnonzero(self.sizes == size)
                yield size, alike, max(_BLOCK_CORNERS // size, 1)

    def _block(self, faces: IntArray, size: int) -> FaceBlock:
        if faces[-1] - faces[0] == len(faces) - 1:  # consecutive faces
            corners = self.connectivity[self.offsets[faces[0]] : self.offsets[faces[-1] + 1]].reshape(-1, size)
        else:
            corners = self.connectivity[self.offsets[faces][:, None] + np.arange(size)]
        gathered = np.take(self._rows, corners, axis=0)  # several times faster than indexing
        points = np.ascontiguousarray(gathered.transpose(2, 1, 0), dtype=np.float64)
        with np.errstate(over="ignore", invalid="ignore"):
            edges, spokes = _edges_and_spokes(points)
            span = np.abs(edges).reshape(-1, len(corners)).max(axis=0)
        exponents = np.zeros(len(faces), dtype=np.int32)
        rare = ~((span >= LEAST_SPAN) & (span <= MOST_SPAN))  # NaN is rare too
        if rare.any():  # scale the edges so that the largest component is in [0.5, 1)
            odd = np.where(np.isfinite(points[:, :, rare]).all(axis=(0, 1)), points[:, :, rare], 0.0)
            quarters = -2 * (np.abs(odd).max(axis=(0, 1)) > _FAR).astype(np.int32)
            odd_edges, odd_spokes = _edges_and_spokes(np.ldexp(odd, quarters))
            levels = np.frexp(np.abs(odd_edges).max(axis=(0, 1)))[1]
            edges[:, :, rare], spokes[:, :, rare] = np.ldexp(odd_edges, -levels), np.ldexp(odd_spokes, -levels)
            exponents[rare] = levels - quarters
        return FaceBlock(faces, corners, edges, spokes, exponents)


def _edges_and_spokes(points: Float64Array) -> tuple[Float64Array, Float64Array]:
    edges = np.empty_like(points)
    np.subtract(points[:, 1:], points[:, :-1], out=edges[:, :-1])
    np.subtract(points[:, 0], points[:, -1], out=edges[:, -1])
    return edges, points[:, 1:-1] - points[:, :1]


def _integers(name: str, value: ArrayLike) -> IntArray:
    result = np.asarray(value)
    if result.ndim != 1 or (result.size and result.dtype.kind not in "iu"):
        check.refuse(
            name, f"an array of {result.dtype} with shape {result.shape}", "a one-dimensional array of integers"
        )
    return result.astype(np.intp, copy=False)


# --- normals of faces


def polygon_normals(points: ArrayLike, connectivity: ArrayLike, offsets: ArrayLike) -> Float64Array:
    """Compute unit normals of the polygons of a mesh. Corners run counter-clockwise as seen from the front.

    Edges are computed in float64 before they are multiplied, and scaled by a power of two if their products would
    overflow or underflow. For a triangle with longest edge L and smallest height h the error is within
    8 * 2**-53 * L / h, at any distance from the origin.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), any real type.
    connectivity : array_like of int
        Point indices of all faces, one face after the other.
    offsets : array_like of int
        Shape (n_faces + 1,): the start of each face in `connectivity`, and the end of the last. Faces may have any
        number of corners; a polygon that is not flat has the normal of its projected areas (Newell's).

    Returns
    -------
    ndarray
        Shape (n_faces, 3), float64. The vector is zero for a face with a point that is not finite, and for a face
        without area: fewer than 3 corners, duplicate or collinear points, or an area within the rounding errors of
        its edges.

    Raises
    ------
    ValueError
        If an index is out of range (the message gives the face and the index), or the arrays do not fit together.
    """
    faces = Faces(points, connectivity, offsets)
    result = np.zeros((faces.count, 3))
    for block in faces.blocks():
        result[block.faces] = unit(block.area_vectors())[0].T
    return result


# --- normals of points


def point_normals(
    points: ArrayLike, connectivity: ArrayLike, offsets: ArrayLike, weighting: Weighting = "angle"
) -> Float64Array:
    """Compute unit normals of the points of a mesh: weighted means of the normals of the faces around each point.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), any real type.
    connectivity : array_like of int
        Point indices of all faces, one face after the other.
    offsets : array_like of int
        Shape (n_faces + 1,): the start of each face in `connectivity`, and the end of the last.
    weighting : {"angle", "area", "max"}
        Weight of a face at a corner. "angle": the face's angle at the corner [1]_, or 180° if the point coincides with
        the face's previous or next point; the normals then do not depend on the division of the surface into faces.
        "area": the face's area. "max": the sine of the angle over the product of the two edges' lengths [2]_; the
        normals are then exact on a sphere.

    Returns
    -------
    ndarray
        Shape (n, 3), float64, one row per point. A point has the zero vector if it belongs to no face with a normal,
        or if its weighted normals cancel. A face without a normal has no weight, so that a NaN does not affect its
        neighbours. Renumbering the points changes no bit; reordering the faces may change the last bit.

    Raises
    ------
    ValueError
        If an index is out of range, the arrays do not fit together, or `weighting` has another value.

    References
    ----------
    .. [1] G. Thürmer, C. A. Wüthrich: Computing vertex normals from polygonal facets. Journal of Graphics
       Tools 3 (1998), 43-46.
    .. [2] N. Max: Weights for computing vertex normals from facet normals. Journal of Graphics Tools 4
       (1999), 1-6.
    """
    check.choice("weighting", weighting, get_args(Weighting))
    faces = Faces(points, connectivity, offsets)
    power = _POWER[weighting]
    levels = _levels(faces, power)
    sums, total = np.zeros((faces.n_points, 3)), np.zeros(faces.n_points)
    for block in faces.blocks():
        areas = block.area_vectors()
        weights = _weights(block, areas, weighting)
        if levels is not None:
            weights = np.ldexp(weights, power * block.exponents - levels[block.corners].T)
        normals = unit(areas)[0]
        index, terms = block.corners.ravel(), np.empty(block.corners.shape)  # face by face, the order of summation
        np.abs(weights, out=terms.T)
        np.add.at(total, index, terms.ravel())
        for axis in range(3):
            np.multiply(weights, normals[axis], out=terms.T)
            np.add.at(sums[:, axis], index, terms.ravel())
    for start in range(0, faces.n_points, _POINTS_AT_ONCE):
        part = slice(start, start + _POINTS_AT_ONCE)
        sums[part][(NOISE_OF_SUM * total[part] >= np.abs(sums[part]).T).all(axis=0)] = 0.0
        sums[part] = unit(columns(sums[part]))[0].T
    return sums


def _weights(block: FaceBlock, areas: Float64Array, weighting: Weighting) -> Float64Array:
    """Return the weights of a block's faces at their corners, shape (k, m); 0 for a face without a normal.

    Parameters
    ----------
    block : FaceBlock
        m faces with k corners each.
    areas : ndarray
        Shape (3, m), the block's area vectors.
    weighting : {"angle", "area", "max"}
        Kind of weight. "angle" is the face's angle at the corner in radians. "area" is the face's area in units of
        2**(2 * block.exponents). "max" is the sine of the angle over the product of the lengths of the corner's edges,
        in units of 2**(-2 * block.exponents).
    """
    if weighting == "area":
        return np.broadcast_to(np.sqrt(dot(areas, areas)), block.corners.T.shape)
    before = np.roll(block.edges, 1, axis=1)
    crosses = cross(before, block.edges)
    sines = np.sqrt(dot(crosses, crosses))  # multiplied by the two edges' lengths, as are the cosines below
    if len(sines) > 3:  # at a reflex corner the cross product opposes the normal; triangles have none
        np.negative(sines, out=sines, where=dot(crosses, areas[:, None]) < 0.0)
    if weighting == "angle":
        cosines = dot(before, block.edges)
        cosines += 0.0  # turns -0 into 0: at a duplicate point the sign of zero would select 0° or 180°
        weights = np.arctan2(sines, np.negative(cosines, out=cosines))
        if len(sines) > 3:
            weights[weights < 0.0] += 2.0 * math.pi
    else:
        squares = dot(block.edges, block.edges)
        products = squares * np.roll(squares, 1, axis=0)
        weights = np.divide(sines, products, out=np.zeros_like(sines), where=products >= np.finfo(np.float64).tiny)
    degenerate = ~areas.any(axis=0)
    if degenerate.any():
        weights[:, degenerate] = 0.0
    return weights


def _levels(faces: Faces, power: int) -> NDArray[np.int32] | None:
    """Return exponents by which the points' weights are scaled, so that their sums stay in range, shape (n_points,).

    `power` is the power of length in the unit of the weights: 2 for areas, 0 for angles, −2 for the weighting "max".
    The result is None if all weights are in range, as is usual.
    """
    if power == 0 or not any(block.exponents.any() for block in faces.blocks()):
        return None
    levels = np.full(faces.n_points, _NO_LEVEL, dtype=np.int32)
    for block in faces.blocks():
        own = np.where(block.area_vectors().any(axis=0), power * block.exponents, _NO_LEVEL)
        np.maximum.at(levels, block.corners.ravel(), np.repeat(own, block.corners.shape[1]))
    return levels


# --- tangents


def point_tangents(
    points: ArrayLike, connectivity: ArrayLike, offsets: ArrayLike, coordinates: ArrayLike, normals: ArrayLike
) -> Float64Array:
    """Compute unit tangents of the points of a mesh, as MikkTSpace does.

    At each corner of a face, ∂p/∂u follows from the edges to the two neighbours. This vector is projected onto the
    tangent plane, normalized, and weighted by the angle between the two edges. Unlike in MikkTSpace, points are not
    split at mirrored texture seams, so the tangents of the faces may cancel there.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), any real type.
    connectivity : array_like of int
        Point indices of all faces, one face after the other.
    offsets : array_like of int
        Shape (n_faces + 1,): the start of each face in `connectivity`, and the end of the last.
    coordinates : array_like
        Shape (n, 2), texture coordinates u and v.
    normals : array_like
        Shape (n, 3), of any length.

    Returns
    -------
    ndarray
        Shape (n, 3), float64. Zero if no face at the point has area both in space and in the texture, or if the
        tangents cancel.

    References
    ----------
    M. S. Mikkelsen: Simulation of wrinkled surfaces revisited. Master's thesis, University of Copenhagen (2008).
    """
    faces = Faces(points, connectivity, offsets)
    n = unit(check.array("normals", normals, count=faces.n_points).T.astype(np.float64))[0]
    uv = np.asarray(coordinates, np.float64)
    sums, total = np.zeros((faces.n_points, 3)), np.zeros(faces.n_points)
    for block in faces.blocks():
        for corner in range(block.corners.shape[1]):
            here = block.corners[:, corner]
            after, before = block.corners[:, corner + 1 - block.corners.shape[1]], block.corners[:, corner - 1]
            one, two, across = block.edges[:, corner], -block.edges[:, corner - 1], n[:, here]
            (u_one, v_one), (u_two, v_two) = (uv[after] - uv[here]).T, (uv[before] - uv[here]).T
            with np.errstate(all="ignore"):  # zero where the edges are parallel in the texture
                along = np.sign(u_one * v_two - v_one * u_two) * (v_two * one - v_one * two)
                tangent = unit(along - dot(along, across) * across)[0]
            sine = np.abs(dot(cross(one, two), across))  # of the angle between the edges, as seen along the normal
            angle = np.arctan2(sine, dot(one, two) - dot(one, across) * dot(two, across))
            weight = angle * tangent.any(axis=0)
            np.add.at(total, here, weight)
            for axis in range(3):
                np.add.at(sums[:, axis], here, weight * tangent[axis])
    sums[np.abs(sums).max(axis=1, initial=0.0) <= _NOISE_OF_TANGENTS * total] = 0.0
    return np.ascontiguousarray(unit(columns(sums))[0].T)
