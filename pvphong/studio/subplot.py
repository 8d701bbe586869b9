"""One subplot: its lights, its lit meshes, and its gizmos."""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import pyvista as pv

from pvphong.base.display import Display
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.studio.gizmos import History, Interaction
from pvphong.studio.gizmos.history import Editable
from pvphong.studio.lit_actors import LitActors
from pvphong.studio.window_lights import WindowLights

_NO_VTK_SHADOWS = (
    "VTK's shadows cannot be combined with meshes lit by pvphong. Set plotter.phong.light_model = "
    "pvphong.LightModel(shadows=True)"
)


class Subplot:
    """The lights, lit meshes and gizmos of one renderer.

    Parameters
    ----------
    renderer : pyvista.Renderer
        The renderer; kept until `release`.
    light_model : LightModel
        Light model of the scene. It can be set at any time.
    history : History
        Undo history that records edits.
    display : Display
        Transform that shows the lit colours. `lit.display` can be set at any time.
    """

    def __init__(self, renderer: pv.Renderer, light_model: LightModel, history: History, display: Display) -> None:
        self.renderer, self.light_model, self._history = renderer, light_model, history
        self.lights = WindowLights(renderer)
        self.lit = LitActors(renderer, lambda: self.scene)
        self.lit.display = display
        self.interaction: Interaction | None = None
        self._unlit = weakref.WeakSet[Any]()
        self._refuse_shadow_pass()

    @property
    def scene(self) -> Scene:
        """The current lights, viewer and light model, as an immutable scene."""
        return Scene(lights=self.lights.values, viewer=self.lights.viewer, light_model=self.light_model)

    def assigning(self, edited: Editable) -> AbstractContextManager[None]:
        """Return a context. All changes of `edited` inside the context become one undo step.

        Without gizmos, no step is recorded, so that animations do not fill the history.
        """
        return nullcontext() if self.interaction is None else self._history.edit(edited)

    def remove_gizmos(self) -> bool:
        """Remove the gizmos. Return False if there are no gizmos."""
        if self.interaction is None:
            return False
        self.interaction.release()
        self.interaction = None
        return True

    def _refuse_shadow_pass(self) -> None:
        """Replace `renderer.enable_shadows` by a function that raises an error while pvphong's meshes are drawn.

        VTK's shadow pass has no shader for unlit actors and prints hundreds of lines in each frame.
        """
        subplot, enable = weakref.ref(self), type(self.renderer).enable_shadows

        @functools.wraps(enable)
        def enable_shadows() -> None:
            if (alive := subplot()) is not None:
                if any(alive.renderer.HasViewProp(actor) for actor in alive._unlit):
                    raise ValueError(f"{_NO_VTK_SHADOWS} instead of calling plotter.enable_shadows().")
                enable(alive.renderer)

        self.renderer.enable_shadows = enable_shadows

    def add_unlit(self, draw: Callable[[], pv.Actor]) -> pv.Actor:
        """Call `draw`, which adds an actor, and switch VTK's lighting off for this actor.

        Raise ``ValueError`` if VTK's shadows are on.
        """
        if self.renderer._render_passes._shadow_map_pass is not None:
            raise ValueError(f"{_NO_VTK_SHADOWS} and remove plotter.enable_shadows().")
        actor = draw()
        self._unlit.add(actor)
        return actor

    def release(self) -> None:
        """Remove the gizmos and detach from the renderer."""
        vars(self.renderer).pop("enable_shadows", None)
        self.remove_gizmos()
        self.lit.release()
