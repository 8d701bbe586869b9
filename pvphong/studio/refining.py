"""Refined pictures of lit meshes, computed in the background and shown while they are valid.

After a moment without changes, a thread refines a copy of the drawn mesh: coarsely first, then finer. Each finished
picture is shown. A change cancels the refinement, and the mesh is drawn again with its own vertices and their current
colours.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

from pvphong.base import text
from pvphong.base.display import Display
from pvphong.base.types import ByteArray, FloatArray
from pvphong.meshes.visibility import KnownOccluders
from pvphong.optics.maps import Map, fractions
from pvphong.scene.scene import Scene
from pvphong.studies.refine import BouncedLight, refine, watched
from pvphong.studio.background import Job
from pvphong.studio.lit_mesh import ARRAY, LitMesh

_AFTER = 0.2  # seconds without changes before refining starts
_OPACITY = "_opacity"
_MOST_ADDED = 200_000  # points
_LEVELS = (16.0, 4.0, 1.0)  # tolerances of the successive pictures, divided by the final one
_APART = 1.0  # seconds between two pictures of an unfinished level, at least


class _Picture(NamedTuple):
    """A refined mesh with its colours. The window shows it in place of the mesh's own vertices."""

    reached: float | None
    """Bound on the picture's colour errors; None if it is not known."""
    mesh: pv.PolyData
    linear: FloatArray
    """Linear colours."""
    opacities: ByteArray | None
    """Opacities from 0 to 255, if the mesh has them."""

    def show(self, display: Display) -> None:
        """Apply the display transform to the colours, and store the result in the array that VTK draws."""
        colors = display(self.linear)
        if self.opacities is not None:
            colors = np.column_stack([colors, self.opacities])
        self.mesh.point_data[ARRAY] = colors
        self.mesh.set_active_scalars(ARRAY, preference="point")


