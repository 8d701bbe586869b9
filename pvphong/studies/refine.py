"""Refinement of a mesh where interpolated colours differ from the evaluated ones, with cuts where colours jump."""

from __future__ import annotations

import numbers
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base import check, text
from pvphong.base.types import Float64Array, FloatArray, IntArray, MatrixLike, Precision
from pvphong.meshes.colormaps import put_scale
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.lit import Setting, put_visibility, refuse_name, vertices_of
from pvphong.meshes.point_data import surface_and_maps
from pvphong.meshes.surfaces import (
    ORIGINAL_POINT,
    FeatureAngle,
    has_faces,
    has_only_triangles,
    point_normals,
    shallow_copy,
)
from pvphong.optics.material import DEFAULT_MATERIAL, Material, as_material
from pvphong.rays.transport import Transport
from pvphong.scene.scene import Scene, SceneLike, light_labels
from pvphong.shading import interreflection
from pvphong.shading.inside.interpolation import all_errors
from pvphong.shading.inside.lighting import Lighting
from pvphong.shading.inside.splitting import Refinement, Stopped
from pvphong.shading.inside.surface import Added, LitSurface
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import known_transport

PunctualParameters = Literal["linear", "smooth"]


# Default limit on the number of added points.
_MOST_ADDED = 1_000_000

# Progress, a fraction of the whole, when the mesh's own vertices are lit.
_LIT = 0.1

# Reasons why the tolerance is not reached.
_NOT_REACHED: dict[Stopped, str] = {
    "max_points": "max_points is used up",
    "jump": "the remaining errors are at jumps of the colour, such as the edge of a cone or of a hard shadow",
    "resolution": "the remaining triangles are as small as the points' type can resolve",
}

# Largest standard error that ray sampling may have, as a fraction of the tolerance.
OF_RAYS = 1.0 / 4.0

# Suffix of the cell array of errors, after the name of the lit colours.
_ERROR = "_interpolation_error"

# Suffix of the point array that pairs coincident points on the two sides of a cut.
_PAIR = "_refinement_pair"


Watcher = Callable[[Callable[[], pv.PolyData]], object]
"""Function with one argument. The argument is a function that returns the mesh as refined so far, with its colours."""

_watcher: ContextVar[Watcher | None] = ContextVar("watcher", default=None)


@contextmanager
def watched(watcher: Watcher) -> Iterator[None]:
    """Return a context in which `refine` calls `watcher` after the cuts of each light and after each round of splits.

    The argument of `watcher` is a function that returns the mesh as refined so far, with its colours.
    """
    token = _watcher.set(watcher)
    try:
        yield
    finally:
        _watcher.reset(token)


class BouncedLight(NamedTuple):
    """Bounced light at the vertices of a mesh. `refine` accepts it in place of a transport."""

    colors: FloatArray
    """Bounced light that each vertex reflects, shape (n, 3), including the remaining ambient light."""


