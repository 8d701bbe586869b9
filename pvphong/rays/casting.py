"""Whether rays are blocked by triangles, in coordinates of any size, by one of two backends of one behaviour.

Backends see triangles about their middle, scaled by a power of two so that none is further than 1 from it, and rays
that begin no further than a few such units away: so single precision has the same resolution whatever the unit of
length and however far from the origin all of it is.
"""

from __future__ import annotations

import functools
import importlib.util
import math
from typing import Protocol

import numpy as np

from pvphong.base.types import BoolArray, Float64Array, FloatArray

RESOLUTION = 2.0**-18
"""In parts of the size of a caster's triangles: what is nearer to a ray's begin or end than that may be passed over."""

# Rays begin at most so far from the middle; those from further away are begun where they come as near.
_NEAR = 4.0
_RAYS_AT_ONCE = 2**15


class Backend(Protocol):
    """What casts rays at triangles."""

    def __init__(self, triangles: Float64Array) -> None:
        """Triangles of shape (m, 3, 3) with coordinates from -1 to 1, m > 0."""

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Whether a triangle is met: origins and unit vectors (n, 3), lengths (n,), all of moderate size."""


class Caster:
    """Triangles that block rays.

    Parameters
    ----------
    triangles : ndarray
        Shape (m, 3, 3), the corners. Those without an area, or with a corner that is not finite, block nothing.
    """

    def __init__(self, triangles: FloatArray) -> None:
        given = np.asarray(triangles, np.float64)
        sound = given[np.isfinite(given).all(axis=(1, 2))]
        self.middle, self._exponent = _middle_and_exponent(sound.reshape(-1, 3))
        scaled = np.ldexp(sound - self.middle, -self._exponent)
        scaled = scaled[(np.cross(scaled[:, 1] - scaled[:, 0], scaled[:, 2] - scaled[:, 0]) != 0.0).any(axis=1)]
        self.count = len(scaled)
        """Of the triangles that can block."""
        self.dropped = len(given) - self.count
        """How many cannot."""
        self._backend = _backend()(scaled) if len(scaled) else None

    @property
    def resolution(self) -> float:
        """The length below which this caster tells nothing apart."""
        return math.ldexp(RESOLUTION, self._exponent)

    def blocked(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        """Whether anything is met between a ray's origin and a point at a distance from it.

        Parameters
        ----------
        origins : ndarray
            Shape (n, 3). A ray that begins at a point that is not finite is not blocked.
        directions : ndarray
            Shape (n, 3), unit vectors.
        distances : ndarray
            Shape (n,), in the unit of the triangles; infinity for a ray without an end.

        Returns
        -------
        ndarray
            Shape (n,), bool.
        """
        result = np.zeros(len(origins), bool)
        if self._backend is None:
            return result
        for start in range(0, len(origins), _RAYS_AT_ONCE):
            part = slice(start, start + _RAYS_AT_ONCE)
            result[part] = self._cast(origins[part], directions[part], distances[part])
        return result

    def _cast(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        assert self._backend is not None
        with np.errstate(over="ignore", invalid="ignore"):
            begins = np.ldexp(origins - self.middle, -self._exponent)
            lengths = np.ldexp(np.asarray(distances, np.float64), -self._exponent)
            ahead = np.zeros(len(begins))
            far = ~(np.abs(begins) <= _NEAR).all(axis=1)
            if far.any():  # begun where the ray is nearest to the middle, less than what triangles reach
                along = -(begins[far] * directions[far]).sum(axis=1)
                ahead[far] = np.maximum(along - _NEAR / 2, 0.0)
                begins[far] += ahead[far, None] * directions[far]
            lengths = np.minimum(lengths - ahead, 4 * _NEAR)
            meets = (np.abs(begins) <= 2 * _NEAR).all(axis=1) & (lengths > 0.0) & np.isfinite(directions).all(axis=1)
        if meets.all():
            return self._backend.blocked(begins, directions, lengths)
        result = np.zeros(len(begins), bool)
        result[meets] = self._backend.blocked(begins[meets], directions[meets], lengths[meets])
        return result


def has_embree() -> bool:
    """Whether embreex is installed, which casts rays some fifty times as fast."""
    return importlib.util.find_spec("embreex") is not None


@functools.cache
def _backend() -> type[Backend]:
    if has_embree():
        from pvphong.rays.embree import Embree

        return Embree
    from pvphong.rays.locator import Locator

    return Locator


def _middle_and_exponent(points: Float64Array) -> tuple[Float64Array, int]:
    """The middle of points' box, and the power of two that is at least half its longest edge."""
    if not len(points):
        return np.zeros(3), 0
    low, high = points.min(axis=0), points.max(axis=0)
    half = high / 2 - low / 2
    return low + half, int(np.frexp(half.max())[1])
