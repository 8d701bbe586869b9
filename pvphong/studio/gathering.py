"""Light that the lit meshes of a window send each other, gathered by rays; in the background where these are many.

Rays depend on where the meshes are alone: lights and materials may be edited while they are cast. Until then meshes
are drawn with what was gathered last in the same places, or without light that bounces.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.formulas import FAINTEST
from pvphong.base.types import Float64Array, FloatArray, rgb
from pvphong.meshes.transport import Exchanging, transport_of
from pvphong.rays.transport import Transport
from pvphong.scene.scene import Scene
from pvphong.shading import interreflection
from pvphong.shading.interreflection import Sent
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices
from pvphong.studio.background import Job
from pvphong.studio.lit_mesh import LitMesh

_LIVE = 2**13  # so many vertices have their own bounces while something is dragged


Planned = Callable[[LitMesh], tuple[Plan, Vertices]]
"""What will light one of the meshes, and on what; ValueError where it cannot be lit."""


class _Gathered(NamedTuple):
    """Light that bounces between meshes, as it was computed last, or is awaited."""

    state: Any
    """What it was computed for."""
    geometry: Any
    """The meshes, and stamps of where they are."""
    bounces: int
    among: Transport
    brightness: Float64Array
    """Shape (3,): the lights' colours together."""
    light: dict[LitMesh, FloatArray]
    """Shape (1, n, 3) for each mesh; none where there is none."""

    def at_brightness(self, brightness: Float64Array) -> dict[LitMesh, FloatArray]:
        """The light in the lights' colours now."""
        was = np.maximum(self.brightness, FAINTEST)
        factor = np.where(self.brightness > 0.0, brightness / was, 1.0).astype(np.float32)
        return {mesh: light * factor for mesh, light in self.light.items()}


class Gathering:
    """The light that bounces between the lit meshes of one renderer."""

    def __init__(self) -> None:
        self.note = ""
        """What is to be said of light that is not final."""
        self.reason = ""
        """Why the last light from the background is none; "" where it is one."""
        self.count = 0
        """How often light has come from the background."""
        self._last: _Gathered | None = None
        self._job: Job[dict[LitMesh, FloatArray]] | None = None
        self._awaited: _Gathered | None = None

    @property
    def part(self) -> float | None:
        """How many of the rays that are awaited are cast, from 0 to 1; None where none are awaited."""
        return None if self._job is None else self._job.part

    @property
    def bounces(self) -> int:
        """How many bounces are in what is drawn until light that is awaited has come."""
        last, awaited = self._last, self._awaited
        return 0 if last is None or awaited is None or last.geometry != awaited.geometry else last.bounces

    def light(
        self, meshes: Sequence[LitMesh], planned: Planned, scene: Scene, samples: int | None, *, held: bool, waits: bool
    ) -> dict[LitMesh, FloatArray] | None:
        """Shape (1, n, 3) for each mesh: light that all send each other. None where none is known yet.

        While something is dragged, that of many vertices is as before, in the lights' colours now.

        Parameters
        ----------
        meshes : sequence of LitMesh
            Those that can be lit exchange light.
        planned : callable
            Gives each one's plan and vertices in the scene.
        scene : Scene
            Its light model has bounces.
        samples : int or None
            So many rays go from each vertex to a light with a size.
        held : bool
            Whether something is being dragged.
        waits : bool
            Whether to come back with the light, and not before.
        """
        exchanging, versions = dict[LitMesh, tuple[Plan, Vertices]](), dict[LitMesh, Any]()
        for mesh in meshes:
            with suppress(ValueError):  # one that cannot be lit sends nothing, and says so elsewhere
                exchanging[mesh] = planned(mesh)
                versions[mesh] = mesh.version
        self.note = ""
        if not exchanging:
            self.stop()
            return {}
        state = scene.lights, scene.light_model, versions, samples
        geometry, brightness = [(mesh, mesh.geometry()) for mesh in versions], _brightness(scene)
        self._take(geometry, waits)
        last = self._last if self._last is not None and self._last.geometry == geometry else None
        if last is not None and last.state == state:
            return last.light
        if last is not None and held and len(last.among) > _LIVE:
            self.note = "light that bounces follows when let go"
            return last.at_brightness(brightness)
        if self._job is None:
            if last is None:  # of copies of what may be edited while rays are cast
                own = [Exchanging(mesh.drawn, partial(np.array, mesh.normals), mesh.matrix) for mesh in exchanging]
                among = transport_of(own)
            else:
                among = last.among
            sent, silent = _sent(exchanging)
            gathered = _Gathered(state, geometry, scene.light_model.bounces, among, brightness, {})

            def gather() -> dict[LitMesh, FloatArray]:
                shares = interreflection.bounced(sent, among.gather, gathered.bounces, apart=False)
                each = zip(exchanging, among.slices, strict=True)
                return {mesh: shares[:, rows] for mesh, rows in each if mesh not in silent}

            if waits or not among.takes_long:
                self._last = gathered._replace(light=gather())
                return self._last.light
            self._job, self._awaited = Job("gathering", gather), gathered
        self.note = f"light that bounces is gathered: {self._job.part:.0%}"
        return None if last is None else last.at_brightness(brightness)

    def _take(self, geometry: Any, waits: bool) -> None:
        """Take what has been gathered in the background, if it is of where the meshes are now."""
        if self._job is None or self._awaited is None:
            return
        if self._awaited.geometry != geometry:
            self.stop()
            return
        if waits:
            self._job.wait()
        if self._job.is_done:
            self.reason, self.count = self._job.reason, self.count + 1
            self._last = self._awaited._replace(light=self._job.result or {})
            self._job = self._awaited = None

    def stop(self) -> None:
        """Gather no more in the background."""
        if self._job is not None:
            self._job.stop()
            self._job = self._awaited = None


def _sent(exchanging: dict[LitMesh, tuple[Plan, Vertices]]) -> tuple[Sent, set[LitMesh]]:
    """What all meshes send before light has bounced, and those that cannot say."""
    sent, silent = list[Sent](), set[LitMesh]()
    for mesh, (plan, vertices) in exchanging.items():
        try:
            sent.append(plan.sent(vertices))
        except ValueError:  # its own refreshing says why
            silent.add(mesh)
            sent.append(Sent(*np.zeros((3, len(vertices), 3), np.float32)))
    return Sent.of_all(sent), silent


def _brightness(scene: Scene) -> Float64Array:
    """The colours of all lights together, shape (3,)."""
    lights = [light.intensity * np.array(rgb(light.diffuse)) for light in scene.lights if light.on]
    return np.sum([np.zeros(3), *lights], axis=0)
