"""Mouse and keyboard: handles are dragged, values are typed, keys run commands.

VTK's widget passes a drag to `Interaction._dragged` and `Drag.move`. The handle computes the new light from the cursor
(`handles.py`, with `view.py`), and the renderer's light is set (`studio/window_lights.py`). VTK's widget then draws a
frame. Before this frame, the meshes are lit again (`studio/lit_actors.py`) and the gizmos are redrawn
(`Interaction.update`).
"""

from __future__ import annotations

import math
import re
import textwrap
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkInteractionWidgets import vtkHandleWidget, vtkPointHandleRepresentation2D

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.optics.light import Light
from pvphong.studio.gizmos import commands
from pvphong.studio.gizmos.asking import Ask
from pvphong.studio.gizmos.gizmo import HIGHLIGHT, Gizmo, Gizmos, called
from pvphong.studio.gizmos.handles import INTENSITY, LightInScene
from pvphong.studio.gizmos.highlight import SurfacePoint, Surfaces, mirrored_to_eye
from pvphong.studio.gizmos.view import Cursor, DragStart, vector

# -- edits in progress


class Edit:
    """An edit in progress of one light, with the state at the start of the edit.

    Parameters
    ----------
    gizmos : Gizmos
        The gizmos of the subplot.
    gizmo : Gizmo
        The light's gizmo.
    handle : str
        Name of the handle that is dragged or typed.
    """

    def __init__(self, gizmos: Gizmos, gizmo: Gizmo, handle: str) -> None:
        self.gizmos, self.gizmo, self.handle = gizmos, gizmo, handle
        self.view = gizmos.view
        self.start = gizmo.in_scene(self.view, grabbed=handle)
        self.before = gizmos.lights.state
        self._own, self._own_state = gizmo.renderer_light.light(self.view.viewer), gizmo.renderer_light.state

    @property
    def is_possible(self) -> bool:
        """True while the light exists. Other code may remove it."""
        return self.gizmo.renderer_light in self.gizmos.lights.renderer_lights

    def set(self, light: Light) -> None:
        """Set the edited light to `light`, given in world coordinates.

        Fields that have not changed keep their exact values in the light's own frame.
        """
        before, viewer = self.start.light, self.view.viewer
        if light == before:
            self.put_back()
            return
        moved = light.in_frame(self._own.frame, viewer)
        same = (field for field in light.roles if getattr(light, field) == getattr(before, field))
        changed = replace(moved, **{field: getattr(self._own, field) for field in same})
        self.gizmo.renderer_light.set(changed, viewer)

    def put_back(self) -> None:
        """Restore the light exactly as it was at the start of the edit."""
        self.gizmo.renderer_light.restore(self._own_state)

    @property
    def now(self) -> LightInScene:
        """The light's current value, with the scene as it was at the start of the edit."""
        return LightInScene(
            self.gizmo.renderer_light.light(self.view.viewer).in_world(self.view.viewer), self.start.scenery
        )


class Drag(Edit):
    """An edit by dragging a handle; `point` is the handle's world position at the start.

    The light depends only on the state at the start and on the cursor. There is one exception: while a highlight is
    dragged off the surface, the light stays as it is.
    """

    def __init__(self, gizmos: Gizmos, gizmo: Gizmo, handle: str, point: Float64Array) -> None:
        super().__init__(gizmos, gizmo, handle)
        self.readout = ""
        self.over: SurfacePoint | None = None
        """The last surface point to which the highlight has been dragged; None before the first."""
        self._highlight = gizmo.surface_highlight(self.view)
        self._surfaces: Surfaces | None = gizmos.surfaces if handle == HIGHLIGHT else None
        light, scenery, options = self.start.light, self.start.scenery, gizmos.options
        steps = options.angle_step, options.length_step
        self._grabbed = DragStart(light, handle, vector(point), gizmos.cursor, self.view, scenery, *steps)

    def move(self, cursor: Cursor) -> None:
        """Set the light for a new position of the cursor."""
        if self._surfaces is None:
            light = self.start.handles[self.handle].dragged(self._grabbed, cursor)
        else:
            x, y = self._grabbed.picture(cursor).tolist()
            target = self._surfaces.pick((x, y))
            if self._highlight is None or target is None:  # off the surface: no change
                light = self.now.light
            else:
                self.over = target
                light = mirrored_to_eye(self.start.light, self.view, self._highlight, target)
        self.set(light)
        self.readout = LightInScene(light, self.start.scenery).readout(self.handle)


