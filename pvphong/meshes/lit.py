"""Lighting functions of `mesh.phong`: colours, plan, visibility and normals of a mesh's points.

A mesh is lit in three steps. The first step makes its surface (`surfaces.py`), the values of maps at its points
(`point_data.py`) and a scene with a viewer (`default_scene.py`). The second step makes `Vertices` and a `Plan` from
these. The third step, `Plan.run`, computes the colours.
"""

from __future__ import annotations

import functools
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise, starmap
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonDataModel import vtkDataObject

from pvphong.base import check
from pvphong.base.types import Backend, FloatArray, MatrixLike, Precision, Weighting
from pvphong.geometry.transform import transform_normals
from pvphong.meshes.blocks import leaves, map_blocks, of_each
from pvphong.meshes.colormaps import put_scale
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.glance import faces_away, warn_of_normals
from pvphong.meshes.point_data import names_taken, surface_and_maps, tangents_from
from pvphong.meshes.surfaces import FeatureAngle, point_normals, shallow_copy, split_sharp_edges, surface
from pvphong.meshes.transport import Exchanging, checked_transport
from pvphong.meshes.visibility import KnownOccluders, visibility_of
from pvphong.optics.material import DEFAULT_MATERIAL, Material, as_material
from pvphong.rays.transport import Transport, TransportPart
from pvphong.rays.visibility import Visibility
from pvphong.scene.options import known_options
from pvphong.scene.scene import Scene, SceneLike, as_scene, light_labels
from pvphong.shading import interreflection
from pvphong.shading.equation import Equation, in_parts
from pvphong.shading.interreflection import Radiosity
from pvphong.shading.plan.plan import Plan, is_worth_loading
from pvphong.shading.reference import Shading, seen_by_viewer
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import VisibilityLike, checked_visibility


