"""What `mesh.phong` does with light, from top to bottom: colours, a plan, visibility and normals of a mesh's points.

A mesh gives a surface (`surfaces.py`), with what is given for each of its points (`point_data.py`), and a scene with a
viewer (`default_scene.py`); these give vertices, a plan is made for them, and `Plan.run` computes their colours.
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
from pvphong.shading.interreflection import Sent
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
    """A new mesh with its lit colours as a point array.

    The mesh's active point normals are used as they are; if it has none they are computed from its
    faces, weighted by angle. A dataset that is not a PolyData gives its extracted surface, with its
    arrays carried along.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface; it is not modified.
    scene : Scene, light, or sequence of lights, optional
        Lights, viewer and light model, in world coordinates; the scene of `pvphong.default_scene` if not given.
        Without a viewer, it is seen as PyVista's camera frames the mesh.
    material : Material or str, optional
        The surface's reflectances, numbers or maps, or the name of a material; OpenGL's default material if not given.
    name : str, default "phong"
        Name of the array, shape (n_points, 3), linear RGB in [0, 1]; it becomes the active scalars.
    matrix : array_like, optional
        (4, 4) model matrix, as on an actor. It takes part in the lighting; the points stay as they are.
    components : bool, default False
        Adds `<name>_ambient`, `<name>_diffuse`, `<name>_specular`, `<name>_emission`, which add up to
        the unclamped colour, `<name>_base` (emission and the light model's ambient) and one
        `<name>_light_<name or index>` per light, which together add up to it too. Where light bounces,
        `<name>_bounced` belongs to either sum.
    tolerance : float, default 0
        Largest absolute colour error that may be traded for time; 0 allows no approximation.
    precision : {"float32", "float64"}
        Of the arrays and the arithmetic. float32 errs by at most (4√n + 16) · 2⁻²⁴ · (1 + number of lights) for
        colours of size 1, n the largest of the shininess and the spot lights' exponents; see `pvphong.evaluate`.
        Light that bounces is gathered in float32 with either, which errs by some 3e-6.
    backend : {"auto", "numpy", "numba"}
        Which evaluator computes, see `pvphong.evaluate`; and normals, see `pvphong.pipeline.vertex_normals`.
    feature_angle : float, "auto" or None, default None
        Degrees between two faces from which their common edge is sharp: points are duplicated along it, and
        `pvphong_original_point` says which each one was. 0 is flat shading; "auto" takes 30 where the mesh has no
        point normals of its own. None splits nothing.
    occluders : sequence, optional
        Meshes, or pairs of a mesh and a 4x4 matrix, that shadow this one, where the scene's light model has shadows
        or ambient occlusion; it always shadows itself.
    visibility : Visibility, optional
        What `visibility` gave for this mesh and these lights, in place of new rays; or its numbers, as for
        `pvphong.evaluate`. With `components=True` the
        result has it as arrays, `<name>_visibility_<name or index>` and `<name>_sky`, where it was needed: that of the
        side that the viewer sees.
    transport : Transport, optional
        What `transport` gave for this mesh, where the light model has bounces, in place of new rays.
    shares_by_bounce : bool, default False
        With `components=True`, `<name>_bounce_1` and so on too, which add up to `<name>_bounced`; what is left of the
        ambient light is in the last.

    Returns
    -------
    pyvista.PolyData
        The surface with the arrays. It shares points, cells and all other arrays with this dataset, as outputs of
        VTK's filters do: what is written into them in place, on either side, is seen on both. Its ``.copy()``
        shares nothing.

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range, or the mesh has nothing that can be lit.

    Warns
    -----
    NormalsWarning
        Once for each state of a mesh, if most of its stored normals do not fit its faces, or if it is closed, has no
        stored normals, and its faces look inwards.

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
    """Options that all calls which light a mesh have in common; each field is as for `shade_mesh`."""

    matrix: MatrixLike | None = None
    feature_angle: FeatureAngle = None
    occluders: Any = ()
    visibility: Visibility | None = None
    transport: Transport | TransportPart | None = None
    tolerance: float = 0.0
    backend: Backend = "auto"


class Prepared(NamedTuple):
    """A mesh that is ready to be lit."""

    mesh: pv.DataSet
    """As it was given, or a copy that shares its arrays."""
    source: pv.PolyData
    """Its surface."""
    scene: Scene
    vertices: Vertices
    material: Material
    plan: Plan


class Ready(NamedTuple):
    """A mesh with everything that its plan needs; the fields are those of `Prepared`."""

    mesh: pv.DataSet
    source: pv.PolyData
    scene: Scene
    vertices: Vertices
    material: Material


def prepare(mesh: pv.DataSet, scene: SceneLike | None, material: Material | str, setting: Setting) -> Prepared:
    """Prepare a mesh to be lit: its surface, its vertices, a scene with a viewer, and a plan."""
    found = ready(mesh, scene, material, setting)
    how: dict[str, Any] = {"matrix": setting.matrix, "tolerance": setting.tolerance}
    return Prepared(*found, Plan.of(found.scene, found.material, found.vertices, **how))


def ready(mesh: pv.DataSet, scene: SceneLike | None, material: Material | str, setting: Setting) -> Ready:
    """Return what the plan of a mesh needs: its surface, its vertices, and a scene with a viewer."""
    # The copy shares the arrays. So arrays that another thread replaces meanwhile are not mixed with the old ones.
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
    """Raise ``ValueError`` for a name that lit colours cannot have, or that is one of what a surface is lit by."""
    if not isinstance(name, str) or not name:
        check.refuse("name", name, "a string that is not empty")
    data = source.GetPointData()
    for array, what in ((data.GetNormals(), "normals"), (data.GetTCoords(), "texture coordinates")):
        if array is not None and array.GetName() == name:
            allowed = "one that no array has by which the mesh is lit"
            check.refuse("name", f"{name!r}, the name of its {what}", allowed, 'The name "phong" is usual.')


def _lit_mesh(prepared: Prepared, shading: Shading, name: str, shares_by_bounce: bool) -> pv.PolyData:
    """A new mesh with its lit colours, and their parts where these are known."""
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
    """Return a new MultiBlock of lit meshes, with the same bits as `shade_mesh` of each block.

    Planning and starting to light a hundred points takes as long as ten thousand. So small blocks of the same material
    without maps form a group, which has one plan and is lit at once.

    Parameters
    ----------
    blocks : pyvista.MultiBlock
        They are not modified.
    scene : Scene
        Scene with a viewer and without bounces.
    own : iterator
        Material and fields of the `Setting` of each dataset that is not empty, in their order.
    name, components, shares_by_bounce, precision, backend
        As for `shade_mesh`.
    """
    groups: dict[Any, tuple[list[Ready], Iterator[pv.PolyData]]] = {}
    equations: dict[int, Equation] = {}

    def light(members: list[Ready], setting: Setting, backend: Backend) -> Iterator[pv.PolyData]:
        """Light a group at once, and yield its meshes in the order of its members."""
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
        """Return a key that is equal for all members of a group; None for a block that is lit alone."""
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
        """Return the iterator that yields the lit block. Blocks of a group share it, in their order."""
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
            # "auto" lights each of these blocks alone with NumPy, so it lights the group with NumPy too.
            groups[key] = members, light(members, setting, "numpy" if backend == "auto" else backend)
        members, results = groups[key]
        members.append(member)
        return results

    # All groups are complete before the first iterator starts.
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
    """New meshes that light each other by what they reflect, in their order; options are those of `shade_mesh`.

    Parameters
    ----------
    prepared : sequence of Prepared
        Whose vertices' transports are the parts of one.
    together : Transport
        That one.
    """
    of_each = [each.plan.sent(each.vertices, **how) for each in prepared]
    count = max((each.plan.equation.bounces for each in prepared), default=0)
    shares: FloatArray | None = None
    if count:
        shares = interreflection.bounced(Sent.of_all(of_each), together.gather, count, apart=bool(components))
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
    """Which effects will run for a scene, which are left out, and why.

    What adds nothing is left out exactly. Within `tolerance`, far lights are taken as directional, a far
    viewer as infinitely far, nearly even attenuation and spot falloff as constant, and lights and highlights
    too weak to be seen are left out; each by a bound that is computed before anything runs.

    Parameters
    ----------
    mesh_or_points : pyvista.DataSet or array_like
        A mesh, or points of shape (n, 3). Of a mesh the normals are known too, and may rule out highlights.
        `evaluate` may leave out more of bare points than the plan says; where that could cost more than the
        plan's own bound, `error_bound` is the whole tolerance.
    scene : Scene, light, sequence of lights, or None
        What lights it; without a viewer, seen as PyVista's camera frames it. Of a mesh, None is the scene of
        `default_scene`.
    material : Material or str, optional
        As for `mesh.phong.shade`; for points its maps are arrays.
    matrix : array_like, optional
        (4, 4) model matrix.
    tolerance : float, default 0
        Largest absolute colour error that may be taken; 1/255 is one step of a display.
    feature_angle
        Of a mesh, as for `mesh.phong.shade`.
    occluders, visibility, transport
        Of a mesh, as for `mesh.phong.shade`. No ray is cast: of bare points, what they see is not known, and these
        are refused, as `feature_angle` is.

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
        remedy = "blocks.phong.plan(...) plans each block by itself."
        check.refuse("mesh_or_points", f"a MultiBlock of {mesh_or_points.n_blocks}", allowed, remedy)
    if isinstance(mesh_or_points, vtkDataObject):
        remedy = "pyvista.wrap(...) makes a mesh of VTK's datasets."
        check.refuse("mesh_or_points", f"a {type(mesh_or_points).__name__}", allowed, remedy)
    points = check.array("mesh_or_points", mesh_or_points, allowed=allowed)
    of_mesh = {"feature_angle": feature_angle, "visibility": visibility, "transport": transport}
    if not isinstance(occluders, Sequence) or len(occluders):
        of_mesh["occluders"] = occluders
    for name, given in of_mesh.items():
        if given is not None:
            check.refuse(name, f"a {type(given).__name__}", "left out for bare points", "A mesh has faces for it.")
    vertices = Vertices(points, None, material.maps)
    scene = as_scene(scene, lambda: vertices.bounds(matrix))
    result = Plan.of(scene, material, vertices, matrix=matrix, tolerance=tolerance)
    is_open = bool(tolerance) and any(result.equation.has(term, "specular") for term in result.equation.terms)
    return replace(result, error_bound=tolerance) if is_open else result


def put_visibility(lit: pv.PolyData, name: str, labels: Sequence[str], equation: Equation, seen: FloatArray) -> None:
    """Give a mesh what its points see of the lights that something may block, and of the sky if that counts.

    Parameters
    ----------
    lit : pyvista.PolyData
        It gets the arrays `<name>_visibility_<label>` and `<name>_sky`.
    name : str
        Of its colours.
    labels : sequence of str
        Of all lights.
    equation : Equation
        Says which lights those are.
    seen : ndarray
        Shape (lights + 1, n).
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
    """What each vertex sees of each light, and of the sky: arrays to keep, which `shade` takes again.

    Rays are cast when an array is first read. A point, spot or directional light takes one ray for each vertex
    that faces it. A light with a size, and the sky, take 16 where these agree, and more where a shadow's edge is.
    Their nodes are chosen by the vertex's number alone, so that equal calls give equal bits.

    With the extra `rays`, Intel's Embree casts them; without, VTK does, which takes some ten to fifty times as
    long. Faces without an area, or with a corner that is not finite, block nothing. What is nearer to a vertex
    than 2⁻¹⁸ of the size of all meshes of its size together may be missed.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface.
    scene : Scene, light, or sequence of lights, optional
        As for `shade`. Its light model need not ask for shadows; its `ambient_occlusion` says up to which distance
        something hides the sky.
    occluders : sequence, optional
        Meshes, or pairs of a mesh and a 4x4 matrix, that block light like this mesh itself.
    samples : int, optional
        So many rays for every vertex to each light with a size, and into the sky: the next power of two, at most
        4096.
    tolerance : float, default 1/255
        Else, rays are cast until the standard error of the colour that the light, or the scene's ambient light,
        gives a white surface is at most that; 0 is the default. So what is dim is known less exactly.
    matrix : array_like, optional
        (4, 4) model matrix, as for `shade`.
    feature_angle : float, "auto" or None, default None
        As for `shade`.

    Returns
    -------
    Visibility
        `.per_light` (lights, n), `.sky` (n,), `.standard_error` of both, `.rays` and `.seconds`; `.behind`, the same of
        the vertices' other sides, where the light model is two-sided; `.save(path)`, for `Visibility.load`.

    Raises
    ------
    ValueError
        If an argument is not allowed, or the mesh has nothing that can be lit.

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
    """The point normals that `shade` lights the surface with.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface.
    weighting : {"angle", "area", "max"}, optional
        Computes them from the faces with this weighting. Without, the mesh's active point normals as
        they are, if it has any, else weighting by angle.
    matrix : array_like, optional
        (4, 4) model matrix: the normals are transformed by its inverse-transpose and made unit length.
    feature_angle : float, "auto" or None, default None
        As for `shade`; the normals are those of the points after edges are split.
    backend : {"auto", "numpy", "numba"}
        What computes them, where they are computed; see `pvphong.pipeline.vertex_normals`.

    Returns
    -------
    ndarray
        Shape (n_points, 3), of the surface's points.

    Raises
    ------
    ValueError
        If the mesh has neither normals nor faces, or the matrix or weighting is not allowed.

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
    """A surface's vertices for a scene; normals, tangents and rays are found when they are first used."""
    normals = functools.cache(lambda: point_normals(source, backend=setting.backend))
    matrix, occluders, among = setting.matrix, setting.occluders, None
    if isinstance(setting.transport, TransportPart):
        among = setting.transport
    elif scene.light_model.bounces:
        (among,) = checked_transport(setting.transport, [Exchanging(source, normals, matrix)], occluders).parts
    if among is not None and among.blocking is not None:
        occluders = KnownOccluders(*among.blocking)  # the same ones: what rays are tested with is built once
    seen: VisibilityLike | None = None
    if setting.visibility is not None:
        seen = checked_visibility("visibility", setting.visibility, source.points, matrix, scene)
    elif scene.light_model.needs_rays:
        how: Any = {"occluders": occluders, "tolerance": setting.tolerance, "matrix": matrix}
        seen = visibility_of(source, normals, scene, **how)
    tangents = tangents_from(source, normals) if tangents is None else tangents
    return Vertices(source.points, normals, maps, seen, tangents=tangents, transport=among)


def one_surface(blocks: pv.MultiBlock, feature_angle: FeatureAngle = None) -> pv.PolyData:
    """The surfaces of all blocks as one, each with the normals that it is lit with, and no other array.

    No points are merged: where blocks touch there are edges, as between the blocks. Sharp edges are split in each, as
    by `split_sharp_edges`.

    Raises
    ------
    ValueError
        If no block, or one of them, has nothing that can be lit; the message names it.
    """
    # before normals are put down, for "auto" splits nothing where there are some
    split = map_blocks(blocks, lambda block: split_sharp_edges(surface(block), feature_angle)[0])
    parts: list[pv.PolyData] = leaves(split)
    if not parts:
        check.refuse("mesh", f"a MultiBlock of {blocks.n_blocks} without a mesh", "one with a mesh that can be lit")
    normals = np.concatenate([point_normals(part) for part in parts])
    bare = [part.copy(deep=False) for part in parts]
    for part in bare:
        part.clear_data()
    result: pv.PolyData = bare[0].append_polydata(*bare[1:]) if len(bare) > 1 else bare[0]
    result.point_data.active_normals = normals
    return result
