"""Coarse pictures of large meshes in the page: from a change until nothing has changed for a moment."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any

from pvphong.studio.coarse import CoarsePictures
from pvphong.studio.gizmos.asking import Ask
from pvphong.studio.gizmos.gizmo import HIGHLIGHT
from pvphong.studio.subplot import Subplot

TRIGGERS = frozenset({"edit", "slide", "undo", "redo"})
"""Triggers of the page after which large meshes are drawn coarsely."""

_CALM_AFTER = 0.25
"""Seconds without a change after which meshes are drawn with all their triangles again."""

_BEFORE_LIT = 2.0  # observer priority: before the colours are computed
_OF_STYLE = "StartInteractionEvent", "InteractionEvent", "EndInteractionEvent"


class Hurry:
    """Draws a subplot's large meshes coarsely while the camera, a gizmo or a value changes.

    Parameters
    ----------
    subplot : Subplot
        The subplot, with gizmos.
    later : callable
        Function that schedules a call. It takes the delay in seconds and the function to call. If this call is
        scheduled already, its time changes.
    draw : callable
        Requests a frame.
    """

    def __init__(
        self, subplot: Subplot, later: Callable[[float, Callable[[], None]], None], draw: Callable[[], None]
    ) -> None:
        assert subplot.interaction is not None, "a studio has gizmos"
        self.pictures = CoarsePictures(subplot.renderer, subplot.lit)
        self._subplot, self._later, self._draw = subplot, later, draw
        hurry = weakref.ref(self)

        def moved(_style: Any, _event: str) -> None:
            if (alive := hurry()) is not None:
                alive.begin()

        def before_frame(_renderer: Any, _event: str) -> None:
            edit = None if subplot.interaction is None else subplot.interaction.edit
            if (subplot.lit.uses_preview_rays or isinstance(edit, Ask)) and (alive := hurry()) is not None:
                alive.begin()

        style = subplot.interaction.gizmos.interactor.GetInteractorStyle()
        self._observed = [(style, style.AddObserver(event, moved)) for event in _OF_STYLE]
        self._observed.append((subplot.renderer, subplot.renderer.AddObserver("StartEvent", before_frame, _BEFORE_LIT)))

    def begin(self) -> None:
        """Draw coarsely until nothing has changed for a moment."""
        edit = None if self._subplot.interaction is None else self._subplot.interaction.edit
        needs_faces = edit is not None and not isinstance(edit, Ask) and edit.handle == HIGHLIGHT  # the mesh's own
        self.pictures.are_wanted = not needs_faces
        self._later(_CALM_AFTER, self._calm)

    def _calm(self) -> None:
        self.pictures.are_wanted = False
        if self.pictures.are_shown:
            self._draw()

    def end(self) -> None:
        """Draw all triangles from the next frame on."""
        self.pictures.are_wanted = False

    def release(self) -> None:
        """Detach from the view, and show the meshes themselves."""
        for subject, tag in self._observed:
            subject.RemoveObserver(tag)
        self.pictures.release()