def shade_mesh(
    mesh: pv.DataSet,
    scene: SceneLike | None = None,
    material: Material | str = DEFAULT_MATERIAL,
    *,
    name: str = "phong",
    matrix: MatrixLike | None = None,
    components: bool = False,
    tolerance: float = 0.0,
    precision: Precision = "float32",
    backend: Backend = "auto",
    feature_angle: FeatureAngle = None,
    occluders: Any = (),
    visibility: Visibility | None = None,
    transport: Transport | None = None,
    shares_by_bounce: bool = False,
) -> pv.PolyData:
    """Compute lit colours, and return them as a point array of a new mesh.

    The mesh's active point normals are used unchanged. If it has none, normals are computed from its faces, weighted
    by angle. If the dataset is not a PolyData, its surface is extracted, with its arrays, and lit.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface; it is not modified.
    scene : Scene, light, or sequence of lights, optional
        Lights, viewer and light model, in world coordinates; by default `pvphong.default_scene`. If there is no viewer,
        PyVista's default camera is used, which frames the mesh.
    material : Material or str, optional
        A Material, whose fields are numbers, colours or maps; or the name of a predefined material. By default
        OpenGL's default material.
    name : str, default "phong"
        Name of the new point array: shape (n_points, 3), linear RGB in [0, 1]. It becomes the active scalars.
    matrix : array_like, optional
        (4, 4) model matrix, as on an actor. It affects the lighting only; the points are not moved.
    components : bool, default False
        If True, add two sets of point arrays. Each set sums to the unclamped colour; ``NAME`` stands for `name`. The
        first set has one array per term: ``NAME_ambient``, ``NAME_diffuse``, ``NAME_specular`` and ``NAME_emission``.
        The second has one per light, ``NAME_light_LIGHT`` with the light's name or index, and ``NAME_base`` for
        emission and the light model's ambient light. With bounces, ``NAME_bounced`` belongs to both sets.
    tolerance : float, default 0
        Largest absolute colour error that is allowed in order to save time; 0 allows no approximation.
    precision : {"float32", "float64"}
        Precision of the arrays and the arithmetic. For colours up to 1, the error of float32 is at most
        (4√n + 16) · 2⁻²⁴ · (1 + number of lights), where n is the largest of the shininess and the spot lights'
        exponents; see `pvphong.evaluate`. Bounces are always gathered in float32, with an error of about 3e-6.
    backend : {"auto", "numpy", "numba"}
        Evaluator of the colours, as for `pvphong.evaluate`, and of normals, as for `pvphong.pipeline.vertex_normals`.
    feature_angle : float, "auto" or None, default None
        An edge is sharp if the normals of its two faces differ by more than this angle, in degrees. Points are
        duplicated along sharp edges, and the array ``pvphong_original_point`` holds their original indices. 0 is flat
        shading. "auto" is 30 if the mesh has no point normals, and None if it has. None splits nothing.
    occluders : sequence, optional
        Other meshes that block light, each as a mesh or a pair of a mesh and a 4x4 matrix. They are used if the light
        model has shadows, ambient occlusion or bounces; the mesh itself then blocks light too.
    visibility : Visibility, optional
        Result of `mesh.phong.visibility` for this mesh and these lights, used instead of casting rays; or an array of
        visibilities, as for `pvphong.evaluate`. With `components=True`, the visibility on the side that the viewer sees
        is added as ``NAME_visibility_LIGHT`` for each light and ``NAME_sky``.
    transport : Transport, optional
        Result of `mesh.phong.transport` for this mesh, used for bounces instead of casting rays.
    shares_by_bounce : bool, default False
        With `components=True`, also add one array for each bounce, ``NAME_bounce_1`` and so on. They sum to
        ``NAME_bounced``. The last one includes the ambient light that stands for the remaining bounces.

    Returns
    -------
    pyvista.PolyData
        The surface with the new arrays. It shares points, cells and all other arrays with `mesh`, like the outputs of
        VTK's filters: a change in place affects both meshes. Its ``.copy()`` shares nothing.

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range, or the mesh has nothing that can be lit.

    Warns
    -----
    NormalsWarning
        If most of the stored normals do not fit the faces, or if a closed mesh without stored normals has faces that
        look inwards. The warning is not repeated while the mesh is unchanged.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight())
    >>> lit["phong"].shape
    (842, 3)
    """
    setting = Setting(matrix, feature_angle, occluders, visibility, transport, tolerance, backend)
    prepared = prepare(mesh, scene, material, setting)
    warn_of_normals(mesh, prepared.source, prepared.scene, matrix)
    _refuse_output(name, prepared.source, components, shares_by_bounce)
    shading = prepared.plan.run(prepared.vertices, precision=precision, backend=backend, components=components)
    return _lit_mesh(prepared, shading, name, shares_by_bounce)


@dataclass(frozen=True)
class Setting:
    """Options of every call that lights a mesh. The fields are the parameters of `shade_mesh` with the same names."""

    matrix: MatrixLike | None = None
    feature_angle: FeatureAngle = None
    occluders: Any = ()
    visibility: Visibility | None = None
    transport: Transport | TransportPart | None = None
    tolerance: float = 0.0
    backend: Backend = "auto"


class Prepared(NamedTuple):
    """A mesh with the plan that lights it, and the inputs of this plan. A plan is a simplified lighting equation."""

    mesh: pv.DataSet
    """The given mesh, or a copy that shares its arrays."""
    source: pv.PolyData
    """The mesh's surface."""
    scene: Scene
    vertices: Vertices
    material: Material
    plan: Plan


class Ready(NamedTuple):
    """A mesh with everything that is needed to plan its lighting. The fields mean the same as in `Prepared`."""

    mesh: pv.DataSet
    source: pv.PolyData
    scene: Scene
    vertices: Vertices
    material: Material


def prepare(mesh: pv.DataSet, scene: SceneLike | None, material: Material | str, setting: Setting) -> Prepared:
    """Prepare a mesh to be lit: its surface, its vertices, a scene with a viewer, and a plan (its simplified equation).

    `setting` has the options of the call, such as the model matrix and the tolerance.
    """
    found = ready(mesh, scene, material, setting)
    how: dict[str, Any] = {"matrix": setting.matrix, "tolerance": setting.tolerance}
    return Prepared(*found, Plan.of(found.scene, found.material, found.vertices, **how))


