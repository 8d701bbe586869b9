"""A window with lit meshes and gizmos for their lights, for the command line."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyvista as pv

from pvphong.base import check
from pvphong.cli.lighting import shaded
from pvphong.meshes.blocks import DEFAULT, datasets, single_material
from pvphong.meshes.files import save_lit
from pvphong.meshes.pictures import WITHOUT_DISPLAY, aim, drawing_window, save_picture
from pvphong.meshes.surfaces import FeatureAngle
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.studio.lit_actors import ARRAY

_INSTEAD = "A picture needs no window: pvphong shade MESH -o picture.png."


BACKGROUND = "#2b2e34"
"""Dark, so that lights and their gizmos are what is bright."""


def show(
    mesh: pv.PolyData | pv.MultiBlock,
    scene: Scene,
    materials: Mapping[str, Material],
    *,
    title: str,
    stem: str = "pvphong",
    background: str = BACKGROUND,
    albedo: Any = None,
    feature_angle: FeatureAngle = "auto",
    occluders: Sequence[Any] = (),
) -> None:
    """Open a window with a lit mesh and gizmos for its lights, and come back when it is closed.

    Lights that ride along with the viewer, and highlights, follow the camera as it is moved. The key h lists
    the keys; d, x and 4 write files into the current folder and say so.

    Parameters
    ----------
    mesh : pyvista.PolyData or pyvista.MultiBlock
        A surface, or several.
    scene : Scene
        Its viewer is where the camera stands at first.
    materials : mapping
        Material of each block, or of "default".
    title : str
        Of the window.
    stem : str
        What the names of saved files begin with.
    background : str
        A colour name or hex string.
    albedo : str, texture or None
        As for `shade`.
    feature_angle : float, "auto" or None, default "auto"
        Degrees from which edges are sharp, as for `shade`.
    occluders : sequence
        Meshes that are shown too, and shadow the others where the scene has shadows.

    Raises
    ------
    ValueError
        If there is no display to open it on, or an argument is not allowed.
    """
    if pv.OFF_SCREEN:
        check.refuse("PYVISTA_OFF_SCREEN", "true", "unset where a window is to open", _INSTEAD)
    if drawing_window() in WITHOUT_DISPLAY:
        check.refuse("DISPLAY", os.environ.get("DISPLAY") or "none", "a display to open a window on", _INSTEAD)
    check.color("background", background)
    plotter = pv.Plotter(title=title, lighting="none")
    plotter.set_background(background)
    aim(plotter, scene.viewer)
    plotter.phong.light_model = scene.light_model
    for light in scene.lights:
        plotter.phong.add_light(light)
    several = isinstance(mesh, pv.MultiBlock)
    how = {"albedo": albedo, "feature_angle": feature_angle}
    drawn = plotter.phong.add_mesh(mesh, materials if several else single_material(materials), **how)
    for occluder in occluders:
        plotter.phong.add_mesh(occluder)
    names = [name for name, _ in datasets(mesh)] if several else [DEFAULT]
    actors = dict(zip(names, drawn if several else [drawn], strict=True))

    def shown() -> dict[str, Material]:
        found = {name: plotter.phong.mesh(actor).material for name, actor in actors.items()}
        first = next(iter(found.values()))
        return {DEFAULT: first} if all(material == first for material in found.values()) else found

    plotter.reset_camera_clipping_range()  # PyVista leaves it alone once the camera has been placed
    plotter.phong.add_gizmos(keys=_keys(plotter, mesh, shown, how | {"occluders": occluders}, stem))
    plotter.show()


def _keys(
    plotter: pv.Plotter,
    mesh: pv.PolyData | pv.MultiBlock,
    materials: Callable[[], dict[str, Material]],
    how: Mapping[str, Any],
    stem: str,
) -> dict[str, tuple[str, Callable[[], str]]]:
    """Keys that save what the window shows: key → (what it does, how)."""
    several = isinstance(mesh, pv.MultiBlock)
    rig, lit, picture = Path(f"{stem}-rig.json"), Path(f"{stem}-lit.{'vtm' if several else 'vtp'}"), Path(f"{stem}.png")

    def save_lit_mesh() -> None:
        save_lit(shaded(mesh, plotter.phong.scene, materials(), **how), lit, ARRAY)

    def save_rig() -> None:
        plotter.phong.scene.save(rig, materials=materials())

    def save_screenshot() -> None:
        save_picture(plotter.screenshot(return_img=True), picture)

    return {
        "d": (f"save the rig as {rig}", _told(save_rig, rig)),
        "x": (f"save the lit mesh as {lit}", _told(save_lit_mesh, lit)),
        "4": (f"save a picture as {picture}", _told(save_screenshot, picture)),
    }


def _told(save: Callable[[], None], path: Path) -> Callable[[], str]:
    """The saving function, which says where the file is, or why there is none: a window must outlive an error."""

    def press() -> str:
        try:
            save()
        except ValueError as error:
            print("error:", error, file=sys.stderr)
            return f"error: {error}"
        print(path)
        return f"saved {path}"

    return press