_CHARACTERS = frozenset("0123456789.+-exyz ")  # allowed in typed text; a comma counts as a decimal point
# VTK's names of the keys for these characters.
_CHARACTER_OF = {"period": ".", "comma": ".", ",": ".", "minus": "-", "plus": "+", "space": " "}
_CHARACTER_OF |= {"KP_Decimal": ".", "KP_Separator": ".", "KP_Subtract": "-", "KP_Add": "+"}
_CHARACTER_OF |= {f"KP_{digit}": str(digit) for digit in range(10)}
_MESSAGE_WIDTH = 48  # characters
_HOW = "Enter: accept  Tab: next  Esc: cancel"


class Entry(Edit):
    """An edit by typing values for a handle of a light, or for its intensity.

    Each character changes the light at once.
    """

    def __init__(self, gizmos: Gizmos, gizmo: Gizmo, handle: str) -> None:
        super().__init__(gizmos, gizmo, handle)
        self.text = ""
        """The typed text."""
        self.error = ""
        """Error message for a text that is not a valid value; "" if it is valid."""

    def put(self, text: str) -> None:
        """Set the light to the values in a text. If the text is empty or a value is invalid, restore the light."""
        self.text, self.error = text, ""
        try:
            self.set(typed_light(self.start, self.handle, text))
        except ValueError as error:
            self.put_back()
            self.error = textwrap.fill(str(error), _MESSAGE_WIDTH)

    @property
    def readout(self) -> str:
        """The typed text, the light's current numbers, and the keys that end typing."""
        now = self.now
        numbers = "  ".join(f"{label} {value:.4g}" for label, value in now.handles[self.handle].numbers.items())
        lines = [f"{called(now.light)}: {self.handle} = {self.text}_", numbers]
        return "\n".join([*lines, self.error or now.arriving, _HOW])


