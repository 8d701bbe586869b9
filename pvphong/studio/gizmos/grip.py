"""A handle that can be grabbed: VTK's handle widget, which finds it under the cursor and follows the mouse."""

from __future__ import annotations

import weakref
from typing import Any, Protocol

from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkInteractionWidgets import vtkHandleWidget, vtkPointHandleRepresentation2D

from pvphong.base.types import Float64Array

TOLERANCE = 12
"""How near to a handle the cursor must be, in pixels: the dot that is drawn is half as wide."""


class Grabbing(Protocol):
    """Who is told when a grip is grabbed, moved and let go."""

    def grabbed(self, grip: Grip) -> None:
        """The button went down on it."""

    def dragged(self, grip: Grip) -> None:
        """The cursor moved with the button down."""

    def dropped(self, grip: Grip) -> None:
        """The button was let go."""


class Grip:
    """One handle in one renderer.

    It draws nothing: its looks are part of the gizmo's drawing. It is an overlay in pixels, so it is not part
    of the scene's bounds, cannot be picked as an object, and keeps its size in every projection.

    Parameters
    ----------
    name : str
        Of the handle.
    renderer, interactor
        VTK's.
    owner : Grabbing
        Held weakly.
    """

    def __init__(self, name: str, renderer: Any, interactor: Any, owner: Grabbing) -> None:
        self.name = name
        self._looks = vtkPointHandleRepresentation2D()
        self._looks.SetCursorShape(_nothing())
        self._looks.SetTolerance(TOLERANCE)
        self._looks.UseBoundsOff()
        self._looks.PickableOff()
        self._widget = vtkHandleWidget()
        self._widget.SetInteractor(interactor)
        self._widget.SetDefaultRenderer(renderer)
        self._widget.SetCurrentRenderer(renderer)
        self._widget.SetRepresentation(self._looks)
        self._widget.KeyPressActivationOff()
        self._widget.EnableAxisConstraintOff()
        self._widget.SetEnabled(True)
        self._tags = [self._tell(event, what, owner) for event, what in _EVENTS.items()]

    def _tell(self, event: str, what: str, owner: Grabbing) -> int:
        listener, grip = weakref.ref(owner), weakref.ref(self)

        def happened(_widget: Any, _event: str) -> None:
            alive, this = listener(), grip()
            if alive is not None and this is not None:
                getattr(alive, what)(this)

        return int(self._widget.AddObserver(event, happened))

    def place(self, position: Float64Array | None) -> None:
        """Put it somewhere in the world; None takes it away, when it is let go."""
        self._widget.SetProcessEvents(position is not None or self._is_held)
        if position is not None:
            self._looks.SetWorldPosition(position.tolist())
            self._looks.BuildRepresentation()  # else it is grabbed where it was when the last frame was drawn

    def limit(self, reach: float) -> None:
        """Grab it from no farther than this many pixels, so that another one close by can be grabbed too."""
        self._looks.SetTolerance(int(min(max(reach, 1.0), TOLERANCE)))

    def look(self, cursor: tuple[int, int]) -> None:
        """See whether the cursor is on it: the handle may have moved, and the cursor not."""
        if not self._is_held:
            self._looks.ComputeInteractionState(*cursor, 0)

    @property
    def _is_held(self) -> bool:
        return bool(self._widget.GetWidgetState() == vtkHandleWidget.Active)

    @property
    def is_hovered(self) -> bool:
        """Whether it can be grabbed where the cursor is."""
        return bool(self._widget.GetProcessEvents() and self._looks.GetInteractionState())

    def retire(self) -> None:
        """Take it away for good; a drag of it ends here."""
        self._widget.SetProcessEvents(False)
        if self._is_held:
            self._widget.ReleaseFocus()

    def release(self) -> None:
        """Let go of renderer and interactor; not to be called while the widget itself deals with an event."""
        for tag in self._tags:
            self._widget.RemoveObserver(tag)
        self._widget.SetEnabled(False)
        self._widget.SetInteractor(None)
        self._widget.SetCurrentRenderer(None)
        self._widget.SetDefaultRenderer(None)


_EVENTS = {"StartInteractionEvent": "grabbed", "InteractionEvent": "dragged", "EndInteractionEvent": "dropped"}


def _nothing() -> Any:
    shape = vtkPolyData()
    shape.SetPoints(vtkPoints())
    return shape
