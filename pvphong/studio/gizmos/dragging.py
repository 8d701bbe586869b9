"""A running drag: what the light becomes, and how it is put back."""

from __future__ import annotations

from dataclasses import dataclass

from pvphong.optics.lights import Light
from pvphong.studio.gizmos.gizmo import HIGHLIGHT, Gizmo, in_frame
from pvphong.studio.gizmos.highlight import Spot, mirrored_to_eye
from pvphong.studio.gizmos.kinds import kind_of
from pvphong.studio.gizmos.press import Cursor, Press
from pvphong.studio.gizmos.readout import readout
from pvphong.studio.gizmos.surfaces import Surfaces
from pvphong.studio.rig import Rig, RigState


@dataclass(frozen=True)
class Drag:
    """Who is dragged, and everything as it was before.

    Parameters
    ----------
    gizmo : Gizmo
        Whose handle was grabbed.
    press : Press
        How it was grabbed.
    rig : Rig
        All lights.
    before : RigState
        What they were.
    held : Spot, optional
        Where the light's highlight was.
    surfaces : Surfaces, optional
        What it can be dragged on, if it is the highlight that was grabbed.
    """

    gizmo: Gizmo
    press: Press
    rig: Rig
    before: RigState
    held: Spot | None
    surfaces: Surfaces | None

    @property
    def is_possible(self) -> bool:
        """Whether the light is still there."""
        return self.gizmo.handle in self.rig.handles

    def move(self, at: Cursor) -> str:
        """Make the light what the cursor asks for; gives the numbers to be shown."""
        press, viewer = self.press, self.press.view.viewer
        light = self._mirrored(at) if press.handle == HIGHLIGHT else kind_of(press.light).drag(press, at)
        if light == press.light:
            self.put_back()
        else:
            frame = self.gizmo.light_for(viewer).frame
            self.gizmo.handle.set(in_frame(light, frame, viewer), viewer)
        return readout(light, press.handle, press.place)

    def _mirrored(self, at: Cursor) -> Light:
        x, y = self.press.picture(at).tolist()
        target = None if self.surfaces is None else self.surfaces.pick((x, y))
        if self.held is None or target is None:  # off the surface: it waits
            viewer = self.press.view.viewer
            return self.gizmo.light_for(viewer).in_world(viewer)
        return mirrored_to_eye(self.press.light, self.press.view, self.held, target)

    def put_back(self) -> None:
        """Make all lights what they were, to the bit."""
        self.rig.turn(self.rig.state, self.before)
