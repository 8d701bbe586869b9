"""Meshes of a subplot that cannot be lit: the others are kept current, and the window says which and why."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Callable, Iterable
from typing import Any

from vtkmodules.vtkRenderingCore import vtkTextActor

from pvphong.studio.live import LiveMesh

_WIDTH = 60  # letters of a line
_AT = (10.0, 10.0)  # of the text, in pixels from the lower left


class LightingWarning(UserWarning):
    """A mesh in a window cannot be lit as it is; it is not drawn until that is mended."""


class Troubles:
    """What is wrong with the meshes of one subplot.

    Parameters
    ----------
    renderer : vtkRenderer
        Where it is said.
    """

    def __init__(self, renderer: Any) -> None:
        self._renderer = renderer
        self._known: dict[LiveMesh, str] = {}
        self._text = vtkTextActor()
        self._text.UseBoundsOff()
        self._text.PickableOff()
        self._text.SetPosition(*_AT)
        style = self._text.GetTextProperty()
        style.SetFontSize(14)
        style.SetColor(1.0, 0.8, 0.3)
        style.SetBackgroundColor(0.1, 0.1, 0.1)
        style.SetBackgroundOpacity(0.75)

    def refresh(self, meshes: Iterable[LiveMesh], refresh: Callable[[LiveMesh], bool]) -> int:
        """Bring meshes up to date, each by `refresh`, and give how many had to be computed.

        A mesh that cannot be lit is not drawn, for its last colours would not be true, until it can be lit again.

        Warns
        -----
        LightingWarning
            Of each new trouble, once, when all other meshes are up to date.
        """
        found: dict[LiveMesh, str] = {}
        computed = 0
        for live in meshes:
            try:
                computed += refresh(live)
            except Exception as error:  # of a light or an array of the user's, too
                live.blank()
                found[live] = f"{self._named(live)} is not lit: {error}"
        before, self._known = self._known, found
        if found != before:
            self._show()
            for live, said in found.items():
                if before.get(live) != said:
                    warnings.warn(said, LightingWarning, stacklevel=2)
        return computed

    def _named(self, live: LiveMesh) -> str:
        names = [name for name, actor in self._renderer.actors.items() if actor is live.actor]
        return f"The mesh {names[0]!r}" if names and "(Addr=" not in names[0] else "A mesh"

    def _show(self) -> None:
        lines = [line for said in self._known.values() for line in textwrap.wrap(said, _WIDTH)]
        self._text.SetInput("\n".join(lines))
        (self._renderer.AddViewProp if lines else self._renderer.RemoveViewProp)(self._text)
