"""Occlusion tests and first hits of rays with triangles, in coordinates of any size.

In order: triangles and hits; backends; `Caster`; `Occluders`. There are three equivalent backends, two for Embree and
one for VTK. A caster prepares rays of any length and origin for a backend. Occluders are all geometry that can block
light. They consist of parts; a part is the triangles of one mesh. A caster holds the triangles of one or more parts.

A backend has at least one triangle. The coordinates are finite, from -1 to 1: a caster centres its triangles and scales
them by a power of two. Rays start at most a few such units away. So single precision has the same resolution for any
unit of length and any distance from the origin.
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
"""Memory of a caster per triangle, roughly, measured with both backends for 1 to 3 million triangles."""

RESOLUTION = 2.0**-18
"""Resolution of a caster, relative to the size of its triangles. Hits that are closer to an end of a ray may be
missed."""

_RAYS_AT_ONCE = 2**15


class SlowRaysWarning(UserWarning):
    """Warning that VTK casts many rays because embreex is not installed."""


# --- triangles


@dataclass(frozen=True, eq=False)
class BlockingFaces:
    """Triangles that block rays.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3).
    corners : ndarray
        Shape (m, 3): point indices of each triangle.
    """

    points: FloatArray
    corners: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.corners)

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling, with the points as a plain NumPy array."""
        return {"points": np.asarray(self.points), "corners": self.corners}

    @property
    def is_well_formed(self) -> bool:
        """True if the arrays have valid shapes and types, and all corners are indices of points."""
        points, corners = self.points, self.corners
        has_shapes = points.ndim == 2 and points.shape[1] == 3 and corners.ndim == 2 and corners.shape[1] == 3
        is_typed = points.dtype.kind == "f" and corners.dtype == np.int64
        return has_shapes and is_typed and (not corners.size or 0 <= corners.min() <= corners.max() < len(points))

    @cached_property
    def sound_numbers(self) -> IntArray:
        """Indices of the triangles whose three corners are finite, shape (k,)."""
        if not len(self) or not len(self.points) or np.isfinite(box_of(self.points)).all():
            return np.arange(len(self))
        finite: Any = np.isfinite(self.points).all(axis=1)
        return np.flatnonzero(finite[self.corners].all(axis=1))

    @cached_property
    def sound(self) -> BlockingFaces:
        """The same points, with only the triangles whose corners are finite."""
        if len(self.sound_numbers) == len(self):
            return self
        used, corners = np.unique(self.corners[self.sound_numbers], return_inverse=True)
        return BlockingFaces(self.points[used], corners.reshape(-1, 3))

    @cached_property
    def box(self) -> Box | None:
        """Least and greatest coordinates of the triangles with finite corners, shape (3,) each, or None."""
        return box_of(self.sound.points) if len(self.sound) else None

    @property
    def sphere(self) -> Sphere | None:
        """Bounding sphere of the triangles with finite corners; None if there are none."""
        return None if self.box is None else sphere_around(self.box)


class Hits(NamedTuple):
    """First hits of rays."""

    triangles: IntArray
    """Indices of the triangles, shape (n,); −1 for a miss."""
    weights: FloatArray
    """Barycentric weights of the second and third corners, shape (n, 2). The weight of the first corner is 1 minus
    these."""
    distances: Float64Array
    """Distances, shape (n,); infinity for a miss."""

    @classmethod
    def none(cls, count: int) -> Self:
        """Return hits in which `count` rays all miss."""
        return cls(np.full(count, -1), np.zeros((count, 2)), np.full(count, math.inf))


class Triangles(NamedTuple):
    """All triangles of the occluders, for compiled code. Each `Caster` tests rays with some of them."""

    starts: IntArray
    """Index in `numbers` at which each caster's triangles start."""
    numbers: IntArray
    """Indices of the casters' triangles among all triangles, caster after caster."""
    corners: IntArray
    """Point indices of each triangle, shape (m, 3), for the concatenated points of all parts."""


# --- backends


