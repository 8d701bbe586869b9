"""Whether the arrays in a VTK XML file have all the bytes that they declare.

Where they have fewer, VTK's readers leave the rest of an array as it was in memory, and say nothing. What compressed
bytes hold is not looked at: they carry a checksum, which VTK's readers check. The layout is that of "VTK XML Formats"
in VTK's documentation: a number of bytes before the data, or numbers of blocks and their sizes where it is compressed.
"""

from __future__ import annotations

import binascii
import re
from typing import Any

_FILE = re.compile(rb"<VTKFile\b[^>]*>")
_ARRAY = re.compile(rb"<(?:Data)?Array\b[^>]*>")
_APPENDED = re.compile(rb"<AppendedData\b[^>]*>\s*_")
_BEGINNING = 4096
_SPACE = b" \t\r\n"


def refuse_short(contents: Any) -> None:
    """Raise ``ValueError`` if an array in an XML file, as a `mmap.mmap`, is shorter than it says."""
    head = _FILE.search(contents, 0, _BEGINNING)
    if head is None:
        raise ValueError("It does not begin as an XML file of VTK's does.")
    order = "big" if b"BigEndian" in head[0] else "little"
    width = 8 if b"UInt64" in head[0] else 4
    compressed = b"compressor=" in head[0]
    appended = _APPENDED.search(contents)
    for found in _ARRAY.finditer(contents, 0, appended.start() if appended else len(contents)):
        kind = _attribute(found[0], b"format")
        if kind == b"binary":
            text = contents[found.end() : contents.find(b"<", found.end())]
            _refuse(_Encoded(text.translate(None, _SPACE)), order, width, compressed)
        elif kind == b"appended" and appended is not None and b"raw" in appended[0]:
            offset = _attribute(found[0], b"offset")
            if not offset.isdigit():
                raise ValueError("An array has no place in its appended data.")
            end = contents.rfind(b"</AppendedData")
            _refuse(_Raw(contents, appended.end() + int(offset), end), order, width, compressed)


def _attribute(tag: bytes, name: bytes) -> bytes:
    found = re.search(rb"\b" + name + rb"""\s*=\s*["']([^"']*)["']""", tag)
    return b"" if found is None else found[1]


def _refuse(data: Any, order: Any, width: int, compressed: bool) -> None:
    def number(index: int) -> int:
        return int.from_bytes(header[index * width : (index + 1) * width], order)

    if not data.is_empty:
        header = data.header(width)
        if not compressed:
            data.check(width, number(0))
        elif number(0):
            blocks = number(0)
            header = data.header((3 + blocks) * width)
            data.check(len(header), sum(number(3 + block) for block in range(blocks)), apart=True)


def _too_short() -> ValueError:
    return ValueError("It is damaged: an array has fewer bytes than it says.")


class _Raw:
    """Bytes as they are."""

    def __init__(self, contents: Any, start: int, end: int) -> None:
        self._contents, self._start, self._end = contents, start, end
        self.is_empty = False

    def header(self, size: int) -> bytes:
        self.check(size, 0)
        found: bytes = self._contents[self._start : self._start + size]
        return found

    def check(self, header: int, size: int, *, apart: bool = True) -> None:  # noqa: ARG002  # alike for raw bytes
        if self._start + header + size > self._end:
            raise _too_short()


class _Encoded:
    """Bytes in base64: a header with the data behind it, or apart from it."""

    def __init__(self, text: bytes) -> None:
        self._text = text
        self.is_empty = not text

    def header(self, size: int) -> bytes:
        if _encoded(size) > len(self._text):
            raise _too_short()
        try:
            return binascii.a2b_base64(self._text[: _encoded(size)])[:size]
        except binascii.Error as error:
            raise _too_short() from error

    def check(self, header: int, size: int, *, apart: bool = False) -> None:
        start = _encoded(header)
        separate = _decoded(self._text[start : start + _encoded(size)]) == size
        if not separate and (apart or _decoded(self._text[: _encoded(header + size)]) != header + size):
            raise _too_short()


def _encoded(size: int) -> int:
    return (size + 2) // 3 * 4


def _decoded(text: bytes) -> int:
    """How many bytes a text stands for; -1 if it is none."""
    try:
        return len(binascii.a2b_base64(text, strict_mode=True))
    except binascii.Error:
        return -1
