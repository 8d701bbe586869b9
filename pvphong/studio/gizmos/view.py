"""A subplot's projection between cursor and world, and the state at the start of a drag.

This module does not depend on a window. The result of a drag depends only on `DragStart` and `Cursor`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.optics.light import Light
from pvphong.scene.viewer import Viewer

# Limits of a point's depth when it moves along an axis, in multiples of its depth at the start.
_NEAREST, _FARTHEST = 0.02, 50.0
# An axis counts as pointing at the eye if its projection is shorter than this fraction of the longest projection.
_END_ON = 0.05
# A direction points at the eye if the sine of its angle to the view direction is below this.
_AT_THE_EYE = 1e-3
# A depth below this fraction of the coordinates may be a rounding error of zero.
_BESIDE = 1e-9

STANDS_OFF = 0.95
"""Distance between the scene's centre and the icon of a light without a position, in scene sizes."""

USUAL_DPI = 72
"""Dots per inch of a VTK window on a screen of usual resolution."""

Pixel = tuple[float, float]


@dataclass(frozen=True)
class View:
    """The view of a subplot: its eye and its pixels.

    Parameters
    ----------
    viewer : Viewer
        The eye.
    size : tuple of float
        Width and height of the subplot, in pixels.
    origin : tuple of float, default (0, 0)
        The subplot's lower left corner in the window, in pixels.
    scale : float, default 1
        Number of device pixels per pixel of a screen with usual resolution.
    """

    viewer: Viewer
    size: tuple[float, float]
    origin: tuple[float, float] = (0.0, 0.0)
    scale: float = 1.0

    @property
    def in_usual_pixels(self) -> View:
        """The same view with the pixels of a screen of usual resolution."""
        (width, height), (x, y), scale = self.size, self.origin, self.scale
        return View(self.viewer, (width / scale, height / scale), (x / scale, y / scale))

    @cached_property
    def _middle(self) -> Float64Array:
        return np.array(self.origin) + 0.5 * np.array(self.size)

    @cached_property
    def _zoom(self) -> float:
        """Pixels per unit of length in parallel projection. In perspective, pixels per unit of offset/depth."""
        half = 0.5 * self.size[1]
        if self.viewer.parallel:
            return half / self.viewer.parallel_scale
        return half / math.tan(math.radians(0.5 * self.viewer.view_angle))

    def seen(self, points: VectorLike | Float64Array) -> Float64Array:
        """Convert world points, shape (…, 3), to eye space: distances to the right of, above, and ahead of the eye."""
        away = np.asarray(points, dtype=np.float64) - np.array(self.viewer.position)
        return away @ self.viewer.axes.T * (1.0, 1.0, -1.0)

    def is_ahead(self, point: VectorLike | Float64Array) -> bool:
        """Return True if a world point can be projected: in perspective, it must be in front of the eye.

        A point beside the eye is not in front, even if rounding makes its depth slightly larger than zero. In parallel
        projection, the result is always True.
        """
        if self.viewer.parallel:
            return True
        seen = self.seen(point)
        return bool(seen[2] > _BESIDE * (math.hypot(*seen) + math.hypot(*self.viewer.position)))

    def project(self, points: VectorLike | Float64Array) -> Float64Array:
        """Return the positions in pixels, shape (…, 2), at which world points, shape (…, 3), appear on the screen.

        In perspective, positions are NaN for points at and behind the eye.
        """
        seen = self.seen(points)
        flat = seen[..., :2]
        if not self.viewer.parallel:
            depth = np.where(seen[..., 2:] > 0.0, seen[..., 2:], np.nan)
            flat = flat / depth
        return self._middle + self._zoom * flat

    def edge_towards(self, point: VectorLike | Float64Array, margin: float) -> tuple[Pixel, Pixel] | None:
        """Return place and direction of an arrow to a world point out of sight; None if the point is visible.

        The arrow is `margin` pixels inside the subplot's edge.

        Returns
        -------
        place, direction : tuple of float
            The position in pixels, and the unit vector on the screen towards the point. The vector is downwards if the
            point is straight behind the eye.
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
        """Return the size of one pixel in world units, at the depth of a world point in front of the eye."""
        return 1.0 / self._zoom if self.viewer.parallel else float(self.seen(point)[2]) / self._zoom

    def facing(self, point: VectorLike | Float64Array, cursor: VectorLike | Float64Array) -> Float64Array:
        """Return the world point under the cursor, in the plane through `point` that is parallel to the picture.

        `cursor` is a position in pixels.
        """
        x, y = (np.asarray(cursor) - self._middle) * self.unit_per_pixel(point)
        right, up, back = self.viewer.axes
        return np.array(self.viewer.position) + x * right + y * up - self.seen(point)[2] * back

    def towards_eye(self, points: VectorLike | Float64Array) -> Float64Array:
        """Return unit vectors from world points, shape (…, 3), to the eye; zero for a point at the eye.

        In parallel projection, all vectors are equal.
        """
        points = np.asarray(points, dtype=np.float64)
        if self.viewer.parallel:
            return np.broadcast_to(-np.array(self.viewer.view_direction), points.shape)
        away = np.array(self.viewer.position) - points
        length = np.linalg.norm(away, axis=-1, keepdims=True)
        return np.divide(away, length, out=np.zeros_like(away), where=length > 0.0)

    def across(self, along: Float64Array, point: VectorLike | Float64Array) -> Float64Array:
        """Return a unit vector perpendicular to the direction `along` and to the line from `point` to the eye.

        If the two are parallel, the vector points to the right.
        """
        return self._square_to(along, self.towards_eye(point))

    def level(self, normal: Float64Array) -> Float64Array:
        """Return a unit vector perpendicular to `normal` and parallel to the picture.

        If the normal is along the view axis, the vector points to the right.
        """
        return self._square_to(normal, self.viewer.axes[2])

    def _square_to(self, axis: Float64Array, other: Float64Array) -> Float64Array:
        """Return a unit vector perpendicular to the unit vectors `axis` and `other`.

        If the two are parallel, the vector is perpendicular to `axis` and points to the right.
        """
        side, right = np.cross(axis, other), self.viewer.axes[0]
        if np.linalg.norm(side) < _AT_THE_EYE:
            side = right - (right @ axis) * axis
        return np.asarray(side / np.linalg.norm(side))

    def along(self, point: Float64Array, axis: Float64Array, motion: Float64Array) -> Float64Array:
        """Return a world point moved along an axis, so that its picture follows a motion on the screen.

        The point's depth grows at most 50 times towards the vanishing point, and shrinks at most to a fiftieth.

        Parameters
        ----------
        point, axis : ndarray
            The point before the motion, and a unit vector.
        motion : ndarray
            Motion in pixels, shape (2,).
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
        # point + t·axis projects to (length · depth · t) / (depth + toward · t) along the projected axis
        left = length * depth - toward * advance
        t = advance * depth / left if left > 0.0 else math.copysign(math.inf, toward)
        limits = sorted(((_NEAREST - 1.0) * depth / toward, (_FARTHEST - 1.0) * depth / toward))
        return point + axis * min(max(t, limits[0]), limits[1])

    def axis_along(self, point: Float64Array, motion: Float64Array) -> Float64Array | None:
        """Return the unit vector of the world axis whose picture is most nearly parallel to a motion on the screen.

        The axes are drawn at the world point `point`. `motion` is in pixels. Axes that point at the eye are left out.
        The result is None if there is no motion.
        """
        pictures = np.array([self._picture_of(point, axis) for axis in np.eye(3)])
        lengths = np.hypot(*pictures.T)
        if not np.any(motion) or not lengths.any():
            return None
        fits = np.where(lengths > _END_ON * lengths.max(), np.abs(pictures @ motion) / (lengths + 1e-300), -1.0)
        return np.eye(3)[int(np.argmax(fits))]

    def _picture_of(self, point: Float64Array, axis: Float64Array) -> Float64Array:
        """Return the motion on the screen, in pixels per world unit, of the world point `point` if it moves along
        `axis`.
        """
        along = self.viewer.axes @ axis * (1.0, 1.0, -1.0)
        if self.viewer.parallel:
            return self._zoom * along[:2]
        seen = self.seen(point)
        slope: Float64Array = along[:2] / seen[2] - seen[:2] / seen[2] * (along[2] / seen[2])
        return self._zoom * slope


