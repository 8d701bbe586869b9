"""Lit meshes: points, normals, albedo and visibility are read from PyVista data, colours written back as arrays."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonDataModel import vtkDataObject

from pvphong.base import check
from pvphong.base.types import Backend, FloatArray, MatrixLike, Weighting
from pvphong.meshes.blocks import leaves, map_blocks
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.point_data import surface_and_point_data, tangents_from
from pvphong.meshes.surfaces import FeatureAngle, shallow_copy, surface, vertex_normals
from pvphong.meshes.visibility import visibility_of
from pvphong.optics.material import Material
from pvphong.rays.visibility import Visibility
from pvphong.scene.scene import Scene, SceneLike, as_scene, light_labels
from pvphong.shading.equation import NO_MAPS
from pvphong.shading.plan.plan import Plan
from pvphong.shading.screen import Screen, checked_screen
from pvphong.shading.vertices import Vertices


def shade_mesh(
    mesh: pv.DataSet,
    scene: SceneLike | None,
    material: Material,
    *,
    name: str = "phong",
    matrix: MatrixLike | None = None,
    albedo: Any = None,
    tangents: Any = None,
    maps: Mapping[str, Any] = NO_MAPS,
    components: bool = False,
    tolerance: float = 0.0,
    feature_angle: FeatureAngle = None,
    backend: Backend = "auto",
    occluders: Any = (),
    visibility: Visibility | None = None,
    **how: Any,
) -> pv.PolyData:
    """A new mesh with lit colours as the point array `name`.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface; it is not modified. Other than PolyData it gives its extracted surface,
        arrays carried along.
    scene : Scene, light, sequence of lights, or None
        As for `evaluate`; None is the scene of `default_scene`.
    material : Material
        The surface's reflectances.
    name : str, default "phong"
        Name of the (n_points, 3) array, and first part of the names of all others.
    matrix : array_like, optional
        (4, 4) model matrix. It takes part in the lighting only: the mesh's points stay where they are.
    albedo : array_like, str or pyvista.Texture, optional
        (n_points, 3) array, or the name of a point array, or a texture, as `pvphong.meshes.point_data.texture_colors`
        takes it.
    tangents : array_like or str, optional
        As `albedo`: vectors along the surface. From the texture coordinates if not given.
    maps : mapping
        "specular", "shininess" or "roughness" → array, or the name of a point array, as for `evaluate`; or None.
    components : bool, default False
        Adds arrays `<name>_ambient`, `_diffuse`, `_specular`, `_emission`, `_base`, and one
        `<name>_light_<light's name or index>` for each light.
    tolerance : float, default 0
        As for `evaluate`.
    feature_angle : float, "auto" or None
        Degrees from which edges are sharp; see `pvphong.meshes.surfaces.split_sharp_edges`.
    backend : {"auto", "numpy", "numba"}
        Which evaluator computes, as for `evaluate`; and which form computes normals, as for `vertex_normals`.
    occluders : sequence
        Meshes, or pairs of a mesh and a matrix, that shadow this one as it does itself; see `mesh.phong.shade`.
    visibility : Visibility, optional
        What the vertices see, if that is known.
    **how
        `precision` of `evaluate`.

    Returns
    -------
    pyvista.PolyData
        With the lit array as its active scalars. It shares points, cells and all other arrays with the surface, as
        outputs of VTK's filters do: what is written into them later is seen in both, and its ``.copy()`` stands alone.

    Raises
    ------
    ValueError
        As `evaluate`, or if the mesh has nothing that can be lit.
    """
    if not isinstance(name, str) or not name:
        check.refuse("name", name, "a string that is not empty")
    # shared first, and then read: what another thread replaces meanwhile is not half seen
    now = shallow_copy(mesh) if isinstance(mesh, pv.PolyData) else mesh
    source, given = surface_and_point_data(now, {"albedo": albedo, "tangents": tangents, **maps}, feature_angle)
    scene = scene_for(source, scene, matrix)
    rays = {"occluders": occluders, "visibility": visibility, "tolerance": tolerance, "matrix": matrix}
    vertices = vertices_of(source, scene=scene, backend=backend, **given, **rays)
    planned = Plan.of(scene, material, vertices, matrix=matrix, tolerance=tolerance)
    shading = planned.run(vertices, components=components, backend=backend, **how)
    lit = source if source is now else shallow_copy(source)
    if shading.per_light is not None and vertices.screen is not None:
        equation = planned.equation  # of the lights that something may block, and of the sky if that counts
        seen = vertices.screen.channels(equation.shadowed, sky=equation.is_occluded)
        for index in equation.shadowed:
            lit.point_data[f"{name}_visibility_{light_labels(scene)[index]}"] = seen[index].copy()
        if equation.is_occluded:
            lit.point_data[f"{name}_sky"] = seen[-1].copy()
    if shading.per_light is not None:
        for part in ("ambient", "diffuse", "specular", "emission", "base"):
            lit.point_data[f"{name}_{part}"] = getattr(shading, part)
        for label, share in zip(light_labels(scene), shading.per_light, strict=True):
            lit.point_data[f"{name}_light_{label}"] = share
    lit.point_data[name] = shading.rgb
    lit.set_active_scalars(name, preference="point")
    return lit


def plan(
    mesh_or_points: Any,
    scene: SceneLike | None,
    material: Material,
    *,
    matrix: MatrixLike | None = None,
    tolerance: float = 0.0,
    feature_angle: FeatureAngle = None,
    occluders: Any = (),
    visibility: Visibility | None = None,
    maps: Mapping[str, Any] = NO_MAPS,
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
    material : Material
        The surface's reflectances.
    matrix : array_like, optional
        (4, 4) model matrix.
    tolerance : float, default 0
        Largest absolute colour error that may be taken; 1/255 is one step of a display.
    feature_angle : float, "auto" or None
        Of a mesh, as for `mesh.phong.shade`.
    occluders, visibility
        Of a mesh, as for `mesh.phong.shade`. No ray is cast: of bare points, what stands before them is not known.
    maps : mapping
        Of a mesh, as for `shade_mesh`.

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
        source, given = surface_and_point_data(mesh_or_points, maps, feature_angle)
        scene = scene_for(source, scene, matrix)
        rays: dict[str, Any] = {"occluders": occluders, "visibility": visibility, "matrix": matrix}
        vertices = vertices_of(source, scene=scene, **rays, **given)
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


def point_normals(mesh: pv.PolyData, weighting: Weighting | None = None, *, backend: Backend = "auto") -> FloatArray:
    """The normals that a surface is lit with.

    Its active point normals as they are, if it has any; else, or where a weighting is asked for, they are
    computed from its faces. Cell normals are not read: a vertex is lit, not a face.
    """
    if weighting is None:
        active: FloatArray | None = mesh.point_data.active_normals
        return vertex_normals(mesh, backend=backend) if active is None else np.asarray(active)
    return vertex_normals(mesh, weighting, backend=backend)


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
    """A surface's vertices for a scene; normals, tangents and rays are found when they are first asked for."""
    normals = functools.cache(lambda: point_normals(source, backend=backend))
    screen: Screen | None = None
    if visibility is not None:
        screen = checked_screen("visibility", visibility, source.points, matrix, scene)
    elif scene.light_model.needs_rays:
        screen = visibility_of(source, normals, scene, occluders=occluders, tolerance=tolerance, matrix=matrix)
    tangents = tangents_from(source, normals) if tangents is None else tangents
    return Vertices(source.points, normals, albedo, screen, tangents=tangents, maps=maps)


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
    bare = []
    for part in parts:
        one = part.copy(deep=False)
        one.clear_data()
        bare.append(one)
    result: pv.PolyData = bare[0].append_polydata(*bare[1:]) if len(bare) > 1 else bare[0]
    result.point_data.active_normals = np.concatenate([point_normals(part) for part in parts])
    return result