class Embreex:
    """Embree, called through embreex's own functions (the extra `rays`). Results are those of `Embree`, but slower."""

    title = "embreex's own calls (slower)"

    def __init__(self, points: Float64Array, corners: NDArray[np.int64]) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene = EmbreeScene(robust=True)
        self._mesh = TriangleMesh(self._scene, points.astype(np.float32), corners.astype(np.int32))
        self.blocked(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.ones(1))  # the first ray builds the tree

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Return True for each ray that hits a triangle within its length, shape (n,).

        `origins` and `directions` have the shape (n, 3), and `lengths` has (n,). The directions are unit vectors.
        """
        rays = (np.ascontiguousarray(a, np.float32) for a in (origins, directions))
        found: BoolArray = self._scene.run(*rays, dists=lengths.astype(np.float32), query="OCCLUDED") >= 0
        return found

    def first(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> Hits:
        """Find the first hit of each ray within its length.

        `origins` and `directions` have the shape (n, 3), and `lengths` has (n,). The directions are unit vectors.
        """
        rays = (np.ascontiguousarray(a, np.float32) for a in (origins, directions))
        found = self._scene.run(*rays, dists=lengths.astype(np.float32), query="INTERSECT", output=True)
        result, met = Hits.none(len(lengths)), found["geomID"] >= 0
        result.triangles[met], result.distances[met] = found["primID"][met], found["tfar"][met]
        result.weights[met] = np.stack([found["u"], found["v"]], axis=1)[met]
        return result


# VTK's tolerance of hits. Points on triangles are rounded; with a tolerance of 0, some hits are missed.
_TOLERANCE = 2.0**-24


class Locator:
    """VTK's static cell locator: slow, but always available."""

    title = "VTK (slow)"

    def __init__(self, points: Float64Array, corners: NDArray[np.int64]) -> None:
        self._locator = vtkStaticCellLocator()
        self._locator.SetDataSet(pv.PolyData.from_regular_faces(points, corners, deep=True))
        self._locator.BuildLocator()

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Return True for each ray that hits a triangle within its length, shape (n,).

        `origins` and `directions` have the shape (n, 3), and `lengths` has (n,). The directions are unit vectors.
        """
        return self.first(origins, directions, lengths).triangles >= 0

    def first(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> Hits:
        """Find the first hit of each ray within its length.

        `origins` and `directions` have the shape (n, 3), and `lengths` has (n,). The directions are unit vectors.
        """
        ends = origins + lengths[:, None] * directions
        meet: Any = self._locator.IntersectWithLine  # VTK's annotations lack output arguments
        of_vtk: list[Any] = [mutable(0.0), mutable(0), mutable(0)]
        (t, part, cell), where, inside = of_vtk, [0.0] * 3, [0.0] * 3
        result = Hits.none(len(origins))
        for row, (a, b) in enumerate(zip(origins.tolist(), ends.tolist(), strict=True)):
            if meet(a, b, _TOLERANCE, t, where, inside, part, cell):
                result.triangles[row], result.weights[row] = cell.get(), inside[:2]
                result.distances[row] = t.get() * lengths[row]
        return result


def ray_backend() -> tuple[type[Embree | Embreex | Locator], str]:
    """Return the class of the fastest available backend, and the reason why a faster one is not available.

    The reason is "" for `Embree`, the fastest of all.
    """
    if importlib.util.find_spec("embreex") is None:
        return Locator, "embreex is not installed; pip install embreex"
    reason = embree.obstacle() or kernel.rays_obstacle()
    return (Embreex, reason) if reason else (Embree, "")


# --- rays of any length and origin


class Caster:
    """Triangles, and a backend that casts rays at them.

    Parameters
    ----------
    faces : BlockingFaces
        Triangles, at least one of them with finite corners. Triangles without an area, or with a corner that is not
        finite, block nothing.
    within : (low, high) or None
        Box of a larger set of triangles that contains these. With this box, rays are rounded, and their origins are
        moved, as for the larger set. By default, the triangles' own box.
    backend : type
        Class that casts the rays.
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
        """Four numbers: the centre of the triangles' box, and the power of two that scales coordinates to [−1, 1]."""
        return *self._middle.tolist(), math.ldexp(1.0, min(-self._exponent, 1023))

    @property
    def resolution(self) -> float:
        """Smallest length that this caster resolves."""
        return math.ldexp(RESOLUTION, self._exponent)

    def blocked(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        """Return True for each ray that hits a triangle within its length.

        Parameters
        ----------
        origins : ndarray
            Shape (n, 3). A ray from a point that is not finite is not blocked.
        directions : ndarray
            Shape (n, 3), unit vectors.
        distances : ndarray
            Shape (n,): lengths of the rays, in the unit of the triangles; infinity for an unbounded ray.

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
        """Return the first hit of each ray within its length.

        The triangles in the result are indices in `BlockingFaces.sound`, which has only triangles with finite corners.

        Parameters
        ----------
        origins : ndarray
            Shape (n, 3). A ray from a point that is not finite hits nothing.
        directions : ndarray
            Shape (n, 3), unit vectors.
        distances : ndarray
            Shape (n,): lengths of the rays, in the unit of the triangles; infinity for an unbounded ray.
        """
        result = Hits.none(len(directions))
        for rows, starts, towards, lengths, shorter in self._near(origins, directions, distances):
            hits = self.backend.first(starts, towards, lengths)
            result.triangles[rows], result.weights[rows] = hits.triangles, hits.weights
            result.distances[rows] = np.ldexp(hits.distances + shorter, self._exponent)
        return result

    def _near(
        self, origins: FloatArray, directions: FloatArray, distances: FloatArray
    ) -> Iterator[tuple[IntArray, Float64Array, FloatArray, Float64Array, Float64Array]]:
        """Yield chunks of rays that may hit something, with arguments for the backend's `blocked` and `first`.

        `origins` and `directions` have the shape (n, 3), and `distances`, the lengths of the rays, have (n,). A chunk
        is five arrays. The first has the indices of its rays. The next three have the rays' origins, directions and
        lengths, in the backend's coordinates. The last has the length by which each ray is shortened. A ray from a far
        origin is shortened because its origin is moved along the ray to the triangles.
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
    """Warn once per process that rays are slow without embreex."""
    message = "VTK casts the rays, which is slow. For about 20 times the speed, pip install embreex."
    warnings.warn(message, SlowRaysWarning, stacklevel=2)


# --- occluders


# Largest ratio of sizes within a caster. Single precision resolves 2⁻²⁴ of the whole, which is too coarse for a much
# smaller part. So such a part has a caster of its own.
_ALIKE = 2.0**8


class Occluders:
    """Geometry that can block light, as several parts. A part is the triangles of one mesh.

    Parameters
    ----------
    parts : sequence of BlockingFaces
        Triangles of each part, in the world. A part is usually a mesh.
    within : (low, high), optional
        Box of a larger surface that contains the parts. Rays are then rounded as if the whole surface were given.
    """

    def __init__(self, parts: Sequence[BlockingFaces], within: Box | None = None) -> None:
        self.parts, self.within = tuple(parts), within

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling; casters are rebuilt when they are next used."""
        return {"parts": self.parts, "within": self.within}

    @property
    def counts(self) -> list[int]:
        """Number of triangles of each part, that is, of each mesh."""
        return list(map(len, self.parts))

    @cached_property
    def _groups(self) -> list[list[int]]:
        """Groups of parts of similar size, from large to small. A group is a list of part indices, and has one caster.

        With `within`, the parts are one surface, and share a caster regardless of their sizes.
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
        """A `Caster` for each group of parts (meshes), built when rays are first cast.

        Raises
        ------
        ValueError
            If the casters need more memory than is free.
        """
        available, count = available_memory(), sum(self.counts)
        needed = count * BYTES_PER_TRIANGLE
        if available is not None and needed > available:
            got = f"{count:,} triangles, which need about {needed / 1e9:.3g} GB"
            allowed = f"small enough for the {available / 1e9:.3g} GB of free memory"
            check.refuse("occluders", got, allowed, "Simplify them: mesh.decimate(0.9) removes nine triangles in ten.")
        casters, (backend, _) = [], ray_backend()  # one backend for all, even if compilation finishes meanwhile
        for group in self._groups:
            parts = [self.parts[index] for index in group]
            faces = parts[0] if len(parts) == 1 else BlockingFaces(*_joined(parts))
            casters.append(Caster(faces, self.within, backend))
        return casters

    @cached_property
    def triangles(self) -> Triangles:
        """Triangles of all parts (meshes), in the order of the parts."""
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
        """Points of all parts (meshes), in the order of the parts."""
        return _joined(self.parts)[0] if self.parts else np.zeros((0, 3))

    @property
    def are_slow(self) -> bool:
        """True if VTK casts the rays."""
        return any(isinstance(caster.backend, Locator) for caster in self.casters)

    @property
    def rays_at_once(self) -> int:
        """Number of rays that one thread casts in at most a tenth of a second."""
        return 2**13 if self.are_slow else 2**17

    @cached_property
    def compiled(self) -> Casters | None:
        """Casters for compiled code; None if compiled code cannot cast rays."""
        scenes = [caster.backend for caster in self.casters if isinstance(caster.backend, Embree)]
        return casters_of(scenes, [caster.place for caster in self.casters]) if scenes else None

    def resolution(self, part: int | None) -> float:
        """Return the smallest length that rays to a part, usually a mesh, can resolve; `part` is the part's index.

        If `part` is None, or no ray can hit the part, return this length for the smallest parts. If rays can hit no
        part at all, return 0.
        """
        if not self.casters:
            return 0.0
        own = [caster for group, caster in zip(self._groups, self.casters, strict=True) if part in group]
        return (own or self.casters)[-1].resolution

    def blocked(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        """Return True for each ray that a triangle of any part blocks within the ray's length, shape (n,).

        `origins` and `directions`, unit vectors, have the shape (n, 3). `distances`, shape (n,), are the rays' lengths.
        """
        found = np.zeros(len(directions), bool)
        for caster in self.casters:
            free = np.flatnonzero(~found)
            found[free] = caster.blocked(origins[free], directions[free], distances[free])
        return found

    def first(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> Hits:
        """Return the first hit of each ray within its length, among the triangles of all parts.

        Triangles are numbered as in `triangles`, part after part. `origins` and `directions`, unit vectors, have the
        shape (n, 3). `distances`, shape (n,), are the rays' lengths.
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
    """Return the points of all parts, and the corners of all triangles as indices of these points."""
    starts = np.cumsum([0, *(len(part.points) for part in parts[:-1])])
    corners = np.concatenate([part.corners + start for part, start in zip(parts, starts, strict=True)])
    return np.concatenate([part.points for part in parts]), corners