def ready(mesh: pv.DataSet, scene: SceneLike | None, material: Material | str, setting: Setting) -> Ready:
    """Return a mesh with all that is needed to plan its lighting: surface, scene with a viewer, vertices and material.

    If `mesh` is a PolyData, the returned mesh is a shallow copy of it. `setting` has the options of the call.
    """
    # Another thread may replace arrays of the mesh meanwhile. The copy keeps the old ones, so old and new do not mix.
    now = shallow_copy(mesh) if isinstance(mesh, pv.PolyData) else mesh
    material = as_material(material)
    source, maps, tangents = surface_and_maps(now, material, setting.feature_angle)
    scene = scene_for(source, scene, setting.matrix)
    return Ready(now, source, scene, vertices_of(source, maps, tangents, scene, setting), material)


def _refuse_output(name: str, source: pv.PolyData, components: bool, shares_by_bounce: bool) -> None:
    refuse_name(name, source)
    if check.flag("shares_by_bounce", shares_by_bounce) and not components:
        check.refuse("shares_by_bounce", True, "False without components=True")


def refuse_name(name: Any, source: pv.PolyData) -> None:
    """Raise ``ValueError`` if lit colours of the surface `source` cannot have the name `name`.

    The name must not be empty, nor that of an array that the lighting reads.
    """
    if not isinstance(name, str) or not name:
        check.refuse("name", name, "a nonempty string")
    data = source.GetPointData()
    for array, what in ((data.GetNormals(), "normals"), (data.GetTCoords(), "texture coordinates")):
        if array is not None and array.GetName() == name:
            allowed = "different from the names of the mesh's normals and texture coordinates"
            check.refuse("name", f"{name!r}, the name of the mesh's {what}", allowed, 'The default is "phong".')


def _lit_mesh(prepared: Prepared, shading: Shading, name: str, shares_by_bounce: bool) -> pv.PolyData:
    """Return a new mesh with the colours of `shading` as the array `name`. Components are added if they were computed.

    With `shares_by_bounce`, an array for each bounce is added too. `prepared` is the mesh that was lit.
    """
    now, source, scene, vertices, material, planned = prepared
    lit = source if source is now else shallow_copy(source)
    if shading.per_light is not None:
        labels = light_labels(scene)
        if vertices.visibility is not None:
            equation = planned.equation
            if (channels := vertices.channels(equation)) is not None and equation.needs_visibility:
                normals = vertices.normals_if(equation.needs_normals)
                seen = seen_by_viewer(vertices.points, normals, equation, channels)
                put_visibility(lit, name, labels, equation, seen)
        for part in ("ambient", "diffuse", "specular", "emission", "base"):
            lit.point_data[f"{name}_{part}"] = getattr(shading, part)
        for label, share in zip(labels, shading.per_light, strict=True):
            lit.point_data[f"{name}_light_{label}"] = share
        if shading.bounced is not None:
            lit.point_data[f"{name}_bounced"] = shading.bounced.sum(axis=0)
            for bounce, share in enumerate(shading.bounced, 1) if shares_by_bounce else ():
                lit.point_data[f"{name}_bounce_{bounce}"] = share
    lit.point_data.set_array(shading.rgb, name)
    put_scale(lit, name, material, now)
    lit.set_active_scalars(name, preference="point")
    return lit


