"""What a cursor means in the world: a subplot's projection, and what is frozen when a handle is grabbed.

Nothing here knows a window. A drag is a function of `DragStart` and `Cursor`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.optics.light import Light
from pvphong.scene.viewer import Viewer

# How far a point may come towards the eye or go away from it along an axis, in multiples of its depth.
_NEAREST, _FARTHEST = 0.02, 50.0
# An axis whose picture is shorter than this fraction of the longest points at the eye.
_END_ON = 0.05
# The sine of the angle below which a direction points at the eye.
_AT_THE_EYE = 1e-3
# A depth of this fraction of the coordinates that it is computed from may be rounded zero.
_BESIDE = 1e-9

STANDS_OFF = 0.95
"""How far off the scene's middle the icon of a light without a place stands, in scene sizes."""

Pixel = tuple[float, float]


@dataclass(frozen=True)
class View:
    """A subplot of a window and the eye behind it.

    Parameters
    ----------
    viewer : Viewer
        The eye.
    size : tuple of float
        Width and height of the subplot, in pixels.
    origin : tuple of float, default (0, 0)
        The subplot's lower left corner in the window, in pixels.
    """

    viewer: Viewer
    size: tuple[float, float]
    origin: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def _middle(self) -> Float64Array:
        return np.array(self.origin) + 0.5 * np.array(self.size)

    @cached_property
    def _zoom(self) -> float:
        """Pixels per unit: of a slope in perspective, of a length in parallel projection."""
        half = 0.5 * self.size[1]
        if self.viewer.parallel:
            return half / self.viewer.parallel_scale
        return half / math.tan(math.radians(0.5 * self.viewer.view_angle))

    def seen(self, points: VectorLike | Float64Array) -> Float64Array:
        """Points or one point, (…, 3), in eye space: right, up, and the depth in front of the eye."""
        away = np.asarray(points, dtype=np.float64) - np.array(self.viewer.position)
        return away @ self.viewer.axes.T * (1.0, 1.0, -1.0)

    def is_ahead(self, point: VectorLike | Float64Array) -> bool:
        """Whether a point has a place in the picture; in parallel projection every point has.

        A point beside the eye has none, although its depth may be rounded to a little more than zero.
        """
        if self.viewer.parallel:
            return True
        seen = self.seen(point)
        return bool(seen[2] > _BESIDE * (math.hypot(*seen) + math.hypot(*self.viewer.position)))

    def project(self, points: VectorLike | Float64Array) -> Float64Array:
        """Pixels, (…, 2), of points (…, 3); NaN at and behind the eye of a perspective."""
        seen = self.seen(points)
        flat = seen[..., :2]
        if not self.viewer.parallel:
            depth = np.where(seen[..., 2:] > 0.0, seen[..., 2:], np.nan)
            flat = flat / depth
        return self._middle + self._zoom * flat

    def edge_towards(self, point: VectorLike | Float64Array, margin: float) -> tuple[Pixel, Pixel] | None:
        """Where, so many pixels inside the edge, a point out of sight is to be looked for; None if it is seen.

        Returns
        -------
        place, direction : tuple of float
            In pixels, and the unit vector on the screen towards it; downwards for what is straight behind.
        """
        half = 0.5 * np.array(self.size)
        if self.is_ahead(point):
            offset = self.project(point) - self._middle
            if (np.abs(offset) <= half).all():
                return None
        else:
            offset = self.seen(point)[:2]
        length = float(np.hypot(*offset))
        offset = offset / length if length else np.array([0.0, -1.0])
        steps = np.maximum(half - margin, 1.0) / np.maximum(np.abs(offset), 1e-9)
        x, y = (self._middle + steps.min() * offset).tolist()
        return (x, y), (float(offset[0]), float(offset[1]))

    def unit_per_pixel(self, point: VectorLike | Float64Array) -> float:
        """How long one pixel is in the world at the depth of a point ahead."""
        return 1.0 / self._zoom if self.viewer.parallel else float(self.seen(point)[2]) / self._zoom

    def facing(self, point: VectorLike | Float64Array, cursor: VectorLike | Float64Array) -> Float64Array:
        """Where the cursor meets the plane through a point that is parallel to the picture."""
        x, y = (np.asarray(cursor) - self._middle) * self.unit_per_pixel(point)
        right, up, back = self.viewer.axes
        return np.array(self.viewer.position) + x * right + y * up - self.seen(point)[2] * back

    def towards_eye(self, points: VectorLike | Float64Array) -> Float64Array:
        """Unit vectors, (…, 3), from points to the eye, zero at the eye; in parallel projection all the same."""
        points = np.asarray(points, dtype=np.float64)
        if self.viewer.parallel:
            return np.broadcast_to(-np.array(self.viewer.view_direction), points.shape)
        away = np.array(self.viewer.position) - points
        length = np.linalg.norm(away, axis=-1, keepdims=True)
        return np.divide(away, length, out=np.zeros_like(away), where=length > 0.0)

    def across(self, along: Float64Array, point: VectorLike | Float64Array) -> Float64Array:
        """Unit vector square to one through a point, as nearly as can be in the picture; at the eye: to the right."""
        return self._square_to(along, self.towards_eye(point))

    def level(self, normal: Float64Array) -> Float64Array:
        """Unit vector that is square to one and parallel to the picture; to the right where that faces the eye."""
        return self._square_to(normal, self.viewer.axes[2])

    def _square_to(self, axis: Float64Array, other: Float64Array) -> Float64Array:
        """Unit vector that is square to two; where these are parallel, square to the axis, to the right."""
        side, right = np.cross(axis, other), self.viewer.axes[0]
        if np.linalg.norm(side) < _AT_THE_EYE:
            side = right - (right @ axis) * axis
        return np.asarray(side / np.linalg.norm(side))

    def along(self, point: Float64Array, axis: Float64Array, motion: Float64Array) -> Float64Array:
        """A point moved along an axis, as far as the cursor's motion goes in the axis's direction on the screen.

        Towards the vanishing point it moves to 50 times its depth at most, towards the eye to a fiftieth.
        """
        picture = self._picture_of(point, axis)
        length = float(np.hypot(*picture))
        if length == 0.0:
            return point
        advance = float(picture @ motion) / length
        toward = -float(self.viewer.axes[2] @ axis)  # change of depth along the axis
        depth = float(self.seen(point)[2])
        if self.viewer.parallel or toward == 0.0:
            return point + axis * (advance / length)
        # the picture of point + t·axis lies at (length · depth · t) / (depth + toward · t) along the axis's picture
        left = length * depth - toward * advance
        t = advance * depth / left if left > 0.0 else math.copysign(math.inf, toward)
        limits = sorted(((_NEAREST - 1.0) * depth / toward, (_FARTHEST - 1.0) * depth / toward))
        return point + axis * min(max(t, limits[0]), limits[1])

    def axis_along(self, point: Float64Array, motion: Float64Array) -> Float64Array | None:
        """The world axis whose picture runs most nearly along a motion; none that points at the eye."""
        pictures = np.array([self._picture_of(point, axis) for axis in np.eye(3)])
        lengths = np.hypot(*pictures.T)
        if not np.any(motion) or not lengths.any():
            return None
        fits = np.where(lengths > _END_ON * lengths.max(), np.abs(pictures @ motion) / (lengths + 1e-300), -1.0)
        return np.eye(3)[int(np.argmax(fits))]

    def _picture_of(self, point: Float64Array, axis: Float64Array) -> Float64Array:
        """Pixels per unit, as a vector on the screen, in which a point ahead starts to move along an axis."""
        along = self.viewer.axes @ axis * (1.0, 1.0, -1.0)
        if self.viewer.parallel:
            return self._zoom * along[:2]
        seen = self.seen(point)
        slope: Float64Array = along[:2] / seen[2] - seen[:2] / seen[2] * (along[2] / seen[2])
        return self._zoom * slope


