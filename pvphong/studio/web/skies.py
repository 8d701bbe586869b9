"""Uploaded images for environment lights."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.optics.light import Light
from pvphong.optics.lights import vtk_values
from pvphong.studio.gizmos.gizmo import called
from pvphong.studio.web.fields import fields_of


def image_in(image: Any, light: Light) -> tuple[str, Any]:
    """Return the name of the field of `light` that takes an image, and the value for it, made from `image`.

    Raises
    ------
    ValueError
        If the light takes no image, or the image is invalid.
    """
    names = [field.name for field in fields_of(type(light)) if field.takes == "image"]
    if not names or not isinstance(image, pv.ImageData) or image.active_scalars is None:
        check.refuse("image", f"a file for {called(light)}", "an image file for an environment light")
    width, height, _ = image.dimensions
    texels = np.asarray(image.active_scalars).reshape(height, width, -1)[::-1, :, :3]
    if texels.dtype != np.uint8:
        return names[0], np.ascontiguousarray(texels, np.float32)
    texture: Any = pv.Texture(np.ascontiguousarray(texels))
    texture.SetUseSRGBColorSpace(True)
    return names[0], texture


def with_image(light: Light, name: str, image: Any) -> Light:
    """Return `light` with `image` in its field `name`.

    Values that are slow to compute from the image are computed now.
    """
    changes: dict[str, Any] = {name: image}
    return prepared(replace(light, **changes))


def prepared(light: Light) -> Light:
    """Return a light after everything that is slow to compute from its image, if it has one."""
    # Both calls cache slow computations with the image. Done here, these do not block the thread that draws.
    vtk_values(light)
    light.bands  # noqa: B018
    return light
