"""The stage on the page: a ground, a backdrop or a plinth under the meshes, with undo."""

from __future__ import annotations

from typing import Any

from pvphong.optics.material import Material
from pvphong.studio.lit_mesh import LitMesh
from pvphong.studio.subplot import Subplot


class Staging:
    """The stage of a subplot.

    Parameters
    ----------
    phong : PlotterPhong
        The lighting of the plotter; the subplot must be the plotter's active one when a stage is made.
    subplot : Subplot
        The subplot.
    """

    def __init__(self, phong: Any, subplot: Subplot) -> None:
        self._phong, self._subplot = phong, subplot

    @property
    def mesh(self) -> LitMesh | None:
        """The stage as a lit mesh; None if there is none."""
        return self._subplot.lit.stage

    @property
    def kind(self) -> str:
        """Kind of the stage; "" if there is none."""
        stage = self.mesh
        return "" if stage is None or stage.stage is None else stage.stage.kind

    def put(self, kind: str, refine: float | None, material: Material | None = None) -> None:
        """Draw a stage under the meshes, in place of an earlier one.

        Parameters
        ----------
        kind : str
            Kind of the stage; "" for none.
        refine : float or None
            Tolerance of refined pictures, if the view is refined.
        material : Material, optional
            The stage's material; by default, that of the earlier stage.
        """
        before = self.mesh
        if not kind:
            self.show(None, refine)
            return
        chosen = before.material if material is None and before is not None else material
        self._phong.add_stage(kind, chosen)
        if refine is not None:
            self._subplot.lit.refine(refine)

    def fit(self, refine: float | None) -> None:
        """Put the stage, if there is one, under the meshes that are shown now. Without a mesh, it is removed."""
        stage = self.mesh
        if stage is not None and stage.stage is not None:
            self.put(stage.stage.kind if self._subplot.lit.subjects else "", refine, stage.material)

    def show(self, stage: LitMesh | None, refine: float | None) -> None:
        """Show `stage`, which was drawn before; None removes the stage.

        `refine` is the tolerance of refined pictures, if the view is refined.
        """
        before, renderer = self.mesh, self._subplot.renderer
        if stage is before:
            return
        if before is not None:
            renderer.remove_actor(before.actor, render=False)
        if stage is not None:
            actor: Any = stage.actor
            renderer.add_actor(actor, name="stage", pickable=bool(actor.GetPickable()), render=False)
            self._subplot.lit.add(stage, refine)
