"""What is frozen when a drag starts, and where the cursor is now."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.optics.light import Light
from pvphong.studio.gizmos.view import View


@dataclass(frozen=True)
class Scenery:
    """What a gizmo knows of the scene it stands in.

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
        The pane.
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
        """What lengths and coordinates snap to."""
        return round_step(self.scenery.size / 20.0) if self.length_step is None else self.length_step

    def picture(self, at: Cursor) -> Float64Array:
        """Where on the screen the handle is to go: it keeps its distance from the cursor."""
        return self.view.project(self.point) + self.motion(at)

    def motion(self, at: Cursor) -> Float64Array:
        """The way of the cursor since the start."""
        return np.array(at.position) - np.array(self.cursor)

    def moved(self, at: Cursor) -> Float64Array:
        """The handle moved with the cursor, parallel to the picture; constrained: along a world axis."""
        point = np.array(self.point)
        if not self.view.is_ahead(point) or not self.motion(at).any():
            return point
        if not at.constrained:
            return self.view.facing(point, self.picture(at))
        axis = self.view.axis_along(point, self.motion(at))
        return point if axis is None else self.view.along(point, axis, self.motion(at))

    def moved_on_grid(self, at: Cursor) -> Float64Array:
        """As `moved`; snapping: to the grid, but for coordinates in which the handle does not move."""
        point = self.moved(at)
        if not at.snapping:
            return point
        stays = np.abs(point - self.point) <= 1e-9 * self.scenery.size
        return np.where(stays, self.point, np.round(point / self.grid) * self.grid)


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


def vector(values: VectorLike | Float64Array) -> Vector:
    """Three floats, as lights have them."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def round_step(length: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above a length > 0."""
    power = 10.0 ** math.floor(math.log10(length))
    return max((factor for factor in (1.0, 2.0, 5.0) if factor * power <= length), default=1.0) * power
