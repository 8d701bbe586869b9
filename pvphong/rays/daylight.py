"""Daylight coefficients: the visible part of each patch of the sky, of the ground, and of the sun at many positions.

They depend on geometry only. Any weather then gives irradiances by one product per vertex (P. Tregenza, I. Waters,
"Daylight coefficients", 1983; the sun's own positions instead of patches: J. Mardaljevic, "Simulation of annual
daylighting profiles", 2000). In order: bins of sun positions; `SkyTracer` casts the rays; `Coefficients` stores what
they see; `received` is the product.

The irradiance by a patch that is completely visible needs no rays: it follows from the normal. Rays only give the
visible part of each patch, as the part of its own rays, weighted by their cosines. So an open surface has no error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base import sobol, text, threads
from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.optics.area.patches import Patches
from pvphong.optics.area.sampling import Sampling
from pvphong.optics.lights import DirectionalLight
from pvphong.rays.casting import Occluders
from pvphong.rays.rays import Receiver, part_by_arrays
from pvphong.rays.sampling import estimate_part
from pvphong.rays.visibility import Tracer
from pvphong.shading import kernel

# --- positions of the sun


class SunBins(NamedTuple):
    """Positions of the sun to which rays are cast, and the position that stands for each time."""

    directions: Float64Array
    """Unit vectors, shape (b, 3)."""
    of_times: IntArray
    """Index of the direction for each time, shape (t,); −1 if the sun is below the horizon."""


def sun_bins(to_sun: Float64Array, above: NDArray[np.bool_], degrees: float) -> SunBins:
    """Choose a few positions of the sun, so that each position is at most some degrees from a chosen one.

    The next choice is the position with the most others around it that are still without one (greedy set cover).

    Parameters
    ----------
    to_sun : ndarray
        Unit vectors to the sun, shape (t, 3).
    above : ndarray
        True where the sun is above the horizon, shape (t,).
    degrees : float
        Largest angle between a position and the chosen one; 0 to choose all positions.
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

# Number of different sets of directions. Vertices that share a set are cast and counted together.
_SETS = 64
_VERTICES_AT_ONCE = 2**13
_STREAM_OF_SETS, _STREAM_OF_SKY, _STREAM_OF_GROUND = 3, 4, 5
# A normal that is this near to the zenith does not see the ground.
_LEVEL = 1e-7
_GROUND_RAYS = 64
# Visible parts are stored as integers.
_WHOLE = 255


