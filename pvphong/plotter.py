"""`plotter.phong`: what a plotter shows, as a scene. PyVista finds this module by its entry point."""

from __future__ import annotations

import pyvista as pv

from pvphong.scene import Scene


@pv.register_plotter_component("phong")
class PlotterPhong:
    """Lighting of one plotter."""

    def __init__(self, plotter: pv.Plotter) -> None:
        self._plotter = plotter

    @property
    def scene(self) -> Scene:
        """A snapshot of the active renderer's lights, at their true world positions, and of its camera."""
        return Scene.from_plotter(self._plotter)
