"""Other implementations for comparison: textbook NumPy, and VTK's per-pixel shading."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray, MatrixLike, rgb
from pvphong.geometry.transform import transform_normals, transform_points
from pvphong.meshes.surfaces import shallow_copy
from pvphong.optics.lights import refuse_unless_in_vtk, vtk_values
from pvphong.optics.material import Material, without_maps
from pvphong.scene.scene import Scene
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import refuse_rays
from pvphong.studies.accuracy.result import NO_ERROR, Errors, Row
from pvphong.studies.accuracy.variants import Subject, Variant
from pvphong.studies.validate.images import window_lit_by_vtk, window_of_colors
from pvphong.vtk.oracle import driver
from pvphong.vtk.scenes import InexpressibleError, in_vtk_terms, refuse_inexpressible

TEXTBOOK, PER_PIXEL, LIT_ARRAY = "textbook NumPy", "VTK per pixel", "VTK drawing lit array"

FRAME = (1024, 768)
"""Size of VTK's frames in pixels."""

# --- textbook NumPy


def textbook(subject: Subject) -> Variant:
    """Return a variant that lights the subject's vertices as in a textbook, with its arithmetic error.

    Raise ``ValueError`` if `textbook_colors` does not support the scene.
    """
    s = subject

    def run() -> Float64Array:
        return textbook_colors(s.points, s.normals, s.scene, s.material, s.matrix)

    row = Row(
        TEXTBOOK, "arithmetic", "textbook", "float64", len(s.points),
        arithmetic=Errors.at_vertices(run(), s.truth), light_model=NO_ERROR,
        is_peer=True, note="textbook formulas for normalisation, mirror direction and powers",
    )  # fmt: skip
    return Variant(row, run)


def textbook_colors(
    points: FloatArray, normals: FloatArray, scene: Scene, material: Material, matrix: MatrixLike | None = None
) -> Float64Array:
    """Evaluate the lighting model as in a textbook, in NumPy.

    The textbook uses whole (n, 3) float64 arrays, vectors divided by their norms, the mirror direction, `np.power` and
    `np.clip`. Its colours are only correct for well-scaled input: no zero normals, no huge or tiny vectors, no light at
    a vertex.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3).
    scene : Scene
        Lights, viewer and light model. The light model's convention must be "standard".
    material : Material
        Material without maps and without a `reflectance`.
    matrix : array_like, optional
        (4, 4) model matrix.

    Returns
    -------
    ndarray
        Shape (n, 3), float64.

    Raises
    ------
    ValueError
        If the scene has another convention, lights that VTK does not have, shadows, ambient occlusion or bounces, or if
        the material has maps or a `reflectance`.
    """
    model, viewer = scene.light_model, scene.viewer
    if model.convention != "standard":
        check.refuse("convention", model.convention, "'standard' for the textbook formula")
    for index, light in enumerate(scene.lights):
        refuse_unless_in_vtk(light, f"lights[{index}]", "a light that the textbook formula supports")
    refuse_rays(scene, "for the textbook formula")
    material = without_maps(material, "for the textbook formula")
    if material.reflectance is not None:
        check.refuse("reflectance", material.reflectance, "None for the textbook formula")

    def unit(vectors: Any) -> Any:
        return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)

    def dot(a: Any, b: Any) -> Any:
        return np.sum(a * b, axis=1, keepdims=True)

    p = points.astype(np.float64) if matrix is None else transform_points(points, matrix)
    n = unit(normals.astype(np.float64) if matrix is None else transform_normals(normals, matrix))
    is_local = model.local_viewer and not viewer.parallel
    v = unit(np.array(viewer.position) - p) if is_local else -np.array([viewer.view_direction])
    if model.two_sided:
        n = np.where(dot(n, v) < 0.0, -n, n)
    color = np.zeros_like(p) + np.multiply(rgb(material.ambient), rgb(model.ambient)) + rgb(material.emission)
    for light in scene.world_lights:
        if not light.on:
            continue
        given = vtk_values(light)
        if given.is_positional:
            to_light = np.array(given.position) - p
            distance = np.linalg.norm(to_light, axis=1, keepdims=True)
            l = to_light / distance  # noqa: E741
            constant, linear, quadratic = given.attenuation
            strength = 1.0 / (constant + linear * distance + quadratic * distance**2)
        else:
            l, strength = -unit(np.array([given.direction])), np.ones(1)  # noqa: E741
        if given.is_positional and given.cone_angle is not None:
            cosine = dot(-l, unit(np.array([given.direction])))
            inside = cosine >= np.cos(np.radians(given.cone_angle))
            strength = np.where(inside, strength * np.maximum(cosine, 0.0) ** given.exponent, 0.0)
        n_l = dot(n, l)
        highlight = dot(2.0 * n_l * n - l, v) if model.reflection == "phong" else dot(n, unit(l + v))
        highlight = np.where(n_l > 0.0, np.power(np.maximum(highlight, 0.0), material.shininess), 0.0)
        color += light.intensity * strength * (
            np.multiply(rgb(material.ambient), rgb(light.ambient))
            + np.multiply(rgb(material.diffuse), rgb(light.diffuse)) * np.maximum(n_l, 0.0)
            + np.multiply(rgb(material.specular), light.specular_color) * highlight
        )  # fmt: skip
    return np.clip(color, 0.0, 1.0) if model.clamp else color


