"""Drawing of gizmos: `Drawing` collects lines, areas and labels in pixels; `Overlay` shows a `Drawing` with VTK.

Pixels are those of a screen of usual resolution. On a screen of high resolution, `Overlay` draws each of them as
several device pixels, so that gizmos and texts have the same size everywhere.
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkCoordinate, vtkPolyDataMapper2D, vtkTextActor

from pvphong.base.types import BoolArray, ByteArray, Float64Array, Vector, rgb
from pvphong.optics.light import Light
from pvphong.studio.gizmos.view import View

_ANGLES = np.linspace(0.0, 2.0 * np.pi, 25)
_CIRCLE = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
_CHORDS = np.stack([_CIRCLE[:-1], _CIRCLE[1:]], axis=1)
_OFF = 0.45  # factor for the colour of a light that is off
_WHITE = (1.0, 1.0, 1.0)
DARK_EDGE, LIGHT_EDGE = (0.08, 0.08, 0.08), (0.75, 0.75, 0.75)
"""Edges of areas: dark, or light if the area itself is dark."""

_THICK_FROM = 0.8  # lines of at least this strength are drawn thick
_ARROW_MARGIN = 16.0  # pixels between the edge of the subplot and an arrow
_LABEL_HEIGHT = 16.0
# In perspective, lines are clipped where their depth is below this fraction of the depth of their farthest point.
_NEAR = 1e-3


def hue(light: Light) -> Vector:
    """Return the colour with which a light is drawn: its own colour, scaled so that the largest channel is 1.

    The colour is darker if the light is off.
    """
    color = np.array(rgb(light.diffuse))
    full = color / color.max() if color.any() else np.full(3, 0.6)
    red, green, blue = (full if light.on else full * _OFF).tolist()
    return red, green, blue


def circle(center: Float64Array, normal: Float64Array, radius: float, count: int = 64) -> Float64Array:
    """Return the corners of a circle around `center`, a closed polygon of `count` sides, shape (count + 1, 3).

    `normal` is the unit normal of the circle's plane, and `radius` is in world units.
    """
    side = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    side /= np.linalg.norm(side)
    turn = np.linspace(0.0, 2.0 * np.pi, count + 1)[:, None]
    points: Float64Array = center + radius * (np.cos(turn) * side + np.sin(turn) * np.cross(normal, side))
    return points


@dataclass
class Drawing:
    """A collection of lines, areas and labels, in pixels, to be shown over the picture.

    Icons and handles have a constant size in pixels; lines are given in world coordinates.

    Parameters
    ----------
    view : View
        The subplot; see `View.in_usual_pixels`.
    color, edge : tuple of float
        Colour of the elements that are added next, and colour of the edges around areas.
    """

    view: View
    color: Vector = (1.0, 1.0, 1.0)
    edge: Vector = DARK_EDGE
    areas: list[tuple[Float64Array, ByteArray]] = field(default_factory=list)
    """Convex polygons, each of shape (k, 2), and the colour of each, RGBA."""
    labels: list[tuple[Float64Array, str]] = field(default_factory=list)
    """Short texts, each with its lower left corner in pixels."""
    _lines: list[tuple[Float64Array, ByteArray, bool]] = field(default_factory=list)

    @property
    def lines(self) -> tuple[Float64Array, ByteArray]:
        """Segments in pixels, shape (n, 2 ends, 2), and the colour of each, RGBA, shape (n, 4)."""
        segments = [np.empty((0, 2, 2)), *(segments for segments, _, _ in self._lines)]
        colors = [np.tile(color, (len(segments), 1)) for segments, color, _ in self._lines]
        return np.concatenate(segments), np.concatenate([np.empty((0, 4), np.uint8), *colors])

    @property
    def thin(self) -> BoolArray:
        """Mask of the segments in `lines` that are drawn thin, shape (n,)."""
        return np.array([is_thin for segments, _, is_thin in self._lines for _ in segments], bool)

    def line(self, points: Float64Array, strength: float = 1.0) -> None:
        """Add a line through world points, shape (n, 3). Parts that are not in front of the eye are cut off.

        `strength`, from 0 to 1, is the line's brightness.
        """
        segments = np.stack([points[:-1], points[1:]], axis=1)
        if not self.view.viewer.parallel:
            # clip the parts too near to the eye or behind it
            depth = self.view.seen(segments)[..., 2]
            near = _NEAR * float(depth.max(initial=0.0))
            if near <= 0.0:
                return
            keep = (depth > near).any(axis=1)
            segments, depth = segments[keep], depth[keep]
            span = depth[:, ::-1] - depth
            part = np.clip((near - depth) / np.where(span > 0.0, span, np.inf), 0.0, 1.0)[..., None]
            segments = segments + part * (segments[:, ::-1] - segments)
        self._add_lines(self.view.project(segments), strength)

    def arrowhead(self, point: Float64Array, along: Float64Array, strength: float) -> None:
        """Add the head of an arrow, with its tip at the world point `point`.

        The arrow points along the world direction `along`. `strength`, from 0 to 1, is the head's brightness. The
        head's size on the screen is constant.
        """
        if not self.view.is_ahead(point):
            return
        end = self.view.project(point)
        back = self._on_screen(point, -along)
        for turn in (0.45, -0.45):
            wing = 9.0 * back @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
            self._add_lines(np.array([[end, end + wing]]), strength)

    def label(self, point: Float64Array, text: str, right: float = 4.0) -> None:
        """Add a short text, `right` pixels to the right of a world point and 4 above it.

        The text is left out if the point is not visible, or the text would cross the upper edge of the picture.
        """
        if self.view.edge_towards(point, 0.0) is not None:
            return
        place = self.view.project(point) + np.array([right, 4.0])
        if place[1] + _LABEL_HEIGHT <= self.view.origin[1] + self.view.size[1]:
            self.labels.append((place, text))

    def crossed(self, point: Float64Array) -> None:
        """Add a bar across the icon at a world point, as a sign that the light is off."""
        if self.view.is_ahead(point):
            along, across = np.array([0.8, 0.6]), 0.12 * np.array([-0.6, 0.8])
            bar = np.array([-along - across, along - across, along + across, across - along])
            self._area(self.view.project(point) + 14.0 * bar, _WHITE, DARK_EDGE, 2.1)

    def arrow_out_of_sight(self, point: Float64Array) -> None:
        """Add an arrow at the subplot's edge that points to a world point. Add nothing if the point is visible."""
        found = self.view.edge_towards(point, _ARROW_MARGIN)
        if found is None:
            return
        (x, y), (along, up) = found
        ahead, side = np.array([along, up]), np.array([-up, along])
        tip = np.array([x, y]) + 8.0 * ahead
        arrow = np.array([tip, tip - 18.0 * ahead + 8.0 * side, tip - 18.0 * ahead - 8.0 * side])
        self._area(arrow, self.color, self.edge, 2.8)

    def icon(self, point: Float64Array, shape: str, along: Float64Array | None = None) -> None:
        """Add an icon at a world point. `shape` is "sun", "bulb" or "lamp".

        `along` is the world direction in which a lamp shines.
        """
        if not self.view.is_ahead(point):
            return
        middle = self.view.project(point)
        if shape == "lamp" and along is not None:
            ahead = self._on_screen(point, along)
            side = np.array([-ahead[1], ahead[0]])
            mouth, back = middle + 10.0 * ahead, middle - 7.0 * ahead
            shade = np.array([back + 4.0 * side, mouth + 9.0 * side, mouth - 9.0 * side, back - 4.0 * side])
            self._area(shade, self.color, self.edge, 2.1)
            return
        self._area(middle + 6.0 * _CIRCLE[:-1], self.color, self.edge)
        if shape == "bulb":
            self._add_lines(middle + 10.0 * _CHORDS, 1.0)
        else:
            rays = _CIRCLE[:-1:3]
            self._add_lines(middle + np.stack([9.0 * rays, 14.0 * rays], axis=1), 1.0)

    def handle(self, point: Float64Array, *, hovered: bool = False) -> None:
        """Add a dot at the world point of a handle. If hovered, the dot is larger and has a white ring."""
        if not self.view.is_ahead(point):
            return
        middle = self.view.project(point)
        if hovered:
            self._area(middle + 9.0 * _CIRCLE[:-1], _WHITE, self.edge)
        self._area(middle + (6.0 if hovered else 5.0) * _CIRCLE[:-1], self.color, self.edge)

    def ring(self, point: Float64Array, *, hovered: bool = False) -> None:
        """Add a ring around the world point of a handle. If hovered, add a second, white ring.

        Unlike a dot, a ring does not cover what is inside.
        """
        if not self.view.is_ahead(point):
            return
        for radius, color in ((8.0, self.color), (11.0, _WHITE))[: 2 if hovered else 1]:
            self._add_lines(self.view.project(point) + radius * _CHORDS, 1.0, color)

    def _on_screen(self, point: Float64Array, along: Float64Array) -> Float64Array:
        """Return the unit vector on the screen of the world direction `along`, at the world point `point`.

        If the direction points at the eye, the result is downwards.
        """
        step = 20.0 * self.view.unit_per_pixel(point)
        motion = self.view.project(point + step * along) - self.view.project(point)
        length = float(np.hypot(*motion))
        return motion / length if length > 1.0 else np.array([0.0, -1.0])

    def _area(self, corners: Float64Array, color: Vector, edge: Vector, wide: float = 1.5) -> None:
        """Add a convex polygon with its corners in pixels, shape (k, 2).

        `color` fills the polygon. An edge with the colour `edge` extends `wide` pixels beyond the corners.
        """
        away = corners - corners.mean(axis=0)
        grown = corners + wide * away / np.linalg.norm(away, axis=1, keepdims=True)
        self.areas += [(grown, _bytes(edge)), (corners, _bytes(color))]

    def _add_lines(self, segments: Float64Array, strength: float, color: Vector | None = None) -> None:
        """Add segments in pixels, shape (n, 2 ends, 2). The default `color` is the drawing's colour.

        `strength`, from 0 to 1, is their brightness. Weak lines are dark and thin, not transparent, so that they are
        visible on any background.
        """
        red, green, blue = (0.5 + 0.5 * strength) * np.array(self.color if color is None else color)
        self._lines.append((segments, _bytes((red, green, blue)), strength < _THICK_FROM))