def shade_blocks(
    blocks: pv.MultiBlock,
    scene: Scene,
    own: Iterator[tuple[Material | str, dict[str, Any]]],
    *,
    name: str = "phong",
    components: bool = False,
    shares_by_bounce: bool = False,
    precision: Precision = "float32",
    backend: Backend = "auto",
) -> pv.MultiBlock:
    """Light the blocks of a MultiBlock. The results are exactly equal to those of `shade_mesh` for each block.

    Because of the overhead of each plan and call, lighting a hundred points takes as long as lighting ten thousand. So
    small blocks of the same material, without maps, form a group that has one plan and is lit in one call.

    Parameters
    ----------
    blocks : pyvista.MultiBlock
        The blocks; they are not modified.
    scene : Scene
        Scene with a viewer and without bounces.
    own : iterator
        Material, and a dictionary with the fields of `Setting`, for each nonempty dataset in order.
    name, components, shares_by_bounce, precision, backend
        Parameters of `shade_mesh`, the same for all blocks.
    """
    groups: dict[Any, tuple[list[Ready], Iterator[pv.PolyData]]] = {}
    equations: dict[int, Equation] = {}

    def light(members: list[Ready], setting: Setting, backend: Backend) -> Iterator[pv.PolyData]:
        """Light the members of a group in one call, and yield their lit meshes in the same order.

        `setting` and `backend` are common to all members.
        """
        parts = [member.vertices for member in members]
        vertices = parts[0] if len(parts) == 1 else Vertices.of_all(parts)
        how: dict[str, Any] = {"matrix": setting.matrix, "tolerance": setting.tolerance}
        planned = Plan.of(scene, members[0].material, vertices, **how)
        shading = planned.run(vertices, precision=precision, backend=backend, components=components)
        ends = accumulate(map(len, parts), initial=0)
        for member, rows in zip(members, starmap(slice, pairwise(ends)), strict=True):
            # A view would keep the colours of the whole group in memory.
            its_own = shading if len(members) == 1 else shading.part(rows).copy()
            yield _lit_mesh(Prepared(*member, planned), its_own, name, shares_by_bounce)

    def group_key(member: Ready, setting: Setting) -> Any:
        """Return a key. Blocks with equal keys can be lit in one call; None is for a block to be lit alone."""
        material, vertices = member.material, member.vertices
        if vertices.maps or setting.tolerance:  # a plan with a tolerance depends on all its vertices
            return None
        if id(material) not in equations:
            equations[id(material)] = in_parts(vertices.equation(scene, material, setting.matrix))
        equation = equations[id(material)]
        if equation.channels or is_worth_loading(len(vertices), equation):
            return None
        stored = member.source.GetPointData().GetNormals()
        return id(material), vertices.points.dtype, None if stored is None else stored.GetDataType()

    def prepare_block(block: pv.DataSet) -> Iterator[pv.PolyData]:
        """Prepare a block and add it to its group. Return the iterator that yields its lit mesh.

        The blocks of a group share one iterator, which yields their meshes in order.
        """
        material, options = next(own)
        setting = Setting(**options)
        member = ready(block, scene, material, setting)
        warn_of_normals(block, member.source, scene, setting.matrix)
        _refuse_output(name, member.source, components, shares_by_bounce)
        key = group_key(member, setting)
        if key is None:
            return light([member], setting, backend)
        if key not in groups:
            members: list[Ready] = []
            # With "auto", NumPy would light each of these small blocks alone. For equal bits, it lights the group.
            groups[key] = members, light(members, setting, "numpy" if backend == "auto" else backend)
        members, results = groups[key]
        members.append(member)
        return results

    # All blocks have been added to their groups before the first iterator starts.
    iterators = deque(of_each(blocks, prepare_block))
    return map_blocks(blocks, lambda _: next(iterators.popleft()))


def lit_together(
    prepared: Sequence[Prepared],
    together: Transport,
    *,
    name: str = "phong",
    components: bool = False,
    shares_by_bounce: bool = False,
    **how: Any,
) -> Iterator[pv.PolyData]:
    """Light meshes that reflect light to each other, and yield the lit meshes in order.

    `name`, `components`, `shares_by_bounce` and the other options are parameters of `shade_mesh`.

    Parameters
    ----------
    prepared : sequence of Prepared
        The meshes. The transport of each mesh's vertices is its part of `together`.
    together : Transport
        The transport between all meshes.
    """
    of_each = [each.plan.sent(each.vertices, **how) for each in prepared]
    count = max((each.plan.equation.bounces for each in prepared), default=0)
    shares: FloatArray | None = None
    if count:
        shares = interreflection.bounced(Radiosity.of_all(of_each), together.gather, count, apart=bool(components))
    for each, rows in zip(prepared, together.slices, strict=True):
        _refuse_output(name, each.source, components, shares_by_bounce)
        bounced = None if shares is None else shares[:, rows]
        shading = each.plan.run(each.vertices, components=components, bounced=bounced, **how)
        yield _lit_mesh(each, shading, name, shares_by_bounce)


