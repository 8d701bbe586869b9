"""`pvphong shade`: light a mesh and write a file or a picture, or light many meshes into a folder."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from pvphong.base import check
from pvphong.base.display import Display, Tone
from pvphong.base.types import Precision
from pvphong.batch.pieces import Seams, is_pattern
from pvphong.batch.shading import shade_files
from pvphong.cli.options import (
    DEFAULT_LIGHTING,
    SIZE,
    Flag,
    LightingOptions,
    Number,
    busy,
    refuse_given,
    seeing,
)
from pvphong.meshes import pictures
from pvphong.meshes.blocks import leaves
from pvphong.meshes.files import Compression, refuse_suffix
from pvphong.meshes.saving import SAVED_BLOCKS, SAVED_MESHES, save
from pvphong.scene.scene import Scene

_OUTPUTS = (*(suffix for suffix in dict.fromkeys(SAVED_MESHES + SAVED_BLOCKS) if suffix != ".png"), ".png")
_WITHOUT_ARRAYS = ".png", ".ply", ".obj", ".glb", ".gltf"
_COMPRESSED = (".vtp", ".vtm", ".vtmb")


def shade(
    mesh: str,
    /,
    *more: str,
    output: Annotated[str, Parameter(name=["--output", "-o"])],
    lighting: LightingOptions = DEFAULT_LIGHTING,
    array: str | None = None,
    components: Flag = False,
    precision: Precision = "float32",
    tolerance: Number = 0.0,
    refine: Number | None = None,
    max_points: int | None = None,
    compress: Compression | None = None,
    size: Annotated[tuple[int, int] | None, Parameter(negative="")] = None,
    background: str | None = None,
    exposure: Number | None = None,
    tone: Tone | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    seams: Seams | None = None,
) -> int:
    """Light a mesh and write it with its colours, or write a picture of it; or light many meshes into a folder.

    Without --scene, a key, a fill and a rim light are used, and PyVista's default view. Many files are lit by
    several processes, as one scene; files that are lit already are skipped. Files that cannot be lit are listed, and
    the exit status is then 1.

    Parameters
    ----------
    mesh
        File of any format that PyVista reads.
    more
        More files to light into a folder: mesh files, patterns such as "parts/*.vtp", or index files (.vtm, .pvtp,
        .pvtu, .pvd).
    output
        File to write: .vtp, .vtk, .vtkhdf, .ply (8-bit vertex colours) or .obj for a mesh; .vtm, .vtmb or .vtkhdf for
        several blocks; .glb or .gltf for either, which other programs show unlit; .png for a picture. For many meshes,
        a folder such as lit/, in which a .vtp is written for each.
    array
        Name of the array of lit colours. Default: "phong".
    components
        Add the ambient, diffuse, specular, emission and per-light arrays.
    precision
        Type of the arrays and the arithmetic.
    tolerance
        Largest absolute colour error allowed to save time.
    refine
        Largest colour error inside triangles; 1/255 is one step of a display. Triangles are split until it is reached,
        and cut along edges of hard shadows and cones.
    max_points
        Largest number of points of a mesh refined with --refine. Default: a million more than the mesh has.
    compress
        Compression of arrays in .vtp, .vtm and .vtmb files. Default: lz4. zlib takes half the space, but more time.
    size
        Width and height of a picture in pixels. Default: 1024 768.
    background
        Background colour of a picture. Default: white.
    exposure
        Brightness of a picture in stops: 1 doubles it. Default: 0.
    tone
        Curve for bright colours of a picture: none clips them, filmic compresses them. Default: none.
    workers
        Number of local processes that light many files. Default: the number of processors.
    scheduler
        Address of a Dask scheduler, such as tcp://host:8786, whose workers light many files.
    seams
        merge: points of several pieces with equal coordinates get one normal, from the faces of all these pieces.
        keep: each piece has its own normals. Default: merge for pieces of a .vtm, .pvtp, .pvtu or .pvd file.
    """
    options: dict[str, Any] = {
        "name": "phong" if array is None else array,
        "components": components,
        "precision": precision,
        "tolerance": tolerance,
        "feature_angle": lighting.feature_angle,
    }
    if refine is None:
        refuse_given({"--max-points": max_points}, "used with --refine")
    else:
        given = {"--components": components, "--tolerance": tolerance if tolerance else None}
        refuse_given(given, "omitted with --refine, because --refine computes only exact colours")
    target = Path(output)
    suffix = target.suffix.lower()
    are_many, names_folder = bool(more) or is_pattern(mesh), output.endswith(("/", os.sep)) or os.path.isdir(target)
    if are_many and not names_folder and suffix in _OUTPUTS:
        check.refuse("--output", target, "a folder for many meshes", f"-o {target}/ makes a folder of that name.")
    is_folder = are_many or names_folder
    if is_folder or suffix != ".png":
        of_picture = {"--size": size, "--background": background, "--exposure": exposure, "--tone": tone}
        refuse_given(of_picture, "used with a .png output only")
    if is_folder:
        refuse_given({"--refine": refine}, "omitted for many files; refine each file by its own command")
        if workers is not None and scheduler is not None:
            check.refuse("--workers", workers, "omitted with --scheduler, because the scheduler has workers")
        options |= {"compress": compress or "lz4", "client": scheduler, "workers": workers, "seams": seams}
        return _shade_many((mesh, *more), output, lighting, options)
    allowed = "omitted for a single mesh and an output file (it applies to many files and -o FOLDER/)"
    refuse_given({"--workers": workers, "--scheduler": scheduler, "--seams": seams}, allowed)
    refuse_suffix(target, "a mesh", _OUTPUTS)
    if suffix in _WITHOUT_ARRAYS:
        refuse_given({"--array": array, "--components": components}, f"omitted: a {suffix} file has no named arrays")
    if suffix not in _COMPRESSED:
        refuse_given({"--compress": compress}, f"used with {', '.join(_COMPRESSED)} only")
    size, display = size or SIZE, Display(exposure or 0.0, tone or "none")
    pictures.refuse_size(size)
    with busy(f"Lighting {mesh}"):
        outside, scene, material = lighting.read(mesh, size)
        if suffix == ".png":
            scene = seeing(scene, outside, size)
            if display != Display():  # a lower exposure shows what was too bright
                scene = replace(scene, light_model=replace(scene.light_model, clamp=False))
        if refine is None:
            lit = outside.phong.shade(scene, material, occluders=lighting.occluders(), **options)
        else:
            how = {name: options[name] for name in ("name", "precision", "feature_angle")}
            how |= {"tolerance": refine, "max_points": max_points, "occluders": lighting.occluders()}
            lit = outside.phong.refine(scene, material, **how)
        picture: dict[str, Any] = {}
        if suffix == ".png":
            picture = {"viewer": scene.viewer, "size": size, "background": background, "display": display}
        save(lit, target, name=options["name"], compress=compress, **picture)
    for block in leaves(lit) if refine is not None else ():
        print(block.field_data[options["name"] + "_refinement_summary"], file=sys.stderr)
    print(target)
    return 0


def _shade_many(meshes: Sequence[str], output: str, lighting: LightingOptions, options: dict[str, Any]) -> int:
    """Light many files into the folder `output`, print the results, and return the exit status.

    `options` are further arguments of `shade_files`.
    """
    refuse_given({"--occluder": lighting.occluder}, "omitted for many files")
    scene = None
    if lighting.scene is not None:
        scene = lighting.with_rays(lighting.with_sun(Scene.load(lighting.scene)))
    else:
        given: dict[str, Any] = {"--shadows": lighting.shadows, "--ambient-occlusion": lighting.ambient_occlusion}
        given |= {"--bounces": lighting.bounces or None, "--sun": lighting.sun}
        refuse_given(given, "used with --scene for many files")
    with busy("Lighting many files"):
        batch = shade_files(meshes, output, scene, lighting.materials(), **options)
    batch = replace(batch, note=batch.note.replace('seams="merge"', "--seams merge"))
    print(batch, file=sys.stderr if batch.failed else sys.stdout)
    return 1 if batch.failed else 0