def _bytes(color: Vector) -> ByteArray:
    return np.rint(255.0 * np.clip([*color, 1.0], 0.0, 1.0)).astype(np.uint8)


# -- in VTK's window

_EDGE_LAYER, _LINE_LAYER, _AREA_LAYER, _TEXT_LAYER = range(4)
# Widths of lines, in pixels, and of their dark edges, which make them visible on any background.
_THIN, _THICK, _EDGE = 1.0, 2.0, 2.0
_LINE_EDGE = (0.04, 0.04, 0.04)
_FROM_CURSOR, _MARGIN = 18.0, 8.0
_NORMAL, _SMALL = 14, 12  # font sizes
_HELP_LETTER = np.array([8.2, 15.2])  # size of a character in the help, a monospaced font, in pixels
_LETTER = (7.5, 18.0)  # largest size of a character in other texts, in pixels


class Overlay:
    """VTK's actors over the picture: lines with dark edges, areas above them, and texts.

    The actors are not lit, cannot be picked, and do not count towards the scene's bounds.
    """

    def __init__(self) -> None:
        self.scale = 1.0
        """Device pixels per pixel. VTK enlarges the texts itself, by the window's dots per inch."""
        self._lines = {thin: (vtkPolyData(), vtkPolyData()) for thin in (True, False)}
        self._areas = vtkPolyData()
        self._readout, self._help, self._status = _text(), _text(), _text()
        self._help.GetTextProperty().SetVerticalJustificationToTop()
        self._help.GetTextProperty().SetFontFamilyToCourier()
        self._status.GetTextProperty().SetJustificationToRight()
        self._labels: list[vtkTextActor] = []
        self._props: list[Any] = []  # in drawing order
        self._widths: dict[Any, float] = {}
        for thin, (edges, lines) in self._lines.items():
            width = _THIN if thin else _THICK
            edge, line = _actor(edges, _EDGE_LAYER), _actor(lines, _LINE_LAYER)
            edge.GetMapper().ScalarVisibilityOff()
            edge.GetProperty().SetColor(_LINE_EDGE)
            self._widths |= {edge: width + _EDGE, line: width}
            self._props += [edge, line]
        self._props += [_actor(self._areas, _AREA_LAYER), self._readout, self._help, self._status]
        self._is_shown = True

    def attach(self, renderer: Any) -> None:
        """Add the overlay to a renderer, if it is not there already."""
        for prop in self._props:
            if not renderer.HasViewProp(prop):
                renderer.AddViewProp(prop)

    def detach(self, renderer: Any) -> None:
        """Remove the overlay from a renderer."""
        for prop in self._props:
            renderer.RemoveViewProp(prop)

    def show(self, shown: bool) -> None:
        """Show or hide the overlay."""
        self._is_shown = shown
        for prop in self._props:
            prop.SetVisibility(shown)

    def put(self, drawing: Drawing) -> None:
        """Show a drawing in place of the previous one."""
        segments, colors = drawing.lines
        segments = self.scale * segments
        for actor, width in self._widths.items():
            actor.GetProperty().SetLineWidth(self.scale * width)
        for thin, both in self._lines.items():
            chosen = drawing.thin == thin
            for data in both:
                _fill(data, segments[chosen].reshape(-1, 2), np.full(chosen.sum(), 2), colors[chosen], data.SetLines)
        corners = [corners for corners, _ in drawing.areas]
        points = self.scale * np.concatenate([np.empty((0, 2)), *corners])
        tints = np.array([color for _, color in drawing.areas], np.uint8).reshape(-1, 4)
        _fill(self._areas, points, np.array([len(polygon) for polygon in corners]), tints, self._areas.SetPolys)
        while len(self._labels) < len(drawing.labels):
            self._labels.append(_text(_SMALL))
            self._props.append(self._labels[-1])
        for actor in self._labels:
            actor.SetVisibility(False)
        for actor, (place, text) in zip(self._labels, drawing.labels, strict=False):
            actor.SetPosition(*(self.scale * (place - drawing.view.origin)))
            self._show_text(actor, text)

    def _show_text(self, actor: vtkTextActor, text: str) -> None:
        actor.SetInput(text)
        actor.SetVisibility(bool(text) and self._is_shown)

    def status(self, text: str, size: tuple[float, float]) -> None:
        """Show a text in the lower right corner of a subplot of `size` pixels; an empty text shows nothing."""
        width = max(int((size[0] - 2 * _MARGIN) / _LETTER[0]), 8)
        self._status.SetPosition(self.scale * (size[0] - _MARGIN), self.scale * _MARGIN)
        self._show_text(self._status, "\n".join(textwrap.fill(line, width) for line in text.split("\n")))

    def readout(self, text: str, cursor: tuple[float, float], size: tuple[float, float]) -> None:
        """Show a text next to the cursor, on the side away from the subplot's middle if it fits there.

        An empty text shows nothing. `cursor` is a position in pixels, and `size` the size of the subplot in pixels.
        """
        lines = text.split("\n")
        needed = _FROM_CURSOR + _LETTER[0] * max(map(len, lines)), _FROM_CURSOR + _LETTER[1] * len(lines)
        right, up = (
            at + need <= side if at >= 0.5 * side else at < need
            for at, need, side in zip(cursor, needed, size, strict=True)
        )
        style = self._readout.GetTextProperty()
        (style.SetJustificationToLeft if right else style.SetJustificationToRight)()
        (style.SetVerticalJustificationToBottom if up else style.SetVerticalJustificationToTop)()
        x, y = cursor
        x = min(x, size[0] - needed[0]) + _FROM_CURSOR if right else max(x, needed[0]) - _FROM_CURSOR
        self._readout.SetPosition(self.scale * x, self.scale * (y + (_FROM_CURSOR if up else -_FROM_CURSOR)))
        self._show_text(self._readout, text)

    def help(self, text: str, size: tuple[float, float]) -> bool:
        """Show a text in the upper left corner of a subplot of `size` pixels; an empty text shows nothing.

        Return True if the text fits at its normal size. Otherwise the text is made smaller to fit, and other texts have
        no room.
        """
        lines = text.split("\n")
        room = np.array(size) - 2.0 * _MARGIN
        fits = min(room / (_HELP_LETTER * (max(map(len, lines)), len(lines) + 2))) if text else 1.0
        self._help.GetTextProperty().SetFontSize(max(int(_NORMAL * min(fits, 1.0)), 5))
        self._help.SetPosition(self.scale * _MARGIN, self.scale * (size[1] - _MARGIN))
        self._show_text(self._help, text)
        return bool(fits >= 1.0)


