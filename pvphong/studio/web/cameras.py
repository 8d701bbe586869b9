"""Views of the camera on the page: front, top, side and isometric views, saved views, and the axis cross."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.types import Vector
from pvphong.meshes.pictures import aim
from pvphong.scene.viewer import Viewer
from pvphong.studio.lit_mesh import LitMesh
from pvphong.studio.subplot import Subplot

VIEWS: Mapping[str, tuple[Vector, Vector]] = {
    "front": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    "back": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "left": ((-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "right": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "top": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    "isometric": ((1.0, 1.0, 1.0), (0.0, 0.0, 1.0)),
}
"""Name of a view → direction to the eye, and up. Front, right, top and isometric are PyVista's `view_xz`, `view_yz`,
`view_xy` and `view_isometric`."""

_MOST_KEPT = 20


class Cameras:
    """The camera of the view. It is not part of the undo history.

    Parameters
    ----------
    subplot : Subplot
        The subplot with the camera.
    """

    def __init__(self, subplot: Subplot) -> None:
        self._subplot = subplot
        self._kept: dict[int, Viewer] = {}
        self._number = 0
        self._has_axes = False

    @property
    def triggers(self) -> dict[str, Callable[..., Any]]:
        """Functions that the page can trigger, by name."""
        acts = self.look, self.fit, self.keep_view, self.look_kept, self.forget_view, self.show_axes
        return {act.__name__: act for act in acts}

    def shown(self) -> dict[str, Any]:
        """Return the page's state: the numbers of the saved views, and a flag for the axis cross."""
        return {"kept_views": list(self._kept), "axes": self._has_axes}

    def look(self, name: str) -> None:
        """Show the meshes from one side; the name is one of `VIEWS`."""
        direction, up = VIEWS[check.choice("name", name, VIEWS)]
        bounds = np.array([mesh.actor.bounds for mesh in self._subplot.lit.subjects if mesh.actor is not None])
        if not len(bounds):
            check.refuse("mesh", "none", "open", "Open a mesh first.")
        middle = 0.5 * (bounds[:, ::2].min(axis=0) + bounds[:, 1::2].max(axis=0))
        renderer = self._subplot.renderer
        renderer.camera_position = [tuple(middle + direction), tuple(middle), up]
        self.fit()

    def fit(self) -> None:
        """Move the camera so that the meshes fill the view; a stage does not count."""
        renderer = self._subplot.renderer
        with self._subplot.lit.without_bounds_of_stage():
            renderer.reset_camera(render=False)  # each trigger ends with a frame
        renderer.ResetCameraClippingRange()

    def sees(self, meshes: Sequence[LitMesh]) -> bool:
        """Return True if the boxes around meshes are in the view, whatever may hide them."""
        renderer, camera = self._subplot.renderer, self._subplot.renderer.camera
        matrix = camera.GetCompositeProjectionTransformMatrix(renderer.GetTiledAspectRatio(), -1.0, 1.0)
        boxes = [np.reshape(mesh.actor.bounds, (3, 2)) for mesh in meshes if mesh.actor is not None]
        corners = np.array([[*corner, 1.0] for box in boxes for corner in itertools.product(*box)])
        x, y, _, depth = np.array(pv.array_from_vtkmatrix(matrix)) @ corners.T
        return bool((np.maximum(abs(x), abs(y)) <= depth).all())

    def keep_view(self) -> str:
        """Save the present view. Return a message if the limit is reached, else ""."""
        if len(self._kept) == _MOST_KEPT:
            return f"Only {_MOST_KEPT} views can be kept. Remove one first."
        self._number += 1
        self._kept[self._number] = self._subplot.lights.viewer
        return ""

    def look_kept(self, number: Any) -> None:
        """Show the meshes as in the saved view `number`.

        The camera's angle stays, because it fits the width of the window.
        """
        renderer = self._subplot.renderer
        aim(renderer, replace(self._kept[self._found(number)], view_angle=renderer.camera.GetViewAngle()))
        renderer.ResetCameraClippingRange()

    def forget_view(self, number: Any) -> None:
        """Delete the saved view `number`."""
        del self._kept[self._found(number)]

    def _found(self, number: Any) -> int:
        return number if number in self._kept else check.refuse("view", number, "the number of a view that is kept")

    def show_axes(self, on: Any) -> None:
        """Show an axis cross in the lower left corner of the view, or hide it. Downloaded pictures have no cross."""
        self._has_axes = check.flag("on", on)
        renderer = self._subplot.renderer
        if self._has_axes:
            renderer.add_axes(interactive=False)
        elif renderer.axes_enabled:
            renderer.hide_axes()
