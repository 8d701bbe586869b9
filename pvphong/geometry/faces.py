"""The polygons of a mesh: their check, and their edges in blocks of equal size, scaled into a safe range.

Tangents of a mesh's points: where the first texture coordinate grows along the surface.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pvphong.base import check
from pvphong.base.types import BoolArray, Float64Array, IntArray
from pvphong.base.vectors import cross, dot, unit

# Corners in a block: its arrays then stay in a core's cache.
_BLOCK_CORNERS = 3 * 8192

# Faces whose sizes are looked at at once.
_SIZES_AT_ONCE = 2**15

# Faces whose longest edge lies between these are used as they are: edges to the fourth power stay in range
# even in slivers.
_LEAST_SPAN, _MOST_SPAN = 2.0**-100, 2.0**100

# Points beyond this are quartered before they are subtracted, so that no edge overflows.
_FAR = 2.0**1000

# A component of an area vector whose magnitude is at most this many times its terms' is made of rounding alone:
# each product of two rounded edges carries 3 roundings of 2**-53, their difference one more.
_NOISE = 4 * 2.0**-53


@dataclass(frozen=True)
class FaceBlock:
    """Faces with the same number k of corners.

    Attributes
    ----------
    faces : ndarray
        Shape (m,), which faces of the mesh these are.
    corners : ndarray
        Shape (m, k), the indices of their points.
    edges : ndarray
        Shape (3, k, m): from each corner to the next, in units of 2**exponents; zero in a face with a point
        that is not finite.
    spokes : ndarray
        Shape (3, k - 2, m): from corner 0 to corners 1 … k - 2, in the same units.
    exponents : ndarray
        Shape (m,): 0 for every face of comfortable size.
    """

    faces: IntArray
    corners: IntArray
    edges: Float64Array
    spokes: Float64Array
    exponents: NDArray[np.int32]

    def area_vectors(self) -> Float64Array:
        """(3, m) normals of twice the faces' area, in units of 2**(2 * exponents); zero for a degenerate face.

        The fan from corner 0: the sum of spoke × edge. Unlike Newell's sum over the points themselves it
        subtracts first, so a world offset costs nothing (M. E. Newell, in Sutherland et al. 1974). The last
        triangle takes the edge back to corner 0, so that a triangle's own two edges there are used.
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
        degenerate = np.logical_and.reduce(np.abs(total) <= _NOISE * terms, axis=0)
        if degenerate.any():
            total[:, degenerate] = 0.0
        return total


