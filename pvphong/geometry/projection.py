"""OpenGL's viewing pipeline: world → eye → clip → normalised device → window coordinates.

Matrices are (4, 4) float64 and multiply column vectors, ``clip = projection @ view @ (x, y, z, 1)``.
In eye space the eye is the origin, x is right, y is up and the eye looks down −z.

At the end of the file are normals of planes and of implicit surfaces.

References
----------
OpenGL 2.1 specification, sections 2.11.1 (window coordinates) and 2.11.2 (``glFrustum``, ``glOrtho``);
the ``gluPerspective`` and ``gluLookAt`` manual pages; ``vtkPerspectiveTransform::SetupCamera`` and
``vtkCamera::ComputeProjectionTransform``, which compute the same matrices.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pvphong.base import check
from pvphong.base.types import Float64Array, VectorLike
from pvphong.base.vectors import unit_vector
from pvphong.geometry.transform import common_integers, normalize

_PARALLEL = 8 * np.finfo(np.float64).eps  # a sine below this is rounding, not a direction


def look_at(eye: VectorLike, target: VectorLike, up: VectorLike) -> Float64Array:
    """Return the view matrix of an eye that looks at a target, like ``gluLookAt``.

    Parameters
    ----------
    eye, target : sequence of 3 floats
        Two different positions, in world coordinates.
    up : sequence of 3 floats
        A direction of any length that is not parallel to the view direction; its component perpendicular to the view
        direction points up in the image.

    Returns
    -------
    ndarray
        (4, 4) float64, world to eye space; equals ``vtkCamera.GetModelViewTransformMatrix()``.

    Raises
    ------
    ValueError
        If a vector is not three finite numbers, `eye` equals `target`, or `up` is zero or parallel to the view
        direction.

    Examples
    --------
    >>> import pvphong as ph
    >>> ph.pipeline.look_at((0, 0, 5), (0, 0, 0), (0, 1, 0))[2]
    array([ 0.,  0.,  1., -5.])
    """
    origin = np.array(check.vector("eye", eye))
    rotation = _rotation(origin, np.array(check.vector("target", target)), up)
    result = np.eye(4)
    result[:3, :3] = rotation
    result[:3, 3] = [-math.fsum(row * origin) for row in rotation]  # the terms may cancel for an eye far away
    return result


def _rotation(eye: Float64Array, target: Float64Array, up: VectorLike) -> Float64Array:
    """Return the rotation from world to eye space, shape (3, 3). Its rows are the directions right, up and backward."""
    backward = normalize([eye * 0.5 - target * 0.5])[0]  # halved, because the difference of huge numbers overflows
    if not backward.any():
        check.refuse("target", target.tolist(), "different from eye", "The view needs a direction.")
    upward = unit_vector(check.direction("up", up))
    right = np.cross(upward, backward)
    if math.hypot(*right) <= _PARALLEL:
        check.refuse("up", list(up), "a direction not parallel to the view", f"The view direction is {-backward}.")
    right = np.array(unit_vector(right.tolist()))
    return np.stack([right, np.cross(backward, right), backward])


def frustum(left: float, right: float, bottom: float, top: float, near: float, far: float) -> Float64Array:
    """Return the perspective projection of a window on the near plane, like ``glFrustum``.

    Parameters
    ----------
    left, right, bottom, top : float
        The window's edges on the near plane, in eye coordinates; left and right, bottom and top must differ.
        Swapped edges mirror the image, as in OpenGL.
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

    Examples
    --------
    >>> import pvphong as ph
    >>> ph.pipeline.frustum(-1, 1, -1, 1, 1, 3)
    array([[ 1.,  0.,  0.,  0.],
           [ 0.,  1.,  0.,  0.],
           [ 0.,  0., -2., -3.],
           [ 0.,  0., -1.,  0.]])
    """
    left, right, width = _interval("left", left, "right", right)
    bottom, top, height = _interval("bottom", bottom, "top", top)
    near, far, depth = _planes(near, far, above=0.0)
    return _finite_matrix(
        [
            [2 * (near / width), 0, right / width + left / width, 0],
            [0, 2 * (near / height), top / height + bottom / height, 0],
            [0, 0, -(far / depth + near / depth), -2 * far * (near / depth)],
            [0, 0, -1, 0],
        ]
    )


def ortho(left: float, right: float, bottom: float, top: float, near: float, far: float) -> Float64Array:
    """Return the parallel projection of a box, like ``glOrtho``.

    Parameters
    ----------
    left, right, bottom, top : float
        The window's edges, in eye coordinates; left and right, bottom and top must differ.
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

    Examples
    --------
    >>> import pvphong as ph
    >>> ph.pipeline.ortho(-1, 1, -1, 1, 1, 3)
    array([[ 1.,  0.,  0., -0.],
           [ 0.,  1.,  0., -0.],
           [ 0.,  0., -1., -2.],
           [ 0.,  0.,  0.,  1.]])
    """
    left, right, width = _interval("left", left, "right", right)
    bottom, top, height = _interval("bottom", bottom, "top", top)
    near, far, depth = _planes(near, far)
    return _finite_matrix(
        [
            [2 / width, 0, 0, -(right / width + left / width)],
            [0, 2 / height, 0, -(top / height + bottom / height)],
            [0, 0, -2 / depth, -(far / depth + near / depth)],
            [0, 0, 0, 1],
        ]
    )


def perspective(view_angle: float, aspect: float, near: float, far: float) -> Float64Array:
    """Return the perspective projection of a view angle, like ``gluPerspective``.

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

    Examples
    --------
    >>> import pvphong as ph
    >>> ph.pipeline.perspective(90, 1.0, 1.0, 3.0).round(3)
    array([[ 1.,  0.,  0.,  0.],
           [ 0.,  1.,  0.,  0.],
           [ 0.,  0., -2., -3.],
           [ 0.,  0., -1.,  0.]])
    """
    angle = check.number("view_angle", view_angle, above=0.0)
    if angle >= 180:
        check.refuse("view_angle", view_angle, "a full angle in degrees, > 0 and < 180")
    aspect = check.number("aspect", aspect, above=0.0)
    near, *_ = _planes(near, far, above=0.0)
    top = near * math.tan(math.radians(angle) / 2)
    return frustum(-top * aspect, top * aspect, -top, top, near, far)


def _interval(first: str, begin: Any, last: str, end: Any) -> tuple[float, float, float]:
    """Check that two opposite edges of the window are finite numbers, and that they differ by a finite amount.

    Parameters
    ----------
    first, last : str
        Names of the arguments, for the message.
    begin, end : Any
        Their values.

    Returns
    -------
    tuple of float
        Both values as floats, and `end` minus `begin`.
    """
    begin, end = check.number(first, begin), check.number(last, end)
    if begin == end or math.isinf(end - begin):
        check.refuse(last, end, f"different from {first} ({begin:g}), by a finite amount")
    return begin, end, end - begin


def _planes(near: Any, far: Any, above: float = -math.inf) -> tuple[float, float, float]:
    near, far = check.number("near", near, above=above), check.number("far", far)
    if far <= near or math.isinf(far - near):
        check.refuse(
            "far", far, f"greater than near ({near:g}), by a finite amount", "Both are distances from the eye."
        )
    return near, far, far - near


def _finite_matrix(rows: list[list[float]]) -> Float64Array:
    result = np.array(rows)
    if not np.isfinite(result).all():
        check.refuse("the view volume", str(rows), "neither so small nor so large that its matrix overflows float64")
    return result


def project(points: Any, viewer: Any, window_size: tuple[int, int]) -> Float64Array:
    """Project points to window coordinates: pixels and pseudo-depth.

    The depth is OpenGL's: 0 on the near plane, 1 on the far plane, and in perspective not linear between them. Points
    are not clipped: beyond the clipping planes the depth is outside [0, 1], and x and y may be outside the window. The
    row is NaN for a point that is not finite, and in perspective for a point on or behind the plane through the eye.

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
        (n, 3) float64. x and y in pixels from the window's lower left corner (pixel i covers i to i + 1), and the
        depth. They equal VTK's display coordinates if the renderer fills the window.

    Raises
    ------
    ValueError
        If the points are not (n, 3), the window has no size, or the viewer's up is parallel to its view direction.

    Examples
    --------
    >>> import pvphong as ph
    >>> ph.pipeline.project([[0.0, 0.0, 0.0]], ph.Viewer(position=(0, 0, 5)), (640, 480))[0, :2]
    array([320., 240.])
    """
    values = check.array("points", points).astype(np.float64)
    width, height = (
        check.number(f"window_size[{axis}]", size, above=0.0)
        for axis, size in enumerate(check.numbers_in("window_size", window_size, 2))
    )
    eye = np.array(viewer.position)
    rotation = _rotation(eye, np.array(viewer.focal_point), viewer.up)
    if viewer.parallel:
        half, across = viewer.parallel_scale, viewer.parallel_scale * width / height
        projection = ortho(-across, across, -half, half, *viewer.clipping_range)
    else:
        projection = perspective(viewer.view_angle, width / height, *viewer.clipping_range)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        # the view matrix would lose digits far from the origin, so subtract the eye first
        seen = (values - eye) @ rotation.T
        clip = seen @ projection[:, :3].T + projection[:, 3]
        device = clip[:, :3] / clip[:, 3:]
        result: Float64Array = (device + 1) / 2 * (width, height, 1)
    result[~(np.isfinite(result).all(axis=1) & (clip[:, 3] > 0))] = np.nan
    return result


# --- normals from formulas


def plane_normal(*plane: Any) -> Float64Array:
    """Compute the unit normal of a plane from its coefficients, or from three of its points.

    ``plane_normal(a, b, c)`` and ``plane_normal(a, b, c, d)`` take the plane ax + by + cz + d = 0;
    ``plane_normal(p, q, r)`` takes points, three numbers each. The arguments may also be one sequence or array.

    Parameters
    ----------
    *plane : float or array_like
        Three or four coefficients, or three points. Seen from the front, p, q, r run counter-clockwise.

    Returns
    -------
    ndarray
        Shape (3,), float64, computed exactly from the given numbers and rounded once, so that it is right for nearly
        collinear points too.

    Raises
    ------
    ValueError
        If a, b and c are all zero, the points are exactly collinear, or a number is not finite.

    Examples
    --------
    >>> import pvphong as ph
    >>> ph.pipeline.plane_normal((0, 0, 0), (1, 0, 0), (0, 1, 0))
    array([0., 0., 1.])
    """
    items = plane[0] if len(plane) == 1 else plane
    is_sequence = isinstance(items, (list, tuple, np.ndarray)) and len(items) in (3, 4)
    dimensions = {np.ndim(item) for item in items} if is_sequence else set()
    if dimensions == {1} and len(items) == 3:
        p, q, r = (check.vector(name, item) for name, item in zip("pqr", items, strict=True))
        integers = common_integers([*p, *q, *r])
        a, b, c = (integers[3 + axis] - integers[axis] for axis in range(3))
        d, e, f = (integers[6 + axis] - integers[axis] for axis in range(3))
        normal = [b * f - c * e, c * d - a * f, a * e - b * d]  # (q - p) × (r - p), times a positive factor
        got, allowed = f"p={p}, q={q}, r={r}", "three points that are not collinear"
    elif dimensions == {0}:
        coefficients = check.numbers_in("plane", items, len(items))
        normal, got, allowed = (
            common_integers(coefficients[:3]),
            str(coefficients),
            "coefficients with a, b and c not all zero",
        )
    else:
        check.refuse("plane", items, "(a, b, c), (a, b, c, d) or three points", "Each point has three numbers.")
    if not any(normal):
        check.refuse("plane", got, allowed)
    guard = 64  # extra bits of the root, so that its truncation does not affect the result
    root = math.isqrt(sum(entry * entry for entry in normal) << 2 * guard)
    return np.array([(entry << guard) / root for entry in normal])


def implicit_normals(gradient: Callable[[Float64Array], ArrayLike] | ArrayLike, points: ArrayLike) -> Float64Array:
    """Compute unit normals of an implicit surface f(x, y, z) = 0 at points on it, from its gradient.

    Parameters
    ----------
    gradient : callable or array_like
        Function of (n, 3) float64 points that returns the (n, 3) gradients of f; or the gradients themselves. For the
        unit sphere, f = x² + y² + z² - 1, ``lambda p: p`` is right up to a factor.
    points : array_like
        Shape (n, 3), any real type. The callable gets a copy.

    Returns
    -------
    ndarray
        Shape (n, 3), float64. Where the gradient is zero (a cone's tip) or not finite, the normal is zero.

    Raises
    ------
    ValueError
        If `points` is not (n, 3), or the gradients are not (n, 3) real numbers.

    Examples
    --------
    >>> import pvphong as ph
    >>> ph.pipeline.implicit_normals(lambda points: 2 * points, [[0, 0, 3.0]])  # a sphere
    array([[0., 0., 1.]])
    """
    rows = check.array("points", points)
    gradients = gradient(rows.astype(np.float64)) if callable(gradient) else gradient
    return normalize(check.array("gradient", gradients, count=len(rows)))
