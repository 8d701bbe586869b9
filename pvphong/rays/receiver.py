"""The vertices of one mesh that look at lights and at the sky."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pvphong.base import threads
from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.base.vectors import unit
from pvphong.geometry.convex import is_convex
from pvphong.geometry.extent import Extent
from pvphong.rays.faces import BlockingFaces
from pvphong.rays.starts import into_faces

# Finding out whether a mesh of more faces is convex would take longer than its rays.
_MOST_FACES = 2**15
_NORMALS_AT_ONCE = 2**16


@dataclass(frozen=True, eq=False)
class Receiver:
    """The vertices of one mesh, in the world.

    Parameters
    ----------
    faces : BlockingFaces
        Its points, float64, and its triangles.
    normals : callable
        Gives their normals, shape (n, 3), of any length.
    part : int or None
        Which of the occluders' parts its faces are; None where they block nothing.
    starts : ndarray, optional
        Shape (n, 3): `beside`, where that is known.
    """

    faces: BlockingFaces
    normals: Callable[[], FloatArray]
    part: int | None
    starts: Float64Array | None = None

    def some(self, rows: IntArray) -> Receiver:
        """Some of its vertices, without faces; their rays begin where they begin here."""
        faces = BlockingFaces(self.points[rows], np.empty((0, 3), np.int64))
        return Receiver(faces, lambda: self.unit_normals[rows], self.part, self.beside[rows])

    @property
    def points(self) -> Float64Array:
        """Shape (n, 3)."""
        return self.faces.points.astype(np.float64, copy=False)

    @cached_property
    def unit_normals(self) -> Float64Array:
        """Shape (n, 3); zero where there is none."""
        normals = self.normals()
        result = np.empty(normals.shape)

        def work(first: int, last: int) -> None:
            result[first:last] = unit(normals[first:last].T.astype(np.float64))[0].T

        threads.run(work, len(normals), _NORMALS_AT_ONCE)
        return result

    @cached_property
    def extent(self) -> Extent:
        """Where the vertices are."""
        return Extent(self.points, None, None)

    @cached_property
    def is_convex(self) -> bool:
        """Whether no ray that leaves it meets it again."""
        return len(self.faces) <= _MOST_FACES and is_convex(self.points, self.unit_normals, self.faces.corners)

    @cached_property
    def beside(self) -> Float64Array:
        """The points, a little way into their faces."""
        if self.starts is not None:
            return self.starts
        return self.points + into_faces(self.points, self.unit_normals, self.faces.corners)
