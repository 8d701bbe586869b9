"""Daylight coefficients: the visible part of each patch of the sky, of the ground, and of the sun at many positions.

They depend on geometry only. The irradiances for any weather are then one product per vertex (P. Tregenza, I. Waters,
"Daylight coefficients", 1983; the sun's own positions instead of patches: J. Mardaljevic, "Simulation of annual
daylighting profiles", 2000). In order: bins of sun positions; `SkyTracer` casts the rays; `Coefficients` stores what
they see; `received` is the product.

The irradiance by a patch that is completely visible needs no rays: it follows from the normal. Rays only give the
visible part of each patch: the fraction of the patch's rays that nothing blocks, weighted by their cosines. So an open
surface has no error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pvphong.base import text, threads
from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.base.vectors import all_dots
from pvphong.optics.area.patches import Patches
from pvphong.rays.casting import Occluders
from pvphong.rays.rays import Receiver
from pvphong.shading import kernel

# --- positions of the sun


class SunBins(NamedTuple):
    """A few positions of the sun to which rays are cast, and the index of one of them for each time."""

    directions: Float64Array
    """Unit vectors, shape (b, 3)."""
    of_times: IntArray
    """Index in `directions` for each time, shape (t,); −1 if the sun is below the horizon."""


def sun_bins(to_sun: Float64Array, above: NDArray[np.bool_], degrees: float) -> SunBins:
    """Choose a few positions of the sun, so that each given position is at most `degrees` from a chosen position.

    A position covers all positions within this angle. The next choice is always the position that covers the most
    positions that are not covered yet (greedy set cover).

    Parameters
    ----------
    to_sun : ndarray
        Unit vectors to the sun, shape (t, 3).
    above : ndarray
        True for positions above the horizon, shape (t,). The other positions are ignored.
    degrees : float
        Largest angle between a given position and the nearest chosen position; 0 to choose all positions.
    """
    from scipy import sparse
    from scipy.spatial import cKDTree

    times, of_times = np.flatnonzero(above), np.full(len(to_sun), -1)
    if not len(times):
        return SunBins(np.zeros((0, 3)), of_times)
    tree = cKDTree(to_sun[times])
    pairs = tree.query_pairs(2.0 * math.sin(math.radians(0.5 * degrees)), output_type="ndarray")
    one, other = np.concatenate([pairs, pairs[:, ::-1], np.arange(len(times))[:, None].repeat(2, axis=1)]).T
    around = sparse.csr_array((np.ones(len(one), bool), (one, other)), shape=(len(times),) * 2)
    counts, chosen = np.diff(around.indptr), list[int]()
    while counts.max() > 0:
        k = int(counts.argmax())
        near = around.indices[around.indptr[k] : around.indptr[k + 1]]
        new = near[of_times[times[near]] < 0]
        of_times[times[new]] = len(chosen)
        chosen.append(int(times[k]))
        counts = counts - around[new].sum(axis=0)
    return SunBins(to_sun[chosen], of_times)


# --- rays

# Neighbouring vertices see the same position together: their rays are parallel, which makes them four times as fast.
_VERTICES_AT_ONCE, _VERTICES_OF_ARRAYS = 2**14, 2**10
_GROUND_RAYS = 2
# Visible parts are stored as integers.
_WHOLE = 255


class Coefficients(NamedTuple):
    """Visible parts of the sky, the ground and the sun, for n vertices."""

    sky: NDArray[np.uint8]
    """Visible part of each patch of the sky, weighted by cosines, shape (n, k), in units of 1/255."""
    ground: FloatArray
    """Visible part of the ground, all directions below the horizon, weighted by cosines, shape (n,)."""
    ground_error: FloatArray
    """Standard error of `ground`, shape (n,)."""
    sun: NDArray[np.uint8]
    """Bits that are 1 where a vertex sees the sun, for each of b positions, shape (b, m). A byte has the bits of eight
    vertices."""
    samples: int
    """Number of rays to each patch."""
    rays: int
    """Total number of rays."""

    @classmethod
    def bytes_for(cls, vertices: int, patches: int, positions: int) -> int:
        """Return the memory of the coefficients in bytes, for a number of vertices, sky patches and sun positions."""
        return vertices * (patches + 8) + positions * -(-vertices // 8)


@dataclass(frozen=True, eq=False)
class SkyTracer:
    """Casts rays from vertices to the sky, the ground and the sun.

    All vertices use the same directions. So the result does not depend on the order of vertices, nor on how a mesh is
    split.

    Parameters
    ----------
    receiver : Receiver
        The vertices.
    occluders : Occluders
        Geometry that can block rays.
    axes : ndarray
        Unit vectors to the east, to the north and up, as rows.
    patches : Patches
        Patches of the sky.
    samples : int
        Number of rays to each patch, at least 2.
    to_sun : ndarray
        Unit vectors to positions of the sun, shape (b, 3).
    """

    receiver: Receiver
    occluders: Occluders
    axes: Float64Array
    patches: Patches
    samples: int
    to_sun: Float64Array

    @property
    def bytes_needed(self) -> int:
        """Memory of the coefficients in bytes."""
        return Coefficients.bytes_for(len(self.receiver.points), len(self.patches), len(self.to_sun))

    def some(self, rows: IntArray) -> SkyTracer:
        """Return a tracer for the vertices `rows` (indices) only."""
        return replace(self, receiver=self.receiver.some(rows))

    def cast(self) -> Coefficients:
        """Cast all rays, and return the visible parts of sky, ground and sun."""
        self.receiver.origins, self.occluders.casters  # noqa: B018  threads will share them
        count, rays = len(self.receiver.points), list[int]()
        sky = np.empty((count, len(self.patches)), np.uint8)
        ground, errors = np.empty(count, np.float32), np.empty(count, np.float32)
        sun = np.zeros((len(self.to_sun), -(-count // 8)), np.uint8)
        to_sky = self.patches.points(self.samples) @ self.axes
        to_ground = self.patches.points(_GROUND_RAYS) * (1.0, 1.0, -1.0) @ self.axes

        def work(first: int, last: int) -> None:
            some = _Some.of(self, slice(first, last))
            for k, directions in enumerate(to_sky):
                sky[first:last, k] = np.rint(some.part_of(directions)[0] * _WHOLE)
            ground[first:last], errors[first:last] = some.part_of_all(to_ground)
            for k, direction in enumerate(self.to_sun):
                sun[k, first // 8 : -(-last // 8)] = np.packbits(some.seen(direction) > 0.0)
            rays.append(some.rays)

        with text.about("rays to the sky and the sun"):
            is_compiled = self.occluders.compiled is not None
            threads.run(work, count, _VERTICES_AT_ONCE if is_compiled else _VERTICES_OF_ARRAYS)
        return Coefficients(sky, ground, errors, sun, self.samples, sum(rays))


@dataclass(eq=False)
class _Some:
    """A block of vertices, all of which look in one direction after another."""

    points: Float64Array
    origins: Float64Array
    normals: Float64Array
    occluders: Occluders
    above: float
    """Height above the tangent planes from which rays start."""
    rays: int = 0
    """Number of rays cast so far."""

    @classmethod
    def of(cls, tracer: SkyTracer, rows: slice) -> Self:
        """Return the block of a tracer's vertices in the slice `rows`."""
        receiver, occluders = tracer.receiver, tracer.occluders
        vertices = receiver.points[rows], receiver.origins[rows], receiver.unit_normals[rows]
        return cls(*vertices, occluders, occluders.resolution(receiver.part))

    def seen(self, direction: Float64Array) -> Float64Array:
        """Return 1 for each vertex that faces a direction and sees the sky there, else 0, shape (m,).

        `direction` is a unit vector, shape (3,).
        """
        threads.go_on()
        result, compiled = np.zeros(len(self.points)), self.occluders.compiled
        if compiled is not None:
            numbers = np.array([*direction, 0.0, 0.0, self.above, 0.0])
            vertices = self.points, self.origins, self.origins, self.normals
            self.rays += kernel.point_seen(*vertices, numbers, compiled, result, result)
            return result
        rows = np.flatnonzero(all_dots(self.normals, direction[None])[:, 0] > 0.0)
        origins = self.origins[rows] + self.above * self.normals[rows]
        directions = np.broadcast_to(direction, origins.shape)
        result[rows] = ~self.occluders.blocked(origins, directions, np.full(len(rows), math.inf))
        self.rays += len(rows) * bool(self.occluders.casters)
        return result

    def part_of(self, directions: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Return the visible part of a patch, weighted by cosines, and the sum of the cosines, for each vertex.

        `directions`, shape (samples, 3), are the patch's rays. If the patch is behind the tangent plane, the visible
        part is 1.
        """
        cosines = all_dots(directions, self.normals)
        np.maximum(cosines, 0.0, out=cosines)
        whole, visible = cosines.sum(axis=0), np.zeros(len(self.points))
        if whole.any():
            for direction, cosine in zip(directions, cosines, strict=True):
                visible += np.multiply(cosine, self.seen(direction), out=cosine)
        is_above = whole > 0.0
        return np.divide(visible, whole, out=np.ones_like(whole), where=is_above), whole

    def part_of_all(self, patches: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Return the visible part of several patches of equal size together, and its standard error, for each vertex.

        `patches`, shape (k, samples, 3), are the directions of each patch's rays.
        """
        whole, visible, variance = np.zeros((3, len(self.points)))
        for directions in patches:
            part, cosines = self.part_of(directions)
            whole += cosines
            visible += part * cosines
            variance += variance_of(part, len(directions)) * cosines**2
        above = np.where(whole > 0.0, whole, 1.0)
        return np.where(whole > 0.0, visible / above, 1.0), np.sqrt(variance) / above


def variance_of(part: FloatArray, samples: int) -> FloatArray:
    """Return the variance of a visible part that is a mean over `samples` rays.

    It is the variance for random rays in a patch. The true rays are distributed more evenly, so it is an upper
    estimate.
    """
    return part * (1.0 - part) / (samples - 1.0)


# --- any weather


class Sources(NamedTuple):
    """Light that the sun, the sky and the ground emit, summed over times."""

    sky: Float64Array
    """Radiance of each patch, times hours, Wh/m²/sr, shape (k,)."""
    ground: float
    """Radiance of the ground, times hours, Wh/m²/sr."""
    sun: Float64Array
    """For each position of the sun, the sum of direct normal irradiance × hours × unit vector to the sun, Wh/m², shape
    (b, 3)."""
    hours: Float64Array
    """Hours of each position of the sun, shape (b,)."""


class Received(NamedTuple):
    """Light that n vertices receive."""

    direct: Float64Array
    """From the sun, Wh/m², shape (n,)."""
    diffuse: Float64Array
    """From the sky, Wh/m², shape (n,)."""
    ground: Float64Array
    """From the open ground, Wh/m², shape (n,)."""
    sun_hours: Float64Array
    """Hours with sun, shape (n,)."""
    error: Float64Array
    """Standard error of the sum of `diffuse` and `ground`, Wh/m², shape (n,)."""


# Vertices at once; and parts of their product with the sun. BLAS starts threads for larger products, which compete with
# these threads: with 32 parts, the product takes a sixth of the processor time.
_PRODUCTS_AT_ONCE, _PARTS = 2**11, 32


def _summable(values: Float64Array) -> Float64Array:
    """Round each column of numbers so that the sum of any of them is exact, in any order.

    The numbers become multiples of the unit with which the sum of all has 52 bits. A sum of b numbers changes by at
    most b times 2⁻⁵² of the sum of all: no more than by rounding the terms of a sum one after the other.
    """
    exponents = np.frexp(np.abs(values).sum(axis=0))[1] - 52
    return np.ldexp(np.rint(np.ldexp(values, -exponents)), exponents)


def received(
    coefficients: Coefficients, normals: Float64Array, axes: Float64Array, patches: Patches, sources: Sources
) -> Received:
    """Return the light that vertices receive: the product of coefficients and sources.

    Parameters
    ----------
    coefficients : Coefficients
        Visible parts.
    normals : ndarray
        Unit normals, shape (n, 3); 0 for a vertex without a normal.
    axes : ndarray
        Unit vectors to the east, to the north and up, as rows.
    patches : Patches
        Patches of the sky.
    sources : Sources
        Light of the same patches and positions of the sun.
    """
    result = Received(*np.zeros((5, len(normals))))
    of_sun = _summable(np.column_stack([sources.sun, sources.hours])).T.copy()

    def work(first: int, last: int) -> None:
        some, n = slice(first, last), normals[first:last]
        bits = np.unpackbits(coefficients.sun[:, first // 8 : -(-last // 8)], axis=1, count=last - first)
        parts = np.array_split(bits.astype(np.float64), _PARTS, axis=1)
        from_sun = np.concatenate([of_sun @ part for part in parts], axis=1)
        result.direct[some] = np.maximum((from_sun[:3].T * n).sum(axis=1), 0.0)
        result.sun_hours[some] = from_sun[3]
        lengths = np.linalg.norm(n, axis=1)
        local = all_dots(n, axes)
        from_patches = patches.seen_from(local)
        from_patches *= sources.sky
        from_patches[lengths == 0.0] = 0.0  # a vertex without a normal faces nothing
        visible = coefficients.sky[some] / _WHOLE
        result.diffuse[some] = (from_patches * visible).sum(axis=1)
        variance = (from_patches**2 * variance_of(visible, coefficients.samples)).sum(axis=1)
        open_ground = (0.5 * math.pi * sources.ground) * (lengths - local[:, 2])
        result.ground[some] = open_ground * coefficients.ground[some]
        result.error[some] = np.sqrt(variance + (open_ground * coefficients.ground_error[some]) ** 2)

    with text.about("daylight"):
        threads.run(work, len(normals), _PRODUCTS_AT_ONCE)
    return result