def typed_light(shown: LightInScene, handle: str, text: str) -> Light:
    """Return the light with the numbers in a typed text.

    Numbers are in the order of the handle's labels. A label of one letter, such as x, can stand before its number.

    Parameters
    ----------
    shown : LightInScene
        The light before the edit.
    handle : str
        Name of the handle.
    text : str
        The typed text.

    Raises
    ------
    ValueError
        If the text is malformed, has too many numbers, or a value is not allowed.
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
            check.refuse("text", text, f"at most {len(labels)} numbers: {', '.join(labels)}")
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
    if typed == light:  # the light and its target would coincide
        check.refuse(handle, given, "a different point", "The light and its target cannot be at the same point.")
    return typed


# -- events

_BEFORE_ALL, _BEFORE_WIDGET = 2.0, 1.0  # priorities; the widget has 0.5, PyVista and the interactor style 0

# Factor by which a step of the wheel makes a spot larger.
_WIDER = 1.25

TOLERANCE = 12
"""Largest distance from the cursor at which a handle is grabbed, in pixels of a screen of usual resolution: about twice
the radius of the drawn dot.
"""


class Interaction:
    """Turns the events of one subplot into drags, typed values and commands.

    A single VTK widget serves all handles. It is moved to the handle nearest to the cursor, tests if the cursor is on
    that handle, and follows the mouse. The widget draws nothing, because the gizmos draw the handles. The widget is
    defined in pixels. So it does not count towards the scene's bounds, and cannot be picked.

    Parameters
    ----------
    gizmos : Gizmos
        The gizmos of the subplot.
    """

    def __init__(self, gizmos: Gizmos) -> None:
        self.gizmos = gizmos
        self.edit: Drag | Entry | Ask | None = None
        self.grabbed_last = ""
        self._key_down: str | None = None
        self._handles: dict[tuple[Gizmo, str], Float64Array] = {}
        self._nearest: tuple[Gizmo, str] | None = None
        self._observed: list[tuple[Any, int]] = []
        interactor, nothing = gizmos.interactor, vtkPolyData()
        nothing.SetPoints(vtkPoints())
        self._representation = vtkPointHandleRepresentation2D()
        self._representation.SetCursorShape(nothing)
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
        self._observe(gizmos.renderer, "StartEvent", Interaction._before_frame, _BEFORE_ALL)
        self._observe(gizmos.renderer, "StartEvent", Interaction.update)
        self._observe(interactor, "LeftButtonPressEvent", Interaction._clicked, _BEFORE_ALL)
        self._observe(interactor, "KeyPressEvent", Interaction._key_pressed, _BEFORE_ALL)
        self._observe(interactor, "CharEvent", Interaction._press_ended, _BEFORE_ALL)
        self._observe(interactor, "KeyReleaseEvent", Interaction._press_ended)
        for event, react in (
            ("LeftButtonPressEvent", Interaction._asked),
            ("MouseMoveEvent", Interaction._asking),
            ("LeftButtonReleaseEvent", Interaction._answered),
            ("MouseWheelForwardEvent", partial(Interaction._resized, factor=_WIDER)),
            ("MouseWheelBackwardEvent", partial(Interaction._resized, factor=1.0 / _WIDER)),
        ):
            self._observe(interactor, event, react, _BEFORE_ALL)
        for event in ("MouseMoveEvent", "LeftButtonPressEvent"):
            self._observe(interactor, event, Interaction._pointed, _BEFORE_WIDGET)
        self.update()

    def _observe(
        self, subject: Any, event: str, react: Callable[[Interaction], bool | None], priority: float = 0.0
    ) -> None:
        """Call `react` at each event with the name `event` of the VTK object `subject`.

        If `react` returns True, observers with a lower priority do not receive the event.
        """
        interaction = weakref.ref(self)

        def happened(subject: Any, _event: str) -> None:
            if (alive := interaction()) is not None and react(alive):
                subject.GetCommand(tag).SetAbortFlag(1)

        tag = int(subject.AddObserver(event, happened, priority))
        self._observed.append((subject, tag))

    def update(self) -> None:
        """Update the handles and the drawing for the current lights, camera and scene."""
        gizmos, view, edit = self.gizmos, self.gizmos.view, self.edit
        handles = dict[tuple[Gizmo, str], Float64Array]()
        shown = {} if gizmos.is_hidden else {gizmo: gizmo.highlight for gizmo in gizmos.all}
        if isinstance(edit, Drag) and edit.gizmo in shown and edit.over is not None:
            shown[edit.gizmo] = edit.over.point  # the exact target, which need not be a vertex
        for gizmo, highlight in shown.items():
            points = gizmo.in_scene(view).points(view)
            if highlight is not None:
                points[HIGHLIGHT] = np.array(highlight)
            handles |= {(gizmo, name): point for name, point in points.items() if view.is_ahead(point)}
        self._handles = handles
        self._hover()
        active, readout = gizmos.hovered, ""
        if isinstance(edit, Ask):
            readout = edit.readout
        elif edit is not None:
            active, readout = (edit.gizmo, edit.handle), edit.readout
        if readout and (note := gizmos.lit.note):
            readout = f"{readout}\n{note}"
        keys = commands.help_entries(gizmos.options.keys)
        gizmos.draw(view, shown, active, readout, "\n".join(f"{key:15}{what}" for key, what in keys))

    def _hover(self) -> bool:
        """Find the handle under the cursor, and move the widget to the nearest handle.

        Return True if the hovered handle has changed.
        """
        gizmos, cursor = self.gizmos, self.gizmos.cursor
        if self._is_held:
            return False
        view, before = gizmos.view, gizmos.hovered
        reach = view.scale * TOLERANCE
        off = {key: math.dist(view.project(point), cursor) for key, point in self._handles.items()}
        # if dots overlap, prefer a dot of the selected light
        on_selected = [key for key in off if key[0].is_selected and off[key] <= reach / 2]
        candidates = {} if gizmos.is_another_pointed_at else on_selected or off
        self._nearest = min(candidates, key=lambda key: off[key], default=None)
        self._widget.SetProcessEvents(self._nearest is not None)
        gizmos.hovered = None
        if self._nearest is not None:
            self._representation.SetTolerance(round(reach))
            self._representation.SetWorldPosition(self._handles[self._nearest].tolist())
            self._representation.BuildRepresentation()  # otherwise it would be grabbed where it was in the last frame
            is_near = self._representation.ComputeInteractionState(*gizmos.interactor.GetEventPosition())
            gizmos.hovered = self._nearest if is_near and gizmos.is_pointed_at else None
        return before != gizmos.hovered

    @property
    def _is_held(self) -> bool:
        return bool(self._widget.GetWidgetState() == vtkHandleWidget.Active)

    @contextmanager
    def out_of_sight(self) -> Iterator[None]:
        """Return a context in which the gizmos are hidden. With the option `in_screenshots`, they stay visible."""
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
        """End and keep an edit in progress, then remove widget, observers and actors."""
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
        """React to a move of the cursor: find the hovered handle, and draw a frame if it has changed.

        This must not wait for the next frame. The window's size may have changed since the last one, because trame may
        draw fewer pixels while the button is down.
        """
        if self._hover():
            self.gizmos.render()

    def _clicked(self) -> bool:
        """Place a light's highlight at the clicked surface point, if a command waits for this click.

        Return False if no command waits. This is called when the button is pressed, before all other reactions.
        """
        gizmos = self.gizmos
        gizmo = gizmos.awaits_click
        if gizmo is None or not gizmos.is_pointed_at:
            return False
        gizmos.notice, gizmos.awaits_click = "", None
        if gizmo in gizmos.all:
            gizmos.history.settle()
            with gizmos.history.edit(gizmos.lights):
                commands.change_light(gizmos, gizmo, commands.highlight_here)
        gizmos.render()
        return True

    def _grabbed(self) -> None:
        """Start the drag of the handle under the cursor, and save the state on which the drag depends."""
        assert self._nearest is not None
        self.gizmos.history.settle()  # ends typing, here or in another subplot
        self.gizmos.notice = ""
        self.gizmos.select(self._nearest[0])
        self._begin(Drag(self.gizmos, *self._nearest, self._handles[self._nearest]))

    def _dragged(self) -> None:
        """Let the light follow the cursor while the button is down."""
        interactor = self.gizmos.interactor
        if isinstance(self.edit, Drag) and self.edit.is_possible:
            shift, control = bool(interactor.GetShiftKey()), bool(interactor.GetControlKey())
            self.edit.move(Cursor(self.gizmos.cursor, shift, control))

    def _dropped(self) -> None:
        """End the drag at the release of the button, and record it as one undo step."""
        if isinstance(self.edit, Drag):
            self.settle()
        self.gizmos.render()

    # -- the mouse, in the mode in which it asks for light

    def _asked(self) -> bool:
        """Start a drag that asks for more or less light on the spot under the cursor.

        Return False if a handle or no mesh is there.
        """
        gizmos = self.gizmos
        if not gizmos.asks or not gizmos.is_pointed_at:
            return False
        self._hover()  # a tap comes without a move
        if gizmos.hovered is not None:
            return False
        spot = gizmos.surfaces.pick(gizmos.cursor)
        if spot is None:
            return False
        gizmos.history.settle()
        gizmos.notice, gizmos.spot = "", (spot, gizmos.spot_size * gizmos.scenery.size)
        try:
            self._begin(Ask(gizmos, *gizmos.spot))
        except ValueError as error:
            gizmos.notice = str(error)
        gizmos.render()
        return True

    def _asking(self) -> bool:
        """Draw a frame with the button down, before which the lights follow. Return False if no spot is dragged."""
        if not isinstance(self.edit, Ask):
            return False
        self.gizmos.interactor.Render()  # as VTK's widgets do; a page draws fewer frames than there are moves
        return True

    def _before_frame(self) -> None:
        """Let the lights follow the cursor before a frame, and not at each move: a page sends more moves."""
        if isinstance(self.edit, Ask) and self.edit.is_possible:
            self.edit.move()

    def _answered(self) -> bool:
        """End the drag of a spot at the release of the button, as one undo step. Return False if no spot is dragged."""
        if not isinstance(self.edit, Ask):
            return False
        self.settle()
        self.gizmos.render()
        return True

    def _resized(self, factor: float) -> bool:
        """Multiply the size of the spot by `factor`.

        Return False if a drag does not ask for light; the wheel then zooms.
        """
        gizmos = self.gizmos
        if not gizmos.asks or not gizmos.is_pointed_at:
            return False
        if isinstance(self.edit, Ask):
            return True  # the spot of a drag keeps its size
        gizmos.resize_spot(gizmos.spot_size * factor)
        gizmos.notice = f"spot: {gizmos.spot_size:.2g} of the scene's size"
        gizmos.render()
        return True

    # -- start and end of an edit

    def _begin(self, edit: Drag | Entry | Ask | None) -> None:
        self.edit = edit
        self.gizmos.lit.uses_preview_rays = isinstance(edit, Drag)
        if edit is not None:
            if not isinstance(edit, Ask):
                self.grabbed_last = edit.handle
            self.gizmos.history.begin(self)
        else:
            self.gizmos.history.end(self)

    def settle(self) -> None:
        """End and keep the edit in progress, and record it as one undo step."""
        self._end(taken=True)

    def give_up(self) -> None:
        """Cancel the edit in progress, and restore the light."""
        self._end(taken=False)
        self.gizmos.render()

    def _end(self, *, taken: bool) -> None:
        """End the edit in progress. If `taken`, record it as one undo step; otherwise restore the light."""
        if taken:
            self._before_frame()
        edit = self.edit
        self._begin(None)
        if edit is not None and edit.is_possible:
            if taken:
                self.gizmos.history.record(self.gizmos.lights, edit.before)
            else:
                edit.put_back()

    # -- the keyboard

    def _key_pressed(self) -> bool:
        """Handle a key press. Return True if the key belongs to a value that is being typed.

        trame's remote area reports letters twice, for the browser's `keydown` and `keypress`. A second report is
        ignored, until the press ends with its `CharEvent` or with the key's release.
        """
        gizmos, key = self.gizmos, self.gizmos.interactor.GetKeySym()
        character = _CHARACTER_OF.get(key, key)
        character = character if character in _CHARACTERS else ""
        drag = self.edit if isinstance(self.edit, Drag) else None
        if drag is not None and character.strip() and drag.is_possible and drag.handle != HIGHLIGHT:
            drag.put_back()  # typing replaces the drag
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
        elif key == "Escape" and gizmos.awaits_click is not None:
            gizmos.awaits_click, gizmos.notice = None, ""
            gizmos.render()
        elif key == "Escape" and gizmos.asks:
            commands.toggle_asking(gizmos)
            gizmos.render()
        elif gizmos.is_pointed_at and not isinstance(gizmos.history.running, Interaction):  # no edit in another subplot
            control, gizmo = bool(gizmos.interactor.GetControlKey()), gizmos.selected
            if key in commands.ENTER and not control and gizmo is not None:
                # type a value for the handle grabbed last, if it belongs to the selected light
                names = [*gizmo.handles, INTENSITY]
                gizmos.history.settle()
                self._begin(Entry(gizmos, gizmo, self.grabbed_last if self.grabbed_last in names else names[0]))
                gizmos.render()
            elif commands.run(gizmos, key, control=control):
                gizmos.render()
        return is_typed

    def _press_ended(self) -> bool:
        """Handle the end of a key press. Return True while a value is typed, so that no other observer reacts."""
        self._key_down = None
        return isinstance(self.edit, Entry)

    def _type(self, entry: Entry, key: str, character: str) -> None:
        if not entry.is_possible or key == "Escape":
            self._end(taken=False)
        elif key in commands.ENTER or key == "Tab":
            if entry.error:  # keep the entry open, with its error message
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