def refine(
    mesh: pv.DataSet,
    scene: SceneLike | None = None,
    material: Material | str = DEFAULT_MATERIAL,
    *,
    tolerance: float,
    max_points: int | None = None,
    name: str = "phong",
    placement: PunctualParameters = "linear",
    matrix: MatrixLike | None = None,
    precision: Precision = "float32",
    feature_angle: FeatureAngle = None,
    occluders: Any = (),
    transport: Transport | BouncedLight | None = None,
    cut: bool = True,
) -> pv.PolyData:
    """Return a new lit mesh whose triangles are split where interpolated colours differ from the evaluated ones.

    Colours are compared with per-pixel shading: the lighting equation at the interpolated point, with the interpolated
    unit normal and the visibility of each light from there. They are compared at 13 points in every triangle, and at
    points that the scene suggests: at the peaks of highlights, spots and near lights, where surfaces turn away from a
    light, and where colours begin to saturate. So a highlight that lies between the corners of a triangle is found too.

    Where the colour jumps, at the edge of a hard shadow or of a spot's cone, triangles are cut along that edge. Each
    point on the cut exists twice: one copy is lit like one side, the second like the other side. So a shadow is as
    crisp as the edge of a face. Rays find where the edge crosses a side of a triangle, to 2⁻²⁰ of the side's length. A
    triangle is split before it is cut if the edge deviates from a straight line between two crossings by more than 2⁻¹²
    of the mesh's diagonal, or if a whole shadow lies inside the triangle.

    Elsewhere triangles are bisected until every error is within the tolerance. A side is split in all triangles that
    share it, so that there are no T-junctions: manifold meshes stay manifold, and closed meshes stay closed. No new
    angle is less than half of the smallest angle of the original triangle.

    Parameters
    ----------
    mesh : pyvista.DataSet
        Dataset with faces; it is not modified. Polygons and strips are triangulated first. Of a dataset other than
        PolyData, the surface is extracted. Vertex and line cells are left out.
    scene, material
        As for `mesh.phong.shade`. Maps are read at the mesh's original points and interpolated at new ones.
    tolerance : float
        Largest absolute colour error that may remain, > 0; 1/255 is one step of a display.
    max_points : int, optional
        Largest number of points of the result, at least the number of points of the mesh. Points are added where the
        product of error and triangle size is largest. Default: a million more than the mesh has.
    name : str, default "phong"
        Name of the (n_points, 3) array of lit colours, and prefix of the other arrays.
    placement : {"linear", "smooth"}
        Position of new vertices. "linear": on the side that they split; the surface does not change. "smooth": on a
        curve between the ends of the side. At each end, the curve is perpendicular to the normal there (the side of a
        PN triangle [1]_, at every split). Sides on a boundary and sides of more than two triangles stay straight, so
        that no cracks open and creases stay sharp.
    matrix : array_like, optional
        (4, 4) model matrix. It affects the lighting only; the mesh's points do not move.
    precision : {"float32", "float64"}
        Type of the colours in the result. They are evaluated in float64.
    feature_angle : float, "auto" or None, default None
        Edges are sharp if the angle between their faces exceeds this, in degrees; see `mesh.phong.shade`. Points along
        them are duplicated first, and do not move.
    occluders : sequence, optional
        As for `mesh.phong.shade`. The noise of soft shadows and occlusion does not cause splits: only errors above
        three standard errors count, and rays are cast until a standard error is a quarter of the tolerance.
    transport : Transport, optional
        As for `mesh.phong.shade`, if the light model has bounces. Bounced light is computed at the mesh's original
        points, and interpolated like maps.
    cut : bool, default True
        Cut triangles where the colour jumps. If False, triangles are split there until they are tiny.

    Returns
    -------
    pyvista.PolyData
        Triangles only. The original points, with copies along sharp edges, come first and do not move;
        ``pvphong_original_point`` is -1 for new points. Point arrays are interpolated linearly. Arrays of 3 or 4 uint8
        channels are colours and are rounded. Other integers, booleans and strings may be labels and are copied: a new
        point on a side takes the value of the end with the lower index. A new normal has the mean length of its
        neighbours' normals. A mesh without active normals gets those of `mesh.phong.normals` before it is split. Cell
        arrays are copied to the parts of each cell.

        If the mesh was cut, the point array ``<name>_refinement_pair`` is the index of the next point at the same
        position, on the other side of the cut, or -1. Where two cuts cross, four points have the same position, and
        their indices form a ring.

        With shadows or occlusion, the visible fractions of each light and of the sky are in ``<name>_visibility_<name
        or index>`` and ``<name>_sky``, as from `mesh.phong.shade`. These fractions differ on the two sides of a cut.
        To light the refined mesh with other colours of the lights and equally crisp edges, stack these arrays to the
        shape (lights + 1, n_points) and pass them to `mesh.phong.shade` as `visibility`. The fraction of a light
        without a size is 1 where points face away from the light, and 0 outside the light's cone.

        The cell array ``<name>_interpolation_error`` is the remaining error in each triangle. Under lights with a size,
        it may be too small where the light jumps at a side of the triangle. Field data describe the result:

        ``<name>_refinement_reached``
            True if the tolerance is reached everywhere.
        ``<name>_refinement_summary``
            Result in one sentence.
        ``<name>_refinement_error``
            Largest remaining error.
        ``<name>_refinement_stopped``
            "tolerance": the tolerance is reached. "max_points": the largest number of points is reached. "jump": the
            tolerance is reached except at jumps that cannot be cut, such as a spot's ambient light, where triangles are
            smaller than 1/1024 of the mesh's diagonal. "resolution": the tolerance is reached except where triangles
            are at the resolution of the points' type.
        ``<name>_refinement_points``
            Number of points before and after.
        ``<name>_refinement_cut``
            Number of sides of triangles that were cut.
        ``<name>_refinement_strip``
            Estimated area along all cuts that has the colours of the wrong side. Where edges are curved, the true area
            may be slightly larger. The estimate includes triangles smaller than 1/1024 of the diagonal that hide the
            tip of a shadow, and triangles that could not be cut, such as those where the edges of several lights meet.

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range, or the mesh has no faces. The message names the argument.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> refined = pv.Sphere().phong.refine(ph.PointLight(position=(0, 0, 2)), tolerance=0.01)
    >>> bool(refined["phong_refinement_reached"][0])
    True

    Notes
    -----
    Errors are measured at samples. Between the samples, errors were up to a tenth larger in one triangle of several
    thousand, and up to a quarter larger in one of a hundred near lamps on coarse triangles. The refinement therefore
    aims at 95 % of the tolerance.

    Triangles without an area, or with a point that is not finite, are split only along with their neighbours. PyVista's
    `validate_mesh` reports triangles as empty if their area is below the epsilon of the points' type, 1.2e-7 in
    float32, whatever the mesh's unit is. The triangles of very fine parts may be smaller.

    References
    ----------
    .. [1] A. Vlachos, J. Peters, C. Boyd, J. L. Mitchell: Curved PN triangles. Symposium on Interactive 3D Graphics
       (2001), 159-166.
    """
    tolerance = check.number("tolerance", tolerance, above=0.0)
    smooth = check.choice("placement", placement, get_args(PunctualParameters)) == "smooth"
    real = check.choice("precision", precision, get_args(Precision))
    cut, rays = check.flag("cut", cut), tolerance * OF_RAYS
    setting = Setting(matrix, feature_angle, occluders, tolerance=rays)
    with text.stage("refining", 0.0, 0.0):
        lit = _lit_triangles(mesh, scene, material, setting, transport, cuts=cut)
    refuse_name(name, lit.mesh)
    count = lit.mesh.n_points
    limit = count + _MOST_ADDED if max_points is None else max_points
    if isinstance(limit, bool) or not isinstance(limit, numbers.Integral) or limit < count:
        check.refuse("max_points", max_points, f"an integer >= {count}, the mesh's number of points, or None")

    def so_far() -> pv.PolyData:
        picture = _split_mesh(lit, refinement, name)
        picture.point_data[name] = lit.lighting.shown(refinement.surface.vertices.colors).astype(real)
        return picture

    def after_round() -> None:
        if (watcher := _watcher.get()) is not None:
            watcher(so_far)

    with _far_ranges_allowed():
        with text.stage("refining", 0.0, _LIT):
            refinement = Refinement(LitSurface(lit.mesh.points, lit.blended, lit.corners, lit.lighting, smooth))
        with text.stage("refining", _LIT, 1.0):
            stopped = refinement.run(tolerance, int(limit), cut=cut, after_round=after_round)
    result, left = _split_mesh(lit, refinement, name), float(refinement.errors.max(initial=0.0))
    quality = f"{tolerance:.3g} everywhere, off by up to {left:.3g}"
    points = f"{result.n_points} points, {result.n_points - count} of them new"
    summary = f"Within {quality}: {points}."
    if stopped != "tolerance":
        summary = f"Not within {quality}: {_NOT_REACHED[stopped]}; {points}."
    result.cell_data[name + _ERROR] = refinement.errors
    result.field_data[f"{name}_refinement_reached"] = [stopped == "tolerance"]
    result.field_data[f"{name}_refinement_summary"] = summary
    result.field_data[f"{name}_refinement_error"] = [left]
    result.field_data[f"{name}_refinement_stopped"] = stopped
    result.field_data[f"{name}_refinement_points"] = [count, result.n_points]
    if refinement.cuts.sides:
        result.point_data[name + _PAIR] = _others_there(refinement.surface.triangles.places)
    result.field_data[f"{name}_refinement_cut"] = [refinement.cuts.sides]
    result.field_data[f"{name}_refinement_strip"] = [refinement.cuts.strip]
    vertices = refinement.surface.vertices
    seen = vertices.seen.T.astype(real)
    if not len(seen):  # no occlusion
        seen = np.ones((lit.lighting.equation.lights + 1, result.n_points), real)
    put_visibility(result, name, light_labels(lit.lighting.scene), lit.lighting.equation, seen)
    result.point_data[name] = lit.lighting.shown(vertices.colors).astype(real)
    put_scale(result, name, as_material(material), mesh)
    result.set_active_scalars(name, preference="point")
    return result


