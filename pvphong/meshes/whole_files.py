"""Whether a mesh file is whole, by what it says of its own length, before VTK reads it and after VTK wrote it.

VTK's readers take what is left of many files that were cut short, with whatever was in memory for the rest, and some
of its writers do not notice that a disk is full. A file that is cut where a shorter one could end, as between the lines
of an .obj file, is a whole one as far as anybody can know.

In order: XML files of VTK's, HDF5, .stl, .obj, .ply, legacy .vtk. Contents are a `mmap.mmap`, whose slices are bytes.
"""

from __future__ import annotations

import binascii
import html
import math
import mmap
import re
import struct
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

_BEGINNING = _END = 4096  # bytes in which the tags at an XML file's beginning and end are looked for
_WITH_BLOCKS = (".vtm", ".vtmb")
_BLOCK = re.compile(rb"""<DataSet\b[^>]*?\bfile\s*=\s*["']([^"']+)["']""")


def refuse_incomplete(path: Path) -> None:
    """Raise ``ValueError`` for a file that was cut short; formats that do not show it are passed over.

    A file that names others is whole if they are; one that is not there is left to the reader.
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
            if other.suffix.lower() not in _WITH_BLOCKS:  # else a file could name itself
                refuse_incomplete(other)
        except ValueError as error:
            raise ValueError(f"Its block {other.name}: {error}") from error


# --- VTK's XML files, as of "VTK XML Formats" in VTK's documentation ---

_FILE = re.compile(rb"<VTKFile\b[^>]*>")
_ARRAY = re.compile(rb"<(?:Data)?Array\b[^>]*>")
_APPENDED = re.compile(rb"<AppendedData\b[^>]*>\s*_")
_FORMAT, _OFFSET, _WHOLE_EXTENT = (
    re.compile(rb"\b" + name + rb"""\s*=\s*["']([^"']*)["']""") for name in (b"format", b"offset", b"WholeExtent")
)
_BASE64 = re.compile(rb"[^=]+=*")
_PIECE_EXTENT = re.compile(rb"""<Piece\b[^>]*?\bExtent\s*=\s*["']([^"']*)["']""")


def _check_xml(contents: Any) -> None:
    """It ends with its tag, and its arrays have all the bytes that they declare.

    Arrays are between their tags in base64, or one after the other at the file's end. What compressed bytes hold is
    not looked at: VTK checks their checksum.
    """
    if b"</VTKFile>" not in contents[-_END:]:
        raise ValueError("It is cut short: the end tag </VTKFile> is missing.")
    head = _FILE.search(contents, 0, _BEGINNING)
    if head is None:
        raise ValueError("It does not begin as an XML file of VTK's does.")
    appended, is_short = _APPENDED.search(contents), False
    for found in _ARRAY.finditer(contents, 0, appended.start() if appended else len(contents)):
        kind = _FORMAT.search(found[0])
        if kind and kind[1] == b"binary":
            text = contents[found.end() : contents.find(b"<", found.end())].translate(None, b" \t\r\n")
            try:  # the header's text may have an end of its own
                data = b"".join(binascii.a2b_base64(part, strict_mode=True) for part in _BASE64.findall(text))
            except binascii.Error:
                data = b""
            is_short = bool(text) and _end_of_array(data, 0, head[0]) > len(data)
        elif kind and kind[1] == b"appended" and appended is not None and b"raw" in appended[0]:
            offset = _OFFSET.search(found[0])
            if offset is None or not offset[1].isdigit():
                raise ValueError("An array has no place in its appended data.")
            place = appended.end() + int(offset[1])
            is_short = _end_of_array(contents, place, head[0]) > contents.rfind(b"</AppendedData")
        if is_short:
            raise ValueError("It is damaged: an array has fewer bytes than it says.")


def _end_of_array(data: Any, place: int, head: bytes) -> int:
    """Where an array ends whose header is at a place, by what that declares; `head` is the file's first tag.

    The header is the number of bytes; or, where they are compressed, the number of blocks, two sizes of blocks, and
    each block's compressed size.
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


