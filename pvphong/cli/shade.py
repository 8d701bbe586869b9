"""`pvphong shade`: a mesh with its colours, or a picture of it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from pvphong.base.types import Precision
from pvphong.cli.inputs import SIZE, seeing, surface_and_scene
from pvphong.cli.lighting import shaded
from pvphong.cli.many import HERE, ManyFilesOptions, are_many
from pvphong.cli.options import (
    NONE,
    PLAIN,
    BlockerOptions,
    FeatureAngleOption,
    LookOptions,
    SceneFile,
    albedo_of,
    feature_angle_of,
    refuse_given,
)
from pvphong.cli.spinner import busy
from pvphong.meshes import pictures
from pvphong.meshes.files import BLOCK_FORMATS, MESH_FORMATS, refuse_suffix, save_lit

_OUTPUTS = (*dict.fromkeys(MESH_FORMATS + BLOCK_FORMATS), ".png")
_WITHOUT_ARRAYS = (".png", ".ply")


def shade(
    mesh: str,
    /,
    *more: str,
    output: Annotated[str, Parameter(name=["--output", "-o"])],
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
    many: ManyFilesOptions = HERE,
) -> int:
    """Light a mesh; write it with its colours, or write a picture of it. Or light many meshes into a folder.

    Without --scene it is lit by a key, a fill and a rim light and seen as PyVista would show it. Many files are lit by
    several processes, seen and lit as one scene; a file that is done already is not done again. If some cannot be lit,
    the exit status is 1 and they are listed.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    more
        For a folder: further ones, patterns such as "parts/*.vtp", or files that name others: .vtm, .pvtp, .pvtu, .pvd.
    output
        .vtp, .vtk, .vtkhdf or .ply (8-bit vertex colours) for a mesh; .vtm, .vtmb or .vtkhdf for several
        blocks; .png for a picture. A folder, as lit/, for many files, each as .vtp.
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
    how: dict[str, Any] = {
        "albedo": albedo_of(albedo),
        "components": components,
        "precision": precision,
        "tolerance": tolerance,
    }
    how["feature_angle"] = feature_angle_of(feature_angle)
    materials, name = look.to_materials(scene), "phong" if array is None else array
    if are_many((mesh, *more), output):
        refuse_given({"--size": size, "--background": background}, "left out, for a mesh has none")
        how |= {"material": materials, "name": name}
        return many.shade((mesh, *more), output, scene, blockers, how)
    many.refuse_any()
    target = Path(output)
    refuse_suffix(target, "a mesh", _OUTPUTS)
    suffix = target.suffix.lower()
    draws = suffix == ".png"
    if not draws:
        refuse_given({"--size": size, "--background": background}, "left out, for a mesh has none")
    if suffix in _WITHOUT_ARRAYS:
        refuse_given({"--array": array, "--components": components}, f"left out, for a {suffix} holds no arrays")
    size = size or SIZE
    pictures.refuse_size(size)
    with busy(f"Lighting {mesh}"):
        outside, lighting = surface_and_scene(mesh, scene, size)
        lighting = blockers.to_scene(seeing(lighting, outside, size) if draws else lighting)
        how["occluders"] = blockers.to_meshes()
        lit = shaded(outside, lighting, materials, name=name, **how)
        if draws:
            image = pictures.draw(lit, lighting.viewer, name=name, size=size, background=background or "white")
            pictures.save_picture(image, target)
        else:
            save_lit(lit, target, name)
    print(target)
    return 0
