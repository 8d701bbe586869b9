"""Input files, the paths of their lit files, and index files.

An index file is a small XML file that names other files: blocks (.vtm), pieces of a surface (.pvtp, .pvtu), or a time
series (.pvd).
"""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from pathlib import Path, PurePosixPath
from typing import Any, Literal, NamedTuple
from xml.etree import ElementTree

from pvphong.base import check
from pvphong.base.files import written_aside
from pvphong.meshes.blocks import DEFAULT

Seams = Literal["merge", "keep"]
""""merge": points of several pieces with equal coordinates get one normal. "keep": each piece has its own normals."""

_PATHS = "a pattern, a path, or a sequence of them"
_INDICES = (".vtm", ".pvtp", ".pvtu", ".pvd")
_PARALLEL = ("PPolyData", "PUnstructuredGrid")
_READABLE = f"a readable index file ({', '.join(_INDICES)})"


@dataclass(frozen=True)
class Piece:
    """File to light: a mesh, or a piece of a mesh.

    Attributes
    ----------
    input, output : Path
        The input file and its lit file, a .vtp.
    labels : tuple of str
        Names of the blocks that refer to the file; only "default" if no block does. The names select the file's
        material.
    surface : str
        Identifier that all pieces of one surface share; "" if the file is a surface of its own.
    """

    input: Path
    output: Path
    labels: tuple[str, ...] = (DEFAULT,)
    surface: str = ""


@dataclass(frozen=True)
class Index:
    """Index file, the path of its lit copy, and the lit files that the copy names, in the order of the index file."""

    input: Path
    output: Path
    outputs: tuple[Path, ...]


class ArrayType(NamedTuple):
    """Name, type and size of an array in a lit file.

    A .pvtp file declares in this form the arrays that all its pieces have.
    """

    place: str
    """"PointData", "CellData" or "Points"."""
    type: str
    name: str
    components: int


def paths_of(given: Any, out: Path) -> list[Path]:
    """Return the files that paths and patterns name, in order and without duplicates.

    Parameters
    ----------
    given : path, or iterable of paths
        Paths of files, and patterns such as `parts/*.vtp`.
    out : Path
        Output folder. If a pattern matches a file in this folder, the file is skipped, because it is a result of an
        earlier call. If the pattern itself begins with this folder, the file is not skipped.

    Raises
    ------
    ValueError
        If a pattern or a path names no file.
    """
    if isinstance(given, (str, os.PathLike)):
        given = [given]
    if not isinstance(given, Iterable):
        check.refuse("paths", given, _PATHS)
    found: dict[Path, Path] = {}
    for path in given:
        if not isinstance(path, (str, os.PathLike)):
            check.refuse("paths", path, _PATHS)
        if not is_pattern(os.fspath(path)):
            found.setdefault(_place(Path(path)), Path(path))
            continue
        matches = sorted(Path(match) for match in glob.glob(os.fspath(path), recursive=True) if os.path.isfile(match))
        root = Path(*takewhile(lambda part: not glob.has_magic(part), Path(path).parts))
        if not _is_inside(root, out):
            matches = [match for match in matches if not _is_inside(match, out)]
        if not matches:
            check.refuse("paths", Path(path), "a pattern that matches a file", "Patterns may use *, ?, [abc] and **.")
        for match in matches:
            found.setdefault(_place(match), match)
    if not found:
        check.refuse("paths", "no path", "one or more files or patterns")
    return list(found.values())


def _place(path: Path) -> Path:
    """Return the absolute path of a file, by which files are compared.

    Links to folders are resolved, links to files are not.
    """
    return Path(os.path.realpath(path.parent), path.name)


def _is_inside(path: Path, folder: Path) -> bool:
    return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


def is_pattern(path: str) -> bool:
    """Return True if a path has pattern characters, such as *, and no file of exactly this name exists."""
    return glob.has_magic(path) and not os.path.lexists(path)


