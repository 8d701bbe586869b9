"""Whether rays are blocked by triangles, in coordinates of any size, by one of two backends of one behaviour.

Backends see triangles about their middle, scaled by a power of two so that none is further than 1 from it, and rays
that begin no further than a few such units away: so single precision has the same resolution whatever the unit of
length and however far from the origin all of it is.

In order: triangles; the backends, Embree's and VTK's; `Caster`, which takes rays of any length from anywhere; and
`Occluders`, parts that can block light, each the triangles of one mesh.
"""

from __future__ import annotations

import functools
import importlib.util
import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import mutable, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkStaticCellLocator

from pvphong.base import check
from pvphong.base.processes import available_memory
from pvphong.base.types import BoolArray, Float64Array, FloatArray

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


# --- triangles


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


# --- backends


class Backend(Protocol):
    """What casts rays at triangles."""

    def __init__(self, faces: BlockingFaces) -> None:
        """At least one triangle, of finite coordinates from -1 to 1."""

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Whether a triangle is met: origins and unit vectors (n, 3), lengths (n,), all of moderate size."""


class Embree:
    """Intel's Embree, through embreex (the extra `rays`), in single precision; several threads may cast at once."""

    def __init__(self, faces: BlockingFaces) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene = EmbreeScene(robust=True)
        self._mesh = TriangleMesh(self._scene, faces.points.astype(np.float32), faces.corners.astype(np.int32))
        self.blocked(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.ones(1))  # the first ray builds the tree

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Whether a triangle is met."""
        rays = (np.ascontiguousarray(a, np.float32) for a in (origins, directions))
        found: BoolArray = self._scene.run(*rays, dists=lengths.astype(np.float32), query="OCCLUDED") >= 0
        return found


# Places on triangles are rounded too: with a tolerance of 0 some are missed.
_TOLERANCE = 2.0**-24


class Locator:
    """VTK's static cell locator: slower, and always there."""

    def __init__(self, faces: BlockingFaces) -> None:
        points, cells, mesh = vtkPoints(), vtkCellArray(), vtkPolyData()
        points.SetData(numpy_to_vtk(np.ascontiguousarray(faces.points), deep=True))
        corners = np.ascontiguousarray(faces.corners, np.int64).ravel()
        offsets = numpy_to_vtkIdTypeArray(np.arange(0, len(corners) + 1, 3, dtype=np.int64), deep=True)
        cells.SetData(offsets, numpy_to_vtkIdTypeArray(corners, deep=True))
        mesh.SetPoints(points)
        mesh.SetPolys(cells)
        self._locator = vtkStaticCellLocator()
        self._locator.SetDataSet(mesh)
        self._locator.BuildLocator()

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Whether a triangle is met."""
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
    return Embree if has_embree() else Locator


# --- what can block light


# A part so many times smaller than the others is not put into one caster with them, whose resolution is too coarse for
# it: single precision tells 2⁻²⁴ of the whole apart.
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

    def __len__(self) -> int:
        return len(self._parts)

    @property
    def count(self) -> int:
        """Of triangles."""
        return sum(map(len, self._parts))

    @property
    def memory(self) -> int:
        """Bytes that casting rays takes for them, about."""
        return self.count * BYTES_PER_TRIANGLE

    @cached_property
    def balls(self) -> list[Ball | None]:
        """Around each part; None for one without a triangle."""
        return [part.ball for part in self._parts]

    @cached_property
    def _groups(self) -> list[list[int]]:
        """Parts that share a caster: those of nearly the size of the largest, then those of the next sizes."""
        left = [(ball.radius, index) for index, ball in enumerate(self.balls) if ball is not None]
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
        if available is not None and self.memory > available:
            got = f"{self.count:,} triangles, which take about {self.memory / 1e9:.3g} GB"
            allowed = f"as many as fit into the {available / 1e9:.3g} GB of memory that are free"
            check.refuse("occluders", got, allowed, "Fewer will do for shadows: mesh.decimate(0.9) takes nine in ten.")
        return [Caster(BlockingFaces.joined([self._parts[index] for index in group])) for group in self._groups]

    def resolution(self, part: int | None) -> float:
        """The length below which nothing is told apart at a part, or else at the finest one; 0 without any."""
        if not self.casters:
            return 0.0
        own = [caster for group, caster in zip(self._groups, self.casters, strict=True) if part in group]
        return (own or self.casters)[-1].resolution

    def blocked(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        """As `Caster.blocked`, by any part."""
        found = np.zeros(len(directions), bool)
        for caster in self.casters:
            if not found.any():
                found = caster.blocked(origins, directions, distances)
                continue
            free = np.flatnonzero(~found)
            some = origins[free // rays_each(origins, directions)]
            found[free] = caster.blocked(some, directions[free], distances[free])
        return found
