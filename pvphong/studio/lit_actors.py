"""Lit actors: the lit meshes of one renderer. Their colours are updated before each frame.

Visible meshes cast shadows on each other. A mesh that cannot be lit is not drawn, and the window shows the reason.
"""

from __future__ import annotations

import math
import textwrap
import warnings
import weakref
from collections.abc import Callable, Container, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkTextActor

from pvphong.base.display import Display
from pvphong.base.types import Float64Array, FloatArray
from pvphong.meshes.visibility import KnownOccluders, world_faces
from pvphong.optics.material import Material
from pvphong.rays.casting import BlockingFaces, Occluders
from pvphong.scene.scene import Scene
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices
from pvphong.studio.gathering import Gathering
from pvphong.studio.lit_mesh import LitMesh, SharedMaterial
from pvphong.studio.refining import Refining
from pvphong.studio.softening import Softening


class LightingWarning(UserWarning):
    """Warning that a mesh in a window cannot be lit. The mesh is not drawn until the problem is fixed.

    The warning is also given if bounced light or a refined picture cannot be computed.
    """


_BEFORE_GIZMOS = 1.0  # observer priority: gizmos show the highlights of the updated meshes
_MESSAGE_WIDTH, _MESSAGE_PLACE = 60, (10.0, 10.0)  # characters per line; pixels from the lower left

_ASK_AGAIN = 100  # milliseconds between two polls for background results


def _refuse(error: Exception, _mesh: LitMesh) -> bool:
    """Raise `error`. If an error prevents all lighting, this function replaces the function that updates a mesh."""
    raise error


MaterialsState = dict[SharedMaterial, Material]


