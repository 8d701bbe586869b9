"""Width of the view: a narrow view shows the same width of the model as a wide view."""

from __future__ import annotations

import math
import weakref
from dataclasses import replace
from typing import Any

import pyvista as pv

from pvphong.scene.viewer import Viewer

_ASPECT = 4.0 / 3.0  # of the picture into which `default_scene` frames a mesh
_NARROWEST = 0.25  # of that aspect

_BEFORE_LIT = 2.0  # observer priority: before the colours are computed


class Framing:
    """Widens the angle of a camera while its view is narrower than 4:3, so that the model is not cropped.

    VTK's angle is vertical. With the same angle, a view that is narrower than high would show only the middle of a
    model that a wide view shows completely.

    Parameters
    ----------
    renderer : pyvista.Renderer
        The renderer of the view.
    """

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._width = self._present_width()
        framing = weakref.ref(self)

        def before_frame(_renderer: Any, _event: str) -> None:
            if (alive := framing()) is not None:
                alive._update()

        self._tag = renderer.AddObserver("StartEvent", before_frame, _BEFORE_LIT)

    def _present_width(self) -> float:
        """Return the ratio of width to height of the view, as a fraction of 4:3, at most 1."""
        width, height = self._renderer.GetSize()
        return min(max(width / height / _ASPECT, _NARROWEST), 1.0) if width and height else 1.0

    def _update(self) -> None:
        width = self._present_width()
        if width != self._width:
            camera = self._renderer.camera
            viewer = _widened(Viewer.from_camera(camera), self._width / width)
            camera.SetViewAngle(viewer.view_angle)
            camera.SetParallelScale(viewer.parallel_scale)
            self._width = width

    def in_a_wide_view(self, viewer: Viewer) -> Viewer:
        """Return the viewer for the same picture in a view of 4:3 or wider.

        `viewer` is the viewer of the present camera.
        """
        return _widened(viewer, self._width) if self._width < 1.0 else viewer

    def release(self) -> None:
        """Detach from the renderer, and undo the change of the angle."""
        self._renderer.RemoveObserver(self._tag)
        camera = self._renderer.camera
        viewer = self.in_a_wide_view(Viewer.from_camera(camera))
        camera.SetViewAngle(viewer.view_angle)
        camera.SetParallelScale(viewer.parallel_scale)


def _widened(viewer: Viewer, factor: float) -> Viewer:
    """Return a viewer that sees `factor` times as much height and width of the plane through its focal point."""
    slope = factor * math.tan(math.radians(viewer.view_angle) / 2.0)
    return replace(
        viewer,
        view_angle=math.degrees(2.0 * math.atan(slope)),
        parallel_scale=factor * viewer.parallel_scale,
    )
