"""Uploads to the studio: meshes, rigs, measured lamps, images of skies, and textures."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from pathlib import Path, PurePath
from typing import Any

from pvphong.base import check
from pvphong.meshes.blocks import DEFAULT
from pvphong.meshes.files import read, read_texture
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.maps import IMAGES, is_image_path
from pvphong.optics.photometric_files import read_photometry
from pvphong.scene.scene import Scene, load_materials
from pvphong.studio.subplot import Subplot
from pvphong.studio.web.access import refuse_lamp_files, upload
from pvphong.studio.web.document import Document

MESHES = (".vtp", ".vtu", ".vtk", ".vti", ".vts", ".vtr", ".vtkhdf", ".ply", ".stl", ".obj", ".glb", ".gltf")
RIGS = (".json",)
LAMPS = (".ies", ".ldt")
SKIES = (".hdr", ".png", ".jpg", ".jpeg")
"""Suffixes of the files that can be uploaded."""

DROPPED: Mapping[str, str] = {
    suffix: what for what, kinds in (("mesh", MESHES), ("rig", RIGS), ("lamp", LAMPS)) for suffix in kinds
}
"""Suffix of a file that can be dropped onto the page → the upload that it becomes."""

_LARGEST_LAMP = 2**24
"""Largest file of a lamp, in bytes: 16 MiB, as much as `read_photometry` reads."""


class Uploads:
    """Takes uploaded files into a studio. Each is read from a temporary file of a fixed name, which is then deleted.

    Parameters
    ----------
    document : Document
        The values that the studio edits.
    subplot : Subplot
        The subplot with the lights.
    open_mesh : callable
        Called with a mesh, the name of its file, and whether it is shown beside the meshes that are there already;
        returns a message.
    """

    def __init__(self, document: Document, subplot: Subplot, open_mesh: Callable[[Any, str, bool], str]) -> None:
        self._document, self._subplot, self._open_mesh = document, subplot, open_mesh

    def add_routes(self, router: Any, done: Callable[[str], None]) -> None:
        """Add the handlers of requests. `done` is as for `access.upload`."""
        router.add_post("/bring/mesh", upload(MESHES, self.take_mesh, done))
        router.add_post("/bring/rig", upload(RIGS, self.take_rig, done))
        router.add_post("/bring/lamp", upload(LAMPS, self.take_lamp, done, largest=_LARGEST_LAMP))
        router.add_post("/bring/sky", upload(SKIES, self.take_sky, done))
        router.add_post("/bring/texture", upload(IMAGES, self.take_texture, done))

    async def take_mesh(self, name: str, path: Path, query: Mapping[str, str]) -> str:
        """Open a mesh; with `beside` in the query, show it beside the others."""
        mesh = await asyncio.to_thread(read, path, guarded=True)
        return self._open_mesh(mesh, name, bool(query.get("beside")))

    async def take_rig(self, _name: str, path: Path, query: Mapping[str, str]) -> None:
        """Use a rig; with `part=material` in the query, only its materials."""
        refuse_lamp_files(path)
        scene: Scene | None = Scene.load(path)
        materials = load_materials(path)
        for material in materials.values():
            for field, given in material.maps.items():
                if is_image_path(given):
                    allowed, remedy = "a value in an uploaded rig, not an image file", "Upload the image as a texture."
                    check.refuse(field, PurePath(str(given)).name, allowed, remedy)
        if query.get("part") == "material":
            if not materials:
                check.refuse("rig", "a rig without materials", "a rig with at least one material")
            scene = None
        self._document.replace_all(scene, materials, DEFAULT)

    async def take_lamp(self, name: str, path: Path, _query: Mapping[str, str]) -> str:
        """Add a measured lamp, placed as any new light and called by the file's name."""
        try:
            measured = await asyncio.to_thread(read_photometry, path, is_alone=True)
        except ValueError as error:
            raise ValueError(str(error).replace(path.name, name)) from error
        lamp: Any = LIGHT_TYPES["photometric"]
        self._document.add_light(lamp(measured), PurePath(name).stem)
        factor = self._subplot.lights.values[-1].intensity
        return f"{name} is added at {factor:.3g} times its measured brightness, which suits the picture."

    async def take_sky(self, _name: str, path: Path, query: Mapping[str, str]) -> None:
        """Set the image of the environment light whose number is `light` in the query."""
        image = await asyncio.to_thread(read, path, guarded=True)
        await self._document.set_image(query.get("light", ""), image)

    async def take_texture(self, name: str, path: Path, query: Mapping[str, str]) -> None:
        """Set the texture of the field `field` of the material with the number `material` in the query."""
        field = query.get("field", "")
        texture = await asyncio.to_thread(read_texture, str(path), field)
        self._document.set_texture(query.get("material", ""), field, texture, name)


def refuse_file(name: Any) -> None:
    """Refuse a file that was dropped onto the page, because of its name. The message lists the allowed suffixes."""
    allowed = f"a mesh ({', '.join(MESHES)}), a rig ({', '.join(RIGS)}) or a measured lamp ({', '.join(LAMPS)})"
    check.refuse("file", PurePath(check.text("file", name)).name[:80] or "a file without a name", allowed)
