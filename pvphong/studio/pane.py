"""One subplot: its lights, its lit meshes, its gizmos, and the one observer that keeps them current."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Sequence
from typing import Any

import pyvista as pv

from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.studio.gizmos import Board, History, Options
from pvphong.studio.live import LiveMesh
from pvphong.studio.rig import LightHandle, Rig
from pvphong.studio.shadows import Casting
from pvphong.studio.troubles import Troubles

# Rays of each vertex to a light with a size while something is dragged.
_WHILE_DRAGGING = 16


class Pane:
    """Everything that pvphong keeps about one renderer.

    Parameters
    ----------
    renderer : pyvista.Renderer
        Held on to until `release`.
    light_model : callable
        Gives the light model that is in force.
    """

    def __init__(self, renderer: pv.Renderer, light_model: Callable[[], LightModel]) -> None:
        self.renderer = renderer
        self.rig = Rig(renderer)
        self.board: Board | None = None
        self.evaluations = 0
        self._light_model = light_model
        self._meshes: list[LiveMesh] = []
        self._casting = Casting()
        self._tag: int | None = None
        self._troubles = Troubles(renderer)

    @property
    def scene(self) -> Scene:
        """A snapshot of what lights this subplot."""
        return Scene(lights=self.rig.lights, viewer=self.rig.viewer, light_model=self._light_model())

    @property
    def meshes(self) -> tuple[LiveMesh, ...]:
        """The lit meshes whose actors are still there."""
        self._meshes = [live for live in self._meshes if self.renderer.HasViewProp(live.actor)]
        return tuple(self._meshes)

    def add(self, live: LiveMesh) -> None:
        """Keep a mesh current from now on, until its actor is removed."""
        self._meshes.append(live)
        self.watch()

    def evaluate(self, live: LiveMesh) -> None:
        """Bring one mesh, which may not be drawn yet, up to date, and count it."""
        self.evaluations += self._refreshing([*self.shown, live])(live)

    def watch(self) -> None:
        """Bring everything up to date before each frame."""
        if self._tag is not None:
            return
        pane = weakref.ref(self)

        def before_frame(_renderer: Any, _event: str) -> None:
            if (alive := pane()) is not None:
                alive.refresh()

        self._tag = self.renderer.AddObserver("StartEvent", before_frame)

    def refresh(self) -> None:
        """Bring the visible meshes and the gizmos up to date."""
        visible = self.shown
        if visible:
            self.evaluations += self._troubles.refresh(visible, self._refreshing(visible))
        if self.board is not None:
            self.board.update()

    def _refreshing(self, visible: Sequence[LiveMesh]) -> Callable[[LiveMesh], bool]:
        """What brings one of the visible meshes up to date.

        During a drag lights with a size get few rays, and as many as they take when it has ended.
        """
        scene = self.scene
        if not scene.light_model.needs_rays:
            return lambda live: live.refresh(scene)
        is_rough = self.board is not None and self.board.is_dragging and any(light.has_size for light in scene.lights)
        if self.board is not None:
            self.board.note = f"shadows by {_WHILE_DRAGGING} rays until let go" if is_rough else ""
        samples = _WHILE_DRAGGING if is_rough else None
        among = dict(zip(visible, self._casting.among(visible), strict=True))
        return lambda live: live.refresh(scene, among[live], samples=samples)

    def put_up(
        self,
        interactor: Any,
        draw: Callable[[], None],
        history: History,
        only: Sequence[LightHandle] | None,
        options: Options,
    ) -> None:
        """Put gizmos up."""
        self.board = Board(self.renderer, interactor, draw, self.rig, history, lambda: self.shown, only, options)
        self.watch()

    @property
    def shown(self) -> list[LiveMesh]:
        """The lit meshes that are visible."""
        return [live for live in self.meshes if live.actor is not None and live.actor.GetVisibility()]

    def take_down(self) -> bool:
        """Take the gizmos down; False if there are none."""
        if self.board is None:
            return False
        self.board.release()
        self.board = None
        return True

    def release(self) -> None:
        """Let go of everything."""
        self.take_down()
        if self._tag is not None:
            self.renderer.RemoveObserver(self._tag)
            self._tag = None
        self._meshes.clear()
