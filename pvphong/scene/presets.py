"""Ready-made lights: three-point lighting around a mesh, and the default scene's."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.optics.lights import DirectionalLight, Light, PointLight
from pvphong.scene.viewer import Viewer

_AWAY = 1.0
"""How far the lights of `three_point` are from the middle, in diagonals of the mesh's bounds."""


def three_point(mesh: Any, viewer: Viewer | None = None, *, ratio: float = 4.0) -> tuple[Light, ...]:
    """Key, fill and rim light of portrait photography, around a mesh in the world.

    The key is 45° to the left of the viewer and 30° above; the fill opposite it, lower and weaker; the rim
    light behind and above, so that it draws the outline.

    Parameters
    ----------
    mesh : pyvista.DataSet, pyvista.MultiBlock, or sequence of float
        What is lit, or its bounds (x_min, x_max, y_min, y_max, z_min, z_max).
    viewer : Viewer, optional
        Where it is seen from, as PyVista's camera frames the mesh if not given; the lights do not move with it.
    ratio : float, default 4
        How many times stronger the key is than the fill, >= 1.

    Returns
    -------
    tuple of Light
        Point lights named "key", "fill" and "rim".

    Raises
    ------
    ValueError
        If the mesh is empty, or an argument is not allowed.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> [light.name for light in ph.three_point(pv.Sphere())]
    ['key', 'fill', 'rim']
    """
    bounds = np.array(check.numbers_in("bounds", getattr(mesh, "bounds", mesh), 6))
    ratio = check.number("ratio", ratio, at_least=1.0)
    viewer = viewer or Viewer.framing(bounds.tolist())
    if not isinstance(viewer, Viewer):
        check.refuse("viewer", viewer, "a Viewer", "Viewer.from_camera makes one of a camera.")
    center = 0.5 * (bounds[::2] + bounds[1::2])
    size = float(np.linalg.norm(bounds[1::2] - bounds[::2]))
    if not (bounds[::2] <= bounds[1::2]).all() or not size > 0.0:
        check.refuse("bounds", bounds.tolist(), "those of a mesh with points in more than one place")

    def light(name: str, azimuth: float, elevation: float, intensity: float) -> Light:
        across, above = math.radians(azimuth), math.radians(elevation)  # right of the view axis, and over it
        in_eye_space = math.sin(across) * math.cos(above), math.sin(above), math.cos(across) * math.cos(above)
        direction = np.array(viewer.vector_to_world(in_eye_space))
        return PointLight(position=center + _AWAY * size * direction, intensity=intensity, name=name)

    return light("key", -45.0, 30.0, 0.9), light("fill", 50.0, 5.0, 0.9 / ratio), light("rim", 160.0, 50.0, 0.6)


def key_fill_rim() -> tuple[Light, ...]:
    """Three lights that ride along with the camera and flatter any mesh: those of the default scene.

    Returns
    -------
    tuple of Light
        "key", warm, from the upper left; "fill", weaker and cool, from right of the viewer, on all that faces it;
        "rim", from behind.
    """
    return (
        DirectionalLight(direction=(1.0, -1.0, -1.4), diffuse=(0.95, 0.93, 0.9), frame="camera", name="key"),
        DirectionalLight(direction=(-0.5, 0.1, -1.0), diffuse=(0.36, 0.4, 0.46), frame="camera", name="fill"),
        DirectionalLight(direction=(-0.4, -1.0, 0.9), diffuse=(0.35, 0.35, 0.35), frame="camera", name="rim"),
    )
