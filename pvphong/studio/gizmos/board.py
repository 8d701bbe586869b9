"""All gizmos of one subplot: brings them up to date, and turns events into new lights."""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array, Vector
from pvphong.studio.gizmos import commands
from pvphong.studio.gizmos.drag_start import vector
from pvphong.studio.gizmos.drawing import Drawing
from pvphong.studio.gizmos.gizmo import Gizmo
from pvphong.studio.gizmos.grip import Grip
from pvphong.studio.gizmos.highlight import SurfacePoint
from pvphong.studio.gizmos.history import History
from pvphong.studio.gizmos.interaction import Interaction
from pvphong.studio.gizmos.options import Options
from pvphong.studio.gizmos.overlay import Overlay
from pvphong.studio.gizmos.status import HINT, described, soloed
from pvphong.studio.gizmos.surfaces import Surfaces, find_highlight
from pvphong.studio.gizmos.view import View
from pvphong.studio.live import LiveMesh
from pvphong.studio.materials import Materials
from pvphong.studio.rig import LightHandle, Rig

_BEFORE_WIDGETS = 1.0  # theirs is 0.5


class Board:
    """The gizmos of one renderer.

    Parameters
    ----------
    renderer, interactor
        VTK's.
    draw : callable
        Draws a frame, wherever it is seen: `plotter.render`.
    rig : Rig
        The renderer's lights.
    history : History
        Where finished drags and edits go.
    meshes : callable
        Gives the renderer's lit meshes.
    only : sequence of LightHandle, optional
        The lights that get a gizmo; all, also those added later, if not given.
    options : Options
        How they behave.
    """

    def __init__(
        self,
        renderer: Any,
        interactor: Any,
        draw: Callable[[], None],
        rig: Rig,
        history: History,
        meshes: Callable[[], Sequence[LiveMesh]],
        only: Sequence[LightHandle] | None,
        options: Options,
    ) -> None:
        self.rig, self.history, self.options = rig, history, options
        self.hidden, self.helping, self.notice = False, False, ""
        self.materials = Materials(meshes)
        self._renderer, self._interactor, self._meshes = renderer, interactor, meshes
        self._only = None if only is None else list(only)
        self.render = draw
        self._overlay = Overlay()
        self._gizmos: list[Gizmo] = []
        self._retired: list[Grip] = []
        self.note = ""
        """What else the readout says."""
        self._hovered: tuple[Gizmo, str] | None = None
        self.interaction = Interaction(self, interactor)
        self._tags = [
            self._observe("MouseMoveEvent", Board._resized, _BEFORE_WIDGETS),
            self._observe("MouseMoveEvent", Board._moved_over),
        ]
        self.update()

    def _observe(self, event: str, react: Callable[[Board], None], priority: float = 0.0) -> int:
        board = weakref.ref(self)

        def happened(_interactor: Any, _event: str) -> None:
            if (alive := board()) is not None:
                react(alive)

        return int(self._interactor.AddObserver(event, happened, priority))

    @property
    def is_dragging(self) -> bool:
        """Whether a handle is held."""
        return self.interaction.drag is not None

    # -- what is there -----------------------------------------------------------------------------------

    @property
    def gizmos(self) -> tuple[Gizmo, ...]:
        """A gizmo for each light."""
        self._follow()
        return tuple(self._gizmos)

    @property
    def selected(self) -> Gizmo | None:
        """The gizmo that keys act on: the one grabbed last."""
        return next((gizmo for gizmo in self._gizmos if gizmo.is_selected), None)

    def select(self, chosen: Gizmo | None) -> None:
        """Select a gizmo, or none."""
        for gizmo in self._gizmos:
            gizmo.is_selected = gizmo is chosen

    @property
    def view(self) -> View:
        """The pane as it is now."""
        width, height = self._renderer.GetSize()
        x, y = self._renderer.GetOrigin()
        return View(self.rig.viewer, (max(width, 1), max(height, 1)), (x, y))

    @property
    def extent(self) -> tuple[Vector, float]:
        """Middle and half the diagonal of what is drawn; of nothing: what the camera looks at."""
        bounds = np.array(self._renderer.ComputeVisiblePropBounds()).reshape(3, 2)
        size = 0.5 * float(np.linalg.norm(bounds[:, 1] - bounds[:, 0]))
        if (bounds[:, 0] > bounds[:, 1]).any() or not 0.0 < size < np.inf:
            return vector(self.rig.viewer.focal_point), 0.5 * self.rig.viewer.distance
        return vector(bounds.mean(axis=1)), size

    @property
    def surfaces(self) -> Surfaces:
        """The lit meshes as they are now, to be asked what is under a cursor."""
        return Surfaces(self._renderer, self.view, self._meshes())

    def follow(self, handle: LightHandle) -> None:
        """Give a light that was just added a gizmo, and select it."""
        if self._only is not None:
            self._only.append(handle)
        self.select(next(gizmo for gizmo in self.gizmos if gizmo.handle is handle))

    def new_grip(self, name: str, gizmo: Gizmo) -> Grip:
        """A handle that can be grabbed."""
        return Grip(name, self._renderer, self._interactor, gizmo)

    def highlight_of(self, gizmo: Gizmo) -> Vector | None:
        """Where the gizmo's light has its highlight."""
        found = self.held_highlight(gizmo, self.view)
        return None if found is None else found.point

    def held_highlight(self, gizmo: Gizmo, view: View) -> SurfacePoint | None:
        """Where a gizmo's light has its highlight, for an eye."""
        light = gizmo.light_for(view.viewer)
        if light.frame == "headlight":
            return None
        return find_highlight(light.in_world(view.viewer), view, self._meshes())

    # -- following ---------------------------------------------------------------------------------------

    def _follow(self) -> None:
        """A gizmo for each light that is there, none for those that are gone."""
        present = [handle for handle in self.rig.handles if self._only is None or handle in self._only]
        for gizmo in self._gizmos:
            if gizmo.handle not in present:
                self._retired += gizmo.retire()
        known = {gizmo.handle: gizmo for gizmo in self._gizmos}
        self._gizmos = [known.get(handle) or Gizmo(handle, self) for handle in present]

    def update(self) -> None:
        """Bring widgets and looks to where lights, camera and scene are now."""
        self._follow()
        view = self.view
        self._size = view.size
        drawing = Drawing(view)
        shown = {} if self.hidden else {gizmo: self._ring(gizmo) for gizmo in self._gizmos}
        self._place_grips(view, shown)
        self._hovered = self._under_cursor()
        active = self.interaction.active or self._hovered
        single = soloed(self.rig.handles, view.viewer)
        for gizmo, highlight in shown.items():
            handle = active[1] if active and active[0] is gizmo else None
            gizmo.draw(drawing, highlight, handle, is_alone=gizmo.handle is single)
        self._overlay.put(drawing)
        self._overlay.label(drawing.labels, view.origin)
        has_room = self._overlay.help(commands.help_text(self.options.keys) if self.helping else "", view.size)
        self._overlay.status(self._status(single) if has_room else "", view.size)
        x, y = self.cursor
        said = "\n".join(line for line in (self.interaction.readout, self.interaction.readout and self.note) if line)
        self._overlay.say(said, (x - view.origin[0], y - view.origin[1]), view.size)
        self._overlay.attach(self._renderer)

    def _ring(self, gizmo: Gizmo) -> Vector | None:
        """Where its highlight is; while that is dragged, where it was dragged to, which need not be at a vertex."""
        return self.interaction.dragged_highlight(gizmo) or gizmo.highlight

    def _status(self, single: LightHandle | None) -> str:
        """The last that was done, and the light that keys act on."""
        chosen = self.selected
        if chosen is not None:
            now = described(chosen.light, is_alone=chosen.handle is single)
        else:
            now = "" if self.helping else HINT
        return "\n".join(line for line in (self.notice, now) if line)

    def _place_grips(self, view: View, shown: dict[Gizmo, Vector | None]) -> None:
        """Of two close together each is grabbed on its own half of the way."""
        grips: list[tuple[Grip, Float64Array]] = []
        for gizmo in self._gizmos:
            grips += gizmo.set_grips(view, shown.get(gizmo), gizmo in shown)
        for grip, pixel in grips:
            others = [math.dist(pixel, other) for neighbour, other in grips if neighbour is not grip]
            grip.limit(0.5 * min(others, default=math.inf))
            grip.look(self._interactor.GetEventPosition())

    def _under_cursor(self) -> tuple[Gizmo, str] | None:
        over = [(gizmo, gizmo.hovered) for gizmo in self._gizmos] if self.is_here else []
        return next(((gizmo, name) for gizmo, name in over if name is not None), None)

    # -- events ------------------------------------------------------------------------------------------

    @property
    def cursor(self) -> tuple[float, float]:
        """Where the pointer is, in pixels of the window."""
        x, y = self._interactor.GetEventPosition()
        return float(x), float(y)

    @property
    def is_here(self) -> bool:
        """Whether the pointer is in the pane."""
        return bool(self._renderer.IsInViewport(*self._interactor.GetEventPosition()))

    def release_retired(self) -> None:
        """A light can go while its handle is dragged: its widget must outlive the event that it is dealing with."""
        for grip in self._retired:
            grip.release()
        self._retired.clear()

    def _resized(self) -> None:
        """A browser's window is resized without a frame: while the button is down, trame may draw fewer pixels."""
        if self.view.size != self._size:
            self.update()

    def _moved_over(self) -> None:
        self.release_retired()
        if self._under_cursor() != self._hovered:
            self.render()

    def grabbed(self, gizmo: Gizmo, grip: Grip) -> None:
        """A handle was grabbed."""
        self.interaction.grabbed(gizmo, grip.name)

    def dragged(self) -> None:
        """The cursor moved with the button down."""
        self.interaction.dragged()

    def dropped(self) -> None:
        """The button was let go."""
        self.interaction.dropped()

    @contextmanager
    def out_of_sight(self) -> Iterator[None]:
        """Without gizmos, unless they are to be in screenshots."""
        if self.options.in_screenshots:
            yield
            return
        self._overlay.show(False)
        try:
            yield
        finally:
            self._overlay.show(True)
            self.update()

    def release(self) -> None:
        """Let go of widgets, observers and actors."""
        for tag in self._tags:
            self._interactor.RemoveObserver(tag)
        self.interaction.release()
        for gizmo in self._gizmos:
            self._retired += gizmo.retire()
        self._gizmos.clear()
        self.release_retired()
        self._overlay.detach(self._renderer)
