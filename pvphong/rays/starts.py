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

_INTO_FACES = 2.0**-10
_CORNERS_AT_ONCE = 2**20


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
    sums, counts = np.zeros_like(points), np.zeros(len(points))
    for start in range(0, len(triangles), _CORNERS_AT_ONCE):
        some = triangles[start : start + _CORNERS_AT_ONCE]
        middles = points[some].mean(axis=1)
        sound = np.isfinite(middles).all(axis=1)
        corners, middles = some[sound], middles[sound]
        for k in range(3):
            counts += np.bincount(corners[:, k], minlength=len(points))
            for axis in range(3):
                sums[:, axis] += np.bincount(corners[:, k], middles[:, axis], len(points))
    ways = np.zeros_like(points)
    touched = counts > 0
    ways[touched] = sums[touched] / counts[touched, None] - points[touched]
    ways -= np.minimum((ways * normals).sum(axis=1, keepdims=True), 0.0) * normals
    return np.where(np.isfinite(ways), ways, 0.0) * _INTO_FACES
