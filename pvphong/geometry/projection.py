"""OpenGL's viewing pipeline: world → eye → clip → normalised device → window coordinates.

Matrices are (4, 4) float64 and multiply column vectors, ``clip = projection @ view @ (x, y, z, 1)``.
In eye space the eye is the origin, x is right, y is up and the eye looks down −z.

References
----------
OpenGL 2.1 specification, sections 2.11.1 (window coordinates) and 2.11.2 (``glFrustum``, ``glOrtho``);
the ``gluPerspective`` and ``gluLookAt`` manual pages; ``vtkPerspectiveTransform::SetupCamera`` and
``vtkCamera::ComputeProjectionTransform``, whose matrices these equal.
"""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, VectorLike

_PARALLEL = 8 * np.finfo(np.float64).eps  # a sine below this is rounding, not a direction


class PerspectiveOrParallel(Protocol):
    """What `project` reads of a viewer; `pvphong.scene.scene.Viewer` has it all."""

    @property
    def position(self) -> VectorLike:
        """The eye, in world coordinates."""

    @property
    def focal_point(self) -> VectorLike:
        """What the eye looks at."""

    @property
    def up(self) -> VectorLike:
        """The direction that is up in the picture."""

    @property
    def parallel(self) -> bool:
        """Whether all rays are parallel."""

    @property
    def view_angle(self) -> float:
        """The full vertical angle of a perspective view, in degrees."""

    @property
    def parallel_scale(self) -> float:
        """Half the height of a parallel view, in world units."""

    @property
    def clipping_range(self) -> VectorLike:
        """Distances of the near and the far plane from the eye."""


def look_at(eye: VectorLike, target: VectorLike, up: VectorLike) -> Float64Array:
    """The view matrix of an eye that looks at a target, as ``gluLookAt`` gives it.

    Parameters
    ----------
    eye, target : sequence of 3 floats
        Two different positions, in world coordinates.
    up : sequence of 3 floats
        A direction of any length that is not parallel to the view; its part across the view points up
        in the picture.

    Returns
    -------
    ndarray
        (4, 4) float64, world to eye space; equals ``vtkCamera.GetModelViewTransformMatrix()``.

    Raises
    ------
    ValueError
        If a vector is not three finite numbers, `eye` equals `target`, or `up` is zero or parallel to
        the view.
    """
    origin = np.array(check.vector("eye", eye))
    rotation = _rotation(origin, np.array(check.vector("target", target)), up)
    result = np.eye(4)
    result[:3, :3] = rotation
    result[:3, 3] = -_product(rotation, origin)
    return result


def _rotation(eye: Float64Array, target: Float64Array, up: VectorLike) -> Float64Array:
    """The rows right, up and backward: the rotation from world to eye space."""
    backward = _unit(eye * 0.5 - target * 0.5)  # halved first: the difference of two huge numbers overflows
    if not backward.any():
        check.refuse("target", target.tolist(), "another point than eye", "A view needs a direction.")
    upward = _unit(np.array(check.direction("up", up)))
    right = np.cross(upward, backward)
    if math.hypot(*right) <= _PARALLEL:
        check.refuse("up", list(up), "a direction across the view, not along it", f"The view is along {-backward}.")
    right = _unit(right)
    return np.stack([right, np.cross(backward, right), backward])


def _unit(vector: Float64Array) -> Float64Array:
    """The vector at length 1, or zero as it stands; no length is too small or too large."""
    _, exponent = math.frexp(float(np.abs(vector).max()))
    scaled = np.ldexp(vector, -exponent)
    length = math.hypot(*scaled)
    return scaled / length if length > 0 else scaled


def _product(rotation: Float64Array, vector: Float64Array) -> Float64Array:
    """``rotation @ vector``, its sums rounded once: for an eye far away its terms may cancel."""
    return np.array([math.fsum(row * vector) for row in rotation])


def frustum(left: float, right: float, bottom: float, top: float, near: float, far: float) -> Float64Array:
    """The perspective projection of a window on the near plane, as ``glFrustum`` gives it.

    Parameters
    ----------
    left, right, bottom, top : float
        The window's edges on the near plane, in eye coordinates; left and right, bottom and top differ.
        Swapped edges mirror the picture, as in OpenGL.
    near, far : float
        Distances of the clipping planes from the eye, 0 < near < far.

    Returns
    -------
    ndarray
        (4, 4) float64, eye to clip space; w is the depth in front of the eye.

    Raises
    ------
    ValueError
        If the window has no size, or the planes are not in order.
    """
    left, right, bottom, top = _window(left, right, bottom, top)
    near, far = _planes(near, far, above=0.0)
    width, height, depth = right - left, top - bottom, far - near
    return _finite_matrix(
        [
            [2 * (near / width), 0, right / width + left / width, 0],
            [0, 2 * (near / height), top / height + bottom / height, 0],
            [0, 0, -(far / depth + near / depth), -2 * far * (near / depth)],
            [0, 0, -1, 0],
        ]
    )


