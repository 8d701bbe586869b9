"""All gizmos of one subplot: brings them up to date, and turns events into new lights."""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array, Vector
from pvphong.studio.gizmos import commands
from pvphong.studio.gizmos.drag_start import Cursor, DragStart, vector
from pvphong.studio.gizmos.dragging import Drag
from pvphong.studio.gizmos.drawing import Drawing
from pvphong.studio.gizmos.gizmo import HIGHLIGHT, Gizmo
from pvphong.studio.gizmos.grip import Grip
from pvphong.studio.gizmos.highlight import SurfacePoint
from pvphong.studio.gizmos.history import History
from pvphong.studio.gizmos.overlay import Overlay
from pvphong.studio.gizmos.surfaces import Surfaces, find_highlight
from pvphong.studio.gizmos.view import View
from pvphong.studio.live import LiveMesh
from pvphong.studio.rig import LightHandle, Rig

_BEFORE_WIDGETS = 1.0  # theirs is 0.5


@dataclass(frozen=True)
class Options:
    """How gizmos behave; see `plotter.phong.add_gizmos`."""

    in_screenshots: bool = False
    angle_step: float = 5.0
    length_step: float | None = None
    keys: commands.Keys = field(default_factory=dict)


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
        Where finished drags go.
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
        self.hidden, self.helping = False, False
        self._renderer, self._interactor, self._meshes, self._only = renderer, interactor, meshes, only
        self.render = draw
        self._overlay = Overlay()
        self._gizmos: list[Gizmo] = []
        self._retired: list[Grip] = []
        self._drag: Drag | None = None
        self._readout = ""
        self.note = ""
        """What else the readout says."""
        self._hovered: tuple[Gizmo, str] | None = None
        self._presses = commands.Presses()
        self._tags = [
            self._observe("MouseMoveEvent", Board._resized, _BEFORE_WIDGETS),
            self._observe("MouseMoveEvent", Board._moved_over),
            self._observe("KeyPressEvent", Board._key_pressed),
            self._observe("CharEvent", Board._key_ended),
            self._observe("KeyReleaseEvent", Board._key_ended),
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
        return self._drag is not None

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

    def new_grip(self, name: str, gizmo: Gizmo) -> Grip:
        """A handle that can be grabbed."""
        return Grip(name, self._renderer, self._interactor, gizmo)

    def highlight_of(self, gizmo: Gizmo) -> Vector | None:
        """Where the gizmo's light has its highlight."""
        found = self._highlight(gizmo, self.view)
        return None if found is None else found.point

    def _highlight(self, gizmo: Gizmo, view: View) -> SurfacePoint | None:
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
        shown = {} if self.hidden else {gizmo: gizmo.highlight for gizmo in self._gizmos}
        self._place_grips(view, shown)
        self._hovered = self._under_cursor()
        active = self._active()
        for gizmo, highlight in shown.items():
            gizmo.draw(drawing, highlight, active[1] if active and active[0] is gizmo else None)
        self._overlay.attach(self._renderer)
        self._overlay.put(drawing)
        self._overlay.help(commands.help_text(self.options.keys) if self.helping else "", (12.0, view.size[1] - 12.0))
        x, y = self._cursor()
        said = "\n".join([self._readout, self.note]) if self._readout and self.note else self._readout
        self._overlay.say(said, (x - view.origin[0], y - view.origin[1]), view.size)

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
        over = [(gizmo, gizmo.hovered) for gizmo in self._gizmos] if self._is_here() else []
        return next(((gizmo, name) for gizmo, name in over if name is not None), None)

    def _active(self) -> tuple[Gizmo, str] | None:
        if self._drag is not None:
            return self._drag.gizmo, self._drag.start.handle
        return self._hovered

    # -- events ------------------------------------------------------------------------------------------

    def _cursor(self) -> tuple[float, float]:
        x, y = self._interactor.GetEventPosition()
        return float(x), float(y)

    def _is_here(self) -> bool:
        return bool(self._renderer.IsInViewport(*self._interactor.GetEventPosition()))

    def _release_retired(self) -> None:
        """A light can go while its handle is dragged: its widget must outlive the event that it is dealing with."""
        for grip in self._retired:
            grip.release()
        self._retired.clear()

    def _resized(self) -> None:
        """A browser's window is resized without a frame: while the button is down, trame may draw fewer pixels."""
        if self.view.size != self._size:
            self.update()

    def _moved_over(self) -> None:
        self._release_retired()
        if self._under_cursor() != self._hovered:
            self.render()

    def _key_pressed(self) -> None:
        self._release_retired()
        key, control = self._interactor.GetKeySym(), self._interactor.GetControlKey()
        if not self._presses.begin(key):
            return
        if self._drag is not None:
            if key == "Escape":
                self.cancel()
        elif self._is_here() and commands.run(self, key, self.options.keys, control=bool(control)):
            self.render()

    def _key_ended(self) -> None:
        self._presses.end()

    def grabbed(self, gizmo: Gizmo, grip: Grip) -> None:
        """A handle was grabbed: freeze everything that the drag depends on."""
        view = self.view
        self.select(gizmo)
        held = self._highlight(gizmo, view)
        point = gizmo.points(view, None if held is None else held.point).get(grip.name)
        if point is None:
            return
        light, steps = gizmo.light_for(view.viewer), (self.options.angle_step, self.options.length_step)
        world, scenery = light.in_world(view.viewer), gizmo.scenery(view)
        start = DragStart(world, grip.name, vector(point), self._cursor(), view, scenery, *steps)
        surfaces = Surfaces(self._renderer, view, self._meshes()) if grip.name == HIGHLIGHT else None
        self._drag = Drag(gizmo, start, self.rig, self.rig.state, light, held, surfaces)

    def dragged(self) -> None:
        """The cursor moved with the button down: the light becomes what the cursor asks for."""
        drag = self._drag
        if drag is None or not drag.is_possible:
            self._drag, self._readout = None, ""
            return
        at = Cursor(self._cursor(), bool(self._interactor.GetShiftKey()), bool(self._interactor.GetControlKey()))
        self._readout = drag.move(at)

    def dropped(self) -> None:
        """The button was let go: the drag becomes one step."""
        if self._drag is not None and self._drag.is_possible:
            self.history.record(self.rig, self._drag.before)
        self._drag, self._readout = None, ""
        self.render()

    def cancel(self) -> None:
        """Put back what a running drag has changed."""
        if self._drag is not None:
            self._drag.put_back()
        self._drag, self._readout = None, ""
        self.render()

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
        self._drag = None
        for gizmo in self._gizmos:
            self._retired += gizmo.retire()
        self._gizmos.clear()
        self._release_retired()
        self._overlay.detach(self._renderer)