def _check_xml_grid(contents: Any) -> None:
    """Its pieces fill it, too; what none of them fills VTK's readers leave as it was in memory."""
    _check_xml(contents)
    data = contents.find(b"<AppendedData")
    whole = _WHOLE_EXTENT.search(contents, 0, _BEGINNING)
    pieces = _PIECE_EXTENT.finditer(contents, 0, data if data > 0 else len(contents))
    if whole is None or _cells_in(whole[1]) != sum(_cells_in(found[1]) for found in pieces):
        raise ValueError("Its pieces do not fill its WholeExtent.")


def _cells_in(extent: bytes) -> float:
    """The number of cells of a grid from first to last places along its axes; an axis with one place counts as one."""
    try:
        a, b, c, d, e, f = map(int, extent.split())
    except ValueError:
        return math.nan
    return math.prod(max(last - first, 1) for first, last in ((a, b), (c, d), (e, f)))


# --- HDF5 and .stl ---

_HDF_END = {0: 40, 1: 44, 2: 28, 3: 28}  # where the superblock of each version has the address of the file's end


def _check_hdf(contents: Any) -> None:
    """Check the length by the "end of file address" of the superblock (HDF5 File Format Specification 3.0, II.A)."""
    is_hdf = contents[:8] == b"\x89HDF\r\n\x1a\n" and len(contents) > 52
    if not is_hdf or contents[8] not in _HDF_END:
        raise ValueError("It does not begin as an HDF5 file does.")
    (end,) = struct.unpack_from("<Q", contents, _HDF_END[contents[8]])
    if end != len(contents):
        raise ValueError(f"It has {len(contents)} bytes, and says {end}.")


def _check_stl(contents: Any) -> None:
    """A binary file has 50 bytes per triangle after its header of 84; text, in any case, its last word."""
    if contents[:5].lower() == b"solid" and b"facet" in contents[:_BEGINNING].lower():
        if b"endsolid" not in contents[-_END:].lower():
            raise ValueError("It is cut short: the word endsolid is missing.")
        return
    count = struct.unpack_from("<I", contents, 80)[0] if len(contents) >= 84 else 0
    if len(contents) < 84 + 50 * count:
        raise ValueError(f"It is cut short: {count} triangles take {84 + 50 * count} bytes, it has {len(contents)}.")


# --- .obj, as of Wavefront's "Object Files (.obj)" ---

_FACE = re.compile(rb"\n[ \t]*f[ \t]([^\n]*)")
_OBJ_PARTS = {
    "point": (re.compile(rb"\n[ \t]*v[ \t]"), re.compile(rb"(?<!\S)(\d+)/")),
    "texture coordinate": (re.compile(rb"\n[ \t]*vt[ \t]"), re.compile(rb"(?<!\S)-?\d+/(\d+)")),
    "normal": (re.compile(rb"\n[ \t]*vn[ \t]"), re.compile(rb"(?<!\S)-?\d+/-?\d*/(-?\d+)")),
}


def _check_obj(contents: Any) -> None:
    """Where faces name more than points, all there is is there, and all name a normal, if there are any.

    VTK's reader makes the rest of what is in memory. Where faces name points alone, it makes nothing.
    """
    text = b"\n" + contents[:]
    corners = {*b" ".join(_FACE.findall(text)).split()}
    named = b" ".join(corners)
    for kind, (line, index) in _OBJ_PARTS.items():
        there, indices = len(line.findall(text)), index.findall(named)
        if max(map(int, indices), default=0) > there:
            raise ValueError(f"It is damaged: it has {there} {kind}s, and a face names another one.")
        if kind == "normal" and there and b"/" in named and len(indices) < len(corners):
            raise ValueError("Not all of its faces name their normals. Write it with all normals, or without any.")


# --- .ply (Turk, The PLY Polygon File Format, 1994) ---

