"""Commands that report on a mesh: `plan`, `validate`, `tradeoff`, `diagnose`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import pyvista as pv
from cyclopts import Parameter

from pvphong.base import check
from pvphong.base.files import write_json
from pvphong.base.processes import reading
from pvphong.cli.options import (
    DEFAULT_LIGHTING,
    Flag,
    LightingOptions,
    Number,
    Verbose,
    busy,
)
from pvphong.meshes.blocks import single_material
from pvphong.meshes.files import BLOCK_FORMATS, MESH_FORMATS, read_mesh, refuse_suffix, save_lit


def plan(
    mesh: str,
    /,
    *,
    lighting: LightingOptions = DEFAULT_LIGHTING,
    tolerance: Number = 0.0,
    verbose: Verbose = False,
) -> None:
    """Print the effects that are computed for a scene on a mesh, and those skipped; with --verbose, the reasons.

    Parameters
    ----------
    mesh
        File of any format that PyVista reads.
    tolerance
        Largest absolute colour error that is allowed in order to save time; 1/255 = 0.0039 is one step of a display.
    """
    outside, scene, material = lighting.read(mesh)
    _print_reports(outside.phong.plan(scene, material, tolerance=tolerance, **_options_of(lighting)), verbose)


def validate(
    mesh: str | None = None,
    /,
    *,
    lighting: LightingOptions = DEFAULT_LIGHTING,
    json: Path | None = None,
    output: Path | None = None,
    every: Annotated[bool, Parameter(name="--all", negative="", show_default=False)] = False,
    report: Path | None = None,
    verbose: Verbose = False,
) -> int:
    """Compare the lit colours with VTK's shader; the exit status is 1 if they differ too much.

    Parameters
    ----------
    mesh
        File of any format that PyVista reads.
    json
        JSON file for the comparison; for several blocks, one comparison per block.
    output
        File for the mesh with signed errors: .vtp, .vtk or .vtkhdf; .vtm, .vtmb or .vtkhdf for several blocks.
    every
        Compare a fixed list of scenes on PyVista's example meshes, instead of a given mesh.
    report
        Markdown file (.md) for the results of --all; its pictures are in a folder next to it.
    """
    if every:
        if mesh is not None or lighting != DEFAULT_LIGHTING or json is not None or output is not None:
            check.refuse("--all", "a mesh or other options with it", "used alone or with --report")
        return _validate_all(report, verbose)
    if report is not None:
        check.refuse("--report", str(report), "used together with --all")
    if mesh is None:
        check.refuse("MESH", "none", "given, or --all instead")
    outside, scene, material = lighting.read(mesh)
    has_blocks = isinstance(outside, pv.MultiBlock)
    if output is not None:
        formats = BLOCK_FORMATS if has_blocks else tuple(suffix for suffix in MESH_FORMATS if suffix != ".ply")
        refuse_suffix(output, "a mesh with signed errors", formats)
    with busy(f"Drawing {mesh} with VTK"):
        from pvphong.vtk.scenes import InexpressibleError  # loads VTK's rendering

        try:
            found = outside.phong.validate(scene, material, feature_angle=lighting.feature_angle)
        except InexpressibleError as error:
            raise ValueError(error.message) from error
    by_block = _print_reports(found, verbose)
    if json is not None:
        numbers = {block: comparison.to_dict() for block, comparison in by_block.items()}
        write_json(numbers if has_blocks else numbers[""], json)
    if output is not None:
        meshes = {block: comparison.to_mesh() for block, comparison in by_block.items()}
        save_lit(pv.MultiBlock(meshes) if has_blocks else meshes[""], output, "")
    return 0 if by_block and all(comparison.passed for comparison in by_block.values()) else 1


def _validate_all(report: Path | None, verbose: bool) -> int:
    from pvphong.studies.validate.report import refuse_path, vtk_report  # loads VTK's rendering

    if report is not None:
        refuse_path(report)
    with busy("Drawing a list of scenes with VTK"):
        found = vtk_report()
    _print_reports(found, verbose)
    if report is not None:
        found.save(report)
        print(report)
    return 0 if found.passed else 1


def tradeoff(
    mesh: str,
    /,
    *,
    lighting: LightingOptions = DEFAULT_LIGHTING,
    tolerance: Number = 1.0 / 255.0,
    seconds: float = 20.0,
    truth: Flag = False,
    plot: Path | None = None,
    csv: Path | None = None,
    json: Path | None = None,
    verbose: Verbose = False,
) -> None:
    """Measure accuracy against time on a mesh: evaluators, simpler light models, refined meshes, VTK.

    Parameters
    ----------
    mesh
        File of any format that PyVista reads. Several blocks are measured together, as one surface.
    tolerance
        Largest allowed absolute colour error; 1/255 = 0.0039 is one step of a display.
    seconds
        Time budget in seconds. Compilation of the kernel, once per installation, does not count.
    truth
        Also compare light models, from constant ambient light to all bounces, with path tracing. This takes the same
        time again.
    plot
        File for a figure: .png, .pdf or .svg.
    csv
        File for the rows as a table.
    json
        File for all numbers.
    """
    if plot is not None:
        from pvphong.studies.accuracy.physics import refuse_format

        refuse_format(plot, "--plot")
    for output in (plot, csv, json):
        if output is not None and not output.resolve().parent.is_dir():
            check.refuse("path", output, "in a folder that exists", f"Create {output.parent} first.")
    outside, scene, _ = lighting.read(mesh)
    material = single_material(lighting.materials())  # for all blocks
    options: dict[str, Any] = {"tolerance": tolerance, "seconds": seconds, "truth": truth}
    result = outside.phong.tradeoff(scene, material, **options, **_options_of(lighting))
    _print_reports(result, verbose)
    for path, save in ((plot, result.plot), (csv, result.to_csv), (json, result.to_json)):
        if path is not None:
            save(path)
            print(path)


def diagnose(mesh: str, /, *, json: Path | None = None, verbose: Verbose = False) -> int:
    """Find faults of a mesh that spoil its lighting; the exit status is 1 if there are any.

    Parameters
    ----------
    mesh
        File of any format that PyVista reads.
    json
        JSON file for the findings; for several blocks, the findings of each block.
    """
    with reading(mesh):
        found = read_mesh(mesh).phong.diagnose()
    diagnoses = _print_reports(found, verbose)
    if json is not None:
        numbers = {block: diagnosis.to_dict() for block, diagnosis in diagnoses.items()}
        write_json(numbers if isinstance(found, dict) else numbers[""], json)
    return 0 if diagnoses and all(diagnosis.ok for diagnosis in diagnoses.values()) else 1


def _options_of(lighting: LightingOptions) -> dict[str, Any]:
    return {"feature_angle": lighting.feature_angle, "occluders": lighting.occluders()}


def _print_reports(found: Any, verbose: bool) -> dict[str, Any]:
    """Print reports, and return them as block → report.

    `found` is a single report, whose block is then "", or a mapping from blocks to reports. If `verbose`, all details
    are printed, else a summary.
    """
    reports = found if isinstance(found, dict) else {"": found}
    for block, report in reports.items():
        if block:
            print(f"{block}:")
        print(report.explain().rstrip() if verbose else report)
    if not reports:
        print("nothing to light: no block of the file contains a mesh")
    elif not verbose and sys.stdout.isatty():
        print("(--verbose shows the whole report.)", file=sys.stderr)
    return reports