class Refining:
    """The refined picture of one lit mesh.

    Parameters
    ----------
    mesh : LitMesh
        The mesh to refine.
    tolerance : float
        Largest allowed colour error inside the triangles of the refined mesh, > 0.
    """

    def __init__(self, mesh: LitMesh, tolerance: float) -> None:
        self._mesh, self.tolerance = mesh, tolerance
        self.pictures = 0
        """Number of pictures made so far."""
        self.reason = ""
        """Reason why the picture is not refined within the tolerance; "" if it is, or will be."""
        self.reached: float | None = None
        """Tolerance of the picture that is shown; None if it is not known."""
        self._state: Any = None
        self._since = 0.0
        self._job: Job[None] | None = None
        self._made: list[_Picture] = []
        self._picture: _Picture | None = None
        self._display: Display | None = None
        self._part = 0.0
        self._shown: pv.PolyData | None = None
        self._is_final = False

    def update(
        self, scene: Scene, occluders: KnownOccluders | None, display: Display, *, held: bool, waits: bool
    ) -> None:
        """Show the refined picture of the mesh in its current state. If there is none, start to make one.

        Work starts after a moment without changes, and the picture is shown as soon as it is made. The mesh's colours
        must be up to date.

        Parameters
        ----------
        scene : Scene
            Lights, viewer and light model.
        occluders : KnownOccluders, optional
            The meshes that cast shadows on this mesh.
        display : Display
            Transform that shows the colours.
        held : bool
            True, for example during a drag, to show the mesh's own vertices and refine nothing.
        waits : bool
            True to block until the picture is made.
        """
        mesh, drawn = self._mesh, self._mesh.drawn
        is_left_alone = held or drawn.n_verts + drawn.n_lines or not drawn.n_cells
        if is_left_alone or mesh.state != self._state:
            self.forget()
        if is_left_alone:
            return
        if self._state is None:
            self._state, self._since = mesh.state, time.monotonic()
        if self._job is None and not self._is_final and (waits or time.monotonic() - self._since >= _AFTER):
            self._made, self._part = [], 0.0
            levels = _LEVELS[-1:] if waits else _LEVELS
            self._job = Job("refining", self._work(scene, occluders, display, levels, self._made))
            self._since = time.monotonic()
        if self._job is not None:
            if waits:
                self._job.go_on()
                self._job.wait()
            self._take(self._job)
        if self._shown is not None:
            if self._picture is not None and self._display != display:
                self._picture.show(display)
                self._display = display
            self._show(self._shown)

    def _take(self, job: Job[None]) -> None:
        """Take the last picture that the job has made if it is new, and record whether the job has ended."""
        self._part = max(self._part, job.part)
        is_done = job.is_done  # read before the pictures, because the last one may be added in between
        picture = self._made[-1] if self._made else None
        shown = self._mesh.drawn if picture is None else picture.mesh
        if shown is not self._shown and (is_done or self._made):
            self._shown, self._picture, self._display, self.pictures = shown, picture, None, self.pictures + 1
            self.reached = None if picture is None else picture.reached
        if is_done:
            self._job, self._is_final, self.reason = None, True, job.reason

    @property
    def is_awaited(self) -> bool:
        """True until the final picture of the mesh's present state is made."""
        return self._state is not None and not self._is_final

    @property
    def is_within(self) -> bool:
        """True if the shown picture is refined within the tolerance."""
        return self._is_final and not self.reason and self.reached is not None

    def result(self) -> pv.PolyData:
        """Return a copy of the shown picture, with its linear colours."""
        assert self._picture is not None, "a refined picture is shown"
        copied = self._picture.mesh.copy(deep=False)
        copied.point_data[ARRAY] = self._picture.linear
        copied.set_active_scalars(ARRAY, preference="point")
        return copied

    @property
    def part(self) -> float:
        """Progress of the picture that is being made, from 0 to 1."""
        return self._part

    @property
    def seconds(self) -> float:
        """Seconds for which the job has worked since its start or its last pause; 0 if it is paused, or no job runs."""
        return 0.0 if self._job is None or self._job.is_paused else time.monotonic() - self._since

    @property
    def is_paused(self) -> bool:
        """True after `pause`, until `go_on` is called or the mesh or scene changes."""
        return self._job is not None and self._job.is_paused

    def pause(self) -> None:
        """Pause the computation. The last picture stays visible."""
        if self._job is not None:
            self._job.pause()

    def go_on(self) -> None:
        """Continue a paused computation."""
        if self._job is not None and self._job.is_paused:
            self._since = time.monotonic()
            self._job.go_on()

    def cancel(self) -> None:
        """Cancel the computation.

        Until a change, the window keeps the last picture, or the mesh's own vertices without one.
        """
        if self.is_awaited:
            if self._job is not None:
                self._job.stop()
            self._job, self._is_final, self.reason = None, True, "cancelled"
            self._shown = self._shown or self._mesh.drawn

    def forget(self) -> None:
        """Cancel the computation, forget its pictures, and show the mesh's own vertices."""
        if self._job is not None:
            self._job.stop()
        self._state = self._job = self._shown = self._picture = self.reached = None
        self._is_final, self.reason = False, ""
        self._show(self._mesh.drawn)

    def _work(
        self,
        scene: Scene,
        occluders: KnownOccluders | None,
        display: Display,
        levels: Sequence[float],
        made: list[_Picture],
    ) -> Callable[[], None]:
        """Return the function that the background job runs.

        It makes one refined picture of the mesh for each tolerance.
        The function uses copies, since the originals may be edited meanwhile.

        Parameters
        ----------
        scene : Scene
            Lights, viewer and light model.
        occluders : KnownOccluders or None
            The meshes that cast shadows on this mesh.
        display : Display
            Transform that shows the colours.
        levels : sequence of float
            Tolerances of the pictures, as multiples of the final tolerance.
        made : list
            List to which each picture is appended.
        """
        mesh = self._mesh
        if display != Display():
            scene = replace(scene, light_model=replace(scene.light_model, clamp=False))
        _, vertices = mesh.planned(scene, occluders)
        arrays = {name: Map(np.array(fractions(name, values.rows))) for name, values in vertices.maps.items()}
        reflectance = mesh.material.reflectance
        if reflectance is not None and "tangents" in reflectance.needs:
            arrays["tangents"] = Map(np.array(vertices.tangents))
        material = replace(mesh.material, tangents=None).with_values(arrays)
        surface = mesh.drawn.copy()
        surface.clear_data()
        surface.point_data.active_normals = np.array(mesh.normals)
        opacities = mesh.opacities()
        if opacities is not None:
            surface.point_data[_OPACITY] = opacities.astype(np.float64)
        options: dict[str, Any] = {"matrix": mesh.matrix, "max_points": surface.n_points + _MOST_ADDED}
        options |= {"occluders": occluders or ()}
        if mesh.bounced is not None:
            options["transport"] = BouncedLight(mesh.bounced.sum(axis=0))

        last = time.monotonic()

        def picture_of(refined: pv.PolyData, reached: float | None) -> _Picture:
            linear, normals = np.array(refined[ARRAY]), np.asarray(refined.point_data.active_normals)
            alpha = None if opacities is None else np.rint(refined[_OPACITY]).astype(np.uint8)
            refined.clear_data()
            refined.point_data.active_normals = normals
            return _Picture(reached, refined, linear, alpha)

        def watch(so_far: Callable[[], pv.PolyData]) -> None:
            nonlocal last
            if time.monotonic() - last >= _APART and not (made and made[-1].reached):  # a finished level is better
                last = time.monotonic()
                made.append(picture_of(so_far(), None))

        def work() -> None:
            shares = np.cumsum([0.0, *(level**-0.5 for level in levels)])  # the time that each level takes, roughly
            for level, (start, end) in zip(levels, pairwise((shares / shares[-1]).tolist()), strict=True):
                tolerance = level * self.tolerance
                with text.stage("refining", start, end), watched(watch):
                    refined = refine(surface, scene, material, tolerance=tolerance, **options)
                    made.append(picture_of(refined, tolerance))

        return work

    def _show(self, picture: pv.PolyData) -> None:
        actor = self._mesh.actor
        if actor is not None and actor.mapper.dataset is not picture:
            actor.mapper.dataset = picture
