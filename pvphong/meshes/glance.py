"""A quick check before a mesh is lit: warns of stored normals that do not fit, and of faces that look inwards.

Only some faces are checked; this takes about 100 microseconds for any mesh. The check is not repeated while the mesh is
unchanged. If most of the checked faces do not fit the stored normals, all faces are checked as in `pvphong.diagnose`
before a warning is given.
"""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy

from pvphong.base.types import BoolArray, Float64Array, FloatArray, MatrixLike
from pvphong.base.vectors import cross, dot
from pvphong.geometry.fit import MISFIT, areas_of, fit_of, weights_of
from pvphong.geometry.normals import Faces
from pvphong.meshes.surfaces import unchecked_polygons, vertex_normals
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.shading.evaluation import evaluate
from pvphong.shading.vertices import Vertices

_FACES = 256
# Positions of the sampled faces in the list of faces, as fractions of its length. Multiples of the golden ratio are
# evenly spread, and do not align with the rows of a grid.
_PLACES = np.arange(_FACES) * (5.0**0.5 - 1.0) / 2.0 % 1.0
_CORNERS = np.arange(3)[:, None]

# Cosine of 30 degrees. A face is counted as misfit if its stored normals deviate by a larger angle. Correct normals at
# sharp edges deviate too: for a triangulated cube with one normal per corner, a face's mean normal deviates by 25.
_FITS = 0.866
# In a closed surface, the area vectors add up to zero, and the sum of area vector · vector from the centre is
# proportional to the volume; it is negative if faces look inwards. The thresholds are fractions of the sums of
# magnitudes, with a margin because only some faces are sampled. The ant of PyVista's examples, a rough body that looks
# outwards, has 0.34.
_BALANCED, _INWARD = 0.3, -0.3

_WHITE = Material(ambient=0.0, diffuse=1.0)

# States of meshes that are not checked again: no problem was found, or the warning was given.
_seen: dict[tuple[int, ...], None] = {}
_REMEMBERED = 1024

_MISFIT = (
    "Most of the mesh's stored normals do not fit its faces, but the lighting uses them. The mesh may have changed "
    'after they were computed. Compute them again with mesh.point_data.active_normals = mesh.phong.normals("angle"), '
    "or turn reversed faces back with mesh.flip_faces(). mesh.phong.diagnose() gives details."
)
_BACKS = (
    "The mesh's faces look inwards, so light from outside hits their backs, which stay dark. Turn them with "
    "mesh.flip_faces(), or light both sides with LightModel(two_sided=True). mesh.phong.diagnose() gives details."
)


class NormalsWarning(UserWarning):
    """Warning that normals or faces of a mesh point the wrong way, so that its lighting looks wrong.

    Examples
    --------
    >>> import warnings, pvphong as ph
    >>> warnings.simplefilter("error", ph.NormalsWarning)  # raise it
    """


def warn_of_normals(mesh: pv.DataSet, source: pv.PolyData, scene: Scene, matrix: MatrixLike | None = None) -> None:
    """Warn if most normals or faces of a surface point the wrong way.

    The warning has the text that `complaint` returns.

    Parameters
    ----------
    mesh : pyvista.DataSet
        The mesh.
    source : pyvista.PolyData
        The valid surface of the mesh.
    scene : Scene
        A scene with a viewer.
    matrix : array_like, optional
        (4, 4) model matrix.

    Warns
    -----
    NormalsWarning
        For the line outside this package that made the call.
    """
    text = complaint(mesh, source, scene, matrix)
    if text:
        warnings.warn(text, NormalsWarning, stacklevel=_levels_to_caller())


def complaint(mesh: pv.DataSet, source: pv.PolyData, scene: Scene, matrix: MatrixLike | None = None) -> str:
    """Return a text on the problem and its remedy if most normals or faces of a surface point the wrong way, else "".

    A problem of an unchanged mesh is reported once. Inward faces are reported only for a PolyData without stored
    normals, such as an isosurface. If both sides are lit, or if the viewer or a light is inside, as in a room, inward
    faces are no problem.

    Parameters
    ----------
    mesh : pyvista.DataSet
        The mesh.
    source : pyvista.PolyData
        The valid surface of the mesh.
    scene : Scene
        A scene with a viewer.
    matrix : array_like, optional
        (4, 4) model matrix.
    """
    stored, is_own = source.GetPointData().GetNormals(), isinstance(mesh, pv.PolyData)
    if stored is None and (scene.light_model.two_sided or not is_own):
        return ""
    parts = mesh.GetPoints() if is_own else None, source.GetPolys(), stored
    state = tuple(0 if part is None else part.GetMTime() for part in parts)
    if state in _seen:
        return ""
    text = ""
    if stored is not None and _seem_misfits(source) and _are_misfits(source):
        text = _MISFIT
    if stored is None and _looks_inwards(source):
        if _holds_viewer_or_light(source, scene, matrix):
            return ""
        text = _BACKS
    if is_own:
        if len(_seen) >= _REMEMBERED:
            _seen.clear()
        _seen[state] = None
    return text


