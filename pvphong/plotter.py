"""`plotter.phong`: lit meshes that follow camera, lights and edits. PyVista finds this module by its entry point."""

from __future__ import annotations

import functools
import os
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from types import MappingProxyType
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.handles import Handle
from pvphong.meshes.blocks import leaves
from pvphong.meshes.glance import warn_of_normals
from pvphong.meshes.pictures import refuse_colouring, vertex_opacity, with_opacity
from pvphong.meshes.surfaces import FeatureAngle, has_faces, surface
from pvphong.optics.lights import Light
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.studies.validate.validation import Comparison, validate
from pvphong.studio.gizmos import Gizmo, Gizmos, History, Interaction, Keys, Options, check_keys
from pvphong.studio.keywords import look_of
from pvphong.studio.lit_mesh import LitMesh, lit_meshes
from pvphong.studio.live import LightHandle, MeshHandle, changed_light
from pvphong.studio.subplot import Subplot
from pvphong.studio.web import refuse_missing_extra

_NO_KEYS: Keys = MappingProxyType({})

_OUTPUTS = (
    "screenshot",
    "save_graphic",
    "export_html",
    "export_vtksz",
    "export_gltf",
    "export_obj",
    "export_vrml",
)
"""Methods of a plotter that write what it shows: made of colours that are current, and without gizmos."""


