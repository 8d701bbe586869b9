"""Whether a mesh file is whole, by what it says of its own length, before VTK reads it and after VTK wrote it.

VTK's readers take what is left of many files that were cut short, with whatever was in memory for the rest, and some
of its writers do not notice that a disk is full. A file that is cut where a shorter one could end, as between the lines
of an .obj file, is a whole one as far as anybody can know.

In order: XML files of VTK's, HDF5, .stl, .ply, legacy .vtk. Contents are a `mmap.mmap`, of which slices are bytes.
"""

from __future__ import annotations

import binascii
import html
import math
import mmap
import re
import struct
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

_BEGINNING = _END = 4096  # bytes in which the tags at an XML file's beginning and end are looked for


def refuse_parts(path: Path) -> None:
    """Raise ``ValueError`` for a file that is not there to its end; formats that do not tell are passed over.

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
                refuse_parts(other)
        except ValueError as error:
            raise ValueError(f"Its block {other.name}: {error}") from error


# --- VTK's XML files, as of "VTK XML Formats" in VTK's documentation ---

_WITH_BLOCKS = (".vtm", ".vtmb")
_FILE = re.compile(rb"<VTKFile\b[^>]*>")
_ARRAY = re.compile(rb"<(?:Data)?Array\b[^>]*>")
_APPENDED = re.compile(rb"<AppendedData\b[^>]*>\s*_")
_BLOCK = re.compile(rb"""<DataSet\b[^>]*?\bfile\s*=\s*["']([^"']+)["']""")
_WHOLE_EXTENT = re.compile(rb"""\bWholeExtent\s*=\s*["']([^"']*)["']""")
_PIECE_EXTENT = re.compile(rb"""<Piece\b[^>]*?\bExtent\s*=\s*["']([^"']*)["']""")


def _check_xml(contents: Any) -> None:
    """It ends with its tag, and its arrays have all the bytes that they declare.

    Before an array's data stands their number of bytes; or, where they are compressed, a number of blocks, two sizes of
    blocks and each block's compressed size. What compressed bytes hold is not looked at: VTK checks their checksum.
    """
    if b"</VTKFile>" not in contents[-_END:]:
        raise ValueError("It is cut short: the end tag </VTKFile> is missing.")
    head = _FILE.search(contents, 0, _BEGINNING)
    if head is None:
        raise ValueError("It does not begin as an XML file of VTK's does.")
    order: Any = "big" if b"BigEndian" in head[0] else "little"
    width = 8 if b"UInt64" in head[0] else 4
    is_compressed = b"compressor=" in head[0]
    appended = _APPENDED.search(contents)
    for found in _ARRAY.finditer(contents, 0, appended.start() if appended else len(contents)):
        kind = _attribute(found[0], b"format")
        if kind == b"binary":
            text = contents[found.end() : contents.find(b"<", found.end())].translate(None, b" \t\r\n")
            array: _Raw | _Base64 = _Base64(text)
            if not text:
                continue
        elif kind == b"appended" and appended is not None and b"raw" in appended[0]:
            offset = _attribute(found[0], b"offset")
            if not offset.isdigit():
                raise ValueError("An array has no place in its appended data.")
            array = _Raw(contents, appended.end() + int(offset), contents.rfind(b"</AppendedData"))
        else:
            continue
        header = array.header(width)
        size = int.from_bytes(header, order)
        if is_compressed:
            if not size:
                continue
            header = array.header((3 + size) * width)
            size = sum(int.from_bytes(header[at : at + width], order) for at in range(3 * width, len(header), width))
        if not array.holds(len(header), size, is_apart=is_compressed):
            raise ValueError(_TOO_SHORT)


_TOO_SHORT = "It is damaged: an array has fewer bytes than it says."


def _attribute(tag: bytes, name: bytes) -> bytes:
    found = re.search(rb"\b" + name + rb"""\s*=\s*["']([^"']*)["']""", tag)
    return b"" if found is None else found[1]


class _Raw:
    """An array's header and data as bytes."""

    def __init__(self, contents: Any, start: int, end: int) -> None:
        self._contents, self._start, self._end = contents, start, end

    def header(self, size: int) -> bytes:
        if not self.holds(size, 0):
            raise ValueError(_TOO_SHORT)
        found: bytes = self._contents[self._start : self._start + size]
        return found

    def holds(self, header: int, size: int, *, is_apart: bool = True) -> bool:  # noqa: ARG002  # raw bytes always are
        return self._start + header + size <= self._end


