"""Highlight dragging: where a light's highlight is, and where the light must be for it to be elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array, Vector
from pvphong.base.vectors import dot
from pvphong.optics.light import Light
from pvphong.optics.roles import Aim, Corners, Place
from pvphong.studio.gizmos.drag_start import vector
from pvphong.studio.gizmos.shape import fields
from pvphong.studio.gizmos.view import View


@dataclass(frozen=True)
class SurfacePoint:
    """A point of a surface and the unit normal there, turned to the eye."""

    point: Vector
    normal: Vector


def brightest(
    light: Light, view: View, points: Float64Array, normals: Float64Array
) -> tuple[float, SurfacePoint] | None:
    """The point of a surface at which a light's mirror direction comes nearest to the eye.

    Parameters
    ----------
    light : Light
        In the world.
    view : View
        Where it is seen from.
    points, normals : ndarray
        Shape (n, 3), in the world; the normals unit or zero.

    Returns
    -------
    tuple of float and SurfacePoint, or None
        The cosine between the mirror direction and the direction to the eye, r·v, and the point; None if
        the light reaches nothing that faces the eye.
    """
    arrival = light.arrival(points.T)
    to_eye = _to_eye(view, points).T
    facing, lit = dot(normals.T, to_eye), dot(normals.T, arrival.direction)
    reaches = (facing > 0.0) & (lit > 0.0) & (np.asarray(arrival.strength) > 0.0)
    if not reaches.any():
        return None
    mirrored = np.where(reaches, dot(2.0 * lit * normals.T - arrival.direction, to_eye), -np.inf)
    best = int(np.argmax(mirrored))
    return float(mirrored[best]), SurfacePoint(vector(points[best]), vector(normals[best]))


def _to_eye(view: View, points: Float64Array) -> Float64Array:
    if view.viewer.parallel:
        return np.broadcast_to(-np.array(view.viewer.view_direction), points.shape)
    away = np.array(view.viewer.position) - points
    length = np.linalg.norm(away, axis=1, keepdims=True)
    return np.divide(away, length, out=np.zeros_like(away), where=length > 0.0)


def mirrored_to_eye(light: Light, view: View, held: SurfacePoint, target: SurfacePoint) -> Light:
    """The light that throws its highlight on a target, mirrored to the eye.

    With the normal n and the unit vector v to the eye it shines from l = 2(n·v)n − v, where v is its mirror
    direction. A light with a place keeps its distance from the surface, one with an aim shines there, and one with
    corners is turned as a whole.

    Parameters
    ----------
    light : Light
        At the start of the drag, in the world.
    view : View
        At that time.
    held : SurfacePoint
        Where the highlight was grabbed.
    target : SurfacePoint
        Where it is to be.
    """
    normal = np.array(target.normal)
    to_eye = view.towards_eye(target.point)
    to_light = 2.0 * float(normal @ to_eye) * normal - to_eye
    changes: dict[str, Any] = {}
    distance = None
    for field, place in list(fields(light, Place).items())[:1]:
        distance = float(np.linalg.norm(np.array(place) - held.point))
        changes[field] = vector(np.array(target.point) + distance * to_light)
    for field, direction in list(fields(light, Aim).items())[:1]:
        length = float(np.linalg.norm(direction)) if distance is None else distance
        changes[field] = vector(-length * to_light)
    for field, corners in fields(light, Corners).items():
        turn = _turn(np.mean(corners, axis=0) - held.point, to_light)
        changes[field] = tuple(vector(target.point + turn @ np.subtract(corner, held.point)) for corner in corners)
    return replace(light, **changes)


def _turn(before: Float64Array, after: Float64Array) -> Float64Array:
    """The smallest rotation, (3, 3), of a direction to a unit vector: two half-turns, the second between the two."""
    start = before / np.linalg.norm(before)
    between = start + after
    if not between @ between > 1e-12:  # opposite: any direction across is between them
        between = np.cross(start, np.eye(3)[np.argmin(np.abs(start))])
    return _half_turn(between) @ _half_turn(start)


def _half_turn(around: Float64Array) -> Float64Array:
    return 2.0 * np.outer(around, around) / (around @ around) - np.eye(3)