class Coefficients(NamedTuple):
    """Visible parts of the sky, the ground and the sun, for n vertices."""

    sky: NDArray[np.uint8]
    """Visible part of each patch of the sky, shape (n, k), in units of 1/255."""
    sky_error: FloatArray
    """Standard error of the visible part of the whole sky, weighted by cosines, shape (n,)."""
    ground: FloatArray
    """Visible part of the ground, all directions below the horizon, weighted by cosines, shape (n,)."""
    ground_error: FloatArray
    """Standard error of `ground`, shape (n,)."""
    sun: NDArray[np.uint8]
    """Whether each vertex sees the sun at each of b positions, shape (b, m): bits, eight vertices each."""
    rays: int

    @classmethod
    def bytes_for(cls, vertices: int, patches: int, positions: int) -> int:
        """Return the memory of the coefficients."""
        return vertices * (patches + 12) + positions * -(-vertices // 8)


@dataclass(frozen=True, eq=False)
class SkyTracer:
    """Casts rays from vertices to the sky, the ground and the sun.

    Parameters
    ----------
    receiver : Receiver
        The vertices.
    occluders : Occluders
        Parts that can block rays.
    axes : ndarray
        Unit vectors to the east, to the north and up, as rows.
    patches : Patches
        Patches of the sky.
    samples : int
        Number of rays per vertex to the sky, a power of two.
    to_sun : ndarray
        Unit vectors to positions of the sun, shape (b, 3).
    first : int
        Number of the first vertex, if the mesh is a piece of a larger one. It determines the random numbers.
    """

    receiver: Receiver
    occluders: Occluders
    axes: Float64Array
    patches: Patches
    samples: int
    to_sun: Float64Array
    first: int = 0

    @property
    def bytes_needed(self) -> int:
        """Number of bytes of the coefficients."""
        return Coefficients.bytes_for(len(self.receiver.points), len(self.patches), len(self.to_sun))

    def some(self, rows: IntArray) -> SkyTracer:
        """Return a tracer of some of the vertices."""
        return replace(self, receiver=self.receiver.some(rows))

    def cast(self) -> Coefficients:
        """Cast all rays."""
        self.receiver.origins, self.occluders.casters  # noqa: B018  threads will share them
        count, rays = len(self.receiver.points), list[int]()
        sky = np.full((count, len(self.patches)), _WHOLE, np.uint8)
        errors, ground = np.zeros((2, count), np.float32), np.ones(count, np.float32)
        sets = sobol.seeds(self.first + np.arange(count), _STREAM_OF_SETS)[0] % np.uint32(_SETS)
        tilt = self.receiver.unit_normals @ self.axes[2]
        if self.occluders.casters:
            above, below = np.flatnonzero(tilt > _LEVEL - 1.0), np.flatnonzero(tilt < 1.0 - _LEVEL)
            with text.stage("rays to the sky", 0.0, 0.4):
                rays += self._see_sky(sets, above, sky, errors[0])
            with text.stage("rays to the ground", 0.4, 0.5):
                rays += self._see_ground(sets, below, ground, errors[1])
        with text.stage("rays to the sun", 0.5, 1.0):
            sun, cast = self._see_sun()
        return Coefficients(sky, errors[0], ground, errors[1], sun, sum(rays) + cast)

    def _see_sky(
        self, sets: NDArray[np.uint32], rows: IntArray, sky: NDArray[np.uint8], errors: FloatArray
    ) -> list[int]:
        """Cast rays of some vertices to all patches, and write the visible parts and their errors."""
        sampling, rays, by_patch = self.patches.sampling(self.axes), list[int](), self._rays_by_patch

        def work(first: int, last: int) -> None:
            some = rows[first:last]
            some = some[np.argsort(sets[some], kind="stable")]
            sent, seen, cast = self._cast(sampling, some, sobol.seeds(sets[some], _STREAM_OF_SKY), self.samples)
            rays.append(cast)
            part, errors[some] = estimate_part(sent, seen)
            ends = np.searchsorted(sets[some], np.arange(_SETS + 1)).tolist()
            for (order, starts), begin, end in zip(by_patch, ends[:-1], ends[1:], strict=True):
                if begin < end:
                    whole, open_part = (np.add.reduceat(each[order, begin:end], starts) for each in (sent, seen))
                    is_sent = whole > 0.0  # else, the mean of the other patches
                    found = np.where(is_sent, open_part / np.where(is_sent, whole, 1.0), part[begin:end])
                    sky[some[begin:end]] = np.rint(found * _WHOLE).T

        with text.about("rays to the sky"):
            threads.run(work, len(rows), self._at_once)
        return rays

    @cached_property
    def _rays_by_patch(self) -> list[tuple[IntArray, IntArray]]:
        """For each set of directions: the numbers of its rays, ordered by patch, and the start of each patch's rays."""
        found, numbers = [], np.arange(self.samples, dtype=np.uint32)
        for seed in sobol.seeds(np.arange(_SETS), _STREAM_OF_SKY)[0]:
            patch = self.patches.chosen(sobol.coordinate(numbers, seed))
            order = np.argsort(patch, kind="stable")
            found.append((order, np.searchsorted(patch[order], np.arange(len(self.patches)))))
        return found

    def _see_ground(
        self, sets: NDArray[np.uint32], rows: IntArray, ground: FloatArray, errors: FloatArray
    ) -> list[int]:
        """Cast rays of some vertices below the horizon, and write the visible part of the ground and its error."""
        sampling, rays = self.patches.sampling(self.axes, -1.0), list[int]()

        def work(first: int, last: int) -> None:
            some = rows[first:last]
            sent, seen, cast = self._cast(sampling, some, sobol.seeds(sets[some], _STREAM_OF_GROUND), _GROUND_RAYS)
            rays.append(cast)
            ground[some], errors[some] = estimate_part(sent, seen)

        with text.about("rays to the ground"):
            threads.run(work, len(rows), self._at_once)
        return rays

    @property
    def _at_once(self) -> int:
        return min(_VERTICES_AT_ONCE, max(16 * self.occluders.rays_at_once // self.samples, 16))

    def _cast(
        self, sampling: Sampling, rows: IntArray, seeds: NDArray[np.uint32], count: int
    ) -> tuple[FloatArray, FloatArray, int]:
        """Cast rays of some vertices; return the rays' weights, and 0 for blocked rays, shape (rays, m) each."""
        compiled, numbers = self.occluders.compiled, np.asarray(sampling.numbers, np.float64)
        origins = self.receiver.above(rows, self.occluders.resolution(self.receiver.part))
        given = numbers, origins, self.receiver.unit_normals[rows], seeds, 0, count, 0.0
        stages = None if compiled is None else kernel.stages_of(sampling)
        if stages is None:
            sent, seen, _, rays = part_by_arrays(sampling, *given, self.occluders)
        else:
            sent, seen, _, rays = kernel.part_seen(stages, *given, compiled)
        return sent, seen, rays

    def _see_sun(self) -> tuple[NDArray[np.uint8], int]:
        """Cast a ray from each vertex to each position of the sun; return the bits, and the number of rays."""
        tracer, rays = Tracer(self.receiver, self.occluders, first=self.first), 0
        bits = np.zeros((len(self.to_sun), -(-len(self.receiver.points) // 8)), np.uint8)
        for k, direction in enumerate(self.to_sun.tolist()):
            x, y, z = direction
            with text.stage("rays to the sun", k / len(bits), (k + 1) / len(bits)), text.about("rays to the sun"):
                (seen,) = tracer.light(DirectionalLight((-x, -y, -z)))
            bits[k] = np.packbits(seen.part > 0.0)
            rays += seen.rays
        return bits, rays


# --- any weather


class Sources(NamedTuple):
    """What the sun, the sky and the ground send, summed over times."""

    sky: Float64Array
    """Radiance of each patch times hours, Wh/m²/sr, shape (k,)."""
    ground: float
    """Radiance of the ground times hours, Wh/m²/sr."""
    sun: Float64Array
    """Sum of direct normal irradiance × hours × unit vectors to the sun, for each position, Wh/m², shape (b, 3)."""
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


_PRODUCTS_AT_ONCE = 2**11


def received(
    coefficients: Coefficients, normals: Float64Array, axes: Float64Array, patches: Patches, sources: Sources
) -> Received:
    """Multiply coefficients with what the sun, the sky and the ground send.

    Parameters
    ----------
    coefficients : Coefficients
        Visible parts.
    normals : ndarray
        Unit normals, shape (n, 3); 0 where there is none.
    axes : ndarray
        Unit vectors to the east, to the north and up, as rows.
    patches : Patches
        Patches of the sky.
    sources : Sources
        What is sent, from the same patches and positions of the sun.
    """
    result = Received(*np.zeros((5, len(normals))))
    of_sun, of_sky = np.column_stack([sources.sun, sources.hours]), sources.sky / _WHOLE

    def work(first: int, last: int) -> None:
        some, n = slice(first, last), normals[first:last]
        bits = np.unpackbits(coefficients.sun[:, first // 8 : -(-last // 8)], axis=1, count=last - first)
        from_sun = bits.T.astype(np.float64) @ of_sun
        result.direct[some] = np.maximum((from_sun[:, :3] * n).sum(axis=1), 0.0)
        result.sun_hours[some] = from_sun[:, 3]
        cosines = patches.seen_from(n @ axes.T)
        open_sky = cosines @ sources.sky
        cosines *= coefficients.sky[some]
        result.diffuse[some] = cosines @ of_sky
        open_ground = (0.5 * math.pi * sources.ground) * (np.linalg.norm(n, axis=1) - n @ axes[2])
        result.ground[some] = open_ground * coefficients.ground[some]
        of_each = open_sky * coefficients.sky_error[some], open_ground * coefficients.ground_error[some]
        result.error[some] = np.hypot(*of_each)

    with text.about("daylight"):
        threads.run(work, len(normals), _PRODUCTS_AT_ONCE)
    return result