def _actor(data: vtkPolyData, layer: int) -> Any:
    pixels = vtkCoordinate()
    pixels.SetCoordinateSystemToDisplay()
    mapper = vtkPolyDataMapper2D()
    mapper.SetInputData(data)
    mapper.SetTransformCoordinate(pixels)
    actor = vtkActor2D()
    actor.SetMapper(mapper)
    actor.SetLayerNumber(layer)
    actor.UseBoundsOff()
    actor.PickableOff()
    return actor


def _text(size: int = _NORMAL) -> Any:
    actor = vtkTextActor()
    actor.SetLayerNumber(_TEXT_LAYER)
    actor.SetVisibility(False)
    actor.UseBoundsOff()
    actor.PickableOff()
    style = actor.GetTextProperty()
    style.SetFontSize(size)
    style.SetColor(1.0, 1.0, 1.0)
    style.SetBackgroundColor(0.1, 0.1, 0.1)
    style.SetBackgroundOpacity(0.85)
    return actor


def _fill(data: vtkPolyData, points: Float64Array, sizes: Any, colors: ByteArray, set_cells: Any) -> None:
    """Replace the points and cells of a mesh whose coordinates are pixels.

    Parameters
    ----------
    data : vtkPolyData
        The mesh.
    points : ndarray
        Shape (n, 2), the points of all cells, one cell after the other.
    sizes : array_like of int
        Number of points of each cell.
    colors : ndarray
        Colour of each cell, uint8.
    set_cells : callable
        Method of `data` that sets the cells, such as `data.SetLines`.
    """
    coordinates = vtkPoints()
    coordinates.SetData(numpy_to_vtk(np.column_stack([points, np.zeros(len(points))]).astype(np.float32), deep=True))
    cells = vtkCellArray()
    offsets, indices = np.append(0, np.cumsum(sizes)).astype(np.int64), np.arange(len(points), dtype=np.int64)
    cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(indices, deep=True))
    data.SetPoints(coordinates)
    set_cells(cells)
    data.GetCellData().SetScalars(numpy_to_vtk(np.ascontiguousarray(colors), deep=True))