def interpolation_error(
    mesh: pv.DataSet,
    scene: SceneLike | None = None,
    material: Material | str = DEFAULT_MATERIAL,
    *,
    matrix: MatrixLike | None = None,
    feature_angle: FeatureAngle = None,
    occluders: Any = (),
    transport: Transport | BouncedLight | None = None,
) -> pv.PolyData:
    """Return a new mesh with the largest error of interpolated colours in each triangle.

    The error is the difference from per-pixel shading.

    Parameters
    ----------
    mesh, scene, material, matrix, feature_angle, occluders, transport
        As for `refine`.

    Returns
    -------
    pyvista.PolyData
        The mesh's triangles with the cell array ``phong_interpolation_error``, float64: the largest absolute difference
        of any channel at the points that `refine` examines. The error is 0 in triangles without an area or with a point
        that is not finite. Other arrays are kept. Like a result of `shade`, the new mesh shares memory with `mesh` if
        `mesh` has only triangles.

    Raises
    ------
    ValueError
        As for `refine`.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> report = pv.Sphere().phong.interpolation_error(ph.DirectionalLight())
    >>> len(report.cell_data) > 0
    True
    """
    setting = Setting(matrix, feature_angle, occluders, tolerance=OF_RAYS / 255.0)
    lit = _lit_triangles(mesh, scene, material, setting, transport)
    with _far_ranges_allowed():
        vertices = lit.lighting.vertices(lit.mesh.points, lit.blended)
        errors = all_errors(vertices, lit.corners)
    result = shallow_copy(lit.mesh)
    result.cell_data["phong" + _ERROR] = errors
    result.set_active_scalars("phong" + _ERROR, preference="cell")
    return result