class PlotterPhong(Handle):
    """Lighting in one plotter: every subplot has its own lights, all share the light model.

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
        self._owner = weakref.ref(plotter)
        self._light_model = LightModel()
        self._subplots: list[Subplot] = []
        self._history = History()
        self._wrapped: dict[str, Callable[..., Any]] = {}

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
        """Draw a mesh, or all blocks of a MultiBlock, with lit colours, and keep them current.

        Before a frame is drawn its colours are computed again if, and only if, something that they depend on
        has changed: a light, the actor's matrix, the material, its maps, the mesh, the light model; the
        camera only where highlights or lights that ride along make it count. A hidden actor waits until it is
        shown, a removed one is followed no longer.

        Parameters
        ----------
        mesh : pyvista.DataSet or pyvista.MultiBlock
            A dataset with a surface, or blocks of such; edits to them are followed, blocks that are put in or taken
            out are not.
        material : Material, str or mapping, optional
            The surface's reflectances, numbers or maps, or the name of a material. Blocks share it, or a mapping has
            one for each, as for `blocks.phong.shade`. If not given, PyVista's keywords say it, and its theme.
        feature_angle : float, "auto" or None, default "auto"
            Degrees between two faces from which their common edge is sharp, as for `mesh.phong.shade`; "auto" takes
            30 where the mesh has no point normals of its own.
        casts_shadows : bool, default True
            Whether it blocks light where `light_model` has shadows or ambient occlusion: all such meshes of a
            subplot that are visible shadow each other and themselves.
        refine : float, optional
            Largest colour error inside of triangles, > 0, as the tolerance of `mesh.phong.refine`; 1/255 is one step of
            a display. While nothing is dragged or edited the mesh is drawn refined, with crisp edges of hard shadows
            and cones; until that is computed, in the background, at its own vertices. Pictures and exports wait for it.
            It adds 200,000 points at most, and none where vertices or lines are drawn as such.
        **add_mesh_options
            As for `pyvista.Plotter.add_mesh`, which draws the same in the same lights with `LightModel.vtk()`: `color`,
            `ambient`, `diffuse`, `specular`, `specular_power`, `pbr`, `metallic` and `roughness` are the material;
            `scalars` with `cmap`, `clim` and all that belongs to them, `rgb` and `texture` its albedo, with a scalar
            bar of the colours before light; cell data give flat faces. `smooth_shading` and `split_sharp_edges` say
            where edges are sharp; without them `feature_angle` does. With `lighting=False` PyVista draws it as it is,
            and without a material lines, and points that have no normals, too.
            `backface_params` and `emissive` are refused. With a `name` blocks are called "name[block]", and replace
            those drawn under the name before. `opacity` may have a number from 0 to 1 for each point, or for each cell
            where faces share no points (`feature_angle=0`), or be the name of such an array, which is followed.

        Returns
        -------
        pyvista.Actor or tuple of pyvista.Actor
            An ordinary actor, drawn with VTK's lighting off; one for each block. `plotter.remove_actor` takes either.

        Raises
        ------
        ValueError
            If an argument is not allowed, or the mesh has nothing that can be lit.

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
        mesh = _as_mesh(mesh, copies=bool(add_mesh_options.pop("copy_mesh", False)))
        if material is None and _is_bare(mesh):
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
            )  # in place of what has its very name
            subplot.lit.add(lit, tolerance)
            names.update(named.values())
        if name is not None:  # only now, for a wrong option is refused by what draws
            for other in [other for other in subplot.renderer.actors if other == name or other.startswith(f"{name}[")]:
                if other not in names:  # of this renderer alone: a plotter takes the name out of all of them
                    subplot.renderer.remove_actor(other, render=False)
        if look.bar is not None:
            look.bar.add_to(plotter)
        if look.silhouette is not None:
            for lit in meshes.values():
                outline = plotter.add_silhouette(surface(lit.mesh), **look.silhouette)
                outline.user_matrix = None if lit.matrix is None else lit.matrix
        self._prepare_outputs()
        for lit in meshes.values():  # now that the camera is where it will be
            warn_of_normals(lit.mesh, lit.drawn, subplot.scene, lit.matrix)
        actors = tuple(lit.actor for lit in meshes.values())
        return actors if isinstance(mesh, pv.MultiBlock) else actors[0]

    def _draw(self, mesh: Any, array: str, options: dict[str, Any]) -> pv.Actor:
        """Draw a mesh in the colours of one of its point arrays."""
        draw = functools.partial(self._plotter.add_mesh, mesh, scalars=array, rgb=True, lighting=False, **options)
        actor = self._subplot.add_unlit(draw)
        actor.prop.color = "white"  # VTK's exporters write it too, and glTF multiplies colours by it
        return actor

    def add_lit(
        self, lit: pv.DataSet | pv.MultiBlock, name: str = "phong", **add_mesh_options: Any
    ) -> pv.Actor | tuple[pv.Actor, ...]:
        """Draw a mesh that is lit already: its colours as they are, clipped to [0, 1], as `lit.phong.plot()` does.

        Nothing is lit again: the colours stay what they are when lights or the camera move.

        Parameters
        ----------
        lit : pyvista.DataSet or pyvista.MultiBlock
            What `mesh.phong.shade` gave, or a file of it that was read back; it is not modified.
        name : str, default "phong"
            Name of the point array with the colours.
        **add_mesh_options
            As for `pyvista.Plotter.add_mesh`, without those that colour the mesh.

        Returns
        -------
        pyvista.Actor or tuple of pyvista.Actor
            An ordinary actor; one for each block of a MultiBlock.

        Raises
        ------
        ValueError
            If an option is not allowed, or there is no mesh with such an array.

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
            check.refuse("lit", "blocks without any mesh", "a MultiBlock with a mesh in it")
        for mesh in meshes:
            check.choice("name", name, mesh.point_data.keys())
        opacity = vertex_opacity(add_mesh_options)
        actors = tuple(self._draw(with_opacity(mesh, name, opacity), name, add_mesh_options) for mesh in meshes)
        return actors if isinstance(lit, pv.MultiBlock) else actors[0]

    def mesh(self, actor: pv.Actor) -> MeshHandle:
        """Handle of the mesh that `add_mesh` drew as an actor. Its `material`, shared by blocks, and its fields can be
        set.

        Returns
        -------
        MeshHandle
            `plotter.phong.mesh(actor).diffuse = "red"` shows in the next frame; it is one step of `undo` where gizmos
            are up.

        Raises
        ------
        ValueError
            If the actor is not one of `add_mesh`, or has been removed.
        """
        subplot, lit = self._drawn(actor)
        return MeshHandle(lit, subplot)

    def _drawn(self, actor: pv.Actor) -> tuple[Subplot, LitMesh]:
        """The lit mesh that is drawn as an actor, and where."""
        for subplot in self._subplots:
            for lit in subplot.lit.meshes:
                if lit.actor is actor:
                    return subplot, lit
        return check.refuse("actor", actor, "an actor that plotter.phong.add_mesh returned, not removed since")

    def validate(self, actor: pv.Actor | None = None) -> Comparison:
        """Compare what is on the screen with VTK's own shader, in the lights, the camera and the place it has now.

        Parameters
        ----------
        actor : pyvista.Actor, optional
            One of the lit meshes; if not given, the one of the active subplot that does worst.

        Returns
        -------
        Comparison
            As `pvphong.validate` gives it; print it for a table.

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
            check.refuse("plotter", "a subplot without any", "one with a lit mesh", "phong.add_mesh draws one.")
        comparisons = [validate(lit.drawn, subplot.scene, lit.material, matrix=lit.matrix) for lit in compared]
        return max(comparisons, key=lambda each: each.max_error / each.tolerance)

    # -- lights ------------------------------------------------------------------------------------------

    @property
    def lights(self) -> tuple[Light, ...]:
        """The active subplot's lights as values, the plotter's own `pyvista.Light` objects among them."""
        return self._subplot.lights.values

    def add_light(self, light: Any) -> LightHandle:
        """Add a light to the active subplot; it lights the actors that VTK lights too.

        Set the fields of what it returns to move or change the light: the next frame shows it.

        Parameters
        ----------
        light : Light, pyvista.Light or vtkLight
            The light.

        Returns
        -------
        LightHandle
            The light, live: `lamp.position = (1, 0, 2)` moves it; one step of `undo` where gizmos are up. It also
            names the light for `set_light` and `remove_light`.

        Raises
        ------
        ValueError
            If it is no light, or one that VTK has nothing like, or the subplot has it, or one of its name, already.

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
        """Replace a light of the active subplot, or change fields of it.

        Parameters
        ----------
        which : LightHandle, int, str or pyvista.Light
            The light: as `add_light` gave it, or by its index in `lights`, its name, or its PyVista light.
        light : Light, optional
            The new value.
        **fields
            New values of some fields, where no new light is given, as in `set_light("lamp", intensity=2)`.

        Raises
        ------
        ValueError
            If there is no such light or field, or `light` is none, or one that VTK has nothing like, or another light
            has its name; and if there is nothing to set.
        """
        lights = self._subplot.lights
        if light is None or fields:
            light = changed_light(lights.find(which).light(lights.viewer), light, fields)
        if not isinstance(light, Light):
            check.refuse("light", light, "a light of pvphong's", "as_light converts a pyvista.Light.")
        with self._history.edit(lights):
            lights.set(which, light)

    def remove_light(self, which: Any) -> None:
        """Take a light out of the active subplot; `which` as for `set_light`."""
        lights = self._subplot.lights
        with self._history.edit(lights):
            lights.remove(which)

    def undo(self) -> bool:
        """Take back the last finished drag or edit of a light, and draw; light and colours are as before, to the bit.

        Returns
        -------
        bool
            False if there is nothing to take back.
        """
        done = self._history.undo()
        if done:
            self._plotter.render()
        return done

    def redo(self) -> bool:
        """Do again what `undo` took back last; False if there is nothing."""
        done = self._history.redo()
        if done:
            self._plotter.render()
        return done

    @property
    def light_model(self) -> LightModel:
        """Light model of all subplots; can be set."""
        return self._light_model

    @light_model.setter
    def light_model(self, model: LightModel) -> None:
        if not isinstance(model, LightModel):
            check.refuse("light_model", model, "a LightModel")
        self._light_model = model
        for subplot in self._subplots:
            subplot.light_model = model

    @property
    def scene(self) -> Scene:
        """A snapshot of what lights the active subplot: its lights, its camera, the light model."""
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
        """Put up a gizmo for each light of the active subplot, to be dragged with the mouse.

        Drag a light's position, its target, the edge of its cone, its size, the radius at which half of it is left, the
        front of a sky on the circle around the scene, or, of the light that was grabbed last, its highlight on the
        surface. With Shift a handle moves along one axis, with Ctrl in steps; Escape puts back. The key h lists the
        other keys. Lights set up before are where `undo` ends.

        Parameters
        ----------
        lights : sequence, optional
            The lights, each as for `set_light`; all of them, and those added later, if not given.
        in_screenshots : bool, default False
            Whether gizmos are part of `plotter.screenshot` and `save_graphic`.
        angle_step : float, default 5
            What angles snap to, in degrees.
        length_step : float, optional
            What coordinates and lengths snap to; a round twentieth to fiftieth of the scene if not given.
        keys : mapping, optional
            More keys for the window: key → (what the help says, function without arguments). A text that the function
            gives is shown in the window.

        Returns
        -------
        tuple of Gizmo
            As `gizmos`.

        Raises
        ------
        ValueError
            If an argument is not allowed.
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
            self._history.clear()  # what a script has set up is where the user begins
        self.remove_gizmos()
        owner = self._owner

        def render() -> None:  # trame's views also get the new picture by it; the plotter is not held on to
            if (plotter := owner()) is not None:
                plotter.render()

        window = subplot.renderer, self._plotter.iren.interactor, render
        gizmos = Gizmos(*window, subplot.lights, subplot.lit, self._history, only, options)
        subplot.interaction = Interaction(gizmos)
        self._prepare_outputs()
        render()
        return self.gizmos

    def remove_gizmos(self) -> None:
        """Take the active subplot's gizmos down, if there are any."""
        if self._subplot.remove_gizmos():
            self._plotter.render()

    @property
    def gizmos(self) -> tuple[Gizmo, ...]:
        """The active subplot's gizmos: each has `.light`, the current value, and `.handles`, name → position."""
        interaction = self._subplot.interaction
        return () if interaction is None else interaction.gizmos.all

    @property
    def _interactions(self) -> list[Interaction]:
        """The interactions of the subplots that have gizmos."""
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
        """Edit lights, materials and light model of the active subplot in a web page, with the gizmos in its view.

        Needs the extra `trame`. What is edited there is the plotter's own: afterwards `lights`, `scene` and the
        materials of its meshes are as they were left. In a notebook the page stands below the cell, and the cell ends;
        elsewhere this prints the page's address, and ends with Ctrl-C.

        Parameters
        ----------
        file : str, default "mesh.vtp"
            The file that the mesh was read from: the script that is downloaded reads it, and other files are named
            after it. Nothing is read or written here.
        port : int, default 0
            The port to listen on; 0 is one that is free.
        host : str, default "127.0.0.1"
            The address to listen on: by default this machine serves itself alone. For any other, the page's address
            ends with a token, without which nothing is answered.
        browser : bool, default True
            Whether to open the page in a browser; not in a notebook.
        keep : path, optional
            A file (JSON) to which lights, viewer, light model and materials are written whenever they have changed, as
            `Scene.save` writes them, until another mesh is opened.

        Returns
        -------
        StudioFrame or None
            In a notebook, what shows the page there.

        Raises
        ------
        ValueError
            If an argument is not allowed, or the extra is not installed.

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

    # -- pictures and exports ----------------------------------------------------------------------------

    def _prepare_outputs(self) -> None:
        """Have the plotter's own pictures and exports made as `_prepared` says, once however often it is called."""
        component, owner = weakref.ref(self), self._owner

        def wrapped(method: Any) -> Any:
            @functools.wraps(method)
            def output(*args: Any, **kwargs: Any) -> Any:
                alive = component()
                # with False as its file the picture is one that every `show` keeps of its end, asked or not
                waits = not (args and args[0] is False)
                with nullcontext() if alive is None else alive._prepared(waits):
                    return method(owner(), *args, **kwargs)

            return output

        for name in _OUTPUTS:
            method = getattr(type(self._plotter), name, None)
            if method is not None and name not in vars(self._plotter):
                self._wrapped[name] = wrapped(method)
                setattr(self._plotter, name, self._wrapped[name])

    @contextmanager
    def _prepared(self, waits: bool) -> Iterator[None]:
        """Colours brought up to date, for an exporter draws no frame; gizmos out of sight.

        It may wait for refined pictures.
        """
        interactions = self._interactions
        is_refined = max([subplot.lit.refresh(waits=waits) for subplot in self._subplots], default=False)
        with ExitStack() as stack:
            for interaction in interactions:
                stack.enter_context(interaction.out_of_sight())
            if interactions or is_refined:
                self._plotter.render()
            yield
        if interactions:
            self._plotter.render()

    # -- life --------------------------------------------------------------------------------------------

    @property
    def _plotter(self) -> pv.Plotter:
        plotter = self._owner()
        assert plotter is not None, "the plotter has gone"
        return plotter

    @property
    def _subplot(self) -> Subplot:
        """The active one."""
        renderer = self._plotter.renderer
        if getattr(renderer, "camera", None) is None or self._plotter.render_window is None:
            check.refuse("plotter", "one that has been closed", "open")
        for subplot in self._subplots:
            if subplot.renderer is renderer:
                return subplot
        self._subplots.append(Subplot(renderer, self._light_model, self._history))
        return self._subplots[-1]

    def __plotter_close__(self) -> None:
        """Let go of everything; PyVista calls it at every close."""
        for subplot in self._subplots:
            subplot.release()
        plotter = self._owner()  # it is None for a plotter that is collected without a close
        for name, output in self._wrapped.items():
            if plotter is not None and vars(plotter).get(name) is output:
                delattr(plotter, name)
        self._wrapped.clear()
        self._subplots.clear()
        self._history.clear()

    def __plotter_deep_clean__(self) -> None:
        """As at a close: what PyVista has cleaned has no camera any more, and events may still come."""
        self.__plotter_close__()


def _is_bare(mesh: Any) -> bool:
    """Return True for lines, and for points without normals, which VTK draws as they are."""
    if not isinstance(mesh, pv.PolyData | pv.PointSet) or not mesh.n_points:
        return False
    if isinstance(mesh, pv.PolyData) and has_faces(mesh):
        return False
    return (isinstance(mesh, pv.PolyData) and mesh.n_lines > 0) or mesh.point_data.active_normals_name is None


def _as_mesh(given: Any, *, copies: bool) -> Any:
    """A mesh of what PyVista's `add_mesh` takes: a dataset, blocks, one of VTK's, points, or a file's path."""
    mesh = pv.read(given) if isinstance(given, str | os.PathLike) else given
    if not isinstance(mesh, pv.DataSet | pv.MultiBlock) and (
        isinstance(mesh, np.ndarray) or hasattr(mesh, "GetDataObjectType")
    ):
        mesh = pv.wrap(mesh)
    return mesh.copy(deep=False) if copies else mesh


pv.register_plotter_component("phong")(PlotterPhong)  # not as a decorator, as in `accessor`
