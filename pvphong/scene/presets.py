"""Ready-made lights: three-point lighting around a mesh, and the lights of the default scene."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.optics.lights import DirectionalLight, Light, PointLight
from pvphong.scene.viewer import Viewer

_AWAY = 1.0
"""Distance of the lights of `three_point` from the centre, in diagonals of the mesh's bounds."""


def three_point(mesh: Any, viewer: Viewer | None = None, *, ratio: float = 4.0) -> tuple[Light, ...]:
    """Return the key, fill and rim light of portrait photography, placed around a mesh.

    The key light is 45° to the left of the viewer and 30° above. The fill light is on the other side, lower and weaker.
    The rim light is behind the mesh and above, so that it shows the outline.

    Parameters
    ----------
    mesh : pyvista.DataSet, pyvista.MultiBlock, or sequence of float
        The mesh to be lit, or its bounds (x_min, x_max, y_min, y_max, z_min, z_max).
    viewer : Viewer, optional
        The viewer; by default, PyVista's default view of the mesh. The lights do not move with the viewer.
    ratio : float, default 4
        Intensity of the key light divided by that of the fill light, >= 1.

    Returns
    -------
    tuple of Light
        Point lights named "key", "fill" and "rim".

    Raises
    ------
    ValueError
        If the mesh is empty, or an argument is invalid.

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
        check.refuse("viewer", viewer, "a Viewer", "Convert a camera with Viewer.from_camera.")
    center = 0.5 * (bounds[::2] + bounds[1::2])
    size = float(np.linalg.norm(bounds[1::2] - bounds[::2]))
    if not (bounds[::2] <= bounds[1::2]).all() or not size > 0.0:
        check.refuse("bounds", bounds.tolist(), "the bounds of a mesh with at least two different points")

    def light(name: str, azimuth: float, elevation: float, intensity: float) -> Light:
        across, above = math.radians(azimuth), math.radians(elevation)  # to the right of the view axis, and above it
        in_eye_space = math.sin(across) * math.cos(above), math.sin(above), math.cos(across) * math.cos(above)
        direction = np.array(viewer.vector_to_world(in_eye_space))
        return PointLight(position=center + _AWAY * size * direction, intensity=intensity, name=name)

    return light("key", -45.0, 30.0, 0.9), light("fill", 50.0, 5.0, 0.9 / ratio), light("rim", 160.0, 50.0, 0.6)


def key_fill_rim() -> tuple[Light, ...]:
    """Return three lights that move with the camera and suit any mesh: the lights of the default scene.

    Returns
    -------
    tuple of Light
        "key", warm, from the upper left; "fill", weaker and cool, from the right, which lights all surfaces that face
        the viewer; "rim", from behind.
    """
    return (
        DirectionalLight(direction=(1.0, -1.0, -1.4), diffuse=(0.95, 0.93, 0.9), frame="camera", name="key"),
        DirectionalLight(direction=(-0.5, 0.1, -1.0), diffuse=(0.36, 0.4, 0.46), frame="camera", name="fill"),
        DirectionalLight(direction=(-0.4, -1.0, 0.9), diffuse=(0.35, 0.35, 0.35), frame="camera", name="rim"),
    )
