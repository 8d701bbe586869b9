"""What keys and the mouse act on: the gizmos of one renderer, as `board.Board` has them."""

from __future__ import annotations

from typing import Protocol

from pvphong.base.types import Vector
from pvphong.studio.gizmos.gizmo import Gizmo
from pvphong.studio.gizmos.highlight import SurfacePoint
from pvphong.studio.gizmos.history import History
from pvphong.studio.gizmos.options import Options
from pvphong.studio.gizmos.surfaces import Surfaces
from pvphong.studio.gizmos.view import View
from pvphong.studio.materials import Materials
from pvphong.studio.rig import LightHandle, Rig


class Surroundings(Protocol):
    """The gizmos of one renderer and what they stand in."""

    rig: Rig
    history: History
    materials: Materials
    options: Options
    hidden: bool
    helping: bool
    notice: str

    @property
    def gizmos(self) -> tuple[Gizmo, ...]:
        """A gizmo for each light."""

    @property
    def selected(self) -> Gizmo | None:
        """The gizmo that keys act on."""

    @property
    def view(self) -> View:
        """The pane as it is now."""

    @property
    def extent(self) -> tuple[Vector, float]:
        """Middle and half the diagonal of what is drawn."""

    @property
    def cursor(self) -> tuple[float, float]:
        """Where the pointer is, in pixels of the window."""

    @property
    def surfaces(self) -> Surfaces:
        """The lit meshes as they are now, to be asked what is under a cursor."""

    @property
    def is_here(self) -> bool:
        """Whether the pointer is in the pane."""

    def select(self, chosen: Gizmo | None) -> None:
        """Select a gizmo, or none."""

    def follow(self, handle: LightHandle) -> None:
        """Give a light that was just added a gizmo, and select it."""

    def held_highlight(self, gizmo: Gizmo, view: View) -> SurfacePoint | None:
        """Where a gizmo's light has its highlight."""

    def release_retired(self) -> None:
        """Let go of the widgets of lights that are gone; not while one of them deals with an event."""

    def update(self) -> None:
        """Bring widgets and looks to where lights, camera and scene are now."""

    def render(self) -> None:
        """Draw a frame."""
