"""Ready-made lights: three-point lighting around a mesh, the default scene's, and PyVista's three."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import Vector
from pvphong.optics.lights import DirectionalLight, Light, PointLight
from pvphong.scene.viewer import Viewer

_AWAY = 1.0
"""How far the lights of `three_point` stand from the middle, in diagonals of the mesh's bounds."""


def three_point(mesh: Any, viewer: Viewer | None = None, *, ratio: float = 4.0) -> tuple[Light, ...]:
    """Key, fill and rim light of portrait photography, standing around a mesh in the world.

    The key stands 45° to the left of the viewer and 30° above; the fill opposite it, lower and weaker; the rim
    light behind and above, so that it draws the outline.

    Parameters
    ----------
    mesh : pyvista.DataSet, pyvista.MultiBlock, or sequence of float
        What stands in the light, or its bounds (x_min, x_max, y_min, y_max, z_min, z_max).
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
        way = np.array(viewer.vector_to_world(_towards(azimuth, elevation)))
        return PointLight(position=center + _AWAY * size * way, intensity=intensity, name=name)

    return light("key", -45.0, 30.0, 0.9), light("fill", 50.0, 5.0, 0.9 / ratio), light("rim", 160.0, 50.0, 0.6)


def three_lights() -> tuple[Light, ...]:
    """The three camera lights of PyVista's ``lighting="three lights"``.

    Source: ``pyvista.Plotter.enable_3_lights``, after Mayavi's version of Raymond Maple's illumination.

    Returns
    -------
    tuple of Light
        "upper right", "lower left" and "lower right", in the camera's frame.
    """
    return tuple(
        DirectionalLight(direction=_from(azimuth, elevation), intensity=intensity, frame="camera", name=name)
        for name, azimuth, elevation, intensity in (
            ("upper right", 45.0, 45.0, 1.0),
            ("lower left", -60.0, -30.0, 0.6),
            ("lower right", 60.0, -30.0, 0.5),
        )
    )


def key_fill_rim() -> tuple[Light, ...]:
    """Three lights that ride along with the camera and flatter any mesh: those of the default scene.

    Returns
    -------
    tuple of Light
        "key", warm, from the upper left; "fill", weak and cool, from the right; "rim", from behind.
    """
    return (
        DirectionalLight(direction=(1.0, -1.0, -1.4), diffuse=(0.95, 0.93, 0.9), frame="camera", name="key"),
        DirectionalLight(direction=(-1.0, 0.1, -0.8), diffuse=(0.18, 0.2, 0.24), frame="camera", name="fill"),
        DirectionalLight(direction=(-0.4, -1.0, 0.9), diffuse=(0.35, 0.35, 0.35), frame="camera", name="rim"),
    )


def _towards(azimuth: float, elevation: float) -> Vector:
    """Unit vector in eye space (x right, y up, z back to the eye) at angles right of and above the view axis."""
    across, above = math.radians(azimuth), math.radians(elevation)
    return math.sin(across) * math.cos(above), math.sin(above), math.cos(across) * math.cos(above)


def _from(azimuth: float, elevation: float) -> Vector:
    x, y, z = _towards(azimuth, elevation)
    return -x, -y, -z
