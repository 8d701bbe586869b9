"""What gizmos look like, as coloured lines and areas in pixels: nothing here knows a window."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pvphong.base.types import BoolArray, ByteArray, Float64Array, Vector, rgb
from pvphong.optics.lights import Light
from pvphong.studio.gizmos.view import View

_ROUND = np.linspace(0.0, 2.0 * np.pi, 25)
_OFF = 0.45
_WHITE = (1.0, 1.0, 1.0)
DARK, LIGHT = (0.08, 0.08, 0.08), (0.75, 0.75, 0.75)
"""Edges of areas: the second where the area itself is dark."""

# Lines of at least this strength are drawn thick.
_THICK = 0.8
# Between the edge of the pane and an arrow there, in pixels.
_MARGIN = 16.0
_LETTERS_HIGH = 16.0
# Lines of perspectives end where their depth is this fraction of their farthest point's.
_NEAR = 1e-3


def hue(light: Light) -> Vector:
    """The light's hue and saturation at full value; a light that is off is dimmed."""
    color = np.array(rgb(light.diffuse))
    full = color / color.max() if color.any() else np.full(3, 0.6)
    red, green, blue = (full if light.on else full * _OFF).tolist()
    return red, green, blue


def circle(center: Float64Array, normal: Float64Array, radius: float, count: int = 64) -> Float64Array:
    """A closed line of `count` sides, shape (count + 1, 3), around a unit normal."""
    side = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    side /= np.linalg.norm(side)
    turn = np.linspace(0.0, 2.0 * np.pi, count + 1)[:, None]
    points: Float64Array = center + radius * (np.cos(turn) * side + np.sin(turn) * np.cross(normal, side))
    return points


