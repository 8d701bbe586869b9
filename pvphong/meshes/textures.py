"""What a surface takes from its texture coordinates: tangents."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base.types import FloatArray
from pvphong.geometry.tangents import point_tangents
from pvphong.meshes.surfaces import has_faces, polygons


def tangents_from(source: pv.PolyData, given: Any, normals: Callable[[], FloatArray]) -> Any:
    """The tangents of a surface's points, or what gives them when they are first read.

    Parameters
    ----------
    source : pyvista.PolyData
        A checked surface.
    given : array_like or None
        The tangents, if they are known. None takes them from the texture coordinates.
    normals : callable
        Gives the points' normals.

    Returns
    -------
    array_like, callable or None
        As `Vertices` takes them; None where nothing was given and there are no texture coordinates.
    """
    if given is not None:
        return given
    coordinates = source.active_texture_coordinates
    if coordinates is None or not has_faces(source):
        return None
    return lambda: point_tangents(source.points, *polygons(source), np.asarray(coordinates)[:, :2], normals())
