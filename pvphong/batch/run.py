"""A call that makes a file from each of many files: it orders the tasks, and collects their results."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import repeat
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pvphong.base import check
from pvphong.base.files import folder_aside
from pvphong.base.text import counting, html_table, wrapped
from pvphong.batch.cluster import Here, ended
from pvphong.batch.culling import Outline, touching
from pvphong.batch.pieces import Index, Piece, write_index
from pvphong.batch.seams import neighbours_of
from pvphong.batch.worker import Job, Result, border_in, checksum_of, light, look, outline_in

if TYPE_CHECKING:
    from distributed import Client


@dataclass(frozen=True)
class Batch:
    """Results of `shade_files` or `daylight_files`. Each file is in one of `done`, `skipped` and `failed`.

    Attributes
    ----------
    done : tuple of Path
        Files that were lit, and index files that were written.
    skipped : tuple of Path
        Files whose lit file existed already, made from the same input and settings.
    failed : mapping of Path to str
        Files that could not be lit, with the reasons. Nothing was written for them.
    note : str
        Remark on pieces of a surface whose normals were not merged at the seams between them; may be empty.

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


@contextmanager
def output_folders(out: Path, pieces: Sequence[Piece], indices: Sequence[Index]) -> Iterator[None]:
    """Create the folder `out` and those of all outputs. Before and after the block, remove the temporary files of
    killed workers there.
    """
    folders = sorted({out, *(each.output.parent for each in pieces), *(each.output.parent for each in indices)})

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


class Run(ABC):
    """State of one call: its pieces and index files, and the result for each output path."""

    def __init__(self, client: Client | Here, job: Job, pieces: Sequence[Piece], indices: Sequence[Index]) -> None:
        self._client, self._job, self._pieces, self._indices = client, job, pieces, indices
        self._count = counting(len(pieces))
        self._results: dict[Path, Result] = {}

    @abstractmethod
    def _around(self, pieces: Sequence[Piece], outlines: Sequence[Outline]) -> Iterable[Any]:
        """Return, for each piece of a surface in order, what the task `light` gets to know of the others' triangles."""

    def light(self, *, merges: bool) -> None:
        """Light all pieces that have no result yet.

        With `merges`, normals that are computed from faces are those of the whole surface, also where its pieces touch.
        Without it, each piece has its own normals.
        """
        depend = merges or self._job.needs_rays
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
        """Start one task per piece of a surface, to light the piece; return task → piece.

        A task receives the other pieces that may block its piece's light. With `merges`, it also receives the other
        pieces' faces that touch its piece.
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
        known_outlines = [outlines[piece] for piece in known]
        neighbours: Iterable[Any] = repeat(None, len(known))
        around: Iterable[Any] = repeat(None, len(known))
        if merges:
            faces = [borders[piece] for piece in known]
            neighbours = (
                self._client.submit(neighbours_of, faces[number], [faces[other] for other in others], pure=False)
                for number, others in enumerate(touching(known_outlines))
            )
        if self._job.needs_rays:
            around = self._around(known, known_outlines)
        failed = {output for output, result in self._results.items() if result.reason}
        missing = [number for number, piece in enumerate(pieces) if piece.output in failed]
        if missing:  # this changes the checksum, so a later run that can read these pieces lights all again
            made_from = checksum_of([made_from, missing])
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
        """Return the results of all pieces and index files as a `Batch` with the given note."""
        results = [(piece.input, self._results[piece.output]) for piece in self._pieces]
        results += [(index.input, self._results[index.output]) for index in self._indices]
        failed = {path: result.reason for path, result in results if result.reason}
        done = dict.fromkeys(path for path, result in results if result.is_new and path not in failed)
        skipped = dict.fromkeys(path for path, _ in results if path not in failed and path not in done)
        return Batch(tuple(done), tuple(skipped), failed, note)

    def _begin(self, work: Callable[..., Any], piece: Piece, *more: Any) -> Any:
        """Start the task `work(piece, *more)`, and return it. Tasks in `more` are replaced by their values."""
        return self._client.submit(work, found_anywhere(piece), *more, pure=False)

    def _each(
        self, work: Callable[..., Any], pieces: Iterable[Piece], *more: Any, fetches: bool = True
    ) -> Iterator[tuple[Piece, Any]]:
        """Run the task `work(piece, *more)` for each piece; yield pieces and values in the order in which tasks end.

        A piece whose task fails is recorded as failed and not yielded. With `fetches` False, values stay on the
        workers, and the task itself is yielded in place of its value.
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


def found_anywhere(piece: Piece) -> Piece:
    """Return a piece with absolute paths, so that worker processes in other folders find its files."""
    return replace(piece, input=piece.input.absolute(), output=piece.output.absolute())
