"""Rays cast by Intel's Embree, through embreex (the extra `rays`), in single precision."""

from __future__ import annotations

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from pvphong.base.types import BoolArray, Float64Array, FloatArray
from pvphong.rays.faces import BlockingFaces


class Embree:
    """A `Backend`; several threads may cast at once."""

    def __init__(self, faces: BlockingFaces) -> None:
        self._scene = EmbreeScene(robust=True)
        self._mesh = TriangleMesh(self._scene, faces.points.astype(np.float32), faces.corners.astype(np.int32))
        self.blocked(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.ones(1))  # the first ray builds the tree

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Whether a triangle is met."""
        rays = (np.ascontiguousarray(a, np.float32) for a in (origins, directions))
        found: BoolArray = self._scene.run(*rays, dists=lengths.astype(np.float32), query="OCCLUDED") >= 0
        return found
