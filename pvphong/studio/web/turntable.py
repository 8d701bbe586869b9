"""A turntable: a GIF for which the camera goes once around the meshes, drawn in the background."""

from __future__ import annotations

import asyncio
import importlib.util
import math
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import pyvista as pv
from aiohttp import web

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.meshes.pictures import aim, drawing_window, preferring
from pvphong.scene.viewer import Viewer
from pvphong.studio.web.downloads import Downloads
from pvphong.studio.web.fields import number_in

_SECONDS = 4.0
_WIDEST = 720  # pixels


def pictures_in(given: Any) -> int:
    """Return the number of pictures of a turntable, from 8 to 120; `given` is a number or a text."""
    number = check.number("pictures", number_in("pictures", given), at_least=8.0, at_most=120.0)
    return int(number) if number.is_integer() else check.refuse("pictures", given, "a whole number")


def around(viewer: Viewer, middle: Any, turn: float) -> Viewer:
    """Return a viewer turned about the vertical line through a point.

    Parameters
    ----------
    viewer : Viewer
        The viewer at the start. The vertical is the coordinate axis nearest to the viewer's up vector.
    middle : array_like
        The point, shape (3,).
    turn : float
        The angle in radians, counterclockwise as seen from above.
    """
    up, center = np.array(viewer.up), np.array(middle)
    axis = np.zeros(3)
    longest = int(np.abs(up).argmax())
    axis[longest] = math.copysign(1.0, up[longest])

    def turned(vector: Float64Array) -> Float64Array:
        along = (axis @ vector) * axis
        return np.asarray(along + math.cos(turn) * (vector - along) + math.sin(turn) * np.cross(axis, vector))

    places = (center + turned(np.subtract(place, center)) for place in (viewer.position, viewer.focal_point))
    position, focal_point = (tuple(place.tolist()) for place in places)
    return replace(viewer, position=position, focal_point=focal_point, up=tuple(turned(up).tolist()))


class Turntable:
    """Draws turntables, and stores the last one.

    Parameters
    ----------
    changed : callable
        Called when the progress or the result has changed.
    """

    def __init__(self, changed: Callable[[], None]) -> None:
        self.part: float | None = None
        """Progress from 0 to 1; None if nothing is drawn."""
        self.gif = b""
        """The last turntable; empty if there is none."""
        self.count = 0
        """Number of turntables that were drawn."""
        self._changed = changed
        self._task: asyncio.Task[None] | None = None
        self._is_released = False

    def shown(self, stem: str) -> dict[str, Any]:
        """Return the page's state: the progress in per cent, and the address of the last turntable.

        `stem` is the beginning of the file name in the address.
        """
        address = f"turntable/{quote(stem)}-{self.count}.gif" if self.gif else ""
        return {"turntable": None if self.part is None else round(100.0 * self.part), "turntable_file": address}

    async def answer(self, _request: web.Request) -> web.StreamResponse:
        """Answer an HTTP request for the last turntable."""
        return web.Response(body=self.gif, content_type="image/gif") if self.gif else web.Response(status=404)

    def start(self, downloads: Downloads, pictures: int, done: Callable[[str], None]) -> None:
        """Start to draw a turntable. The camera begins at the present view, and keeps its height and distance.

        Parameters
        ----------
        downloads : Downloads
            The meshes with their scene. They also define the pictures' size, background and display transform; the GIF
            is at most 720 pixels wide.
        pictures : int
            Number of pictures. The whole turn lasts 4 seconds.
        done : callable
            Called with a message at the end.

        Raises
        ------
        ValueError
            If there is no mesh, a turntable is being drawn, or the extra `gif` is not installed.
        """
        if importlib.util.find_spec("imageio") is None:
            check.refuse(
                "turntable", "a missing package", "used with its package installed", "Run: pip install imageio"
            )
        if not downloads.meshes:
            check.refuse("mesh", "none", "open", "Open a mesh first.")
        if self._task is not None and not self._task.done():
            check.refuse("turntable", "a second one", "started after the first has ended", "Cancel the first one.")
        self.part = 0.0
        self._task = asyncio.get_running_loop().create_task(self._draw(downloads, pictures, done))

    def cancel(self) -> None:
        """Cancel the turntable that is being drawn."""
        if self._task is not None:
            self._task.cancel()

    def release(self) -> None:
        """Cancel the turntable that is being drawn, without a message."""
        self._is_released = True
        self.cancel()

    async def _draw(self, downloads: Downloads, pictures: int, done: Callable[[str], None]) -> None:
        said = ""
        try:
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "turntable.gif"
                await self._write(downloads, pictures, path)
                self.gif = path.read_bytes()
            self.count += 1
        except asyncio.CancelledError:
            said = "The turntable is cancelled."
        except Exception as error:  # else an error in a task is silent, and the page would wait for ever
            said = str(error) if isinstance(error, ValueError) else f"The turntable could not be drawn: {error}"
        self.part = None
        if not self._is_released:
            self._changed()
            done(said)

    async def _write(self, downloads: Downloads, pictures: int, path: Path) -> None:
        """Draw the pictures in a separate plotter, and write them to `path`.

        Lighting is computed in another thread, so that the page stays responsive.
        """
        scene, (width, height) = downloads.scene, downloads.picture.size
        viewer = scene.viewer
        assert viewer is not None, "a view has a viewer"
        scale = min(1.0, _WIDEST / width)
        with preferring(drawing_window()):
            plotter = pv.Plotter(
                off_screen=True,
                window_size=[max(1, round(scale * width)), max(1, round(scale * height))],
                lighting="none",
            )
        try:
            phong = plotter.phong
            for light in scene.lights:
                phong.add_light(light)
            phong.display = downloads.picture.display
            background = downloads.picture.background
            plotter.set_background("white" if background == "transparent" else background)
            stage, boxes = downloads.stage, []
            for mesh in (*downloads.meshes.values(), *(() if stage is None else (stage,))):
                hides_nothing = {} if mesh.stage is None else {"culling": "back"}  # the wall of a backdrop, from behind
                how: dict[str, Any] = {"feature_angle": mesh.feature_angle, "casts_shadows": mesh.casts_shadows}
                actor = phong.add_mesh(mesh.mesh, mesh.material, **how, **hides_nothing)
                actor.user_matrix = np.eye(4) if mesh.matrix is None else mesh.matrix
                if mesh.stage is None:
                    boxes.append(actor.bounds)
            phong.light_model = scene.light_model  # last: with it, lighting may take long, and leaves this thread
            bounds = np.array(boxes)
            middle = 0.5 * (bounds[:, ::2].min(axis=0) + bounds[:, 1::2].max(axis=0))
            plotter.enable_anti_aliasing("ssaa")
            plotter.open_gif(path, fps=pictures / _SECONDS)
            for number in range(pictures):
                aim(plotter, around(viewer, middle, 2.0 * math.pi * number / pictures))
                plotter.renderer.ResetCameraClippingRange()
                await _finished(phong._subplot.lit.refresh)
                plotter.write_frame()
                self.part = (number + 1) / pictures
                self._changed()
        finally:
            plotter.close()


async def _finished(work: Callable[[], Any]) -> None:
    """Run `work` in another thread and wait for it.

    If the task is cancelled meanwhile, also more than once, still wait until `work` has ended, because it uses the
    plotter.
    """
    doing, cancelled = asyncio.ensure_future(asyncio.to_thread(work)), None
    while not doing.done():
        try:
            await asyncio.wait([doing])
        except asyncio.CancelledError as error:
            cancelled = error
    if cancelled is not None:
        raise cancelled
    await doing