class _LitTriangles(NamedTuple):
    mesh: pv.PolyData
    corners: IntArray
    normals: FloatArray
    """Normals as the mesh stores them."""
    blended: Float64Array
    """Normals to interpolate: the stored normals divided by 2**exponent, so that the longest is near 1 and nothing
    overflows. A normal that is not finite is replaced by 0.
    """
    exponent: int
    lighting: Lighting


def _lit_triangles(
    mesh: pv.DataSet,
    given_scene: SceneLike | None,
    material: Material | str,
    setting: Setting,
    transport: Transport | BouncedLight | None,
    *,
    cuts: bool = False,
) -> _LitTriangles:
    material, matrix = as_material(material), setting.matrix
    source, maps, tangents = surface_and_maps(mesh, material, setting.feature_angle)
    scene = scene_for(source, given_scene, matrix)
    if not has_faces(source):
        remedy = "A point cloud has no triangles to refine."
        check.refuse("mesh", f"{source.n_points} points without faces", "a mesh with faces", remedy)
    triangles = source
    if not has_only_triangles(source):
        # VTK's triangulation mixes up the arrays of vertices, lines and faces. Remove vertices and lines first.
        faces = shallow_copy(source)
        faces.clear_cell_data()
        faces.SetVerts(None)
        faces.SetLines(None)
        first = source.n_verts + source.n_lines
        for key in source.cell_data:
            faces.cell_data[key] = np.asarray(source.cell_data[key])[first:]
        triangles = faces.triangulate()
    normals = point_normals(source)
    blended = normals.astype(np.float64)
    blended[~np.isfinite(blended).all(axis=1)] = 0.0
    exponent = int(np.frexp(np.abs(blended).max(initial=0.0))[1])
    corners, blended = triangles.regular_faces.astype(np.intp), np.ldexp(blended, -exponent)
    direct = _of_direct_light(scene)
    if isinstance(transport, BouncedLight):
        vertices = vertices_of(source, maps, tangents, direct, setting)
    else:
        vertices = vertices_of(source, maps, tangents, scene, replace(setting, transport=transport))
        transport = _bounced_light(vertices, scene, material, matrix) if scene.light_model.bounces else None
    if transport is not None:
        scene, vertices = direct, vertices.sending(transport.colors, material)
    lighting = Lighting(scene, material, matrix, vertices, cuts=cuts)
    return _LitTriangles(triangles, corners, normals, blended, exponent, lighting)


def _of_direct_light(scene: Scene) -> Scene:
    """Return a scene with only its direct light, that is, without bounces and without ambient light."""
    lights = [replace(light, ambient=0.0) for light in scene.lights]
    return replace(scene, lights=lights, light_model=replace(scene.light_model, bounces=0, ambient=0.0))


