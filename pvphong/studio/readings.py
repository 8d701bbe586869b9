"""The subplots of a plotter, and readings of what they show: a histogram of the picture, the lit value at a point."""

from __future__ import annotations

import weakref

import pyvista as pv

from pvphong.base import check
from pvphong.base.display import Display
from pvphong.base.types import VectorLike
from pvphong.scene.light_model import LightModel
from pvphong.studio.gizmos import History
from pvphong.studio.histogram import BINS, Histogram, displayed, histogram_of
from pvphong.studio.probing import Locators, Probe, read
from pvphong.studio.subplot import Subplot


class Readings:
    """Part of `plotter.phong`: the plotter's subplots, and methods that measure the picture of the active subplot.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The plotter; kept by weak reference.
    """

    def __init__(self, plotter: pv.Plotter) -> None:
        self._owner = weakref.ref(plotter)
        self._light_model = LightModel()
        self._display = Display()
        self._subplots: list[Subplot] = []
        self._history = History()

    @property
    def _plotter(self) -> pv.Plotter:
        plotter = self._owner()
        assert plotter is not None, "the plotter has gone"
        return plotter

    @property
    def _subplot(self) -> Subplot:
        """Active subplot."""
        renderer = self._plotter.renderer
        if getattr(renderer, "camera", None) is None or self._plotter.render_window is None:
            check.refuse("plotter", "a closed plotter", "open")
        for subplot in self._subplots:
            if subplot.renderer is renderer:
                return subplot
        self._subplots.append(Subplot(renderer, self._light_model, self._history, self._display))
        return self._subplots[-1]

    def histogram(self, bins: int = BINS) -> Histogram:
        """Return the histogram of the luminance that the active subplot displays.

        A new frame is drawn, and its pixels are counted after the display transform. Background, gizmos and the
        display's overlay are left out.

        Parameters
        ----------
        bins : int, default 64
            Number of bins, from 1 to 256.

        Returns
        -------
        Histogram
            Counts, edges, and the fractions of black and of clipped pixels.

        Raises
        ------
        ValueError
            If `bins` is not allowed, or the plotter is closed.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> plotter = pv.Plotter(off_screen=True, lighting="none")
        >>> actor = plotter.phong.add_mesh(pv.Sphere(), "gold")
        >>> plotter.show(auto_close=False)
        >>> plotter.phong.histogram().clipped_high
        0.0
        >>> plotter.close()
        """
        if type(bins) is not int or not 1 <= bins <= 256:
            check.refuse("bins", bins, "a whole number from 1 to 256", "Displayed colours have 256 levels.")
        subplot = self._subplot
        found = histogram_of(displayed(subplot.renderer, subplot.lit, subplot.interaction), bins)
        if subplot.interaction is not None or subplot.lit.display.overlay != "none":
            self._plotter.render()
        return found

    def probe(self, point: VectorLike, actor: pv.Actor | None = None) -> Probe:
        """Return the lit value at a point of a surface, and each light's contribution (its share).

        Parameters
        ----------
        point : sequence of float
            A point in the world. Of all visible lit meshes in the active subplot, the nearest face is found. The lit
            value is that of the face's corner nearest to the point.
        actor : pyvista.Actor, optional
            Actor of the only mesh to read.

        Returns
        -------
        Probe
            The vertex, its colour and the shares. They equal those of ``mesh.phong.shade(components=True)``.

        Raises
        ------
        ValueError
            If `point` is not a point, no lit mesh is visible, or `actor` is not the actor of a visible lit mesh.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> plotter = pv.Plotter(off_screen=True, lighting="none")
        >>> sun = plotter.phong.add_light(ph.DirectionalLight(direction=(0, 0, -1), name="sun"))
        >>> actor = plotter.phong.add_mesh(pv.Sphere(), name="ball")
        >>> plotter.show(auto_close=False)
        >>> plotter.phong.probe((0, 0, 0.5))
        <Probe of vertex 0 of 'ball': 0.84 0.84 0.84, 1 lights>
        >>> plotter.close()
        """
        target, subplot = check.vector("point", point), self._subplot
        lit = subplot.lit
        lit.refresh()
        meshes = [mesh for mesh in lit.shown if actor is None or mesh.actor is actor]
        place = Locators().nearest(meshes, target)
        found = None if place is None else read(place, lit.name_of(place.mesh), subplot.scene)
        if found is None:
            allowed = "a visible mesh from plotter.phong.add_mesh"
            check.refuse("actor", "none" if actor is None else actor, allowed, "Call add_mesh first.")
        return found
