"""What a lit file was made from: a small file beside it says so, by which the next run knows that it is done."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pvphong.base.files import write_json
from pvphong.batch.indices import Declared


@dataclass(frozen=True)
class Receipt:
    """What a lit file was made from.

    Attributes
    ----------
    input : str
        Checksum of the file, or of all pieces of a surface across which normals were merged.
    rig : str
        That of the scene, the material and the options.
    version : str
        Of pvphong.
    run : str
        Names the call that made it.
    output : str
        Checksum of the lit file.
    arrays : tuple of Declared
        What it has, for an index.
    """

    input: str
    rig: str
    version: str
    run: str
    output: str
    arrays: tuple[Declared, ...]


def own_version() -> str:
    """That of pvphong."""
    return version("pvphong")


def checksum(path: Path) -> str:
    """Of a file's contents, SHA-256."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def checksum_of(value: Any) -> str:
    """Of plain values and of dataclasses of such, whose classes count too."""
    return hashlib.sha256(json.dumps(_plain(value)).encode()).hexdigest()


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return [type(value).__name__, {field.name: _plain(getattr(value, field.name)) for field in fields(value)}]
    if isinstance(value, Mapping):
        return sorted((str(key), _plain(entry)) for key, entry in value.items())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(entry) for entry in value]
    return value if isinstance(value, (str, int, float, type(None))) else repr(value)


def beside(output: Path) -> Path:
    """Where a lit file's receipt is."""
    return output.with_name(f".{output.name}.json")


def write(receipt: Receipt, output: Path) -> None:
    """Put it beside the lit file."""
    write_json(vars(receipt), beside(output))


def standing(output: Path, made_from: str, rig: str) -> Receipt | None:
    """The receipt of a lit file that need not be made again: it is there as it was written, from just that."""
    with suppress(OSError, ValueError, TypeError):
        told = json.loads(beside(output).read_text(encoding="utf-8"))
        found = Receipt(**told | {"arrays": tuple(Declared(*array) for array in told["arrays"])})
        is_of_this = (found.input, found.rig, found.version) == (made_from, rig, own_version())
        if is_of_this and found.output == checksum(output):
            return found
    return None
