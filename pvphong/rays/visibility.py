"""What the vertices of a mesh see of a scene's lights and of the sky.

In order: `Tracer` casts a receiver's rays; `Visibility` keeps what they found, as arrays to shade with again, and
answers what a plan asks before any ray is cast.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check, sobol, text, threads
from pvphong.base.text import html_table
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.base.vectors import dot
from pvphong.geometry.extent import Box
from pvphong.optics.area.sampling import Sampling, sky_sampling
from pvphong.optics.light import Light
from pvphong.rays.casting import BYTES_PER_TRIANGLE, BlockingFaces, Occluders, warn_of_slow_rays
from pvphong.rays.rays import (
    BEFORE_LIGHT,
    Receiver,
    may_block,
    may_hide,
    part_by_arrays,
    place_of,
    place_or_direction,
    rays_to,
)
from pvphong.rays.sampling import Cast, Seen, look
from pvphong.scene.light_model import LightModel
from pvphong.shading import kernel

# --- casting a receiver's rays

_VERTICES_AT_ONCE = 2**16
# So many rays every vertex gets.
_LEAST, _LEAST_OF_ALL_AROUND = 16, 64


@dataclass(frozen=True)
class Tracer:
    """Casts the rays of the vertices of one mesh.

    Parameters
    ----------
    receiver : Receiver
        Whose vertices look.
    occluders : Occluders
        What can block them.
    two_sided : bool
        Whether vertices that face away from a light see it too: from their other side.
    distance : float
        Up to where something hides the sky.
    tolerance : float
        Largest standard error of the colours of a white surface.
    samples : int or None
        So many rays for each vertex in place of that.
    ambient : float
        The sky's brightness, which that tolerance counts with.
    first : int
        Number of the first vertex, by which its rays are chosen: where it is a piece of a larger mesh.
    """

    receiver: Receiver
    occluders: Occluders
    two_sided: bool = False
    distance: float = math.inf
    tolerance: float = 1.0 / 255.0
    samples: int | None = None
    ambient: float = 1.0
    first: int = 0

    def light(self, light: Light) -> Seen:
        """What the vertices see of a light in the world."""
        return self._part_of(light) if light.has_size else self._all_or_nothing_of(light)

    def _sides(self, light: Light, some: slice = slice(None)) -> Float64Array:
        """1 where vertices face a light, -1 where they see it from their other side, 0 where not at all."""
        normals, points = self.receiver.unit_normals[some], self.receiver.points[some]
        with np.errstate(all="ignore"):
            facing = np.nan_to_num(dot(normals.T, light.arrival(np.ascontiguousarray(points.T)).direction))
        return np.sign(facing) if self.two_sided else (facing > 0.0).astype(np.float64)

    def _origins(self, rows: Any, sides: Any) -> Float64Array:
        """Where rays begin at some vertices, on the side of the surface that sees the light."""
        return self.receiver.above(rows, sides * self.occluders.resolution(self.receiver.part))

    def _all_or_nothing_of(self, light: Light) -> Seen:
        """A light without a size: one ray for each vertex."""
        receiver, compiled = self.receiver, self.occluders.compiled
        count, above = len(receiver.points), self.occluders.resolution(receiver.part)
        part, rays = np.zeros(count), list[int]()
        place = place_of(light)
        if place is None and not light.is_even:  # its direction differs from vertex to vertex
            compiled = None
        known = *place_or_direction(light).tolist(), float(place is not None), float(self.two_sided), above
        numbers = np.array([*known, BEFORE_LIGHT * above])

        def work(first: int, last: int) -> None:
            some = slice(first, last)
            if compiled is not None:
                vertices = receiver.points[some], receiver.origins[some], receiver.unit_normals[some]
                rays.append(kernel.point_seen(*vertices, numbers, compiled, part[some]))
                return
            sides = self._sides(light, some)
            facing = np.flatnonzero(sides)
            rows = first + facing
            origins = self._origins(rows, sides[facing, None])
            directions, distances = rays_to(light, origins)
            part[rows] = ~self.occluders.blocked(origins, directions, distances - numbers[-1])
            rays.append(len(rows))

        threads.run(work, count, _VERTICES_AT_ONCE)
        return Seen(part, np.zeros(count), sum(rays) * bool(self.occluders.casters))

    def _part_of(self, light: Light) -> Seen:
        """A light with a size: as many rays as it takes, weighted with what its points send."""
        if light.sampling is None:
            remedy = "A kind with `sampling` casts shadows; pvphong.optics.area.sampling says how."
            check.refuse("light", light, "one that says how rays to it are chosen", remedy)
        sides = self._sides(light.nodes(1)[0]) if self.two_sided else np.ones(len(self.receiver.points))
        sides[sides == 0.0] = 1.0
        margin = BEFORE_LIGHT * self.occluders.resolution(self.receiver.part)
        brightness = light.intensity * max(np.ravel(light.diffuse).tolist())
        return self._look(light.sampling, sides, margin, brightness, _LEAST_OF_ALL_AROUND if light.is_even else _LEAST)

    def sky(self) -> Seen:
        """What the vertices see of the hemispheres around their normals."""
        seen = self._look(
            sky_sampling(self.distance, 1.0),
            np.ones(len(self.receiver.points)),
            0.0,
            self.ambient,
            _LEAST_OF_ALL_AROUND,
        )
        has_normal: BoolArray = (self.receiver.unit_normals != 0.0).any(axis=1)
        return seen._replace(part=np.where(has_normal, seen.part, 1.0))

    def _look(self, sampling: Sampling, sides: Float64Array, margin: float, brightness: float, least: int) -> Seen:
        compiled, numbers = self.occluders.compiled, np.asarray(sampling.numbers, np.float64)
        stages = None if compiled is None else kernel.stages_of(sampling)

        def cast(vertices: IntArray, begin: int, end: int) -> Cast:
            normals = self.receiver.unit_normals[vertices] * sides[vertices, None]
            origins = self._origins(vertices, sides[vertices, None])
            given = numbers, origins, normals, sobol.seeds(self.first + vertices), begin, end, margin
            if stages is not None:
                return Cast(*kernel.part_seen(stages, *given, compiled))
            return Cast(*part_by_arrays(sampling, *given, self.occluders))

        options: Any = {"tolerance": self.tolerance, "samples": self.samples, "brightness": brightness, "least": least}
        count, triangles = len(self.receiver.points), self.receiver.faces.corners
        return look(count, cast, triangles, rays_at_once=self.occluders.rays_at_once, **options)


# --- what they found, kept

# From so many triangles on the representation says what memory their rays take.
_MANY = 2_000_000
# From so many vertices on VTK's rays are worth a warning.
_WORTH_A_WARNING = 2**15


# So many faces are picked to find out what rays from all vertices will take.
_PROBED = 256


class Cost(NamedTuple):
    """What rays take."""

    rays: int
    seconds: float


class StandardError(NamedTuple):
    """Standard errors of what was sampled; 0 where one ray is exact."""

    per_light: FloatArray
    """Shape (lights, n)."""
    sky: FloatArray
    """Shape (n,)."""


class Visibility:
    """What every vertex of a mesh sees of each light, and of the sky: arrays to keep, and to shade with again.

    Each is computed when it is first read, and kept; nothing is kept of one that is interrupted. Lights may then be
    dimmed, tinted and switched without a ray; one that has moved is refused.

    Parameters
    ----------
    tracer : Tracer
        Casts the rays.
    lights : sequence of Light
        The scene's, in the world, those that are off too.
    labels : sequence of str
        Their names.
    """

    def __init__(self, tracer: Tracer, lights: Sequence[Light], labels: Sequence[str]) -> None:
        self._tracer, self._receiver, self._lights = tracer, tracer.receiver, tuple(lights)
        self.lights = tuple(labels)
        """Names of the lights, in the order of `per_light`."""
        self._parts = np.ones((len(self.lights) + 1, len(self._receiver.points)), np.float32)
        self._errors = np.zeros_like(self._parts)
        self._done: set[int] = set()
        self.rays = 0
        """How many rays have been cast."""
        self.seconds = 0.0
        """How long that took."""

    def __repr__(self) -> str:
        seen = f"{len(self.lights)} lights from {self._parts.shape[1]} vertices"
        count = sum(self._tracer.occluders.counts)
        memory = count * BYTES_PER_TRIANGLE / 1e9
        much = f"; {count:,} triangles that block light take about {memory:.2g} GB" if count >= _MANY else ""
        return f"<Visibility of {seen}: {self.rays} rays in {self.seconds:.3g} s{much}>"

    def _repr_html_(self) -> str:
        """Showing it casts no ray."""
        rows = [(name, "not asked for yet", "") for name in (*self.lights, "the sky")]
        for row in self._done:
            part, error = self._parts[row].mean(dtype=np.float64), self._errors[row].max(initial=0.0)
            rows[row] = rows[row][0], f"{part:.3f}", f"{error:.4f}"
        return html_table(repr(self)[1:-1], ("seen", "mean part", "largest standard error"), rows)

    @property
    def per_light(self) -> FloatArray:
        """Shape (lights, n), float32, in [0, 1]: the part of each light that reaches each vertex.

        0 where a vertex faces away from it; the part of a light that has a size is weighted with what it sends.
        """
        return self.channels(range(len(self.lights)), sky=False)[:-1]

    @property
    def sky(self) -> FloatArray:
        """Shape (n,), float32, in [0, 1]: the open part of the hemisphere around the normal.

        Each part of it is weighted with the cosine; 1 where there is no normal.
        """
        return self.channels((), sky=True)[-1]

    @property
    def standard_error(self) -> StandardError:
        """The standard errors of `per_light` and `sky`."""
        self.channels(range(len(self.lights)), sky=True)
        return StandardError(self._errors[:-1], self._errors[-1])

    @property
    def blocking(self) -> tuple[Occluders, int | None]:
        """What can block the rays, and which part of it the mesh's own faces are, if they are one."""
        return self._tracer.occluders, self._receiver.part

    def expected_cost(self) -> Cost:
        """What all that is not computed yet will take, by rays from some vertices; roughly.

        Building what rays are tested with, which takes about a second for three million triangles, is done here.
        """
        corners, count = self._receiver.faces.corners, len(self._receiver.points)
        picked = corners if len(corners) else np.arange(count)
        rows = np.unique(picked[:: max(len(picked) // _PROBED, 1)])
        probe = self.afresh(samples=self._tracer.samples, rows=rows)
        for done in self._done:
            probe._keep(done, self._parts[done, rows], self._errors[done, rows])
        self._receiver.origins, self._tracer.occluders.casters  # noqa: B018  they are not to be counted
        probe.channels(range(len(self.lights)), sky=True)
        share = count / max(len(rows), 1)
        return Cost(round(probe.rays * share), probe.seconds * share)

    def for_lights(self, lights: Sequence[Light], labels: Sequence[str], samples: int | None = None) -> Visibility:
        """The same vertices, for a scene's lights now: what is known of those that have not moved is kept.

        Parameters
        ----------
        lights, labels
            As for the class.
        samples : int, optional
            Of what is not known yet.
        """
        result = Visibility(replace(self._tracer, samples=samples), lights, labels)
        is_as_good = self._tracer.samples in (None, samples)
        known = {_geometry_of(light): index for index, light in enumerate(self._lights) if index in self._done}
        for index, light in enumerate(result._lights):
            before = known.get(_geometry_of(light))
            if before is not None and (is_as_good or not light.has_size):
                result._keep(index, self._parts[before], self._errors[before])
        if len(self._lights) in self._done and is_as_good:
            result._keep(len(result._lights), self._parts[-1], self._errors[-1])
        return result

    def afresh(self, *, samples: int | None = None, rows: IntArray | None = None) -> Visibility:
        """A copy with nothing known yet; the occluders, which take time to prepare, are shared.

        Parameters
        ----------
        samples : int, optional
            As for the tracer.
        rows : ndarray, optional
            Shape (m,): of these vertices alone, and the faces between them, so that adaptive rays may be more.
        """
        receiver = self._receiver if rows is None else self._receiver.some(rows)
        return Visibility(replace(self._tracer, receiver=receiver, samples=samples), self._lights, self.lights)

    def part(self, row: int) -> tuple[FloatArray, FloatArray]:
        """The part that is seen of a light, or in the row after theirs of the sky, and its standard error, (n,)."""
        is_sky = row == len(self.lights)
        return self.channels(() if is_sky else (row,), sky=is_sky)[row], self._errors[row]

    def at(self, points: Float64Array, normals: FloatArray, origins: Float64Array) -> Visibility:
        """What is seen of the same lights, past the same occluders, from other places on the mesh.

        Parameters
        ----------
        points, normals, origins : ndarray
            Shape (n, 3), in the world; rays begin at the origins, above them by the resolution of the triangles.
        """
        nowhere = BlockingFaces(points, np.zeros((0, 3), np.int64))
        receiver = Receiver(nowhere, lambda: normals, self._receiver.part, origins)
        return Visibility(replace(self._tracer, receiver=receiver), self._lights, self.lights)

    def _keep(self, row: int, part: FloatArray, error: FloatArray) -> None:
        self._parts[row], self._errors[row] = part, error
        self._done.add(row)

    def channels(self, lights: Sequence[int], *, sky: bool) -> FloatArray:
        """Shape (lights + 1, n): `per_light` with `sky` in the last row; other rows may not be computed yet."""
        for index in (*lights, *[len(self.lights)] * sky):
            if index not in self._done:
                start, is_sky = time.perf_counter(), index == len(self.lights)
                self._receiver.origins, self._tracer.occluders.casters  # noqa: B018  found now: threads share them
                if len(self._receiver.points) >= _WORTH_A_WARNING and self._tracer.occluders.are_slow:
                    warn_of_slow_rays()
                with text.about(f"rays to {'the sky' if is_sky else self.lights[index]}"):
                    seen = self._tracer.sky() if is_sky else self._tracer.light(self._lights[index])
                self._keep(index, seen.part, seen.error)
                self.rays += seen.rays
                self.seconds += time.perf_counter() - start
        result = self._parts.view()
        result.flags.writeable = False
        return result

    def why_clear(self, light: int) -> str:
        """Why nothing can block a light; "" where something may."""
        seen_from = self._receiver.extent.box
        return self._why_nothing(lambda parts: may_block(self._lights[light], seen_from, parts), "stands between")

    def why_open(self) -> str:
        """Why nothing can hide the sky; "" where something may."""
        seen_from, distance = self._receiver.extent.box, self._tracer.distance
        nothing = "is around it" if math.isinf(distance) else "is near enough"
        return self._why_nothing(lambda parts: may_hide(seen_from, parts, distance), nothing)

    def _why_nothing(self, may_count: Callable[[Box], BoolArray], nothing: str) -> str:
        own, boxes = self._receiver.part, [part.box for part in self._tracer.occluders.parts]
        others = [box for index, box in enumerate(boxes) if box and index != own]
        if others:
            low, high = np.transpose(others, (1, 0, 2))
            if may_count((low, high)).any():
                return ""
        if own is None or boxes[own] is None:
            return f"nothing {nothing}"
        if self._tracer.two_sided or not self._receiver.is_convex:
            return ""
        return f"nothing {nothing}, and the mesh is convex" if others else "the mesh is convex, and alone"

    def refuse_other(
        self, points: FloatArray, lights: Sequence[Light], labels: Sequence[str], model: LightModel
    ) -> None:
        """Raise ValueError if it is not of these vertices in the world, of these lights, or of such a light model."""
        if len(points) != self._parts.shape[1]:
            check.refuse("visibility", f"one of {self._parts.shape[1]} vertices", f"one of the mesh's {len(points)}")
        remedy = "mesh.phong.visibility(scene) makes one."
        if tuple(labels) != self.lights:
            check.refuse("visibility", f"one of the lights {self.lights}", f"one of {tuple(labels)}", remedy)
        if not np.array_equal(points, self._receiver.points, equal_nan=True):
            check.refuse("visibility", "one of other points", "one of the mesh where it is now", remedy)
        for label, now, then in zip(labels, lights, self._lights, strict=True):
            if _geometry_of(now) != _geometry_of(then):
                check.refuse("visibility", f"one from before {label} moved", "one of the lights where they are", remedy)
        if model.two_sided and not self._tracer.two_sided:
            check.refuse("visibility", "one of a one-sided light model", "one of a two-sided one", remedy)
        if model.ambient_occlusion is not False and model.occlusion_distance != self._tracer.distance:
            got = f"one with occlusion up to {self._tracer.distance:g}"
            check.refuse("visibility", got, f"one up to {model.occlusion_distance:g}", remedy)


def _geometry_of(light: Light) -> str:
    """What rays to a light depend on: its place, direction, size and parts."""
    nodes = [(place_or_direction(node).tolist(), light.has_size and node.intensity) for node in light.nodes(4)]
    return repr((nodes, light.is_even))