class Faces:
    """Polygons over points, checked: every index is one of a point's.

    Parameters
    ----------
    points : array_like
        Shape (n, 3).
    connectivity : array_like of int
        All faces' point indices, one face after the other.
    offsets : array_like of int
        Shape (n_faces + 1,): where each face starts in `connectivity`, and the end.

    Raises
    ------
    ValueError
        For an index that no point has (the message names the face), or for arrays that do not fit together.
    """

    def __init__(self, points: ArrayLike, connectivity: ArrayLike, offsets: ArrayLike) -> None:
        rows = check.array("points", points)
        self.offsets = _integers("offsets", offsets)
        self._sizes = _checked_sizes(self.offsets, len(np.atleast_1d(connectivity)))
        self.connectivity = _checked_connectivity(connectivity, self.offsets, len(rows))
        self.count = len(self.offsets) - 1
        self.n_points = len(rows)
        self._rows = np.ascontiguousarray(rows)  # or each block would have them copied

    def blocks(self) -> Iterator[FaceBlock]:
        """Blocks of faces with equally many corners; faces with fewer than 3 are in none."""
        for size in self._sizes:
            if size < 3:
                continue
            alike = None if len(self._sizes) == 1 else np.flatnonzero(np.diff(self.offsets) == size)
            count, step = self.count if alike is None else len(alike), max(_BLOCK_CORNERS // size, 1)
            for start in range(0, count, step):
                stop = min(start + step, count)
                faces = np.arange(start, stop) if alike is None else alike[start:stop]
                yield self._block(faces, self._corners(faces, size))

    def _corners(self, faces: IntArray, size: int) -> IntArray:
        """(m, size) corners of faces of one size; of such as follow one another they are a view."""
        first, last = faces[0], faces[-1]
        if last - first == len(faces) - 1:
            return self.connectivity[self.offsets[first] : self.offsets[last + 1]].reshape(-1, size)
        return self.connectivity[self.offsets[faces][:, None] + np.arange(size)]

    def _block(self, faces: IntArray, corners: IntArray) -> FaceBlock:
        gathered = np.take(self._rows, corners, axis=0)  # several times as fast as an index
        points = np.ascontiguousarray(gathered.transpose(2, 1, 0), dtype=np.float64)
        with np.errstate(over="ignore", invalid="ignore"):
            edges, spokes = _edges_and_spokes(points)
            span = np.abs(edges).reshape(-1, len(corners)).max(axis=0)
        exponents = np.zeros(len(faces), dtype=np.int32)
        rare = ~((span >= _LEAST_SPAN) & (span <= _MOST_SPAN))  # NaN is rare too
        if rare.any():
            edges[:, :, rare], spokes[:, :, rare], exponents[rare] = _rescaled(points[:, :, rare])
        return FaceBlock(faces, corners, edges, spokes, exponents)


def _edges_and_spokes(points: Float64Array) -> tuple[Float64Array, Float64Array]:
    edges = np.empty_like(points)
    np.subtract(points[:, 1:], points[:, :-1], out=edges[:, :-1])
    np.subtract(points[:, 0], points[:, -1], out=edges[:, -1])
    return edges, points[:, 1:-1] - points[:, :1]


def _rescaled(points: Float64Array) -> tuple[Float64Array, Float64Array, NDArray[np.int32]]:
    """Edges and spokes with the longest edge's largest component in [0.5, 1), and their exponents."""
    finite: BoolArray = np.logical_and.reduce(np.isfinite(points), axis=(0, 1))
    points = np.where(finite, points, 0.0)
    quarters = -2 * (np.abs(points).max(axis=(0, 1)) > _FAR).astype(np.int32)
    edges, spokes = _edges_and_spokes(np.ldexp(points, quarters))
    exponents = np.frexp(np.abs(edges).max(axis=(0, 1)))[1]
    return np.ldexp(edges, -exponents), np.ldexp(spokes, -exponents), exponents - quarters


def _checked_sizes(offsets: IntArray, end: int) -> list[int]:
    """Numbers of corners that faces have, in rising order."""
    found: set[int] = set()
    for start in range(0, len(offsets) - 1, _SIZES_AT_ONCE):  # an array of all of them costs more than the look at it
        sizes = np.diff(offsets[start : start + _SIZES_AT_ONCE + 1])
        found.update({int(sizes[0])} if (sizes == sizes[0]).all() else np.unique(sizes).tolist())
    if not len(offsets) or offsets[0] != 0 or offsets[-1] != end or min(found, default=0) < 0:
        allowed = f"indices that rise from 0 to the connectivity's length, {end}"
        check.refuse(
            "offsets",
            np.array2string(offsets, threshold=9),
            allowed,
            "One starts each face, and one more ends the last.",
        )
    return sorted(found)


def _checked_connectivity(connectivity: ArrayLike, offsets: IntArray, n_points: int) -> IntArray:
    result = _integers("connectivity", connectivity)
    if len(result) and not (result.min() >= 0 and result.max() < n_points):
        first = int(np.flatnonzero((result < 0) | (result >= n_points))[0])
        face = int(np.searchsorted(offsets, first, side="right")) - 1
        allowed = f"indices of the {n_points} points, from 0 to {n_points - 1}" if n_points else "empty without points"
        remedy = "The file or the code that made the faces counts its points differently."
        check.refuse("connectivity", f"index {result[first]} in face {face}", allowed, remedy)
    return result


def _integers(name: str, value: ArrayLike) -> IntArray:
    result: NDArray[Any] = np.asarray(value)
    if result.ndim != 1 or (result.size and result.dtype.kind not in "iu"):
        check.refuse(name, f"shape {result.shape} of {result.dtype}", "a one-dimensional array of integers")
    return result.astype(np.intp, copy=False)


# --- tangents


# Of unit vectors with weights up to π: sums that are less, beside their weights, are made of rounding alone.
_NOISE_OF_TANGENTS = 2.0**-40


def point_tangents(
    points: ArrayLike, connectivity: ArrayLike, offsets: ArrayLike, coordinates: ArrayLike, normals: ArrayLike
) -> Float64Array:
    """Unit tangents of the points of a mesh, as MikkTSpace has them.

    Around each corner of a face, ∂p/∂u comes from the edges to its two neighbours; across the point's normal, it is
    weighted by the angle that the edges have there. Unlike MikkTSpace, no point is split in two where faces around it
    are mirrored in the texture: there their tangents may cancel.

    Parameters
    ----------
    points, connectivity, offsets : array_like
        As for `pvphong.geometry.normals.point_normals`.
    coordinates : array_like
        Shape (n, 2): texture coordinates u and v.
    normals : array_like
        Shape (n, 3), of any length.

    Returns
    -------
    ndarray
        Shape (n, 3), float64. Zero where no face has an area, on the surface and in the texture, or tangents cancel.

    References
    ----------
    M. S. Mikkelsen: Simulation of wrinkled surfaces revisited. Master's thesis, University of Copenhagen (2008).
    """
    faces = Faces(points, connectivity, offsets)
    rows = check.array("normals", normals, count=faces.n_points)
    n = unit(rows.T.astype(np.float64))[0]
    uv = np.asarray(coordinates, np.float64)
    sums, total = np.zeros((faces.n_points, 3)), np.zeros(faces.n_points)
    for block in faces.blocks():
        for corner in range(block.corners.shape[1]):
            here = block.corners[:, corner]
            after, before = block.corners[:, corner + 1 - block.corners.shape[1]], block.corners[:, corner - 1]
            edges = block.edges[:, corner], -block.edges[:, corner - 1]
            tangent = _tangents(*edges, uv[after] - uv[here], uv[before] - uv[here], n[:, here])
            weight = _angle(*edges, n[:, here]) * tangent.any(axis=0)
            np.add.at(total, here, weight)
            for axis in range(3):
                np.add.at(sums[:, axis], here, weight * tangent[axis])
    sums[np.abs(sums).max(axis=1, initial=0.0) <= _NOISE_OF_TANGENTS * total] = 0.0
    return np.ascontiguousarray(unit(sums.T)[0].T)


def _tangents(
    one: Float64Array, two: Float64Array, uv_one: NDArray[np.float64], uv_two: NDArray[np.float64], n: Float64Array
) -> Float64Array:
    """∂p/∂u of two edges from one point, across n, unit length; zero where they are parallel in the texture."""
    with np.errstate(all="ignore"):
        turn = np.sign(uv_one[:, 0] * uv_two[:, 1] - uv_one[:, 1] * uv_two[:, 0])
        along = turn * (uv_two[:, 1] * one - uv_one[:, 1] * two)
        return unit(along - dot(along, n) * n)[0]


def _angle(one: Float64Array, two: Float64Array, n: Float64Array) -> Float64Array:
    """Between two edges as seen along n, in radians."""
    return np.arctan2(np.abs(dot(cross(one, two), n)), dot(one, two) - dot(one, n) * dot(two, n))