@dataclass(frozen=True)
class Scenery:
    """Bounds of the scene around a gizmo, and the pivot of lights without a position.

    Parameters
    ----------
    center : tuple of float
        Centre of the drawn objects.
    size : float
        Half the diagonal of the drawn objects, > 0.
    anchor : tuple of float
        Point that stays fixed while a light without a position is turned.
    behind : float, default 0
        Distance from the anchor to the icon of a light without a position. The icon is on the side from which the light
        comes.
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
        Position in pixels, from the lower left corner of the window.
    constrained : bool, default False
        True to move the handle along one axis only.
    snapping : bool, default False
        True to move the handle in steps.
    """

    position: tuple[float, float]
    constrained: bool = False
    snapping: bool = False


@dataclass(frozen=True)
class DragStart:
    """The state at the start of a drag, when the button was pressed on a handle.

    Parameters
    ----------
    light : Light
        The light, in world coordinates.
    handle : str
        Name of the handle.
    point : tuple of float
        World position of the handle.
    cursor : tuple of float
        Position of the cursor, in pixels of the window.
    view : View
        The subplot's view.
    scenery : Scenery
        The scene.
    angle_step : float, default 5
        Snapping step of angles, in degrees.
    length_step : float, optional
        Snapping step of lengths and coordinates; by default a round number from 1/50 to 1/20 of the scene's size.
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
        """Snapping step of lengths; by default 1, 2 or 5 times a power of ten, up to 1/20 of the scene's size."""
        if self.length_step is not None:
            return self.length_step
        length = self.scenery.size / 20.0
        power = 10.0 ** math.floor(math.log10(length))
        return max((factor for factor in (1.0, 2.0, 5.0) if factor * power <= length), default=1.0) * power

    def picture(self, cursor: Cursor) -> Float64Array:
        """Return the position on the screen, in pixels, at which the handle must appear.

        It keeps its offset from the cursor.
        """
        return self.view.project(self.point) + self.motion(cursor)

    def motion(self, cursor: Cursor) -> Float64Array:
        """Return the motion of the cursor since the start of the drag, in pixels, shape (2,)."""
        return np.array(cursor.position) - np.array(self.cursor)

    def moved(self, cursor: Cursor) -> Float64Array:
        """Return the world position to which the cursor has moved the handle, parallel to the picture.

        If the cursor is constrained, the handle moves along a world axis instead.
        """
        point = np.array(self.point)
        if not self.view.is_ahead(point) or not self.motion(cursor).any():
            return point
        if not cursor.constrained:
            return self.view.facing(point, self.picture(cursor))
        axis = self.view.axis_along(point, self.motion(cursor))
        return point if axis is None else self.view.along(point, axis, self.motion(cursor))


