"""Handles: live objects whose attributes users set.

Setting a misspelt attribute raises an error that suggests the nearest name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, ClassVar

from pvphong.base import check


class Handle:
    """Base class of handles: setting an attribute that the class does not declare raises AttributeError.

    Two kinds of attributes are not checked: names that begin with an underscore, and attributes of classes that users
    derive from a handle. Attributes that are set in `__init__` are declared by an annotation in the class.
    """

    _instead: ClassVar[Mapping[str, str]] = {}
    """Common wrong names → the intended attributes. It is for names too different for a search by spelling."""

    def __setattr__(self, name: str, value: Any) -> None:
        kind: Any = type(self)
        if Handle in kind.__bases__ and not name.startswith("_") and name not in declared(kind):
            raise unknown_attribute(kind.__name__, name, declared(kind), self._instead)
        super().__setattr__(name, value)


@cache
def declared(kind: Any) -> frozenset[str]:
    """Return the names of the public attributes that the class `kind` declares."""
    annotated = {name for base in kind.__mro__ for name in vars(base).get("__annotations__", ())}
    return frozenset(name for name in {*dir(kind), *annotated} if not name.startswith("_"))


def unknown_attribute(
    owner: str, name: str, known: Iterable[str], instead: Mapping[str, str] | None = None
) -> AttributeError:
    """Return the error for an attribute that an object does not have; the caller raises it.

    Parameters
    ----------
    owner : str
        Name of the object's class.
    name : str
        Name of the attribute that does not exist.
    known : iterable of str
        Names of the existing attributes.
    instead : mapping, optional
        Common wrong names → the intended attributes.
    """
    known = sorted(known)
    meant = (instead or {}).get(name)
    remedy = f"Did you mean {meant!r}?" if meant in known else check.meant(name, known)
    return AttributeError(f"{owner} has no attribute {name!r}. {remedy or 'It has ' + ', '.join(known) + '.'}")
