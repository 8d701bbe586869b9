"""Other implementations that light a mesh: a textbook's NumPy, Matplotlib's hillshading, VTK's per-pixel shading."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray, IntArray, MatrixLike, rgb
from pvphong.geometry.transform import transform_normals, transform_points
from pvphong.meshes.surfaces import shallow_copy
from pvphong.optics.lights import refuse_unless_in_vtk, vtk_values
from pvphong.optics.material import Material, without_maps
from pvphong.scene.scene import Scene
from pvphong.shading.equation import Equation
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import refuse_rays
from pvphong.studies.accuracy.result import NO_ERROR, Errors, Row
from pvphong.studies.accuracy.variants import Subject, Variant
from pvphong.studies.validate.images import window_lit_by_vtk, window_of_colors
from pvphong.vtk.oracle import driver
from pvphong.vtk.scenes import InexpressibleError, in_vtk_terms, refuse_inexpressible

TEXTBOOK, LIGHT_SOURCE = "textbook NumPy", "Matplotlib LightSource"
PER_PIXEL, LIT_ARRAY = "VTK per pixel", "VTK drawing lit array"

FRAME = (1024, 768)
"""Pixels of a frame that VTK draws."""

# By how much of a step a coordinate may be off its place in a regular grid: rounding to float32, generously.
_OFF_PLACE = 1e-3

_NO_GRID = "it lights height fields: one point at each place of a regular grid in x and y"

# --- a textbook's NumPy


def textbook(subject: Subject) -> Variant:
    """The textbook's colours, with their arithmetic error; raises ``ValueError`` for what it does not know."""
    s = subject

    def run() -> Float64Array:
        return textbook_colors(s.points, s.normals, s.scene, s.material, s.matrix)

    row = Row(
        TEXTBOOK, "arithmetic", "textbook", "float64", len(s.points),
        arithmetic=Errors.at_vertices(run(), s.truth), light_model=NO_ERROR,
        is_peer=True, note="normalises, mirrors and raises to powers as a textbook writes it",
    )  # fmt: skip
    return Variant(row, run)


def textbook_colors(
    points: FloatArray, normals: FloatArray, scene: Scene, material: Material, matrix: MatrixLike | None = None
) -> Float64Array:
    """The lighting model as a textbook writes it in NumPy.

    Whole (n, 3) float64 arrays, vectors divided by their norms, the mirror direction, `np.power`, `np.clip`. It is
    right for comfortable numbers and for nothing else: no zero normals, no huge or tiny vectors, no light on a
    vertex.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3).
    scene, material, matrix
        As for `evaluate`; the light model's convention is "standard".

    Returns
    -------
    ndarray
        Shape (n, 3), float64.

    Raises
    ------
    ValueError
        For a scene or a material that the formula does not know: another convention, lights with a size, rays,
        another reflectance.
    """
    model, viewer = scene.light_model, scene.viewer
    if model.convention != "standard":
        check.refuse("convention", model.convention, "'standard' for the textbook formula")
    for index, light in enumerate(scene.lights):
        refuse_unless_in_vtk(light, f"lights[{index}]", "one that the textbook knows")
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


# --- Matplotlib's `LightSource`: height fields by one distant light, without highlights


class HeightField(NamedTuple):
    """Heights over a regular grid, as Matplotlib takes them: rows from north to south, columns from west to east."""

    heights: Float64Array
    """(rows, columns): z."""

    vertices: IntArray
    """(rows, columns): the number of the vertex at each place."""

    spacing: tuple[float, float]
    """Steps in x and y, > 0."""


def light_source(subject: Subject) -> Variant:
    """Matplotlib's colours with their errors; raises ``ValueError`` for a mesh or scene that it cannot light."""
    s = subject
    field = height_field(s.points, s.normals, s.matrix)
    run = hillshading(field, s.equation)
    errors = Errors.at_vertices(run().reshape(-1, 3), s.truth[field.vertices.ravel()])
    row = Row(
        LIGHT_SOURCE, "light model", "Matplotlib", "float64", len(s.points), light_model=errors, is_peer=True,
        note="its own normals, from differences of heights; brightness stretched from the least to the greatest",
    )  # fmt: skip
    return Variant(row, run)


