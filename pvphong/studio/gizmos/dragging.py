"""A running drag: from the cursor by way of `handles.py`, which knows each role's drag, to the light in the window."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pvphong.optics.light import Light
from pvphong.scene.viewer import Viewer
from pvphong.studio.gizmos.drag_start import Cursor, DragStart
from pvphong.studio.gizmos.gizmo import HIGHLIGHT, Gizmo
from pvphong.studio.gizmos.handles import dragged
from pvphong.studio.gizmos.highlight import SurfacePoint, mirrored_to_eye
from pvphong.studio.gizmos.readout import readout
from pvphong.studio.gizmos.surfaces import Surfaces
from pvphong.studio.rig import Rig, RigState


@dataclass
class Drag:
    """Who is dragged, and everything as it was before.

    Parameters
    ----------
    gizmo : Gizmo
        Whose handle was grabbed.
    start : DragStart
        How it was grabbed.
    rig : Rig
        All lights.
    before : RigState
        What they were.
    light : Light
        What this one was, in its own frame.
    held : SurfacePoint, optional
        Where the light's highlight was.
    surfaces : Surfaces, optional
        What it can be dragged on, if it is the highlight that was grabbed.
    over : SurfacePoint, optional
        Where on them the highlight has been dragged to.
    """

    gizmo: Gizmo
    start: DragStart
    rig: Rig
    before: RigState
    light: Light
    held: SurfacePoint | None
    surfaces: Surfaces | None
    over: SurfacePoint | None = None

    @property
    def is_possible(self) -> bool:
        """Whether the light is still there."""
        return self.gizmo.handle in self.rig.handles

    def move(self, at: Cursor) -> str:
        """Make the light what the cursor asks for; gives the numbers to be shown."""
        start, viewer = self.start, self.start.view.viewer
        light = self._mirrored(at) if start.handle == HIGHLIGHT else dragged(start, at)
        if light == start.light:
            self.put_back()
        else:
            self.gizmo.handle.set(in_its_frame(light, start.light, self.light, viewer), viewer)
        return readout(light, start.handle, start.scenery)

    def _mirrored(self, at: Cursor) -> Light:
        x, y = self.start.picture(at).tolist()
        target = None if self.surfaces is None else self.surfaces.pick((x, y))
        if self.held is None or target is None:  # off the surface: it waits
            viewer = self.start.view.viewer
            return self.gizmo.light_for(viewer).in_world(viewer)
        self.over = target
        return mirrored_to_eye(self.start.light, self.start.view, self.held, target)

    def put_back(self) -> None:
        """Make all lights what they were, to the bit."""
        self.rig.turn(self.rig.state, self.before)


def in_its_frame(changed: Light, before: Light, own: Light, viewer: Viewer) -> Light:
    """A light that was changed in the world, in its own frame; what has not changed keeps its bits.

    Parameters
    ----------
    changed, before : Light
        As it is to be and as it was, both in the world.
    own : Light
        As it was, in its own frame.
    viewer : Viewer
        By which the two are the same.
    """
    moved = changed.in_frame(own.frame, viewer)
    same = (field for field in changed.roles if getattr(changed, field) == getattr(before, field))
    return replace(moved, **{field: getattr(own, field) for field in same})
