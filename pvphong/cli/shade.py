"""`pvphong shade`: a mesh with its colours, or a picture of it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from pvphong.base import check
from pvphong.base.types import Precision
from pvphong.cli.inputs import SIZE, seeing, surface_and_scene
from pvphong.cli.lighting import shaded
from pvphong.cli.options import (
    NONE,
    PLAIN,
    BlockerOptions,
    FeatureAngleOption,
    LookOptions,
    SceneFile,
    albedo_of,
    feature_angle_of,
)
from pvphong.cli.spinner import busy
from pvphong.meshes import pictures
from pvphong.meshes.files import BLOCK_FORMATS, MESH_FORMATS, refuse_suffix, save_lit

_OUTPUTS = (*dict.fromkeys(MESH_FORMATS + BLOCK_FORMATS), ".png")
_WITHOUT_ARRAYS = (".png", ".ply")


def shade(
    mesh: str,
    /,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    scene: SceneFile = None,
    look: LookOptions = PLAIN,
    albedo: str | None = None,
    array: str | None = None,
    components: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    precision: Precision = "float32",
    tolerance: float = 0.0,
    feature_angle: FeatureAngleOption = "auto",
    blockers: BlockerOptions = NONE,
    size: Annotated[tuple[int, int] | None, Parameter(negative="")] = None,
    background: str | None = None,
) -> None:
    """Light a mesh; write it with its colours, or write a picture of it.

    Without --scene it is lit by a key, a fill and a rim light and seen as PyVista would show it.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    output
        .vtp, .vtk, .vtkhdf or .ply (8-bit vertex colours) for a mesh; .vtm, .vtmb or .vtkhdf for several
        blocks; .png for a picture.
    albedo
        Colours that multiply the material's ambient and diffuse: the name of a point array, or an image file that is
        laid on by the mesh's texture coordinates.
    array
        Name of the array of lit colours, "phong" if not given.
    components
        Add the ambient, diffuse, specular, emission and per-light arrays.
    precision
        Of the arrays and the arithmetic.
    tolerance
        Largest absolute colour error that may be traded for time.
    feature_angle
        Degrees between two faces from which their common edge is sharp; "auto" takes 30 where the mesh has no point
        normals of its own, and "none" leaves all of it smooth.
    size
        Width and height of a picture in pixels, 1024 768 if not given.
    background
        Colour of a picture's background, white if not given.
    """
    refuse_suffix(output, "a mesh", _OUTPUTS)
    suffix = output.suffix.lower()
    draws = suffix == ".png"
    if not draws:
        _refuse_given({"--size": size, "--background": background}, "left out, for a mesh has none")
    if suffix in _WITHOUT_ARRAYS:
        _refuse_given({"--array": array, "--components": components}, f"left out, for a {suffix} holds no arrays")
    size, array = size or SIZE, "phong" if array is None else array
    pictures.refuse_size(size)
    how: dict[str, Any] = {
        "albedo": albedo_of(albedo),
        "components": components,
        "precision": precision,
        "tolerance": tolerance,
    }
    how["feature_angle"] = feature_angle_of(feature_angle)
    with busy(f"Lighting {mesh}"):
        outside, lighting = surface_and_scene(mesh, scene, size)
        lighting = blockers.to_scene(seeing(lighting, outside, size) if draws else lighting)
        how["occluders"] = blockers.to_meshes()
        lit = shaded(outside, lighting, look.to_materials(scene), name=array, **how)
        if draws:
            image = pictures.draw(lit, lighting.viewer, name=array, size=size, background=background or "white")
            pictures.save_picture(image, output)
        else:
            save_lit(lit, output, array)
    print(output)


def _refuse_given(options: dict[str, Any], allowed: str) -> None:
    for option, given in options.items():
        if given not in (None, False):
            check.refuse(option, given, allowed)
