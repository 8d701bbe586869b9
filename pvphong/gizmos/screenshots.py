"""Keeps gizmos out of a plotter's pictures and exports."""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

_MAKES_PICTURES = (
    "screenshot",
    "save_graphic",
    "export_html",
    "export_vtksz",
    "export_gltf",
    "export_obj",
    "export_vrml",
)


def keep_out(plotter: Any, out_of_sight: Callable[[], AbstractContextManager[None]]) -> None:
    """Have a plotter's pictures made inside a context in which the gizmos are out of sight."""
    for name in _MAKES_PICTURES:
        method = getattr(type(plotter), name, None)
        if method is not None and name not in vars(plotter):
            setattr(plotter, name, _wrapped(weakref.ref(plotter), method, out_of_sight))


def let_in(plotter: Any) -> None:
    """Take back what `keep_out` did."""
    for name in _MAKES_PICTURES:
        if hasattr(vars(plotter).get(name), "out_of_sight"):
            delattr(plotter, name)


def _wrapped(plotter: Any, method: Any, out_of_sight: Callable[[], AbstractContextManager[None]]) -> Any:
    @functools.wraps(method)
    def without_gizmos(*args: Any, **kwargs: Any) -> Any:
        with out_of_sight():
            return method(plotter(), *args, **kwargs)

    without_gizmos.out_of_sight = out_of_sight  # type: ignore[attr-defined] # what `let_in` knows it by
    return without_gizmos