def faces_away(source: pv.PolyData, scene: Scene, vertices: Vertices, matrix: MatrixLike | None = None) -> bool:
    """Return True if every vertex faces away from every light, but most faces would be lit if they were turned over.

    Some faces are tested first. Usually one of them faces a light, and the result is False.

    Parameters
    ----------
    source : pyvista.PolyData
        A valid surface.
    scene : Scene
        A scene with a viewer.
    vertices : Vertices
        The surface's vertices.
    matrix : array_like, optional
        (4, 4) model matrix.
    """
    corners = _corners_of_some(source)
    if scene.light_model.two_sided or not corners.size:
        return False
    plain = replace(scene, light_model=LightModel(ambient=0.0, clamp=False))

    def is_lit(points: FloatArray, normals: FloatArray) -> BoolArray:
        diffuse: Any = evaluate(points, normals, plain, _WHITE, matrix=matrix, components=True).diffuse
        lit: BoolArray = diffuse.any(axis=1)
        return lit

    with np.errstate(all="ignore"):
        places, fronts = (rows.T for rows in _places_and_areas(source, corners))
    if source.point_data.active_normals is not None:
        fronts = np.take(np.asarray(source.point_data.active_normals), corners, axis=0).sum(axis=0, dtype=np.float64)
    if is_lit(places / 3.0, fronts).any() or not 2 * np.count_nonzero(is_lit(places / 3.0, -fronts)) > len(places):
        return False
    return not is_lit(vertices.points, vertices.normals).any()


def _corners_of_some(source: pv.PolyData) -> NDArray[np.int64]:
    """Choose m faces of a surface, and return the point indices of three corners of each, shape (3, m).

    In a face with more corners, the three are spaced evenly around it.
    """
    faces = source.GetPolys()
    count, corners = faces.GetNumberOfCells(), vtk_to_numpy(faces.GetConnectivityArray())
    if not count:
        return np.empty((3, 0), np.int64)
    chosen = (_PLACES * count).astype(np.int64) if count > _FACES else np.arange(count)
    if faces.IsStorageFixedSize():  # the offsets are not read, because VTK would create them all
        sizes = np.int64(len(corners) // count)
        first = chosen * sizes
    else:
        offsets = vtk_to_numpy(faces.GetOffsetsArray())
        first = offsets[chosen]
        sizes = offsets[chosen + 1] - first
        first, sizes = first[sizes > 2], sizes[sizes > 2]
    found: NDArray[np.int64] = corners[first + _CORNERS * sizes // 3]
    return found


def _places_and_areas(source: pv.PolyData, corners: NDArray[np.int64]) -> tuple[Float64Array, Float64Array]:
    """Return three times the centres of m triangles, and twice their area vectors, shape (3, m) each.

    An area vector points along the triangle's normal and is as long as its area. `corners` has the point indices of the
    triangles, shape (3, m).
    """
    p, q, r = np.take(np.asarray(source.points), corners, axis=0).transpose(0, 2, 1).astype(np.float64)
    return p + q + r, cross(q - p, r - p)


def _seem_misfits(source: pv.PolyData) -> bool:
    """Return True if, in a sample of faces, those that do not fit the stored normals have most of the area."""
    corners = _corners_of_some(source)
    stored = np.take(np.asarray(source.point_data.active_normals), corners, axis=0).sum(axis=0, dtype=np.float64).T
    with np.errstate(all="ignore"):
        _, areas = _places_and_areas(source, corners)
        sizes = np.sqrt(dot(areas, areas))
        is_off = dot(stored, areas) < _FITS * sizes * np.sqrt(dot(stored, stored))
        return bool(2.0 * sizes[is_off].sum() > sizes.sum())


def _are_misfits(source: pv.PolyData) -> bool:
    """Return True if the mean angle between stored normals and all faces of a surface exceeds `MISFIT`."""
    faces = Faces(source.points, *unchecked_polygons(source))
    weights = weights_of(faces, areas_of(faces))
    fit, _ = fit_of(np.asarray(source.point_data.active_normals), vertex_normals(source), weights)
    return fit is not None and fit.mean > MISFIT


def _looks_inwards(source: pv.PolyData) -> bool:
    """Return True if a surface is nearly closed and the fronts of its faces are inside, judged by a sample of faces."""
    with np.errstate(all="ignore"):
        places, areas = _places_and_areas(source, _corners_of_some(source))
        sizes = np.sqrt(dot(areas, areas))
        volumes = dot(places - ((places @ sizes) / sizes.sum())[:, None], areas)
        is_inward = volumes.sum() < _INWARD * np.abs(volumes).sum()
        return bool(is_inward and (np.abs(areas.sum(axis=1)) <= _BALANCED * np.abs(areas).sum(axis=1)).all())


def _holds_viewer_or_light(source: pv.PolyData, scene: Scene, matrix: MatrixLike | None) -> bool:
    """Return True if the viewer or a light is inside the bounding box of a surface, in world coordinates."""
    bounds = Vertices(source.points, None).bounds(matrix)
    low, high = np.asarray(bounds)[::2], np.asarray(bounds)[1::2]
    viewer: Any = scene.viewer
    places = [viewer.position, *(place for light in scene.world_lights for place in light.places)]
    return any(bool(((low < place) & (place < high)).all()) for place in places)


def _levels_to_caller() -> int:
    """Return the `stacklevel` with which `warnings.warn` names the first caller outside this package."""
    frame, levels = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "pvphong":
        frame, levels = frame.f_back, levels + 1
    return levels