# --- VTK's per-pixel shading, and the lit array


def vtk_frames(mesh: pv.PolyData, subject: Subject, stack: ExitStack, lit_error: Errors | None) -> list[Variant]:
    """Return two variants of drawing a frame. In the first, VTK lights each pixel, and pvphong computes nothing.

    In the second, VTK draws the lit array.
    If VTK's shader cannot draw the scene, the nearest scene that it can draw is used. VTK uses the mesh's active
    normals. If the mesh has none, VTK uses the normals that pvphong computes.

    Parameters
    ----------
    mesh : pyvista.PolyData
        Mesh to draw.
    subject : Subject
        The mesh's points, scene and material.
    stack : ExitStack
        Context stack that closes the windows at its end.
    lit_error : Errors or None
        Interpolation error of the lit array. If None, the frame of the lit array is left out.

    Raises
    ------
    ValueError
        If VTK cannot draw on this machine, or can draw neither the scene nor a similar one.
    """
    scene, matrix, changed = subject.scene, subject.matrix, ""
    material = without_maps(subject.material, "for VTK's picture")
    try:
        refuse_inexpressible(scene, material, matrix)
    except InexpressibleError as error:
        if error.scene is None or error.material is None:
            raise
        scene, material, changed = error.scene, error.material, "without " + ", ".join(error.reasons)

    low, high = np.reshape(Vertices(mesh.points, None).bounds(matrix), (3, 2)).T
    terms = in_vtk_terms(scene, material, (low + high) / 2.0, float((high - low).max()))
    windows = [window_lit_by_vtk(mesh, terms, FRAME, matrix)]
    stack.callback(windows[0].close)
    if lit_error is not None:
        colored = shallow_copy(mesh)
        colored.clear_data()
        colored.point_data["lit"] = subject.truth
        windows.append(window_of_colors(colored, subject.scene.viewer, FRAME, matrix, name="lit"))
        stack.callback(windows[1].close)
    for window in windows:
        window.render_window.Render()
    note = f"a frame of {FRAME[0]} × {FRAME[1]} pixels, {driver()}"

    def variant(name: str, window: Any, errors: Errors, more: str) -> Variant:
        def run() -> None:
            window.Render()
            window.WaitForCompletion()

        row = Row(
            name, "interpolation", "VTK", "float32", mesh.n_points,
            interpolation=errors, is_peer=True, note=f"{note}; {more}",
        )  # fmt: skip
        return Variant(row, run)

    given = f"drawn {changed}" if changed else "its error is 0 by definition"
    found = [variant(PER_PIXEL, windows[0].render_window, NO_ERROR, given)]
    if lit_error is not None:
        found.append(variant(LIT_ARRAY, windows[1].render_window, lit_error, "not evaluated again"))
    return found
