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
    """Read a JSON file and return its content.

    Parameters
    ----------
    path : path
        The file.
    what : str
        Noun for the expected kind of file, such as "a scene file"; error messages contain it.

    Raises
    ------
    ValueError
        If the file cannot be read or is not JSON.
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
    """Return a copy of `given` if it is a mapping (a JSON object); raise ValueError for any other value.

    Error messages begin with `place`, the position of the value in its file, such as "lights[2]".
    """
    return dict(given) if isinstance(given, Mapping) else check.refuse(place, given, "a JSON object")


def check_keys(place: str, given: Mapping[str, Any], allowed: set[str]) -> None:
    """Raise ValueError if the mapping `given` (a JSON object) has a key that is not in `allowed`.

    Error messages contain `place`, the position of the object in its file, such as "lights[2]".
    """
    for key in given:
        if key not in allowed:
            check.refuse(f"field of {place}", key, "one of " + ", ".join(sorted(allowed)))


def value(place: str, kind: type[Kind], given: Any) -> Kind:
    """Create an instance of a dataclass from a JSON object.

    Parameters
    ----------
    place : str
        Position of the object in its file, such as "lights[2]"; error messages contain it.
    kind : type
        The dataclass.
    given : Any
        The JSON object, a mapping from names of fields to values. Fields that it lacks have their defaults.

    Raises
    ------
    ValueError
        If `given` is not a mapping, or a field is unknown or invalid.
    """
    found = entries(place, given)
    check_keys(place, found, {field.name for field in fields(kind)})  # type: ignore[arg-type] # any dataclass
    try:
        return kind(**{key: tuple(item) if isinstance(item, list) else item for key, item in found.items()})
    except ValueError as error:
        raise ValueError(f"{place}.{error}") from error


def with_type(argument: str, given: Any, kinds: Mapping[str, Any]) -> dict[str, Any]:
    """Convert a dataclass instance to a dict for JSON: its fields, and the name of its class as the entry "type".

    Parameters
    ----------
    argument : str
        Name of the argument in the error message.
    given : dataclass instance
        The value to convert.
    kinds : mapping
        Name → class, for all classes that files can store.

    Raises
    ------
    ValueError
        If `kinds` does not contain the class.
    """
    for name, kind in kinds.items():
        if type(given) is kind:
            return {"type": name} | asdict(given)
    remedy = "Files store built-in types only; a user-defined type can be evaluated and planned, but not saved."
    return check.refuse(argument, given, f"of a built-in type ({', '.join(kinds)}) to be saved in a file", remedy)


def value_of_type(place: str, given: Any, kinds: Mapping[str, type[Kind]]) -> Kind:
    """Create a dataclass instance from a JSON object whose entry "type" names the class: the inverse of `with_type`.

    Parameters
    ----------
    place : str
        Position of the object in its file, such as "lights[2]"; error messages contain it.
    given : Any
        The JSON object: the entry "type", and the fields of the class. Missing fields have their defaults.
    kinds : mapping
        Name → class, for all classes that "type" may name.

    Raises
    ------
    ValueError
        If `given` is not a mapping, "type" is not in `kinds`, or a field is unknown or invalid.
    """
    found = entries(place, given)
    kind = kinds[check.choice(f"{place}.type", found.pop("type", None), kinds)]
    return value(place, kind, found)
