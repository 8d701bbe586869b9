"""Detection of truncated mesh files, before VTK reads them and after VTK has written them.

VTK's readers accept many truncated files, and some of its writers do not report a full disk. Here only the length that
a file declares, or its required end, is checked; VTK checks the rest. If the part that is left is also a valid file, as
with some lines of an .obj file, the truncation cannot be detected.

The formats, in the order of this module: VTK's XML files, HDF5, .stl, .ply, legacy .vtk. The argument `contents` is a
`mmap.mmap`, whose slices are bytes.
"""

from __future__ import annotations

import html
import mmap
import re
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

_BEGINNING = _END = 4096  # bytes to search for the tags at the beginning and end of an XML file
_WITH_BLOCKS = (".vtm", ".vtmb")
_BLOCK = re.compile(rb"""<DataSet\b[^>]*?\bfile\s*=\s*["']([^"']+)["']""")


def refuse_incomplete(path: Path) -> None:
    """Raise ``ValueError`` if a file is truncated. Formats without a declared length or end are not checked.

    If the file lists the files of its blocks, these are checked too. A missing file is not reported here, but by the
    reader.
    """
    suffix = path.suffix.lower()
    check = _CHECKS.get(suffix)
    if check is None or not path.is_file() or not path.stat().st_size:
        return
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as contents:
        check(contents)
        blocks = _BLOCK.findall(contents) if suffix in _WITH_BLOCKS else []
    for block in blocks:
        other = path.parent / html.unescape(block.decode(errors="replace"))
        try:
            if other.suffix.lower() not in _WITH_BLOCKS:  # otherwise a file could refer to itself without end
                refuse_incomplete(other)
        except ValueError as error:
            raise ValueError(f"Its block {other.name}: {error}") from error


# --- VTK's XML files ("VTK XML Formats" in VTK's documentation) ---

_FILE = re.compile(rb"<VTKFile\b[^>]*>")
_ARRAY = re.compile(rb"<(?:Data)?Array\b[^>]*>")
_APPENDED = re.compile(rb"<AppendedData\b[^>]*>\s*_")
_FORMAT, _OFFSET = (re.compile(rb"\b" + name + rb"""\s*=\s*["']([^"']*)["']""") for name in (b"format", b"offset"))


def _check_xml(contents: Any) -> None:
    """Raise ValueError if a VTK XML file has no end tag, or an array appended as bytes is shorter than declared.

    Compressed bytes are not checked, because VTK verifies their checksum.
    """
    if b"</VTKFile>" not in contents[-_END:]:
        raise ValueError("It is cut short: the end tag </VTKFile> is missing.")
    head = _FILE.search(contents, 0, _BEGINNING)
    if head is None:
        raise ValueError("It does not begin like a VTK XML file.")
    appended = _APPENDED.search(contents)
    if appended is None or b"raw" not in appended[0]:
        return
    end = contents.rfind(b"</AppendedData")
    for found in _ARRAY.finditer(contents, 0, appended.start()):
        kind, offset = _FORMAT.search(found[0]), _OFFSET.search(found[0])
        if kind is None or kind[1] != b"appended":
            continue
        if offset is None or not offset[1].isdigit():
            raise ValueError("It is damaged: an array has no offset in the appended data.")
        if _end_of_array(contents, appended.end() + int(offset[1]), head[0]) > end:
            raise ValueError("It is damaged: an array has fewer bytes than it declares.")


def _end_of_array(data: Any, place: int, head: bytes) -> int:
    """Return the position of the end of an appended array, as its header declares it.

    For an uncompressed array, the header is the number of bytes. For a compressed array, it is the number of blocks,
    the size of a full block, the size of the last block, and the compressed size of each block.

    Parameters
    ----------
    data : mmap.mmap
        The file.
    place : int
        Position of the header.
    head : bytes
        First tag of the file, which tells byte order, width of the header's numbers, and compression.
    """
    order: Any = "big" if b"BigEndian" in head else "little"
    width = 8 if b"UInt64" in head else 4
    size, start = int.from_bytes(data[place : place + width], order), place + width
    if b"compressor=" not in head:
        return start + size
    if not size:
        return start
    first, end = start + 2 * width, start + (2 + size) * width
    if end > len(data):
        return end
    return end + sum(int.from_bytes(data[at : at + width], order) for at in range(first, end, width))


# --- HDF5 and .stl ---

_HDF_END = {0: 40, 1: 44, 2: 28, 3: 28}  # offset of the file's end address in the superblock, by version


def _check_hdf(contents: Any) -> None:
    """Raise ValueError if the length of an HDF5 file is not the "end of file address" in its superblock.

    Source: HDF5 File Format Specification 3.0, II.A.
    """
    is_hdf = contents[:8] == b"\x89HDF\r\n\x1a\n" and len(contents) > 52
    if not is_hdf or contents[8] not in _HDF_END:
        raise ValueError("It does not begin like an HDF5 file.")
    (end,) = struct.unpack_from("<Q", contents, _HDF_END[contents[8]])
    if end != len(contents):
        raise ValueError(f"It has {len(contents)} bytes, but declares {end}.")


