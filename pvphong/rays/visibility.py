"""What the vertices of a mesh see, as arrays to keep; and what a plan asks before any ray is cast.

Rays from the vertices of a mesh to lights, and into the sky.
"""

from __future__ import annotations

import functools
import math
import time
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check, text, threads
from pvphong.base.text import html_table
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.base.vectors import dot
from pvphong.optics.light import Light
from pvphong.rays.casting import Ball, Occluders, tell_if_slow
from pvphong.rays.rays import Receiver, Target, Targets, may_block
from pvphong.rays.sampling import MOST_RAYS, Ask, Effort, Seen, in_tree_order, look
from pvphong.scene.light_model import LightModel

# Triangles of which it is said beforehand what memory their rays take.
_MANY = 2_000_000


class StandardError(NamedTuple):
    """Of what was sampled; 0 where one ray says all."""

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
    receiver : Receiver
        Whose vertices look.
    lights : sequence of Light
        The scene's, in the world, those that are off too.
    labels : sequence of str
        Their names.
    occluders : Occluders
        What is in the way.
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
    """

    def __init__(
        self,
        receiver: Receiver,
        lights: Sequence[Light],
        labels: Sequence[str],
        occluders: Occluders,
        *,
        two_sided: bool = False,
        distance: float = math.inf,
        tolerance: float = 1.0 / 255.0,
        samples: int | None = None,
        ambient: float = 1.0,
    ) -> None:
        self._receiver, self._lights, self._occluders = receiver, tuple(lights), occluders
        self.lights = tuple(labels)
        """Names of the lights, in the order of `per_light`."""
        self._tracer = Tracer(receiver, occluders, two_sided, distance, tolerance, samples, ambient)
        self._parts = np.ones((len(self.lights) + 1, len(receiver.points)), np.float32)
        self._errors = np.zeros_like(self._parts)
        self._done: set[int] = set()
        self.rays = 0
        """How many rays have been cast."""
        self.seconds = 0.0
        """How long that took."""

    def __repr__(self) -> str:
        return (
            f"<Visibility of {len(self.lights)} lights from {self._parts.shape[1]} vertices: "
            f"{self.rays} rays in {self.seconds:.3g} s{self._memory}>"
        )

    @property
    def _memory(self) -> str:
        """What the triangles in the way take, where that is much."""
        occluders = self._occluders
        much = f"; {occluders.count:,} triangles in the way take about {occluders.memory / 1e9:.2g} GB"
        return much if occluders.count >= _MANY else ""

    def _repr_html_(self) -> str:
        headings = ("seen", "mean part", "largest standard error")
        rows = [(name, *self._summary(row)) for row, name in enumerate((*self.lights, "the sky"))]
        return html_table(repr(self)[1:-1], headings, rows)

    def _summary(self, row: int) -> tuple[str, str]:
        """Of one array, if it has been computed: showing something casts no ray."""
        if row not in self._done:
            return "not asked for yet", ""
        return f"{self._parts[row].mean(dtype=np.float64):.3f}", f"{self._errors[row].max(initial=0.0):.4f}"

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
        """Of `per_light` and `sky`."""
        self.channels(range(len(self.lights)), sky=True)
        return StandardError(self._errors[:-1], self._errors[-1])

    def for_lights(self, lights: Sequence[Light], labels: Sequence[str], samples: int | None = None) -> Visibility:
        """Of the same vertices for a scene's lights now: what is known of those that have not moved is kept.

        Parameters
        ----------
        lights, labels
            As for the class.
        samples : int, optional
            Of what is not known yet.
        """
        result = self._anew(self._receiver, lights, labels, samples)
        as_good = self._tracer.samples in (None, samples)
        known = {_light_stamp(light): index for index, light in enumerate(self._lights) if index in self._done}
        for index, light in enumerate(result._lights):
            before = known.get(_light_stamp(light))
            if before is not None and (as_good or not light.has_size):
                result._keep(index, self._parts[before], self._errors[before])
        if len(self._lights) in self._done and as_good:
            result._keep(len(result._lights), self._parts[-1], self._errors[-1])
        return result

    def afresh(self, *, samples: int | None = None, rows: IntArray | None = None) -> Visibility:
        """With nothing known yet; the occluders, which take time to prepare, are shared.

        Parameters
        ----------
        samples : int, optional
            As for the class.
        rows : ndarray, optional
            Shape (m,): of these vertices alone. They share no face with others, so that adaptive rays may be more.
        """
        receiver = self._receiver if rows is None else self._receiver.some(rows)
        return self._anew(receiver, self._lights, self.lights, samples)

    def _anew(
        self, receiver: Receiver, lights: Sequence[Light], labels: Sequence[str], samples: int | None
    ) -> Visibility:
        tracer = self._tracer
        return Visibility(
            receiver,
            lights,
            labels,
            self._occluders,
            two_sided=tracer.two_sided,
            distance=tracer.distance,
            tolerance=tracer.tolerance,
            samples=samples,
            ambient=tracer.ambient,
        )

    def _keep(self, row: int, part: FloatArray, error: FloatArray) -> None:
        self._parts[row], self._errors[row] = part, error
        self._done.add(row)

    # -- what plans and evaluators ask

    def why_clear(self, light: int) -> str:
        """Why nothing can block a light; "" where something may."""
        return self._why_nothing(
            lambda ball: may_block(self._lights[light], self._receiver.extent.sphere, ball), "stands between"
        )

    def why_open(self) -> str:
        """Why nothing can hide the sky; "" where something may."""
        if math.isinf(self._tracer.distance):
            return self._why_nothing(lambda _: True, "is around it")
        sphere = self._receiver.extent.sphere

        def is_near(ball: Ball) -> bool:
            if sphere is None:
                return True
            return math.dist(ball.center, sphere.center) <= 1.001 * (
                ball.radius + sphere.radius + self._tracer.distance
            )

        return self._why_nothing(is_near, "is near enough")

    def channels(self, lights: Sequence[int], *, sky: bool) -> FloatArray:
        """Shape (lights + 1, n): `per_light` with `sky` in the last row; rows not asked for may not be computed yet."""
        for index in (*lights, *[len(self.lights)] * sky):
            if index not in self._done:
                tell_if_slow(len(self._receiver.points))
                start, is_sky = time.perf_counter(), index == len(self.lights)
                with text.about(f"rays to {'the sky' if is_sky else self.lights[index]}"):
                    seen = self._tracer.sky() if is_sky else self._tracer.light(self._lights[index])
                self._keep(index, seen.part, seen.error)
                self.rays += seen.rays
                self.seconds += time.perf_counter() - start
        result = self._parts.view()
        result.flags.writeable = False
        return result

    # -- whether it fits

    @cached_property
    def _stamp(self) -> tuple[int, ...]:
        return _stamp(self._receiver.points, self._lights)

    def refuse_other(
        self, points: FloatArray, lights: Sequence[Light], labels: Sequence[str], model: LightModel
    ) -> None:
        """Raise ValueError if it is not of these vertices in the world, of these lights, or of such a light model."""
        if len(points) != self._parts.shape[1]:
            check.refuse("visibility", f"one of {self._parts.shape[1]} vertices", f"one of the mesh's {len(points)}")
        remedy = "mesh.phong.visibility(scene) makes one."
        if tuple(labels) != self.lights:
            check.refuse("visibility", f"one of the lights {self.lights}", f"one of {tuple(labels)}", remedy)
        here, there = _stamp(points, lights), self._stamp
        if here[0] != there[0]:
            check.refuse("visibility", "one of other points", "one of the mesh where it is now", remedy)
        for label, now, then in zip(labels, here[1:], there[1:], strict=True):
            if now != then:
                check.refuse("visibility", f"one from before {label} moved", "one of the lights where they are", remedy)
        if model.two_sided and not self._tracer.two_sided:
            check.refuse("visibility", "one of a one-sided light model", "one of a two-sided one", remedy)
        if model.ambient_occlusion is not False and model.occlusion_distance != self._tracer.distance:
            got = f"one with occlusion up to {self._tracer.distance:g}"
            check.refuse("visibility", got, f"one up to {model.occlusion_distance:g}", remedy)

    # -- what is known before any ray is cast

    def _why_nothing(self, may: Callable[[Ball], bool], nothing: str) -> str:
        others = [ball for index, ball in enumerate(self._occluders.balls) if ball and index != self._receiver.part]
        if any(map(may, others)):
            return ""
        own = self._receiver.part
        if own is None or self._occluders.balls[own] is None:
            return f"nothing {nothing}"
        if self._tracer.two_sided or not self._receiver.is_convex:
            return ""
        return f"nothing {nothing}, and the mesh is convex" if others else "the mesh is convex, and alone"


def _stamp(points: FloatArray, lights: Sequence[Light]) -> tuple[int, ...]:
    """Numbers that tell apart points, and each light's place, direction and size."""
    world = np.ascontiguousarray(points, np.float64)
    return (zlib.crc32(world.tobytes()), *map(_light_stamp, lights))


