"""Whether rays are blocked by triangles, and what they meet first, in coordinates of any size.

In order: triangles, and what rays meet of them; the backends, Embree's twice and VTK's, which do the same; `Caster`,
which takes rays of any length from anywhere to a backend; and `Occluders`, parts that can block light, each the
triangles of one mesh.

A backend is built of at least one triangle, of finite coordinates from -1 to 1: a caster's triangles are moved to
their middle and scaled by a power of two. Its rays begin no further than a few such units away. So single precision has
the same resolution whatever the unit of length and however far from the origin all of it is.
"""

from __future__ import annotations

import functools
import importlib.util
import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

from pvphong.base import check
from pvphong.base.processes import available_memory
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.geometry.extent import Box, Sphere, box_of, sphere_around
from pvphong.geometry.rays import LONGEST, NEAR, begun_near, is_near
from pvphong.rays import embree
from pvphong.rays.embree import Embree, casters_of
from pvphong.shading import kernel
from pvphong.shading.kernel import Casters

BYTES_PER_TRIANGLE = 130
"""What a caster takes for each, about, measured with both backends from 1 to 3 million triangles."""

RESOLUTION = 2.0**-18
"""A share of the size of all of a caster's triangles; what is nearer to an end of a ray than that may be missed."""

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

    def __getstate__(self) -> dict[str, Any]:
        """For files: points that are a mesh's are but numbers there."""
        return {"points": np.asarray(self.points), "corners": self.corners}

    @cached_property
    def sound_numbers(self) -> IntArray:
        """Shape (k,): the numbers of those without a corner that is not finite."""
        if not len(self) or not len(self.points) or np.isfinite(box_of(self.points)).all():
            return np.arange(len(self))
        finite: Any = np.isfinite(self.points).all(axis=1)
        return np.flatnonzero(finite[self.corners].all(axis=1))

    @cached_property
    def sound(self) -> BlockingFaces:
        """Those without a corner that is not finite."""
        if len(self.sound_numbers) == len(self):
            return self
        used, corners = np.unique(self.corners[self.sound_numbers], return_inverse=True)
        return BlockingFaces(self.points[used], corners.reshape(-1, 3))

    @cached_property
    def box(self) -> Box | None:
        """Least and greatest coordinates, shape (3,), of those that are sound; None where there is none."""
        return box_of(self.sound.points) if len(self.sound) else None

    @property
    def sphere(self) -> Sphere | None:
        """Around those that are sound; None where there is none."""
        return None if self.box is None else sphere_around(self.box)


class Hits(NamedTuple):
    """What rays meet first."""

    triangles: IntArray
    """Shape (n,): their numbers; −1 where nothing is met."""
    weights: FloatArray
    """Shape (n, 2): of their second and third corners; the first has the rest of 1."""
    distances: Float64Array
    """Shape (n,): how far that is; infinity where nothing is met."""

    @classmethod
    def none(cls, count: int) -> Self:
        """Of so many rays that meet nothing."""
        return cls(np.full(count, -1), np.zeros((count, 2)), np.full(count, math.inf))


class Triangles(NamedTuple):
    """All triangles of some parts, as compiled code takes them."""

    starts: IntArray
    """Where each caster's begin in `numbers`."""
    numbers: IntArray
    """The number of each caster's own triangles among all."""
    corners: IntArray
    """Shape (m, 3): which of the points of all parts, one part after the other, are a triangle's."""


# --- backends


