"""Pictures and exports of a plotter. Before each, colours are updated and gizmos are hidden."""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from typing import Any

import pyvista as pv

from pvphong.studio.subplot import Subplot

_METHODS = (
    "screenshot",
    "save_graphic",
    "export_html",
    "export_vtksz",
    "export_gltf",
    "export_obj",
    "export_vrml",
)
"""Methods of a plotter that write pictures or files."""


class Outputs:
    """The methods of one plotter that make pictures and exports. They update colours and hide gizmos first.

    Parameters
    ----------
    owner : weakref.ref
        The plotter.
    subplots : list of Subplot
        The plotter's subplots; the list may change later.
    """

    def __init__(self, owner: weakref.ref[pv.Plotter], subplots: list[Subplot]) -> None:
        self._owner, self._subplots = owner, subplots
        self._wrapped: dict[str, Callable[..., Any]] = {}

    def prepare(self) -> None:
        """Replace the plotter's output methods by methods that update colours and hide gizmos first.

        Further calls have no effect.
        """
        outputs, owner = weakref.ref(self), self._owner

        def wrapped(method: Any) -> Any:
            @functools.wraps(method)
            def output(*args: Any, **kwargs: Any) -> Any:
                alive = outputs()
                # `show` always takes a last screenshot, with False as its file name; it must not wait for refinement
                waits = not (args and args[0] is False)
                with nullcontext() if alive is None else alive._prepared(waits):
                    return method(owner(), *args, **kwargs)

            return output

        plotter = owner()
        for name in _METHODS:
            method = getattr(type(plotter), name, None)
            if method is not None and name not in vars(plotter):
                self._wrapped[name] = wrapped(method)
                setattr(plotter, name, self._wrapped[name])

    @contextmanager
    def _prepared(self, waits: bool) -> Iterator[None]:
        """Return a context for a plotter's output: colours are up to date, and gizmos are hidden.

        Usually a frame updates the colours, but an exporter draws no frame. With `waits`, refined pictures are
        completed first.
        """
        interactions = [each.interaction for each in self._subplots if each.interaction is not None]
        is_refined = max([subplot.lit.refresh(waits=waits) for subplot in self._subplots], default=False)
        plotter = self._owner()
        with ExitStack() as stack:
            for interaction in interactions:
                stack.enter_context(interaction.out_of_sight())
            if plotter is not None and (interactions or is_refined):
                plotter.render()
            yield
        if plotter is not None and interactions:
            plotter.render()

    def release(self) -> None:
        """Restore the plotter's own output methods."""
        plotter = self._owner()  # None if the plotter was collected without being closed
        for name, output in self._wrapped.items():
            if plotter is not None and vars(plotter).get(name) is output:
                delattr(plotter, name)
        self._wrapped.clear()
