"""One call: what is asked of the workers, in which order, and what came of each piece."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from operator import getitem
from pathlib import Path
from typing import Any

import numpy as np

from pvphong.base.text import counting
from pvphong.batch import indices, receipts
from pvphong.batch.cluster import Cluster, trouble
from pvphong.batch.listing import Index, Listing, Piece
from pvphong.batch.result import Batch
from pvphong.batch.seams import neighbours_of
from pvphong.batch.tasks import Job, Outcome, border_in, bounds_of, checksum_of_file, light, standing
from pvphong.meshes.default_scene import default_scene_of
from pvphong.scene.scene import Scene


class Run:
    """What came of each piece so far.

    Parameters
    ----------
    cluster : Cluster
        Who works.
    job : Job
        How pieces are lit.
    found : Listing
        The pieces, and their indices.
    merges : bool
        Whether normals are those of surfaces in one piece.
    """

    def __init__(self, cluster: Cluster, job: Job, found: Listing, *, merges: bool) -> None:
        self._cluster, self._job, self._found = cluster, job, found
        self._merges = merges
        self._count = counting(len(found.pieces))
        self._outcomes: dict[Path, Outcome] = {}
        self._indices: dict[Path, Outcome] = {}

    def frame(self, given: Scene | None) -> None:
        """Give the scene a viewer that sees all pieces; the default scene if none is given."""
        asked = {self._cluster.begin(bounds_of, piece.absolute().input): piece for piece in self._found.pieces}
        low, high, is_open = np.full(3, np.nan), np.full(3, np.nan), False
        for piece, told in self._cluster.done(asked, _failed):
            if isinstance(told, Outcome):
                self._end(piece, told)
                continue
            bounds, has_edges = np.array(told[0]), told[1]
            low, high, is_open = np.fmin(low, bounds[::2]), np.fmax(high, bounds[1::2]), is_open or has_edges
        box = np.column_stack([low, high]).ravel()
        scene = default_scene_of(box, is_open=is_open) if given is None else given.framed(box)
        self._job = replace(self._job, scene=scene)

    def light(self) -> None:
        """Light all pieces that have not failed."""
        surfaces: dict[str, list[Piece]] = defaultdict(list)
        for piece in self._found.pieces:
            surfaces[piece.surface if self._merges else ""].append(piece)
        begun = self._begin_alone(surfaces.pop("", []))
        for pieces in surfaces.values():
            begun |= self._begin_surface(pieces) if len(pieces) > 1 else self._begin_alone(pieces)
        for piece, outcome in self._cluster.done(begun, _failed):
            self._end(piece, outcome)

    def write_indices(self) -> None:
        """Write those of which all pieces have a lit file."""
        for index in self._found.indices:
            self._indices[index.output] = self._written(index)

    def batch(self, note: str) -> Batch:
        """All of it."""
        ends = [(piece.input, self._outcomes[piece.output]) for piece in self._found.pieces]
        ends += [(index.input, self._indices[index.output]) for index in self._found.indices]
        failed = {path: end.reason for path, end in ends if end.reason}
        done = dict.fromkeys(path for path, end in ends if end.is_new and path not in failed)
        skipped = dict.fromkeys(path for path, _ in ends if path not in failed and path not in done)
        return Batch(tuple(done), tuple(skipped), failed, note)

    # --- pieces

    def _left(self, pieces: Sequence[Piece]) -> list[Piece]:
        return [piece for piece in pieces if piece.output not in self._outcomes]

    def _end(self, piece: Piece, outcome: Outcome) -> None:
        self._outcomes[piece.output] = outcome
        self._count(1)

    def _begin_alone(self, pieces: Sequence[Piece]) -> dict[Any, Piece]:
        return {self._cluster.begin(light, piece.absolute(), self._job): piece for piece in self._left(pieces)}

    def _begin_surface(self, pieces: Sequence[Piece]) -> dict[Any, Piece]:
        """Tasks for the pieces of one surface: each depends on all, for it gets its neighbours' faces."""
        made_from = self._checksum(pieces)
        asked = {
            self._cluster.begin(standing, piece.absolute(), self._job, made_from): piece for piece in self._left(pieces)
        }
        for piece, outcome in self._cluster.done(asked, _failed):
            if outcome is not None:
                self._end(piece, outcome)
        if not self._left(pieces):
            return {}
        borders = {self._cluster.begin(border_in, piece.absolute().input): piece for piece in pieces}
        known = {}
        for task in self._cluster.ended(borders):
            piece, why = borders[task], trouble(task)
            if not why:
                known[task] = piece
            elif piece.output not in self._outcomes:
                self._end(piece, Outcome(reason=why))
        if not known:
            return {}
        missing = [number for number, piece in enumerate(pieces) if piece not in known.values()]
        if missing:  # the others have to be lit again when these are there
            made_from = receipts.checksum_of([made_from, missing])
        shared = self._cluster.begin(neighbours_of, list(known))
        return {
            self._cluster.begin(
                light, piece.absolute(), self._job, self._cluster.begin(getitem, shared, number), made_from
            ): piece
            for number, piece in enumerate(known.values())
            if piece.output not in self._outcomes
        }

    def _checksum(self, pieces: Sequence[Piece]) -> str:
        """Of all files of a surface."""
        asked = {self._cluster.begin(checksum_of_file, piece.absolute().input): piece for piece in self._left(pieces)}
        sums = dict.fromkeys(pieces, "")
        for piece, told in self._cluster.done(asked, _failed):
            if isinstance(told, Outcome):
                self._end(piece, told)
            else:
                sums[piece] = told
        return receipts.checksum_of(list(sums.values()))

    # --- indices

    def _written(self, index: Index) -> Outcome:
        ends = [self._outcomes.get(output) or self._indices[output] for output in index.outputs]
        without = sum(bool(end.reason) for end in ends)
        if without:
            return Outcome(reason=f"not written, for {without} of the {len(ends)} files that it names failed")
        try:
            return Outcome(indices.write(index.input, index.output, index.outputs, [end.arrays for end in ends]))
        except ValueError as error:
            return Outcome(reason=str(error))


def _failed(reason: str) -> Outcome:
    return Outcome(reason=reason)