def vector(values: VectorLike | Float64Array) -> Vector:
    """Convert three numbers to a tuple of Python floats."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def nearest(
    start: DragStart,
    cursor: Cursor,
    places: Callable[[Any], Float64Array],
    tried: Float64Array,
    reluctance: float = 0.0,
) -> float | None:
    """Return the number whose world point appears nearest to the dragged handle on the screen.

    Parameters
    ----------
    start : DragStart
        The state at the start of the drag.
    cursor : Cursor
        The present cursor.
    places : callable
        Maps numbers, shape (n,), to their world points, shape (n, 3).
    tried : numpy.ndarray
        Candidates for the number, increasing and evenly spaced. The result lies between the neighbours of the best
        candidate.
    reluctance : float, default 0
        Penalty for large numbers, in pixels of distance per unit of the number's absolute value.

    Returns
    -------
    float or None
        The number; None if the cursor has not moved, or no point is visible.
    """
    if not start.motion(cursor).any():
        return None
    best, limits, step = 0.0, (tried[0], tried[-1]), float(tried[1] - tried[0])
    for _ in range(5):  # each round refines the step around the best by a factor of 20
        off = np.linalg.norm(start.view.project(places(tried)) - start.picture(cursor), axis=1)
        if np.isnan(off).all():
            return None
        best = float(tried[np.nanargmin(off + reluctance * np.abs(tried))])
        tried = np.clip(best + step * np.linspace(-1.0, 1.0, 41), *limits)
        step /= 20.0
    return best
