"""What the vertices of a mesh see, as arrays to keep; and what a plan asks before any ray is cast."""

from __future__ import annotations

import math
import time
import zlib
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pvphong.base import check, text
from pvphong.base.text import html_table
from pvphong.base.types import FloatArray, IntArray
from pvphong.optics.light import Light
from pvphong.rays.between import may_block
from pvphong.rays.casting import tell_if_slow
from pvphong.rays.faces import Ball
from pvphong.rays.occluders import Occluders
from pvphong.rays.receiver import Receiver
from pvphong.rays.targets import Target
from pvphong.rays.tracing import Tracer
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
