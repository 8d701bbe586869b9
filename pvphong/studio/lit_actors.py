"""Lit actors: the lit meshes of one renderer, whose colours are kept current.

Before each frame all that are visible are brought up to date, with shadows on each other; those that cannot be lit are
not drawn, and the window says why.
"""

from __future__ import annotations

import textwrap
import warnings
import weakref
from collections.abc import Callable, Container, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkTextActor

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


class LightingWarning(UserWarning):
    """A mesh in a window cannot be lit as it is; it is not drawn until that is mended."""


_PREVIEW_SAMPLES = 16  # rays of each vertex to a light with a size while something is dragged
_BEFORE_GIZMOS = 1.0  # a frame's gizmos show where highlights are
_MESSAGE_WIDTH, _MESSAGE_PLACE = 60, (10.0, 10.0)  # letters of a line; pixels from the lower left

_ASK_AGAIN = 100  # milliseconds until results from the background are asked for again


def _refuse(error: Exception, _mesh: LitMesh) -> bool:
    """Say of every mesh that it cannot be lit."""
    raise error


MaterialsState = dict[SharedMaterial, Material]


class LitActors:
    """The lit meshes of one renderer, brought up to date before each frame.

    Parameters
    ----------
    renderer : pyvista.Renderer
        Where they are drawn.
    scene : callable
        Gives what lights them now.
    """

    def __init__(self, renderer: pv.Renderer, scene: Callable[[], Scene]) -> None:
        self.uses_preview_rays = False
        """Whether shadows of lights with a size are made of few rays: so while something is dragged."""
        self.note = ""
        """What is to be said of colours that are not final."""
        self.is_in_a_page = False
        """Whether a web page asks for results from the background, by `refresh` while `is_awaiting`."""
        self.is_mixed = False
        """Whether faders write the colours: so there are no refined pictures of them."""
        self.gathering = Gathering()
        self._gathered = 0  # how often light has come from there that frames show
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
        """The lit meshes whose actors are still there."""
        self._meshes = [mesh for mesh in self._meshes if self._renderer.HasViewProp(mesh.actor)]
        for mesh in [mesh for mesh in self._refining if mesh not in self._meshes]:
            self._refining.pop(mesh).forget()
        return tuple(self._meshes)

    @property
    def shown(self) -> list[LitMesh]:
        """The lit meshes that are visible."""
        return [mesh for mesh in self.meshes if mesh.actor is not None and mesh.actor.GetVisibility()]

    def others(self, mesh: LitMesh) -> list[tuple[pv.PolyData, Float64Array | None]]:
        """The visible meshes that cast shadows on one, each with its matrix, as `occluders` takes them."""
        return [(each.drawn, each.matrix) for each in self.shown if each is not mesh and each.casts_shadows]

    @property
    def refining(self) -> dict[LitMesh, Refining]:
        """What shows refined pictures of the visible meshes of which there are to be any."""
        return {mesh: self._refining[mesh] for mesh in self.shown if mesh in self._refining}

    @property
    def is_awaiting(self) -> bool:
        """Whether something of what is to be shown is still computed in the background."""
        return self.gathering.part is not None or any(each.is_awaited for each in self.refining.values())

    def add(self, mesh: LitMesh, refine: float | None = None) -> None:
        """Keep a mesh current from now on, until its actor is removed; within a tolerance: and show it refined."""
        self._meshes.append(mesh)
        if refine is not None:
            self._refining[mesh] = Refining(mesh, refine)

    def name_of(self, mesh: LitMesh) -> str:
        """The name that a mesh was drawn by; "" if it was drawn without one."""
        names = [name for name, actor in self._renderer.actors.items() if actor is mesh.actor]
        return names[0] if names and "(Addr=" not in names[0] else ""

    def light(self, mesh: LitMesh) -> None:
        """Light a mesh that is not drawn yet among those that are; ValueError if it cannot be lit."""
        self._refreshing([*self.shown, mesh])(mesh)

    def refresh(self, *, waits: bool = False) -> bool:
        """Bring all visible meshes up to date.

        One that cannot be lit is not drawn, for its last colours would not be true, until it can be lit again.

        Parameters
        ----------
        waits : bool, default False
            Whether to come back with light that bounces and with refined pictures, where there are to be any, and not
            before.

        Returns
        -------
        bool
            Whether the background has given something new, which a frame that is drawn already does not show.

        Warns
        -----
        LightingWarning
            Of each that cannot be lit, once, when all others are up to date.
        """
        shown, unlit = self.shown, dict[LitMesh, str]()
        if shown:
            try:
                refresh = self._refreshing(shown, waits)
            except Exception as error:  # of a light of the user's, which lights all of them
                refresh = partial(_refuse, error)
            for mesh in shown:
                try:
                    refresh(mesh)
                except Exception as error:  # of a light or an array of the user's, too
                    mesh.blank()
                    if mesh in self._refining:
                        self._refining[mesh].forget()
                    name = self.name_of(mesh)
                    which = f"The mesh {name!r}" if name else "A mesh"
                    unlit[mesh] = f"{which} is not lit: {error}"
        else:
            self.gathering.stop()
        is_new = self._refine(unlit, waits)
        if self.gathering.count > self._gathered:
            self._gathered, is_new = self.gathering.count, True
            if self.gathering.reason:
                text = f"Light that bounces is not gathered: {self.gathering.reason}"
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
        """Show the refined pictures that there are, but of what cannot be lit; whether one is new."""
        refined = {mesh: each for mesh, each in self.refining.items() if mesh not in unlit}
        if not refined:
            return False
        scene, is_new = self._scene(), False
        held = self.uses_preview_rays or self.is_mixed or self.gathering.part is not None  # refined is what is final
        for mesh, refining in refined.items():
            before = refining.pictures
            refining.update(scene, self.occluders_of(mesh, scene), held=held, waits=waits)
            if refining.pictures > before:
                is_new = True
                if refining.reason:
                    warnings.warn(f"A mesh is not refined: {refining.reason}", LightingWarning, stacklevel=2)
        return is_new

    def _ask_again(self) -> None:
        """Have the window ask for results from the background soon, if there are to be any."""
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
        """What brings one of some meshes up to date, which shadow each other where the light model has shadows."""
        scene, self.note = self._scene(), ""
        model, samples = scene.light_model, None
        if model.needs_rays:
            if self.uses_preview_rays and any(light.has_size for light in scene.lights):
                samples, self.note = _PREVIEW_SAMPLES, f"shadows by {_PREVIEW_SAMPLES} rays until let go"
            self._gather_occluders(meshes)
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
            return mesh.refresh(lit, self.occluders_of(mesh, scene), samples=samples, bounced=light)

        return refresh

    @property
    def _is_on_screen(self) -> bool:
        """Whether frames will come by themselves; who draws one off screen looks at that one."""
        window = self._renderer.GetRenderWindow()
        return window is not None and not window.GetOffScreenRendering()

    def occluders_of(self, mesh: LitMesh, scene: Scene) -> KnownOccluders | None:
        """What casts shadows on a mesh; None in a scene without shadows and occlusion."""
        own = list(self._blocking).index(mesh) if mesh in self._blocking else None
        return KnownOccluders(self._occluders, own) if scene.light_model.needs_rays else None

    def _gather_occluders(self, meshes: Sequence[LitMesh]) -> None:
        """Know all of some meshes that cast shadows, where they are now."""
        blocking = dict[LitMesh, tuple[Any, BlockingFaces]]()
        for mesh in meshes:
            if mesh.casts_shadows:
                try:
                    geometry = mesh.geometry()
                except ValueError:  # it cannot be lit either, and that is said where it is to be
                    continue
                known = self._blocking.get(mesh)
                if known is None or known[0] != geometry:
                    known = geometry, world_faces(mesh.drawn, mesh.matrix)
                blocking[mesh] = known
        is_same = list(blocking) == list(self._blocking)
        if not is_same or any(self._blocking[mesh] is not faces for mesh, faces in blocking.items()):
            self._occluders, self._blocking = Occluders([faces for _, faces in blocking.values()]), blocking

    # -- materials, whose edits can be undone

    @property
    def state(self) -> MaterialsState:
        """The materials of the visible meshes and what they are, for `revert`."""
        return {mesh.shared_material: mesh.material for mesh in self.shown}

    def revert(self, now: MaterialsState, then: MaterialsState) -> None:
        """Undo what changed in materials from `then` to `now`; what else has changed since is left as it is."""
        for shared, material in now.items():
            if then.get(shared, material) != material:
                shared.material = then[shared]

    # -- refined pictures, and the end

    def refine(self, tolerance: float | None) -> None:
        """Show all meshes refined within a tolerance from now on, as `Refining` does; None: at their own vertices."""
        self.show_own_vertices()
        self._refining = {} if tolerance is None else {mesh: Refining(mesh, tolerance) for mesh in self.meshes}

    def show_own_vertices(self) -> None:
        """Show no refined picture before the next frame, and end what makes one."""
        for refining in self._refining.values():
            refining.forget()

    def stop(self) -> None:
        """End what is computed in the background; the next frame begins it again."""
        self.gathering.stop()
        self.show_own_vertices()

    def release(self) -> None:
        """Let go of the renderer."""
        self._renderer.RemoveObserver(self._tag)
        self._end_timer()
        self.stop()
        self._meshes.clear()
