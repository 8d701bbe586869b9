"""The vertices of one mesh that look at lights and at the sky."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import Float64Array, FloatArray
from pvphong.base.vectors import unit
from pvphong.geometry.convex import is_convex
from pvphong.geometry.extent import Extent
from pvphong.rays.starts import into_faces

# Finding out whether a mesh of more faces is convex would take longer than its rays.
_MOST_FACES = 2**15


@dataclass(frozen=True, eq=False)
class Receiver:
    """The vertices of one mesh, in the world.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3), float64.
    normals : callable
        Gives their normals, shape (n, 3), of any length.
    triangles : ndarray
        Shape (m, 3): its faces.
    part : int or None
        Which of the occluders' parts its faces are; None where they block nothing.
    """

    points: Float64Array
    normals: Callable[[], FloatArray]
    triangles: NDArray[np.int64]
    part: int | None

    @cached_property
    def unit_normals(self) -> Float64Array:
        """Shape (n, 3); zero where there is none."""
        return np.ascontiguousarray(unit(self.normals().T.astype(np.float64))[0].T)

    @cached_property
    def extent(self) -> Extent:
        """Where the vertices are."""
        return Extent(self.points, None, None)

    @cached_property
    def is_convex(self) -> bool:
        """Whether no ray that leaves it meets it again."""
        return len(self.triangles) <= _MOST_FACES and is_convex(self.points, self.unit_normals, self.triangles)

    @cached_property
    def beside(self) -> Float64Array:
        """The points, a little way into their faces."""
        return self.points + into_faces(self.points, self.unit_normals, self.triangles)
