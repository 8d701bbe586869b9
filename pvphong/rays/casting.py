"""Whether rays are blocked by triangles, in coordinates of any size.

In order: triangles; the backends, Embree's twice and VTK's, which do the same; `Caster`, which takes rays of any length
from anywhere to a backend; and `Occluders`, parts that can block light, each the triangles of one mesh.

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
from pvphong.geometry.rays import LONGEST, NEAR, begun_near, is_near
from pvphong.rays import embree
from pvphong.rays.embree import EmbreeScene
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
    """Intel's Embree, called by compiled code (the extras `rays` and `fast`), in single precision."""

    title = "compiled code and Embree"

    def __init__(self, faces: BlockingFaces) -> None:
        self.scene = EmbreeScene(faces.points, faces.corners)

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Whether a triangle is met: origins and unit vectors (n, 3), lengths (n,), all of moderate size."""
        return kernel.rays_blocked(origins, directions, lengths, casters_of([self.scene], [(0.0, 0.0, 0.0, 1.0)]))


def casters_of(scenes: Sequence[EmbreeScene], places: Sequence[Sequence[float]]) -> Casters:
    """Scenes, and what brings rays to their coordinates, as compiled code takes them."""
    handles = np.array([scene.handle for scene in scenes], np.int64)
    return Casters(embree.address_of_test(), handles, np.array(places, np.float64).reshape(-1, 4), scenes)


class Embreex:
    """Embree by embreex's own calls (the extra `rays`): the same, slower."""

    title = "embreex's own calls, which are slower"

    def __init__(self, faces: BlockingFaces) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene = EmbreeScene(robust=True)
        self._mesh = TriangleMesh(self._scene, faces.points.astype(np.float32), faces.corners.astype(np.int32))
        self.blocked(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.ones(1))  # the first ray builds the tree

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """As `Embree.blocked`."""
        rays = (np.ascontiguousarray(a, np.float32) for a in (origins, directions))
        found: BoolArray = self._scene.run(*rays, dists=lengths.astype(np.float32), query="OCCLUDED") >= 0
        return found


# Places on triangles are rounded too: with a tolerance of 0 some are missed.
_TOLERANCE = 2.0**-24


class Locator:
    """VTK's static cell locator: slower, and always there."""

    title = "VTK, which takes long"

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


def ray_backend() -> tuple[type[Embree | Embreex | Locator], str]:
    """What casts rays here, and why nothing faster does; "" for the fastest."""
    if importlib.util.find_spec("embreex") is None:
        return Locator, 'embreex is not installed; pip install "pvphong[rays]"'
    reason = embree.obstacle() or kernel.rays_obstacle()
    return (Embreex, reason) if reason else (Embree, "")


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
        self.backend = ray_backend()[0](BlockingFaces(scaled, faces.sound.corners)) if len(faces.sound) else None
        """None without triangles."""

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
        for start in range(0, len(origins), _RAYS_AT_ONCE) if self.backend else ():
            part = slice(start, start + _RAYS_AT_ONCE)
            result[part] = self._cast(origins[part], directions[part], distances[part])
        return result

    def _cast(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        assert self.backend is not None
        with np.errstate(over="ignore", invalid="ignore"):
            starts = np.ldexp(origins - self._middle, -self._exponent)
            is_far = ~is_near(starts.T, NEAR)
            lengths = np.ldexp(np.asarray(distances, np.float64), -self._exponent)
            can_meet = np.isfinite(directions).all(axis=1)
            if is_far.any():
                moved, lengths[is_far] = begun_near(starts[is_far].T, directions[is_far].T, lengths[is_far])
                starts[is_far] = np.transpose(moved)
                can_meet &= is_near(starts.T, 2.0 * NEAR)
        can_meet &= lengths > 0.0
        lengths = np.minimum(lengths, LONGEST)
        if can_meet.all():
            return self.backend.blocked(starts, directions, lengths)
        result = np.zeros(len(starts), bool)
        if can_meet.any():
            result[can_meet] = self.backend.blocked(starts[can_meet], directions[can_meet], lengths[can_meet])
        return result


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

    @property
    def are_slow(self) -> bool:
        """Whether VTK casts the rays."""
        return any(isinstance(caster.backend, Locator) for caster in self.casters)

    @cached_property
    def compiled(self) -> Casters | None:
        """As compiled code casts rays at them; None where it does not."""
        casters = [caster for caster in self.casters if caster.backend is not None]
        scenes = [caster.backend.scene for caster in casters if isinstance(caster.backend, Embree)]
        return casters_of(scenes, [each.place for each in casters]) if len(scenes) == len(casters) > 0 else None

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
