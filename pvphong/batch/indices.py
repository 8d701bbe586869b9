"""Files that name other files: blocks (.vtm), pieces (.pvtp, .pvtu) and time series (.pvd), all of them small XML."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from pvphong.base import check
from pvphong.base.files import written_aside

SUFFIXES = (".vtm", ".pvtp", ".pvtu", ".pvd")

_PIECES = ("PPolyData", "PUnstructuredGrid")
_READABLE = f"a file of one of {', '.join(SUFFIXES)} that can be read"


class IndexEntry(NamedTuple):
    """A file that an index names."""

    file: str
    """As it is written there, from the folder of the index."""
    label: str
    """The path of names of a block; "" elsewhere."""
    step: str
    """The time of a .pvd file; "" elsewhere. Files of one time are pieces of one surface."""


class Declared(NamedTuple):
    """An array that every piece has, as a .pvtp file tells of it."""

    place: str
    """"PointData", "CellData" or "Points"."""
    type: str
    name: str
    components: int


def is_index(path: Path) -> bool:
    """Whether a file names others, by its suffix."""
    return path.suffix.lower() in SUFFIXES


def entries(path: Path) -> list[IndexEntry]:
    """The files that an index names, in its order.

    Raises
    ------
    ValueError
        If it cannot be read, is no such file, or names none.
    """
    found = [
        IndexEntry(element.get(attribute, ""), label, element.get("timestep", ""))
        for element, attribute, label in _elements(_root(path))
    ]
    if not found:
        check.refuse("paths", path, "an index that names files")
    return found


def output_suffix(path: Path) -> str:
    """That of the index of the lit files: surfaces are PolyData, whatever they are cut from."""
    suffix = path.suffix.lower()
    return ".pvtp" if suffix == ".pvtu" else suffix


def write(source: Path, target: Path, files: Sequence[Path], arrays: Sequence[Sequence[Declared]]) -> bool:
    """Write an index of lit files, whole or not at all; False where it was there already.

    Parameters
    ----------
    source : Path
        The index of the files that were lit; what else it says is kept.
    target : Path
        The new one.
    files : sequence of Path
        The lit files, in the order of `entries`.
    arrays : sequence
        What each of them has; those that all have are declared where the format asks for it.

    Raises
    ------
    ValueError
        If it cannot be written.
    """
    root = _root(source)
    names = [Path(os.path.relpath(file, target.parent)).as_posix() for file in files]
    if root.get("type") in _PIECES:
        root = _declaring(names, arrays)
    else:
        for (element, attribute, _), name in zip(_elements(root), names, strict=True):
            element.set(attribute, name)
    text = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    if target.is_file() and target.read_bytes() == text:
        return False
    with written_aside(target) as aside:
        aside.write_bytes(text)
    return True


def _root(path: Path) -> ElementTree.Element:
    if not path.is_file():
        check.refuse("paths", path, "a file that exists")
    try:
        root = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, OSError, ValueError) as error:
        check.refuse("paths", path, _READABLE, f"It cannot be understood: {error}.")
    if root.tag != "VTKFile" or root.get("type") not in (*_PIECES, "vtkMultiBlockDataSet", "Collection"):
        check.refuse("paths", path, _READABLE, f"It holds {root.get('type') or root.tag}.")
    return root


def _elements(root: ElementTree.Element) -> list[tuple[ElementTree.Element, str, str]]:
    """The elements that name a file, each with the attribute that does, and with its label."""
    if root.get("type") in _PIECES:
        return [(element, "Source", "") for element in root.iter("Piece")]
    if root.get("type") == "Collection":
        return [(element, "file", "") for element in root.iter("DataSet")]
    return _blocks(root[0]) if len(root) else []


def _blocks(parent: ElementTree.Element, names: tuple[str, ...] = ()) -> list[tuple[ElementTree.Element, str, str]]:
    """The datasets of a block and of the blocks in it; those without a file are empty."""
    found = []
    for element in parent:
        path = (*names, element.get("name") or element.get("index") or "")
        if element.tag == "Block":
            found += _blocks(element, path)
        elif element.get("file"):
            found.append((element, "file", "/".join(path)))
    return found


def _declaring(names: Sequence[str], arrays: Sequence[Sequence[Declared]]) -> ElementTree.Element:
    """A .pvtp file: VTK's reader passes over arrays that it does not declare (VTK's "XML file formats")."""
    root = ElementTree.Element("VTKFile", type="PPolyData", version="0.1", byte_order="LittleEndian")
    whole = ElementTree.SubElement(root, "PPolyData", GhostLevel="0")
    common = [array for array in arrays[0] if all(array in others for others in arrays)]
    for place in ("PointData", "CellData", "Points"):
        parent = ElementTree.SubElement(whole, f"P{place}")
        for array in common:
            if array.place == place:
                told: Mapping[str, str] = {"Name": array.name, "NumberOfComponents": str(array.components)}
                ElementTree.SubElement(parent, "PDataArray", {"type": array.type, **told})
    for name in names:
        ElementTree.SubElement(whole, "Piece", Source=name)
    return root
