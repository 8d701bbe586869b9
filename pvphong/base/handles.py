"""Handles: live objects whose attributes users set. A misspelt attribute raises an error that suggests the nearest."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, ClassVar

from pvphong.base import check


class Handle:
    """An object with the attributes that its class declares; setting any other raises AttributeError.

    Private names (with an underscore) are not checked, and neither are subclasses of handles by users. Attributes that
    are set in `__init__` are declared by an annotation in the class.
    """

    _instead: ClassVar[Mapping[str, str]] = {}
    """Common wrong name → attribute that is meant, where the spelling is too different to suggest it."""

    def __setattr__(self, name: str, value: Any) -> None:
        kind: Any = type(self)
        if Handle in kind.__bases__ and not name.startswith("_") and name not in declared(kind):
            raise unknown_attribute(kind.__name__, name, declared(kind), self._instead)
        super().__setattr__(name, value)


@cache
def declared(kind: Any) -> frozenset[str]:
    """Return the public attributes that a class declares."""
    annotated = {name for base in kind.__mro__ for name in vars(base).get("__annotations__", ())}
    return frozenset(name for name in {*dir(kind), *annotated} if not name.startswith("_"))


def unknown_attribute(
    owner: str, name: str, known: Iterable[str], instead: Mapping[str, str] | None = None
) -> AttributeError:
    """Return the error for an attribute that an object does not have; the caller raises it.

    Parameters
    ----------
    owner : str
        The kind of object.
    name : str
        The attribute.
    known : iterable of str
        The existing attributes.
    instead : mapping, optional
        Common wrong name → attribute that is meant.
    """
    known = sorted(known)
    meant = (instead or {}).get(name)
    remedy = f"Did you mean {meant!r}?" if meant in known else check.meant(name, known)
    return AttributeError(f"{owner} has no attribute {name!r}. {remedy or 'It has ' + ', '.join(known) + '.'}")
