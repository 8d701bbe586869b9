"""`pvphong view`: show a lit mesh in a window, with gizmos for its lights and keys that save the result."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pyvista as pv

from pvphong.base import check
from pvphong.base.display import Display, Tone
from pvphong.cli.options import (
    DEFAULT_LIGHTING,
    SIZE,
    LightingOptions,
    Number,
    seeing,
)
from pvphong.meshes.blocks import DEFAULT, common_or_named, datasets
from pvphong.meshes.pictures import WITHOUT_DISPLAY, aim, drawing_window, save_picture
from pvphong.meshes.saving import save
from pvphong.meshes.surfaces import FeatureAngle
from pvphong.optics.material import DEFAULT_MATERIAL, Material
from pvphong.scene.scene import Scene

BACKGROUND = "#2b2e34"
"""Default background colour, dark so that lights and gizmos stand out."""

_PLAIN = Display()

_INSTEAD = "A picture needs no window: pvphong shade MESH -o picture.png."


def view(
    mesh: str,
    /,
    *,
    lighting: LightingOptions = DEFAULT_LIGHTING,
    background: str = BACKGROUND,
    exposure: Number = 0.0,
    tone: Tone = "none",
) -> None:
    """Show a lit mesh in a window, with gizmos for its lights; press h for the list of keys.

    Parameters
    ----------
    mesh
        File of any format that PyVista reads.
    background
        Background colour of the window.
    exposure
        Brightness of the picture in stops: 1 doubles it.
    tone
        Curve for bright colours: none clips them, filmic compresses them.
    """
    outside, scene, material = lighting.read(mesh)
    show(
        outside,
        seeing(scene, outside, SIZE),
        material,
        title=f"pvphong: {mesh}",
        stem=Path(mesh).stem,
        background=background,
        feature_angle=lighting.feature_angle,
        occluders=lighting.occluders(),
        display=Display(exposure, tone),
    )


def show(
    mesh: pv.PolyData | pv.MultiBlock,
    scene: Scene,
    material: Material | Mapping[str, Material],
    *,
    title: str,
    stem: str = "pvphong",
    background: str = BACKGROUND,
    feature_angle: FeatureAngle = "auto",
    occluders: Sequence[Any] = (),
    display: Display = _PLAIN,
) -> None:
    """Open a window with a lit mesh and gizmos for its lights, and return when it is closed.

    Highlights, and lights that move with the viewer, follow the camera. The key h lists all keys. The keys d, x and 4
    write files into the current folder and show a message.

    Parameters
    ----------
    mesh : pyvista.PolyData or pyvista.MultiBlock
        One surface, or several blocks.
    scene : Scene
        The scene. Its viewer is the initial camera.
    material : Material or mapping
        Material of all blocks, or a mapping from block names, with "default" for the others.
    title : str
        Title of the window.
    stem : str
        Prefix of the names of saved files.
    background : str
        Colour name or hex string.
    feature_angle
        As for `shade`.
    occluders : sequence
        Additional meshes. They are shown, and cast shadows if the scene has shadows.
    display : Display
        Transform that shows the colours.

    Raises
    ------
    ValueError
        If there is no display, or an argument is invalid.
    """
    if pv.OFF_SCREEN:
        check.refuse("PYVISTA_OFF_SCREEN", "true", "unset to open a window", _INSTEAD)
    if drawing_window() in WITHOUT_DISPLAY:
        check.refuse("DISPLAY", os.environ.get("DISPLAY") or "none", "a display to open a window on", _INSTEAD)
    check.color("background", background)
    plotter = pv.Plotter(title=title, lighting="none")
    plotter.set_background(background)
    set_scene(plotter, scene)
    plotter.phong.display = display
    drawn = plotter.phong.add_mesh(mesh, material, feature_angle=feature_angle)
    for occluder in occluders:
        plotter.phong.add_mesh(occluder, DEFAULT_MATERIAL)
    has_blocks = isinstance(mesh, pv.MultiBlock)
    names = [name for name, _ in datasets(mesh)] if has_blocks else [DEFAULT]
    actors = dict(zip(names, drawn if has_blocks else [drawn], strict=True))

    def current() -> dict[str, Material]:
        """Return the materials as block → material, with the user's edits by keys."""
        return common_or_named({name: plotter.phong.mesh(actor).material for name, actor in actors.items()})

    def save_lit_mesh(path: Path) -> None:
        left = current()
        lit = mesh.phong.shade(
            plotter.phong.scene, left if has_blocks else left[DEFAULT], occluders=occluders, feature_angle=feature_angle
        )
        save(lit, path)

    plotter.reset_camera_clipping_range()  # PyVista does not reset it for a camera that has been set
    saved: dict[str, tuple[str, str, Callable[[Path], Any]]] = {
        "d": ("the rig", f"{stem}-rig.json", lambda path: plotter.phong.scene.save(path, materials=current())),
        "x": ("the lit mesh", f"{stem}-lit.{'vtm' if has_blocks else 'vtp'}", save_lit_mesh),
        "4": ("a picture", f"{stem}.png", lambda path: save_picture(plotter.screenshot(return_img=True), path)),
    }
    keys = {key: (f"save {what} as {path}", partial(_save, save, path)) for key, (what, path, save) in saved.items()}
    plotter.phong.add_gizmos(keys=keys)
    plotter.show()


def set_scene(plotter: pv.Plotter, scene: Scene) -> None:
    """Give a plotter the viewer, the light model and the lights of a scene."""
    aim(plotter, scene.viewer)
    plotter.phong.light_model = scene.light_model
    for light in scene.lights:
        plotter.phong.add_light(light)


def _save(save: Callable[[Path], Any], path: str) -> str:
    """Save a file when a key of the window is pressed; return the text that the window shows.

    `save` is a function that writes the file at `path`. An error is printed and not raised, because the window must
    stay open.
    """
    try:
        save(Path(path))
    except ValueError as error:
        print("error:", error, file=sys.stderr)
        return f"error: {error}"
    print(path)
    return f"saved {path}"
