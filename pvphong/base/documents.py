"""Reading of JSON files, and checks of their values.

The argument `place` is the position of a value in its file, such as "lights[2]". Error messages contain it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, TypeVar

from pvphong.base import check

Kind = TypeVar("Kind")


def read(path: str | os.PathLike[str], what: str) -> Any:
    """Return the content of a JSON file.

    Raises
    ------
    ValueError
        If the file cannot be read or is not JSON. The message names the expected kind of file, `what`, such as "a
        scene file".
    """
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"path must be {what} that can be read; got {os.fspath(path)} ({error}).") from error
    except ValueError as error:  # not UTF-8, or not JSON
        raise ValueError(f"path must be {what} in JSON; got {os.fspath(path)} ({error}).") from error
    except RecursionError:
        check.refuse("path", Path(path), f"{what} in JSON", "It is nested too deeply.")


def entries(place: str, given: Any) -> dict[str, Any]:
    """Return a JSON object as a dict; raise ValueError for any other value."""
    return dict(given) if isinstance(given, Mapping) else check.refuse(place, given, "a JSON object")


def check_keys(place: str, given: Mapping[str, Any], allowed: set[str]) -> None:
    """Raise ValueError if a JSON object has a key that is not allowed."""
    for key in given:
        if key not in allowed:
            check.refuse(f"field of {place}", key, "one of " + ", ".join(sorted(allowed)))


def value(place: str, kind: type[Kind], given: Any) -> Kind:
    """Create an instance of the dataclass `kind` from a JSON object of its fields; missing fields have their defaults.

    Raises
    ------
    ValueError
        If `given` is not an object, or a field is unknown or invalid. The message contains the place.
    """
    found = entries(place, given)
    check_keys(place, found, {field.name for field in fields(kind)})  # type: ignore[arg-type] # any dataclass
    try:
        return kind(**{key: tuple(item) if isinstance(item, list) else item for key, item in found.items()})
    except ValueError as error:
        raise ValueError(f"{place}.{error}") from error


def with_type(argument: str, given: Any, kinds: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of the dataclass `given` as a dict; the entry "type" is the name of its class in `kinds`.

    Raise ValueError if `kinds` does not contain the class.
    """
    for name, kind in kinds.items():
        if type(given) is kind:
            return {"type": name} | asdict(given)
    remedy = "Files store built-in types only; a user-defined type can be evaluated and planned, but not saved."
    return check.refuse(argument, given, f"of a built-in type ({', '.join(kinds)}) to be saved in a file", remedy)


def value_of_type(place: str, given: Any, kinds: Mapping[str, type[Kind]]) -> Kind:
    """Create a dataclass as `value` does; the JSON object's entry "type" is the name of the class in `kinds`."""
    found = entries(place, given)
    kind = kinds[check.choice(f"{place}.type", found.pop("type", None), kinds)]
    return value(place, kind, found)
