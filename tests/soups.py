"""Meshes given by the corners of their faces, as arrays and as PyVista meshes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import pyvista as pv

from pvphong.base import check
from pvphong.geometry.normals import point_normals
from pvphong.meshes.surfaces import polygons
from pvphong.shading import kernel

Face = Sequence[int]


def soup(*faces: Face) -> tuple[Any, Any]:
    """Return connectivity and offsets."""
    return np.array([corner for face in faces for corner in face], dtype=np.int64), np.cumsum([0, *map(len, faces)])


def mesh_of(points: Any, *faces: Face) -> pv.PolyData:
    """Return a mesh with exactly these faces; indices may be out of range."""
    connectivity, offsets = soup(*faces)
    mesh = pv.PolyData()
    mesh.points = np.asarray(points)
    mesh.SetPolys(pv.CellArray.from_arrays(offsets, connectivity, deep=True))
    return mesh


def faces_of(mesh: pv.PolyData) -> list[list[int]]:
    """Return the faces of a mesh, with strips cut into triangles."""
    connectivity, offsets = polygons(mesh)
    return [connectivity[a:b].tolist() for a, b in pairwise(offsets)]


def bumpy(n: int, *, quads: bool = False) -> tuple[Any, list[Face]]:
    """Return a rough grid of n x n points, of triangles, or with every second square a quad."""
    rng = np.random.default_rng(3)
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    points = np.stack([x.ravel(), y.ravel(), rng.uniform(0, 1, n * n)], axis=1) + rng.uniform(-0.2, 0.2, (n * n, 3))
    faces: list[Face] = []
    for a in range(n * (n - 1)):
        b, c, d = a + 1, a + n + 1, a + n
        if b % n:
            faces += [(a, b, c, d)] if quads and a % 2 else [(a, b, c), (a, c, d)]
    return points, faces


def state(mesh: pv.DataSet) -> list[Any]:
    """Return a mesh's modification time (first), its active arrays and all its bytes."""
    point_data = mesh.point_data
    active = mesh.active_scalars_info, point_data.active_normals_name, point_data.active_texture_coordinates_name
    arrays = [
        {name: (str(np.asarray(data[name]).dtype), np.asarray(data[name]).tobytes()) for name in data}
        for data in (point_data, mesh.cell_data, mesh.field_data)
    ]
    cells = ("verts", "lines", "faces", "strips") if isinstance(mesh, pv.PolyData) else ("cells", "celltypes")
    cells = [getattr(mesh, name).tobytes() for name in cells if hasattr(mesh, name)]
    return [mesh.GetMTime(), active, np.asarray(mesh.points).tobytes(), arrays, cells]


# --- both implementations of point normals: NumPy and compiled ---


def compiled_normals(points: Any, connectivity: Any, offsets: Any, weighting: Any = "angle") -> Any:
    """Compute by compiled code; NumPy handles cases that it declines, such as faces of size 1e-200 and errors."""
    rows = check.array("points", points)
    found = kernel.point_normals(rows, np.asarray(connectivity), np.asarray(offsets), weighting)
    return point_normals(points, connectivity, offsets, weighting) if found is None else found


FORMS = {"numpy": point_normals} | ({"numba": compiled_normals} if kernel.is_available() else {})

every_form = pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
