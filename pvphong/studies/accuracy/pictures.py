"""Reference, chosen colours and errors in linked cameras, drawn offscreen. Needs Matplotlib for its colours."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray
from pvphong.geometry.transform import transform_points
from pvphong.meshes.default_scene import default_scene
from pvphong.meshes.pictures import draw
from pvphong.studies.accuracy.result import Result

SIZE = (640, 480)

_LEAST_SHOWN = 0.01
"""In parts of the tolerance: errors inside triangles from here on have a colour."""

_NOT_SEEN = 0.002
"""A part of the picture that shows less of a mesh than this does not show it."""

_BACKGROUND = "#dce6f2"


class Picture(NamedTuple):
    """One of the linked pictures.

    Parameters
    ----------
    title : str
        What it shows.
    pixels : ndarray
        Shape (height, width, 3), uint8.
    scale : matplotlib.cm.ScalarMappable or None
        Of errors and their colours, for a colour bar; None where colours are those of the mesh.
    """

    title: str
    pixels: NDArray[np.uint8]
    scale: Any = None


def linked_pictures(result: Result) -> list[Picture]:
    """One mesh from one place: the reference, the chosen colours, their errors, the errors inside triangles.

    The scene's own viewer is used where it sees the mesh, else one that does. Errors at the vertices have a colour
    scale to the largest of them on both sides; those inside triangles one of powers of ten.

    Raises
    ------
    ValueError
        If VTK cannot draw on this machine.
    """
    mesh, viewer = _placed(result), result.scene.viewer
    reference = np.clip(result.reference_colors, 0.0, 1.0)
    pixels = _drawn(mesh, reference, viewer)
    if _covered(pixels) < _NOT_SEEN:
        viewer = default_scene(mesh).viewer
        pixels = _drawn(mesh, reference, viewer)
    chosen = result.best()
    title = "chosen" if chosen is None else f"chosen: {chosen.name}"
    signed = worst_channel(result.chosen_colors - result.reference_colors)
    scale = signed_scale(signed)
    pictures = [
        Picture("reference", pixels),
        Picture(title, _drawn(mesh, np.clip(result.chosen_colors, 0.0, 1.0), viewer)),
        Picture("its signed error at the vertices", _drawn(mesh, _colors(scale, signed), viewer), scale),
    ]
    if len(result.inside_errors) == mesh.n_cells and mesh.is_all_triangles:
        scale = decades(result.inside_errors, result.tolerance)
        pixels = _drawn_faces(mesh, _colors(scale, result.inside_errors), viewer)
        pictures.append(Picture("interpolation error inside triangles", pixels, scale))
    return pictures


def signed_scale(errors: Float64Array) -> Any:
    """White for no error, red above, blue below, up to the largest; up to a display step where there is none."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    largest = float(np.abs(errors).max(initial=0.0)) or 1.0 / 255.0
    return ScalarMappable(Normalize(-largest, largest), "RdBu_r")


def decades(errors: Float64Array, tolerance: float) -> Any:
    """From white, a small part of the tolerance, to the largest error or the tolerance; logarithmic."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm

    most = max(float(errors.max(initial=0.0)), tolerance)
    return ScalarMappable(LogNorm(_LEAST_SHOWN * tolerance, most, clip=True), "Reds")


def _colors(scale: Any, errors: Float64Array) -> Float64Array:
    """(n, 3) in [0, 1]."""
    low = scale.norm.vmin
    return np.asarray(scale.to_rgba(np.maximum(errors, low)))[:, :3]  # a logarithm of 0 would be masked


def _placed(result: Result) -> pv.PolyData:
    mesh = result.surface.copy()
    mesh.clear_data()
    if result.matrix is not None:
        mesh.points = transform_points(np.asarray(mesh.points), check.matrix4("matrix", result.matrix))
    return mesh


def worst_channel(differences: Float64Array) -> Float64Array:
    """The entry of each row (n, 3) that is farthest from 0, with its sign."""
    return differences[np.arange(len(differences)), np.abs(differences).argmax(axis=1)]


def _drawn(mesh: pv.PolyData, colors: FloatArray, viewer: Any) -> Any:
    mesh.point_data["phong"] = colors
    return draw(mesh, viewer, size=SIZE, background=_BACKGROUND)


def _drawn_faces(mesh: pv.PolyData, colors: FloatArray, viewer: Any) -> Any:
    """Every triangle in a colour of its own."""
    corners = mesh.regular_faces
    own = pv.PolyData.from_regular_faces(
        np.asarray(mesh.points)[corners.ravel()], np.arange(corners.size).reshape(-1, 3)
    )
    return _drawn(own, np.repeat(colors, 3, axis=0), viewer)


def _covered(picture: Any) -> float:
    """The part of a picture that is not background."""
    return float((picture != picture[0, 0]).any(axis=2).mean())