@known_options
def plan(
    mesh_or_points: Any,
    scene: SceneLike | None = None,
    material: Material | str = DEFAULT_MATERIAL,
    *,
    matrix: MatrixLike | None = None,
    tolerance: float = 0.0,
    feature_angle: FeatureAngle = None,
    occluders: Any = (),
    visibility: Visibility | None = None,
    transport: Transport | None = None,
) -> Plan:
    """Plan the effects of a scene: list those that will be computed and those that will be skipped, with reasons.

    An effect that contributes nothing is skipped; this causes no error. With a `tolerance`, effects are also
    approximated or skipped. A far light becomes directional, and a far viewer infinitely far. Nearly uniform
    attenuation and spot falloff become constant. Weak lights and highlights are skipped. The errors are bounded before
    any colour is computed.

    Parameters
    ----------
    mesh_or_points : pyvista.DataSet or array_like
        A mesh, or an array of points of shape (n, 3). The normals of a mesh may show that there are no highlights. An
        array has no normals; `evaluate`, which also gets normals, may skip more effects than the plan. If this could
        cause a larger error than the plan's own bound, `error_bound` is the whole tolerance.
    scene : Scene, light, sequence of lights, or None
        The scene. If it has no viewer, PyVista's default camera is used, which frames the mesh or points. For a mesh,
        None means `default_scene`.
    material : Material or str, optional
        Material of the surface, or its name; by default OpenGL's. For points, its maps must be arrays.
    matrix : array_like, optional
        (4, 4) model matrix.
    tolerance : float, default 0
        Largest allowed absolute colour error; 1/255 is one step of a display.
    feature_angle : float, "auto" or None, default None
        For a mesh only: split edges whose faces' normals differ by more than this angle, in degrees.
    occluders : sequence, optional
        For a mesh only: other meshes that block light, each as a mesh or a pair of a mesh and a 4x4 matrix.
    visibility, transport : Visibility and Transport, optional
        For a mesh only: results of `mesh.phong.visibility` and `mesh.phong.transport`. No rays are cast.

    Returns
    -------
    Plan
        `.effects`, `.needs`, `.view_dependent`, `.error_bound`, `.faces_away`, `.maps`, `.explain()`.

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range; the message names it.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> ph.plan(pv.Sphere(), ph.DirectionalLight(), ph.Material(specular=0.5)).view_dependent
    True
    """
    material = as_material(material)
    if isinstance(mesh_or_points, pv.DataSet):
        setting = Setting(matrix, feature_angle, occluders, visibility, transport, tolerance)
        ready = prepare(mesh_or_points, scene, material, setting)
        is_away = faces_away(ready.source, ready.scene, ready.vertices, matrix)
        return replace(ready.plan, faces_away=is_away, maps=names_taken(ready.material, ready.mesh))
    allowed = "a mesh or an (n, 3) array of real numbers"
    if isinstance(mesh_or_points, pv.MultiBlock):
        remedy = "Use blocks.phong.plan(...), which plans each block separately."
        check.refuse("mesh_or_points", f"a MultiBlock of {mesh_or_points.n_blocks} blocks", allowed, remedy)
    if isinstance(mesh_or_points, vtkDataObject):
        remedy = "Convert a VTK dataset with pyvista.wrap(...)."
        check.refuse("mesh_or_points", f"a {type(mesh_or_points).__name__}", allowed, remedy)
    points = check.array("mesh_or_points", mesh_or_points, allowed=allowed)
    of_mesh = {"feature_angle": feature_angle, "visibility": visibility, "transport": transport}
    if not isinstance(occluders, Sequence) or len(occluders):
        of_mesh["occluders"] = occluders
    for name, given in of_mesh.items():
        if given is not None:
            check.refuse(name, f"a {type(given).__name__}", "left out for bare points", "It needs the faces of a mesh.")
    vertices = Vertices(points, None, material.maps)
    scene = as_scene(scene, lambda: vertices.bounds(matrix))
    result = Plan.of(scene, material, vertices, matrix=matrix, tolerance=tolerance)
    is_open = bool(tolerance) and any(result.equation.has(term, "specular") for term in result.equation.terms)
    return replace(result, error_bound=tolerance) if is_open else result


