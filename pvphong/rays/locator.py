"""Rays cast by VTK's static cell locator: slower, and always there."""

from __future__ import annotations

from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import mutable, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkStaticCellLocator

from pvphong.base.types import BoolArray, Float64Array, FloatArray
from pvphong.rays.faces import BlockingFaces

# Places on triangles are rounded too: with a tolerance of 0 some are missed.
_TOLERANCE = 2.0**-24


class Locator:
    """A `Backend`."""

    def __init__(self, faces: BlockingFaces) -> None:
        points, cells, mesh = vtkPoints(), vtkCellArray(), vtkPolyData()
        points.SetData(numpy_to_vtk(np.ascontiguousarray(faces.points), deep=True))
        corners = np.ascontiguousarray(faces.corners, np.int64).ravel()
        offsets = numpy_to_vtkIdTypeArray(np.arange(0, len(corners) + 1, 3, dtype=np.int64), deep=True)
        cells.SetData(offsets, numpy_to_vtkIdTypeArray(corners, deep=True))
        mesh.SetPoints(points)
        mesh.SetPolys(cells)
        self._locator = vtkStaticCellLocator()
        self._locator.SetDataSet(mesh)
        self._locator.BuildLocator()

    def blocked(self, origins: Float64Array, directions: FloatArray, lengths: Float64Array) -> BoolArray:
        """Whether a triangle is met."""
        ends = origins + lengths[:, None] * directions
        meet: Any = self._locator.IntersectWithLine  # VTK's annotations have no numbers that it changes
        t, cell, where, inside = mutable(0.0), mutable(0), [0.0] * 3, [0.0] * 3
        pairs = zip(origins.tolist(), ends.tolist(), strict=True)
        return np.array([meet(a, b, _TOLERANCE, t, where, inside, cell) != 0 for a, b in pairs], np.bool_)