def _light_stamp(light: Light) -> int:
    """A number that tells a light's place, direction and size, and of which parts it is, from others."""
    nodes = [
        (Target.of(node).place_or_way.tolist(), node.intensity if light.has_size else 1.0) for node in light.nodes(4)
    ]
    return zlib.crc32(repr((nodes, light.is_even)).encode())


# --- tracing


_VERTICES_AT_ONCE = 2**16
# Into so many lights without a size one with a size is divided.
_LIGHTS = 1024
# So many rays every vertex gets.
_LEAST, _LEAST_OF_ALL_AROUND = 16, 64
# In units of the resolution: rays end so far before a light, for it may stand on a face.
_BEFORE_LIGHT = 2.0


@dataclass(frozen=True)
class Tracer:
    """Casts a receiver's rays; the arguments are those of `Visibility`."""

    receiver: Receiver
    occluders: Occluders
    two_sided: bool
    distance: float
    tolerance: float
    samples: int | None
    ambient: float

    def _prepare(self) -> None:
        """Compute what threads are to share."""
        self.receiver.beside.shape, self.occluders.casters  # noqa: B018

    def _begins(self, rows: Any, sides: Any) -> Float64Array:
        above = self.occluders.resolution(self.receiver.part)
        return self.receiver.beside[rows] + above * sides * self.receiver.unit_normals[rows]

    def _sides(self, light: Light, some: slice = slice(None)) -> Float64Array:
        """1 where vertices face a light, -1 where they see it from their other side, 0 where not at all."""
        normals, points = self.receiver.unit_normals[some], self.receiver.points[some]
        with np.errstate(all="ignore"):
            ways = light.arrival(np.ascontiguousarray(points.T)).direction
            facing = np.nan_to_num(dot(normals.T, ways))
        return np.sign(facing) if self.two_sided else (facing > 0.0).astype(np.float64)

    def light(self, light: Light) -> Seen:
        """What the vertices see of a light in the world."""
        return self._see_part(light) if light.has_size else self._see_or_not(light)

    def _see_or_not(self, light: Light) -> Seen:
        """A light without a size: one ray for each vertex."""
        self._prepare()
        count, target = len(self.receiver.points), Target.of(light)
        part, rays = np.zeros(count), list[int]()

        def work(first: int, last: int) -> None:
            sides = self._sides(light, slice(first, last))
            facing = np.flatnonzero(sides)
            rows = first + facing
            begins = self._begins(rows, sides[facing, None])
            ways, distances = target.seen_from(begins)
            end = distances - _BEFORE_LIGHT * self.occluders.resolution(self.receiver.part)
            part[rows] = ~self.occluders.blocked(begins, ways, end)
            rays.append(len(rows))

        threads.run(work, count, _VERTICES_AT_ONCE)
        return Seen(part, np.zeros(count), sum(rays) * bool(self.occluders.casters))

    def _see_part(self, light: Light) -> Seen:
        targets = Targets(light, _LIGHTS)
        sides = self._sides(light.nodes(1)[0]) if self.two_sided else np.ones(len(self.receiver.points))
        sides[sides == 0.0] = 1.0
        brightness = len(targets) * light.intensity * max(np.ravel(light.diffuse).tolist())

        def ask(vertices: IntArray, chosen: IntArray) -> tuple[FloatArray, BoolArray]:
            picked = chosen.ravel() * len(targets) // MOST_RAYS
            rows = np.repeat(vertices, chosen.shape[1])
            normals = self.receiver.unit_normals[rows] * sides[rows, None]
            begins = self._begins(vertices, sides[vertices, None]).repeat(chosen.shape[1], axis=0)
            ways, distances = targets.seen_from(picked, begins)
            weights = np.maximum(dot(ways.T, normals.T), 0.0) * targets.strengths(picked, begins)
            weights[~np.isfinite(weights)] = 0.0
            sent = np.flatnonzero(weights)
            seen = np.zeros(len(weights), bool)
            end = distances[sent] - _BEFORE_LIGHT * self.occluders.resolution(self.receiver.part)
            seen[sent] = ~self.occluders.blocked(begins[sent], ways[sent], end)
            return weights.reshape(chosen.shape), seen.reshape(chosen.shape)

        return self._look(ask, brightness, least=_LEAST_OF_ALL_AROUND if light.is_even else _LEAST)

    def sky(self) -> Seen:
        """What the vertices see of the hemispheres around their normals."""
        ways = np.ascontiguousarray(_sky_ways().T, np.float32)
        normals = self.receiver.unit_normals
        frame = np.stack([*_frame(normals), normals]).astype(np.float32)
        has_normal: BoolArray = (normals != 0.0).any(axis=1)

        def ask(vertices: IntArray, chosen: IntArray) -> tuple[FloatArray, BoolArray]:
            toward, (x, y, z) = np.empty((*chosen.shape, 3), np.float32), (way[chosen] for way in ways)
            for axis in range(3):  # long rows at a time
                a, b, c = frame[:, vertices, axis, None]
                toward[..., axis] = x * a + y * b + z * c
            ends = np.broadcast_to(self.distance, chosen.size)
            seen = ~self.occluders.blocked(self._begins(vertices, 1.0), toward.reshape(-1, 3), ends)
            sent = np.broadcast_to(has_normal[vertices, None], chosen.shape).astype(np.float32)
            return sent, seen.reshape(chosen.shape)

        seen = self._look(ask, self.ambient, _LEAST_OF_ALL_AROUND)
        return seen._replace(part=np.where(has_normal, seen.part, 1.0))

    def _look(self, ask: Ask, brightness: float, least: int) -> Seen:
        receiver = self.receiver
        self._prepare()
        return look(
            len(receiver.points), ask, Effort(self.tolerance, self.samples, brightness, least), receiver.faces.corners
        )


@functools.cache
def _sky_ways() -> Float64Array:
    """Unit vectors about (0, 0, 1), as many as nodes, with the density of the cosine: a sunflower's seeds, projected.

    Sources: H. Vogel, "A better way to construct the sunflower head" (1979); Nusselt's analogon.
    """
    k = np.arange(MOST_RAYS)
    radius, around = np.sqrt((k + 0.5) / MOST_RAYS), k * math.pi * (3.0 - math.sqrt(5.0))
    ways = np.stack([radius * np.cos(around), radius * np.sin(around), np.sqrt(1.0 - radius * radius)], axis=1)
    return ways[in_tree_order(ways[:, :2])]


def _frame(normals: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Two unit vectors across each normal (T. Duff et al., "Building an orthonormal basis, revisited", 2017)."""
    x, y, z = normals.T
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    return first, np.stack([b, sign + y * y * a, -y], axis=1)
