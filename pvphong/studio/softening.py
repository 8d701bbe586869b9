"""Soft shadows with a growing number of rays: hard shadows during a drag, a few rays after it, all rays later.

Rays to lights with a size, and to the sky, take far longer than lighting. During a drag, a single ray to each light's
centre is cast. After a change, a few rays give a picture at once. While nothing moves, a thread casts as many rays as
accuracy needs, and their result replaces the picture.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any, NamedTuple

from pvphong.meshes.visibility import KnownOccluders
from pvphong.rays.visibility import HARD, Visibility
from pvphong.scene.scene import Scene
from pvphong.studio.background import Job
from pvphong.studio.lit_mesh import LitMesh

_FEW = 16  # rays from each vertex to a light
_AT_ONCE = 2**13  # up to this many vertices in total, all rays are cast at once
_STILL = 0.05  # seconds without a change after which the thread starts


class _Wanted(NamedTuple):
    """The final visibility that a mesh needs; some of its rays may not be cast yet."""

    mesh: LitMesh
    visibility: Visibility
    lights: Sequence[int]
    """Indices of the lights whose visibility is read."""
    sky: bool
    behind: bool
    """True if the back sides of the vertices need rays too."""

    @property
    def rays(self) -> Any:
        """A value that changes with everything on which the rays depend; cheap to compare."""
        return self.mesh, self.visibility.geometry, self.lights, self.sky, self.behind, self.mesh.geometry()


class Softening:
    """The soft shadows on the lit meshes of one renderer."""

    def __init__(self) -> None:
        self.note = ""
        """Text to show while the shadows are not final."""
        self.count = 0
        """Number of background jobs whose result has been taken."""
        self._state: Any = None
        self._since = 0.0
        self._wanted: list[_Wanted] = []
        self._job: Job[None] | None = None
        self._casting: list[Any] = []  # `_Wanted.rays` of the job

    @property
    def is_awaited(self) -> bool:
        """True while the final shadows of the current state are not known."""
        return bool(self._wanted)

    def samples(
        self,
        meshes: Sequence[LitMesh],
        scene: Scene,
        occluders_of: Callable[[LitMesh, Scene], KnownOccluders | None],
        *,
        held: bool,
        waits: bool,
    ) -> int | None:
        """Return the number of rays from each vertex to each light; None for as many as accuracy needs.

        Parameters
        ----------
        meshes : sequence of LitMesh
            The meshes that are drawn.
        scene : Scene
            A scene whose light model needs rays.
        occluders_of : callable
            Returns the occluders of a mesh.
        held : bool
            True during a drag.
        waits : bool
            True if this picture must have the final shadows.
        """
        self.note = ""
        has_size = any(light.on and light.casts_shadows and light.has_size for light in scene.lights)
        if held and has_size:
            self.stop()
            self.note = "hard shadows until the drag ends"
            return HARD
        versions = dict[LitMesh, Any]()
        for mesh in meshes:
            with suppress(ValueError):  # a mesh that cannot be lit; `refresh` reports it
                versions[mesh] = mesh.version
        total = sum(mesh.drawn.n_points for mesh in versions)
        if waits or total <= _AT_ONCE or not (has_size or scene.light_model.ambient_occlusion is not False):
            self.stop()
            return None
        state = scene.world_lights, scene.light_model, versions
        if state != self._state:
            self._begin(state, [_wanted(mesh, scene, occluders_of(mesh, scene)) for mesh in versions])
        elif self._wanted and self._job is None and time.monotonic() - self._since >= _STILL:
            self._casting = [each.rays for each in self._wanted]
            self._job = Job("shadows", partial(_cast, self._wanted))
        if self._job is not None and self._job.is_done:
            for wanted in self._wanted if not self._job.reason else ():
                wanted.mesh.know(wanted.visibility, occluders_of(wanted.mesh, scene), scene)
            self._job, self._wanted, self.count = None, [], self.count + 1
        if not self._wanted:
            return None
        self.note = "soft shadows grow finer"
        return _FEW

    def _begin(self, state: Any, wanted: list[_Wanted | None]) -> None:
        """Record a state of meshes and lights, and the visibility that the meshes still need in it.

        `wanted` has an entry for each mesh; None if no rays are missing. A running job continues if it casts exactly
        the missing rays. Any other job is cancelled.
        """
        missing = [each for each in wanted if each is not None]
        if self._job is None or self._casting != [each.rays for each in missing]:
            self.stop()
            self._wanted = missing
        self._state, self._since = state, time.monotonic()

    def stop(self) -> None:
        """Cancel the background job, and forget the state."""
        if self._job is not None:
            self._job.stop()
        self._job, self._wanted, self._state = None, [], None


def _wanted(mesh: LitMesh, scene: Scene, occluders: KnownOccluders | None) -> _Wanted | None:
    """Return the final visibility that a mesh needs in a scene; None if it needs no rays, or cannot be lit.

    Rays that have been cast are not needed again. `occluders` are the meshes that cast shadows.
    """
    try:
        plan, visibility = mesh.final_visibility(scene, occluders)
    except ValueError:  # `refresh` reports it
        return None
    equation = plan.equation
    wanted = _Wanted(mesh, visibility, equation.shadowed, equation.is_occluded, equation.is_flipped)
    is_known = visibility.is_final(wanted.lights, sky=wanted.sky, behind=wanted.behind)
    return None if is_known or not equation.needs_visibility else wanted


def _cast(wanted: Sequence[_Wanted]) -> None:
    for each in wanted:
        each.visibility.channels(each.lights, sky=each.sky, behind=each.behind)
