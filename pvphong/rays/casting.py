"""Whether rays are blocked by triangles, in coordinates of any size, by one of two backends of one behaviour.

Backends see triangles about their middle, scaled by a power of two so that none is further than 1 from it, and rays
that begin no further than a few such units away: so single precision has the same resolution whatever the unit of
length and however far from the origin all of it is.
"""

from __future__ import annotations

import functools
import importlib.util
import math
import warnings
from typing import Protocol

import numpy as np

from pvphong.base.types import BoolArray, Float64Array, FloatArray
from pvphong.rays.faces import BlockingFaces

BYTES_PER_TRIANGLE = 130
"""What a caster takes for each, about, measured with both backends from 1 to 3 million triangles."""

RESOLUTION = 2.0**-18
"""In parts of the size of a caster's triangles: what is nearer to a ray's begin or end than that may be passed over."""

# Rays begin at most so far from the middle; those from further away are begun where they come as near.
_NEAR = 4.0
_RAYS_AT_ONCE = 2**15
# Vertices of which one who waits for VTK's rays is told that there are faster ones.
_WORTH_TELLING = 2**15


class SlowRaysWarning(UserWarning):
    """Many rays are cast by VTK, for embreex is not installed."""


class Backend(Protocol):
    """What casts rays at triangles."""

    def __init__(self, faces: BlockingFaces) -> None:
        """At least one triangle, of finite coordinates from -1 to 1."""

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Whether a triangle is met: origins and unit vectors (n, 3), lengths (n,), all of moderate size."""


class Caster:
    """Triangles that block rays.

    Parameters
    ----------
    faces : BlockingFaces
        Triangles without an area, or with a corner that is not finite, block nothing.
    """

    def __init__(self, faces: BlockingFaces) -> None:
        sound = faces.sound
        low, high = sound.box
        half = high / 2 - low / 2
        self.middle: Float64Array = low + half
        self._exponent = int(np.frexp(half.max())[1])
        scaled = np.ldexp(sound.points - self.middle, -self._exponent)
        self._backend = _backend()(BlockingFaces(scaled, sound.corners)) if len(sound) else None

    @property
    def resolution(self) -> float:
        """The length below which this caster tells nothing apart."""
        return math.ldexp(RESOLUTION, self._exponent)

    def blocked(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        """Whether anything is met between a ray's origin and a point at a distance from it.

        Parameters
        ----------
        origins : ndarray
            Shape (n, 3), or (m, 3) where each is that of n / m rays in a row. A ray that begins at a point that is not
            finite is not blocked.
        directions : ndarray
            Shape (n, 3), unit vectors.
        distances : ndarray
            Shape (n,), in the unit of the triangles; infinity for a ray without an end.

        Returns
        -------
        ndarray
            Shape (n,), bool.
        """
        result = np.zeros(len(directions), bool)
        if self._backend is None:
            return result
        each = rays_each(origins, directions)
        step = max(_RAYS_AT_ONCE // each, 1)
        for start in range(0, len(origins), step):
            part = slice(each * start, each * (start + step))
            result[part] = self._cast(origins[start : start + step], directions[part], distances[part])
        return result

    def _cast(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        assert self._backend is not None
        with np.errstate(over="ignore", invalid="ignore"):
            begins = np.ldexp(origins - self.middle, -self._exponent)
            lengths = np.ldexp(np.asarray(distances, np.float64), -self._exponent)
            is_near = np.abs(begins).max(initial=0.0) <= _NEAR
        begins = begins.repeat(rays_each(begins, directions), axis=0)
        if is_near and (lengths > 0.0).all() and np.isfinite(directions).all():
            return self._backend.blocked(begins, directions, np.minimum(lengths, 4 * _NEAR))
        return self._cast_some(begins, directions, lengths)

    def _cast_some(self, begins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Rays of which some may begin far away, or be none."""
        assert self._backend is not None
        with np.errstate(over="ignore", invalid="ignore"):
            ahead = np.zeros(len(begins))
            far = ~(np.abs(begins) <= _NEAR).all(axis=1)
            if far.any():  # begun where the ray is nearest to the middle, less than what triangles reach
                along = -(begins[far] * directions[far]).sum(axis=1)
                ahead[far] = np.maximum(along - _NEAR / 2, 0.0)
                begins[far] += ahead[far, None] * directions[far]
            lengths = np.minimum(lengths - ahead, 4 * _NEAR)
            meets = (np.abs(begins) <= 2 * _NEAR).all(axis=1) & (lengths > 0.0) & np.isfinite(directions).all(axis=1)
        result = np.zeros(len(begins), bool)
        if meets.any():
            result[meets] = self._backend.blocked(begins[meets], directions[meets], lengths[meets])
        return result


def rays_each(origins: FloatArray, directions: FloatArray) -> int:
    """How many rays begin at each origin."""
    return max(len(directions) // max(len(origins), 1), 1)


def has_embree() -> bool:
    """Whether embreex is installed, which casts rays some twenty times as fast."""
    return importlib.util.find_spec("embreex") is not None


def tell_if_slow(vertices: int) -> None:
    """Warn, once in a process, where the rays of so many vertices will take long without embreex."""
    if vertices >= _WORTH_TELLING and not has_embree():
        _tell_once()


@functools.cache
def _tell_once() -> None:
    message = 'VTK casts the rays, which takes long; pip install "pvphong[rays]" makes them twenty times as fast.'
    warnings.warn(message, SlowRaysWarning, stacklevel=2)


@functools.cache
def _backend() -> type[Backend]:
    if has_embree():
        from pvphong.rays.embree import Embree

        return Embree
    from pvphong.rays.locator import Locator

    return Locator
