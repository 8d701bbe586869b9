"""Diffuse light transport between vertices, by rays over each vertex's hemisphere.

A diffuse surface reflects its albedo times the cosine-weighted mean of the colours that it sees. If the density of the
rays is proportional to the cosine, this is a plain mean of the colours at the rays' first hits. Colours are known at
vertices, so a ray takes the colour of one corner of the triangle that it hits. The corner is chosen with the
barycentric weight of the hit as probability. So each vertex is a row of a sparse matrix T, whose entries are the
fractions of the vertex's rays. T times colours is the light after one bounce, and relighting needs no rays (C. Goral et
al., "Modeling the interaction of light between diffuse surfaces", 1984; rays in place of form factors: P. Shirley,
"Radiosity via ray tracing", 1991).

In order, `HemisphereTracer` casts the rays, `Transport` stores their hits in memory and in files, and `TransportPart`
supplies bounds for the vertices of one mesh, which plans use to simplify the lighting.
"""

from __future__ import annotations

import hashlib
import importlib.util
import math
import os
import time
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pvphong.base import check, sobol, text, threads
from pvphong.base.files import written_aside
from pvphong.base.processes import available_memory
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.optics.area.sampling import sky_sampling
from pvphong.rays.casting import Occluders, warn_of_slow_rays
from pvphong.rays.rays import Receiver, SendingTriangles, around_by_arrays
from pvphong.shading import kernel

# --- rays

_WORTH_A_WARNING = 2**12  # vertices
_FEW_RAYS, _FEW_RAYS_OF_VTK = 2**20, 2**15  # numbers that take a tenth or two of a second
_STREAM, _STREAM_OF_CORNERS = 1, 2  # streams of random numbers, different from those of visibility

Met = Callable[[int, int, NDArray[np.int32]], None]
"""Function that receives the hits of a block of m vertices. Its arguments are the number of the block's first vertex,
the number after that of its last vertex, and the vertices that the rays hit, shape (m, samples)."""


