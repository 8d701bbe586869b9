"""A window with lit meshes, for the command line."""

from __future__ import annotations

import os

import pyvista as pv

from pvphong import _check
from pvphong.material import Material
from pvphong.pictures import WITHOUT_DISPLAY, aim, drawing_window, leaves
from pvphong.scene import Scene

_INSTEAD = "A picture needs no window: pvphong shade MESH -o picture.png."


def show(mesh: pv.PolyData | pv.MultiBlock, scene: Scene, material: Material, *, title: str) -> None:
    """Open a window with a lit mesh, and come back when it is closed.

    Lights that ride along with the viewer, and highlights, follow the camera as it is moved.

    Parameters
    ----------
    mesh : pyvista.PolyData or pyvista.MultiBlock
        A surface, or several.
    scene : Scene
        Its viewer is where the camera stands at first.
    material : Material
        The surface's reflectances.
    title : str
        Of the window.

    Raises
    ------
    ValueError
        If there is no display to open it on.
    """
    if pv.OFF_SCREEN:
        _check.refuse("PYVISTA_OFF_SCREEN", "true", "unset where a window is to open", _INSTEAD)
    if drawing_window() in WITHOUT_DISPLAY:
        _check.refuse("DISPLAY", os.environ.get("DISPLAY", "none"), "a display to open a window on", _INSTEAD)
    plotter = pv.Plotter(title=title, lighting="none")
    aim(plotter, scene.viewer)
    plotter.phong.light_model = scene.light_model
    for light in scene.lights:
        plotter.phong.add_light(light)
    for part in leaves(mesh):
        plotter.phong.add_mesh(part, material)
    plotter.show()
