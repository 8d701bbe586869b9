"""Which files are to be lit, and where what comes of them goes."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Any, Literal

from pvphong.base import check
from pvphong.batch import indices
from pvphong.meshes.blocks import DEFAULT

Seams = Literal["merge", "keep"]
"""Whether points of several pieces at one place get one normal, that of all faces around it."""

_MANY = "a pattern, a path, or a sequence of them"


@dataclass(frozen=True)
class Piece:
    """A file to be lit: one mesh, or a part of one.

    Attributes
    ----------
    input, output : Path
        The file, and the .vtp file that comes of it.
    label : str
        The block that it is, for its material; "default" elsewhere.
    surface : str
        The same for the pieces of one surface; "" for a surface of its own.
    """

    input: Path
    output: Path
    label: str = DEFAULT
    surface: str = ""

    def absolute(self) -> Piece:
        """As workers are told: they may run in another folder."""
        return replace(self, input=self.input.absolute(), output=self.output.absolute())


@dataclass(frozen=True)
class Index:
    """A file that names others, and what is to be written in its place: names of lit files, in its order."""

    input: Path
    output: Path
    outputs: tuple[Path, ...]


@dataclass
class Listing:
    """What there is to do. Indices come after those that they name."""

    pieces: list[Piece] = field(default_factory=list)
    indices: list[Index] = field(default_factory=list)

    @property
    def each(self) -> list[Piece | Index]:
        """All files."""
        return [*self.pieces, *self.indices]


def paths_of(given: Any) -> list[Path]:
    """The files that paths and patterns name, in order and each once.

    Raises
    ------
    ValueError
        If a pattern or a path names none.
    """
    if isinstance(given, (str, os.PathLike)):
        given = [given]
    if not isinstance(given, Iterable):
        check.refuse("paths", given, _MANY)
    found: dict[Path, None] = {}
    for one in given:
        if not isinstance(one, (str, os.PathLike)):
            check.refuse("paths", one, _MANY)
        found.update(dict.fromkeys(_named(os.fspath(one))))
    if not found:
        check.refuse("paths", "none", "at least one file")
    return list(found)


def is_pattern(path: str) -> bool:
    """Whether it is to be matched with the names of files: a file of just that name is taken as it is."""
    return glob.has_magic(path) and not os.path.lexists(path)


def _named(path: str) -> list[Path]:
    if not is_pattern(path):
        return [Path(path)]
    matched = sorted(Path(match) for match in glob.glob(path, recursive=True) if os.path.isfile(match))
    if not matched:
        check.refuse("paths", Path(path), "a pattern that some file matches", "Patterns know *, ?, [abc] and **.")
    return matched


def listing(paths: Iterable[Path], out: Path, *, as_one: bool = False) -> Listing:
    """All pieces that some files are or name, and where their lit ones go: `out`/name.vtp.

    What an index names goes into a folder of the index's name.

    Parameters
    ----------
    paths : iterable of Path
        Meshes, and indices.
    out : Path
        The folder.
    as_one : bool
        Whether all are pieces of one surface; else what one index names for one time is.

    Raises
    ------
    ValueError
        If two would have one output, an output would be an input, or an index cannot be read or names itself.
    """
    result = Listing()
    for path in paths:
        _add(result, path, out / path.stem, DEFAULT, "all" if as_one else "", ())
    _refuse_clashes(result)
    return result


def _add(
    result: Listing,
    path: Path,
    target: Path,
    label: str,
    surface: str,
    above: tuple[Path, ...],
) -> Path:
    """Add a file and what it names; gives its output."""
    if not indices.is_index(path):
        piece = Piece(path, target.with_name(f"{target.name}.vtp"), label, surface)
        result.pieces.append(piece)
        return piece.output
    if path.resolve() in above:
        check.refuse("paths", path, "an index that does not name itself")
    outputs = tuple(
        _add(
            result,
            path.parent / entry.file,
            _below(target, entry.file),
            entry.label or label,
            surface or f"{path}@{entry.step}",
            (*above, path.resolve()),
        )
        for entry in indices.entries(path)
    )
    index = Index(path, target.with_name(target.name + indices.output_suffix(path)), outputs)
    result.indices.append(index)
    return index.output


def _below(folder: Path, file: str) -> Path:
    """Where a file that an index names goes, without its suffix: as it lies beside the index, but never outside."""
    parts = [part for part in PurePosixPath(file.replace("\\", "/")).parts if part not in ("..", "/", ".")]
    inner = parts[1:-1] if parts[0] == folder.name else parts[:-1]
    return folder.joinpath(*inner, Path(parts[-1]).stem)


def _refuse_clashes(found: Listing) -> None:
    made: dict[Path, Path] = {}
    inputs = {os.path.realpath(each.input) for each in found.each}
    for each in found.each:
        other = made.setdefault(each.output, each.input)
        if other != each.input:
            remedy = "Light them into two folders, or rename one."
            check.refuse("paths", f"{other} and {each.input}, both {each.output}", "files with different names", remedy)
        if os.path.realpath(each.output) in inputs:
            check.refuse("out", each.output.parent, "another folder than that of the files", "It would replace them.")
    found.pieces = list({piece.output: piece for piece in reversed(found.pieces)}.values())[::-1]
    found.indices = list(dict.fromkeys(found.indices))