class _Base64:
    """An array's header and data in base64: one text, or each a text of its own."""

    def __init__(self, text: bytes) -> None:
        self._text = text

    def header(self, size: int) -> bytes:
        if _encoded_size(size) > len(self._text):
            raise ValueError(_TOO_SHORT)
        try:
            return binascii.a2b_base64(self._text[: _encoded_size(size)])[:size]
        except binascii.Error as error:
            raise ValueError(_TOO_SHORT) from error

    def holds(self, header: int, size: int, *, is_apart: bool) -> bool:
        start = _encoded_size(header)
        if _decoded_size(self._text[start : start + _encoded_size(size)]) == size:
            return True
        return not is_apart and _decoded_size(self._text[: _encoded_size(header + size)]) == header + size


def _encoded_size(size: int) -> int:
    return (size + 2) // 3 * 4


def _decoded_size(text: bytes) -> int:
    """How many bytes a text in base64 stands for; -1 if it is none."""
    try:
        return len(binascii.a2b_base64(text, strict_mode=True))
    except binascii.Error:
        return -1


def _check_xml_grid(contents: Any) -> None:
    """Its pieces fill it, too; what none of them fills VTK's readers leave as it was in memory."""
    _check_xml(contents)
    data = contents.find(b"<AppendedData")
    whole = _WHOLE_EXTENT.search(contents, 0, _BEGINNING)
    pieces = _PIECE_EXTENT.finditer(contents, 0, data if data > 0 else len(contents))
    if whole is None or _cells_in(whole[1]) != sum(_cells_in(found[1]) for found in pieces):
        raise ValueError("Its pieces do not fill its WholeExtent.")


def _cells_in(extent: bytes) -> float:
    """Of a grid from a first to a last place along each axis; an axis with one place counts as one cell."""
    try:
        a, b, c, d, e, f = map(int, extent.split())
    except ValueError:
        return math.nan
    return math.prod(max(last - first, 1) for first, last in ((a, b), (c, d), (e, f)))


# --- HDF5 and .stl ---

_HDF_END = {0: 40, 1: 44, 2: 28, 3: 28}  # where the superblock of each version has the address of the file's end


def _check_hdf(contents: Any) -> None:
    """By the "end of file address" of the superblock (HDF5 File Format Specification 3.0, II.A)."""
    is_hdf = contents[:8] == b"\x89HDF\r\n\x1a\n" and len(contents) > 52
    if not is_hdf or contents[8] not in _HDF_END:
        raise ValueError("It does not begin as an HDF5 file does.")
    (end,) = struct.unpack_from("<Q", contents, _HDF_END[contents[8]])
    if end != len(contents):
        raise ValueError(f"It has {len(contents)} bytes, and says {end}.")


def _check_stl(contents: Any) -> None:
    """A binary file has 50 bytes per triangle after its header of 84; text ends with a word."""
    if contents[:5] == b"solid" and b"facet" in contents[:_BEGINNING]:
        if b"endsolid" not in contents[-_END:]:
            raise ValueError("It is cut short: the word endsolid is missing.")
        return
    count = struct.unpack_from("<I", contents, 80)[0] if len(contents) >= 84 else 0
    if len(contents) < 84 + 50 * count:
        raise ValueError(f"It is cut short: {count} triangles take {84 + 50 * count} bytes, it has {len(contents)}.")


# --- .ply (Turk, The PLY Polygon File Format, 1994) ---

