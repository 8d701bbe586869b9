"""A value that is being typed: the text, and the light that it makes so far."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass

from pvphong.optics.light import Light
from pvphong.scene.viewer import Viewer
from pvphong.studio.gizmos.drag_start import Scenery
from pvphong.studio.gizmos.dragging import in_its_frame
from pvphong.studio.gizmos.gizmo import Gizmo
from pvphong.studio.gizmos.names import called
from pvphong.studio.gizmos.readout import arriving_line
from pvphong.studio.gizmos.typed import CHARACTERS, numbers, parse, with_numbers
from pvphong.studio.rig import Rig, RigState

_WIDTH = 48  # of messages, in letters
_HOW = "Enter: take  Tab: next  Esc: give up"
# VTK's names of keys that give one of the characters, and of those that end an entry or erase.
_CHARACTER_OF = {"period": ".", "comma": ".", ",": ".", "minus": "-", "plus": "+", "space": " "}
_CHARACTER_OF |= {"KP_Decimal": ".", "KP_Separator": ".", "KP_Subtract": "-", "KP_Add": "+"}
_CHARACTER_OF |= {f"KP_{digit}": str(digit) for digit in range(10)}
TAKE, NEXT, GIVE_UP, ERASE = frozenset({"Return", "KP_Enter"}), frozenset({"Tab"}), "Escape", "BackSpace"


def character_of(key: str) -> str:
    """What a key adds to a text; "" for one that adds nothing."""
    character = _CHARACTER_OF.get(key, key)
    return character if character in CHARACTERS else ""


@dataclass
class Entry:
    """What is typed for one handle of a light, or for its intensity; the light follows every character.

    Parameters
    ----------
    gizmo : Gizmo
        Whose.
    handle : str
        Which of its handles, or `typed.INTENSITY`.
    rig : Rig
        All lights.
    before : RigState
        What they are, and will be again if the entry is given up.
    light : Light
        What this one was then, in its own frame.
    scenery : Scenery
        The scene.
    viewer : Viewer
        The eye.
    text : str
        What has been typed.
    trouble : str
        Why that is no value; "" where it is one.
    """

    gizmo: Gizmo
    handle: str
    rig: Rig
    before: RigState
    light: Light
    scenery: Scenery
    viewer: Viewer
    text: str = ""
    trouble: str = ""

    @property
    def is_possible(self) -> bool:
        """Whether the light is still there."""
        return self.gizmo.handle in self.rig.handles

    def put(self, text: str) -> None:
        """Make the light what a text says; as it was where that says nothing, or nothing that is allowed."""
        self.text, self.trouble = text, ""
        self.put_back()
        world = self.light.in_world(self.viewer)
        try:
            given = parse(text, list(numbers(world, self.handle, self.scenery)))
            changed = with_numbers(world, self.handle, given, self.scenery)
        except ValueError as error:
            self.trouble = textwrap.fill(str(error), _WIDTH)
            return
        if changed != world:
            self.gizmo.handle.set(in_its_frame(changed, world, self.light, self.viewer), self.viewer)

    def put_back(self) -> None:
        """Make all lights what they were, to the bit."""
        self.rig.turn(self.rig.state, self.before)

    @property
    def readout(self) -> str:
        """What is typed, what the light has now, and how to end it."""
        light = self.gizmo.light_for(self.viewer).in_world(self.viewer)
        now = "  ".join(f"{label} {value:.4g}" for label, value in numbers(light, self.handle, self.scenery).items())
        lines = [f"{called(light)}: {self.handle} = {self.text}_", now]
        return "\n".join([*lines, self.trouble or arriving_line(light, self.scenery), _HOW])
