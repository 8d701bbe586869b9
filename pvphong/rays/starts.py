"""Where the rays of a vertex begin: beside it, so that its own faces do not block them by rounding.

A vertex is on the smooth surface that a mesh stands for, and its normal is that surface's; so a ray that begins there
and rises above the tangent plane meets no face of a convex surface, however coarse: there is no staircase where light
ends to reach it, which rays from inside of faces make (Hanika, "Hacking the shadow terminator", 2021).

A begin is above the tangent plane by the resolution of the triangles. It is also a thousandth of the way into the
vertex's own faces, as far as they are not below that plane: a vertex at the foot of a wall is in the plane of the wall,
and belongs on that side of it on which its faces are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import Float64Array
from pvphong.base.vectors import dot

_INTO_FACES = 2.0**-10
_AT_ONCE = 2**15


def into_faces(points: Float64Array, normals: Float64Array, triangles: NDArray[np.int64]) -> Float64Array:
    """The ways into the faces of each vertex, not below its tangent plane; zero where these lie evenly around it.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), in the world; unit normals, or zero.
    triangles : ndarray
        Shape (m, 3), the points at their corners.

    Returns
    -------
    ndarray
        Shape (n, 3): a thousandth of the way to the mean of the middles of its faces, without what of it is against
        the normal.
    """
    columns = np.ascontiguousarray(points.T)
    sums, counts = np.zeros_like(columns), np.zeros(len(points))
    for start in range(0, len(triangles), _AT_ONCE):
        corners = np.ascontiguousarray(triangles[start : start + _AT_ONCE].T)  # long rows are quicker to add up
        middles = np.stack([column[corners[0]] + column[corners[1]] + column[corners[2]] for column in columns]) / 3.0
        sound = np.isfinite(middles).all(axis=0)
        if not sound.all():
            corners, middles = corners[:, sound], middles[:, sound]
        for corner in corners:
            np.add.at(counts, corner, 1.0)
            for axis in range(3):
                np.add.at(sums[axis], corner, middles[axis])
    with np.errstate(invalid="ignore"):
        ways = np.where(counts > 0, sums / np.maximum(counts, 1.0) - columns, 0.0)
        ways -= np.minimum(dot(ways, normals.T), 0.0) * normals.T
    return np.where(np.isfinite(ways), ways, 0.0).T * _INTO_FACES
