"""Handles: live objects whose attributes users set. A misspelt attribute raises, and names the close match."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, ClassVar

from pvphong.base import check


class Handle:
    """An object that has the attributes its class declares: setting any other raises AttributeError.

    Private names (with an underscore) are free, and so are users' own subclasses of handles. Attributes that are set
    in `__init__` are declared by an annotation in the class.
    """

    _instead: ClassVar[Mapping[str, str]] = {}
    """Name that users try → name of the attribute that they mean, where spelling does not tell."""

    def __setattr__(self, name: str, value: Any) -> None:
        kind: Any = type(self)
        if Handle in kind.__bases__ and not name.startswith("_") and name not in declared(kind):
            raise unknown_attribute(kind.__name__, name, declared(kind), self._instead)
        super().__setattr__(name, value)


@cache
def declared(kind: Any) -> frozenset[str]:
    """The public attributes that a class declares."""
    annotated = {name for base in kind.__mro__ for name in vars(base).get("__annotations__", ())}
    return frozenset(name for name in {*dir(kind), *annotated} if not name.startswith("_"))


def unknown_attribute(
    owner: str, name: str, known: Iterable[str], instead: Mapping[str, str] | None = None
) -> AttributeError:
    """The error for an attribute that an object does not have, to be raised.

    Parameters
    ----------
    owner : str
        The kind of object.
    name : str
        The attribute.
    known : iterable of str
        The attributes that it has.
    instead : mapping, optional
        Name that users try → name that they mean.
    """
    known = sorted(known)
    meant = (instead or {}).get(name)
    remedy = f"Did you mean {meant!r}?" if meant in known else check.meant(name, known)
    return AttributeError(f"{owner} has no attribute {name!r}. {remedy or 'It has ' + ', '.join(known) + '.'}")
