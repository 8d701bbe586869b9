"""Puts a drawing in front of a renderer's picture, with VTK's two-dimensional actors."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkCoordinate, vtkPolyDataMapper2D, vtkTextActor

from pvphong.base.types import ByteArray, Float64Array
from pvphong.studio.gizmos.drawing import Drawing

_EDGES, _LINES, _AREAS, _TEXT = range(4)
# Of lines, in pixels, and of the dark edges to both sides of them: those are seen on any background.
_THIN, _THICK, _EDGE = 1.0, 2.0, 2.0
_DARK = (0.04, 0.04, 0.04)
_BESIDE, _MARGIN = 18.0, 8.0
_NORMAL, _SMALL = 14, 12  # sizes of letters
_HELP_LETTER = np.array([8.2, 15.2])  # of the help, which has letters of one width
_LETTER = (7.5, 18.0)  # how large one is at most, in pixels


class Overlay:
    """Lines with a dark edge, areas above them, and texts: none of it lit, picked, or part of the bounds."""

    def __init__(self) -> None:
        self._lines = {thin: (vtkPolyData(), vtkPolyData()) for thin in (True, False)}
        self._areas = vtkPolyData()
        self._readout, self._help, self._status = _text(), _text(), _text()
        self._help.GetTextProperty().SetVerticalJustificationToTop()
        self._help.GetTextProperty().SetFontFamilyToCourier()
        self._status.GetTextProperty().SetJustificationToRight()
        self._labels: list[vtkTextActor] = []
        self._props: list[Any] = []
        for thin, (edges, lines) in self._lines.items():
            width = _THIN if thin else _THICK
            edge = _actor(edges, _EDGES, width + _EDGE)
            edge.GetMapper().ScalarVisibilityOff()
            edge.GetProperty().SetColor(_DARK)
            self._props += [_unpicked(edge), _unpicked(_actor(lines, _LINES, width))]
        self._props += map(_unpicked, (_actor(self._areas, _AREAS), self._readout, self._help, self._status))
        self._is_shown = True

    def attach(self, renderer: Any) -> None:
        """Show it in a renderer, if it is not there already."""
        for prop in self._props:
            if not renderer.HasViewProp(prop):
                renderer.AddViewProp(prop)

    def detach(self, renderer: Any) -> None:
        """Take it out of a renderer."""
        for prop in self._props:
            renderer.RemoveViewProp(prop)

    def show(self, shown: bool) -> None:
        """Show or hide all of it."""
        self._is_shown = shown
        for prop in self._props:
            prop.SetVisibility(shown)

    def put(self, drawing: Drawing) -> None:
        """Show a drawing in place of the last one."""
        segments, colors = drawing.lines
        for thin, both in self._lines.items():
            chosen = drawing.thin == thin
            for data in both:
                _fill(data, segments[chosen].reshape(-1, 2), np.full(chosen.sum(), 2), colors[chosen], data.SetLines)
        corners = [corners for corners, _ in drawing.areas]
        points = np.concatenate(corners) if corners else np.empty((0, 2))
        tints = np.array([color for _, color in drawing.areas], np.uint8).reshape(-1, 4)
        _fill(self._areas, points, np.array([len(polygon) for polygon in corners]), tints, self._areas.SetPolys)

    def label(self, labels: list[tuple[Float64Array, str]], origin: tuple[float, float]) -> None:
        """Show short texts in place of the last ones, at pixels of the window; the pane begins at `origin`."""
        while len(self._labels) < len(labels):
            self._labels.append(_unpicked(_text(_SMALL)))
            self._props.append(self._labels[-1])
        for actor in self._labels:
            actor.SetVisibility(False)
        for actor, (place, text) in zip(self._labels, labels, strict=False):
            actor.SetInput(text)
            actor.SetPosition(*(place - origin))
            actor.SetVisibility(self._is_shown)

    def status(self, text: str, size: tuple[float, float]) -> None:
        """Show a text in the lower right corner of a pane of this size; an empty one hides it."""
        lines = [textwrap.fill(line, max(int((size[0] - 2 * _MARGIN) / _LETTER[0]), 8)) for line in text.split("\n")]
        self._status.SetInput("\n".join(lines))
        self._status.SetPosition(size[0] - _MARGIN, _MARGIN)
        self._status.SetVisibility(bool(text) and self._is_shown)

    def say(self, text: str, cursor: tuple[float, float], size: tuple[float, float]) -> None:
        """Show a text beside the cursor, on the side where a pane of this size has its edge; an empty one hides it."""
        lines = text.split("\n")
        needed = _BESIDE + _LETTER[0] * max(map(len, lines)), _BESIDE + _LETTER[1] * len(lines)
        right, up = (
            at + need <= side if at >= 0.5 * side else at < need
            for at, need, side in zip(cursor, needed, size, strict=True)
        )
        style = self._readout.GetTextProperty()
        (style.SetJustificationToLeft if right else style.SetJustificationToRight)()
        (style.SetVerticalJustificationToBottom if up else style.SetVerticalJustificationToTop)()
        x, y = cursor
        x = min(x + _BESIDE, size[0] - needed[0] + _BESIDE) if right else max(x - _BESIDE, needed[0] - _BESIDE)
        self._readout.SetInput(text)
        self._readout.SetPosition(x, y + (_BESIDE if up else -_BESIDE))
        self._readout.SetVisibility(bool(text) and self._is_shown)

    def help(self, text: str, size: tuple[float, float]) -> bool:
        """Show a text in the upper left of a pane of this size; an empty one hides it.

        Returns whether it leaves room for others; where it does not, it is as small as it must be to fit in.
        """
        lines = text.split("\n")
        room = np.array(size) - 2.0 * _MARGIN
        fits = min(room / (_HELP_LETTER * (max(map(len, lines)), len(lines) + 2))) if text else 1.0
        self._help.SetInput(text)
        self._help.GetTextProperty().SetFontSize(max(int(_NORMAL * min(fits, 1.0)), 5))
        self._help.SetPosition(_MARGIN, size[1] - _MARGIN)
        self._help.SetVisibility(bool(text) and self._is_shown)
        return bool(fits >= 1.0)


def _actor(data: vtkPolyData, layer: int, width: float = 1.0) -> vtkActor2D:
    pixels = vtkCoordinate()
    pixels.SetCoordinateSystemToDisplay()
    mapper = vtkPolyDataMapper2D()
    mapper.SetInputData(data)
    mapper.SetTransformCoordinate(pixels)
    actor = vtkActor2D()
    actor.SetMapper(mapper)
    actor.SetLayerNumber(layer)
    actor.GetProperty().SetLineWidth(width)
    return actor


def _unpicked(actor: Any) -> Any:
    actor.UseBoundsOff()
    actor.PickableOff()
    return actor


def _text(size: int = _NORMAL) -> vtkTextActor:
    actor = vtkTextActor()
    actor.SetLayerNumber(_TEXT)
    actor.SetVisibility(False)
    style = actor.GetTextProperty()
    style.SetFontSize(size)
    style.SetColor(1.0, 1.0, 1.0)
    style.SetBackgroundColor(0.1, 0.1, 0.1)
    style.SetBackgroundOpacity(0.85)
    return actor


def _fill(data: vtkPolyData, points: Float64Array, sizes: Any, colors: ByteArray, set_cells: Any) -> None:
    """Cells of these sizes, each of the points that come next."""
    coordinates = vtkPoints()
    coordinates.SetData(numpy_to_vtk(np.column_stack([points, np.zeros(len(points))]).astype(np.float32), deep=True))
    cells = vtkCellArray()
    offsets, indices = np.append(0, np.cumsum(sizes)).astype(np.int64), np.arange(len(points), dtype=np.int64)
    cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(indices, deep=True))
    data.SetPoints(coordinates)
    set_cells(cells)
    data.GetCellData().SetScalars(numpy_to_vtk(np.ascontiguousarray(colors), deep=True))