class Embreex:
    """Embree by embreex's own calls (the extra `rays`): the same, slower."""

    title = "embreex's own calls, which are slower"

    def __init__(self, points: Float64Array, corners: NDArray[np.int64]) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene = EmbreeScene(robust=True)
        self._mesh = TriangleMesh(self._scene, points.astype(np.float32), corners.astype(np.int32))
        self.blocked(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.ones(1))  # the first ray builds the tree

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """As `Embree.blocked`."""
        rays = (np.ascontiguousarray(a, np.float32) for a in (origins, directions))
        found: BoolArray = self._scene.run(*rays, dists=lengths.astype(np.float32), query="OCCLUDED") >= 0
        return found

    def first(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> Hits:
        """What is met first, of rays as for `blocked`."""
        rays = (np.ascontiguousarray(a, np.float32) for a in (origins, directions))
        found = self._scene.run(*rays, dists=lengths.astype(np.float32), query="INTERSECT", output=True)
        result, met = Hits.none(len(lengths)), found["geomID"] >= 0
        result.triangles[met], result.distances[met] = found["primID"][met], found["tfar"][met]
        result.weights[met] = np.stack([found["u"], found["v"]], axis=1)[met]
        return result


# Places on triangles are rounded too: with a tolerance of 0 some are missed.
_TOLERANCE = 2.0**-24


class Locator:
    """VTK's static cell locator: slower, and always there."""

    title = "VTK, which takes long"

    def __init__(self, points: Float64Array, corners: NDArray[np.int64]) -> None:
        self._locator = vtkStaticCellLocator()
        self._locator.SetDataSet(pv.PolyData.from_regular_faces(points, corners, deep=True))
        self._locator.BuildLocator()

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """As `Embree.blocked`."""
        return self.first(origins, directions, lengths).triangles >= 0

    def first(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> Hits:
        """As `Embreex.first`."""
        ends = origins + lengths[:, None] * directions
        meet: Any = self._locator.IntersectWithLine  # VTK's annotations have no numbers that it changes
        of_vtk: list[Any] = [mutable(0.0), mutable(0), mutable(0)]
        (t, part, cell), where, inside = of_vtk, [0.0] * 3, [0.0] * 3
        result = Hits.none(len(origins))
        for row, (a, b) in enumerate(zip(origins.tolist(), ends.tolist(), strict=True)):
            if meet(a, b, _TOLERANCE, t, where, inside, part, cell):
                result.triangles[row], result.weights[row] = cell.get(), inside[:2]
                result.distances[row] = t.get() * lengths[row]
        return result


def ray_backend() -> tuple[type[Embree | Embreex | Locator], str]:
    """What casts rays here, and why nothing faster does; "" for the fastest."""
    if importlib.util.find_spec("embreex") is None:
        return Locator, "embreex is not installed; pip install embreex"
    reason = embree.obstacle() or kernel.rays_obstacle()
    return (Embreex, reason) if reason else (Embree, "")


# --- rays of any length from anywhere


class Caster:
    """Triangles that block rays.

    Parameters
    ----------
    faces : BlockingFaces
        Triangles without an area, or with a corner that is not finite, block nothing; there are others.
    within : (low, high) or None
        Around these triangles and others: rays are rounded, and begin, as they do with all of them. None is the
        triangles' own box.
    backend : type
        What casts the rays.
    """

    def __init__(self, faces: BlockingFaces, within: Box | None, backend: type[Embree | Embreex | Locator]) -> None:
        box = within or faces.box
        assert box is not None
        low, high = box
        half = high / 2 - low / 2
        self._middle: Float64Array = low + half
        self._exponent = int(np.frexp(half.max())[1])
        scaled = np.ldexp(faces.sound.points - self._middle, -self._exponent)
        self.backend: Any = backend(scaled, faces.sound.corners)

    @property
    def place(self) -> tuple[float, ...]:
        """Its middle, and the power of two that brings it to −1 to 1."""
        return *self._middle.tolist(), math.ldexp(1.0, min(-self._exponent, 1023))

    @property
    def resolution(self) -> float:
        """The length that this caster resolves."""
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
        result = np.zeros(len(directions), bool)
        for rows, starts, towards, lengths, _ in self._near(origins, directions, distances):
            result[rows] = self.backend.blocked(starts, towards, lengths)
        return result

    def first(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> Hits:
        """What is met first, of rays as for `blocked`; triangles are numbered as `BlockingFaces.sound` has them."""
        result = Hits.none(len(directions))
        for rows, starts, towards, lengths, shorter in self._near(origins, directions, distances):
            hits = self.backend.first(starts, towards, lengths)
            result.triangles[rows], result.weights[rows] = hits.triangles, hits.weights
            result.distances[rows] = np.ldexp(hits.distances + shorter, self._exponent)
        return result

    def _near(
        self, origins: FloatArray, directions: FloatArray, distances: FloatArray
    ) -> Iterator[tuple[IntArray, Float64Array, FloatArray, Float64Array, Float64Array]]:
        """Rays that may meet something, some at once: their numbers, and what the backend takes of them.

        The last array says by how much they are shorter there, for they begin nearer to the triangles.
        """
        for begin in range(0, len(origins), _RAYS_AT_ONCE):
            part = slice(begin, begin + _RAYS_AT_ONCE)
            towards = directions[part]
            with np.errstate(over="ignore", invalid="ignore"):
                starts = np.ldexp(origins[part] - self._middle, -self._exponent)
                is_far = ~is_near(starts.T, NEAR)
                lengths = np.ldexp(np.asarray(distances[part], np.float64), -self._exponent)
                can_meet, shorter = np.isfinite(towards).all(axis=1), np.zeros(len(starts))
                if is_far.any():
                    far = starts[is_far].T, towards[is_far].T
                    shorter[is_far] = -begun_near(*far, 0.0)[1]
                    moved, lengths[is_far] = begun_near(*far, lengths[is_far])
                    starts[is_far] = np.transpose(moved)
                    can_meet &= is_near(starts.T, 2.0 * NEAR)
            can_meet &= lengths > 0.0
            rows = np.flatnonzero(can_meet)
            if len(rows):
                yield begin + rows, starts[rows], towards[rows], np.minimum(lengths[rows], LONGEST), shorter[rows]


@functools.cache
def warn_of_slow_rays() -> None:
    """Warn, once in a process, of rays that take long without embreex."""
    message = "VTK casts the rays, which takes long; pip install embreex makes them twenty times as fast."
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
    within : (low, high), optional
        Around the surface whose parts these are, with those that are not here: rays are as past all of it.
    """

    def __init__(self, parts: Sequence[BlockingFaces], within: Box | None = None) -> None:
        self.parts, self.within = tuple(parts), within

    def __getstate__(self) -> dict[str, Any]:
        """For files and other processes, where casters are built anew."""
        return {"parts": self.parts, "within": self.within}

    @property
    def counts(self) -> list[int]:
        """The number of triangles of each part."""
        return list(map(len, self.parts))

    @cached_property
    def _groups(self) -> list[list[int]]:
        """Parts that share a caster: those of nearly the size of the largest, then those of the next sizes.

        Parts of one surface share one, whatever their sizes.
        """
        left = [(part.sphere.radius, index) for index, part in enumerate(self.parts) if part.sphere is not None]
        left.sort(reverse=True)
        groups: list[list[int]] = []
        while left:
            alike = [index for radius, index in left if self.within or radius * _ALIKE >= left[0][0]]
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
        available, count = available_memory(), sum(self.counts)
        needed = count * BYTES_PER_TRIANGLE
        if available is not None and needed > available:
            got = f"{count:,} triangles, which take about {needed / 1e9:.3g} GB"
            allowed = f"as many as fit into the {available / 1e9:.3g} GB of memory that are free"
            check.refuse("occluders", got, allowed, "Fewer will do for shadows: mesh.decimate(0.9) takes nine in ten.")
        casters, (backend, _) = [], ray_backend()  # of one kind, though compiled code may come between two
        for group in self._groups:
            parts = [self.parts[index] for index in group]
            faces = parts[0] if len(parts) == 1 else BlockingFaces(*_joined(parts))
            casters.append(Caster(faces, self.within, backend))
        return casters

    @cached_property
    def triangles(self) -> Triangles:
        """Those of all parts, one part after the other."""
        firsts = np.cumsum([0, *self.counts])
        numbers = [
            np.concatenate([firsts[index] + self.parts[index].sound_numbers for index in group])
            for group in self._groups
        ]
        starts = np.cumsum([0, *map(len, numbers)])[:-1]
        empty = np.zeros(0, np.int64)
        corners = _joined(self.parts)[1] if self.parts else np.zeros((0, 3), np.int64)
        return Triangles(starts.astype(np.int64), np.concatenate([empty, *numbers]), np.ascontiguousarray(corners))

    @property
    def points(self) -> FloatArray:
        """Those of all parts, one part after the other."""
        return _joined(self.parts)[0] if self.parts else np.zeros((0, 3))

    @property
    def are_slow(self) -> bool:
        """Whether VTK casts the rays."""
        return any(isinstance(caster.backend, Locator) for caster in self.casters)

    @property
    def rays_at_once(self) -> int:
        """So many a thread casts in no more than a tenth of a second."""
        return 2**13 if self.are_slow else 2**17

    @cached_property
    def compiled(self) -> Casters | None:
        """As compiled code casts rays at them; None where it does not."""
        scenes = [caster.backend for caster in self.casters if isinstance(caster.backend, Embree)]
        return casters_of(scenes, [caster.place for caster in self.casters]) if scenes else None

    def resolution(self, part: int | None) -> float:
        """The length that is resolved at a part, or else at the finest one; 0 without any."""
        if not self.casters:
            return 0.0
        own = [caster for group, caster in zip(self._groups, self.casters, strict=True) if part in group]
        return (own or self.casters)[-1].resolution

    def blocked(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        """As `Caster.blocked`, by any part."""
        found = np.zeros(len(directions), bool)
        for caster in self.casters:
            free = np.flatnonzero(~found)
            found[free] = caster.blocked(origins[free], directions[free], distances[free])
        return found

    def first(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> Hits:
        """What rays meet first of all parts; triangles are numbered as `triangles` has them.

        Parameters
        ----------
        origins, directions, distances : ndarray
            As for `Caster.blocked`.
        """
        if self.compiled is not None:
            return Hits(*kernel.ray_hits(origins, directions, distances, self.compiled, self.triangles))
        result = Hits.none(len(directions))
        for caster, start in zip(self.casters, self.triangles.starts, strict=True):
            hits = caster.first(origins, directions, np.minimum(distances, result.distances))
            met = np.flatnonzero(hits.triangles >= 0)
            result.triangles[met] = self.triangles.numbers[start + hits.triangles[met]]
            result.weights[met], result.distances[met] = hits.weights[met], hits.distances[met]
        return result


def _joined(parts: Sequence[BlockingFaces]) -> tuple[FloatArray, NDArray[np.int64]]:
    """Points and corners of some parts, one after the other."""
    starts = np.cumsum([0, *(len(part.points) for part in parts[:-1])])
    corners = np.concatenate([part.corners + start for part, start in zip(parts, starts, strict=True)])
    return np.concatenate([part.points for part in parts]), corners
