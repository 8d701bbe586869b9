"""`pvphong tradeoff`: what accuracy costs in time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyvista as pv

from pvphong.base import check
from pvphong.cli.inputs import SIZE, surface_and_scene
from pvphong.cli.options import NONE, PLAIN, BlockerOptions, LookOptions, SceneFile, Verbose
from pvphong.cli.telling import tell
from pvphong.meshes.lit import one_surface
from pvphong.studies.accuracy.measure import tradeoff as measure_tradeoff
from pvphong.studies.accuracy.figure import refuse_format


def tradeoff(
    mesh: str,
    /,
    *,
    scene: SceneFile = None,
    look: LookOptions = PLAIN,
    tolerance: float = 1.0 / 255.0,
    seconds: float = 20.0,
    blockers: BlockerOptions = NONE,
    plot: Path | None = None,
    csv: Path | None = None,
    json: Path | None = None,
    verbose: Verbose = False,
) -> None:
    """Measure what accuracy costs in time on a mesh: evaluators, simpler light models, refined meshes, VTK.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads; several blocks are measured together, as one surface.
    tolerance
        Largest absolute colour error that is to be allowed; 1/255 = 0.0039 is one step of a display.
    seconds
        What the measuring may take; compiling the kernel, once per installation, is not counted.
    plot
        A figure: .png, .pdf or .svg.
    csv
        The rows as a table.
    json
        All numbers.
    """
    if plot is not None:
        refuse_format(plot)
    for output in (plot, csv, json):
        if output is not None and not output.resolve().parent.is_dir():
            check.refuse("path", output, "in a folder that exists", f"Create {output.parent} first.")
    outside, lighting = surface_and_scene(mesh, scene, SIZE)
    whole = one_surface(outside) if isinstance(outside, pv.MultiBlock) else outside
    lighting, occluders = blockers.to_scene(lighting), blockers.to_meshes()
    how: Any = {"tolerance": tolerance, "seconds": seconds, "occluders": occluders}
    result = measure_tradeoff(whole, lighting, look.to_material(scene), **how)
    tell([("", result)], verbose)
    for path, save in ((plot, result.plot), (csv, result.to_csv), (json, result.to_json)):
        if path is not None:
            save(path)
            print(path)