def put_visibility(lit: pv.PolyData, name: str, labels: Sequence[str], equation: Equation, seen: FloatArray) -> None:
    """Add point arrays to a mesh: the visibility of each light with shadows, and of the sky if it is used.

    Parameters
    ----------
    lit : pyvista.PolyData
        Mesh to which the arrays ``NAME_visibility_LABEL`` and ``NAME_sky`` are added.
    name : str
        Name of the colours.
    labels : sequence of str
        Labels of all lights.
    equation : Equation
        Equation that knows which lights have shadows.
    seen : ndarray
        Visibility of the lights and, in the last row, of the sky, shape (lights + 1, n).
    """
    for index in equation.shadowed:
        lit.point_data[f"{name}_visibility_{labels[index]}"] = seen[index].copy()
    if equation.is_occluded:
        lit.point_data[f"{name}_sky"] = seen[-1].copy()


def visibility(
    mesh: pv.DataSet,
    scene: SceneLike | None = None,
    *,
    occluders: Any = (),
    samples: int | None = None,
    tolerance: float = 1.0 / 255.0,
    matrix: MatrixLike | None = None,
    feature_angle: FeatureAngle = None,
) -> Visibility:
    """Compute the visibility of each light, and of the sky, from each vertex; `shade` accepts the result.

    Rays are cast when an array of the result is first read. A point, spot or directional light needs one ray for each
    vertex that faces it. A light with a size needs at least 16 rays per vertex, and the sky or an environment light at
    least 64. If these rays disagree, as at the edges of shadows, more are cast. A light with `casts_shadows=False`
    needs none: its visibility is 1 everywhere. The directions of the rays depend only on the index of their vertex, so
    equal calls give equal bits.

    With the extra `rays`, Intel's Embree casts the rays. Without it, VTK casts them, 10 to 50 times slower. Faces
    without area, or with a corner that is not finite, block nothing. Meshes of similar size are traced together.
    Geometry may be missed if it is nearer to a vertex than 2⁻¹⁸ of their common size.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface.
    scene : Scene, light, or sequence of lights, optional
        Lights, viewer and light model; by default `pvphong.default_scene`. The light model need not have shadows. If
        the light model's `ambient_occlusion` is a number, this is the distance up to which geometry occludes the sky.
    occluders : sequence, optional
        Other meshes that block light, each as a mesh or a pair of a mesh and a 4x4 matrix. The mesh itself always
        blocks light.
    samples : int, optional
        Number of rays per vertex to each light with a size, and to the sky, rounded up to a power of two; at most 4096.
    tolerance : float, default 1/255
        Largest standard error of the colour that a light gives to a white surface or, for the sky, that the scene's
        ambient light gives to this surface. If `samples` is not given, rays are cast until this error is reached. So
        the visibility of a dim light may have a larger error. 0 means the default.
    matrix : array_like, optional
        (4, 4) model matrix of the mesh.
    feature_angle : float, "auto" or None, default None
        Edges are split if the normals of their two faces differ by more than this angle, in degrees; see `shade`.

    Returns
    -------
    Visibility
        `.per_light` has the shape (lights, n), and `.sky` has (n,). `.standard_error` has the errors of both. `.rays`
        is the number of rays, and `.seconds` their time. With a two-sided light model, `.behind` is the visibility on
        the other side of the surface. `.save(path)` writes a file for `Visibility.load`.

    Raises
    ------
    ValueError
        If an argument is invalid, or the mesh has nothing that can be lit.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> seen = pv.Sphere().phong.visibility([ph.DirectionalLight(name="sun")])
    >>> seen.per_light.shape
    (1, 842)
    """
    source, _ = split_sharp_edges(surface(mesh), feature_angle)
    normals = functools.cache(lambda: point_normals(source))
    scene = scene_for(source, scene, matrix)
    rays: dict[str, Any] = {"occluders": occluders, "samples": samples, "tolerance": tolerance, "matrix": matrix}
    return visibility_of(source, normals, scene, **rays)