def _check_stl(contents: Any) -> None:
    """Raise ValueError if an .stl file is cut short.

    A binary file must have 84 bytes and 50 for each triangle; a text file must end with the word "endsolid".
    """
    if contents[:5].lower() == b"solid" and b"facet" in contents[:_BEGINNING].lower():
        if b"endsolid" not in contents[-_END:].lower():
            raise ValueError("It is cut short: the word endsolid is missing.")
        return
    count = struct.unpack_from("<I", contents, 80)[0] if len(contents) >= 84 else 0
    if len(contents) < 84 + 50 * count:
        raise ValueError(f"It is cut short: {count} triangles need {84 + 50 * count} bytes, it has {len(contents)}.")


# --- .ply (Turk, The PLY Polygon File Format, 1994) ---

_PLY_SIZES = {"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4, "double": 8}
_PLY_SIZES |= {"int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4, "float64": 8}
_PLY_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}


def _check_ply(contents: Any) -> None:
    """Raise ValueError if a .ply file has fewer lines of text, or fewer bytes, than its header declares."""
    end = contents.find(b"end_header", 0, 2**16)
    at = contents.find(b"\n", end) + 1
    if not contents[:3] == b"ply" or end < 0 or not at:
        raise ValueError("It has no .ply header.")
    order = None
    elements: list[tuple[int, list[list[int]]]] = []  # count, and sizes of the properties; a list property has two
    for line in contents[:end].decode("ascii", "replace").splitlines():
        match line.split():
            case ["format", kind, *_]:
                order = _PLY_ORDERS.get(kind)
            case ["element", _, count] if count.isdigit():
                elements.append((int(count), []))
            case ["property", kind, _] if elements and kind in _PLY_SIZES:
                elements[-1][1].append([_PLY_SIZES[kind]])
            case ["property", "list", of_count, of_entry, _] if elements and {of_count, of_entry} <= {*_PLY_SIZES}:
                elements[-1][1].append([_PLY_SIZES[of_count], _PLY_SIZES[of_entry]])
            case ["ply"] | ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise ValueError(f"The line {line!r} of its header is unknown.")
    if order is None:
        declared, text = sum(count for count, _ in elements), contents[at:]
        is_by_vtk = b"VTK generated" in contents[:end]  # VTK ends all lines with a line break
        if text.count(b"\n") + (not text.endswith(b"\n") and not is_by_vtk) < declared:
            raise ValueError(f"It is cut short: its header declares {declared} lines.")
        return
    for count, properties in elements:
        at = _end_of_element(contents, at, order, count, properties)
        if at > len(contents):
            raise ValueError("It is cut short: its header declares more bytes.")


def _end_of_element(contents: Any, at: int, order: str, count: int, properties: list[list[int]]) -> int:
    """Return the position after all items of an element of a binary .ply file.

    In a truncated file, the position is beyond the file's end.

    Parameters
    ----------
    contents : mmap.mmap
        The file.
    at : int
        Position of the element's first item.
    order : str
        Byte order for `struct`: "<" or ">".
    count : int
        Number of items.
    properties : list
        Sizes in bytes of each property: [size] for a number, [size of the count, size of an entry] for a list.
    """
    if all(len(sizes) == 1 for sizes in properties):
        return at + count * sum(size for (size,) in properties)

    def size_at(place: int, sizes: list[int]) -> int:
        if len(sizes) == 1:
            return sizes[0]
        entries = int.from_bytes(contents[place : place + sizes[0]], "little" if order == "<" else "big")
        return sizes[0] + entries * sizes[1]

    if len(properties) == 1 and count and at < len(contents):  # one list, as for faces: usually of equal lengths
        stride, width = size_at(at, properties[0]), properties[0][0]
        there = min(count, (len(contents) - at) // stride)
        form: Any = {"names": ["n"], "formats": [f"{order}u{width}"], "offsets": [0], "itemsize": stride}
        lengths = np.frombuffer(contents[at : at + there * stride], np.dtype(form))["n"]
        if (lengths == lengths[:1]).all():
            return at + count * stride
    for _ in range(count):
        for sizes in properties:
            if at >= len(contents):
                return at + 1
            at += size_at(at, sizes)
    return at


# --- legacy .vtk ("VTK File Formats" in The VTK User's Guide, 11th edition) ---

_HEADER = re.compile(rb"# vtk DataFile Version \d+\.\d+\s*\n([^\n]*)\n\s*(?:ASCII|BINARY)\s", re.IGNORECASE)


def _check_legacy(contents: Any) -> None:
    """Raise ValueError if a legacy .vtk file is cut short: VTK ends its files with a line break.

    Only files that VTK has written are checked; they have VTK's own title.
    """
    header = _HEADER.match(contents)
    if header is None:
        raise ValueError("It does not begin like a legacy .vtk file.")
    if header[1].strip() == b"vtk output" and contents[-1:] != b"\n":
        raise ValueError("It is cut short: its last line has no line break.")


_CHECKS: dict[str, Callable[[Any], None]] = {
    **dict.fromkeys((".vtp", ".vtu", ".vts", ".vtr", ".vti", ".vtm", ".vtmb"), _check_xml),
    ".vtkhdf": _check_hdf,
    ".stl": _check_stl,
    ".ply": _check_ply,
    ".vtk": _check_legacy,
}
