"""The pictures and exports that a plotter's own methods make: of what is current, and without gizmos."""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

_OUTPUTS = (
    "screenshot",
    "save_graphic",
    "export_html",
    "export_vtksz",
    "export_gltf",
    "export_obj",
    "export_vrml",
)


def wrap_outputs(plotter: Any, prepared: Callable[[], AbstractContextManager[None]]) -> None:
    """Have a plotter's pictures and exports made inside a context, once however often it is called."""
    for name in _OUTPUTS:
        method = getattr(type(plotter), name, None)
        if method is not None and name not in vars(plotter):
            setattr(plotter, name, _wrapped(weakref.ref(plotter), method, prepared))


def unwrap_outputs(plotter: Any) -> None:
    """Take back what `wrap_outputs` did."""
    for name in _OUTPUTS:
        if hasattr(vars(plotter).get(name), "prepared"):
            delattr(plotter, name)


def _wrapped(plotter: Any, method: Any, prepared: Callable[[], AbstractContextManager[None]]) -> Any:
    @functools.wraps(method)
    def output(*args: Any, **kwargs: Any) -> Any:
        with prepared():
            return method(plotter(), *args, **kwargs)

    output.prepared = prepared  # type: ignore[attr-defined] # what `unwrap_outputs` knows it by
    return output