def normals(
    mesh: pv.DataSet,
    weighting: Weighting | None = None,
    *,
    matrix: MatrixLike | None = None,
    feature_angle: FeatureAngle = None,
    backend: Backend = "auto",
) -> FloatArray:
    """Return the point normals with which `shade` lights the surface.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface.
    weighting : {"angle", "area", "max"}, optional
        Compute normals from the faces with this weighting. By default, return the mesh's active point normals
        unchanged; if it has none, compute them with weighting by angle.
    matrix : array_like, optional
        (4, 4) model matrix: the normals are transformed by its inverse-transpose and normalized.
    feature_angle : float, "auto" or None, default None
        Edges are split if the normals of their two faces differ by more than this angle, in degrees; see `shade`. There
        is one normal per point of the surface with split edges.
    backend : {"auto", "numpy", "numba"}
        Backend that computes normals from the faces; see `pvphong.pipeline.vertex_normals`.

    Returns
    -------
    ndarray
        Shape (n_points, 3), for the surface's points.

    Raises
    ------
    ValueError
        If the mesh has neither normals nor faces, or the matrix or weighting is invalid.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> pv.Plane().phong.normals()[0]
    array([0., 0., 1.], dtype=float32)
    """
    source, _ = split_sharp_edges(surface(mesh), feature_angle)
    found = point_normals(source, weighting, backend=backend)
    return found if matrix is None else transform_normals(found, matrix)


def vertices_of(
    source: pv.PolyData, maps: Mapping[str, Any], tangents: Any, scene: Scene, setting: Setting
) -> Vertices:
    """Return a surface's vertices for a scene; normals, tangents and visibility are computed at their first use.

    `maps` and `tangents` come from `surface_and_maps`. `setting` has the options of the call.
    """
    normals = functools.cache(lambda: point_normals(source, backend=setting.backend))
    matrix, occluders, among = setting.matrix, setting.occluders, None
    if isinstance(setting.transport, TransportPart):
        among = setting.transport
    elif scene.light_model.bounces:
        (among,) = checked_transport(setting.transport, [Exchanging(source, normals, matrix)], occluders).parts
    if among is not None and among.blocking is not None:
        occluders = KnownOccluders(*among.blocking)  # shared, so that the ray tracer's tree is built only once
    seen: VisibilityLike | None = None
    if setting.visibility is not None:
        seen = checked_visibility("visibility", setting.visibility, source.points, matrix, scene)
    elif scene.light_model.needs_rays:
        how: Any = {"occluders": occluders, "tolerance": setting.tolerance, "matrix": matrix}
        seen = visibility_of(source, normals, scene, **how)
    tangents = tangents_from(source, normals) if tangents is None else tangents
    return Vertices(source.points, normals, maps, seen, tangents=tangents, transport=among)


def one_surface(blocks: pv.MultiBlock, feature_angle: FeatureAngle = None) -> pv.PolyData:
    """Join the surfaces of all blocks into one surface, whose only array is its normals for lighting.

    Points are not merged, so blocks that touch still have separate edges. In each block, edges are split if the normals
    of their faces differ by more than `feature_angle`, in degrees.

    Raises
    ------
    ValueError
        If there is no mesh, or a block cannot be lit; the message names the block.
    """
    # split before normals are stored, because with stored normals "auto" would split nothing
    split = map_blocks(blocks, lambda block: split_sharp_edges(surface(block), feature_angle)[0])
    parts: list[pv.PolyData] = leaves(split)
    if not parts:
        check.refuse(
            "mesh",
            f"a MultiBlock of {blocks.n_blocks} blocks, none with a mesh",
            "a MultiBlock that contains a mesh to light",
        )
    normals = np.concatenate([point_normals(part) for part in parts])
    bare = [part.copy(deep=False) for part in parts]
    for part in bare:
        part.clear_data()
    result: pv.PolyData = bare[0].append_polydata(*bare[1:]) if len(bare) > 1 else bare[0]
    result.point_data.active_normals = normals
    return result
