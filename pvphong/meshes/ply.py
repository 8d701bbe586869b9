"""Whether a .ply file holds all that its header declares (Turk, The PLY Polygon File Format, 1994)."""

from __future__ import annotations

from typing import Any

import numpy as np

_SIZES = {"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4, "double": 8}
_SIZES |= {"int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4, "float64": 8}
_LONGEST_HEADER = 2**16
_MADE_BY_VTK = b"VTK generated"  # whose lines of text all have an end

Property = tuple[str, ...]
"""The words of its line, without "property"."""


def refuse_parts(contents: Any) -> None:
    """Raise ``ValueError`` if the contents of a .ply file, as a `mmap.mmap`, end too early."""
    end = contents.find(b"end_header", 0, _LONGEST_HEADER)
    start = contents.find(b"\n", end) + 1
    if not contents[:3] == b"ply" or end < 0 or not start:
        raise ValueError("It has no header of a .ply file.")
    order, elements = _header(contents[:end].decode("ascii", "replace"))
    if order is None:
        declared, text = sum(count for count, _ in elements), contents[start:]
        lines = text.count(b"\n") + (not text.endswith(b"\n") and _MADE_BY_VTK not in contents[:end])
        if lines < declared:
            raise ValueError(f"It is cut short: its header declares {declared} lines.")
        return
    for count, properties in elements:
        start = _after(contents, start, order, count, properties)
        if start > len(contents):
            raise ValueError("It is cut short: its header declares more.")


def _header(text: str) -> tuple[str | None, list[tuple[int, list[Property]]]]:
    """The order of bytes, None for text; and of each element how often it comes and its properties."""
    order: str | None = None
    elements: list[tuple[int, list[Property]]] = []
    for line in text.splitlines():
        match line.split():
            case ["format", kind, *_]:
                order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(kind)
            case ["element", _, count] if count.isdigit():
                elements.append((int(count), []))
            case ["property", "list", of_count, of_entry, name] if elements and {of_count, of_entry} <= set(_SIZES):
                elements[-1][1].append(("list", of_count, of_entry, name))
            case ["property", kind, name] if elements and kind in _SIZES:
                elements[-1][1].append((kind, name))
            case ["ply"] | ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise ValueError(f"The line {line!r} of its header says nothing.")
    return order, elements


def _after(contents: Any, start: int, order: str, count: int, properties: list[Property]) -> int:
    """Where an element ends that comes `count` times; beyond the file's end if it is cut short."""
    lists = [words for words in properties if words[0] == "list"]
    if not lists:
        return start + count * sum(_SIZES[words[0]] for words in properties)
    stride = _stride_of_equals(contents, start, order, count, properties) if len(properties) == 1 else None
    if stride is not None:
        return start + count * stride
    for _ in range(count):
        for words in properties:
            if start >= len(contents):
                return start + 1
            start += _size(contents, start, order, words)
    return start


def _stride_of_equals(contents: Any, start: int, order: str, count: int, properties: list[Property]) -> int | None:
    """Of an element that is one list, the bytes of each if all have the same length; else None."""
    ((_, of_count, *_),) = properties
    if not count or start >= len(contents):
        return 0 if not count else None
    stride = _size(contents, start, order, properties[0])
    whole = min(count, (len(contents) - start) // stride)
    form: Any = {"names": ["count"], "formats": [f"{order}u{_SIZES[of_count]}"], "offsets": [0], "itemsize": stride}
    counts = np.frombuffer(contents[start : start + whole * stride], np.dtype(form))["count"]
    return stride if (counts == counts[:1]).all() else None


def _size(contents: Any, start: int, order: str, words: Property) -> int:
    if words[0] != "list":
        return _SIZES[words[0]]
    width = _SIZES[words[1]]
    length = int.from_bytes(contents[start : start + width], "little" if order == "<" else "big")
    return width + length * _SIZES[words[2]]
