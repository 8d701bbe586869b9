"""`pvphong validate`: the lit colours beside those of VTK's own shader."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import pyvista as pv
from cyclopts import Parameter
from rich.console import Console

from pvphong.base import check
from pvphong.cli.inputs import SIZE, surface_and_scene
from pvphong.cli.options import PLAIN, LookOptions, Rig
from pvphong.cli.spinner import busy
from pvphong.meshes.files import MESH_FORMATS, refuse_suffix, save_lit
from pvphong.optics.material import Material


def validate(
    mesh: str | None = None,
    /,
    *,
    scene: Rig = None,
    look: LookOptions = PLAIN,
    json: Path | None = None,
    output: Path | None = None,
    every: Annotated[bool, Parameter(name="--all", negative="", show_default=False)] = False,
    report: Path | None = None,
) -> int:
    """Compare the lit colours with those of VTK's own shader; the exit status is 1 if they are too far apart.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    json
        A file for the comparison as JSON.
    output
        .vtp, .vtk or .vtkhdf for the mesh with the signed errors.
    every
        In place of a mesh: a standing list of scenes, on meshes that come with PyVista.
    report
        .md for what came of --all, with pictures in a folder beside it.
    """
    if every:
        if mesh is not None or look != PLAIN or any(given is not None for given in (scene, json, output)):
            check.refuse("--all", "a mesh, a scene, a look, --json or --output beside it", "alone or with --report")
        return _validate_all(report)
    if report is not None:
        check.refuse("--report", str(report), "given together with --all")
    if mesh is None:
        check.refuse("MESH", "none", "given, or --all in its place")
    return _validate_mesh(mesh, scene, look.to_material(scene), json, output)


def _validate_all(report: Path | None) -> int:
    from pvphong.studies.validate.report import refuse_path, standing_report  # it loads VTK's rendering

    if report is not None:
        refuse_path(report)
    with busy("Drawing a list of scenes with VTK"):
        found = standing_report()
    Console().print(found.table())
    print(found.summary())
    if report is not None:
        found.save(report)
        print(report)
    return 0 if found.passed else 1


def _validate_mesh(mesh: str, scene: Path | None, material: Material, json: Path | None, output: Path | None) -> int:
    if output is not None:
        refuse_suffix(output, "signed errors", tuple(suffix for suffix in MESH_FORMATS if suffix != ".ply"))
    outside, rig = surface_and_scene(mesh, scene, SIZE)
    if isinstance(outside, pv.MultiBlock):
        check.refuse("mesh", f"{mesh}, several blocks", "a single mesh", "Validate each block by itself.")
    with busy(f"Drawing {mesh} with VTK"):
        from pvphong.studies.validate.validation import validate as validate_mesh  # it loads VTK's rendering

        comparison = validate_mesh(outside, rig, material)
    print(comparison)
    if json is not None:
        comparison.to_json(json)
    if output is not None:
        save_lit(comparison.to_mesh(), output, "")
    return 0 if comparison.passed else 1