@dataclass
class Drawing:
    """Collects lines and areas; icons and handles keep their size in pixels, lines are given in the world.

    Parameters
    ----------
    view : View
        The pane.
    color, edge : tuple of float
        Of what is added next, and of the edges of its areas.
    """

    view: View
    color: Vector = (1.0, 1.0, 1.0)
    edge: Vector = DARK
    _lines: list[Float64Array] = field(default_factory=list)
    _line_colors: list[ByteArray] = field(default_factory=list)
    _thin: list[bool] = field(default_factory=list)
    _areas: list[Float64Array] = field(default_factory=list)
    _area_colors: list[ByteArray] = field(default_factory=list)
    labels: list[tuple[Float64Array, str]] = field(default_factory=list)
    """Short texts and their lower left corners, in pixels."""

    @property
    def lines(self) -> tuple[Float64Array, ByteArray]:
        """Segments, shape (n, 2, 2), and their colours, RGBA, shape (n, 4)."""
        if not self._lines:
            return np.empty((0, 2, 2)), np.empty((0, 4), np.uint8)
        return np.concatenate(self._lines), np.concatenate(self._line_colors)

    @property
    def thin(self) -> BoolArray:
        """Which of the segments are drawn thin, shape (n,)."""
        return np.repeat(np.array(self._thin, bool), [len(lines) for lines in self._lines])

    @property
    def areas(self) -> list[tuple[Float64Array, ByteArray]]:
        """Convex polygons, each of shape (k, 2), and their colours, RGBA."""
        return list(zip(self._areas, self._area_colors, strict=True))

    def line(self, points: Float64Array, strength: float = 1.0) -> None:
        """A line through points of the world, as far as it lies ahead of the eye."""
        self._add_lines(self._visible(np.stack([points[:-1], points[1:]], axis=1)), strength)

    def tip(self, point: Float64Array, along: Float64Array, strength: float) -> None:
        """An arrow's tip, as large on the screen everywhere."""
        if not self.view.is_ahead(point):
            return
        end = self.view.project(point)
        back = self._on_screen(point, -along)
        for turn in (0.45, -0.45):
            wing = 9.0 * back @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
            self._add_lines(np.array([[end, end + wing]]), strength)

    def label(self, point: Float64Array, text: str, right: float = 4.0) -> None:
        """A short text, so many pixels to the right of a point of the world."""
        if self.view.edge_towards(point, 0.0) is not None:
            return
        place = self.view.project(point) + np.array([right, 4.0])
        if place[1] + _LETTERS_HIGH <= self.view.origin[1] + self.view.size[1]:
            self.labels.append((place, text))

    def crossed(self, point: Float64Array) -> None:
        """A bar across an icon: the light is off."""
        if self.view.is_ahead(point):
            along, across = np.array([0.8, 0.6]), np.array([-0.6, 0.8])
            bar = np.array(
                [-along - 0.12 * across, along - 0.12 * across, along + 0.12 * across, 0.12 * across - along]
            )
            middle = self.view.project(point)
            self._area(middle + _grown(14.0 * bar, 1.5), DARK)
            self._area(middle + 14.0 * bar, _WHITE)

    def beyond(self, point: Float64Array) -> None:
        """Where a point of the world is out of sight, an arrow towards it at the edge of the pane."""
        found = self.view.edge_towards(point, _MARGIN)
        if found is None:
            return
        (x, y), (along, up) = found
        ahead, side = np.array([along, up]), np.array([-up, along])
        tip = np.array([x, y]) + 8.0 * ahead
        arrow = np.array([tip, tip - 18.0 * ahead + 8.0 * side, tip - 18.0 * ahead - 8.0 * side])
        self._area(_grown(arrow, 2.0), self.edge)
        self._area(arrow, self.color)

    def icon(self, point: Float64Array, shape: str, along: Float64Array | None = None) -> None:
        """A sun, a bulb, or a lamp that shines along a direction of the world."""
        if not self.view.is_ahead(point):
            return
        middle = self.view.project(point)
        ring = np.stack([np.cos(_ROUND), np.sin(_ROUND)], axis=1)
        if shape == "lamp" and along is not None:
            self._lamp(middle, self._on_screen(point, along))
            return
        self._disc(middle, 6.0, self.color)
        if shape == "bulb":
            self._add_lines(middle + 10.0 * np.stack([ring[:-1], ring[1:]], axis=1), 1.0)
        else:
            rays = ring[:-1:3]
            self._add_lines(middle + np.stack([9.0 * rays, 14.0 * rays], axis=1), 1.0)

    def _lamp(self, middle: Float64Array, ahead: Float64Array) -> None:
        side = np.array([-ahead[1], ahead[0]])
        mouth, back = middle + 10.0 * ahead, middle - 7.0 * ahead
        shade = np.array([back + 4.0 * side, mouth + 9.0 * side, mouth - 9.0 * side, back - 4.0 * side])
        self._area(_grown(shade, 1.5), self.edge)
        self._area(shade, self.color)

    def handle(self, point: Float64Array, *, hovered: bool = False, strength: float = 1.0) -> None:
        """A dot to grab; hovered: larger, with a white ring."""
        if not self.view.is_ahead(point):
            return
        middle = self.view.project(point)
        if hovered:
            self._disc(middle, 9.0, _WHITE)
        red, green, blue = (np.array(self.color) * strength).tolist()
        self._disc(middle, 6.0 if hovered else 5.0, (red, green, blue))

    def ring(self, point: Float64Array, *, hovered: bool = False) -> None:
        """A ring to grab, with what is inside left to be seen; hovered: with a white one around it."""
        if not self.view.is_ahead(point):
            return
        turns = np.stack([np.cos(_ROUND), np.sin(_ROUND)], axis=1)
        for radius, color in ((8.0, self.color), (11.0, _WHITE))[: 2 if hovered else 1]:
            points = self.view.project(point) + radius * turns
            self._add_lines(np.stack([points[:-1], points[1:]], axis=1), 1.0, color)

    def _on_screen(self, point: Float64Array, along: Float64Array) -> Float64Array:
        """Unit vector on the screen of a direction; downwards where that points at the eye."""
        step = 20.0 * self.view.unit_per_pixel(point)
        way = self.view.project(point + step * along) - self.view.project(point)
        length = float(np.hypot(*way))
        return way / length if length > 1.0 else np.array([0.0, -1.0])

    def _disc(self, middle: Float64Array, radius: float, color: Vector) -> None:
        ring = np.stack([np.cos(_ROUND[:-1]), np.sin(_ROUND[:-1])], axis=1)
        self._area(middle + (radius + 1.5) * ring, self.edge)
        self._area(middle + radius * ring, color)

    def _area(self, corners: Float64Array, color: Vector) -> None:
        self._areas.append(corners)
        self._area_colors.append(_bytes(color))

    def _add_lines(self, segments: Float64Array, strength: float, color: Vector | None = None) -> None:
        """Weak lines are darker and thin, not transparent: what is behind them would decide whether they are seen."""
        red, green, blue = (0.5 + 0.5 * strength) * np.array(self.color if color is None else color)
        self._lines.append(segments)
        self._line_colors.append(np.tile(_bytes((red, green, blue)), (len(segments), 1)))
        self._thin.append(strength < _THICK)

    def _visible(self, segments: Float64Array) -> Float64Array:
        """Pixels of segments (n, 2, 3), cut off where they come too near to a perspective's eye or behind it."""
        if self.view.viewer.parallel:
            return self.view.project(segments)
        depth = self.view.seen(segments)[..., 2]
        near = _NEAR * float(depth.max(initial=0.0))
        if near <= 0.0:
            return np.empty((0, 2, 2))
        keep = (depth > near).any(axis=1)
        segments, depth = segments[keep], depth[keep]
        ends = []
        for this, other in ((0, 1), (1, 0)):
            span = depth[:, other] - depth[:, this]
            part = np.clip((near - depth[:, this]) / np.where(span > 0.0, span, np.inf), 0.0, 1.0)
            ends.append(segments[:, this] + part[:, None] * (segments[:, other] - segments[:, this]))
        return self.view.project(np.stack(ends, axis=1))


def _grown(corners: Float64Array, by: float) -> Float64Array:
    away = corners - corners.mean(axis=0)
    return corners + by * away / np.linalg.norm(away, axis=1, keepdims=True) * np.sqrt(2.0)


def _bytes(color: Vector) -> ByteArray:
    return np.rint(255.0 * np.clip([*color, 1.0], 0.0, 1.0)).astype(np.uint8)