def _bounced_light(vertices: Vertices, scene: Scene, material: Material, matrix: MatrixLike | None) -> BouncedLight:
    plan = Plan.of(scene, material, vertices, matrix=matrix)
    if not plan.equation.bounces:  # no vertex sees another
        return BouncedLight(np.zeros((len(vertices), 3)))
    sent, gather = plan.sent(vertices, precision="float64"), known_transport(vertices).gather
    return BouncedLight(interreflection.bounced(sent, gather, plan.equation.bounces, apart=False)[0])


def _far_ranges_allowed() -> np.errstate:
    """Return a context in which NumPy does not warn of overflow, underflow and NaN.

    If large coordinates overflow, only some samples of the error are lost.
    """
    return np.errstate(over="ignore", under="ignore", invalid="ignore")


def _others_there(places: IntArray) -> IntArray:
    """Return the next point at the same position for each point, shape (n,); -1 if there is no other.

    The points at one position form a ring. Points with equal numbers in `places` are at the same position.
    """
    order = np.argsort(places, kind="stable")
    starts = np.flatnonzero(np.diff(places[order], prepend=-1))
    following = np.roll(order, -1)
    following[np.append(starts[1:], len(order)) - 1] = order[starts]
    result = np.empty_like(places)
    result[order] = np.where(following == order, -1, following)
    return result


def _split_mesh(lit: _LitTriangles, refinement: Refinement, name: str) -> pv.PolyData:
    """Return the refined triangles as a mesh, with the arrays of the original mesh.

    Parameters
    ----------
    lit : _LitTriangles
        The original triangles.
    refinement : Refinement
        The refined triangles and their vertices.
    name : str
        Name of the lit colours. If the original mesh has no active normals, the normals are stored as an array whose
        name differs from `name` and from the names of other arrays.
    """
    source, surface = lit.mesh, refinement.surface
    triangles, vertices = surface.triangles, surface.vertices
    added = slice(source.n_points, None)
    points = np.concatenate([source.points, vertices.points[added].astype(source.points.dtype)])
    result = pv.PolyData.from_regular_faces(points, triangles.corners)
    for key in source.point_data:
        result.point_data[key] = _interpolated(np.asarray(source.point_data[key]), surface.added)
    if refinement.cuts.sides and ORIGINAL_POINT not in result.point_data:
        result.point_data[ORIGINAL_POINT] = np.arange(result.n_points)
    if ORIGINAL_POINT in result.point_data:
        result.point_data[ORIGINAL_POINT][added] = -1
    for key in source.cell_data:
        result.cell_data[key] = np.asarray(source.cell_data[key])[triangles.source]
    result.field_data.update(source.field_data)
    key = source.point_data.active_normals_name
    if key is None:
        key = "Normals"
        while key in (*source.point_data, name):  # already taken
            key += "_"
    new_normals = np.ldexp(vertices.stored[added], lit.exponent)
    result.point_data[key] = np.concatenate([lit.normals, new_normals.astype(lit.normals.dtype)])
    result.point_data.active_normals_name = key
    result.point_data.active_texture_coordinates_name = source.point_data.active_texture_coordinates_name
    result.point_data.active_vectors_name = source.point_data.active_vectors_name
    return result


def _interpolated(values: NDArray[Any], added: list[Added]) -> NDArray[Any]:
    """Extend a point array by the values of the new points in `added`, and return it.

    Floats and colours are blended between the ends of the split side. Other values may be labels; they are copied from
    the end with the lower index.
    """
    start, kind = len(values), values.dtype
    result = np.empty((start + sum(len(each.along) for each in added), *values.shape[1:]), dtype=kind)
    result[:start] = values
    for parents, along in added:
        low, high = (result[ends] for ends in np.sort(parents, axis=1).T)
        t = np.where(parents[:, 0] <= parents[:, 1], along, 1.0 - along).reshape(-1, *(1,) * (values.ndim - 1))
        if kind.kind in "fc":
            with np.errstate(invalid="ignore", under="ignore"):
                low = low * (1.0 - t).astype(kind) + high * t.astype(kind)
        elif kind == np.uint8 and values.ndim == 2 and values.shape[1] in (3, 4):
            low = np.floor(low * (1.0 - t) + high * t + 0.5).astype(np.uint8)
        result[start : start + len(parents)] = low
        start += len(parents)
    return result
