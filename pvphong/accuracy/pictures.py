"""Reference, chosen colours and errors in linked cameras, drawn offscreen."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista as pv

from pvphong import _check
from pvphong._types import Float64Array, FloatArray
from pvphong.pictures import draw
from pvphong.studio import studio_scene
from pvphong.transform import transform_points

if TYPE_CHECKING:
    from pvphong.accuracy.report import Tradeoff

SIZE = (640, 480)

STEP = 1.0 / 255.0
"""One step of a display, the unit of the errors in pictures."""

MOST_STEPS = 4
"""The fixed scale of signed errors: this many display steps to both sides, whole steps, what is beyond as the last."""

BELOW, NONE, ABOVE = np.array([[33, 102, 172], [247, 247, 247], [178, 24, 43]]) / 255.0
"""Colours of −4 steps, no error and +4 steps: ColorBrewer's RdBu."""

_NOT_SEEN = 0.002
"""A part of the picture that shows less of a mesh than this does not show it."""


def linked_pictures(report: Tradeoff) -> dict[str, Any]:
    """Pictures (height, width, 3), uint8, of one mesh from one place: the reference, the chosen colours, errors.

    The scene's own viewer is used where it sees the mesh, else one that does.

    Raises
    ------
    ValueError
        If VTK cannot draw on this machine.
    """
    mesh = _placed(report)
    signed = worst_channel(report.chosen_colors - report.reference_colors)
    shown = {
        "reference": np.clip(report.reference_colors, 0.0, 1.0),
        "chosen": np.clip(report.chosen_colors, 0.0, 1.0),
        "signed error at the vertices": error_colors(signed),
    }
    viewer = report.scene.viewer
    pictures = {"reference": _drawn(mesh, shown.pop("reference"), viewer)}
    if _covered(pictures["reference"]) < _NOT_SEEN:
        viewer = studio_scene(mesh).viewer
        pictures["reference"] = _drawn(mesh, np.clip(report.reference_colors, 0.0, 1.0), viewer)
    pictures |= {name: _drawn(mesh, colors, viewer) for name, colors in shown.items()}
    if len(report.inside_errors) == mesh.n_cells and mesh.is_all_triangles:
        pictures["interpolation error inside triangles"] = _drawn_faces(mesh, report.inside_errors, viewer)
    return pictures


def _placed(report: Tradeoff) -> pv.PolyData:
    mesh = report.surface.copy()
    mesh.clear_data()
    if report.matrix is not None:
        mesh.points = transform_points(np.asarray(mesh.points), _check.matrix4("matrix", report.matrix))
    return mesh


def worst_channel(differences: Float64Array) -> Float64Array:
    """The entry of each row (n, 3) that is farthest from 0, with its sign."""
    return differences[np.arange(len(differences)), np.abs(differences).argmax(axis=1)]


def error_colors(signed: Float64Array) -> Float64Array:
    """Colours (n, 3) of signed errors (n,), in whole display steps."""
    steps = np.clip(np.rint(signed / STEP), -MOST_STEPS, MOST_STEPS)[:, None] / MOST_STEPS
    return np.where(steps < 0.0, NONE + (BELOW - NONE) * -steps, NONE + (ABOVE - NONE) * steps)


def _drawn(mesh: pv.PolyData, colors: FloatArray, viewer: Any) -> Any:
    mesh.point_data["phong"] = colors
    return draw(mesh, viewer, size=SIZE, background=_BACKGROUND)


def _drawn_faces(mesh: pv.PolyData, errors: Float64Array, viewer: Any) -> Any:
    """Every triangle in the colour of its own error."""
    corners = mesh.regular_faces
    own = pv.PolyData.from_regular_faces(
        np.asarray(mesh.points)[corners.ravel()], np.arange(corners.size).reshape(-1, 3)
    )
    return _drawn(own, error_colors(np.repeat(errors, 3)), viewer)


_BACKGROUND = "#dce6f2"


def _covered(picture: Any) -> float:
    """The part of a picture that is not background."""
    return float((picture != picture[0, 0]).any(axis=2).mean())
