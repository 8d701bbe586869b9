"""Thumbnails: a sphere for each named material, reflectance and set-up of lights.

The spheres are lit by pvphong, with several vertices per pixel.
"""

from __future__ import annotations

import asyncio
from dataclasses import replace
from functools import lru_cache
from io import BytesIO

import numpy as np
from aiohttp import web

from pvphong.base import check
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.presets import key_fill_rim, setups
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading.evaluation import evaluate
from pvphong.studio.web.kinds import new_reflectance

_SIDE = 56  # pixels
_SMOOTH = 3  # rows of vertices per row of pixels
_LIGHTS = Scene(key_fill_rim(), Viewer(position=(0.0, 0.0, 5.0), parallel=True), LightModel(ambient=0.4))
_BASE = Material(ambient=0.2, diffuse=(0.75, 0.35, 0.2), specular=0.5, shininess=25.0)
"""The material that shows a reflectance in its thumbnail."""


@lru_cache(maxsize=64)
def thumbnail(kind: str, name: str) -> bytes:
    """Return the picture of a sphere, as a .png with a transparent background.

    Parameters
    ----------
    kind : {"material", "reflectance", "setup"}
        The kind of thumbnail.
    name : str
        Name of a material, of a reflectance in scene files, or of a set-up of lights.

    Raises
    ------
    ValueError
        If there is no such material, reflectance or set-up.
    """
    from PIL import Image

    material, scene = _BASE, _LIGHTS
    match check.choice("kind", kind, ("material", "reflectance", "setup")):
        case "material":
            material = Material.named(name)
        case "reflectance":
            material = replace(_BASE, reflectance=new_reflectance(name))
        case _:
            lights = setups[name]((-1.0, 1.0) * 3, _LIGHTS.viewer)
            scene = replace(_LIGHTS, lights=lights, light_model=LightModel())
    across = np.linspace(-1.06, 1.06, _SIDE * _SMOOTH)
    x, y = np.meshgrid(across, -across)
    inside = x * x + y * y < 1.0
    normals = np.stack([x, y, np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))], axis=-1)[inside]
    if material.reflectance is not None and material.reflectance.needs:
        material = replace(material, tangents=np.cross((0.0, 1.0, 1e-6), normals))
    picture = np.zeros((*x.shape, 4))
    picture[inside, :3] = evaluate(normals, normals, scene, material, backend="numpy").rgb
    picture[inside, 3] = 1.0
    blocks = picture.reshape(_SIDE, _SMOOTH, _SIDE, _SMOOTH, 4).mean(axis=(1, 3))
    blocks[..., :3] /= np.maximum(blocks[..., 3:], 1e-6)  # average over the covered part only
    out = BytesIO()
    Image.fromarray(np.rint(255.0 * blocks.clip(0.0, 1.0)).astype(np.uint8)).save(out, format="PNG")
    return out.getvalue()


async def answer(request: web.Request) -> web.StreamResponse:
    """Answer an HTTP request for the thumbnail of a material, a reflectance or a set-up of lights."""
    try:
        image = await asyncio.to_thread(thumbnail, request.match_info["kind"], request.match_info["name"])
    except ValueError:
        return web.Response(status=404)
    return web.Response(body=image, content_type="image/png", headers={"Cache-Control": "max-age=3600"})
