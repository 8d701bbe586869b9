"""Tangents of a mesh's points: where the first texture coordinate grows along the surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.base.vectors import cross, dot, unit
from pvphong.geometry.faces import Faces

# Of unit vectors with weights up to π: sums that are less, beside their weights, are made of rounding alone.
_NOISE = 2.0**-40


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
    sums[np.abs(sums).max(axis=1, initial=0.0) <= _NOISE * total] = 0.0
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
