"""`pvphong.shade_files`: light many files by many processes."""

from __future__ import annotations

import os
import uuid
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import repeat
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from pvphong.base import check
from pvphong.base.files import folder_aside
from pvphong.base.text import about, counting, html_table, wrapped
from pvphong.base.types import Backend, Precision
from pvphong.batch.cluster import Here, connected, ended
from pvphong.batch.culling import potential_occluders, touching
from pvphong.batch.pieces import Index, Piece, Seams, paths_of, pieces_and_indices, write_index
from pvphong.batch.seams import neighbours_of
from pvphong.batch.worker import Job, Result, border_in, bounds_of, checksum_of, light, look, outline_in, spans_of
from pvphong.meshes.blocks import DEFAULT
from pvphong.meshes.colormaps import joined, spanned, unspanned
from pvphong.meshes.default_scene import default_scene_of
from pvphong.meshes.files import Compression
from pvphong.meshes.surfaces import FeatureAngle
from pvphong.optics.material import DEFAULT_MATERIAL, Material, as_material
from pvphong.scene.options import known_options
from pvphong.scene.scene import Scene, SceneLike, as_scene

if TYPE_CHECKING:
    from distributed import Client

_APART = 'Each file was lit separately; seams="merge" treats them as pieces of one surface.'


@dataclass(frozen=True)
class Batch:
    """Results of `shade_files`. Each file is in one of `done`, `skipped` and `failed`.

    Attributes
    ----------
    done : tuple of Path
        Files that were lit, and index files that were written.
    skipped : tuple of Path
        Files whose lit file existed already, made from the same input and settings.
    failed : mapping of Path to str
        Files that could not be lit, with the reasons. Nothing was written for them.
    note : str
        Remark if normals of neighbouring pieces of a surface were not merged along their seams; else empty.

    Examples
    --------
    >>> import pvphong as ph
    >>> batch = ph.Batch(done=(), skipped=(), failed={})
    >>> batch.failed
    {}
    """

    done: tuple[Path, ...]
    skipped: tuple[Path, ...]
    failed: Mapping[Path, str]
    note: str = ""

    def __str__(self) -> str:
        counts = f"{len(self.done)} done, {len(self.skipped)} skipped, {len(self.failed)} failed."
        reasons = [line for path, why in self.failed.items() for line in wrapped(f"{path}: {why}")]
        return "\n".join([counts, *reasons, *wrapped(self.note)])

    def __repr__(self) -> str:
        return f"<Batch: {len(self.done)} done, {len(self.skipped)} skipped, {len(self.failed)} failed>"

    def _repr_html_(self) -> str:
        rows = [(str(path), why) for path, why in self.failed.items()]
        return html_table(repr(self)[1:-1], ("failed", "why") if rows else (), rows)


