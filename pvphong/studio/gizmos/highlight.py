"""Highlight dragging: find a light's highlight, and move the light so that the highlight is under the cursor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator
from vtkmodules.vtkRenderingCore import vtkCellPicker

from pvphong.base.types import Float64Array, Vector, rgb
from pvphong.base.vectors import dot
from pvphong.geometry.transform import transform_normals, transform_points
from pvphong.optics.light import Light
from pvphong.optics.roles import Aim, Corners, Place
from pvphong.studio.gizmos.handles import comes_from_somewhere, fields
from pvphong.studio.gizmos.view import View, vector
from pvphong.studio.lit_mesh import LitMesh

# About the largest number of vertices that are searched for the highlight. It affects a handle's position, not shading.
_ASKED = 20_000


@dataclass(frozen=True)
class SurfacePoint:
    """A point of a surface, and the surface's unit normal there, on the side of the eye."""

    point: Vector
    normal: Vector


def find_highlight(light: Light, view: View, meshes: Sequence[LitMesh]) -> SurfacePoint | None:
    """Return the surface point at which the viewer sees a light's highlight; None if there is no highlight.

    Meshes whose material has no highlight are ignored, and so are meshes that cannot be lit.

    Parameters
    ----------
    light : Light
        The light, in world coordinates.
    view : View
        The view.
    meshes : sequence of LitMesh
        The meshes.
    """
    if not light.on or light.frame == "headlight" or not comes_from_somewhere(light):
        return None
    found = []
    for mesh in meshes:
        if mesh.drawn.n_points and ("specular" in mesh.material.maps or any(rgb(mesh.material.specular))):
            points, normals, matrix = np.asarray(mesh.drawn.points), np.asarray(mesh.normals), _matrix_of(mesh)
            step = max(1, len(points) // _ASKED)
            in_world = transform_points(points[::step], matrix), transform_normals(normals[::step], matrix)
            found.append(brightest(light, view, *in_world))
    return max((each for each in found if each is not None), key=lambda each: each[0], default=(0.0, None))[1]


def brightest(
    light: Light, view: View, points: Float64Array, normals: Float64Array
) -> tuple[float, SurfacePoint] | None:
    """Return the surface point from which the mirror direction of the light is nearest to the eye.

    Parameters
    ----------
    light : Light
        The light, in world coordinates.
    view : View
        The view.
    points, normals : ndarray
        Shape (n, 3), in world coordinates; the normals are unit vectors or zero.

    Returns
    -------
    tuple of float and SurfacePoint, or None
        The cosine between mirror direction and direction to the eye, r·v, and the point. None if the light reaches no
        point that faces the eye.
    """
    arrival = light.arrival(points.T)
    to_eye = view.towards_eye(points).T
    facing, lit = dot(normals.T, to_eye), dot(normals.T, arrival.direction)
    reaches = (facing > 0.0) & (lit > 0.0) & (np.asarray(arrival.strength) > 0.0)
    if not reaches.any():
        return None
    mirrored = np.where(reaches, dot(2.0 * lit * normals.T - arrival.direction, to_eye), -np.inf)
    best = int(np.argmax(mirrored))
    return float(mirrored[best]), SurfacePoint(vector(points[best]), vector(normals[best]))


def mirrored_to_eye(light: Light, view: View, held: SurfacePoint, target: SurfacePoint) -> Light:
    """Return the light, moved so that the viewer sees its highlight at the surface point `target`.

    With the unit normal n and the unit vector v to the eye, light from l = 2(n·v)n − v is mirrored to the eye. A light
    with a position keeps its distance from the surface. A light with an aim points at the target. A light with corners
    is turned as a whole.

    Parameters
    ----------
    light : Light
        The light at the start of the drag, in world coordinates.
    view : View
        The view at the start of the drag.
    held : SurfacePoint
        The point where the highlight was grabbed.
    target : SurfacePoint
        The new point of the highlight.
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
        turn = rotation(np.mean(corners, axis=0) - held.point, to_light)
        changes[field] = tuple(vector(target.point + turn @ np.subtract(corner, held.point)) for corner in corners)
    return replace(light, **changes)


def rotation(before: Float64Array, after: Float64Array) -> Float64Array:
    """Return the smallest rotation from the direction `before` to the unit vector `after`, as a matrix of shape (3, 3).

    The rotation is the product of two half-turns.
    """
    start = before / np.linalg.norm(before)
    halfway = start + after
    if not halfway @ halfway > 1e-12:  # opposite: any perpendicular direction is halfway
        halfway = np.cross(start, np.eye(3)[np.argmin(np.abs(start))])
    first, second = (2.0 * np.outer(axis, axis) / (axis @ axis) - np.eye(3) for axis in (start, halfway))
    return np.asarray(second @ first)


def _matrix_of(mesh: LitMesh) -> Float64Array:
    return np.eye(4) if mesh.matrix is None else mesh.matrix


class Surfaces:
    """Lit meshes, prepared for picking. The object is valid until a mesh or the camera moves.

    Parameters
    ----------
    renderer
        VTK's renderer.
    view : View
        The subplot.
    meshes : sequence of LitMesh
        The meshes that can be picked.
    """

    def __init__(self, renderer: Any, view: View, meshes: Sequence[LitMesh]) -> None:
        self._renderer, self._view = renderer, view
        self._meshes = [mesh for mesh in meshes if mesh.drawn.n_cells]  # meshes that cannot be lit have none
        self._picker = vtkCellPicker()
        self._picker.SetTolerance(0.0)
        self._picker.PickFromListOn()
        for mesh in self._meshes:
            assert mesh.actor is not None
            self._picker.AddPickList(mesh.actor)
            locator = vtkStaticCellLocator()
            locator.SetDataSet(mesh.actor.GetMapper().GetInput())  # the picker looks it up by the mapper's dataset
            locator.BuildLocator()
            self._picker.AddLocator(locator)

    def mesh(self, cursor: tuple[float, float]) -> LitMesh | None:
        """Return the mesh under the cursor; None if there is no mesh. `cursor` is in pixels of the window."""
        if not self._picker.Pick(*cursor, 0.0, self._renderer):
            return None
        return next(mesh for mesh in self._meshes if mesh.actor is self._picker.GetActor())

    def pick(self, cursor: tuple[float, float]) -> SurfacePoint | None:
        """Return the surface point under the cursor, with its interpolated normal; None if there is no mesh.

        `cursor` is in pixels of the window.
        """
        picker, mesh = self._picker, self.mesh(cursor)
        if mesh is None:
            return None
        cell = mesh.drawn.GetCell(picker.GetCellId())
        weights = [0.0] * cell.GetNumberOfPoints()
        cell.InterpolateFunctions(picker.GetPCoords(), weights)
        ids = [cell.GetPointId(corner) for corner in range(cell.GetNumberOfPoints())]
        blended = np.array(weights) @ np.asarray(mesh.normals, dtype=np.float64)[ids]
        normal = transform_normals(blended[None], _matrix_of(mesh))[0]
        point = picker.GetPickPosition()
        facing = float(normal @ self._view.towards_eye(point))
        return SurfacePoint(vector(point), vector(normal if facing >= 0.0 else -normal))
