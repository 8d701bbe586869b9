"""One subplot: its lights, its lit meshes, and its gizmos."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

import pyvista as pv

from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.studio.gizmos import History, Interaction
from pvphong.studio.gizmos.history import Editable
from pvphong.studio.lit_actors import LitActors
from pvphong.studio.window_lights import WindowLights


class Subplot:
    """Everything that pvphong keeps about one renderer.

    Parameters
    ----------
    renderer : pyvista.Renderer
        Held on to until `release`.
    light_model : LightModel
        Can be set at any time.
    history : History
        Where edits go that can be undone.
    """

    def __init__(self, renderer: pv.Renderer, light_model: LightModel, history: History) -> None:
        self.renderer, self.light_model, self._history = renderer, light_model, history
        self.lights = WindowLights(renderer)
        self.lit = LitActors(renderer, lambda: self.scene)
        self.interaction: Interaction | None = None

    @property
    def scene(self) -> Scene:
        """A snapshot of what lights this subplot."""
        return Scene(lights=self.lights.values, viewer=self.lights.viewer, light_model=self.light_model)

    def assigning(self, edited: Editable) -> AbstractContextManager[None]:
        """What is assigned inside becomes one step of undo where there are gizmos; an animation leaves no steps."""
        return nullcontext() if self.interaction is None else self._history.edit(edited)

    def remove_gizmos(self) -> bool:
        """Take the gizmos down; False if there are none."""
        if self.interaction is None:
            return False
        self.interaction.release()
        self.interaction = None
        return True

    def release(self) -> None:
        """Let go of everything."""
        self.remove_gizmos()
        self.lit.release()
