"""VTK's own per-pixel shading, drawn and timed, as the peer of colours at vertices."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkLight

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray, MatrixLike
from pvphong.meshes.lit import point_normals
from pvphong.meshes.pictures import aim, drawing_window, preferring
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.vtk.lights import write_light
from pvphong.vtk.oracle import driver, write_material
from pvphong.vtk.scenes import InexpressibleError, in_vtk_terms, refuse_inexpressible

FRAME = (1024, 768)
"""Pixels of a frame that VTK draws."""


@dataclass(frozen=True, eq=False)
class Frames:
    """Two windows, ready to draw the same mesh again and again.

    Attributes
    ----------
    per_pixel : callable
        Draws a frame with VTK's own per-pixel lighting, and waits until it is there.
    lit_array : callable
        Draws a frame of a mesh that brings its colours, with VTK's lighting off.
    driver : str
        The graphics driver.
    changed : str
        What VTK draws in place of what it has no words for; empty where it draws the very scene.
    """

    per_pixel: Any
    lit_array: Any
    driver: str
    changed: str


@contextmanager
def vtk_frames(
    mesh: pv.PolyData, colors: FloatArray, scene: Scene, material: Material, matrix: MatrixLike | None = None
) -> Iterator[Frames]:
    """VTK's per-pixel shading of a scene in an offscreen window, beside the lit array in another.

    Of a scene that VTK's shader cannot draw it draws the nearest that it can.

    Parameters
    ----------
    mesh : pyvista.PolyData
        Drawn with its active point normals, or those that pvphong computes.
    colors : ndarray
        Shape (n_points, 3): what the second window draws.
    scene, material, matrix
        As for `evaluate`.

    Raises
    ------
    ValueError
        If VTK cannot draw here, or nothing like the scene.
    """
    placed = None if matrix is None else check.matrix4("matrix", matrix)
    scene, material, changed = _drawable(scene, material, placed)
    windows: list[pv.Plotter] = []
    try:
        with preferring(drawing_window()), pv.vtk_verbosity("off"):
            windows += [_per_pixel(mesh, scene, material, placed), _lit(mesh, colors, scene, placed)]
            first, second = (_drawing(window) for window in windows)
            first()
            second()
            name = driver()
        yield Frames(first, second, name, changed)
    finally:
        for window in windows:
            window.close()


def _drawable(scene: Scene, material: Material, matrix: Float64Array | None) -> tuple[Scene, Material, str]:
    """The scene and material, or the nearest that VTK can draw, and what was changed."""
    try:
        refuse_inexpressible(scene, material, matrix)
    except InexpressibleError as error:
        if error.scene is None or error.material is None:
            raise
        return error.scene, error.material, "without " + ", ".join(error.reasons)
    return scene, material, ""


def _per_pixel(mesh: pv.PolyData, scene: Scene, material: Material, matrix: Float64Array | None) -> pv.Plotter:
    low, high = np.reshape(mesh.bounds, (3, 2)).T
    terms = in_vtk_terms(scene, material, (low + high) / 2.0, float((high - low).max()))
    shown = mesh.copy()
    shown.clear_data()
    shown.point_data.active_normals = point_normals(mesh)
    plotter = pv.Plotter(off_screen=True, window_size=list(FRAME), lighting="none")
    for light in terms.lights:
        given = vtkLight()
        write_light(light, given, terms.viewer)
        plotter.renderer.AddLight(given)
    actor = plotter.add_mesh(shown, copy_mesh=False)
    actor.user_matrix = matrix if matrix is not None else np.eye(4)
    write_material(terms.material, actor.prop)
    aim(plotter, terms.viewer)
    return plotter


def _lit(mesh: pv.PolyData, colors: FloatArray, scene: Scene, matrix: Float64Array | None) -> pv.Plotter:
    shown = mesh.copy()
    shown.clear_data()
    shown.point_data["lit"] = colors
    plotter = pv.Plotter(off_screen=True, window_size=list(FRAME), lighting="none")
    actor = plotter.add_mesh(shown, scalars="lit", rgb=True, lighting=False, copy_mesh=False)
    actor.user_matrix = matrix if matrix is not None else np.eye(4)
    aim(plotter, scene.viewer)
    return plotter


def _drawing(plotter: pv.Plotter) -> Any:
    plotter.renderer.ResetCameraClippingRange()
    window = plotter.render_window

    def draw() -> None:
        window.Render()
        window.WaitForCompletion()

    return draw
