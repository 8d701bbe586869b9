"""Whether a mesh file is whole, by what it says of its own length.

VTK's readers take what is left of many files that were cut short, with garbage for the rest, and some of its writers
do not notice that a disk is full. So files are looked at before they are read, and after they were written. A file
that is cut where a shorter one could end, as between the lines of an .obj file, is a whole one as far as anybody can
know.
"""

from __future__ import annotations

import html
import math
import mmap
import re
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pvphong.meshes import legacy, ply, xml_arrays

Bytes = Any
"""A file's contents as a `mmap.mmap`, of which slices are bytes."""

_HDF = b"\x89HDF\r\n\x1a\n"
_HDF_END = {0: 40, 1: 44, 2: 28, 3: 28}  # where the superblock of each version has the address of the file's end
_WHOLE = re.compile(rb"""\bWholeExtent\s*=\s*["']([^"']*)["']""")
_PIECE = re.compile(rb"""<Piece\b[^>]*?\bExtent\s*=\s*["']([^"']*)["']""")
_BLOCK = re.compile(rb"""<DataSet\b[^>]*?\bfile\s*=\s*["']([^"']+)["']""")
_WITH_BLOCKS = (".vtm", ".vtmb")
_LAST = 4096  # bytes in which the end tag of an XML file is looked for, and a grid's extent at its beginning


def refuse_parts(path: Path) -> None:
    """Raise ``ValueError`` for a file that is not there to its end; formats that do not tell are passed over.

    A file that names others is whole if they are; one that is not there is left to the reader.
    """
    check = _CHECKS.get(path.suffix.lower())
    if check is None or not path.is_file() or not path.stat().st_size:
        return
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as contents:
        check(contents)
        blocks = _BLOCK.findall(contents) if path.suffix.lower() in _WITH_BLOCKS else []
    for block in blocks:
        other = path.parent / html.unescape(block.decode(errors="replace"))
        try:
            if other.suffix.lower() not in _WITH_BLOCKS:  # else a file could name itself
                refuse_parts(other)
        except ValueError as error:
            raise ValueError(f"Its block {other.name}: {error}") from error


def _xml(contents: Bytes) -> None:
    if b"</VTKFile>" not in contents[-_LAST:]:
        raise ValueError("It is cut short: the end tag </VTKFile> is missing.")
    xml_arrays.refuse_short(contents)


def _xml_grid(contents: Bytes) -> None:
    """A grid's pieces fill it; what none of them fills VTK's readers leave as it was in memory."""
    _xml(contents)
    data = contents.find(b"<AppendedData")
    whole = _WHOLE.search(contents, 0, _LAST)
    pieces = [_cells(found[1]) for found in _PIECE.finditer(contents, 0, data if data > 0 else len(contents))]
    if whole is None or _cells(whole[1]) != sum(pieces):
        raise ValueError("Its pieces do not fill its WholeExtent.")


def _cells(extent: bytes) -> float:
    """In a grid from a first to a last place along each axis; an axis with one place counts as one cell."""
    try:
        a, b, c, d, e, f = map(int, extent.split())
    except ValueError:
        return math.nan
    return math.prod(max(last - first, 1) for first, last in ((a, b), (c, d), (e, f)))


def _hdf(contents: Bytes) -> None:
    """By the "end of file address" of the superblock (HDF5 File Format Specification 3.0, II.A)."""
    place = _HDF_END.get(contents[8]) if contents[:8] == _HDF and len(contents) > 52 else None
    if place is None:
        raise ValueError("It does not begin as an HDF5 file does.")
    (end,) = struct.unpack_from("<Q", contents, place)
    if end != len(contents):
        raise ValueError(f"It has {len(contents)} bytes, and says {end}.")


def _stl(contents: Bytes) -> None:
    """A binary file has 50 bytes per triangle after its header of 84; text ends with a word."""
    if contents[:5] == b"solid" and b"facet" in contents[:_LAST]:
        if b"endsolid" not in contents[-_LAST:]:
            raise ValueError("It is cut short: the word endsolid is missing.")
        return
    count = struct.unpack_from("<I", contents, 80)[0] if len(contents) >= 84 else 0
    if len(contents) < 84 + 50 * count:
        raise ValueError(f"It is cut short: {count} triangles take {84 + 50 * count} bytes, it has {len(contents)}.")


_CHECKS: dict[str, Callable[[Bytes], None]] = {
    **dict.fromkeys((".vtp", ".vtu", ".vtm", ".vtmb"), _xml),
    **dict.fromkeys((".vts", ".vtr", ".vti"), _xml_grid),
    ".vtk": legacy.refuse_parts,
    ".vtkhdf": _hdf,
    ".ply": ply.refuse_parts,
    ".stl": _stl,
}
