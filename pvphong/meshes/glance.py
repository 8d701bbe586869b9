"""A glance at some faces before a mesh is lit: whether stored normals fit them, and whether they look inwards.

It costs the same for every mesh, about 100 microseconds, and is not repeated while the mesh stays as it is. Where most
of these faces are at odds with the stored normals, all are looked at before a warning is given, as by
`pvphong.diagnose`.
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
# Parts of the way through the faces, spread evenly and in step with no row of a grid: by the golden ratio
_PLACES = np.arange(_FACES) * (5.0**0.5 - 1.0) / 2.0 % 1.0
_CORNERS = np.arange(3)[:, None]

# The cosine of 30 degrees, from which stored normals seem not to fit a face. At sharp edges they may fit all faces
# around and none of them: in a cube of triangles with a normal at each corner of the cube they are off by 25.
_FITS = 0.866
# A closed surface has as much area that looks one way along an axis as the other, and the sum of its faces' distances
# from the middle, along their fronts, is its volume. Shares of the sums of the magnitudes, with some room for a sample
# of the faces: of rough bodies that look outwards, the ant of PyVista's examples has 0.34.
_BALANCED, _INWARD = 0.3, -0.3

_WHITE = Material(ambient=0.0, diffuse=1.0)

# States of meshes that need no second look: all is well, or the warning was given.
_seen: dict[tuple[int, ...], None] = {}
_REMEMBERED = 1024

_MISFIT = (
    "Most of the mesh's stored normals do not fit its faces, and it is lit by them: it was changed after they were "
    'computed. mesh.point_data.active_normals = mesh.phong.normals("angle") computes them anew; where the faces were '
    "turned, mesh.flip_faces() turns them back. mesh.phong.diagnose() says more."
)
_BACKS = (
    "The mesh's faces look inwards, so that light from outside falls on their backs, which stay dark. "
    "mesh.flip_faces() turns them; LightModel(two_sided=True) lights both sides. mesh.phong.diagnose() says more."
)


class NormalsWarning(UserWarning):
    """A mesh's normals or faces look the wrong way, so that it is lit otherwise than it looks.

    Examples
    --------
    >>> import warnings, pvphong as ph
    >>> warnings.simplefilter("error", ph.NormalsWarning)  # raise it
    """


def warn_of_normals(mesh: pv.DataSet, source: pv.PolyData, scene: Scene, matrix: MatrixLike | None = None) -> None:
    """Warn where most normals of a surface look the wrong way; parameters are those of `complaint`.

    Warns
    -----
    NormalsWarning
        At the line outside of this package that called it.
    """
    text = complaint(mesh, source, scene, matrix)
    if text:
        warnings.warn(text, NormalsWarning, stacklevel=_levels_to_caller())


def complaint(mesh: pv.DataSet, source: pv.PolyData, scene: Scene, matrix: MatrixLike | None = None) -> str:
    """What is wrong with most normals of a surface, and the remedy; once for each state of a PolyData, then "".

    Faces that look inwards are a fault of a PolyData without stored normals alone, as isosurfaces are. It is none where
    both sides are lit, or where the viewer or a light is inside, as in a room.

    Parameters
    ----------
    mesh : pyvista.DataSet
        What was given.
    source : pyvista.PolyData
        Its checked surface.
    scene : Scene
        With a viewer.
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
    """Whether every vertex faces away from every light, and would be lit from behind.

    Some faces are looked at first: mostly one of them faces a light, and that is the end of it.

    Parameters
    ----------
    source : pyvista.PolyData
        A checked surface.
    scene : Scene
        With a viewer.
    vertices : Vertices
        Of the surface.
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
    """Three corners of each of some faces, shape (3, m); far apart where a face has many."""
    faces = source.GetPolys()
    count, corners = faces.GetNumberOfCells(), vtk_to_numpy(faces.GetConnectivityArray())
    if not count:
        return np.empty((3, 0), np.int64)
    chosen = (_PLACES * count).astype(np.int64) if count > _FACES else np.arange(count)
    if faces.IsStorageFixedSize():  # its offsets would be made, all of them
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
    """The middles of faces, three times, and their area vectors, four times, each a column a face."""
    p, q, r = np.take(np.asarray(source.points), corners, axis=0).transpose(0, 2, 1).astype(np.float64)
    return p + q + r, cross(q - p, r - p)


def _seem_misfits(source: pv.PolyData) -> bool:
    """Whether stored normals are off most of some faces, by area."""
    corners = _corners_of_some(source)
    stored = np.take(np.asarray(source.point_data.active_normals), corners, axis=0).sum(axis=0, dtype=np.float64).T
    with np.errstate(all="ignore"):
        _, areas = _places_and_areas(source, corners)
        sizes = np.sqrt(dot(areas, areas))
        is_off = dot(stored, areas) < _FITS * sizes * np.sqrt(dot(stored, stored))
        return bool(2.0 * sizes[is_off].sum() > sizes.sum())


def _are_misfits(source: pv.PolyData) -> bool:
    """Whether stored normals are off those that all faces give, on average."""
    faces = Faces(source.points, *unchecked_polygons(source))
    weights = weights_of(faces, areas_of(faces))
    fit, _ = fit_of(np.asarray(source.point_data.active_normals), vertex_normals(source), weights)
    return fit is not None and fit.mean > MISFIT


def _looks_inwards(source: pv.PolyData) -> bool:
    """Whether a surface is closed, or nearly, and its fronts are inside, as far as some faces tell."""
    with np.errstate(all="ignore"):
        places, areas = _places_and_areas(source, _corners_of_some(source))
        sizes = np.sqrt(dot(areas, areas))
        volumes = dot(places - ((places @ sizes) / sizes.sum())[:, None], areas)
        is_inward = volumes.sum() < _INWARD * np.abs(volumes).sum()
        return bool(is_inward and (np.abs(areas.sum(axis=1)) <= _BALANCED * np.abs(areas).sum(axis=1)).all())


def _holds_viewer_or_light(source: pv.PolyData, scene: Scene, matrix: MatrixLike | None) -> bool:
    """Whether the viewer or a light is within the box around a surface."""
    bounds = Vertices(source.points, None).bounds(matrix)
    low, high = np.asarray(bounds)[::2], np.asarray(bounds)[1::2]
    viewer: Any = scene.viewer
    places = [viewer.position, *(place for light in scene.world_lights for place in light.places)]
    return any(bool(((low < place) & (place < high)).all()) for place in places)


def _levels_to_caller() -> int:
    """How far up the stack the first function is that is not this package's, as `warnings.warn` counts."""
    frame, levels = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "pvphong":
        frame, levels = frame.f_back, levels + 1
    return levels
