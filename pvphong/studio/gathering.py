"""Bounced light between the lit meshes of a window, gathered with rays. Many rays are cast in the background.

The rays depend only on the positions of the meshes, so lights and materials may be edited while rays are cast. Until
the result arrives, meshes are drawn with the last light gathered at the same positions, or without bounced light.
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
from pvphong.shading.interreflection import Radiosity
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices
from pvphong.studio.background import Job
from pvphong.studio.lit_mesh import LitMesh

_LIVE = 2**13  # up to this many vertices, bounces are recomputed during a drag


Planned = Callable[[LitMesh], tuple[Plan, Vertices]]
"""Returns a mesh's plan (its simplified lighting equation) and vertices; raises ValueError if it cannot be lit."""


class _Gathered(NamedTuple):
    """Bounced light between meshes, and the inputs from which it was or is being computed."""

    state: Any
    """Inputs from which the light was computed: lights, light model, versions of the meshes, and number of rays. The
    viewer is included if a light moves with it or a diffuse reflection depends on it."""
    geometry: Any
    """Each mesh with its `LitMesh.geometry`, as they were when the light was computed."""
    bounces: int
    among: Transport
    brightness: Float64Array
    """Shape (3,): the sum of the lights' colours."""
    light: dict[LitMesh, FloatArray]
    """Bounced light of each mesh, shape (1, n, 3). A mesh without bounced light has no entry."""

    def at_brightness(self, brightness: Float64Array) -> dict[LitMesh, FloatArray]:
        """Return the bounced light, scaled to lights whose colours have the sum `brightness`.

        Each channel is multiplied by `brightness` over the sum for which the light was computed.
        """
        was = np.maximum(self.brightness, FAINTEST)
        factor = np.where(self.brightness > 0.0, brightness / was, 1.0).astype(np.float32)
        return {mesh: light * factor for mesh, light in self.light.items()}


class Gathering:
    """Bounced light between the lit meshes of one renderer.

    It is computed at once, or in a background job if it takes long.
    """

    def __init__(self) -> None:
        self.note = ""
        """Text to show while the light is not final."""
        self.reason = ""
        """The error message of the last background job; "" if it succeeded."""
        self.count = 0
        """Number of background jobs that have finished."""
        self._last: _Gathered | None = None
        self._job: Job[dict[LitMesh, FloatArray]] | None = None
        self._awaited: _Gathered | None = None

    @property
    def part(self) -> float | None:
        """Progress of the background job, from 0 to 1; None if there is no job."""
        return None if self._job is None else self._job.part

    @property
    def bounces(self) -> int:
        """Number of bounces in the light that is drawn while the background job runs; 0 if none is drawn."""
        last, awaited = self._last, self._awaited
        return 0 if last is None or awaited is None or last.geometry != awaited.geometry else last.bounces

    def transport(self, meshes: Sequence[LitMesh]) -> Transport | None:
        """Return the transport of light between meshes; None until light has been gathered where they are now."""
        geometry, last = [(mesh, mesh.geometry()) for mesh in meshes], self._last
        return last.among if last is not None and last.geometry == geometry else None

    def light(
        self, meshes: Sequence[LitMesh], planned: Planned, scene: Scene, samples: int | None, *, held: bool, waits: bool
    ) -> dict[LitMesh, FloatArray] | None:
        """Return the bounced light of each mesh, shape (1, n, 3); None while no bounced light is known.

        During a drag, the light of meshes with many vertices is not recomputed, only scaled to the lights' colours.

        Parameters
        ----------
        meshes : sequence of LitMesh
            The meshes that exchange light, except those that cannot be lit.
        planned : callable
            Returns the plan, that is, the simplified lighting equation, and the vertices of a mesh in the scene.
        scene : Scene
            A scene whose light model has bounces.
        samples : int or None
            Number of rays from each vertex to an area light; None for as many as accuracy needs.
        held : bool
            True during a drag.
        waits : bool
            True to block until the light is known.
        """
        exchanging, versions = dict[LitMesh, tuple[Plan, Vertices]](), dict[LitMesh, Any]()
        follows = any(light.frame != "world" for light in scene.lights)
        for mesh in meshes:
            with suppress(ValueError):  # a mesh that cannot be lit sends nothing; `refresh` reports it
                exchanging[mesh] = planned(mesh)
                versions[mesh] = mesh.version
                follows |= exchanging[mesh][0].equation.diffuse_needs_viewer
        self.note = ""
        if not exchanging:
            self.stop()
            return {}
        state = scene.lights, scene.light_model, versions, samples, scene.viewer if follows else None
        geometry, brightness = [(mesh, mesh.geometry()) for mesh in versions], _brightness(scene)
        self._take(geometry, waits)
        last = self._last if self._last is not None and self._last.geometry == geometry else None
        if last is not None and last.state == state:
            return last.light
        if last is not None and held and len(last.among) > _LIVE:
            self.note = "bounced light is updated after the drag"
            return last.at_brightness(brightness)
        if self._job is None:
            if last is None:  # copies, since the originals may be edited while rays are cast
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
        self.note = f"computing bounced light: {self._job.part:.0%}"
        return None if last is None else last.at_brightness(brightness)

    def _take(self, geometry: Any, waits: bool) -> None:
        """Take the result of the background job if it has ended. With `waits`, block until it ends.

        `geometry` has the meshes' present geometry. If the job began with another geometry, the job is cancelled.
        """
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
        """Cancel the background job."""
        if self._job is not None:
            self._job.stop()
            self._job = self._awaited = None


def _sent(exchanging: dict[LitMesh, tuple[Plan, Vertices]]) -> tuple[Radiosity, set[LitMesh]]:
    """Return the direct light that all meshes reflect, and the set of meshes that cannot be lit.

    Meshes in this set reflect nothing. `exchanging` maps each mesh to its plan, the simplified lighting equation, and
    its vertices.
    """
    sent, silent = list[Radiosity](), set[LitMesh]()
    for mesh, (plan, vertices) in exchanging.items():
        try:
            sent.append(plan.sent(vertices))
        except ValueError:  # `refresh` of the mesh reports why
            silent.add(mesh)
            sent.append(Radiosity(*np.zeros((3, len(vertices), 3), np.float32)))
    return Radiosity.of_all(sent), silent


def _brightness(scene: Scene) -> Float64Array:
    """Return the sum of the colours of all lights that are on, each times its intensity, shape (3,)."""
    lights = [light.intensity * np.array(rgb(light.diffuse)) for light in scene.lights if light.on]
    return np.sum([np.zeros(3), *lights], axis=0)
