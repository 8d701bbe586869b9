"""What mouse and keyboard do: handles are dragged, values are typed, keys are commands.

A drag goes from VTK's widget to `Interaction._dragged` and `Drag.move`. The handle says what the cursor makes of the
light (`handles.py`, which computes with `view.py`), and the renderer's light is set (`studio/window_lights.py`).
VTK's widget then draws a frame, before which the meshes are lit again (`studio/lit_actors.py`) and the gizmos drawn
anew (`Interaction.update`).
"""

from __future__ import annotations

import math
import re
import textwrap
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkInteractionWidgets import vtkHandleWidget, vtkPointHandleRepresentation2D

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.optics.light import Light
from pvphong.studio.gizmos import commands
from pvphong.studio.gizmos.gizmo import HIGHLIGHT, Gizmo, Gizmos, called
from pvphong.studio.gizmos.handles import INTENSITY, LightInScene
from pvphong.studio.gizmos.highlight import SurfacePoint, Surfaces, mirrored_to_eye
from pvphong.studio.gizmos.view import Cursor, DragStart, vector

# -- a light that is being changed


class Edit:
    """A light that is being changed, and everything as it was when that began.

    Parameters
    ----------
    gizmos : Gizmos
        All of the subplot.
    gizmo : Gizmo
        The light's.
    handle : str
        Which of its handles is dragged, or what is typed.
    """

    def __init__(self, gizmos: Gizmos, gizmo: Gizmo, handle: str) -> None:
        self.gizmos, self.gizmo, self.handle = gizmos, gizmo, handle
        self.view = gizmos.view
        self.start = gizmo.in_scene(self.view, grabbed=handle)
        self.before = gizmos.lights.state
        self._own, self._own_state = gizmo.renderer_light.light(self.view.viewer), gizmo.renderer_light.state

    @property
    def is_possible(self) -> bool:
        """Whether the light is still there."""
        return self.gizmo.renderer_light in self.gizmos.lights.renderer_lights

    def set(self, light: Light) -> None:
        """Make the light another of the world; in its own frame what has not changed keeps its bits."""
        before, viewer = self.start.light, self.view.viewer
        if light == before:
            self.put_back()
            return
        moved = light.in_frame(self._own.frame, viewer)
        same = (field for field in light.roles if getattr(light, field) == getattr(before, field))
        changed = replace(moved, **{field: getattr(self._own, field) for field in same})
        self.gizmo.renderer_light.set(changed, viewer)

    def put_back(self) -> None:
        """Make the light what it was, to the bit."""
        self.gizmo.renderer_light.restore(self._own_state)

    @property
    def now(self) -> LightInScene:
        """The light as it is now, where it started."""
        return LightInScene(
            self.gizmo.renderer_light.light(self.view.viewer).in_world(self.view.viewer), self.start.scenery
        )


class Drag(Edit):
    """A running drag of a handle that was at `point`; the light is a function of what was frozen and of the cursor."""

    def __init__(self, gizmos: Gizmos, gizmo: Gizmo, handle: str, point: Float64Array) -> None:
        super().__init__(gizmos, gizmo, handle)
        self.readout = ""
        self.over: SurfacePoint | None = None
        """Where on a surface the highlight has been dragged to."""
        self._highlight = gizmo.surface_highlight(self.view)
        self._surfaces: Surfaces | None = gizmos.surfaces if handle == HIGHLIGHT else None
        light, scenery, options = self.start.light, self.start.scenery, gizmos.options
        steps = options.angle_step, options.length_step
        self._grabbed = DragStart(light, handle, vector(point), gizmos.cursor, self.view, scenery, *steps)

    def move(self, cursor: Cursor) -> None:
        """Give the light the value that belongs to the cursor's place."""
        if self._surfaces is None:
            light = self.start.handles[self.handle].dragged(self._grabbed, cursor)
        else:
            x, y = self._grabbed.picture(cursor).tolist()
            target = self._surfaces.pick((x, y))
            if self._highlight is None or target is None:  # off the surface: it waits
                light = self.now.light
            else:
                self.over = target
                light = mirrored_to_eye(self.start.light, self.view, self._highlight, target)
        self.set(light)
        self.readout = LightInScene(light, self.start.scenery).readout(self.handle)


