"""JSON files and the values in them. Error messages give the place in the file."""

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
        If the file cannot be read or is not JSON. The message says that `what`, such as "a scene file", was expected.
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
    """Return a JSON object as a dict; raise ValueError with the place for any other value."""
    return dict(given) if isinstance(given, Mapping) else check.refuse(place, given, "a JSON object")


def check_keys(place: str, given: Mapping[str, Any], allowed: set[str]) -> None:
    """Raise ValueError for a key that is not allowed."""
    for key in given:
        if key not in allowed:
            check.refuse(f"field of {place}", key, "one of " + ", ".join(sorted(allowed)))


def value(place: str, kind: type[Kind], given: Any) -> Kind:
    """Create a dataclass from a JSON object of its fields; missing fields have their defaults.

    Raises
    ------
    ValueError
        If `given` is not an object, or a field is unknown or invalid. The message begins with the place.
    """
    found = entries(place, given)
    check_keys(place, found, {field.name for field in fields(kind)})  # type: ignore[arg-type] # any dataclass
    try:
        return kind(**{key: tuple(item) if isinstance(item, list) else item for key, item in found.items()})
    except ValueError as error:
        raise ValueError(f"{place}.{error}") from error


def with_type(argument: str, given: Any, kinds: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a dataclass and its name in `kinds` as "type"; raise ValueError if it has no name there."""
    for name, kind in kinds.items():
        if type(given) is kind:
            return {"type": name} | asdict(given)
    remedy = "Files store built-in types only; a user-defined type can be evaluated and planned, but not saved."
    return check.refuse(argument, given, f"one of {', '.join(kinds)} in a file", remedy)


def value_of_type(place: str, given: Any, kinds: Mapping[str, type[Kind]]) -> Kind:
    """Create a dataclass as `value` does; the object's "type" gives its kind."""
    found = entries(place, given)
    kind = kinds[check.choice(f"{place}.type", found.pop("type", None), kinds)]
    return value(place, kind, found)