def ortho(left: float, right: float, bottom: float, top: float, near: float, far: float) -> Float64Array:
    """The parallel projection of a box, as ``glOrtho`` gives it.

    Parameters
    ----------
    left, right, bottom, top : float
        The window's edges, in eye coordinates; left and right, bottom and top differ.
    near, far : float
        Distances of the clipping planes from the eye, near < far; a negative one lies behind the eye.

    Returns
    -------
    ndarray
        (4, 4) float64, eye to clip space; w is 1.

    Raises
    ------
    ValueError
        If the window has no size, or the planes are not in order.
    """
    left, right, bottom, top = _window(left, right, bottom, top)
    near, far = _planes(near, far)
    width, height, depth = right - left, top - bottom, far - near
    return _finite_matrix(
        [
            [2 / width, 0, 0, -(right / width + left / width)],
            [0, 2 / height, 0, -(top / height + bottom / height)],
            [0, 0, -2 / depth, -(far / depth + near / depth)],
            [0, 0, 0, 1],
        ]
    )


def perspective(view_angle: float, aspect: float, near: float, far: float) -> Float64Array:
    """The perspective projection of a view angle, as ``gluPerspective`` gives it.

    Parameters
    ----------
    view_angle : float
        The full vertical angle, in degrees, 0 < view_angle < 180.
    aspect : float
        The window's width divided by its height, > 0.
    near, far : float
        Distances of the clipping planes from the eye, 0 < near < far.

    Returns
    -------
    ndarray
        (4, 4) float64, eye to clip space; equals ``vtkCamera.GetProjectionTransformMatrix(aspect, -1, 1)``.

    Raises
    ------
    ValueError
        If the angle or the aspect is out of range, or the planes are not in order.
    """
    angle = check.number("view_angle", view_angle, above=0.0)
    if angle >= 180:
        check.refuse("view_angle", view_angle, "a full angle in degrees, > 0 and < 180")
    aspect = check.number("aspect", aspect, above=0.0)
    near, _ = _planes(near, far, above=0.0)
    top = near * math.tan(math.radians(angle) / 2)
    return frustum(-top * aspect, top * aspect, -top, top, near, far)


def _window(left: Any, right: Any, bottom: Any, top: Any) -> tuple[float, float, float, float]:
    left, right = check.number("left", left), check.number("right", right)
    bottom, top = check.number("bottom", bottom), check.number("top", top)
    if left == right or math.isinf(right - left):
        check.refuse("right", right, f"different from left, {left:g}, at a finite distance")
    if bottom == top or math.isinf(top - bottom):
        check.refuse("top", top, f"different from bottom, {bottom:g}, at a finite distance")
    return left, right, bottom, top


def _planes(near: Any, far: Any, above: float = -math.inf) -> tuple[float, float]:
    near, far = check.number("near", near, above=above), check.number("far", far)
    if far <= near or math.isinf(far - near):
        check.refuse("far", far, f"beyond near, > {near:g}", "Distances are measured from the eye.")
    return near, far


def _finite_matrix(rows: list[list[float]]) -> Float64Array:
    result = np.array(rows)
    if not np.isfinite(result).all():
        check.refuse("the view volume", str(rows), "of a size whose matrix fits into float64")
    return result


def project(points: Any, viewer: PerspectiveOrParallel, window_size: tuple[int, int]) -> Float64Array:
    """Where points appear in the window: pixels and pseudo-depth.

    The depth is OpenGL's: 0 on the near plane, 1 on the far plane, and in perspective not linear between
    them. Points outside the clipping planes or beside the window keep the coordinates that they have
    there, outside [0, 1] or outside the window. A point that is not finite, or in perspective lies on or
    behind the plane through the eye, has no place in the picture: its row is NaN.

    Parameters
    ----------
    points : array_like
        (n, 3) positions, in world coordinates.
    viewer : pvphong.Viewer
        The eye; see its fields for the view angle, the parallel scale and the clipping range.
    window_size : tuple of 2 int
        The window's width and height, in pixels.

    Returns
    -------
    ndarray
        (n, 3) float64. x and y in pixels with the origin at the window's lower left corner (pixel i
        covers i to i + 1), and the depth; VTK's display coordinates of a renderer that fills the window.

    Raises
    ------
    ValueError
        If the points are not (n, 3), the window has no size, or the viewer's up is along its view.
    """
    values = check.array("points", points).astype(np.float64)
    width, height = (
        check.number(f"window_size[{axis}]", size, above=0.0)
        for axis, size in enumerate(check.numbers_in("window_size", window_size, 2))
    )
    eye = np.array(viewer.position)
    rotation = _rotation(eye, np.array(viewer.focal_point), viewer.up)
    projection = _projection(viewer, width / height)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        # the eye is subtracted first: the view matrix rounds far from the origin
        seen = (values - eye) @ rotation.T
        clip = seen @ projection[:, :3].T + projection[:, 3]
        device = clip[:, :3] / clip[:, 3:]
        result: Float64Array = (device + 1) / 2 * (width, height, 1)
    result[~(np.isfinite(result).all(axis=1) & (clip[:, 3] > 0))] = np.nan
    return result


def _projection(viewer: PerspectiveOrParallel, aspect: float) -> Float64Array:
    near, far = viewer.clipping_range
    if viewer.parallel:
        scale = viewer.parallel_scale
        return ortho(-scale * aspect, scale * aspect, -scale, scale, near, far)
    return perspective(viewer.view_angle, aspect, near, far)