_CHARACTERS = frozenset("0123456789.+-exyz ")  # of which typed text consists; a comma counts as a decimal point
# VTK's names of keys that give one of the characters.
_CHARACTER_OF = {"period": ".", "comma": ".", ",": ".", "minus": "-", "plus": "+", "space": " "}
_CHARACTER_OF |= {"KP_Decimal": ".", "KP_Separator": ".", "KP_Subtract": "-", "KP_Add": "+"}
_CHARACTER_OF |= {f"KP_{digit}": str(digit) for digit in range(10)}
_MESSAGE_WIDTH = 48  # letters
_HOW = "Enter: take  Tab: next  Esc: give up"


class Entry(Edit):
    """What is typed for one handle of a light, or for its intensity; the light follows every character."""

    def __init__(self, gizmos: Gizmos, gizmo: Gizmo, handle: str) -> None:
        super().__init__(gizmos, gizmo, handle)
        self.text = ""
        """What has been typed."""
        self.error = ""
        """Why that is no value; "" where it is one."""

    def put(self, text: str) -> None:
        """Make the light what a text says; as it was where that says nothing, or nothing that is allowed."""
        self.text, self.error = text, ""
        try:
            self.set(typed_light(self.start, self.handle, text))
        except ValueError as error:
            self.put_back()
            self.error = textwrap.fill(str(error), _MESSAGE_WIDTH)

    @property
    def readout(self) -> str:
        """What is typed, what the light has now, and how to end it."""
        now = self.now
        numbers = "  ".join(f"{label} {value:.4g}" for label, value in now.handles[self.handle].numbers.items())
        lines = [f"{called(now.light)}: {self.handle} = {self.text}_", numbers]
        return "\n".join([*lines, self.error or now.arriving, _HOW])


def typed_light(shown: LightInScene, handle: str, text: str) -> Light:
    """The light with the numbers of a text: in the labels' order; a label of one letter goes to its number.

    Raises
    ------
    ValueError
        If it is no such text, has too many numbers, or the light allows no such value.
    """
    light, known, given = shown.light, shown.handles[handle].numbers, dict[str, float]()
    labels = list(known)
    letters = "".join(label for label in labels if len(label) == 1)
    at = 0
    for part in re.findall(f"[{letters}]|[^{letters} ]+" if letters else "[^ ]+", text):
        if part in labels:
            at = labels.index(part)
            continue
        if at == len(labels):
            check.refuse("text", text, f"at most {len(labels)} of {', '.join(labels)}")
        try:
            number = float(part)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            check.refuse(labels[at], part, "a number")
        given[labels[at]] = number
        at += 1
    if all(known[label] == value for label, value in given.items()):
        return light
    typed = shown.handles[handle].typed(known | given)
    if typed == light:  # it would shine from its target
        check.refuse(handle, given, "another place", "The light must shine somewhere.")
    return typed


# -- events

_BEFORE_ALL, _BEFORE_WIDGET = 2.0, 1.0  # its own is 0.5, PyVista's and the interactor style's 0

TOLERANCE = 12
"""How near to a handle the cursor must be, in pixels: the dot that is drawn is half as wide."""