@dataclass(frozen=True, eq=False)
class HemisphereTracer:
    """Casts rays over the hemispheres of vertices.

    Parameters
    ----------
    receivers : sequence of Receiver
        Meshes whose vertices exchange light. Each mesh is one of the occluders' parts, or does not block light. A mesh
        without faces only gathers light; its `part` is the part on which its points lie.
    occluders : Occluders
        Geometry that rays hit. Parts that belong to no receiver block light, and are black.
    samples : int
        Number of rays per vertex, a multiple of 16.
    """

    receivers: Sequence[Receiver]
    occluders: Occluders
    samples: int

    @cached_property
    def starts(self) -> IntArray:
        """Index of each receiver's first vertex among the vertices of all receivers.

        The last entry is the total number.
        """
        return np.cumsum([0, *(len(each.points) for each in self.receivers)])

    @cached_property
    def triangles(self) -> SendingTriangles:
        """All triangles of the occluders. Triangles of receivers emit light from their fronts.

        The front of a triangle is the side to which its vertices' normals point.
        """
        starts, numbers, corners = self.occluders.triangles
        sides, firsts = np.zeros(len(corners), np.int8), np.cumsum([0, *self.occluders.counts])
        vertices = np.full_like(corners, -1)
        for each, start in zip(self.receivers, self.starts[:-1].tolist(), strict=True):
            if each.part is None or not len(each.faces):
                continue
            own = slice(firsts[each.part], firsts[each.part + 1])
            a, b, c = each.points[each.faces.corners].transpose(1, 0, 2)
            normals = each.unit_normals[each.faces.corners].sum(axis=1)
            with np.errstate(all="ignore"):
                sides[own] = np.nan_to_num(np.sign((np.cross(b - a, c - a) * normals).sum(axis=1)))
            vertices[own] = each.faces.corners + start
        return SendingTriangles(starts, numbers, vertices, sides)

    def may_see(self, receiver: Receiver) -> BoolArray:
        """Return True for vertices of a receiver that may see geometry above their tangent planes, shape (n,)."""
        result = np.zeros(len(receiver.points), bool)
        slack = self.occluders.resolution(receiver.part)
        for index, part in enumerate(self.occluders.parts):
            if part.box is None or (index == receiver.part and receiver.is_convex):
                continue
            low, high = part.box
            middle, half, normals = low / 2 + high / 2, high / 2 - low / 2, receiver.unit_normals
            with np.errstate(invalid="ignore"):
                height = ((middle - receiver.points) * normals).sum(axis=1) + np.abs(normals) @ half
                result |= height > slack
        return result & (receiver.unit_normals != 0.0).any(axis=1)

    def cast(self, found: Met, rows: IntArray | None = None) -> int:
        """Cast the rays of all vertices, or of some vertices of the first receiver, and return their number.

        Parameters
        ----------
        found : callable
            Function that receives the hits of each block of vertices. It is called from several threads. Vertices are
            counted through all receivers or, with `rows`, by their index in `rows`.
        rows : ndarray, optional
            Vertices, shape (k,), in ascending order.
        """
        compiled, sampling = self.occluders.compiled, sky_sampling(math.inf, 1.0)
        numbers, triangles = np.asarray(sampling.numbers, np.float64), self.triangles
        stages = None if compiled is None else kernel.stages_of(sampling)
        rays, pieces = list[int](), list[Callable[[], None]]()
        step = max(self.occluders.rays_at_once // self.samples, 1)

        def add_pieces_of(receiver: Receiver, own: IntArray, start: int) -> None:
            seeing, height = self.may_see(receiver)[own], self.occluders.resolution(receiver.part)

            def work(first: int, last: int) -> None:
                met = np.full((last - first, self.samples), -1, np.int32)
                looking = np.flatnonzero(seeing[first:last])
                vertices = own[first + looking]
                origins, normals = receiver.above(vertices, height), receiver.unit_normals[vertices]
                seeds = sobol.seeds(start + vertices, _STREAM), sobol.seeds(start + vertices, _STREAM_OF_CORNERS)[:1]
                given = numbers, origins, normals, np.concatenate(seeds), 0, self.samples
                if stages is not None:
                    met[looking], cast = kernel.vertices_met(stages, *given, compiled, triangles)
                else:
                    met[looking], cast = around_by_arrays(sampling, *given, self.occluders, triangles)
                rays.append(cast)
                found(start + first, start + last, met)

            receiver.origins  # noqa: B018  computed here because threads share it
            starts = range(0, len(own), step)
            pieces.extend(partial(work, first, min(first + step, len(own))) for first in starts)

        among = self.receivers if rows is None else self.receivers[:1]
        for receiver, start in zip(among, self.starts.tolist(), strict=False):
            add_pieces_of(receiver, np.arange(len(receiver.points)) if rows is None else rows, start)
        with text.about("rays between vertices"):
            threads.run(lambda first, _last: pieces[first](), len(pieces), 1)
        return sum(rays)


# --- stored hits

_FORMAT, _VERSION = "pvphong transport", 3
_PROBED = 512  # vertices that are sampled to estimate the cost of all rays
_BYTES_PER_RAY = 4
_GATHERED_AT_ONCE = 2**18  # rays
MEMORY = 2.0e9
"""Default memory limit of a transport in bytes; if the hits need more, rays are cast for each bounce."""


class TransportCost(NamedTuple):
    """Cost of rays that are not cast yet."""

    rays: int
    seconds: float
    memory: int
    """Memory of the hits in bytes; 0 if they are not stored."""


class Transport:
    """Diffuse light transport between vertices, for any lights and materials.

    Rays are cast when the transport is first used, and their hits are stored. An interrupted computation stores
    nothing.

    Parameters
    ----------
    tracer : HemisphereTracer or None
        Object that casts the rays; None for a transport from a file.
    memory : float
        Memory limit in bytes; if the hits need more, rays are cast for each bounce.
    checksum : str
        Checksum of the meshes.
    counts : tuple of int
        Number of vertices of each mesh.
    samples : int
        Number of rays per vertex.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> transport = pv.Sphere().phong.transport(samples=16)
    >>> model = ph.LightModel(bounces=2)
    >>> scene = ph.Scene([ph.DirectionalLight()], light_model=model)
    >>> lit = pv.Sphere().phong.shade(scene, transport=transport)
    """

    def __init__(
        self, tracer: HemisphereTracer | None, memory: float, checksum: str, counts: tuple[int, ...], samples: int
    ) -> None:
        self._tracer, self._memory, self._checksum, self._counts = tracer, memory, checksum, counts
        self._kept: NDArray[np.int32] | None = None
        self.samples = samples
        """Number of rays per vertex."""
        self.rays = 0
        """Number of rays cast so far."""
        self.seconds = 0.0
        """Time that the rays took."""

    @classmethod
    def of(cls, tracer: HemisphereTracer, memory: float) -> Self:
        """Return the transport for the rays of a tracer; `memory` is the memory limit in bytes."""
        counts = tuple(np.diff(tracer.starts).tolist())
        return cls(tracer, memory, checksum_of(tracer), counts, tracer.samples)

    @classmethod
    def of_hits(cls, hits: NDArray[np.int32], counts: tuple[int, ...] = (), checksum: str = "") -> Self:
        """Return a transport with the given hits, shape (n, samples).

        `counts` are the numbers of vertices of the meshes; by default, there is one mesh. `checksum` is that of the
        meshes.
        """
        result = cls(None, math.inf, checksum, counts or (len(hits),), hits.shape[1])
        result._kept = np.ascontiguousarray(hits)
        return result

    def __len__(self) -> int:
        return sum(self._counts)

    def __repr__(self) -> str:
        seen = "rays not cast yet" if not self.rays else f"{self.rays} rays in {self.seconds:.3g} s"
        return f"<Transport between {len(self)} vertices, {self.samples} rays each: {seen}>"

    @property
    def parts(self) -> list[TransportPart]:
        """The transport of each mesh's vertices."""
        return [TransportPart(self, index) for index in range(len(self._counts))]

    @property
    def slices(self) -> list[slice]:
        """The slice of each mesh's vertices among the vertices of all meshes."""
        ends = np.cumsum(self._counts).tolist()
        return [slice(end - count, end) for end, count in zip(ends, self._counts, strict=True)]

    @property
    def is_kept(self) -> bool:
        """True if the hits are stored, because they fit into the memory limit."""
        return self._kept is not None or _BYTES_PER_RAY * len(self) * self.samples <= self._memory

    @property
    def takes_long(self) -> bool:
        """True if the next use casts so many rays that a user interface would block."""
        rays = len(self) * self.samples
        if self._tracer is None or self._kept is not None or rays <= _FEW_RAYS_OF_VTK:
            return False
        return rays > _FEW_RAYS or self._tracer.occluders.are_slow

    def expected_cost(self) -> TransportCost:
        """Estimate the cost of the rays that are not cast yet. For this, rays are cast from some of the vertices.

        This builds the casters. VTK casts rays in one thread at a time.
        """
        if self._tracer is None or self._kept is not None:
            return TransportCost(0, 0.0, 0)
        count = self._counts[0]
        rows = np.unique(np.linspace(0, max(count - 1, 0), min(_PROBED, count)).astype(np.int64))
        with threads.limited(1):
            self._tracer.cast(lambda *_: None, rows[:1])  # exclude one-time costs of the first ray
            start = time.perf_counter()
            rays = self._tracer.cast(lambda *_: None, rows)
            taken = time.perf_counter() - start
        share, at_once = len(self) / max(len(rows), 1), 1 if self._tracer.occluders.are_slow else threads.count()
        memory = _BYTES_PER_RAY * len(self) * self.samples if self.is_kept else 0
        return TransportCost(round(rays * share), taken * share / at_once, memory)

    def gather(self, colors: Any) -> FloatArray:
        """Return the cosine-weighted mean colour that each vertex sees.

        Directions in which a ray hits nothing, or the back of a surface, count as black.

        Parameters
        ----------
        colors : array_like
            Colour that each vertex emits, shape (n, k), mesh by mesh.

        Returns
        -------
        ndarray
            Shape (n, k), float32.

        Raises
        ------
        ValueError
            If the number of colours differs from the number of vertices.
        """
        given = check.real_array("colors", colors, f"an array of shape ({len(self)}, k)")
        if given.ndim != 2 or len(given) != len(self):
            check.refuse("colors", f"an array of shape {given.shape}", f"an array of shape ({len(self)}, k)")
        triples, channels = -(-given.shape[1] // 3), given.shape[1]
        sent = np.zeros((len(self) + 1, 3 * triples), np.float32)  # the last row is for misses, whose number is −1
        sent[:-1, :channels] = given
        by_triple = np.ascontiguousarray(sent.reshape(-1, triples, 3).transpose(1, 0, 2))
        result = np.empty((triples, len(self), 3), np.float32)
        mean = kernel.gatherer() or _mean_by_arrays  # one function for all, even if compilation finishes meanwhile

        def add(first: int, last: int, met: NDArray[np.int32]) -> None:
            for colors, means in zip(by_triple, result, strict=True):
                means[first:last] = mean(met, colors)

        if self.is_kept:
            kept = self.hits
            work = lambda first, last: add(first, last, kept[first:last])  # noqa: E731
            threads.run(work, len(self), max(_GATHERED_AT_ONCE // self.samples, 1))
        else:
            self._cast(add)
        return result.transpose(1, 0, 2).reshape(len(self), -1)[:, :channels]

    @property
    def matrix(self) -> Any:
        """Transport matrix, `scipy.sparse.csr_array` (n, n), float32.

        Entry (i, j) is the fraction of the rays of vertex i that hit vertex j. The sum of row i is the part of the
        hemisphere of vertex i that fronts of surfaces fill, weighted by the cosine.

        Raises
        ------
        ValueError
            If the hits exceed the memory limit, or SciPy is missing.
        """
        met = self.hits
        if importlib.util.find_spec("scipy") is None:
            remedy = "`gather` works without SciPy. For the matrix, run pip install scipy."
            check.refuse("matrix", "no SciPy", "computed with SciPy", remedy)
        from scipy import sparse

        is_met = met >= 0
        columns, ends = met[is_met], np.append(0, np.cumsum(is_met.sum(axis=1)))
        shares = np.full(len(columns), 1.0 / self.samples, np.float32)
        result = sparse.csr_array((shares, columns, ends), shape=(len(self), len(self)))
        result.sum_duplicates()
        return result

    @property
    def hits(self) -> NDArray[np.int32]:
        """Index of the vertex that each ray hits, shape (n, samples); −1 if the ray hits nothing, or a back side."""
        if not self.is_kept:
            need = _BYTES_PER_RAY * len(self) * self.samples
            remedy = "Raise the limit with transport(memory=...); gather works without stored hits."
            check.refuse("memory", f"{self._memory:.3g} bytes", f"at least {need:.3g} bytes to store the hits", remedy)
        if self._kept is None:
            found = np.empty((len(self), self.samples), np.int32)

            def keep(first: int, last: int, met: NDArray[np.int32]) -> None:
                found[first:last] = met

            self._cast(keep)
            self._kept = found
        return self._kept

    def _cast(self, found: Met) -> None:
        """Cast all rays, and count rays and seconds. The function `found` receives the hits."""
        assert self._tracer is not None
        start = time.perf_counter()
        if len(self) >= _WORTH_A_WARNING and self._tracer.occluders.are_slow:
            warn_of_slow_rays()
        self.rays += self._tracer.cast(found)
        self.seconds += time.perf_counter() - start

    @cached_property
    def _sums(self) -> Float64Array:
        """Fraction of each vertex's rays that hit the front of a surface, shape (n,): the row sums of the matrix."""
        return (self.hits >= 0).mean(axis=1)

    # -- files

    def refuse_other(self, checksum: str) -> None:
        """Raise ValueError if this transport was made for other meshes than those with this checksum."""
        if checksum != self._checksum:
            remedy = "Recompute it with mesh.phong.transport(), with the same matrix, occluders and feature angle."
            check.refuse(
                "transport", "a Transport for other or moved meshes", "computed for the meshes that are lit", remedy
            )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Save the transport to a file in NumPy's format .npz; missing rays are cast first.

        Raises
        ------
        ValueError
            If the file cannot be written, or the hits exceed the memory limit.
        """
        met = self.hits
        with written_aside(path) as aside, aside.open("wb") as file:
            kind = np.array([_FORMAT, str(_VERSION), self._checksum])
            np.savez(file, format=kind, counts=np.array(self._counts, np.int64), met=met)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Load a file written by `save`.

        Raises
        ------
        ValueError
            If the file cannot be read, has another format or version, or is damaged.
        """
        allowed = "a file written by Transport.save"
        try:
            with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
                kind, counts, met = (file[name] for name in ("format", "counts", "met"))
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            check.refuse(
                "path",
                os.fspath(path),
                allowed,
                f"{type(error).__name__}: {error}. Recompute the transport with mesh.phong.transport().",
            )
        written = kind.tolist() if kind.shape == (3,) else []
        if not written or written[0] != _FORMAT or written[1] != str(_VERSION):
            got = f"{os.fspath(path)} of version {written[1]}" if written and written[0] == _FORMAT else os.fspath(path)
            check.refuse(
                "path", got, f"{allowed}, of version {_VERSION}", "Recompute the transport with mesh.phong.transport()."
            )
        count = int(counts.sum())
        is_sound = (
            (counts >= 0).all()
            and met.dtype == np.int32
            and met.ndim == 2
            and met.shape[1] > 0
            and len(met) == count
            and (met.min(initial=-1) >= -1 and met.max(initial=-1) < count)
        )
        if not is_sound:
            check.refuse(
                "path",
                os.fspath(path),
                allowed,
                "The file is damaged. Recompute the transport with mesh.phong.transport().",
            )
        return cls.of_hits(met, tuple(counts.tolist()), str(written[2]))


@dataclass(frozen=True, eq=False)
class TransportPart:
    """Transport of the vertices of one mesh.

    It supplies bounds to plans, and gathers light if there is only one mesh.
    """

    whole: Transport
    index: int

    @property
    def is_shared(self) -> bool:
        """True if vertices of other meshes emit light too."""
        return len(self.whole.slices) > 1

    @property
    def blocking(self) -> tuple[Occluders, int | None] | None:
        """The occluders, and the index of the mesh among their parts. None for a transport from a file."""
        tracer = self.whole._tracer
        return None if tracer is None else (tracer.occluders, tracer.receivers[self.index].part)

    def most(self) -> float:
        """Return the largest fraction of a vertex's hemisphere that fronts of surfaces fill, over this mesh's vertices.

        The hemisphere is weighted by the cosine. Before rays are cast, an upper bound on this fraction is returned.
        """
        whole, tracer = self.whole, self.whole._tracer
        if whole._kept is not None:
            return float(whole._sums[whole.slices[self.index]].max(initial=0.0))
        if tracer is None:
            return 1.0
        own, occluders = tracer.receivers[self.index], tracer.occluders
        if own.part is not None and not own.is_convex:
            return 1.0
        others = [each.part for each in tracer.receivers if each is not own and each.part is not None]
        spheres = [sphere for part in others if (sphere := occluders.parts[part].sphere) is not None]
        if not spheres or own.extent.sphere is None:
            return float(bool(spheres))
        center, radius = own.extent.sphere
        share = 0.0  # a sphere along the normal, of angular radius α, fills sin²α
        for sphere in spheres:
            nearest = math.dist(sphere.center, center) - radius
            share += (sphere.radius / nearest) ** 2 if nearest > sphere.radius else 1.0
        # margin for a finite number of rays: four standard errors of random rays, and one ray
        sampled = share + 4.0 * math.sqrt(share / whole.samples) + 1.0 / whole.samples
        return min(sampled, 1.0)

    def why_nothing(self) -> str:
        """Return the reason why no vertex of this mesh sees the front of a surface; "" if a vertex may see one.

        No rays are cast for this.
        """
        tracer = self.whole._tracer
        if self.whole._kept is not None:
            return "" if self.most() > 0.0 else "no vertex sees a lit surface"
        if tracer is None:
            return ""
        own = tracer.receivers[self.index]
        if any(each.part is not None for each in tracer.receivers if each is not own):
            return ""
        if own.part is None:
            return "nothing is around it"
        return "the mesh is convex, and alone" if own.is_convex else ""

    def gather(self, colors: FloatArray) -> FloatArray:
        """Return the cosine-weighted mean colour that each vertex sees, shape (n, k).

        `colors` is the colour that each vertex emits, shape (n, k).
        """
        return self.whole.gather(colors)


def checksum_of(tracer: HemisphereTracer) -> str:
    """Return a checksum of the points, normals and triangles of all meshes that exchange or block light.

    The checksum also depends on which meshes exchange light.
    """
    found = hashlib.sha256()  # processors have instructions for it
    for each in tracer.receivers:
        found.update(repr((len(each.points), each.part)).encode())
        found.update(np.ascontiguousarray(each.points if each.part is None else each.points[:0]).ravel().data)
        # coarse, because normals from NumPy and from compiled code differ by rounding
        found.update(np.rint(1024.0 * each.unit_normals).astype(np.int16).ravel().data)
    for part in tracer.occluders.parts:
        found.update(repr((len(part.points), len(part))).encode())
        found.update(np.ascontiguousarray(part.points, np.float64).ravel().data)
        found.update(part.corners.astype(np.uint32).ravel().data)
    return found.hexdigest()


def refuse_too_large(samples: int, count: int, memory: float) -> None:
    """Raise ValueError if a transport of `count` vertices, with `samples` rays each, needs more memory than is free.

    `memory` is the transport's memory limit in bytes. The transport never needs more than this limit.
    """
    available, needed = available_memory(), min(_BYTES_PER_RAY * samples * count, memory)
    if available is not None and needed > available:
        allowed = f"at most {available:.3g}, the number of free bytes"
        consequence = "hits are then not stored, and rays are cast again for each bounce, which takes longer"
        check.refuse("memory", f"{memory:.3g}", allowed, f"Pass a lower limit: {consequence}.")


def _mean_by_arrays(met: NDArray[np.int32], colors: FloatArray) -> FloatArray:
    """Return the mean of the colours that the rays of each vertex hit, shape (m, 3), computed with NumPy.

    `met`, shape (m, samples), are the vertices that the rays hit, −1 for no hit. `colors`, shape (n + 1, 3), are the
    colours of the vertices, then black.
    """
    numbers = met.astype(np.intp)
    columns = np.ascontiguousarray(colors.T)
    return np.stack([np.take(column, numbers, mode="wrap").sum(axis=1) for column in columns], axis=1) / met.shape[1]
