"""`pvphong validate`: the lit colours beside those of VTK's own shader."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import pyvista as pv
from cyclopts import Parameter

from pvphong.base import check
from pvphong.base.files import write_json
from pvphong.cli.inputs import SIZE, surface_and_scene
from pvphong.cli.lighting import with_materials
from pvphong.cli.options import PLAIN, LookOptions, SceneFile, Verbose
from pvphong.cli.spinner import busy
from pvphong.cli.telling import tell
from pvphong.meshes.files import BLOCK_FORMATS, MESH_FORMATS, refuse_suffix, save_lit
from pvphong.optics.material import Material


def validate(
    mesh: str | None = None,
    /,
    *,
    scene: SceneFile = None,
    look: LookOptions = PLAIN,
    json: Path | None = None,
    output: Path | None = None,
    every: Annotated[bool, Parameter(name="--all", negative="", show_default=False)] = False,
    report: Path | None = None,
    verbose: Verbose = False,
) -> int:
    """Compare the lit colours with those of VTK's own shader; the exit status is 1 if they are too far apart.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    json
        A file for the comparison as JSON; of several blocks, by their names.
    output
        .vtp, .vtk or .vtkhdf for the mesh with the signed errors; .vtm, .vtmb or .vtkhdf for several blocks.
    every
        In place of a mesh: a standing list of scenes, on meshes that come with PyVista.
    report
        .md for what came of --all, with pictures in a folder beside it.
    """
    if every:
        if mesh is not None or look != PLAIN or any(given is not None for given in (scene, json, output)):
            check.refuse("--all", "a mesh, a scene, a look, --json or --output beside it", "alone or with --report")
        return _validate_all(report, verbose)
    if report is not None:
        check.refuse("--report", str(report), "given together with --all")
    if mesh is None:
        check.refuse("MESH", "none", "given, or --all in its place")
    return _validate_mesh(mesh, scene, look.to_materials(scene), json, output, verbose)


def _validate_all(report: Path | None, verbose: bool) -> int:
    from pvphong.studies.validate.report import refuse_path, standing_report  # it loads VTK's rendering

    if report is not None:
        refuse_path(report)
    with busy("Drawing a list of scenes with VTK"):
        found = standing_report()
    tell([("", found)], verbose)
    if report is not None:
        found.save(report)
        print(report)
    return 0 if found.passed else 1


def _validate_mesh(
    mesh: str,
    scene: Path | None,
    materials: Mapping[str, Material],
    json: Path | None,
    output: Path | None,
    verbose: bool,
) -> int:
    outside, lighting = surface_and_scene(mesh, scene, SIZE)
    has_blocks = isinstance(outside, pv.MultiBlock)
    if output is not None:
        formats = BLOCK_FORMATS if has_blocks else tuple(suffix for suffix in MESH_FORMATS if suffix != ".ply")
        refuse_suffix(output, "signed errors", formats)
    with busy(f"Drawing {mesh} with VTK"):
        from pvphong.studies.validate.validation import validate as validate_mesh  # it loads VTK's rendering

        found = {
            block: validate_mesh(single, lighting, material)
            for block, single, material in with_materials(outside, materials)
        }
    tell(found.items(), verbose)
    if json is not None:
        told = {block: comparison.to_dict() for block, comparison in found.items()}
        write_json(told if has_blocks else told[""], json)
    if output is not None:
        meshes = {block: comparison.to_mesh() for block, comparison in found.items()}
        save_lit(pv.MultiBlock(meshes) if has_blocks else meshes[""], output, "")
    return 0 if found and all(comparison.passed for comparison in found.values()) else 1