class Interaction:
    """Turns the events of one subplot into drags, typed values and commands.

    One widget of VTK's stands for all handles: it is put to the one nearest to the cursor, finds out whether the cursor
    is on it, and follows the mouse. It draws nothing, for handles are part of the gizmos' drawing; in pixels it is no
    part of the scene's bounds, and cannot be picked as an object.

    Parameters
    ----------
    gizmos : Gizmos
        What they act on.
    """

    def __init__(self, gizmos: Gizmos) -> None:
        self.gizmos = gizmos
        self.edit: Drag | Entry | None = None
        self.grabbed_last = ""
        self._key_down: str | None = None
        self._handles: dict[tuple[Gizmo, str], Float64Array] = {}
        self._nearest: tuple[Gizmo, str] | None = None
        self._observed: list[tuple[Any, int]] = []
        interactor, nothing = gizmos.interactor, vtkPolyData()
        nothing.SetPoints(vtkPoints())
        self._representation = vtkPointHandleRepresentation2D()
        self._representation.SetCursorShape(nothing)
        self._representation.SetTolerance(TOLERANCE)
        self._representation.UseBoundsOff()
        self._representation.PickableOff()
        self._widget = vtkHandleWidget()
        self._widget.SetInteractor(interactor)
        self._widget.SetDefaultRenderer(gizmos.renderer)
        self._widget.SetCurrentRenderer(gizmos.renderer)
        self._widget.SetRepresentation(self._representation)
        self._widget.KeyPressActivationOff()
        self._widget.EnableAxisConstraintOff()
        self._widget.SetEnabled(True)
        self._observe(self._widget, "StartInteractionEvent", Interaction._grabbed)
        self._observe(self._widget, "InteractionEvent", Interaction._dragged)
        self._observe(self._widget, "EndInteractionEvent", Interaction._dropped)
        self._observe(gizmos.renderer, "StartEvent", Interaction.update)
        self._observe(interactor, "KeyPressEvent", Interaction._key_pressed, _BEFORE_ALL)
        self._observe(interactor, "CharEvent", Interaction._press_ended, _BEFORE_ALL)
        self._observe(interactor, "KeyReleaseEvent", Interaction._press_ended)
        for event in ("MouseMoveEvent", "LeftButtonPressEvent"):
            self._observe(interactor, event, Interaction._pointed, _BEFORE_WIDGET)
        self.update()

    def _observe(
        self, subject: Any, event: str, react: Callable[[Interaction], bool | None], priority: float = 0.0
    ) -> None:
        """React to an event; nobody else hears of it where the answer is True."""
        interaction = weakref.ref(self)

        def happened(subject: Any, _event: str) -> None:
            if (alive := interaction()) is not None and react(alive):
                subject.GetCommand(tag).SetAbortFlag(1)

        tag = int(subject.AddObserver(event, happened, priority))
        self._observed.append((subject, tag))

    def update(self) -> None:
        """Bring handles and looks to where lights, camera and scene are now."""
        gizmos, view, edit = self.gizmos, self.gizmos.view, self.edit
        handles = dict[tuple[Gizmo, str], Float64Array]()
        shown = {} if gizmos.is_hidden else {gizmo: gizmo.highlight for gizmo in gizmos.all}
        if isinstance(edit, Drag) and edit.gizmo in shown and edit.over is not None:
            shown[edit.gizmo] = edit.over.point  # where it was dragged to, which need not be at a vertex
        for gizmo, highlight in shown.items():
            points = gizmo.in_scene(view).points(view)
            if highlight is not None:
                points[HIGHLIGHT] = np.array(highlight)
            handles |= {(gizmo, name): point for name, point in points.items() if view.is_ahead(point)}
        self._handles = handles
        self._hover()
        active, readout = gizmos.hovered, ""
        if edit is not None:
            active, readout = (edit.gizmo, edit.handle), edit.readout
        if readout and (note := gizmos.lit.note):
            readout = f"{readout}\n{note}"
        keys = commands.help_entries(gizmos.options.keys)
        gizmos.draw(view, shown, active, readout, "\n".join(f"{key:15}{what}" for key, what in keys))

    def _hover(self) -> bool:
        """Put the widget to the handle nearest to the cursor; returns whether another than before is under it now."""
        gizmos, cursor = self.gizmos, self.gizmos.cursor
        if self._is_held:
            return False
        view, before = gizmos.view, gizmos.hovered
        off = {key: math.dist(view.project(point), cursor) for key, point in self._handles.items()}
        # where dots overlap, the selected light's is meant
        on_selected = [key for key in off if key[0].is_selected and off[key] <= TOLERANCE / 2]
        candidates = {} if gizmos.is_another_pointed_at else on_selected or off
        self._nearest = min(candidates, key=lambda key: off[key], default=None)
        self._widget.SetProcessEvents(self._nearest is not None)
        gizmos.hovered = None
        if self._nearest is not None:
            self._representation.SetWorldPosition(self._handles[self._nearest].tolist())
            self._representation.BuildRepresentation()  # else it is grabbed where it was at the last frame
            is_near = self._representation.ComputeInteractionState(*gizmos.interactor.GetEventPosition())
            gizmos.hovered = self._nearest if is_near and gizmos.is_pointed_at else None
        return before != gizmos.hovered

    @property
    def _is_held(self) -> bool:
        return bool(self._widget.GetWidgetState() == vtkHandleWidget.Active)

    @contextmanager
    def out_of_sight(self) -> Iterator[None]:
        """Without gizmos, unless they are to be in screenshots."""
        if self.gizmos.options.in_screenshots:
            yield
            return
        self.gizmos.overlay.show(False)
        try:
            yield
        finally:
            self.gizmos.overlay.show(True)
            self.update()

    def release(self) -> None:
        """Let go of widget, observers and actors; what is dragged or typed is taken."""
        self.settle()
        for subject, tag in self._observed:
            subject.RemoveObserver(tag)
        if self._is_held:
            self._widget.ReleaseFocus()
        self._widget.SetEnabled(False)
        self._widget.SetInteractor(None)
        self._widget.SetCurrentRenderer(None)
        self._widget.SetDefaultRenderer(None)
        self.gizmos.overlay.detach(self.gizmos.renderer)

    # -- the mouse

    def _pointed(self) -> None:
        """The cursor is somewhere else, perhaps in a window of another size, of which no frame has been drawn.

        While the button is down, trame may draw fewer pixels.
        """
        if self._hover():
            self.gizmos.render()

    def _grabbed(self) -> None:
        """A handle was grabbed: freeze everything that the drag depends on."""
        assert self._nearest is not None
        self.gizmos.history.settle()  # what was being typed, here or elsewhere
        self.gizmos.notice = ""
        self.gizmos.select(self._nearest[0])
        self._begin(Drag(self.gizmos, *self._nearest, self._handles[self._nearest]))

    def _dragged(self) -> None:
        """The cursor moved with the button down: the light follows the cursor."""
        interactor = self.gizmos.interactor
        if isinstance(self.edit, Drag) and self.edit.is_possible:
            shift, control = bool(interactor.GetShiftKey()), bool(interactor.GetControlKey())
            self.edit.move(Cursor(self.gizmos.cursor, shift, control))

    def _dropped(self) -> None:
        """The button was let go: the drag becomes one step."""
        if isinstance(self.edit, Drag):
            self.settle()
        self.gizmos.render()

    # -- the beginning and the end of an edit

    def _begin(self, edit: Drag | Entry | None) -> None:
        self.edit = edit
        self.gizmos.lit.uses_preview_rays = isinstance(edit, Drag)
        if edit is not None:
            self.grabbed_last = edit.handle
            self.gizmos.history.begin(self)
        else:
            self.gizmos.history.end(self)

    def settle(self) -> None:
        """End what is dragged or typed, as one step."""
        self._end(taken=True)

    def give_up(self) -> None:
        """End what is dragged or typed, and put the light back."""
        self._end(taken=False)
        self.gizmos.render()

    def _end(self, *, taken: bool) -> None:
        """What was dragged or typed becomes one step, or is put back."""
        edit = self.edit
        self._begin(None)
        if edit is not None and edit.is_possible:
            if taken:
                self.gizmos.history.record(self.gizmos.lights, edit.before)
            else:
                edit.put_back()

    # -- the keyboard

    def _key_pressed(self) -> bool:
        """A key was pressed; True if it belongs to the value that is being typed.

        A press ends with its `CharEvent` or with its release. Trame's remote area reports letters twice before that,
        for the browser's `keydown` and for its `keypress`: the second report is none.
        """
        gizmos, key = self.gizmos, self.gizmos.interactor.GetKeySym()
        character = _CHARACTER_OF.get(key, key)
        character = character if character in _CHARACTERS else ""
        drag = self.edit if isinstance(self.edit, Drag) else None
        if drag is not None and character.strip() and drag.is_possible and drag.handle != HIGHLIGHT:
            drag.put_back()  # the value is typed from here on
            self._begin(Entry(gizmos, drag.gizmo, drag.handle))
        is_typed = isinstance(self.edit, Entry)
        is_new, self._key_down = key != self._key_down, key
        if not is_new:
            return is_typed
        if isinstance(self.edit, Entry):
            self._type(self.edit, key, character)
            gizmos.render()
        elif self.edit is not None:
            if key == "Escape":
                self.give_up()
        elif gizmos.is_pointed_at and not isinstance(gizmos.history.running, Interaction):  # whose keys they are then
            control, gizmo = bool(gizmos.interactor.GetControlKey()), gizmos.selected
            if key in commands.ENTER and not control and gizmo is not None:
                # a value for the handle that was grabbed last, if it is the selected light's
                names = [*gizmo.handles, INTENSITY]
                gizmos.history.settle()
                self._begin(Entry(gizmos, gizmo, self.grabbed_last if self.grabbed_last in names else names[0]))
                gizmos.render()
            elif commands.run(gizmos, key, control=control):
                gizmos.render()
        return is_typed

    def _press_ended(self) -> bool:
        """A press has ended, with a character perhaps; True if nobody else may act on it: a value is being typed."""
        self._key_down = None
        return isinstance(self.edit, Entry)

    def _type(self, entry: Entry, key: str, character: str) -> None:
        if not entry.is_possible or key == "Escape":
            self._end(taken=False)
        elif key in commands.ENTER or key == "Tab":
            if entry.error:  # it stays, and says what is wrong
                return
            self.settle()
            if key == "Tab":
                names = [*entry.gizmo.handles, INTENSITY]
                following = names[(names.index(entry.handle) + 1) % len(names)]
                self._begin(Entry(self.gizmos, entry.gizmo, following))
        elif key == "BackSpace":
            entry.put(entry.text[:-1])
        elif character:
            entry.put(entry.text + character)