_PLY_SIZES = {"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4, "double": 8}
_PLY_SIZES |= {"int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4, "float64": 8}


def _check_ply(contents: Any) -> None:
    """It has the lines of text, or the bytes, that its header declares."""
    end = contents.find(b"end_header", 0, 2**16)
    start = contents.find(b"\n", end) + 1
    if not contents[:3] == b"ply" or end < 0 or not start:
        raise ValueError("It has no header of a .ply file.")
    order, elements = _ply_header(contents[:end].decode("ascii", "replace"))
    if order is None:
        declared, text = sum(count for count, _ in elements), contents[start:]
        is_by_vtk = b"VTK generated" in contents[:end]  # whose lines of text all have an end
        if text.count(b"\n") + (not text.endswith(b"\n") and not is_by_vtk) < declared:
            raise ValueError(f"It is cut short: its header declares {declared} lines.")
        return
    for count, properties in elements:
        start = _end_of_element(contents, start, order, count, properties)
        if start > len(contents):
            raise ValueError("It is cut short: its header declares more.")


def _ply_header(text: str) -> tuple[Any, list[tuple[int, list[list[str]]]]]:
    """The order of bytes, None for text; and of each element how often it comes and its properties, in words."""
    order = None
    elements: list[tuple[int, list[list[str]]]] = []
    for line in text.splitlines():
        match line.split():
            case ["format", kind, *_]:
                order = {"binary_little_endian": "little", "binary_big_endian": "big"}.get(kind)
            case ["element", _, count] if count.isdigit():
                elements.append((int(count), []))
            case ["property", "list", of_count, of_entry, _] if elements and {of_count, of_entry} <= set(_PLY_SIZES):
                elements[-1][1].append(["list", of_count, of_entry])
            case ["property", kind, _] if elements and kind in _PLY_SIZES:
                elements[-1][1].append([kind])
            case ["ply"] | ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise ValueError(f"The line {line!r} of its header says nothing.")
    return order, elements


def _end_of_element(contents: Any, start: int, order: Any, count: int, properties: list[list[str]]) -> int:
    """Where an element ends that comes `count` times; beyond the file's end if it is cut short."""

    def size_at(place: int, words: list[str]) -> int:
        if words[0] != "list":
            return _PLY_SIZES[words[0]]
        width = _PLY_SIZES[words[1]]
        return width + int.from_bytes(contents[place : place + width], order) * _PLY_SIZES[words[2]]

    if not any(words[0] == "list" for words in properties):
        return start + count * sum(size_at(start, words) for words in properties)
    if len(properties) == 1 and count and start < len(contents):  # one list, as the faces: most often of equal lengths
        stride = size_at(start, properties[0])
        whole = min(count, (len(contents) - start) // stride)
        kind = f"{'<' if order == 'little' else '>'}u{_PLY_SIZES[properties[0][1]]}"
        form: Any = {"names": ["count"], "formats": [kind], "offsets": [0], "itemsize": stride}
        counts = np.frombuffer(contents[start : start + whole * stride], np.dtype(form))["count"]
        if (counts == counts[:1]).all():
            return start + count * stride
    for _ in range(count):
        for words in properties:
            if start >= len(contents):
                return start + 1
            start += size_at(start, words)
    return start


# --- legacy .vtk, as of "VTK File Formats" in The VTK User's Guide, 11th edition, and of version 5.1 ---

_HEADER = re.compile(rb"# vtk DataFile Version \d+\.\d+\s*\n([^\n]*)\n\s*(ASCII|BINARY)\s", re.IGNORECASE)
_WORD = re.compile(rb"\s*(\S{1,256})")
_SIZES = {"char": 1, "short": 2, "int": 4, "long": 8, "long_long": 8}
_SIZES |= {f"unsigned_{name}": size for name, size in _SIZES.items()}
_SIZES |= {"signed_char": 1, "float": 4, "double": 8, "vtkidtype": 4, "vtktypeint64": 8, "vtktypeuint64": 8}
_COMPONENTS = {"scalars": 1, "vectors": 3, "normals": 3, "tensors": 9, "tensors6": 6}
_COMPONENTS |= {"global_ids": 1, "pedigree_ids": 1, "edge_flags": 1}
_CHUNK = 2**20  # bytes of text that are looked at together


def _check_legacy(contents: Any) -> None:
    """It goes on to the end of each section that it begins."""
    header = _HEADER.match(contents)
    if header is None:
        raise ValueError("It does not begin as a legacy .vtk file does.")
    if header[1].strip() == b"vtk output" and contents[-1:] != b"\n":  # a title that only VTK's writers give
        raise ValueError("It is cut short: its last line has no end.")
    with suppress(_Unknown):
        _Legacy(contents, header.end(), header[2].upper() == b"BINARY").skip_sections()


class _Unknown(Exception):
    """A section or a type of numbers that is not known here, of which VTK's reader will say what it thinks."""


class _Legacy:
    """A legacy file's contents, and a place that moves from each section to the next."""

    def __init__(self, contents: Any, start: int, is_binary: bool) -> None:
        self._contents, self._at, self._is_binary = contents, start, is_binary
        self._section = "dataset"
        self._tuples = 0  # of the point or cell data that come

    def skip_sections(self) -> None:
        while self._next_word():
            self._section = self._word().lower()
            match self._section:
                case "dataset" | "dimensions" | "extent" | "origin" | "spacing" | "aspect_ratio":
                    self._line()
                case "points":
                    self._array(3 * self._number(), self._word())
                case "x_coordinates" | "y_coordinates" | "z_coordinates":
                    self._array(self._number(), self._word())
                case "vertices" | "lines" | "polygons" | "triangle_strips" | "cells":
                    self._cells()
                case "cell_types":
                    self._array(self._number(), "int")
                case "point_data" | "cell_data":
                    self._tuples = self._number()
                case "field":
                    self._field()
                case "metadata":
                    self._metadata()
                case "texture_coordinates":
                    self._word()
                    self._array(self._number() * self._tuples, self._word())
                case "color_scalars":
                    self._word()
                    self._array(self._number() * self._tuples, "unsigned_char" if self._is_binary else "float")
                case "lookup_table":
                    self._word()
                    self._array(4 * self._number(), "unsigned_char" if self._is_binary else "float")
                case section if section in _COMPONENTS:
                    self._attribute(_COMPONENTS[section])
                case _:
                    raise _Unknown

    def _cells(self) -> None:
        first, second = self._number(), self._number()
        if self._next_word() != "offsets":
            self._array(second, "int")
            return
        for name, count in (("offsets", first), ("connectivity", second)):
            if self._word().lower() != name:
                raise self._cut_short()
            self._array(count, self._word())

    def _attribute(self, components: int) -> None:
        words = self._line().decode("latin-1").split()
        if len(words) < 2:
            raise self._cut_short()
        if self._section == "scalars":
            components = int(words[2]) if words[2:] and words[2].isdigit() else 1
            if self._next_word() == "lookup_table":
                self._line()
        self._array(components * self._tuples, words[1], is_on_next_line=False)

    def _field(self) -> None:
        self._word()
        for _ in range(self._number()):
            if self._word().lower() == "null_array":
                continue
            components, tuples = self._number(), self._number()
            self._array(components * tuples, self._word())
            if self._next_word() == "metadata":
                self._word()
                self._metadata()

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
                self._string()
        elif kind not in _SIZES and kind != "bit":
            raise _Unknown
        elif self._is_binary:
            self._skip((count + 7) // 8 if kind == "bit" else count * _SIZES[kind])
        else:
            self._skip_numbers(count)

    def _string(self) -> None:
        """A line of text; or text behind its length, in which the first two bits say how long that is."""
        if self._is_binary:
            self._skip(1)
            first = self._contents[self._at - 1]
            width = {3: 0, 2: 1, 1: 3, 0: 7}[first >> 6]
            rest = self._contents[self._at : self._at + width]
            self._skip(width + ((first & 63) << 8 * width | int.from_bytes(rest, "big")))
        elif not self._line():
            raise self._cut_short()

    def _skip(self, size: int) -> None:
        self._at += size
        if self._at > len(self._contents):
            raise self._cut_short()

    def _skip_numbers(self, count: int) -> None:
        """Numbers in text, each of which can be read."""
        while count:
            chunk = self._contents[self._at : self._at + _CHUNK]
            if len(chunk) < _CHUNK:
                chunk += b"\n"  # hands may leave it out at the end
            cut = max(chunk.rfind(space) for space in (b" ", b"\n", b"\t", b"\r")) + 1
            text = np.frombuffer(chunk[:cut], np.uint8)
            is_space = (text == 32) | ((text >= 9) & (text <= 13))
            ends = (np.flatnonzero(is_space[1:] & ~is_space[:-1]) + 1)[:count]  # of words
            if not len(ends) or _numbers_in(chunk[: ends[-1]]) != len(ends):
                raise self._cut_short()
            self._at += int(ends[-1])
            count -= len(ends)

    def _next_word(self) -> str:
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


def _numbers_in(text: bytes) -> int:
    """How many numbers a text consists of; -1 if there is anything else in it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # older versions of NumPy only warn
        try:
            return len(np.fromstring(text, sep=" "))
        except (ValueError, DeprecationWarning):
            return -1


_CHECKS: dict[str, Callable[[Any], None]] = {
    **dict.fromkeys((".vtp", ".vtu", ".vtm", ".vtmb"), _check_xml),
    **dict.fromkeys((".vts", ".vtr", ".vti"), _check_xml_grid),
    ".vtkhdf": _check_hdf,
    ".stl": _check_stl,
    ".ply": _check_ply,
    ".vtk": _check_legacy,
}
