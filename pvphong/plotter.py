"""`plotter.phong`: lit meshes that follow camera, lights and edits. PyVista finds this module by its entry point."""

from __future__ import annotations

import weakref
from typing import Any

import pyvista as pv

from pvphong import _check
from pvphong.lights import Light
from pvphong.live import ARRAY, LiveMesh
from pvphong.material import Material
from pvphong.planning import check_scene_and_material
from pvphong.rig import LightHandle, Rig
from pvphong.scene import LightModel, Scene

_DULL = Material()
# What `add_mesh` decides itself.
_OURS = ("scalars", "rgb", "rgba", "lighting", "color", "smooth_shading", "texture", "pbr", "cmap")


@pv.register_plotter_component("phong")
class PlotterPhong:
    """Lighting in one plotter: every subplot has its own lights, all share the light model."""

    def __init__(self, plotter: pv.Plotter) -> None:
        self._plotter = weakref.proxy(plotter)
        self._light_model = LightModel()
        self._rigs: dict[int, Rig] = {}
        self._meshes: dict[int, list[LiveMesh]] = {}
        self._observers: list[tuple[Any, int]] = []
        self._evaluations = 0

    # -- meshes ------------------------------------------------------------------------------------------

    def add_mesh(
        self, mesh: pv.DataSet, material: Material = _DULL, *, albedo: Any = None, **add_mesh_options: Any
    ) -> pv.Actor:
        """Draw a mesh with lit colours, and keep them current.

        Before a frame is drawn its colours are computed again if, and only if, something that they depend on
        has changed: a light, the actor's matrix, the material, the albedo, the mesh, the light model; the
        camera only where highlights or lights that ride along make it count.

        Parameters
        ----------
        mesh : pyvista.DataSet
            A dataset with a surface; edits to it are followed.
        material : Material, optional
            The surface's reflectances; OpenGL's default material if not given.
        albedo : str or array_like, optional
            Colours that multiply the material's ambient and diffuse, as for `mesh.phong.shade`.
        **add_mesh_options
            As for `pyvista.Plotter.add_mesh`, without those that colour the mesh.

        Returns
        -------
        pyvista.Actor
            An ordinary actor, drawn with VTK's lighting off.

        Raises
        ------
        ValueError
            If an argument is not allowed, or the mesh has nothing that can be lit.
        """
        for option in _OURS:
            if option in add_mesh_options:
                allowed = f"an option of add_mesh other than {', '.join(_OURS)}"
                _check.refuse("option", option, allowed, "Colour comes from `material` and `albedo` here.")
        check_scene_and_material(Scene(), material)
        renderer = self._plotter.renderer
        live = LiveMesh(mesh, material, albedo)
        live.refresh(self.scene)
        self._evaluations += 1
        live.actor = self._plotter.add_mesh(live.drawn, scalars=ARRAY, rgb=True, lighting=False, **add_mesh_options)
        self._meshes.setdefault(id(renderer), []).append(live)
        self._watch(renderer)
        return live.actor

    def mesh(self, actor: pv.Actor) -> LiveMesh:
        """What `add_mesh` drew as this actor: its `.material` and `.albedo` can be set.

        Raises
        ------
        ValueError
            If the actor is not one of `add_mesh`, or has been removed.
        """
        for live in self._present(self._plotter.renderer):
            if live.actor is actor:
                return live
        return _check.refuse("actor", actor, "an actor that plotter.phong.add_mesh returned, in the active subplot")

    @property
    def evaluations(self) -> int:
        """How many times lit colours have been computed since the start."""
        return self._evaluations

    # -- lights ------------------------------------------------------------------------------------------

    @property
    def lights(self) -> tuple[Light, ...]:
        """The active subplot's lights as values, the plotter's own `pyvista.Light` objects among them."""
        return self._rig.lights

    def add_light(self, light: Any) -> LightHandle:
        """Add a light to the active subplot; VTK-lit actors stand in it too.

        Parameters
        ----------
        light : Light, pyvista.Light or vtkLight
            The light.

        Returns
        -------
        LightHandle
            Names the light for `set_light` and `remove_light`.

        Raises
        ------
        ValueError
            If it is no light, or the subplot has it already.
        """
        return self._rig.add(light)

    def set_light(self, which: Any, light: Light) -> None:
        """Give a light of the active subplot a new value.

        Parameters
        ----------
        which : LightHandle, int, str or pyvista.Light
            The light: by its handle, its index in `lights`, its name, or its PyVista light.
        light : Light
            The new value.

        Raises
        ------
        ValueError
            If there is no such light, or `light` is none.
        """
        if not isinstance(light, Light):
            _check.refuse("light", light, "a light of pvphong's", "as_light converts a pyvista.Light.")
        rig = self._rig
        rig.find(which).set(light, rig.viewer)

    def remove_light(self, which: Any) -> None:
        """Take a light out of the active subplot; `which` as for `set_light`."""
        self._rig.remove(which)

    @property
    def light_model(self) -> LightModel:
        """How contributions are put together, in all subplots; can be set."""
        return self._light_model

    @light_model.setter
    def light_model(self, model: LightModel) -> None:
        if not isinstance(model, LightModel):
            _check.refuse("light_model", model, "a LightModel")
        self._light_model = model

    @property
    def scene(self) -> Scene:
        """A snapshot of what lights the active subplot: its lights, its camera, the light model."""
        return self._scene(self._plotter.renderer)

    # -- following ---------------------------------------------------------------------------------------

    @property
    def _rig(self) -> Rig:
        return self._rig_of(self._plotter.renderer)

    def _rig_of(self, renderer: pv.Renderer) -> Rig:
        return self._rigs.setdefault(id(renderer), Rig(renderer))

    def _scene(self, renderer: pv.Renderer) -> Scene:
        rig = self._rig_of(renderer)
        return Scene(lights=rig.lights, viewer=rig.viewer, light_model=self._light_model)

    def _present(self, renderer: pv.Renderer) -> list[LiveMesh]:
        """The renderer's live meshes, without those whose actors have been removed."""
        meshes = self._meshes.get(id(renderer), [])
        meshes[:] = [live for live in meshes if renderer.HasViewProp(live.actor)]
        return meshes

    def _watch(self, renderer: pv.Renderer) -> None:
        if any(watched is renderer for watched, _ in self._observers):
            return
        component = weakref.ref(self)

        def before_frame(source: Any, _event: str) -> None:
            if (alive := component()) is not None:
                alive._refresh(source)

        self._observers.append((renderer, renderer.AddObserver("StartEvent", before_frame)))

    def _refresh(self, renderer: pv.Renderer) -> None:
        meshes = self._present(renderer)
        if meshes:
            scene = self._scene(renderer)
            self._evaluations += sum(live.refresh(scene) for live in meshes)

    def __plotter_close__(self) -> None:
        """Let go of everything; PyVista calls it at every close."""
        for renderer, tag in self._observers:
            renderer.RemoveObserver(tag)
        self._observers.clear()
        self._meshes.clear()
        self._rigs.clear()
