"""Keys: which there are, and what each does. None of them is one of PyVista's or VTK's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import nullcontext
from typing import Any, NamedTuple

from pvphong.base import check
from pvphong.studio.gizmos import light_commands as lights
from pvphong.studio.gizmos import material_commands as materials
from pvphong.studio.gizmos import view_commands as views
from pvphong.studio.gizmos.options import Keys
from pvphong.studio.gizmos.surroundings import Surroundings


class Command(NamedTuple):
    """What one key does, or two that belong together."""

    keys: tuple[str, ...]
    """By VTK's names."""

    what: str
    """What the help says."""

    act: tuple[Callable[[Surroundings], None], ...]
    """What each of the keys does."""


_SHOWING = (
    Command(("h",), "these keys", (views.toggle_help,)),
    Command(("g",), "hide or show the gizmos", (views.toggle_hidden,)),
    Command(("n",), "select the next light", (views.select_next,)),
    Command(("z", "y"), "undo, redo", (views.undo, views.redo)),
)
_OF_LIGHTS = (
    Command(("m",), "light off or on", (lights.mute,)),
    Command(("o",), "this light alone, or all", (lights.solo,)),
    Command(("k",), "light to the camera", (lights.to_camera,)),
    Command(("0",), "light as it was at first", (lights.reset,)),
    Command(("Left", "Right"), "dimmer, brighter by 1/3 stop", (lights.dimmer, lights.brighter)),
    Command(("comma", "period"), "hue back, on", (lights.hue_back, lights.hue_on)),
    Command(("1", "2"), "cooler, warmer", (lights.cooler, lights.warmer)),
    Command(("N",), "new light where the cursor points", (lights.add,)),
    Command(("D",), "duplicate the light", (lights.duplicate,)),
    Command(("Delete", "BackSpace"), "delete the light", (lights.delete, lights.delete)),
)
_OF_MATERIALS = (
    Command(("M", "K"), "material: next, previous", (materials.following, materials.preceding)),
    Command(("5", "6"), "less, more shiny", (materials.duller, materials.shinier)),
    Command(("7", "8"), "weaker, stronger highlight", (materials.weaker, materials.stronger)),
)
COMMANDS = _SHOWING + _OF_LIGHTS + _OF_MATERIALS
_TYPING = {"Enter": "type a value; in a drag: digits"}
_MOUSE = {
    "drag": "a handle, or the highlight",
    "Shift": "along one axis",
    "Ctrl": "in steps",
    "Esc": "put back",
}
_SHORT = {"comma": ",", "period": ".", "Delete": "Del", "BackSpace": "Backspace"}

TAKEN = frozenset({*"qQeErRwWsSpPbBvVCcfFuUiI3lLjJtTaA+-", "Up", "Down", "plus", "minus"})
"""What vtkInteractorStyle::OnChar, `Plotter.reset_key_events`, PyVista's picking and VTK's widgets listen to."""

OURS = frozenset(key for command in COMMANDS for key in command.keys) | {"Return", "KP_Enter"}
"""The keys that have a meaning here."""


def check_keys(keys: Keys) -> Keys:
    """Raise ValueError for a key that has a meaning already, or has none."""
    if not isinstance(keys, Mapping):
        check.refuse("keys", keys, "a mapping: key → (what the help says, function without arguments)")
    for key, entry in keys.items():
        if not isinstance(entry, tuple) or len(entry) != 2:
            check.refuse(f"keys[{key!r}]", entry, "what the help says, and a function without arguments")
        what, action = entry
        if check.text("keys", key) in TAKEN | OURS:
            check.refuse("keys", key, "keys that are free", "x, d, 4 and 9 are, for example.")
        check.text(f"keys[{key!r}][0]", what)
        if not callable(action):
            check.refuse(f"keys[{key!r}][1]", action, "a function without arguments")
    return keys


def entries(more: Keys) -> list[tuple[str, str]]:
    """All keys as people call them, and what they do."""
    ours = [(" ".join(_SHORT.get(key, key) for key in command.keys), command.what) for command in COMMANDS]
    return [*ours, *_TYPING.items(), *((key, what) for key, (what, _) in more.items()), *_MOUSE.items()]


def help_text(more: Keys) -> str:
    """All keys, one or two a line."""
    return "\n".join(f"{keys:15}{what}" for keys, what in entries(more))


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


def run(board: Surroundings, key: str, more: Keys, *, control: bool = False) -> bool:
    """Do what a key stands for, here or among the caller's own; False if it stands for nothing."""
    act = _ACTS.get(key)
    if control and key not in ("z", "y"):
        return False
    if act is not None:
        board.notice = ""
        edited = next((edited(board) for table, edited in _EDITED if key in table), None)
        with nullcontext() if edited is None else board.history.edit(edited):
            act(board)
        return True
    if key in more:
        board.notice = more[key][1]() or ""
        return True
    return False


def _acts(commands: tuple[Command, ...]) -> dict[str, Callable[[Surroundings], None]]:
    return {key: act for command in commands for key, act in zip(command.keys, command.act, strict=True)}


_ACTS = _acts(COMMANDS)
_EDITED: tuple[tuple[Any, Callable[[Surroundings], Any]], ...] = (
    (_acts(_OF_LIGHTS), lambda board: board.rig),
    (_acts(_OF_MATERIALS), lambda board: board.materials),
)
"""What the commands of a table change: that is one step of undo."""
