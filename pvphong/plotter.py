"""`plotter.phong`: lit meshes that follow the camera, the lights and edits.

PyVista imports this module when `plotter.phong` is first used.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.display import Display
from pvphong.base.handles import Handle
from pvphong.meshes.blocks import leaves
from pvphong.meshes.glance import warn_of_normals
from pvphong.meshes.pictures import refuse_colouring, vertex_opacity, with_opacity
from pvphong.meshes.stages import Stage, StageOptions
from pvphong.meshes.surfaces import FeatureAngle, surface
from pvphong.optics.lights import Light
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.studies.validate.validation import Comparison, validate
from pvphong.studio.gizmos import Gizmo, Gizmos, Interaction, Keys, Options, check_keys
from pvphong.studio.keywords import as_mesh, is_bare, look_of
from pvphong.studio.lit_mesh import LitMesh, lit_meshes
from pvphong.studio.live import LightHandle, MeshHandle, changed_light
from pvphong.studio.outputs import Outputs
from pvphong.studio.readings import Readings
from pvphong.studio.subplot import Subplot
from pvphong.studio.web import refuse_missing_extra

_NO_KEYS: Keys = MappingProxyType({})


_STAGE, _STAGE_NAME = Material(ambient=0.6, diffuse=0.6), "stage"


class PlotterPhong(Readings, Handle):
    """Lighting of one plotter. Each subplot has its own lights; all subplots share the light model.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> plotter = pv.Plotter(off_screen=True, lighting="none")
    >>> sun = plotter.phong.add_light(ph.DirectionalLight(name="sun"))
    >>> actor = plotter.phong.add_mesh(pv.Sphere(), "gold", show_edges=True)
    >>> sun.intensity = 0.8  # the next frame shows it
    >>> plotter.phong.set_light("sun", diffuse="orange")
    >>> plotter.phong.undo(), plotter.phong.redo()
    (True, True)
    >>> plotter.phong.light_model = ph.LightModel(ambient=0.1)
    >>> plotter.phong.mesh(actor).material = ph.Material.named("silver")
    >>> gizmos = plotter.phong.add_gizmos()
    >>> plotter.phong.gizmos == gizmos, list(gizmos[0].handles)
    (True, ['target', 'origin'])
    >>> plotter.phong.remove_gizmos()
    >>> plotter.show(auto_close=False)
    >>> plotter.phong.validate().passed
    True
    >>> plotter.phong.scene.light_model.ambient
    0.1
    >>> plotter.phong.remove_light("sun")
    >>> plotter.phong.lights
    ()
    >>> lit = pv.Cube().phong.shade(ph.DirectionalLight())
    >>> box = plotter.phong.add_lit(lit)
    """

    _instead = dict.fromkeys(LightModel.__dataclass_fields__, "light_model")

    def __init__(self, plotter: pv.Plotter) -> None:
        super().__init__(plotter)
        self._outputs = Outputs(self._owner, self._subplots)

    def __repr__(self) -> str:
        meshes = sum(len(subplot.lit.meshes) for subplot in self._subplots)
        return f"<phong of a plotter: {meshes} lit meshes in {len(self._subplots)} subplots, {self._light_model}>"

    # -- meshes ------------------------------------------------------------------------------------------

    def add_mesh(
        self,
        mesh: pv.DataSet | pv.MultiBlock,
        material: Material | str | Mapping[str, Material | str] | None = None,
        *,
        feature_angle: FeatureAngle = "auto",
        casts_shadows: bool = True,
        refine: float | None = None,
        **add_mesh_options: Any,
    ) -> pv.Actor | tuple[pv.Actor, ...]:
        """Draw a mesh, or all blocks of a MultiBlock, with lit colours that stay up to date.

        Before a frame, colours are computed again if something that they depend on has changed: a light, the actor's
        matrix, the material, its maps, the mesh or the light model. Colours depend on the camera only if there are
        highlights, or lights that move with the camera. A hidden actor is updated when it is shown again.

        Parameters
        ----------
        mesh : pyvista.DataSet or pyvista.MultiBlock
            A dataset with a surface, or several in blocks. Later edits of their data are shown. Blocks that are added
            later are not drawn, and blocks that are removed later stay in the picture.
        material : Material, str or mapping, optional
            Material, or the name of a predefined one. For a MultiBlock, a material for all blocks, or a mapping from
            block names to materials, as for `blocks.phong.shade`. By default, the material is made from PyVista's
            keywords and theme.
        feature_angle : float, "auto" or None, default "auto"
            An edge is sharp if the normals of its two faces differ by more than this angle, in degrees, as for
            `mesh.phong.shade`. "auto" is 30 if the mesh has no point normals.
        casts_shadows : bool, default True
            Let the mesh block light, if `light_model` has shadows or ambient occlusion. Visible meshes of a subplot
            shadow each other and themselves.
        refine : float, optional
            Largest allowed colour error inside triangles, > 0: the mesh is refined as by `mesh.phong.refine`. 1/255 is
            one step of a display. Edges of hard shadows and cones become crisp. After each edit, the unrefined mesh is
            drawn until the refined mesh has been computed in the background; pictures and exports wait for the refined
            mesh. At most 200,000 points are added, and none if the mesh has vertex or line cells.
        **add_mesh_options
            As for `pyvista.Plotter.add_mesh`. With `LightModel.vtk()` the result looks the same as PyVista's.

            - `color`, `ambient`, `diffuse`, `specular`, `specular_power`, `pbr`, `metallic` and `roughness` define the
              material. `rgb`, `texture`, and `scalars` with `cmap`, `clim` and related keywords define its albedo; the
              scalar bar shows the unlit colours. Cell data give flat faces.
            - `smooth_shading` and `split_sharp_edges` override `feature_angle`.
            - `lighting=False` without a material draws the mesh unlit, as PyVista does. Without a material, lines, and
              points without normals, are always drawn unlit.
            - `opacity` may be an array of numbers from 0 to 1, or the name of such an array, with one number per point.
              With `feature_angle=0`, one number per cell is allowed too. Later edits of a named array are shown.
            - With a `name`, blocks are called "name[block]", and replace earlier blocks of the same name.
            - `backface_params` and `emissive` are refused.

        Returns
        -------
        pyvista.Actor or tuple of pyvista.Actor
            The actor, drawn with VTK's lighting off; for a MultiBlock, a tuple with one actor for each block.
            `plotter.remove_actor` accepts the actor or the tuple, and ends the updates.

        Raises
        ------
        ValueError
            If an argument is invalid, or the mesh has nothing to light.

        Warns
        -----
        NormalsWarning
            As `mesh.phong.shade`.
        """
        check.flag("casts_shadows", casts_shadows)
        tolerance = None if refine is None else check.number("refine", refine, above=0.0)
        subplot, plotter = self._subplot, self._plotter
        if add_mesh_options.get("lighting") is False and material is None:
            return subplot.add_unlit(functools.partial(plotter.add_mesh, mesh, **add_mesh_options))
        mesh = as_mesh(mesh, copies=bool(add_mesh_options.pop("copy_mesh", False)))
        if material is None and is_bare(mesh):
            return plotter.add_mesh(mesh, **add_mesh_options)
        add_mesh_options.pop("lighting", None)
        next_color = functools.partial(getattr, subplot.renderer, "next_color")
        look = look_of(mesh, material, feature_angle, add_mesh_options, plotter.theme, next_color)
        add_mesh_options = look.options
        meshes = lit_meshes(mesh, look.materials, look.feature_angle, look.opacity)
        for lit in meshes.values():
            lit.casts_shadows = casts_shadows
            subplot.lit.light(lit)
        name, names = add_mesh_options.pop("name", None), set[str]()
        for block, lit in meshes.items():
            named = {} if name is None else {"name": f"{name}[{block}]" if block else name}
            lit.actor = self._draw(
                lit.drawn, lit.shown_array, add_mesh_options | named
            )  # replaces an actor of the same name
            subplot.lit.add(lit, tolerance)
            names.update(named.values())
        if name is not None:  # after drawing, which raises for a wrong option: then the old actors stay
            for other in [other for other in subplot.renderer.actors if other == name or other.startswith(f"{name}[")]:
                if other not in names:  # plotter.remove_actor would remove the name from all subplots
                    subplot.renderer.remove_actor(other, render=False)
        if look.bar is not None:
            look.bar.add_to(plotter)
        if look.silhouette is not None:
            for lit in meshes.values():
                outline = plotter.add_silhouette(surface(lit.mesh), **look.silhouette)
                outline.user_matrix = None if lit.matrix is None else lit.matrix
        self._outputs.prepare()
        for lit in meshes.values():  # after drawing, which may move the camera
            warn_of_normals(lit.mesh, lit.drawn, subplot.scene, lit.matrix)
        actors = tuple(lit.actor for lit in meshes.values())
        return actors if isinstance(mesh, pv.MultiBlock) else actors[0]

    def _draw(self, mesh: Any, array: str, options: dict[str, Any]) -> pv.Actor:
        """Draw a mesh in the colours of its point array `array`; `options` are those of `pyvista.Plotter.add_mesh`."""
        draw = functools.partial(self._plotter.add_mesh, mesh, scalars=array, rgb=True, lighting=False, **options)
        actor = self._subplot.add_unlit(draw)
        actor.prop.color = "white"  # VTK's exporters write this colour too, and glTF multiplies vertex colours by it
        return actor

    def add_lit(
        self, lit: pv.DataSet | pv.MultiBlock, name: str = "phong", **add_mesh_options: Any
    ) -> pv.Actor | tuple[pv.Actor, ...]:
        """Draw a lit mesh in its stored colours, clipped to [0, 1], as `lit.phong.plot()` does.

        The colours do not change with the plotter's lights or camera.

        Parameters
        ----------
        lit : pyvista.DataSet or pyvista.MultiBlock
            Result of `mesh.phong.shade`, also if read from a file; it is not modified.
        name : str, default "phong"
            Name of the point array with the colours.
        **add_mesh_options
            Options of `pyvista.Plotter.add_mesh`, except those that colour the mesh.

        Returns
        -------
        pyvista.Actor or tuple of pyvista.Actor
            The actor, or one actor for each block of a MultiBlock.

        Raises
        ------
        ValueError
            If an option is invalid, `lit` has no mesh, or a mesh has no array of this name.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> plotter = pv.Plotter(off_screen=True)
        >>> actor = plotter.phong.add_lit(pv.Sphere().phong.shade(ph.DirectionalLight()))
        >>> plotter.close()
        """
        refuse_colouring(add_mesh_options)
        if not isinstance(lit, pv.DataSet | pv.MultiBlock):
            check.refuse("lit", type(lit).__name__, "a pyvista.DataSet or a pyvista.MultiBlock")
        meshes = leaves(lit)
        if not meshes:
            check.refuse("lit", "a MultiBlock without meshes", "a MultiBlock with at least one mesh")
        for mesh in meshes:
            check.choice("name", name, mesh.point_data.keys())
        opacity = vertex_opacity(add_mesh_options)
        actors = tuple(self._draw(with_opacity(mesh, name, opacity), name, add_mesh_options) for mesh in meshes)
        return actors if isinstance(lit, pv.MultiBlock) else actors[0]

    def add_stage(self, kind: Stage = "backdrop", material: Material | str | None = None) -> pv.Actor:
        """Draw a stage under the visible lit meshes of the active subplot: a ground, a curved backdrop or a plinth.

        It replaces an earlier stage. The meshes cast shadows on it if `light_model` has shadows.
        `plotter.remove_actor("stage")` removes it.

        Parameters
        ----------
        kind : {"backdrop", "ground", "plinth"}
            The stage; see `ph.stage`. The wall of a backdrop is opposite to the present camera.
        material : Material or str, optional
            Material of the stage; by default a matt light grey.

        Returns
        -------
        pyvista.Actor
            The actor. Use `mesh(actor)` to change its material.

        Raises
        ------
        ValueError
            If `kind` is unknown, or no lit mesh is visible.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> plotter = pv.Plotter(off_screen=True)
        >>> actor = plotter.phong.add_mesh(pv.Sphere(), "gold")
        >>> actor = plotter.phong.add_stage("plinth")
        >>> plotter.close()
        """
        lit, renderer = self._subplot.lit, self._subplot.renderer
        bounds = [mesh.actor.bounds for mesh in lit.subjects if mesh.actor is not None]
        if not bounds:
            check.refuse("plotter", "one without a lit mesh", "a plotter that shows a lit mesh", "Call add_mesh first.")
        taken = renderer.actors.get(_STAGE_NAME)
        if taken is not None and (lit.stage is None or lit.stage.actor is not taken):
            remedy = "Add that actor by another name."
            check.refuse("plotter", "one that has it", f"without another actor {_STAGE_NAME!r}", remedy)
        low, high = np.min(bounds, axis=0)[::2], np.max(bounds, axis=0)[1::2]
        viewer = self._subplot.lights.viewer if renderer.camera_set else None  # else PyVista's default view comes later
        options = StageOptions(tuple(np.stack([low, high], axis=1).ravel().tolist()), kind, viewer)
        actor: pv.Actor = self.add_mesh(
            options.make(),
            _STAGE if material is None else material,
            feature_angle=lit.subjects[0].feature_angle,  # so that one call of `shade` can light both
            name=_STAGE_NAME,
            reset_camera=False,
        )
        self._drawn(actor)[1].stage = options
        return actor

    def mesh(self, actor: pv.Actor) -> MeshHandle:
        """Return a handle to a lit mesh. Set the handle's `material`, or fields of the material, to change the mesh.

        Blocks that share a material change together.

        Returns
        -------
        MeshHandle
            For example, `plotter.phong.mesh(actor).diffuse = "red"` shows in the next frame. With gizmos, each
            assignment is one step of `undo`.

        Raises
        ------
        ValueError
            If the actor was not returned by `add_mesh`, or has been removed.
        """
        subplot, lit = self._drawn(actor)
        return MeshHandle(lit, subplot)

    def _drawn(self, actor: pv.Actor) -> tuple[Subplot, LitMesh]:
        """Return the lit mesh that an actor draws, and its subplot."""
        for subplot in self._subplots:
            for lit in subplot.lit.meshes:
                if lit.actor is actor:
                    return subplot, lit
        return check.refuse("actor", actor, "an actor from plotter.phong.add_mesh that has not been removed")

    def validate(self, actor: pv.Actor | None = None) -> Comparison:
        """Compare the colours of lit meshes with VTK's shader, for the current lights, camera and matrix.

        Parameters
        ----------
        actor : pyvista.Actor, optional
            Actor of the mesh to compare. By default, all visible lit meshes of the active subplot are compared, and the
            comparison with the largest error is returned.

        Returns
        -------
        Comparison
            The comparison, as from `pvphong.validate`; print it for a table.

        Raises
        ------
        ValueError
            If there is no lit mesh, its material has maps, or VTK's shader cannot draw the scene.
        """
        if actor is None:
            subplot = self._subplot
            compared = subplot.lit.shown
        else:
            subplot, lit = self._drawn(actor)
            compared = [lit]
        if not compared:
            allowed = "a plotter whose active subplot shows a lit mesh"
            check.refuse(
                "plotter",
                "a subplot without visible lit meshes",
                allowed,
                "Draw a mesh with plotter.phong.add_mesh(...).",
            )
        comparisons = [validate(lit.drawn, subplot.scene, lit.material, matrix=lit.matrix) for lit in compared]
        return max(comparisons, key=lambda each: each.max_error / each.tolerance)

    # -- lights ------------------------------------------------------------------------------------------

    @property
    def lights(self) -> tuple[Light, ...]:
        """Lights of the active subplot, as immutable values; the plotter's `pyvista.Light` objects are converted."""
        return self._subplot.lights.values

    def add_light(self, light: Any) -> LightHandle:
        """Add a light to the active subplot. The new light also lights the actors that VTK lights.

        Set the fields of the returned handle to move or change the light; the next frame shows it.

        Parameters
        ----------
        light : Light, pyvista.Light or vtkLight
            The light.

        Returns
        -------
        LightHandle
            Handle of the light: `lamp.position = (1, 0, 2)` moves it. With gizmos, each assignment is one step of
            `undo`. `set_light` and `remove_light` accept the handle.

        Raises
        ------
        ValueError
            If `light` is not a light, VTK has no similar light, or the subplot already has this light or another light
            of the same name.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> plotter = pv.Plotter(off_screen=True)
        >>> lamp = plotter.phong.add_light(ph.PointLight(position=(0, 0, 2)))
        >>> lamp.position = (1, 0, 2)
        >>> plotter.close()
        """
        subplot = self._subplot
        with self._history.edit(subplot.lights):
            return LightHandle(subplot.lights.add(light), subplot)

    def set_light(self, which: Any, light: Light | None = None, **fields: Any) -> None:
        """Replace a light of the active subplot, or change some of its fields.

        Parameters
        ----------
        which : LightHandle, int, str or pyvista.Light
            The light: a handle from `add_light`, its index in `lights`, its name, or its PyVista light.
        light : Light, optional
            The new value.
        **fields
            New values of fields, instead of a new light, as in `set_light("lamp", intensity=2)`.

        Raises
        ------
        ValueError
            If the light or a field does not exist, `light` is not a light, VTK has no similar light, another light has
            the same name, or neither `light` nor a field is given.
        """
        lights = self._subplot.lights
        if light is None or fields:
            light = changed_light(lights.find(which).light(lights.viewer), light, fields)
        if not isinstance(light, Light):
            check.refuse("light", light, "a pvphong light", "Convert a pyvista.Light with pvphong.as_light(...).")
        with self._history.edit(lights):
            lights.set(which, light)

    def remove_light(self, which: Any) -> None:
        """Remove a light from the active subplot; `which` is as for `set_light`."""
        lights = self._subplot.lights
        with self._history.edit(lights):
            lights.remove(which)

    def undo(self) -> bool:
        """Undo the last step, and draw. Lights and colours are restored exactly.

        Steps are calls of `add_light`, `set_light` and `remove_light` and, with gizmos, drags, keys and assignments
        to the fields of a handle. Without gizmos, assignments such as ``lamp.position = (1, 0, 2)`` are not steps, so
        an animation records nothing. If no subplot has gizmos yet, `add_gizmos` forgets all earlier steps.

        Returns
        -------
        bool
            False if there is nothing to undo.
        """
        done = self._history.undo()
        if done:
            self._plotter.render()
        return done

    def redo(self) -> bool:
        """Redo the last undone step; return False if there is no such step."""
        done = self._history.redo()
        if done:
            self._plotter.render()
        return done

    @property
    def light_model(self) -> LightModel:
        """Light model of all subplots. It can be set."""
        return self._light_model

    @light_model.setter
    def light_model(self, model: LightModel) -> None:
        if not isinstance(model, LightModel):
            check.refuse("light_model", model, "a LightModel")
        self._light_model = model
        for subplot in self._subplots:
            subplot.light_model = model

    @property
    def display(self) -> Display:
        """Transform that shows the colours of all lit meshes: exposure, tone curve and overlay. It can be set.

        For a display other than the default, the light model does not clamp colours before they are transformed. The
        display does not change the colours of `add_lit`.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> plotter = pv.Plotter(off_screen=True)
        >>> plotter.phong.display = ph.Display(exposure=-1, tone="filmic")
        >>> plotter.phong.exposure
        -1.0
        >>> plotter.close()
        """
        return self._display

    @display.setter
    def display(self, display: Display) -> None:
        if not isinstance(display, Display):
            check.refuse("display", display, "a Display")
        self._display = display
        for subplot in self._subplots:
            subplot.lit.display = display

    @property
    def exposure(self) -> float:
        """Exposure of `display`, in stops. It can be set: 1 shows colours twice as bright.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> plotter = pv.Plotter(off_screen=True)
        >>> plotter.phong.exposure = 1
        >>> plotter.close()
        """
        return self._display.exposure

    @exposure.setter
    def exposure(self, stops: float) -> None:
        self.display = replace(self._display, exposure=stops)

    @property
    def scene(self) -> Scene:
        """Current scene of the active subplot: its lights, its camera and the light model."""
        return self._subplot.scene

    # -- gizmos ------------------------------------------------------------------------------------------

    def add_gizmos(
        self,
        lights: Sequence[Any] | None = None,
        *,
        in_screenshots: bool = False,
        angle_step: float = 5.0,
        length_step: float | None = None,
        keys: Keys = _NO_KEYS,
    ) -> tuple[Gizmo, ...]:
        """Add a gizmo for each light of the active subplot, to drag with the mouse.

        Handles move a light's position, its target, its cone, its size or the radius of half intensity, turn a sky
        around the scene, or move the highlight of the selected light on the surface. With Shift a handle moves along
        one axis, with Ctrl in steps; Escape cancels the drag. The key h lists the other keys. `undo` reverts
        only changes that were made after gizmos were first added.

        Parameters
        ----------
        lights : sequence, optional
            Lights that get a gizmo, each given like `which` of `set_light`; by default all, including lights added
            later.
        in_screenshots : bool, default False
            Show gizmos in `plotter.screenshot` and `save_graphic`.
        angle_step : float, default 5
            Step of angles with Ctrl, in degrees.
        length_step : float, optional
            Step of coordinates and lengths with Ctrl; by default a round number between 1/50 and 1/20 of the scene's
            size.
        keys : mapping, optional
            Additional keys: key → (help text, function without arguments). If the function returns a text, it is shown
            in the window.

        Returns
        -------
        tuple of Gizmo
            The gizmos, as in the property `gizmos`.

        Raises
        ------
        ValueError
            If an argument is invalid.
        """
        subplot = self._subplot
        if isinstance(lights, str) or not isinstance(lights, Iterable | None):
            check.refuse("lights", lights, "a sequence of lights, or None for all", "Put a single light into a list.")
        only = None if lights is None else [subplot.lights.find(which) for which in lights]
        options = Options(
            check.flag("in_screenshots", in_screenshots),
            check.number("angle_step", angle_step, above=0.0, at_most=90.0),
            None if length_step is None else check.number("length_step", length_step, above=0.0),
            check_keys(keys),
        )
        if not self._interactions:
            self._history.clear()  # undo must not revert what the script has set up
        self.remove_gizmos()
        owner = self._owner

        def render() -> None:  # plotter.render also updates trame's views; the closure must not keep the plotter alive
            if (plotter := owner()) is not None:
                plotter.render()

        window = subplot.renderer, self._plotter.iren.interactor, render
        gizmos = Gizmos(*window, subplot.lights, subplot.lit, self._history, only, options)
        subplot.interaction = Interaction(gizmos)
        self._outputs.prepare()
        render()
        return self.gizmos

    def remove_gizmos(self) -> None:
        """Remove the active subplot's gizmos, if there are any."""
        if self._subplot.remove_gizmos():
            self._plotter.render()

    @property
    def gizmos(self) -> tuple[Gizmo, ...]:
        """Gizmos of the active subplot. Each has `.light`, its current light, and `.handles`, name → position."""
        interaction = self._subplot.interaction
        return () if interaction is None else interaction.gizmos.all

    @property
    def _interactions(self) -> list[Interaction]:
        """Interactions of the subplots that have gizmos."""
        return [each.interaction for each in self._subplots if each.interaction is not None]

    # -- the studio --------------------------------------------------------------------------------------

    def studio(
        self,
        *,
        file: str = "mesh.vtp",
        port: int = 0,
        host: str = "127.0.0.1",
        browser: bool = True,
        keep: str | os.PathLike[str] | None = None,
    ) -> Any:
        """Open a web page for the active subplot, to edit its lights, materials and light model; it shows the gizmos.

        Needs the extra `trame`. Edits change the plotter itself: its `lights`, its `scene` and the materials. In a
        notebook, the call returns and the page appears below the cell. Elsewhere, the call prints the page's address
        and serves the page until Ctrl-C is pressed.

        Parameters
        ----------
        file : str, default "mesh.vtp"
            File that the mesh was read from, for the script that the page offers as a download. Other downloads are
            named after it. The studio does not open the file.
        port : int, default 0
            Port to listen on; 0 selects a free one.
        host : str, default "127.0.0.1"
            Address to listen on; by default only this machine can connect. With any other host, the page's address ends
            with a token, and requests without the token get no answer.
        browser : bool, default True
            Open the page in a browser, except in a notebook.
        keep : path, optional
            JSON file to which lights, viewer, light model and materials are saved after each change, as by
            `Scene.save`. After another mesh is opened in the page, nothing is saved until this is undone. Materials of
            meshes that the page adds beside it are not saved.

        Returns
        -------
        StudioFrame or None
            In a notebook, the object that displays the page; elsewhere None.

        Raises
        ------
        ValueError
            If an argument is invalid, or the extra is not installed.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> plotter = pv.Plotter(off_screen=True, lighting="none")
        >>> plotter.phong.studio()  # doctest: +SKIP
        """
        refuse_missing_extra("plotter.phong.studio")
        from pvphong.studio.web.serving import serve

        if not self.gizmos:
            self.add_gizmos()
        options: dict[str, Any] = {"file": file, "port": port, "host": host, "browser": browser, "keep": keep}
        return serve(self._plotter, self._subplot, self._history, **options)

    # -- lifetime ----------------------------------------------------------------------------------------

    def __plotter_close__(self) -> None:
        """Release all resources; PyVista calls this whenever the plotter is closed."""
        for subplot in self._subplots:
            subplot.release()
        self._outputs.release()
        self._subplots.clear()
        self._history.clear()

    def __plotter_deep_clean__(self) -> None:
        """Release all resources, as when the plotter is closed.

        A cleaned plotter has no camera, but may still receive events.
        """
        self.__plotter_close__()


pv.register_plotter_component("phong")(PlotterPhong)  # not as a decorator, for the reason given in `accessor`
