"""The viewer of a scene."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Self

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, InitSignature, Vector, VectorLike
from pvphong.base.vectors import towards, unit_vector
from pvphong.geometry.extent import Box, corners_of

# Below this sine of the angle between up and the view axis, rounding errors dominate their cross product.
_PARALLEL = 2.0**-48

# Radius that vtkRenderer::ResetCamera assumes for a single point; and the smallest radius, relative to the largest
# coordinate of the centre, so that rounding does not move the eye onto the point.
_POINT_RADIUS, _LEAST_RADIUS = 0.5, 1e-9


@dataclass(frozen=True)
class Viewer:
    """Position and direction of the eye.

    Colours depend only on `position`, `focal_point` and `parallel`, and on `up` if a light is in the camera's frame.
    The other fields are for `pvphong.pipeline.project`.

    Parameters
    ----------
    position : sequence of float, default (0, 0, 1)
        The eye, in world coordinates.
    focal_point : sequence of float, default (0, 0, 0)
        The point that the eye looks at; different from `position`.
    up : sequence of float, default (0, 1, 0)
        The direction that is up in the image. If `up` is used, it must not be parallel to the view axis.
    parallel : bool, default False
        True for parallel projection: the direction to the viewer is the same everywhere.
    view_angle : float, default 30
        Full vertical opening angle of the perspective, in degrees.
    parallel_scale : float, default 1
        Half the height of the image in parallel projection, in the mesh's unit.
    clipping_range : sequence of float, default (0.01, 1000.01)
        Distances of the near and the far plane. All defaults are vtkCamera's.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> viewer = ph.Viewer(position=(0, -4, 2), up=(0, 0, 1))
    >>> lit = pv.Sphere().phong.shade(ph.Scene([ph.DirectionalLight()], viewer))
    """

    position: VectorLike = check.field(check.vector, (0.0, 0.0, 1.0))
    focal_point: VectorLike = check.field(check.vector, (0.0, 0.0, 0.0))
    up: VectorLike = check.field(check.direction, (0.0, 1.0, 0.0))
    parallel: bool = check.field(check.flag, False)
    view_angle: float = check.field(partial(check.number, above=0.0, at_most=179.0), 30.0)
    parallel_scale: float = check.field(partial(check.number, above=0.0), 1.0)
    clipping_range: VectorLike = check.field(partial(check.numbers_in, count=2), (0.01, 1000.01))

    __signature__ = InitSignature()

    def __new__(cls, *_given: Any, **fields: Any) -> Self:
        """Raise TypeError for an unknown field; the message suggests the nearest field."""
        check.keywords(cls, fields)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        check.fields(self)
        if self.position == self.focal_point:
            check.refuse("focal_point", self.focal_point, "different from position", "The view needs a direction.")

    @classmethod
    def from_camera(cls, camera: Any) -> Self:
        """Make a viewer from a `pyvista.Camera` or `vtkCamera`.

        Raises
        ------
        ValueError
            If `camera` is neither a `pyvista.Camera` nor a `vtkCamera`.
        """
        if not hasattr(camera, "GetParallelProjection"):
            check.refuse("camera", camera, "a pyvista.Camera or a vtkCamera")
        return cls(
            position=camera.GetPosition(),
            focal_point=camera.GetFocalPoint(),
            up=camera.GetViewUp(),
            parallel=bool(camera.GetParallelProjection()),
            view_angle=camera.GetViewAngle(),
            parallel_scale=camera.GetParallelScale(),
            clipping_range=camera.GetClippingRange(),
        )

    @classmethod
    def framing(cls, bounds: VectorLike) -> Self:
        """Return PyVista's default view of a box: from the direction (1, 1, 1), z up, with the whole box in view.

        Parameters
        ----------
        bounds : sequence of float
            x_min, x_max, y_min, y_max, z_min, z_max, as from a mesh; an invalid box is replaced by the unit cube.

        Raises
        ------
        ValueError
            If `bounds` is not six numbers.
        """
        return cls(position=(1.0, 1.0, 1.0), up=(0.0, 0.0, 1.0)).moved_to_see(bounds)

    def moved_to_see(self, bounds: VectorLike) -> Self:
        """Return a copy of this viewer, moved so that a whole box is in view; the view direction stays the same.

        Parameters
        ----------
        bounds : sequence of float
            x_min, x_max, y_min, y_max, z_min, z_max of the box; an invalid box is replaced by the unit cube.
        """
        low, high = finite_box(bounds)
        center, radius = 0.5 * low + 0.5 * high, float(np.linalg.norm(0.5 * high - 0.5 * low)) or _POINT_RADIUS
        radius = max(radius, _LEAST_RADIUS * float(np.abs(center).max()))
        distance = radius / math.sin(math.radians(0.5 * self.view_angle))
        return replace(
            self,
            position=center - distance * np.array(self.view_direction),
            focal_point=center,
            parallel_scale=radius,
            clipping_range=(distance - radius, distance + radius),
        )

    def sees(self, bounds: VectorLike, aspect: float) -> bool:
        """Return True if part of a box may be in the image.

        The result is False if all corners are behind the eye, or all are beyond the same edge of the image.

        Parameters
        ----------
        bounds : sequence of float
            x_min, x_max, y_min, y_max, z_min, z_max of the box; an invalid box is replaced by the unit cube.
        aspect : float
            Width of the image divided by its height.
        """
        low, high = finite_box(bounds)
        x, y, back = self.axes @ (corners_of(low, high) - self.position).T
        half = self.parallel_scale if self.parallel else -back * math.tan(math.radians(0.5 * self.view_angle))
        beyond = [back >= 0.0, *(side > limit for v, limit in ((x, aspect * half), (y, half)) for side in (v, -v))]
        return not any(side.all() for side in beyond)

    @cached_property
    def view_direction(self) -> Vector:
        """Unit vector from the eye along the view axis."""
        x, y, z = self.focal_point
        return _vector(towards((x, y, z), np.array(self.position)[:, None])[0][:, 0])

    @cached_property
    def distance(self) -> float:
        """Distance from the eye to the focal point; at most the largest float."""
        return min(math.dist(self.position, self.focal_point), sys.float_info.max)

    @cached_property
    def axes(self) -> Float64Array:
        """Axes of eye space, x (right), y (up) and z (back), as the rows of a (3, 3) rotation.

        Raises
        ------
        ValueError
            If `up` is parallel to the view axis.
        """
        back = -np.array(self.view_direction)
        up = np.array(unit_vector(self.up))
        right = np.cross(up, back)
        if np.abs(right).max() < _PARALLEL:
            check.refuse("up", self.up, "a direction not parallel to the view axis")
        right = np.array(unit_vector(right.tolist()))
        return np.array([right, np.cross(back, right), back])

    def vector_to_world(self, vector: Vector) -> Vector:
        """Convert a vector from eye space to world coordinates."""
        with np.errstate(over="ignore", invalid="ignore"):
            return _vector(self.axes.T @ np.array(vector))

    def point_to_world(self, point: Vector) -> Vector:
        """Convert a point from eye space to world coordinates."""
        with np.errstate(over="ignore", invalid="ignore"):
            return _vector(np.array(self.position) + self.axes.T @ np.array(point))

    def vector_to_eye(self, vector: Vector) -> Vector:
        """Convert a vector from world coordinates to eye space."""
        return _vector(self.axes @ np.array(vector))

    def point_to_eye(self, point: Vector) -> Vector:
        """Convert a point from world coordinates to eye space."""
        return _vector(self.axes @ (np.array(point) - np.array(self.position)))


def finite_box(bounds: VectorLike) -> Box:
    """Return the low and the high corner of a box, shape (3,) each.

    `bounds` is x_min, x_max, y_min, y_max, z_min, z_max. An invalid box is replaced by the unit cube.

    Raises
    ------
    ValueError
        If `bounds` is not six numbers.
    """
    given = np.asarray(bounds, np.float64)
    if given.shape != (6,):
        check.refuse("bounds", bounds, "six numbers: x_min, x_max, y_min, y_max, z_min, z_max")
    low, high = given[::2], given[1::2]
    is_box = bool(np.isfinite(given).all() and (low <= high).all())
    return (low, high) if is_box else (np.zeros(3), np.ones(3))


def _vector(array: Float64Array) -> Vector:
    x, y, z = array.tolist()
    return x, y, z