@known_options
def shade_files(
    paths: Any,
    out: str | os.PathLike[str],
    scene: SceneLike | None = None,
    material: Material | str | Mapping[str, Material | str] = DEFAULT_MATERIAL,
    *,
    client: Client | str | None = None,
    workers: int | None = None,
    seams: Seams | None = None,
    name: str = "phong",
    components: bool = False,
    tolerance: float = 0.0,
    precision: Precision = "float32",
    backend: Backend = "auto",
    feature_angle: FeatureAngle = None,
    compress: Compression = "lz4",
) -> Batch:
    """Light many files in many processes. For each, a .vtp file of the same name is written, with the lit colours.

    A lit file is written atomically. A receipt next to it, ``.NAME.vtp.json``, holds checksums of the input and of
    scene, material and options, and pvphong's version. A file with a matching receipt is skipped, so an interrupted
    call can be repeated. If a worker is killed, Dask gives its tasks to others.

    Index files (.vtm, .pvtp, .pvtu, and .pvd, which may name any of these) name other files, the pieces. The pieces are
    lit one by one, and a new index file names the lit files; for a .pvtu it is a .pvtp, because lit meshes are
    surfaces. Ghost cells are left out. A file without points, or with ghost cells only, gives an empty lit
    file.

    Parameters
    ----------
    paths : str, path, or sequence of them
        Files of any format that PyVista reads, index files, or patterns such as `parts/*.vtp`. A mesh file holds one
        mesh. Files inside `out` that match a pattern are skipped, as results of an earlier call.
    out : path
        Folder, created if missing. Workers on other machines must see it, and the input files, under the same paths.
    scene : Scene, light, or sequence of lights, optional
        As for `mesh.phong.shade`, common to all files. If there is no viewer, PyVista's default camera frames all files
        together; for its bounds, all files are read once more. Pieces of one surface shadow each other, so a worker
        also reads the pieces that may block the light of its own piece. These are all pieces if light comes from all
        sides, or with unlimited ambient occlusion. Separate meshes shadow only themselves. Bounces are refused for
        pieces of one surface.
    material : Material or mapping, optional
        Material, or a mapping from the names of a .vtm file's blocks to materials, with the key "default" for the other
        blocks. Maps are names of point arrays of the files, colormaps of such names, or paths of image files. A
        colormap without `clim` gets the range of its array in all files; to find it, all files are read once more.
    client : distributed.Client or str, optional
        Client of a Dask cluster, or the address of its scheduler, such as ``tcp://host:8786``. By default a local
        cluster is started; a script must then call this function below ``if __name__ == "__main__":``.
    workers : int, optional
        Number of processes of the local cluster, with one thread each; by default the number of processors.
    seams : {"merge", "keep"}, optional
        With "merge", points of several pieces with equal coordinates get the normal of the whole surface, if normals
        are computed from faces. With "keep", each piece has its own normals. By default "merge" for the pieces of one
        index file at one time step, and "keep" for separate files. Coordinates must be equal to the bit; if several
        points of a piece are equal, only the first is merged.
    name, components, tolerance, precision, backend, feature_angle
        As for `mesh.phong.shade`. Each piece has its own plan, within the tolerance. Sharp edges are also found across
        merged seams.
    compress : {"lz4", "zlib", "none"}, default "lz4"
        Compression of arrays in the lit files: zlib takes about half the space of LZ4, and ten times as long to write.

    Returns
    -------
    Batch
        `.done`, `.skipped`, and `.failed`: path → reason.

    Raises
    ------
    ValueError
        If an argument is invalid, for example if no file is named, two files have the same output, the folder is not
        writable, the scheduler does not answer, or workers have other versions of packages. Nothing is written then. An
        error in a single file is not raised, but recorded in `.failed`; the other files are lit.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> from distributed import Client
    >>> import pyvista as pv, pvphong as ph
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> pv.Sphere().save(folder / "ball.vtp")
    >>> with Client(processes=False, dashboard_address=None) as client:
    ...     batch = ph.shade_files(folder / "*.vtp", folder / "lit", client=client)
    >>> [path.name for path in batch.done]
    ['ball.vtp']
    """
    if seams is not None:
        check.choice("seams", seams, get_args(Seams))
    given = None if scene is None else as_scene(scene)
    check.choice("compress", compress, get_args(Compression))
    given_materials = material if isinstance(material, Mapping) else {DEFAULT: material}
    materials = {label: as_material(each) for label, each in given_materials.items()}
    options = {
        "name": name,
        "components": components,
        "tolerance": tolerance,
        "precision": precision,
        "backend": backend,
    }
    job = Job(given or Scene(), materials, feature_angle, options, uuid.uuid4().hex, compress)
    folder = Path(out)
    pieces, indices = pieces_and_indices(paths_of(paths, folder), folder, as_one=seams == "merge")
    job.refuse_wrong(pieces)
    several = [name for name, count in Counter(piece.surface for piece in pieces).items() if name and count > 1]
    if several and job.scene.light_model.bounces:  # for each bounce, light would travel between all pieces
        remedy = "Use LightModel(bounces=0), or join the pieces: pyvista.read(path)."
        got = f"bounces for the pieces of {several[0].rpartition('@')[0] or 'one surface'}"
        check.refuse("light_model", got, "without bounces for a surface in several pieces", remedy)
    outputs = [piece.output for piece in pieces] + [index.output for index in indices]
    folders = sorted({folder, *(output.parent for output in outputs)})
    with connected(client, workers, len(pieces)) as workforce, _folders(folders), about("files"):
        run = _Run(workforce, job, pieces, indices)
        if given is None or given.viewer is None:
            run.frame(given)
        run.span()
        run.light(merges=seams != "keep")
        run.write_indices()
    are_apart = sum(not piece.surface for piece in pieces) > 1
    return run.batch(note=_APART if are_apart and seams is None else "")


