"""What mouse and keyboard do to the gizmos of one board: drags, typed values, keys."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any

from pvphong.base.types import Vector
from pvphong.studio.gizmos import commands, entry
from pvphong.studio.gizmos.drag_start import Cursor, DragStart, vector
from pvphong.studio.gizmos.dragging import Drag
from pvphong.studio.gizmos.entry import Entry
from pvphong.studio.gizmos.gizmo import HIGHLIGHT, Gizmo
from pvphong.studio.gizmos.surroundings import Surroundings
from pvphong.studio.gizmos.typed import INTENSITY

_BEFORE_ALL, _BEFORE_WIDGETS = 2.0, 1.0  # theirs is 0.5, PyVista's and the interactor style's 0


class Interaction:
    """Turns events into drags, typed values and commands.

    Parameters
    ----------
    board : Surroundings
        Held weakly.
    interactor
        VTK's.
    """

    def __init__(self, board: Surroundings, interactor: Any) -> None:
        self._owner, self._interactor = weakref.ref(board), interactor
        self.drag: Drag | None = None
        self.entry: Entry | None = None
        self.grabbed_last = ""
        self._presses = commands.Presses()
        self._numbers = ""
        self._tags = [
            self._observe("KeyPressEvent", Interaction._typed, _BEFORE_ALL),
            self._observe("CharEvent", Interaction._typed_character, _BEFORE_ALL),
            self._observe("KeyPressEvent", Interaction._key_pressed),
            self._observe("CharEvent", Interaction._key_ended),
            self._observe("KeyReleaseEvent", Interaction._key_ended),
        ]

    def _observe(self, event: str, react: Callable[[Interaction], bool | None], priority: float = 0.0) -> int:
        """React to an event; nobody else hears of it where the answer is True."""
        interaction = weakref.ref(self)

        def happened(interactor: Any, _event: str) -> None:
            if (alive := interaction()) is not None and react(alive):
                interactor.GetCommand(tag).SetAbortFlag(1)

        tag = int(self._interactor.AddObserver(event, happened, priority))
        return tag

    @property
    def _board(self) -> Surroundings:
        board = self._owner()
        assert board is not None, "the board has gone"
        return board

    @property
    def readout(self) -> str:
        """What is to be said beside the cursor."""
        return self._numbers if self.entry is None else self.entry.readout

    @property
    def active(self) -> tuple[Gizmo, str] | None:
        """The gizmo and the handle that are being changed."""
        if self.drag is not None:
            return self.drag.gizmo, self.drag.start.handle
        return None if self.entry is None else (self.entry.gizmo, self.entry.handle)

    def dragged_highlight(self, gizmo: Gizmo) -> Vector | None:
        """Where a gizmo's highlight has been dragged to, if it is being dragged."""
        if self.drag is None or self.drag.gizmo is not gizmo or self.drag.over is None:
            return None
        return self.drag.over.point

    def release(self) -> None:
        """Let go of the interactor."""
        for tag in self._tags:
            self._interactor.RemoveObserver(tag)
        self.drag = self.entry = None

    # -- drags -------------------------------------------------------------------------------------------

    def grabbed(self, gizmo: Gizmo, handle: str) -> None:
        """A handle was grabbed: freeze everything that the drag depends on."""
        self._end_entry(taken=True)
        board, view = self._board, self._board.view
        board.notice = ""
        board.select(gizmo)
        held = board.held_highlight(gizmo, view)
        point = gizmo.points(view, None if held is None else held.point).get(handle)
        if point is None:
            return
        gizmo.hold(handle, view)
        light, options = gizmo.light_for(view.viewer), board.options
        world, scenery = light.in_world(view.viewer), gizmo.scenery(view)
        steps = options.angle_step, options.length_step
        start = DragStart(world, handle, vector(point), board.cursor, view, scenery, *steps)
        surfaces = board.surfaces if handle == HIGHLIGHT else None
        self.drag = Drag(gizmo, start, board.rig, board.rig.state, light, held, surfaces)
        self.grabbed_last = handle

    def dragged(self) -> None:
        """The cursor moved with the button down: the light becomes what the cursor asks for."""
        drag = self.drag
        if drag is None or not drag.is_possible:
            self.drag, self._numbers = None, ""
            return
        shift, control = self._interactor.GetShiftKey(), self._interactor.GetControlKey()
        self._numbers = drag.move(Cursor(self._board.cursor, bool(shift), bool(control)))

    def dropped(self) -> None:
        """The button was let go: the drag becomes one step."""
        if self.drag is not None and self.drag.is_possible:
            self._board.history.record(self._board.rig, self.drag.before)
        self.drag, self._numbers = None, ""
        self._board.render()

    def cancel(self) -> None:
        """Put back what a running drag has changed."""
        if self.drag is not None:
            self.drag.put_back()
        self.drag, self._numbers = None, ""
        self._board.render()

    # -- typed values ------------------------------------------------------------------------------------

    def type(self) -> None:
        """Begin to type a value for the selected light: for the handle that was grabbed last, if it is its own."""
        gizmo = self._board.selected
        if gizmo is not None:
            names = [*gizmo.handles, INTENSITY]
            self._enter(gizmo, self.grabbed_last if self.grabbed_last in names else names[0])

    def _enter(self, gizmo: Gizmo, handle: str) -> None:
        board, view = self._board, self._board.view
        gizmo.hold(handle, view)
        light, before = gizmo.light_for(view.viewer), board.rig.state
        self.entry = Entry(gizmo, handle, board.rig, before, light, gizmo.scenery(view), view.viewer)
        self.grabbed_last = handle

    def _end_entry(self, *, taken: bool) -> None:
        """What was typed becomes one step, or is put back."""
        ended, self.entry = self.entry, None
        if ended is None or not ended.is_possible:
            return
        if taken:
            self._board.history.record(ended.rig, ended.before)
        else:
            ended.put_back()

    def _type_instead_of_dragging(self) -> None:
        """The first character that is typed during a drag: its value is typed from here on."""
        drag = self.drag
        if drag is None or not drag.is_possible or drag.start.handle == HIGHLIGHT:
            return
        drag.put_back()
        start, view = drag.start, drag.start.view
        self.drag, self._numbers = None, ""
        self.entry = Entry(drag.gizmo, start.handle, drag.rig, drag.before, drag.light, start.scenery, view.viewer)

    def _typed(self) -> bool:
        """A key was pressed; True if it belongs to the value that is being typed."""
        key = self._interactor.GetKeySym()
        if self.drag is not None and entry.character_of(key).strip():
            self._type_instead_of_dragging()
        if self.entry is None:
            return False
        self._board.release_retired()
        if self._presses.begin(key):
            self._edit(self.entry, key)
            self._board.render()
        return True

    def _edit(self, current: Entry, key: str) -> None:
        if not current.is_possible or key == entry.GIVE_UP:
            self._end_entry(taken=False)
        elif key in entry.TAKE | entry.NEXT:
            if current.trouble:  # it stays, and says what is wrong
                return
            self._end_entry(taken=True)
            if key in entry.NEXT:
                names = [*current.gizmo.handles, INTENSITY]
                self._enter(current.gizmo, names[(names.index(current.handle) + 1) % len(names)])
        elif key == entry.ERASE:
            current.put(current.text[:-1])
        elif character := entry.character_of(key):
            current.put(current.text + character)

    def _typed_character(self) -> bool:
        """The character of a key, which VTK and PyVista would act on."""
        if self.entry is None:
            return False
        self._presses.end()
        return True

    # -- keys --------------------------------------------------------------------------------------------

    def _key_pressed(self) -> None:
        board = self._board
        board.release_retired()
        key, control = self._interactor.GetKeySym(), bool(self._interactor.GetControlKey())
        if not self._presses.begin(key):
            return
        if self.drag is not None:
            if key == "Escape":
                self.cancel()
        elif board.is_here:
            self._run(board, key, control=control)

    def _run(self, board: Surroundings, key: str, *, control: bool) -> None:
        if key in entry.TAKE and not control and board.selected is not None:
            self.type()
            board.render()
        elif commands.run(board, key, board.options.keys, control=control):
            board.render()

    def _key_ended(self) -> None:
        self._presses.end()
