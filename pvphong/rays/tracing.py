"""Rays from the vertices of a mesh to lights, and into the sky."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from pvphong.base import threads
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.base.vectors import dot
from pvphong.optics.light import Light
from pvphong.rays.occluders import Occluders
from pvphong.rays.receiver import Receiver
from pvphong.rays.sampling import MOST_RAYS, Ask, Effort, Seen, in_tree_order, look
from pvphong.rays.targets import Target, Targets

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
