"""Refined pictures of lit meshes, computed in the background and shown while they are valid.

After a moment without changes, a thread refines a copy of the drawn mesh. A change cancels the refinement, and the mesh
is drawn again with its own vertices and their current colours.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

from pvphong.base.display import Display
from pvphong.base.types import ByteArray, FloatArray
from pvphong.meshes.visibility import KnownOccluders
from pvphong.optics.maps import Map, fractions
from pvphong.scene.scene import Scene
from pvphong.studies.refine import BouncedLight, refine
from pvphong.studio.background import Job
from pvphong.studio.lit_mesh import ARRAY, LitMesh

_AFTER = 0.2  # seconds without changes before refining starts
_OPACITY = "_opacity"
_MOST_ADDED = 200_000  # points


class _Picture(NamedTuple):
    """A refined mesh, its linear colours, and its opacities from 0 to 255 if it has them."""

    mesh: pv.PolyData
    linear: FloatArray
    opacities: ByteArray | None

    def show(self, display: Display) -> None:
        """Write the colours as the display shows them."""
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
        Tolerance, as for `refine`.
    """

    def __init__(self, mesh: LitMesh, tolerance: float) -> None:
        self._mesh, self.tolerance = mesh, tolerance
        self.pictures = 0
        """Number of pictures made so far."""
        self.reason = ""
        """Reason why the last picture is not refined; "" if the picture is refined."""
        self._state: Any = None
        self._since = 0.0
        self._job: Job[_Picture] | None = None
        self._picture: _Picture | None = None
        self._display: Display | None = None
        self._shown: pv.PolyData | None = None

    def update(
        self, scene: Scene, occluders: KnownOccluders | None, display: Display, *, held: bool, waits: bool
    ) -> None:
        """Show the refined picture of the mesh's current state, if it is made already; otherwise start to make it after
        a moment without changes. The mesh's colours must be up to date.

        Parameters
        ----------
        scene : Scene
            Lights, viewer and light model.
        occluders : KnownOccluders, optional
            The meshes that cast shadows on this mesh.
        display : Display
            Transform that shows the colours.
        held : bool
            True during a drag, for example: show the mesh's own vertices and refine nothing.
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
        if self._shown is None and self._job is None and (waits or time.monotonic() - self._since >= _AFTER):
            self._job = Job("refining", self._work(scene, occluders, display))
        if self._job is not None and waits:
            self._job.wait()
        if self._job is not None and self._job.is_done:
            self.reason = self._job.reason
            self._picture, self._job, self.pictures = self._job.result, None, self.pictures + 1
            self._shown, self._display = drawn if self._picture is None else self._picture.mesh, None
        if self._shown is not None:
            if self._picture is not None and self._display != display:
                self._picture.show(display)
                self._display = display
            self._show(self._shown)

    @property
    def is_awaited(self) -> bool:
        """True if the picture of the mesh in its current state is not made yet."""
        return self._state is not None and self._shown is None

    def cancel(self) -> None:
        """Cancel the awaited picture and show the mesh's own vertices until the mesh's state changes."""
        if self.is_awaited:
            self.forget()
            self._state, self._shown, self.reason = self._mesh.state, self._mesh.drawn, "cancelled"

    def forget(self) -> None:
        """Show the mesh's own vertices and cancel the running job."""
        if self._job is not None:
            self._job.stop()
        self._state = self._job = self._shown = self._picture = None
        self.reason = ""
        self._show(self._mesh.drawn)

    def _work(self, scene: Scene, occluders: KnownOccluders | None, display: Display) -> Callable[[], _Picture]:
        """Return the function that makes the picture. The function uses copies, since the originals may be edited
        meanwhile.
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
        options |= {"occluders": occluders or (), "tolerance": self.tolerance}
        if mesh.bounced is not None:
            options["transport"] = BouncedLight(mesh.bounced.sum(axis=0))

        def work() -> _Picture:
            refined = refine(surface, scene, material, **options)
            linear = np.array(refined[ARRAY])
            alpha = None if opacities is None else np.rint(refined[_OPACITY]).astype(np.uint8)
            normals = np.asarray(refined.point_data.active_normals)
            refined.clear_data()
            refined.point_data.active_normals = normals
            return _Picture(refined, linear, alpha)

        return work

    def _show(self, picture: pv.PolyData) -> None:
        actor = self._mesh.actor
        if actor is not None and actor.mapper.dataset is not picture:
            actor.mapper.dataset = picture
