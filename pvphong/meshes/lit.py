"""What `mesh.phong` does with light, from top to bottom: colours, a plan, visibility and normals of a mesh's points.

A mesh gives a surface (`surfaces.py`), with what is given for each of its points (`point_data.py`), and a scene with a
viewer (`default_scene.py`); these give vertices, a plan is made for them, and `Plan.run` computes their colours.
"""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonDataModel import vtkDataObject

from pvphong.base import check
from pvphong.base.types import Backend, FloatArray, MatrixLike, Precision, Weighting
from pvphong.geometry.transform import transform_normals
from pvphong.meshes.blocks import leaves, map_blocks
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.point_data import surface_and_point_data, tangents_from
from pvphong.meshes.surfaces import FeatureAngle, shallow_copy, split_sharp_edges, surface, vertex_normals
from pvphong.meshes.visibility import visibility_of
from pvphong.optics.material import Material
from pvphong.rays.visibility import Visibility
from pvphong.scene.scene import Scene, SceneLike, as_scene, light_labels
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import VisibilityLike, checked_visibility

_PLAIN = Material()


def shade_mesh(
    mesh: pv.DataSet,
    scene: SceneLike | None = None,
    material: Material = _PLAIN,
    *,
    name: str = "phong",
    matrix: MatrixLike | None = None,
    albedo: Any = None,
    specular: Any = None,
    shininess: Any = None,
    roughness: Any = None,
    tangents: Any = None,
    components: bool = False,
    tolerance: float = 0.0,
    precision: Precision = "float32",
    backend: Backend = "auto",
    feature_angle: FeatureAngle = None,
    occluders: Any = (),
    visibility: Visibility | None = None,
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
    material : Material, optional
        The surface's reflectances; OpenGL's default material if not given.
    name : str, default "phong"
        Name of the array, shape (n_points, 3), linear RGB in [0, 1]; it becomes the active scalars.
    matrix : array_like, optional
        (4, 4) model matrix, as on an actor. It takes part in the lighting; the points stay as they are.
    albedo : array_like, str or pyvista.Texture, optional
        (n_points, 3) colours, or the name of a point array, that multiply the material's ambient and
        diffuse. uint8 counts as 0-255; floats are clipped to [0, 1], a NaN counts as 0. Of a texture, the colours
        at the mesh's texture coordinates: bilinear, with its `wrap`, and as linear light where it says that they
        are sRGB; see `pvphong.meshes.point_data.texture_colors`.
    specular, shininess, roughness : array_like or str, optional
        (n_points,) numbers, of specular (n_points, 3) colours too, or the name of a point array, in place of the
        material's or its reflectance's, which are the same at all points; see `pvphong.evaluate`.
    tangents : array_like or str, optional
        (n_points, 3) vectors along the surface, or the name of a point array, for reflectances that are not the
        same in all directions; from the mesh's texture coordinates, where u grows, if not given.
    components : bool, default False
        Adds `<name>_ambient`, `<name>_diffuse`, `<name>_specular`, `<name>_emission`, which add up to
        the unclamped colour, `<name>_base` (emission and the light model's ambient) and one
        `<name>_light_<name or index>` per light, which together add up to it too.
    tolerance : float, default 0
        Largest absolute colour error that may be traded for time; 0 allows no approximation.
    precision : {"float32", "float64"}
        Of the arrays and the arithmetic. float32 errs by at most (4√n + 16) · 2⁻²⁴ · (1 + number of lights) for
        colours of size 1, n the largest of the shininess and the spot lights' exponents; see `pvphong.evaluate`.
    backend : {"auto", "numpy", "numba"}
        Which evaluator computes, see `pvphong.evaluate`; and normals, see `pvphong.vertex_normals`.
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
        result has it as arrays, `<name>_visibility_<name or index>` and `<name>_sky`, where it was needed.

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

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight())
    >>> lit["phong"].shape
    (842, 3)
    """
    if not isinstance(name, str) or not name:
        check.refuse("name", name, "a string that is not empty")
    # shared first, and then read: what another thread replaces meanwhile is not half seen
    now = shallow_copy(mesh) if isinstance(mesh, pv.PolyData) else mesh
    given = {"albedo": albedo, "specular": specular, "shininess": shininess, "roughness": roughness}
    source, at_points = surface_and_point_data(now, given | {"tangents": tangents}, feature_angle)
    scene = scene_for(source, scene, matrix)
    rays = {"occluders": occluders, "visibility": visibility, "tolerance": tolerance, "matrix": matrix}
    vertices = vertices_of(source, scene=scene, backend=backend, **at_points, **rays)
    planned = Plan.of(scene, material, vertices, matrix=matrix, tolerance=tolerance)
    shading = planned.run(vertices, components=components, backend=backend, precision=precision)
    lit = source if source is now else shallow_copy(source)
    if shading.per_light is not None:
        labels = light_labels(scene)
        if vertices.visibility is not None:
            equation = planned.equation  # of the lights that something may block, and of the sky if that counts
            seen = vertices.visibility.channels(equation.shadowed, sky=equation.is_occluded)
            for index in equation.shadowed:
                lit.point_data[f"{name}_visibility_{labels[index]}"] = seen[index].copy()
            if equation.is_occluded:
                lit.point_data[f"{name}_sky"] = seen[-1].copy()
        for part in ("ambient", "diffuse", "specular", "emission", "base"):
            lit.point_data[f"{name}_{part}"] = getattr(shading, part)
        for label, share in zip(labels, shading.per_light, strict=True):
            lit.point_data[f"{name}_light_{label}"] = share
    lit.point_data[name] = shading.rgb
    lit.set_active_scalars(name, preference="point")
    return lit


def plan(
    mesh_or_points: Any,
    scene: SceneLike | None = None,
    material: Material = _PLAIN,
    *,
    matrix: MatrixLike | None = None,
    tolerance: float = 0.0,
    feature_angle: FeatureAngle = None,
    specular: Any = None,
    shininess: Any = None,
    roughness: Any = None,
    occluders: Any = (),
    visibility: Visibility | None = None,
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
    material : Material, optional
        The surface's reflectances; OpenGL's default material if not given.
    matrix : array_like, optional
        (4, 4) model matrix.
    tolerance : float, default 0
        Largest absolute colour error that may be taken; 1/255 is one step of a display.
    feature_angle, specular, shininess, roughness
        Of a mesh, as for `mesh.phong.shade`.
    occluders, visibility
        Of a mesh, as for `mesh.phong.shade`. No ray is cast: of bare points, what they see is not known.

    Returns
    -------
    Plan
        `.effects`, `.needs`, `.view_dependent`, `.error_bound`, `.explain()`.

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range; the message names it.
    """
    if isinstance(mesh_or_points, pv.DataSet):
        maps = {"specular": specular, "shininess": shininess, "roughness": roughness}
        source, at_points = surface_and_point_data(mesh_or_points, maps, feature_angle)
        scene = scene_for(source, scene, matrix)
        rays: dict[str, Any] = {"occluders": occluders, "visibility": visibility, "matrix": matrix}
        vertices = vertices_of(source, scene=scene, **rays, **at_points)
        return Plan.of(scene, material, vertices, matrix=matrix, tolerance=tolerance)
    allowed = "a mesh or an (n, 3) array of real numbers"
    if isinstance(mesh_or_points, pv.MultiBlock):
        remedy = "blocks.phong.plan(...) plans each block by itself."
        check.refuse("mesh_or_points", f"a MultiBlock of {mesh_or_points.n_blocks}", allowed, remedy)
    if isinstance(mesh_or_points, vtkDataObject):
        remedy = "pyvista.wrap(...) makes a mesh of VTK's datasets."
        check.refuse("mesh_or_points", f"a {type(mesh_or_points).__name__}", allowed, remedy)
    vertices = Vertices(check.array("mesh_or_points", mesh_or_points, allowed=allowed), None)
    scene = as_scene(scene, lambda: vertices.bounds(matrix))
    result = Plan.of(scene, material, vertices, matrix=matrix, tolerance=tolerance)
    is_open = bool(tolerance) and any(result.equation.has(term, "specular") for term in result.equation.terms)
    return replace(result, error_bound=tolerance) if is_open else result


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
        `.per_light` (lights, n), `.sky` (n,), `.standard_error` of both, `.rays` and `.seconds`.

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
    backend : {"auto", "numpy", "numba"}
        What computes them, where they are computed; see `pvphong.vertex_normals`.

    Returns
    -------
    ndarray
        Shape (n_points, 3), of the surface's points.

    Raises
    ------
    ValueError
        If the mesh has neither normals nor faces, or the matrix or weighting is not allowed.
    """
    found = point_normals(surface(mesh), weighting, backend=backend)
    return found if matrix is None else transform_normals(found, matrix)


def point_normals(mesh: pv.PolyData, weighting: Weighting | None = None, *, backend: Backend = "auto") -> FloatArray:
    """The normals that a surface is lit with.

    Its active point normals as they are, if it has any; else, or where a weighting is given, they are
    computed from its faces. Cell normals are not read: a vertex is lit, not a face.
    """
    active: FloatArray | None = mesh.point_data.active_normals
    if weighting is None and active is not None:
        return np.asarray(active)
    return vertex_normals(mesh, weighting or "angle", backend=backend)


def vertices_of(
    source: pv.PolyData,
    *,
    albedo: Any = None,
    tangents: Any = None,
    scene: Scene,
    occluders: Any = (),
    visibility: Visibility | None = None,
    matrix: MatrixLike | None = None,
    tolerance: float = 0.0,
    backend: Backend = "auto",
    **maps: Any,
) -> Vertices:
    """A surface's vertices for a scene; normals, tangents and rays are found when they are first used."""
    normals = functools.cache(lambda: point_normals(source, backend=backend))
    seen: VisibilityLike | None = None
    if visibility is not None:
        seen = checked_visibility("visibility", visibility, source.points, matrix, scene)
    elif scene.light_model.needs_rays:
        seen = visibility_of(source, normals, scene, occluders=occluders, tolerance=tolerance, matrix=matrix)
    tangents = tangents_from(source, normals) if tangents is None else tangents
    return Vertices(source.points, normals, albedo, seen, tangents=tangents, maps=maps)


def one_surface(blocks: pv.MultiBlock) -> pv.PolyData:
    """The surfaces of all blocks as one, each with the normals that it is lit with, and no other array.

    No points are merged: where blocks touch there are edges, as between the blocks.

    Raises
    ------
    ValueError
        If no block, or one of them, has nothing that can be lit; the message names it.
    """
    parts = [part for part in leaves(map_blocks(blocks, surface)) if isinstance(part, pv.PolyData)]
    if not parts:
        check.refuse("mesh", f"a MultiBlock of {blocks.n_blocks} without a mesh", "one with a mesh that can be lit")
    normals = np.concatenate([point_normals(part) for part in parts])
    bare = [part.copy(deep=False) for part in parts]
    for part in bare:
        part.clear_data()
    result: pv.PolyData = bare[0].append_polydata(*bare[1:]) if len(bare) > 1 else bare[0]
    result.point_data.active_normals = normals
    return result
