"""Snapshots A and B of the document, each with its picture, to be compared and restored."""

from __future__ import annotations

import io
import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from PIL import Image
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

from pvphong.base import check
from pvphong.meshes.pictures import aim
from pvphong.scene.viewer import Viewer
from pvphong.studio.subplot import Subplot
from pvphong.studio.web.document import Document, DocumentState

NAMES = ("A", "B")
NOW = "now"
"""Name of the live view in a comparison."""

_QUALITY = 92  # of JPEG pictures


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A stored state of the document.

    Parameters
    ----------
    number : int
        Number of the snapshot, unique in a studio.
    state : DocumentState
        Lights, materials, light model, display and the file that is shown.
    viewer : Viewer
        The camera.
    picture : bytes
        The view without gizmos, as JPEG.
    about : str
        Short description: the lights that were on.
    """

    number: int
    state: DocumentState
    viewer: Viewer
    picture: bytes
    about: str


class Snapshots:
    """The snapshots of a studio.

    Parameters
    ----------
    document : Document
        The values that are stored and restored.
    subplot : Subplot
        The subplot, with gizmos.
    """

    def __init__(self, document: Document, subplot: Subplot) -> None:
        self._document, self._subplot = document, subplot
        self._kept: dict[str, Snapshot] = {}
        self._numbers = itertools.count(1)

    # -- triggers of the page

    def keep(self, name: Any = None) -> None:
        """Store the present state as snapshot `name`, "A" or "B".

        Without a name, use a free name, or else that of the older snapshot.
        """
        if name is None:
            name = min(NAMES, key=lambda each: self._kept[each].number if each in self._kept else 0)
        check.choice("name", name, NAMES)
        self._document.history.settle()
        lights = self._subplot.lights
        shining = [light.name or type(light).__name__ for light in lights.values if light.on]
        about = ", ".join(shining) or "no light"
        kept = Snapshot(next(self._numbers), self._document.state, lights.viewer, self._picture(), about)
        self._kept[name] = kept

    def restore(self, name: Any) -> None:
        """Restore the snapshot `name`, as one undo step. The camera stays."""
        self._document.restore(self._of(name).state)

    def look_from(self, name: Any) -> None:
        """Move the camera to its position when the snapshot `name` was stored."""
        aim(self._subplot.renderer, self._of(name).viewer)
        self._subplot.renderer.ResetCameraClippingRange()

    def forget(self, name: Any) -> None:
        """Delete the snapshot `name`."""
        del self._kept[check.choice("name", name, self._kept)]

    def _of(self, name: Any) -> Snapshot:
        return self._kept[check.choice("name", name, self._kept)]

    # -- values for the page

    def shown(self) -> dict[str, Any]:
        """Return the page's state: the snapshots, and the pairs that can be compared, such as "A | now"."""
        viewer, names = self._subplot.lights.viewer, [name for name in NAMES if name in self._kept]
        listed = [
            {
                "name": name,
                "url": f"snapshot/{self._kept[name].number}.jpg",
                "about": self._kept[name].about,
                "moved": self._kept[name].viewer != viewer,
            }
            for name in names
        ]
        pairs = ["A | B"] * (len(names) == len(NAMES)) + [f"{name} | {NOW}" for name in names]
        return {"list": listed, "pairs": pairs, "urls": {each["name"]: each["url"] for each in listed}}

    def picture(self, number: str) -> bytes | None:
        """Return the picture of the snapshot with a number; None if there is no such snapshot."""
        return next((each.picture for each in self._kept.values() if str(each.number) == number), None)

    def _picture(self) -> bytes:
        """Draw the view without gizmos, and return it as JPEG."""
        window, interaction = self._subplot.renderer.GetRenderWindow(), self._subplot.interaction
        assert interaction is not None, "a studio has gizmos"
        (width, height), pixels = window.GetSize(), vtkUnsignedCharArray()
        with interaction.out_of_sight():
            window.Render()
            window.GetPixelData(0, 0, width - 1, height - 1, 0, pixels, 0)
        file = io.BytesIO()
        image = Image.fromarray(vtk_to_numpy(pixels).reshape(height, width, 3)[::-1])
        image.save(file, "jpeg", quality=_QUALITY, subsampling=0)
        return file.getvalue()


def pictures(snapshots: Snapshots) -> Any:
    """Return the handler of HTTP requests for the pictures of snapshots."""
    from aiohttp import web

    async def answer(request: web.Request) -> web.StreamResponse:
        picture = snapshots.picture(request.match_info["number"])
        if picture is None:
            return web.Response(status=404)
        headers: Mapping[str, str] = {"Cache-Control": "no-store"}
        return web.Response(body=picture, content_type="image/jpeg", headers=headers)

    return answer