_PLY_SIZES = {"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4, "double": 8}
_PLY_SIZES |= {"int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4, "float64": 8}
_PLY_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}


def _check_ply(contents: Any) -> None:
    """It has the lines of text, or the bytes, that its header declares."""
    end = contents.find(b"end_header", 0, 2**16)
    at = contents.find(b"\n", end) + 1
    if not contents[:3] == b"ply" or end < 0 or not at:
        raise ValueError("It has no header of a .ply file.")
    order = None
    elements: list[tuple[int, list[list[int]]]] = []  # how often each comes, and its properties' sizes, of a list two
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
                raise ValueError(f"The line {line!r} of its header says nothing.")
    if order is None:
        declared, text = sum(count for count, _ in elements), contents[at:]
        is_by_vtk = b"VTK generated" in contents[:end]  # whose lines of text all have an end
        if text.count(b"\n") + (not text.endswith(b"\n") and not is_by_vtk) < declared:
            raise ValueError(f"It is cut short: its header declares {declared} lines.")
        return
    for count, properties in elements:
        at = _end_of_element(contents, at, order, count, properties)
        if at > len(contents):
            raise ValueError("It is cut short: its header declares more.")


def _end_of_element(contents: Any, at: int, order: str, count: int, properties: list[list[int]]) -> int:
    """Where an element ends that comes `count` times from a place on; beyond the file's end if it is cut short."""
    if all(len(sizes) == 1 for sizes in properties):
        return at + count * sum(size for (size,) in properties)

    def size_at(place: int, sizes: list[int]) -> int:
        if len(sizes) == 1:
            return sizes[0]
        entries = int.from_bytes(contents[place : place + sizes[0]], "little" if order == "<" else "big")
        return sizes[0] + entries * sizes[1]

    if len(properties) == 1 and count and at < len(contents):  # one list, as the faces: most often of equal lengths
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


# --- legacy .vtk, as of "VTK File Formats" in The VTK User's Guide, 11th edition, and of version 5.1 ---

_HEADER = re.compile(rb"# vtk DataFile Version \d+\.\d+\s*\n([^\n]*)\n\s*(ASCII|BINARY)\s", re.IGNORECASE)
_WORD = re.compile(rb"\s*(\S{1,256})")
_NUMBER = rb"[-+]?(?:\d++(?:\.\d*+)?|\.\d++|nan|inf)(?:e[-+]?\d++)?"
_SIZES = {"char": 1, "short": 2, "int": 4, "long": 8, "long_long": 8}
_SIZES |= {f"unsigned_{name}": size for name, size in _SIZES.items()}
_SIZES |= {"signed_char": 1, "float": 4, "double": 8, "vtkidtype": 4, "vtktypeint64": 8, "vtktypeuint64": 8}
_COMPONENTS = {"scalars": 1, "vectors": 3, "normals": 3, "tensors": 9, "tensors6": 6}
_COMPONENTS |= {"global_ids": 1, "pedigree_ids": 1, "edge_flags": 1}


def _check_legacy(contents: Any) -> None:
    """It goes on to the end of each section that it begins."""
    header = _HEADER.match(contents)
    if header is None:
        raise ValueError("It does not begin as a legacy .vtk file does.")
    if header[1].strip() == b"vtk output" and contents[-1:] != b"\n":  # a title that only VTK's writers give
        raise ValueError("It is cut short: its last line has no end.")
    sections = _Legacy(contents, header.end(), header[2].upper() == b"BINARY")
    with suppress(_Unknown):
        while sections.next_word():
            sections.skip_section()


class _Unknown(Exception):
    """A section or a type of numbers that is not known here, of which VTK's reader will say what it thinks."""


class _Legacy:
    """A legacy file's contents, and a place that moves from each section to the next."""

    def __init__(self, contents: Any, start: int, is_binary: bool) -> None:
        self._contents, self._at, self._is_binary = contents, start, is_binary
        self._section = "dataset"
        self._tuples = 0  # of the point or cell data that come

    def skip_section(self) -> None:
        self._section = self._word().lower()
        color = "unsigned_char" if self._is_binary else "float"
        match self._section:
            case "dataset" | "dimensions" | "extent" | "origin" | "spacing" | "aspect_ratio":
                self._line()
            case "points":
                self._array(3 * self._number(), self._word())
            case "x_coordinates" | "y_coordinates" | "z_coordinates":
                self._array(self._number(), self._word())
            case "vertices" | "lines" | "polygons" | "triangle_strips" | "cells":
                first, second = self._number(), self._number()
                if self.next_word() != "offsets":
                    self._array(second, "int")
                    return
                for name, count in (("offsets", first), ("connectivity", second)):
                    if self._word().lower() != name:
                        raise self._cut_short()
                    self._array(count, self._word())
            case "cell_types":
                self._array(self._number(), "int")
            case "point_data" | "cell_data":
                self._tuples = self._number()
            case "field":
                self._word()
                for _ in range(self._number()):
                    if self._word().lower() != "null_array":
                        self._array(self._number() * self._number(), self._word())
                        if self.next_word() == "metadata":
                            self._word()
                            self._metadata()
            case "metadata":
                self._metadata()
            case "texture_coordinates":
                self._word()
                self._array(self._number() * self._tuples, self._word())
            case "color_scalars":
                self._word()
                self._array(self._number() * self._tuples, color)
            case "lookup_table":
                self._word()
                self._array(4 * self._number(), color)
            case section if section in _COMPONENTS:
                match self._line().decode("latin-1").split():
                    case [_, kind, *more]:
                        components = _COMPONENTS[section]
                    case _:
                        raise self._cut_short()
                if section == "scalars":
                    components = int(more[0]) if more and more[0].isdigit() else 1
                    if self.next_word() == "lookup_table":
                        self._line()
                self._array(components * self._tuples, kind, is_on_next_line=False)
            case _:
                raise _Unknown

    def _metadata(self) -> None:
        """It ends with an empty line."""
        self._line()
        while self._line().strip():
            pass

    def _array(self, count: int, kind: str, *, is_on_next_line: bool = True) -> None:
        kind = kind.lower()
        if is_on_next_line:
            self._line()
        if kind in ("string", "utf8_string"):
            for _ in range(count):
                if self._is_binary:  # behind its length, in which the first two bits say how long that is
                    self._skip(1)
                    first = self._contents[self._at - 1]
                    width = {3: 0, 2: 1, 1: 3, 0: 7}[first >> 6]
                    rest = self._contents[self._at : self._at + width]
                    self._skip(width + ((first & 63) << 8 * width | int.from_bytes(rest, "big")))
                elif not self._line():
                    raise self._cut_short()
        elif kind not in _SIZES and kind != "bit":
            raise _Unknown
        elif self._is_binary:
            self._skip((count + 7) // 8 if kind == "bit" else count * _SIZES[kind])
        elif 2 * count > len(self._contents) - self._at + 1:  # a digit and a space each
            raise self._cut_short()
        else:
            numbers = re.compile(rb"(?:\s*+(?>%b)(?!\S)){%d}+" % (_NUMBER, count), re.IGNORECASE)
            found = numbers.match(self._contents, self._at)
            if found is None:
                raise self._cut_short()
            self._at = found.end()

    def _skip(self, size: int) -> None:
        self._at += size
        if self._at > len(self._contents):
            raise self._cut_short()

    def next_word(self) -> str:
        """The next word in small letters, "" at the end; the place stays."""
        found = _WORD.match(self._contents, self._at)
        return "" if found is None else found[1].decode("latin-1").lower()

    def _word(self) -> str:
        found = _WORD.match(self._contents, self._at)
        if found is None:
            raise self._cut_short()
        self._at = found.end()
        return found[1].decode("latin-1")

    def _number(self) -> int:
        word = self._word()
        if not word.isdigit():
            raise self._cut_short()
        return int(word)

    def _line(self) -> bytes:
        """What is left of this line, with its end."""
        end = self._contents.find(b"\n", self._at) + 1 or len(self._contents)
        line: bytes = self._contents[self._at : end]
        self._at = end
        return line

    def _cut_short(self) -> ValueError:
        return ValueError(f"It is cut short or damaged in its section {self._section.upper()}.")


_CHECKS: dict[str, Callable[[Any], None]] = {
    **dict.fromkeys((".vtp", ".vtu", ".vtm", ".vtmb"), _check_xml),
    **dict.fromkeys((".vts", ".vtr", ".vti"), _check_xml_grid),
    ".vtkhdf": _check_hdf,
    ".stl": _check_stl,
    ".obj": _check_obj,
    ".ply": _check_ply,
    ".vtk": _check_legacy,
}