@contextmanager
def _folders(folders: Iterable[Path]) -> Iterator[None]:
    """Create the output folders. Before and after the block, remove from them the temporary files of killed workers."""

    def clear() -> None:
        for folder in folders:
            with folder_aside(folder):
                pass

    try:
        for folder in folders:
            folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        check.refuse("out", folder, "a folder that can be created", f"{error.strerror}.")
    clear()
    try:
        yield
    finally:
        clear()


class _Run:
    """State of one call of `shade_files`: its pieces and index files, and the result for each output path."""

    def __init__(self, client: Client | Here, job: Job, pieces: Sequence[Piece], indices: Sequence[Index]) -> None:
        self._client, self._job, self._pieces, self._indices = client, job, pieces, indices
        self._count = counting(len(pieces))
        self._results: dict[Path, Result] = {}

    def frame(self, given: Scene | None) -> None:
        """Give the job a scene with a viewer that frames all pieces.

        The scene is `given` with that viewer added. If `given` is None, it is the default scene.
        """
        low, high, is_open = np.full(3, np.nan), np.full(3, np.nan), False
        for _, (bounds, has_edges) in self._each(bounds_of, self._pieces):
            low, high = np.fmin(low, bounds[::2]), np.fmax(high, bounds[1::2])
            is_open = is_open or has_edges
        box = np.column_stack([low, high]).ravel()
        scene = default_scene_of(box, is_open=is_open) if given is None else given.framed(box)
        self._job = replace(self._job, scene=scene)

    def span(self) -> None:
        """Give a range to each colormap that has none.

        The range is from the least to the greatest number of the colormap's array in all pieces.
        """
        fields = [(label, name) for label, each in self._job.materials.items() for name in unspanned(each)]
        if not fields:
            return
        colormaps = [unspanned(self._job.materials[label])[name] for label, name in fields]
        of_pieces = [spans for _, spans in self._each(spans_of, self._left(self._pieces), colormaps)]
        materials = dict(self._job.materials)
        for (label, name), spans in zip(fields, zip(*of_pieces, strict=True), strict=False):
            materials[label] = spanned(materials[label], {name: joined(spans)})
        self._job = replace(self._job, materials=materials)

    def light(self, *, merges: bool) -> None:
        """Light all pieces that have no result yet.

        If `merges`, normals that are computed from faces take the faces of touching pieces into account. Else each
        piece has its own normals.
        """
        depend = merges or self._job.scene.light_model.needs_rays
        surfaces: dict[Any, list[Piece]] = defaultdict(list)
        for piece in self._pieces:
            surfaces[piece.surface if depend and piece.surface else piece].append(piece)
        tasks: dict[Any, Piece] = {}
        for pieces in surfaces.values():
            if len(pieces) > 1:
                tasks |= self._begin_together(pieces, merges=merges)
            else:
                tasks |= {self._begin(light, piece, self._job): piece for piece in self._left(pieces)}
        for piece, result in ended(self._client, tasks):
            self._end(piece, result)

    def _begin_together(self, pieces: Sequence[Piece], *, merges: bool) -> dict[Any, Piece]:
        """Start a task for each piece of a surface that lights the piece; return task → piece.

        A task receives the other pieces that may block light of its piece. If `merges`, it also receives the faces of
        other pieces that touch its piece.
        """
        looked = dict(self._each(look, self._left(pieces), self._job))
        made_from = checksum_of([looked[piece][0] if piece in looked else "" for piece in pieces])
        if not merges:
            made_from = checksum_of([made_from, "kept apart"])
        for piece, (_, receipt) in looked.items():
            if receipt is not None and receipt.input == made_from:
                self._end(piece, Result(arrays=receipt.arrays))
        if not self._left(pieces):
            return {}
        known = [piece for piece in pieces if piece in looked]
        if merges:  # the faces along borders stay on the workers
            borders = dict(self._each(border_in, known, fetches=False))
            where = attrgetter("outline")
            outlines = dict(
                self._values({self._client.submit(where, borders[each], pure=False): each for each in borders})
            )
        else:
            borders, outlines = {}, dict(self._each(outline_in, known))
        known = [piece for piece in known if piece in outlines]
        if not known:
            return {}
        missing = [number for number, piece in enumerate(pieces) if piece not in outlines]
        if missing:  # this changes the checksum, so a later run that can read these pieces lights all again
            made_from = checksum_of([made_from, missing])
        known_outlines = [outlines[piece] for piece in known]
        neighbours: Iterable[Any] = repeat(None, len(known))
        around: Iterable[Any] = repeat(None, len(known))
        if merges:
            faces = [borders[piece] for piece in known]
            neighbours = (
                self._client.submit(neighbours_of, faces[number], [faces[other] for other in others], pure=False)
                for number, others in enumerate(touching(known_outlines))
            )
        if self._job.scene.light_model.needs_rays:
            around = potential_occluders(self._job.scene, [*map(_found_anywhere, known)], known_outlines)
        return {
            self._begin(light, piece, self._job, beside, blocking, made_from): piece
            for piece, beside, blocking in zip(known, neighbours, around, strict=True)
            if piece.output not in self._results
        }

    def write_indices(self) -> None:
        """Write each index file whose pieces all have a lit file; record all other index files as failed."""
        for index in self._indices:
            named = [self._results[output] for output in index.outputs]
            failed = sum(bool(result.reason) for result in named)
            if failed:
                result = Result(reason=f"not written, because {failed} of its {len(named)} files failed")
            else:
                try:
                    result = Result(write_index(index, [result.arrays for result in named]))
                except ValueError as error:
                    result = Result(reason=str(error))
            self._results[index.output] = result

    def batch(self, note: str) -> Batch:
        """Return the results of all pieces and index files as a `Batch`. `note` is its remark on seams."""
        results = [(piece.input, self._results[piece.output]) for piece in self._pieces]
        results += [(index.input, self._results[index.output]) for index in self._indices]
        failed = {path: result.reason for path, result in results if result.reason}
        done = dict.fromkeys(path for path, result in results if result.is_new and path not in failed)
        skipped = dict.fromkeys(path for path, _ in results if path not in failed and path not in done)
        return Batch(tuple(done), tuple(skipped), failed, note)

    def _begin(self, work: Callable[..., Any], piece: Piece, *more: Any) -> Any:
        """Start the task `work(piece, *more)`, and return it.

        If an entry of `more` is itself a task, `work` gets the value of this task.
        """
        return self._client.submit(work, _found_anywhere(piece), *more, pure=False)

    def _each(
        self, work: Callable[..., Any], pieces: Iterable[Piece], *more: Any, fetches: bool = True
    ) -> Iterator[tuple[Piece, Any]]:
        """Run the task `work(piece, *more)` for each piece; yield pieces and values in the order in which tasks end.

        A piece whose task fails is recorded as failed and not yielded. If `fetches` is False, values stay on the
        workers, and the task is yielded in place of its value.
        """
        return self._values({self._begin(work, piece, *more): piece for piece in pieces}, fetches=fetches)

    def _values(self, tasks: Mapping[Any, Piece], *, fetches: bool = True) -> Iterator[tuple[Piece, Any]]:
        for piece, value in ended(self._client, tasks, fetches=fetches):
            if isinstance(value, Result):
                self._end(piece, value)
            else:
                yield piece, value

    def _left(self, pieces: Iterable[Piece]) -> list[Piece]:
        return [piece for piece in pieces if piece.output not in self._results]

    def _end(self, piece: Piece, result: Result) -> None:
        """Record the result of a piece, if the piece has no result yet."""
        if piece.output not in self._results:
            self._results[piece.output] = result
            self._count(1)


def _found_anywhere(piece: Piece) -> Piece:
    """Return a piece with absolute paths, so that worker processes in other folders find its files."""
    return replace(piece, input=piece.input.absolute(), output=piece.output.absolute())
