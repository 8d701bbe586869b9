"""`pvphong.shade_files`: many files lit by many processes."""

from __future__ import annotations

import os
import uuid
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from pvphong.base import check
from pvphong.base.files import folder_aside
from pvphong.base.text import about
from pvphong.base.types import Backend, Precision
from pvphong.batch.cluster import connected
from pvphong.batch.listing import Listing, Piece, Seams, listing, paths_of
from pvphong.batch.result import Batch
from pvphong.batch.run import Run
from pvphong.batch.tasks import Job
from pvphong.meshes.blocks import DEFAULT
from pvphong.meshes.surfaces import FeatureAngle
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene, SceneLike, as_scene

if TYPE_CHECKING:
    from distributed import Client

_DULL = Material()
_LEFT = 'Each file was lit by itself: seams="merge" takes them for pieces of one surface.'


def shade_files(
    paths: Any,
    out: str | os.PathLike[str],
    scene: SceneLike | None = None,
    material: Material | Mapping[str, Material] = _DULL,
    *,
    client: Client | str | None = None,
    workers: int | None = None,
    seams: Seams | None = None,
    name: str = "phong",
    albedo: str | None = None,
    components: bool = False,
    tolerance: float = 0.0,
    precision: Precision = "float32",
    backend: Backend = "auto",
    feature_angle: FeatureAngle = None,
) -> Batch:
    """Light many files in many processes; each comes out as a .vtp file of its name with its colours.

    A file is written whole or not at all. Beside it stands, in ``.NAME.vtp.json``, what it was made from: checksums of
    the input, of scene, material and options, and pvphong's version. While these are the same, and the file is as it
    was written, it is not made again: so a call that was interrupted is simply repeated. A worker that is killed loses
    nothing, for Dask gives its work to others.

    Files that name others are read as pieces, which are lit one by one, and written back with the names of the lit
    ones: .vtm, .pvtp, .pvtu (as .pvtp, for what is lit are surfaces) and .pvd, which may name any of these. Ghost
    cells are left out.

    Parameters
    ----------
    paths : str, path, or sequence of them
        Files of any format that PyVista reads, or patterns such as "parts/*.vtp"; each holds one mesh, or names others.
    out : path
        A folder; it is made if it is not there. Workers elsewhere must find it, and the files, under the same paths.
    scene : Scene, light, or sequence of lights, optional
        As for `mesh.phong.shade`, but one for all: without a viewer it is seen as PyVista's camera frames all files
        together, and so is the default scene, for which all files are read once more. Pieces of one surface cast no
        shadows on each other, so they are refused with shadows or ambient occlusion; whole meshes shadow themselves.
    material : Material or mapping, optional
        The surface's reflectances; or by the paths of names of a .vtm file's blocks, "default" for the others.
    client : distributed.Client or str, optional
        A Dask cluster, or the address of its scheduler, as "tcp://host:8786". A local cluster is started if not given;
        a script then needs ``if __name__ == "__main__":``, as with all of Python's processes.
    workers : int, optional
        How many processes the local cluster has, of one thread each; as many as there are processors if not given.
    seams : {"merge", "keep"}, optional
        Whether points of several pieces at one place get the normal of the surface in one piece, where normals are
        computed from faces. If not given: "merge" for what one index names, at one time, and "keep" for files beside
        each other. Points are the same whose coordinates are, to the bit; of a piece's own points at one place the
        first one counts.
    name, albedo, components, tolerance, precision, backend, feature_angle
        As for `mesh.phong.shade`; `albedo` is the name of a point array. Each piece is planned for by itself, within
        the tolerance. Sharp edges are found across pieces whose seams are merged.

    Returns
    -------
    Batch
        `.done`, `.skipped`, and `.failed`: path → reason.

    Raises
    ------
    ValueError
        If an argument is not allowed: no file, two with one output, a folder that cannot be written to, a scheduler
        that does not answer, workers with other versions. Nothing is written then. What is wrong with a file is no
        error: it is in `.failed`, and the others are lit.
    """
    if seams is not None:
        check.choice("seams", seams, get_args(Seams))
    given = None if scene is None else as_scene(scene)
    materials = material if isinstance(material, Mapping) else {DEFAULT: material}
    options = {
        "name": name,
        "albedo": albedo,
        "components": components,
        "tolerance": tolerance,
        "precision": precision,
        "backend": backend,
    }
    job = Job(given or Scene(), materials, feature_angle, options, uuid.uuid4().hex)
    found = listing(paths_of(paths), Path(out), as_one=seams == "merge")
    job.refuse_wrong({piece.label for piece in found.pieces})
    _refuse_shadows(job.scene, found.pieces)
    with connected(client, workers) as cluster, _folders(found, Path(out)), about("files"):
        run = Run(cluster, job, found, merges=seams != "keep")
        if given is None or given.viewer is None:
            run.frame(given)
        run.light()
        run.write_indices()
    apart = sum(not piece.surface for piece in found.pieces) > 1
    return run.batch(note=_LEFT if apart and seams is None else "")


def _refuse_shadows(scene: Scene, pieces: Sequence[Piece]) -> None:
    """Who lights a piece does not have the others."""
    several = [name for name, count in Counter(piece.surface for piece in pieces).items() if name and count > 1]
    if several and scene.light_model.needs_rays:
        remedy = "scene.light_model.without_rays() is the same without them; or join the pieces: pyvista.read(path)."
        got = f"one with them for the pieces of {several[0].rpartition('@')[0] or 'one surface'}"
        check.refuse("light_model", got, "without shadows and ambient occlusion where a surface is in pieces", remedy)


@contextmanager
def _folders(found: Listing, out: Path) -> Iterator[None]:
    """The folders that are written in; what killed workers have left there is cleared before and after."""
    folders = sorted({each.output.parent for each in found.each} | {out})
    try:
        for folder in folders:
            folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        check.refuse("out", folder, "a folder that can be made", f"{error.strerror}.")
    _clear(folders)
    try:
        yield
    finally:
        _clear(folders)


def _clear(folders: Iterable[Path]) -> None:
    for folder in folders:
        with folder_aside(folder):
            pass
