"""Whether rays are blocked by triangles, in coordinates of any size.

In order: triangles; the backends, Embree's and VTK's, which do the same; `Caster`, which takes rays of any length from
anywhere to a backend; and `Occluders`, parts that can block light, each the triangles of one mesh.

A backend is built of at least one triangle, of finite coordinates from -1 to 1: a caster's triangles are moved to
their middle and scaled by a power of two. Its rays begin no further than a few such units away. So single precision has
the same resolution whatever the unit of length and however far from the origin all of it is.
"""

from __future__ import annotations

import functools
import importlib.util
import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

from pvphong.base import check
from pvphong.base.processes import available_memory
from pvphong.base.types import BoolArray, Float64Array, FloatArray
from pvphong.geometry.extent import Sphere, box_of

BYTES_PER_TRIANGLE = 130
"""What a caster takes for each, about, measured with both backends from 1 to 3 million triangles."""

RESOLUTION = 2.0**-18
"""A share of the size of all of a caster's triangles; what is nearer to an end of a ray than that may be missed."""

# Rays begin at most so far from the middle; those from further away are begun where they come as near.
_NEAR = 4.0
_RAYS_AT_ONCE = 2**15


class SlowRaysWarning(UserWarning):
    """Many rays are cast by VTK, for embreex is not installed."""


# --- triangles


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

    @cached_property
    def sound(self) -> BlockingFaces:
        """Those without a corner that is not finite."""
        if not len(self) or not len(self.points) or np.isfinite(box_of(self.points)).all():
            return self
        finite: Any = np.isfinite(self.points).all(axis=1)
        left = self.corners[finite[self.corners].all(axis=1)]
        used, corners = np.unique(left, return_inverse=True)
        return BlockingFaces(self.points[used], corners.reshape(-1, 3))

    @cached_property
    def box(self) -> tuple[Float64Array, Float64Array]:
        """Least and greatest coordinates, shape (3,), of those that are sound; 0 where there is none."""
        return box_of(self.sound.points if len(self.sound) else np.zeros((1, 3)))

    @cached_property
    def sphere(self) -> Sphere | None:
        """Around those that are sound; None where there is none."""
        low, high = self.box
        half = high / 2 - low / 2
        x, y, z = (low + half).tolist()
        return Sphere((x, y, z), float(np.hypot.reduce(half)) * (1.0 + 1e-9)) if len(self.sound) else None


# --- backends


class Embree:
    """Intel's Embree, through embreex (the extra `rays`), in single precision; several threads may cast at once."""

    def __init__(self, faces: BlockingFaces) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene = EmbreeScene(robust=True)
        self._mesh = TriangleMesh(self._scene, faces.points.astype(np.float32), faces.corners.astype(np.int32))
        self.blocked(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.ones(1))  # the first ray builds the tree

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Whether a triangle is met: origins and unit vectors (n, 3), lengths (n,), all of moderate size."""
        rays = (np.ascontiguousarray(a, np.float32) for a in (origins, directions))
        found: BoolArray = self._scene.run(*rays, dists=lengths.astype(np.float32), query="OCCLUDED") >= 0
        return found


# Places on triangles are rounded too: with a tolerance of 0 some are missed.
_TOLERANCE = 2.0**-24


class Locator:
    """VTK's static cell locator: slower, and always there."""

    def __init__(self, faces: BlockingFaces) -> None:
        self._locator = vtkStaticCellLocator()
        self._locator.SetDataSet(pv.PolyData.from_regular_faces(faces.points, faces.corners, deep=True))
        self._locator.BuildLocator()

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """As `Embree.blocked`."""
        ends = origins + lengths[:, None] * directions
        meet: Any = self._locator.IntersectWithLine  # VTK's annotations have no numbers that it changes
        t, cell, where, inside = mutable(0.0), mutable(0), [0.0] * 3, [0.0] * 3
        pairs = zip(origins.tolist(), ends.tolist(), strict=True)
        return np.array([meet(a, b, _TOLERANCE, t, where, inside, cell) != 0 for a, b in pairs], np.bool_)


# --- rays of any length from anywhere