def height_field(points: FloatArray, normals: FloatArray, matrix: MatrixLike | None = None) -> HeightField:
    """Vertices as heights over a regular grid in x and y.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), in any order.
    matrix : array_like, optional
        (4, 4) model matrix; what it gives is the height field.

    Raises
    ------
    ValueError
        If they are none; the message says why.
    """

    def places(values: Float64Array) -> tuple[IntArray, float]:
        """The number of each value's place in an even row, and the step from place to place; refuses uneven ones."""
        low, high = float(values.min()), float(values.max())
        widest = float(np.diff(np.sort(values)).max(initial=0.0))
        steps = round((high - low) / widest) if widest else 0
        step = (high - low) / steps if steps else 1.0
        numbers: IntArray = np.rint((values - low) / step).astype(np.intp)
        if np.abs(values - (low + numbers * step)).max() > _OFF_PLACE * step:
            raise ValueError(_NO_GRID)
        return numbers, step

    placed = points.astype(np.float64) if matrix is None else transform_points(points, matrix)
    upright = normals if matrix is None else transform_normals(normals, matrix)
    if not np.isfinite(placed).all():
        raise ValueError("it lights height fields, and some points are not finite")
    (column, dx), (row, dy) = (places(placed[:, axis]) for axis in (0, 1))
    rows, columns = int(row.max()) + 1, int(column.max()) + 1
    number = (rows - 1 - row) * columns + column
    if min(rows, columns) < 2 or rows * columns != len(points) or not (np.bincount(number) == 1).all():
        raise ValueError(_NO_GRID)
    if not (upright[:, 2] > 0.0).all():
        raise ValueError("it lights height fields from above, and not all normals point up")
    vertices = np.argsort(number).reshape(rows, columns)
    return HeightField(placed[vertices, 2], vertices, (dx, dy))


def hillshading(field: HeightField, equation: Equation) -> Callable[[], Float64Array]:
    """A run that gives colours (rows, columns, 3) of a height field: the diffuse term by Matplotlib, the rest as it is.

    `LightSource.hillshade` makes normals of its own from differences of heights, takes n·l, and stretches it so
    that the least becomes 0 and the greatest 1; a plane keeps its n·l.

    Raises
    ------
    ValueError
        If Matplotlib is not installed, or cannot draw the scene.
    """
    light = equation.terms[0].light if len(equation.terms) == 1 else None
    if light is None or not light.is_even or light.has_size:
        raise ValueError("it knows one directional light, no more, no other")
    (term,) = equation.terms
    if equation.has(term, "specular"):
        raise ValueError("it knows no highlights")
    if equation.needs_visibility:
        raise ValueError("it casts no shadows")
    if equation.two_sided:
        raise ValueError("it lights one side of a surface")
    try:
        from matplotlib.colors import LightSource
    except ImportError as error:
        raise ValueError("Matplotlib is not installed: pip install matplotlib") from error

    east, north, up = light.arrival(np.zeros((3, 1))).direction[:, 0].tolist()  # towards the light
    azimuth = 90.0 - math.degrees(math.atan2(north, east))  # Matplotlib's is clockwise from north
    source = LightSource(azimuth, math.degrees(math.atan2(up, math.hypot(east, north))))
    diffuse = term.gain * np.array(term.colors[0])
    constant = np.array(equation.emission) + np.array(equation.ambient) + term.gain * np.array(term.ambient)
    dx, dy = field.spacing

    def run() -> Float64Array:
        colors: Float64Array = constant + diffuse * source.hillshade(field.heights, dx=dx, dy=dy)[:, :, None]
        return np.clip(colors, 0.0, 1.0) if equation.clamp else colors

    return run


# --- VTK's per-pixel shading, beside the lit array


def vtk_frames(
    mesh: pv.PolyData, subject: Subject, stack: ExitStack, lit_error: Errors | None = NO_ERROR
) -> list[Variant]:
    """A frame of the mesh with VTK's own per-pixel lighting, and one of the lit array with VTK's lighting off.

    Of a scene that VTK's shader cannot draw it draws the nearest that it can. Normals are the mesh's active ones, or
    those that pvphong computes.

    Parameters
    ----------
    mesh : pyvista.PolyData
        What is drawn.
    subject : Subject
        Its points, and what lights them.
    stack : ExitStack
        Closes the windows.
    lit_error : Errors, optional
        The interpolation error of the lit array; None leaves its frame out.

    Raises
    ------
    ValueError
        If VTK cannot draw here, or nothing like the scene.
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
        found.append(variant(LIT_ARRAY, windows[1].render_window, lit_error, "not evaluated anew"))
    return found
