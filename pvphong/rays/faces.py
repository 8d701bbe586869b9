"""The triangles of a mesh, as all that casts rays has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import Float64Array, FloatArray


class Ball(NamedTuple):
    """A sphere around triangles."""

    center: Float64Array
    radius: float


@dataclass(frozen=True, eq=False)
class BlockingFaces:
    """Triangles.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3).
    corners : ndarray
        Shape (m, 3): which of the points are a triangle's.
    """

    points: FloatArray
    corners: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.corners)

    @classmethod
    def joined(cls, parts: Sequence[BlockingFaces]) -> BlockingFaces:
        """All triangles of several."""
        if len(parts) == 1:
            return parts[0]
        starts = np.cumsum([0, *(len(part.points) for part in parts)])
        corners = [part.corners + start for part, start in zip(parts, starts[:-1], strict=True)]
        return cls(np.concatenate([part.points for part in parts]), np.concatenate(corners))

    @cached_property
    def sound(self) -> BlockingFaces:
        """Those without a corner that is not finite."""
        if not len(self) or not len(self.points) or np.isfinite(_extremes(self.points)).all():
            return self
        finite: Any = np.isfinite(self.points).all(axis=1)
        left = self.corners[finite[self.corners].all(axis=1)]
        used, corners = np.unique(left, return_inverse=True)
        return BlockingFaces(self.points[used], corners.reshape(-1, 3))

    @cached_property
    def box(self) -> Float64Array:
        """Least and greatest coordinates, shape (2, 3); 0 where there is no triangle."""
        return _extremes(self.points) if len(self) else np.zeros((2, 3))

    @cached_property
    def ball(self) -> Ball | None:
        """Around those that are sound; None where there is none."""
        if not len(self.sound):
            return None
        low, high = self.sound.box
        half = high / 2 - low / 2
        return Ball(low + half, float(np.hypot.reduce(half)) * (1.0 + 1e-9))


def _extremes(points: FloatArray) -> Float64Array:
    columns = np.ascontiguousarray(points.T)  # long rows are searched many times as fast as triples
    return np.stack([columns.min(axis=1), columns.max(axis=1)]).astype(np.float64)