class Caster:
    """Triangles that block rays.

    Parameters
    ----------
    faces : BlockingFaces
        Triangles without an area, or with a corner that is not finite, block nothing.
    """

    def __init__(self, faces: BlockingFaces) -> None:
        low, high = faces.box
        half = high / 2 - low / 2
        self._middle: Float64Array = low + half
        self._exponent = int(np.frexp(half.max())[1])
        scaled = np.ldexp(faces.sound.points - self._middle, -self._exponent)
        backend = Embree if has_embree() else Locator
        self._backend = backend(BlockingFaces(scaled, faces.sound.corners)) if len(faces.sound) else None

    @property
    def resolution(self) -> float:
        """The length that this caster resolves."""
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
        each = rays_each(origins, directions)
        step = max(_RAYS_AT_ONCE // each, 1)
        for start in range(0, len(origins), step) if self._backend else ():
            part = slice(each * start, each * (start + step))
            result[part] = self._cast(origins[start : start + step], directions[part], distances[part])
        return result

    def _cast(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        assert self._backend is not None
        with np.errstate(over="ignore", invalid="ignore"):
            starts = np.ldexp(origins - self._middle, -self._exponent)
            is_far = ~(np.abs(starts) <= _NEAR).all(axis=1)
            each = rays_each(origins, directions)
            starts, is_far = starts.repeat(each, axis=0), is_far.repeat(each)
            lengths = np.ldexp(np.asarray(distances, np.float64), -self._exponent)
            can_meet = np.isfinite(directions).all(axis=1)
            if is_far.any():  # started where the ray is nearest to the middle, less than what triangles reach
                toward = directions[is_far]
                ahead = np.maximum(-(starts[is_far] * toward).sum(axis=1) - _NEAR / 2, 0.0)
                starts[is_far] += ahead[:, None] * toward
                lengths[is_far] -= ahead
                can_meet &= (np.abs(starts) <= 2 * _NEAR).all(axis=1)
        can_meet &= lengths > 0.0
        lengths = np.minimum(lengths, 4 * _NEAR)
        if can_meet.all():
            return self._backend.blocked(starts, directions, lengths)
        result = np.zeros(len(starts), bool)
        if can_meet.any():
            result[can_meet] = self._backend.blocked(starts[can_meet], directions[can_meet], lengths[can_meet])
        return result


def rays_each(origins: FloatArray, directions: FloatArray) -> int:
    """How many rays begin at each origin."""
    return max(len(directions) // max(len(origins), 1), 1)


def has_embree() -> bool:
    """Whether embreex is installed, which casts rays some twenty times as fast."""
    return importlib.util.find_spec("embreex") is not None


@functools.cache
def warn_of_slow_rays() -> None:
    """Warn, once in a process, of rays that take long without embreex."""
    message = 'VTK casts the rays, which takes long; pip install "pvphong[rays]" makes them twenty times as fast.'
    warnings.warn(message, SlowRaysWarning, stacklevel=2)


# --- what can block light


# A part so many times smaller than the others is not put into one caster with them, whose resolution is too coarse for
# it: single precision resolves 2⁻²⁴ of the whole.
_ALIKE = 2.0**8


class Occluders:
    """Parts that block light together.

    Parameters
    ----------
    parts : sequence of BlockingFaces
        In the world.
    """

    def __init__(self, parts: Sequence[BlockingFaces]) -> None:
        self._parts = tuple(parts)

    @property
    def count(self) -> int:
        """The number of triangles."""
        return sum(map(len, self._parts))

    @property
    def spheres(self) -> list[Sphere | None]:
        """Around each part; None for one without a triangle."""
        return [part.sphere for part in self._parts]

    @cached_property
    def _groups(self) -> list[list[int]]:
        """Parts that share a caster: those of nearly the size of the largest, then those of the next sizes."""
        left = [(sphere.radius, index) for index, sphere in enumerate(self.spheres) if sphere is not None]
        left.sort(reverse=True)
        groups: list[list[int]] = []
        while left:
            alike = [index for radius, index in left if radius * _ALIKE >= left[0][0]]
            groups.append(alike)
            left = left[len(alike) :]
        return groups

    @cached_property
    def casters(self) -> list[Caster]:
        """Built when rays are first cast.

        Raises
        ------
        ValueError
            If they would take more memory than there is.
        """
        available = available_memory()
        needed = self.count * BYTES_PER_TRIANGLE
        if available is not None and needed > available:
            got = f"{self.count:,} triangles, which take about {needed / 1e9:.3g} GB"
            allowed = f"as many as fit into the {available / 1e9:.3g} GB of memory that are free"
            check.refuse("occluders", got, allowed, "Fewer will do for shadows: mesh.decimate(0.9) takes nine in ten.")
        casters = []
        for group in self._groups:
            parts = [self._parts[index] for index in group]
            faces = parts[0]
            if len(parts) > 1:
                starts = np.cumsum([0, *(len(part.points) for part in parts[:-1])])
                corners = np.concatenate([part.corners + start for part, start in zip(parts, starts, strict=True)])
                faces = BlockingFaces(np.concatenate([part.points for part in parts]), corners)
            casters.append(Caster(faces))
        return casters

    def resolution(self, part: int | None) -> float:
        """The length that is resolved at a part, or else at the finest one; 0 without any."""
        if not self.casters:
            return 0.0
        own = [caster for group, caster in zip(self._groups, self.casters, strict=True) if part in group]
        return (own or self.casters)[-1].resolution

    def blocked(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        """As `Caster.blocked`, by any part."""
        found = np.zeros(len(directions), bool)
        each = rays_each(origins, directions)
        for caster in self.casters:
            free = np.flatnonzero(~found)
            if len(free) == len(found):
                found = caster.blocked(origins, directions, distances)
            else:
                found[free] = caster.blocked(origins[free // each], directions[free], distances[free])
        return found
