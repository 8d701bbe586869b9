"""One light's gizmo."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from pvphong.base.types import Float64Array, Vector
from pvphong.optics.light import Light
from pvphong.scene.viewer import Viewer
from pvphong.studio.gizmos.drag_start import Scenery, vector
from pvphong.studio.gizmos.drawing import DARK, LIGHT, Drawing, hue
from pvphong.studio.gizmos.grip import Grip
from pvphong.studio.gizmos.handles import handles
from pvphong.studio.gizmos.looks import draw
from pvphong.studio.gizmos.shape import ORIGIN, around_middle, held, is_movable, origin
from pvphong.studio.gizmos.status import marks
from pvphong.studio.gizmos.view import View
from pvphong.studio.rig import LightHandle

HIGHLIGHT = "highlight"


class GizmoOwner(Protocol):
    """What a gizmo asks of whoever has it: the board."""

    @property
    def view(self) -> View:
        """The pane as it is now."""

    @property
    def extent(self) -> tuple[Vector, float]:
        """Middle and size of what is drawn."""

    def new_grip(self, name: str, gizmo: Gizmo) -> Grip:
        """A handle that can be grabbed."""

    def highlight_of(self, gizmo: Gizmo) -> Vector | None:
        """Where the gizmo's light has its highlight."""

    def grabbed(self, gizmo: Gizmo, grip: Grip) -> None:
        """A handle of the gizmo was grabbed."""

    def dragged(self) -> None:
        """The cursor moved with the button down."""

    def dropped(self) -> None:
        """The button was let go."""


class Gizmo:
    """What stands for a light in the window, to be dragged.

    Parameters
    ----------
    handle : LightHandle
        The light.
    board : GizmoOwner
        Where it is.
    """

    def __init__(self, handle: LightHandle, board: GizmoOwner) -> None:
        self.handle = handle
        self.first = self.light_for(board.view.viewer)
        self.is_selected = False
        self._board = board
        self._grips: dict[str, Grip] = {}
        self._held: tuple[Any, Scenery] | None = None

    def __repr__(self) -> str:
        return f"Gizmo({self.light!r})"

    @property
    def light(self) -> Light:
        """The light's current value, in its own frame."""
        return self.light_for(self._board.view.viewer)

    @property
    def handles(self) -> dict[str, Vector]:
        """Name of each handle that the light has → where it is in the world.

        A directional light has "target" and, at its icon, "origin"; a point light "position", and "radius" if it
        weakens; a spot light "position", "target" and "cone"; an environment "rotation"; any other those of its
        fields' roles. A headlight has none: it is where the viewer is.
        """
        return {name: vector(point) for name, point in self.points(self._board.view).items()}

    @property
    def highlight(self) -> Vector | None:
        """Where its highlight is on the lit meshes, if it is selected and throws one: that can be dragged too."""
        return self._board.highlight_of(self) if self.is_selected else None

    @property
    def hovered(self) -> str | None:
        """The handle under the cursor."""
        return next((name for name, grip in self._grips.items() if grip.is_hovered), None)

    def light_for(self, viewer: Viewer) -> Light:
        """The light's value for a viewer."""
        return self.handle.light(viewer)

    def scenery(self, view: View) -> Scenery:
        """The scene around it; the icon of a light without a place stands in front of it, or where it was left."""
        known = self._known(view)
        return self._held[1] if self._held is not None and self._held[0] == known else around_middle(*known[:2])

    def hold(self, handle: str, view: View) -> None:
        """Let a light without a place turn around the end that is not grabbed, for as long as the scene stays."""
        world = self.light_for(view.viewer).in_world(view.viewer)
        self._held = self._known(view), held(world, handle, self.scenery(view))

    def _known(self, view: View) -> tuple[Vector, float, Viewer | None]:
        """Middle and size of the scene, and the eye if the light goes along with it."""
        return *self._board.extent, view.viewer if self.light_for(view.viewer).frame == "camera" else None

    def points(self, view: View, highlight: Vector | None = None) -> dict[str, Float64Array]:
        """The handles' positions, as arrays; with that of a highlight, if there is one."""
        light = self.light_for(view.viewer)
        if light.frame == "headlight":
            return {}
        found = handles(light.in_world(view.viewer), self.scenery(view), view)
        return found if highlight is None else found | {HIGHLIGHT: np.array(highlight)}

    def set_grips(self, view: View, highlight: Vector | None, shown: bool) -> list[tuple[Grip, Float64Array]]:
        """Bring the widgets to where the handles are; those that can be grabbed, and where they are in pixels."""
        points = self.points(view, highlight)
        for name in points:
            if name not in self._grips:
                self._grips[name] = self._board.new_grip(name, self)
        there = {name: point for name, point in points.items() if shown and view.is_ahead(point)}
        for name, grip in self._grips.items():
            grip.place(there.get(name))
        return [(self._grips[name], view.project(point)) for name, point in there.items()]

    def draw(self, drawing: Drawing, highlight: Vector | None, active: str | None, *, is_alone: bool) -> None:
        """Add it to a drawing; `active` is the handle that is hovered or dragged."""
        light = self.light_for(drawing.view.viewer)
        if light.frame == "headlight":
            return
        world = light.in_world(drawing.view.viewer)
        drawing.color, drawing.edge = hue(world), DARK if world.on else LIGHT
        scenery = self.scenery(drawing.view)
        draw(drawing, world, scenery, self.is_selected or active is not None)
        if is_movable(world):
            for mark in marks(world, is_alone=is_alone):
                drawing.label(origin(world, scenery), mark, 18.0)
        for name, point in self.points(drawing.view).items():
            if name not in ("position", ORIGIN) or active == name:  # an icon is there
                drawing.handle(point, hovered=name == active)
        if highlight is not None:
            drawing.ring(np.array(highlight), hovered=active == HIGHLIGHT)

    def grabbed(self, grip: Grip) -> None:
        """A grip was grabbed."""
        self._board.grabbed(self, grip)

    def dragged(self, grip: Grip) -> None:  # noqa: ARG002 there is one drag at a time
        """A grip was moved."""
        self._board.dragged()

    def dropped(self, grip: Grip) -> None:  # noqa: ARG002 there is one drag at a time
        """A grip was let go."""
        self._board.dropped()

    def retire(self) -> list[Grip]:
        """Take its grips away; they are to be released when none of them deals with an event."""
        grips = list(self._grips.values())
        self._grips.clear()
        for grip in grips:
            grip.retire()
        return grips