class LitActors:
    """The lit meshes of one renderer, updated before each frame.

    Parameters
    ----------
    renderer : pyvista.Renderer
        The renderer that draws the meshes.
    scene : callable
        Returns the current scene.
    """

    def __init__(self, renderer: pv.Renderer, scene: Callable[[], Scene]) -> None:
        self.uses_preview_rays = False
        """True during a drag: shadows of area lights are hard."""
        self.note = ""
        """Text to show while the colours are not final."""
        self.is_in_a_page = False
        """True if a web page polls for background results: the page calls `refresh` while `is_awaiting`. Then no timer
        is used.
        """
        self.is_mixed = False
        """True while the web page's faders write the colours. Refined pictures are not shown then."""
        self.display = Display()
        """Transform that shows the colours; can be set at any time."""
        self.gathering = Gathering()
        self.softening = Softening()
        self._softened = 0  # the softening's count at the last refresh
        self._gathered = 0  # the gathering's count at the last refresh
        self._renderer, self._scene = renderer, scene
        self._meshes: list[LitMesh] = []
        self._refining: dict[LitMesh, Refining] = {}
        self._blocking: dict[LitMesh, tuple[Any, BlockingFaces]] = {}
        self._occluders = Occluders(())
        self._unlit: dict[LitMesh, str] = {}
        self._timer: tuple[Any, int, int] | None = None
        self._message = vtkTextActor()
        self._message.UseBoundsOff()
        self._message.PickableOff()
        self._message.SetPosition(*_MESSAGE_PLACE)
        style = self._message.GetTextProperty()
        style.SetFontSize(14)
        style.SetColor(1.0, 0.8, 0.3)
        style.SetBackgroundColor(0.1, 0.1, 0.1)
        style.SetBackgroundOpacity(0.75)
        actors = weakref.ref(self)

        def before_frame(_renderer: Any, _event: str) -> None:
            if (alive := actors()) is not None:
                alive.refresh()

        self._tag = renderer.AddObserver("StartEvent", before_frame, _BEFORE_GIZMOS)

    @property
    def meshes(self) -> tuple[LitMesh, ...]:
        """The lit meshes whose actors are still in the renderer. Meshes whose actors were removed are forgotten."""
        self._meshes = [mesh for mesh in self._meshes if self._renderer.HasViewProp(mesh.actor)]
        for mesh in [mesh for mesh in self._refining if mesh not in self._meshes]:
            self._refining.pop(mesh).forget()
        return tuple(self._meshes)

    @property
    def shown(self) -> list[LitMesh]:
        """The lit meshes that are visible."""
        return [mesh for mesh in self.meshes if mesh.actor is not None and mesh.actor.GetVisibility()]

    @property
    def scene(self) -> Scene:
        """The current scene."""
        return self._scene()

    def vertices(self) -> list[tuple[LitMesh, Vertices]]:
        """Return each visible mesh with its vertices. The vertices include the visibility of the current lights.

        Raises
        ------
        ValueError
            If a mesh cannot be lit.
        """
        scene, shown = self.scene, self.shown
        if scene.light_model.needs_rays:
            self._gather_occluders(shown)
        return [(mesh, mesh.planned(scene, self.occluders_of(mesh, scene))[1]) for mesh in shown]

    @property
    def stage(self) -> LitMesh | None:
        """The stage (ground, backdrop or plinth) under the meshes; None if there is no stage."""
        return next((mesh for mesh in self.meshes if mesh.stage is not None), None)

    @property
    def subjects(self) -> list[LitMesh]:
        """The visible lit meshes without the stage."""
        return [mesh for mesh in self.shown if mesh.stage is None]

    @contextmanager
    def without_bounds_of_stage(self) -> Iterator[None]:
        """Return a context in which the bounds of the drawn objects do not include the stage (ground or backdrop)."""
        actor = None if self.stage is None else self.stage.actor
        if actor is not None:
            actor.UseBoundsOff()
        try:
            yield
        finally:
            if actor is not None:
                actor.UseBoundsOn()

    def others(self, mesh: LitMesh) -> list[tuple[pv.PolyData, Float64Array | None]]:
        """Return the other visible meshes that cast shadows on `mesh`, each with its model matrix.

        The result can be passed to `shade` as `occluders`.
        """
        return [(each.drawn, each.matrix) for each in self.shown if each is not mesh and each.casts_shadows]

    @property
    def refining(self) -> dict[LitMesh, Refining]:
        """Refined picture of each visible mesh that is refined."""
        return {mesh: self._refining[mesh] for mesh in self.shown if mesh in self._refining}

    @property
    def is_awaiting(self) -> bool:
        """True while soft shadows, bounced light or a refined picture are computed in the background."""
        is_refining = any(each.is_awaited for each in self.refining.values())
        return self.gathering.part is not None or self.softening.is_awaited or is_refining

    def add(self, mesh: LitMesh, refine: float | None = None) -> None:
        """Add a mesh. Its colours are updated before each frame, until its actor is removed.

        With a tolerance `refine`, the window shows the mesh refined within this tolerance.
        """
        self._meshes.append(mesh)
        if refine is not None:
            self._refining[mesh] = Refining(mesh, refine)

    def name_of(self, mesh: LitMesh) -> str:
        """Return the name with which the mesh's actor was added; "" if it was added without a name."""
        names = [name for name, actor in self._renderer.actors.items() if actor is mesh.actor]
        return names[0] if names and "(Addr=" not in names[0] else ""

    def light(self, mesh: LitMesh) -> None:
        """Light a mesh that is not drawn yet. The visible meshes cast shadows and bounce light on it.

        Raise ``ValueError`` if the mesh cannot be lit.
        """
        self._refreshing([*self.shown, mesh])(mesh)

    def refresh(self, *, waits: bool = False) -> bool:
        """Update all visible meshes.

        A mesh that cannot be lit is hidden, because its last colours would be wrong. It is drawn again as soon as it
        can be lit.

        Parameters
        ----------
        waits : bool, default False
            True to block until bounced light and refined pictures, if any, are computed.

        Returns
        -------
        bool
            True if a background result has arrived since the last frame.

        Warns
        -----
        LightingWarning
            Once for each mesh that cannot be lit, after all other meshes are updated. Also if a mesh cannot be refined,
            or bounced light cannot be computed.
        """
        shown, unlit = self.shown, dict[LitMesh, str]()
        if shown:
            try:
                refresh = self._refreshing(shown, waits)
            except Exception as error:  # also from a user's light, which affects all meshes
                refresh = partial(_refuse, error)
            for mesh in shown:
                try:
                    refresh(mesh)
                except Exception as error:  # also from a user's light or array
                    mesh.blank()
                    if mesh in self._refining:
                        self._refining[mesh].forget()
                    name = self.name_of(mesh)
                    which = f"The mesh {name!r}" if name else "A mesh"
                    unlit[mesh] = f"{which} cannot be lit and is not drawn: {error}"
        else:
            self.gathering.stop()
            self.softening.stop()
        is_new = self._refine(unlit, waits)
        if self.softening.count > self._softened:
            self._softened, is_new = self.softening.count, True
        if self.gathering.count > self._gathered:
            self._gathered, is_new = self.gathering.count, True
            if self.gathering.reason:
                text = f"Bounced light could not be computed: {self.gathering.reason}"
                warnings.warn(text, LightingWarning, stacklevel=2)
        self._ask_again()
        before, self._unlit = self._unlit, unlit
        if unlit != before:
            lines = [line for text in unlit.values() for line in textwrap.wrap(text, _MESSAGE_WIDTH)]
            self._message.SetInput("\n".join(lines))
            (self._renderer.AddViewProp if lines else self._renderer.RemoveViewProp)(self._message)
            for mesh, text in unlit.items():
                if before.get(mesh) != text:
                    warnings.warn(text, LightingWarning, stacklevel=2)
        return is_new

    def _refine(self, unlit: Container[LitMesh], waits: bool) -> bool:
        """Show the refined pictures of all meshes except the meshes in `unlit`.

        Return True if a picture is shown for the first time.

        With `waits`, block until the pictures are made.
        """
        refined = {mesh: each for mesh, each in self.refining.items() if mesh not in unlit}
        if not refined:
            return False
        scene, is_new = self._scene(), False
        held = self.uses_preview_rays or self.is_mixed or self.gathering.part is not None
        held |= self.softening.is_awaited  # refine only final colours
        for mesh, refining in refined.items():
            before = refining.pictures
            refining.update(scene, self.occluders_of(mesh, scene), self.display, held=held, waits=waits)
            if refining.pictures > before:
                is_new = True
                if refining.reason:
                    warnings.warn(f"A mesh could not be refined: {refining.reason}", LightingWarning, stacklevel=2)
        return is_new

    def _ask_again(self) -> None:
        """Start a timer that polls for background results while some are awaited; otherwise stop the timer."""
        window = self._renderer.GetRenderWindow()
        interactor = None if window is None else window.GetInteractor()
        if not self.is_awaiting or self.is_in_a_page:
            self._end_timer()
        elif self._timer is None and interactor is not None and interactor.GetInitialized():
            actors = weakref.ref(self)

            def passed(_interactor: Any, _event: str) -> None:
                if (alive := actors()) is not None and alive._timer is not None and alive.refresh():
                    alive._renderer.GetRenderWindow().Render()

            tag = interactor.AddObserver("TimerEvent", passed)
            self._timer = interactor, tag, interactor.CreateRepeatingTimer(_ASK_AGAIN)

    def _end_timer(self) -> None:
        if self._timer is not None:
            interactor, tag, timer = self._timer
            interactor.RemoveObserver(tag)
            interactor.DestroyTimer(timer)
            self._timer = None

    def _refreshing(self, meshes: Sequence[LitMesh], waits: bool = False) -> Callable[[LitMesh], bool]:
        """Return a function that updates the colours of one of the `meshes`, with shadows from all of them.

        The function takes a mesh, and returns True if its colours had to be recomputed. Before this method returns,
        bounced light between the meshes is computed. With `waits`, this method blocks until the bounced light is known.
        """
        scene, self.note = self._scene(), ""
        model, samples = scene.light_model, None
        if model.needs_rays:
            for mesh in meshes:
                mesh.ray_tolerance = _ray_tolerance(self.display)
            self._gather_occluders(meshes)
            is_final = waits or bool(model.bounces) or not (self.is_in_a_page or self._is_on_screen)
            how = {"held": self.uses_preview_rays, "waits": is_final}
            samples = self.softening.samples(meshes, scene, self.occluders_of, **how)
            self.note = self.softening.note
        else:
            self.softening.stop()
        bounced: dict[LitMesh, FloatArray] | None = {}
        if model.bounces:

            def planned(mesh: LitMesh) -> tuple[Plan, Vertices]:
                return mesh.planned(scene, self.occluders_of(mesh, scene), samples)

            held, waits = self.uses_preview_rays, waits or not (self.is_in_a_page or self._is_on_screen)
            bounced = self.gathering.light(meshes, planned, scene, samples, held=held, waits=waits)
            self.note = self.gathering.note or self.note
        else:
            self.gathering.stop()
        lit = scene if bounced is not None else replace(scene, light_model=replace(model, bounces=0))

        def refresh(mesh: LitMesh) -> bool:
            light = None if bounced is None else bounced.get(mesh)
            how: dict[str, Any] = {"samples": samples, "bounced": light, "display": self.display}
            return mesh.refresh(lit, self.occluders_of(mesh, scene), **how)

        return refresh

    @property
    def _is_on_screen(self) -> bool:
        """True if the window is on the screen. A later frame can then show the final light.

        Offscreen, the first frame may be the only one, so it must show the final light.
        """
        window = self._renderer.GetRenderWindow()
        return window is not None and not window.GetOffScreenRendering()

    def occluders_of(self, mesh: LitMesh, scene: Scene) -> KnownOccluders | None:
        """Return the meshes that can cast shadows on `mesh`, including `mesh`; None if the scene needs no rays."""
        own = list(self._blocking).index(mesh) if mesh in self._blocking else None
        return KnownOccluders(self._occluders, own) if scene.light_model.needs_rays else None

    def _gather_occluders(self, meshes: Sequence[LitMesh]) -> None:
        """Update the triangles that block light, to the current geometry of those `meshes` that cast shadows."""
        blocking = dict[LitMesh, tuple[Any, BlockingFaces]]()
        for mesh in meshes:
            if mesh.casts_shadows:
                try:
                    geometry = mesh.geometry()
                except ValueError:  # the mesh cannot be lit; `refresh` reports it
                    continue
                known = self._blocking.get(mesh)
                if known is None or known[0] != geometry:
                    known = geometry, world_faces(mesh.drawn, mesh.matrix)
                blocking[mesh] = known
        is_same = list(blocking) == list(self._blocking)
        if not is_same or any(self._blocking[mesh] is not faces for mesh, faces in blocking.items()):
            self._occluders, self._blocking = Occluders([faces for _, faces in blocking.values()]), blocking

    # -- materials and their undo

    @property
    def state(self) -> MaterialsState:
        """Current materials of the visible meshes, for `revert`.

        The keys are the meshes' `SharedMaterial` objects, and the values are the materials that these hold now.
        """
        return {mesh.shared_material: mesh.material for mesh in self.shown}

    def revert(self, now: MaterialsState, then: MaterialsState) -> None:
        """Restore the materials of the state `then` that differ in the state `now`, and keep all other changes.

        Both arguments are values of the property `state`.
        """
        for shared, material in now.items():
            if then.get(shared, material) != material:
                shared.material = then[shared]

    # -- refined pictures and release

    def refine(self, tolerance: float | None) -> None:
        """Show all meshes refined within a tolerance. If the tolerance is None, show them with their own vertices."""
        self.show_own_vertices()
        self._refining = {} if tolerance is None else {mesh: Refining(mesh, tolerance) for mesh in self.meshes}

    def show_own_vertices(self) -> None:
        """Cancel refining, and show the meshes with their own vertices until the next frame."""
        for refining in self._refining.values():
            refining.forget()
        for mesh in self.meshes:
            if mesh.actor is not None and mesh.actor.mapper.dataset is not mesh.drawn:
                mesh.actor.mapper.dataset = mesh.drawn

    def stop(self) -> None:
        """Cancel background computations; the next frame starts them again."""
        self.gathering.stop()
        self.softening.stop()
        self.show_own_vertices()

    def release(self) -> None:
        """Remove the observer and the timer, cancel background computations, and forget the meshes."""
        self._renderer.RemoveObserver(self._tag)
        self._end_timer()
        self.stop()
        self._meshes.clear()


def _ray_tolerance(display: Display) -> float:
    """Return the standard error of colours that is at most one step of a screen, after an exposure below 0.

    Lights in W/m² need an exposure of about -10; rays for colours from 0 to 1 would be far too many for them. Two stops
    are one step, so that few changes of the exposure cast rays again.
    """
    return 4.0 ** math.floor(max(-display.exposure, 0.0) / 2.0) / 255.0