def pieces_and_indices(paths: Iterable[Path], out: Path, *, as_one: bool = False) -> tuple[list[Piece], list[Index]]:
    """Return the pieces in the given files, and the index files among them.

    The lit file of a mesh is `out`/name.vtp. The lit files of an index file are in a folder named after it. In the
    result, an index file follows the index files that it names.

    Parameters
    ----------
    paths : iterable of Path
        Mesh files and index files.
    out : Path
        Output folder.
    as_one : bool
        Treat all files as pieces of one surface, except for the time steps of a .pvd file: each is a surface. By
        default, only the files of one index file at one time step are treated as pieces of one surface.

    Raises
    ------
    ValueError
        If two files have the same output, an output is an input, an index file cannot be read or names itself, or, with
        `as_one`, two time steps name the same file.
    """
    pieces: dict[Path, Piece] = {}
    indices: dict[Path, Index] = {}
    source_of: dict[Path, Path] = {}

    def claim(output: Path, source: Path) -> None:
        other = source_of.setdefault(output, source)
        if other != source:
            remedy = "Light them into different folders, or rename one."
            check.refuse("paths", f"{other} and {source}, both for {output}", "files with different names", remedy)

    def add(path: Path, target: Path, label: str, surface: str, above: tuple[Path, ...]) -> Path:
        """Add a file, and all files that it names, to the pieces and index files; return the path of its lit file.

        Parameters
        ----------
        path : Path
            Mesh file or index file.
        target : Path
            Path of the lit file without suffix.
        label : str
            Name of the block that refers to the file. The name selects the file's material.
        surface : str
            Identifier of the surface of which the file is a piece; "" for a surface of its own.
        above : tuple of Path
            The index files that lead to this file.
        """
        suffix = path.suffix.lower()
        if suffix not in _INDICES:
            output = target.with_name(f"{target.name}.vtp")
            claim(output, path)
            known = pieces.setdefault(output, Piece(path, output, (label,), surface))
            if as_one and known.surface != surface:
                check.refuse("paths", path, "in one time step only", "Copy the file for each other time step.")
            if label not in known.labels:
                pieces[output] = replace(known, labels=(*known.labels, label))
            return output
        if path.resolve() in above:
            check.refuse("paths", path, "files to light", "This index file names itself.")
        named = _named_files(_root(path))
        if not named:
            check.refuse("paths", path, "files to light", "This index file names no files.")
        outputs = []
        for element, attribute, name in named:
            file = element.get(attribute, "")
            # keep the path relative to the index file, but inside the output folder
            parts = [part for part in PurePosixPath(file.replace("\\", "/")).parts if part not in ("..", "/", ".")]
            if not parts:
                check.refuse("paths", path, "files to light", f"An entry of this index file names {file!r}.")
            inner = target.joinpath(*parts[int(parts[0] == target.name) : -1], Path(parts[-1]).stem)
            time = element.get("timestep", "")  # a time step is a surface of its own
            one = f"{surface or path}@{time}" if time or not surface else surface
            outputs.append(add(path.parent / file, inner, name or label, one, (*above, path.resolve())))
        output = target.with_name(target.name + (".pvtp" if suffix == ".pvtu" else suffix))  # lit meshes are surfaces
        claim(output, path)
        indices[output] = Index(path, output, tuple(outputs))
        return output

    for path in paths:
        add(path, out / path.stem, DEFAULT, "one surface" if as_one else "", ())
    inputs = {os.path.realpath(path) for path in source_of.values()}
    for output in source_of:
        if os.path.realpath(output) in inputs:
            check.refuse(
                "out", output.parent, "a folder other than that of the input", "Lit files would replace inputs."
            )
    return list(pieces.values()), list(indices.values())


def write_index(index: Index, arrays: Sequence[Sequence[ArrayType]]) -> bool:
    """Write the lit copy of an index file atomically; return False if the same file exists already.

    Parameters
    ----------
    index : Index
        The index file. In a .vtm or .pvd file, only the names of files are replaced.
    arrays : sequence
        Arrays of each lit file. A .pvtp copy declares the arrays that all nonempty lit files have.

    Raises
    ------
    ValueError
        If the file cannot be written.
    """
    root = _root(index.input)
    names = [Path(os.path.relpath(file, index.output.parent)).as_posix() for file in index.outputs]
    if root.get("type") in _PARALLEL:
        # VTK's reader skips arrays that the file does not declare (VTK's "XML file formats")
        root = ElementTree.Element("VTKFile", type="PPolyData", version="0.1", byte_order="LittleEndian")
        whole = ElementTree.SubElement(root, "PPolyData", GhostLevel="0")
        first, *more = [each for each in arrays if each] or [()]
        common = [array for array in first if all(array in others for others in more)]
        for place in ("PointData", "CellData", "Points"):
            parent = ElementTree.SubElement(whole, f"P{place}")
            for array in common:
                if array.place == place:
                    declared = {"type": array.type, "Name": array.name, "NumberOfComponents": str(array.components)}
                    ElementTree.SubElement(parent, "PDataArray", declared)
        for name in names:
            ElementTree.SubElement(whole, "Piece", Source=name)
    else:
        for (element, attribute, _), name in zip(_named_files(root), names, strict=True):
            element.set(attribute, name)
    text = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    if index.output.is_file() and index.output.read_bytes() == text:
        return False
    with written_aside(index.output) as aside:
        aside.write_bytes(text)
    return True


def _root(path: Path) -> ElementTree.Element:
    """Parse an index file, and return its root element; raise ValueError if it is not a valid index file."""
    if not os.path.isfile(path):  # also False for a name that is too long
        check.refuse("paths", path, "a file that exists")
    try:
        root = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, OSError, ValueError) as error:
        check.refuse("paths", path, _READABLE, f"It cannot be parsed: {error}.")
    if root.tag != "VTKFile" or root.get("type") not in (*_PARALLEL, "vtkMultiBlockDataSet", "Collection"):
        check.refuse("paths", path, _READABLE, f"It contains {root.get('type') or root.tag}.")
    return root


def _named_files(root: ElementTree.Element) -> list[tuple[ElementTree.Element, str, str]]:
    """Return a tuple for each element of an index file that names a file.

    The tuple has the element, the name of the attribute that holds the file's path, and the path of the block to which
    the file belongs, such as "car/wheel". In a .pvtp, .pvtu or .pvd file, there are no blocks, and the path of the
    block is "".
    """
    if root.get("type") in _PARALLEL:
        return [(element, "Source", "") for element in root.iter("Piece")]
    if root.get("type") == "Collection":
        return [(element, "file", "") for element in root.iter("DataSet")]
    found = []

    def add_blocks(parent: ElementTree.Element, above: tuple[str, ...]) -> None:
        for element in parent:
            names = (*above, element.get("name") or element.get("index") or "")
            if element.tag == "Block":
                add_blocks(element, names)
            elif element.get("file"):  # an empty block has no file
                found.append((element, "file", "/".join(names)))

    for blocks in root[:1]:
        add_blocks(blocks, ())
    return found
