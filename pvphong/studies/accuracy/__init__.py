"""What accuracy costs in time, measured on one's own mesh and scene.

`variants` are ways to light a mesh at its vertices, `sampling` ways to cast rays from them, `inside` the meshes that
are refined; `textbook`, `hillshade` and `frames` are peers, which others wrote. `measurement` runs them in turns within
a time budget. `result` is what comes of it; `tables` and `figure` show it, and `report` is all of that for its reader.
"""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any

import pyvista as pv

from pvphong.base import check
from pvphong.base.types import MatrixLike
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.lit import point_normals
from pvphong.meshes.surfaces import surface
from pvphong.meshes.visibility import visibility_of
from pvphong.optics.material import Material, check_material
from pvphong.scene.scene import SceneLike
from pvphong.shading import kernel
from pvphong.studies.accuracy.measurement import Measurement
from pvphong.studies.accuracy.progress import progress
from pvphong.studies.accuracy.report import Tradeoff
from pvphong.studies.accuracy.subject import Subject
from pvphong.studies.accuracy.timing import Clock

__all__ = ["Tradeoff", "tradeoff"]

# The part of the time budget that is left over, so that it is kept.
_SPARE = 0.05


def tradeoff(
    mesh: pv.DataSet,
    scene: SceneLike | None,
    material: Material,
    *,
    tolerance: float = 1.0 / 255.0,
    seconds: float = 20.0,
    matrix: MatrixLike | None = None,
    occluders: Any = (),
) -> Tradeoff:
    """Measure what accuracy costs in time on a mesh and a scene of one's own.

    Variants from the float64 reference down to coarse light models are run in turns, so that a machine that drifts
    favours none, as often as the time budget allows. Their errors are of three kinds, which are measured apart:
    arithmetic (against the same equation in float64) and light model (between two equations in float64), both at the
    vertices, and interpolation (colours blended across triangles against per-pixel shading, in float64). Where the
    scene has shadows or ambient occlusion there is a fourth, sampling: colours by few rays for each vertex against
    colours by 4096, at vertices chosen at random. The other kinds then take what the vertices see as known, and
    interpolation is measured without shadows, for no rays are cast inside triangles.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface; it is not modified.
    scene : Scene, light, sequence of lights, or None
        What lights it; None is the scene of `pvphong.default_scene`.
    material : Material
        The surface's reflectances.
    tolerance : float, default 1/255
        The largest absolute colour error that is to be allowed, > 0; the default is one step of a display.
    seconds : float, default 20
        What it may take, > 0. On large meshes variants are left out to keep it, with the reason given; the reference,
        the plan and the variant that it is compared with are always measured. Compiling the kernel, once per
        installation, is not counted.
    matrix : array_like, optional
        (4, 4) model matrix.
    occluders : sequence
        Meshes, or pairs of a mesh and a matrix, that shadow this one as it does itself; see `mesh.phong.shade`.

    Returns
    -------
    Tradeoff
        `.rows`, `.best(tolerance)`, `.ledger`, `.promises`, `.table()`, `.plot(path)`, `.to_csv(path)`,
        `.to_json(path)`; print it for what to choose, and `.explain()` for all of it.

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range, or the mesh has nothing that can be lit.
    """
    check_material(material)
    tolerance = check.number("tolerance", tolerance, above=0.0)
    clock = Clock((1.0 - _SPARE) * check.number("seconds", seconds, above=0.0))
    source = surface(mesh)
    scene = scene_for(source, scene, matrix)
    placed = None if matrix is None else check.matrix4("matrix", matrix)
    points, normals = check.array("points", source.points), check.array("normals", point_normals(source))
    screen = None
    if scene.light_model.needs_rays:
        rays: Any = {"occluders": occluders, "tolerance": tolerance, "matrix": placed}
        screen = visibility_of(source, lambda: normals, scene, **rays)
    subject = Subject(points, normals, scene, material, placed, screen)
    with progress(clock, "measuring"), ExitStack() as stack:
        clock.say("loading the evaluator")
        clock.seconds += kernel.seconds_compiling(lambda: subject.backend)
        return Measurement(source, subject, tolerance, clock, stack).run()
