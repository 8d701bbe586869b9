"""Whether a legacy .vtk file holds all that it declares.

VTK's reader takes a file that is cut short within its point data for whole, with whatever was in memory for the rest
(9.5, 9.6). The sections are those of "VTK File Formats" in The VTK User's Guide, 11th edition, and of version 5.1.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

_HEADER = re.compile(rb"# vtk DataFile Version \d+\.\d+\s*\n([^\n]*)\n\s*(ASCII|BINARY)\s", re.IGNORECASE)
_SIZES = {"char": 1, "short": 2, "int": 4, "long": 8, "long_long": 8}
_SIZES |= {f"unsigned_{name}": size for name, size in _SIZES.items()}
_SIZES |= {"signed_char": 1, "float": 4, "double": 8, "vtkidtype": 4, "vtktypeint64": 8, "vtktypeuint64": 8}
_TEXTS = ("string", "utf8_string")
_TUPLES = {"scalars": 1, "vectors": 3, "normals": 3, "tensors": 9, "tensors6": 6}
_TUPLES |= {"global_ids": 1, "pedigree_ids": 1, "edge_flags": 1}
_CELLS = ("vertices", "lines", "polygons", "triangle_strips", "cells")
_AXES = ("x_coordinates", "y_coordinates", "z_coordinates")
_MADE_BY_VTK = b"vtk output"  # a title that only its writers give; all their lines have an end
_CHUNK = 2**20  # bytes of text that are looked at together


def refuse_parts(contents: Any) -> None:
    """Raise ``ValueError`` if the contents of a legacy file, as a `mmap.mmap`, end too early."""
    header = _HEADER.match(contents)
    if header is None:
        raise ValueError("It does not begin as a legacy .vtk file does.")
    if header[1].strip() == _MADE_BY_VTK and contents[-1:] != b"\n":
        raise ValueError("It is cut short: its last line has no end.")
    _Walk(contents, header.end(), header[2].upper() == b"BINARY").walk()


class _CutShort(ValueError):
    """The file ends within something that it has declared."""

    def __init__(self, section: str) -> None:
        super().__init__(f"It is cut short or damaged in its section {section.upper()}.")


class _Unknown(Exception):
    """A section or a type of numbers that is not known here."""


class _Walk:
    """A way through the sections of a file, from each to the next."""

    def __init__(self, contents: Any, start: int, is_binary: bool) -> None:
        self._contents, self._at, self._is_binary = contents, start, is_binary
        self._section = "dataset"
        self._tuples = 0  # of the point or cell data that come

    def walk(self) -> None:
        """To the end, or to a section that is not known here, of which VTK's reader will say what it thinks."""
        with suppress(_Unknown):
            while self._peek():
                self._section = self._word().lower()
                self._step()()

    def _step(self) -> Callable[[], object]:
        section = self._section
        if section == "points":
            return lambda: self._array(3 * self._number(), self._word())
        if section in _AXES:
            return lambda: self._array(self._number(), self._word())
        if section in _CELLS:
            return self._cells
        if section in _TUPLES:
            return self._attribute
        steps: dict[str, Callable[[], object]] = {
            "dataset": self._line,
            "dimensions": self._line,
            "extent": self._line,
            "origin": self._line,
            "spacing": self._line,
            "aspect_ratio": self._line,
            "cell_types": lambda: self._array(self._number(), "int"),
            "point_data": self._begin_data,
            "cell_data": self._begin_data,
            "field": self._field,
            "metadata": self._metadata,
            "texture_coordinates": self._texture_coordinates,
            "color_scalars": self._color_scalars,
            "lookup_table": self._lookup_table,
        }
        if section not in steps:
            raise _Unknown
        return steps[section]

    # --- sections ---

    def _begin_data(self) -> None:
        self._tuples = self._number()

    def _cells(self) -> None:
        first, second = self._number(), self._number()
        if self._peek().lower() != "offsets":
            self._array(second, "int")
            return
        for name, count in (("offsets", first), ("connectivity", second)):
            if self._word().lower() != name:
                raise _CutShort(self._section)
            self._array(count, self._word())

    def _attribute(self) -> None:
        _, kind, *more = self._words_of_line(2)
        components = _TUPLES[self._section]
        if self._section == "scalars":
            components = int(more[0]) if more and more[0].isdigit() else 1
            if self._peek().lower() == "lookup_table":
                self._line()
        self._array(components * self._tuples, kind, on_next_line=False)

    def _texture_coordinates(self) -> None:
        self._word()
        self._array(self._number() * self._tuples, self._word())

    def _color_scalars(self) -> None:
        self._word()
        self._array(self._number() * self._tuples, "unsigned_char" if self._is_binary else "float")

    def _lookup_table(self) -> None:
        self._word()
        self._array(4 * self._number(), "unsigned_char" if self._is_binary else "float")

    def _field(self) -> None:
        self._word()
        for _ in range(self._number()):
            if self._word().lower() == "null_array":
                continue
            components, tuples = self._number(), self._number()
            self._array(components * tuples, self._word())
            if self._peek().lower() == "metadata":
                self._word()
                self._metadata()

    def _metadata(self) -> None:
        """It ends with an empty line."""
        self._line()
        while self._line().strip():
            pass

    # --- arrays ---

    def _array(self, count: int, kind: str, *, on_next_line: bool = True) -> None:
        kind = kind.lower()
        if on_next_line:
            self._line()
        if kind in _TEXTS:
            self._strings(count)
        elif kind not in _SIZES and kind != "bit":
            raise _Unknown
        elif self._is_binary:
            self._skip((count + 7) // 8 if kind == "bit" else count * _SIZES[kind])
        else:
            self._skip_numbers(count)

    def _skip(self, size: int) -> None:
        self._at += size
        if self._at > len(self._contents):
            raise _CutShort(self._section)

    def _strings(self, count: int) -> None:
        """Lines of text; or each behind its length, in which the first two bits say how long that is."""
        for _ in range(count):
            if self._is_binary:
                self._skip(1)
                first = self._contents[self._at - 1]
                width = {3: 0, 2: 1, 1: 3, 0: 7}[first >> 6]
                rest = self._contents[self._at : self._at + width]
                self._skip(width + ((first & 63) << 8 * width | int.from_bytes(rest, "big")))
            elif not self._line():
                raise _CutShort(self._section)

    def _skip_numbers(self, count: int) -> None:
        """Numbers in text, each of which can be read."""
        while count:
            chunk = self._contents[self._at : self._at + _CHUNK]
            if len(chunk) < _CHUNK:
                chunk += b"\n"  # hands may leave it out at the end
            cut = max(chunk.rfind(space) for space in (b" ", b"\n", b"\t", b"\r")) + 1
            text = np.frombuffer(chunk[:cut], np.uint8)
            is_space = (text == 32) | ((text >= 9) & (text <= 13))
            ends = np.flatnonzero(is_space[1:] & ~is_space[:-1]) + 1  # of words
            if not len(ends):
                raise _CutShort(self._section)
            ends = ends[:count]
            if _numbers_in(chunk[: ends[-1]]) != len(ends):
                raise _CutShort(self._section)
            self._at += int(ends[-1])
            count -= len(ends)

    # --- words ---

    def _peek(self) -> str:
        """The next word, "" at the end."""
        at = self._at
        word = self._word(needed=False)
        self._at = at
        return word

    def _word(self, *, needed: bool = True) -> str:
        found = re.compile(rb"\s*(\S{1,256})").match(self._contents, self._at)
        if found is None:
            if needed:
                raise _CutShort(self._section)
            return ""
        self._at = found.end()
        return found[1].decode("latin-1")

    def _number(self) -> int:
        word = self._word()
        if not word.isdigit():
            raise _CutShort(self._section)
        return int(word)

    def _line(self) -> bytes:
        """What is left of this line, with its end."""
        end = self._contents.find(b"\n", self._at) + 1 or len(self._contents)
        line: bytes = self._contents[self._at : end]
        self._at = end
        return line

    def _words_of_line(self, least: int) -> list[str]:
        words = self._line().decode("latin-1").split()
        if len(words) < least:
            raise _CutShort(self._section)
        return words


def _numbers_in(text: bytes) -> int:
    """How many numbers a text consists of; -1 if there is anything else in it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # older versions of NumPy only warn
        try:
            return len(np.fromstring(text, sep=" "))
        except (ValueError, DeprecationWarning):
            return -1
