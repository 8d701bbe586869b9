"""The lit surfaces of a pane, as highlight dragging needs them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator
from vtkmodules.vtkRenderingCore import vtkCellPicker

from pvphong.base.types import Float64Array, rgb
from pvphong.geometry.transform import transform_normals, transform_points
from pvphong.optics.light import Light
from pvphong.studio.gizmos.drag_start import vector
from pvphong.studio.gizmos.highlight import SurfacePoint, brightest
from pvphong.studio.gizmos.shape import comes_from_somewhere
from pvphong.studio.gizmos.view import View
from pvphong.studio.live import LiveMesh

# So many vertices of a mesh are asked for the brightest: it places a handle, it does not light anything.
_ASKED = 20_000


def find_highlight(light: Light, view: View, meshes: Sequence[LiveMesh]) -> SurfacePoint | None:
    """Where a light that comes from somewhere, in the world, has its highlight on the shiny ones of some meshes."""
    if not light.on or not comes_from_somewhere(light):
        return None
    shiny = [live for live in meshes if any(rgb(live.material.specular))]
    found = [brightest(light, view, *_sample(live)) for live in shiny]
    return max((at for at in found if at is not None), key=lambda at: at[0], default=(0.0, None))[1]


def _sample(live: LiveMesh) -> tuple[Float64Array, Float64Array]:
    points = np.asarray(live.drawn.points)
    step = max(1, len(points) // _ASKED)
    return _in_world(live, points[::step], np.asarray(live.normals)[::step])


def _in_world(live: LiveMesh, points: Any, normals: Any) -> tuple[Float64Array, Float64Array]:
    matrix = np.eye(4) if live.matrix is None else live.matrix
    points, normals = np.asarray(points, dtype=np.float64), np.asarray(normals, dtype=np.float64)
    return transform_points(points, matrix), transform_normals(normals, matrix)


class Surfaces:
    """Lit meshes that are asked again and again what is under a cursor, while none of them moves.

    Parameters
    ----------
    renderer
        VTK's.
    view : View
        The pane.
    meshes : sequence of LiveMesh
        What can be hit.
    """

    def __init__(self, renderer: Any, view: View, meshes: Sequence[LiveMesh]) -> None:
        self._renderer, self._view, self._meshes = renderer, view, meshes
        self._picker = vtkCellPicker()
        self._picker.SetTolerance(0.0)
        self._picker.PickFromListOn()
        for live in meshes:
            assert live.actor is not None
            self._picker.AddPickList(live.actor)
            locator = vtkStaticCellLocator()
            locator.SetDataSet(live.actor.GetMapper().GetInput())  # the picker knows it by the mapper's own
            locator.BuildLocator()
            self._picker.AddLocator(locator)

    def mesh(self, cursor: tuple[float, float]) -> LiveMesh | None:
        """The mesh under a cursor."""
        picker = self._picker
        if not picker.Pick(*cursor, 0.0, self._renderer):
            return None
        return next(live for live in self._meshes if live.actor is picker.GetActor())

    def pick(self, cursor: tuple[float, float]) -> SurfacePoint | None:
        """The place under a cursor, its normal interpolated and turned to the eye."""
        picker, live = self._picker, self.mesh(cursor)
        if live is None:
            return None
        cell = live.drawn.GetCell(picker.GetCellId())
        weights = [0.0] * cell.GetNumberOfPoints()
        cell.InterpolateFunctions(picker.GetPCoords(), weights)
        ids = [cell.GetPointId(corner) for corner in range(cell.GetNumberOfPoints())]
        blended = np.array(weights) @ np.asarray(live.normals, dtype=np.float64)[ids]
        normal = _in_world(live, np.zeros((1, 3)), blended[None])[1][0]
        point = picker.GetPickPosition()
        facing = float(normal @ self._view.towards_eye(point))
        return SurfacePoint(vector(point), vector(normal if facing >= 0.0 else -normal))