@dataclass(frozen=True)
class Scenery:
    """What a gizmo knows of the scene around it.

    Parameters
    ----------
    center : tuple of float
        Middle of what is drawn.
    size : float
        Half the diagonal of what is drawn, > 0.
    anchor : tuple of float
        What stays where it is while a light without a place is turned.
    behind : float, default 0
        How far from there, against its aim, the icon of such a light stands.
    """

    center: Vector
    size: float
    anchor: Vector
    behind: float = 0.0


@dataclass(frozen=True)
class Cursor:
    """The cursor during a drag.

    Parameters
    ----------
    position : tuple of float
        In pixels of the window, from its lower left corner.
    constrained : bool, default False
        Whether the handle moves along one axis only.
    snapping : bool, default False
        Whether it moves in steps.
    """

    position: tuple[float, float]
    constrained: bool = False
    snapping: bool = False


@dataclass(frozen=True)
class DragStart:
    """A handle that has been grabbed.

    Parameters
    ----------
    light : Light
        The light at that time, in the world.
    handle : str
        Which of its handles.
    point : tuple of float
        Where the handle was.
    cursor : tuple of float
        Where the cursor was, in pixels of the window.
    view : View
        The subplot.
    scenery : Scenery
        The scene.
    angle_step : float, default 5
        What angles snap to, in degrees.
    length_step : float, optional
        What lengths and coordinates snap to; a round twentieth to fiftieth of the scene's size if not given.
    """

    light: Light
    handle: str
    point: Vector
    cursor: tuple[float, float]
    view: View
    scenery: Scenery
    angle_step: float = 5.0
    length_step: float | None = None

    @property
    def grid(self) -> float:
        """What lengths and coordinates snap to; by default 1, 2 or 5 times a power of ten up to a twentieth."""
        if self.length_step is not None:
            return self.length_step
        length = self.scenery.size / 20.0
        power = 10.0 ** math.floor(math.log10(length))
        return max((factor for factor in (1.0, 2.0, 5.0) if factor * power <= length), default=1.0) * power

    def picture(self, cursor: Cursor) -> Float64Array:
        """Where on the screen the handle is to go: it keeps its distance from the cursor."""
        return self.view.project(self.point) + self.motion(cursor)

    def motion(self, cursor: Cursor) -> Float64Array:
        """How far the cursor has gone since the start, in pixels."""
        return np.array(cursor.position) - np.array(self.cursor)

    def moved(self, cursor: Cursor) -> Float64Array:
        """The handle moved with the cursor, parallel to the picture; constrained: along a world axis."""
        point = np.array(self.point)
        if not self.view.is_ahead(point) or not self.motion(cursor).any():
            return point
        if not cursor.constrained:
            return self.view.facing(point, self.picture(cursor))
        axis = self.view.axis_along(point, self.motion(cursor))
        return point if axis is None else self.view.along(point, axis, self.motion(cursor))


def vector(values: VectorLike | Float64Array) -> Vector:
    """Three floats, as lights have them."""
    x, y, z = (float(value) for value in values)
    return x, y, z
