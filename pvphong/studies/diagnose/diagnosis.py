"""What in a mesh, or in a model matrix for it, will not light as it should."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray, IntArray, MatrixLike
from pvphong.geometry import normals
from pvphong.geometry.normals import Faces
from pvphong.meshes.cells import invalid_cells, refuse_wrong_sizes
from pvphong.meshes.surfaces import outer_surface, unchecked_polygons
from pvphong.studies.diagnose.checks import (
    check_edges,
    check_faces,
    check_matrix,
    duplicates,
    finite_rows,
    offset_to_origin,
    repeated_faces,
)
from pvphong.studies.diagnose.report import Diagnosis, Finding
from pvphong.studies.diagnose.shells import inside_out_faces

__all__ = ["Diagnosis", "Finding", "diagnose"]


def diagnose(mesh: pv.DataSet, *, matrix: MatrixLike | None = None) -> Diagnosis:
    """Look for what will spoil a mesh's lighting: faces, normals and points, and the model matrix.

    PyVista's ``mesh.validate_mesh`` asks whether cells are what their types promise (convex, planar, not
    inverted, arrays of the right length). This asks what a light will make of them: whether every point gets a
    normal, whether neighbours agree about their front, whether the coordinates are fine enough for normals. A
    face that is not convex is no fault here; a mesh that is valid there may be dark here.

    No VTK algorithm sees a mesh with an index out of range, so that the worst file is reported, not fatal.

    Parameters
    ----------
    mesh : pyvista.DataSet
        Looked at, not changed. Of another than PolyData it is the extracted surface that is looked at.
    matrix : array_like or vtkMatrix4x4, optional
        (4, 4) model matrix that the mesh will be lit with.

    Returns
    -------
    Diagnosis
        `.ok`, `.findings`, an array of indices for each kind of fault; printable, `.explain()`, `.table()`,
        `.to_mesh()`.

    Raises
    ------
    ValueError
        If `mesh` is no DataSet, its dimensions or arrays do not fit its points, or `matrix` is not an affine
        4x4 matrix of finite numbers.
    """
    if not isinstance(mesh, pv.DataSet):
        remedy = "pyvista.wrap turns VTK's datasets into one; of a MultiBlock diagnose each block."
        check.refuse("mesh", type(mesh).__name__, "a pyvista.DataSet", remedy)
    singular, nearly, mirrored = (False, False, False) if matrix is None else check_matrix(matrix)
    refuse_wrong_sizes(mesh)
    invalid = invalid_cells(mesh)
    source = (
        outer_surface(mesh)
        if isinstance(mesh, pv.PolyData) or not len(invalid)
        else pv.PolyData(np.asarray(mesh.points))
    )
    points = check.array("mesh.points", np.asarray(source.points))
    n_faces, numbers, faces = _valid_faces(source, points)
    stored = source.point_data.active_normals
    return Diagnosis(
        n_points=len(points),
        n_faces=n_faces,
        stored_normals=stored is not None,
        invalid_cells=invalid,
        nothing_to_light=not len(invalid) and not (len(points) and (n_faces or stored is not None)),
        singular_matrix=singular,
        nearly_singular_matrix=nearly,
        mirrored_matrix=mirrored,
        **_of_faces(points, faces, numbers),
        **_of_points(points, faces, None if stored is None else np.asarray(stored)),
        _points=points,
        _faces=(numbers, faces.connectivity, faces.offsets),
    )


def _valid_faces(source: pv.PolyData, points: FloatArray) -> tuple[int, IntArray, Faces]:
    """How many faces there are, and the numbers and the corners of those whose indices are points."""
    connectivity, offsets = unchecked_polygons(source)
    sizes = np.diff(offsets)
    right = (connectivity >= 0) & (connectivity < len(points))
    if right.all():
        return len(sizes), np.arange(len(sizes)), Faces(points, connectivity, offsets)
    owners = np.repeat(np.arange(len(sizes)), sizes)
    valid = np.ones(len(sizes), dtype=bool)
    valid[owners[~right]] = False
    kept = np.concatenate([[0], np.cumsum(sizes[valid])])
    return len(sizes), np.flatnonzero(valid), Faces(points, connectivity[valid[owners]], kept)


def _of_faces(points: FloatArray, faces: Faces, numbers: IntArray) -> dict[str, Any]:
    checks = check_faces(points, faces)
    repeated = repeated_faces(faces, np.concatenate([checks.degenerate, checks.folded]))
    non_manifold, inconsistent = check_edges(faces, checks.folded, repeated)
    return {
        "degenerate_faces": numbers[checks.degenerate],
        "far_faces": numbers[checks.far],
        "thin_faces": numbers[checks.thin],
        "duplicate_faces": numbers[repeated],
        "non_manifold_edges": non_manifold,
        "inconsistent_edges": inconsistent,
        "inside_out_faces": numbers[inside_out_faces(points, faces)],
        "offset": offset_to_origin(points) if len(checks.far) and checks.one_offset_helps else None,
    }


def _of_points(points: FloatArray, faces: Faces, stored: NDArray[Any] | None) -> dict[str, Any]:
    used = np.zeros(len(points), dtype=bool)
    used[faces.connectivity] = True
    finite = finite_rows(points)
    computed = normals.point_normals(points, faces.connectivity, faces.offsets)
    return {
        "non_finite_points": np.flatnonzero(~finite),
        "unlit_points": np.flatnonzero(used & finite & ~computed.any(axis=1)),
        "duplicate_points": duplicates(points),
        "unused_points": np.flatnonzero(~used) if faces.count else np.empty(0, dtype=np.intp),
        **_of_normals(computed, computed[:0] if stored is None else stored),
    }


def _of_normals(computed: Float64Array, stored: NDArray[Any]) -> dict[str, IntArray]:
    """Faults of stored normals; none where there are no rows."""
    with np.errstate(all="ignore"):
        along = np.einsum("ij,ij->i", computed[: len(stored)], stored.astype(np.float64))
    finite = finite_rows(stored)
    return {
        "zero_normals": np.flatnonzero(~stored.any(axis=1)),
        "non_finite_normals": np.flatnonzero(~finite),
        "opposed_normals": np.flatnonzero(finite & (along < 0)),
    }
