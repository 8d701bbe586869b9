"""Meshes that carry lit colours between their vertices too: what interpolation misses, and refinement."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal, get_args

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong import _check
from pvphong._interpolation import Lighting, Vertices, first_errors, jumps, more_errors
from pvphong._refining import Refinement
from pvphong._types import Float64Array, IntArray, MatrixLike, Precision
from pvphong.evaluation import _albedo as shades_of
from pvphong.material import Material
from pvphong.mesh import _surface_and_albedo as surface_and_albedo
from pvphong.mesh import point_normals
from pvphong.planning import check_scene_and_material
from pvphong.scene import Scene
from pvphong.surface import has_faces

Placement = Literal["linear", "smooth"]

# Points that are added at most where no limit is given.
_MOST_ADDED = 1_000_000


def refine(
    mesh: pv.DataSet,
    scene: Scene,
    material: Material,
    *,
    tolerance: float,
    max_points: int | None = None,
    name: str = "phong",
    placement: Placement = "linear",
    matrix: MatrixLike | None = None,
    albedo: Any = None,
    precision: Precision = "float32",
) -> pv.PolyData:
    """A new mesh with lit colours, its triangles split where interpolated colours miss the evaluated ones.
