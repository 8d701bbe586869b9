"""One subplot: its lights, its lit meshes, and its gizmos."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pyvista as pv

from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.studio.gizmos import Gizmos, History, Interaction, Options
from pvphong.studio.lit_actors import LitActors
from pvphong.studio.window_lights import RendererLight, WindowLights


class Subplot:
    """Everything that pvphong keeps about one renderer.

    Parameters
    ----------
    renderer : pyvista.Renderer
        Held on to until `release`.
    light_model : callable
        Gives the light model that is in force.
    """

    def __init__(self, renderer: pv.Renderer, light_model: Callable[[], LightModel]) -> None:
        self.renderer = renderer
        self.lights = WindowLights(renderer)
        self.lit = LitActors(renderer, lambda: self.scene)
        self.interaction: Interaction | None = None
        self._light_model = light_model

    @property
    def scene(self) -> Scene:
        """A snapshot of what lights this subplot."""
        return Scene(lights=self.lights.values, viewer=self.lights.viewer, light_model=self._light_model())

    def add_gizmos(
        self,
        interactor: Any,
        render: Callable[[], None],
        history: History,
        only: Sequence[RendererLight] | None,
        options: Options,
    ) -> None:
        """Put gizmos up, as `Gizmos` has them."""
        gizmos = Gizmos(self.renderer, interactor, render, self.lights, self.lit, history, only, options)
        self.interaction = Interaction(gizmos)

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
