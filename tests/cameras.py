"""VTK's cameras, for tests of code that must agree with them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv
import vtk


def random_camera(seed: int) -> Any:
    """Return a random `vtkCamera` or `pyvista.Camera`; every second one is parallel."""
    rng = np.random.default_rng(seed)
    near = rng.uniform(0.1, 2)
    camera = pv.Camera() if seed % 3 == 0 else vtk.vtkCamera()
    camera.SetPosition(rng.normal(size=3) * 10)
    camera.SetFocalPoint(rng.normal(size=3))
    camera.SetViewUp(rng.normal(size=3))
    camera.SetParallelProjection(seed % 2)
    camera.SetViewAngle(rng.uniform(1, 150))
    camera.SetParallelScale(rng.uniform(0.1, 20))
    camera.SetClippingRange(near, near + rng.uniform(1, 100))
    return camera


def as_array(matrix: Any) -> Any:
    """Convert a `vtkMatrix4x4` to an array."""
    return np.array([[matrix.GetElement(row, column) for column in range(4)] for row in range(4)])
