"""What keys do to lights. None of them is one of PyVista's or VTK's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Protocol

from pvphong.base import check
from pvphong.optics.roles import Aim
from pvphong.studio.gizmos.gizmo import Gizmo
from pvphong.studio.gizmos.history import History
from pvphong.studio.gizmos.shape import fields
from pvphong.studio.gizmos.view import View
from pvphong.studio.rig import Rig


class Board(Protocol):
    """What keys act on: the gizmos of one renderer, as `board.Board` has them."""

    rig: Rig
    history: History
    hidden: bool
    helping: bool

    @property
    def gizmos(self) -> tuple[Gizmo, ...]:
        """A gizmo for each light."""

    @property
    def selected(self) -> Gizmo | None:
        """The gizmo that keys act on."""

    @property
    def view(self) -> View:
        """The pane as it is now."""

    def select(self, chosen: Gizmo | None) -> None:
        """Select a gizmo, or none."""


def _toggle_help(board: Board) -> None:
    board.helping = not board.helping


def _toggle_hidden(board: Board) -> None:
    board.hidden = not board.hidden


def _select_next(board: Board) -> None:
    ring = [None, *board.gizmos]
    board.select(ring[(ring.index(board.selected) + 1) % len(ring)])


def _mute(board: Board) -> None:
    if (gizmo := board.selected) is not None:
        light = gizmo.light
        gizmo.handle.set(replace(light, on=not light.on), board.view.viewer)


def _solo(board: Board) -> None:
    """All others off; if they are off already, all on."""
    if (chosen := board.selected) is None:
        return
    viewer = board.view.viewer
    others = [handle for handle in board.rig.handles if handle is not chosen.handle]
    alone = chosen.light.on and not any(handle.light(viewer).on for handle in others)
    for handle in others:
        handle.set(replace(handle.light(viewer), on=alone), viewer)
    chosen.handle.set(replace(chosen.light, on=True), viewer)


def _to_camera(board: Board) -> None:
    """The light where the eye is, shining along the view axis."""
    if (gizmo := board.selected) is None:
        return
    viewer, light = board.view.viewer, gizmo.light
    world = replace(light, frame="headlight").in_world(viewer)
    aim: Any = tuple(viewer.distance * part for part in viewer.view_direction)
    aimed = replace(world, **dict.fromkeys(list(fields(world, Aim))[:1], aim))  # the focal point is its target
    gizmo.handle.set(aimed.in_frame(light.frame, viewer), viewer)


def _reset(board: Board) -> None:
    if (gizmo := board.selected) is not None:
        gizmo.handle.set(gizmo.first, board.view.viewer)


def _undo(board: Board) -> None:
    board.history.undo()


def _redo(board: Board) -> None:
    board.history.redo()


_SHOWING: dict[str, tuple[str, Callable[[Board], None]]] = {
    "h": ("these keys", _toggle_help),
    "g": ("hide or show the gizmos", _toggle_hidden),
    "n": ("select the next light", _select_next),
    "z": ("undo", _undo),
    "y": ("redo", _redo),
}
_CHANGING: dict[str, tuple[str, Callable[[Board], None]]] = {
    "m": ("light off or on", _mute),
    "o": ("this light alone, or all", _solo),
    "k": ("light to the camera", _to_camera),
    "0": ("light as it was at first", _reset),
}
_MOUSE = {
    "drag": "a handle, or the highlight",
    "Shift": "along one axis",
    "Ctrl": "in steps",
    "Esc": "put back",
}

TAKEN = frozenset({*"qQeErRwWsSpPbBvVCcfFuUiI3lLjJtTaA+-", "Up", "Down", "plus", "minus"})
"""What vtkInteractorStyle::OnChar, `Plotter.reset_key_events`, PyVista's picking and VTK's widgets listen to."""

Keys = Mapping[str, tuple[str, Callable[[], None]]]
"""Key → what the help says, and what is done."""


def check_keys(keys: Keys) -> Keys:
    """Raise ValueError for a key that has a meaning already, or has none."""
    for key, (what, action) in keys.items():
        if key in TAKEN or key in _SHOWING or key in _CHANGING:
            check.refuse("keys", key, "keys that are free", "x, d and the digits from 4 are, for example.")
        check.text(f"keys[{key!r}][0]", what)
        if not callable(action):
            check.refuse(f"keys[{key!r}][1]", action, "a function without arguments")
    return keys


def help_text(more: Keys) -> str:
    """All keys, one a line."""
    entries = {key: what for table in (_SHOWING, _CHANGING, more) for key, (what, _) in table.items()}
    return "\n".join(f"{key:6}{what}" for key, what in (entries | _MOUSE).items())


class Presses:
    """Tells presses of a key apart from reports of them.

    A press ends with its `CharEvent` or with its release. Trame's remote area reports letters twice before that, for
    the browser's `keydown` and for its `keypress`.
    """

    def __init__(self) -> None:
        self._down: str | None = None

    def begin(self, key: str) -> bool:
        """A press is reported; False if it is the one that was reported last."""
        is_new = key != self._down
        self._down = key
        return is_new

    def end(self) -> None:
        """The key has given its character, or was let go."""
        self._down = None


def run(board: Board, key: str, more: Keys, *, control: bool = False) -> bool:
    """Do what a key stands for, here or among the caller's own; False if it stands for nothing."""
    if key in _SHOWING and (not control or key in "zy"):
        _SHOWING[key][1](board)
    elif key in _CHANGING and not control:
        with board.history.edit(board.rig):
            _CHANGING[key][1](board)
    elif key in more and not control:
        more[key][1]()
    else:
        return False
    return True
