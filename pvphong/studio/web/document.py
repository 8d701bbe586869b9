"""The document that a studio edits: lights, materials, light model, edges, faders and accuracy, with one undo history.

An edit names its field by a key: "light.3.intensity", "material.0.diffuse", "reflectance.0.roughness", "model.shadows",
"display.exposure", "background.background", "surfaces.feature_angle", "fader.3.gain" or "accuracy.tolerance". A light
keeps its number while the studio runs.
"""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import PurePath
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.color import kelvin
from pvphong.base.display import Display
from pvphong.base.types import rgb
from pvphong.meshes.surfaces import FeatureAngle
from pvphong.optics.light import Light
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.maps import Map
from pvphong.optics.material import Material, as_material
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.studio.gizmos import Gizmo, Gizmos, History, commands
from pvphong.studio.gizmos.gizmo import called
from pvphong.studio.lit_actors import MaterialsState
from pvphong.studio.lit_mesh import LitMesh, SharedMaterial
from pvphong.studio.subplot import Subplot
from pvphong.studio.web import coloring
from pvphong.studio.web.fields import edited, form_of, number_in, slid
from pvphong.studio.web.kinds import kind_of, new_reflectance, textured
from pvphong.studio.web.mix import Mix, MixState
from pvphong.studio.web.new_light import brightened, placed_apart
from pvphong.studio.web.opening import OpenFile, Opening, Part, own_names
from pvphong.studio.web.placing import placed, placing_of
from pvphong.studio.web.set_ups import SetUps, SunState
from pvphong.studio.web.settings import Accuracy, Background, Surfaces
from pvphong.studio.web.skies import image_in, with_image
from pvphong.studio.web.staging import Staging
from pvphong.studio.web.words import LIGHTS, in_words
from pvphong.studio.window_lights import LightStates, RendererLight, free_name

_IN_ROW = ("name", "on", "diffuse", "intensity", "casts_shadows")
"""Fields of a light in its row; others are shown for the selected light."""

_FIRST_OF_SCENE = ("ambient", "shadows", "ambient_occlusion", "bounces")
"""Fields of the light model that the page shows first."""


_ACTS: Mapping[str, Callable[[Gizmos, Gizmo], Any]] = {
    "duplicate": commands.duplicate,
    "delete": commands.delete,
    "solo": commands.solo,
    "to camera": commands.to_camera,
    "reset": commands.reset,
}


class DocumentState(NamedTuple):
    """All editable values. States can be compared by ==."""

    lights: LightStates
    materials: MaterialsState
    light_model: LightModel
    display: Display
    accuracy: Accuracy
    mix: MixState
    feature_angles: dict[LitMesh, FeatureAngle]
    parts: tuple[Part, ...]
    stage: LitMesh | None
    background: Background
    sun: SunState | None


class Document:
    """All values that a studio edits.

    Parameters
    ----------
    phong : PlotterPhong
        The lighting of the plotter; its light model is edited.
    subplot : Subplot
        The lights, lit meshes and gizmos.
    history : History
        The undo history, shared with the gizmos.
    opening : Opening, optional
        The files that are shown; None if no other file is ever opened.
    """

    def __init__(self, phong: Any, subplot: Subplot, history: History, opening: Opening | None = None) -> None:
        self._phong, self._subplot, self.history, self._opening = phong, subplot, history, opening
        refined = (each.tolerance for each in subplot.lit.refining.values())
        self._accuracy = Accuracy(refine=min(refined, default=None))
        self.mix = Mix(subplot)
        self.staging = Staging(phong, subplot)
        self.set_ups = SetUps(phong, subplot)
        self._is_transparent = False
        self.textures: dict[Map, str] = {}
        """File names of uploaded textures."""
        self._numbers: dict[RendererLight, int] = {}
        self._middles: dict[str, float] = {}
        self._sliding: tuple[str, Any] | None = None

    @property
    def accuracy(self) -> Accuracy:
        """Accuracy of the colours; can be set."""
        return self._accuracy

    @accuracy.setter
    def accuracy(self, accuracy: Accuracy) -> None:
        before, self._accuracy = self._accuracy, accuracy
        if accuracy.refine != before.refine:
            self._subplot.lit.refine(accuracy.refine)

    @property
    def surfaces(self) -> Surfaces:
        """Shading of the first mesh's edges. Setting it changes all meshes."""
        first = next(iter(self._subplot.lit.subjects), None)
        return Surfaces(None if first is None else first.sharp_angle)

    @surfaces.setter
    def surfaces(self, surfaces: Surfaces) -> None:
        for mesh in self._subplot.lit.meshes:
            mesh.feature_angle = surfaces.feature_angle

    @property
    def background(self) -> Background:
        """Background of the view and of pictures; can be set."""
        return Background(self._subplot.renderer.background_color.float_rgb, self._is_transparent)

    @background.setter
    def background(self, background: Background) -> None:
        self._is_transparent = background.transparent
        if background.background != self.background.background:  # else a gradient would be lost
            self._subplot.renderer.set_background(rgb(background.background))

    # -- undo

    @property
    def state(self) -> DocumentState:
        """All editable values, for the undo history."""
        return DocumentState(
            lights=self._subplot.lights.state,
            materials=self._subplot.lit.state,
            light_model=self._phong.light_model,
            display=self._phong.display,
            accuracy=self.accuracy,
            mix=self.mix.state,
            feature_angles={mesh: mesh.feature_angle for mesh in self._subplot.lit.meshes},
            parts=() if self._opening is None else self._opening.parts,
            stage=self.staging.mesh,
            background=self.background,
            sun=self.set_ups.state,
        )

    def revert(self, now: DocumentState, then: DocumentState) -> None:
        """Undo the changes that were made between the states `then` and `now`."""
        if self._opening is not None and then.parts != now.parts:
            self._opening.show(then.parts, then.accuracy.refine)
        self.staging.show(then.stage, then.accuracy.refine)
        if now.background != then.background:
            self.background = then.background
        self._subplot.lights.revert(now.lights, then.lights)
        self._subplot.lit.revert(now.materials, then.materials)
        if now.light_model != then.light_model:
            self._phong.light_model = then.light_model
        if now.display != then.display:
            self._phong.display = then.display
        if now.accuracy != then.accuracy:
            self.accuracy = then.accuracy
        self.set_ups.state = then.sun
        if now.mix != then.mix:
            self.mix.state = then.mix
        if now.feature_angles != then.feature_angles:
            for mesh, angle in then.feature_angles.items():
                mesh.feature_angle = angle

    @contextmanager
    def _step(self) -> Iterator[None]:
        """Return a context that records the changes made in it as one step. If a mesh cannot be lit after the changes,
        the context reverts them and raises the error.
        """
        self.history.settle()
        before = self.state
        try:
            yield
            for mesh in self._subplot.lit.shown:
                self._subplot.lit.light(mesh)
            self.mix.refresh()
        except ValueError:
            self.revert(self.state, before)
            raise
        self.history.record(self, before)

    def undo(self) -> bool:
        """Undo the last step, of the page or the gizmos; return False if there is none."""
        return self.history.undo()

    def redo(self) -> bool:
        """Redo the last undone step; return False if there is none."""
        return self.history.redo()

    # -- the files that are shown

    @property
    def opening(self) -> Opening:
        """The files that are shown."""
        return self._opening or check.refuse("file", "none", "opened in a studio")

    def open(self, mesh: Any, file: OpenFile, *, beside: bool = False) -> None:
        """Show another file as one undo step, in place of the others or beside them; see `Opening`."""
        with self._step_on_stage():
            if not self.opening.drawn or not (beside or self._subplot.lights.renderer_lights):
                self.set_ups.leave()  # the default lights, which come with the mesh, are not in W/m²
            (self.opening.add if beside else self.opening.open)(mesh, file, self.accuracy.refine)

    def remove_mesh(self, number: Any) -> None:
        """Remove a file's meshes from the view, as one undo step."""
        with self._step_on_stage():
            self.opening.remove(number)

    def rename_mesh(self, number: Any, name: Any) -> None:
        """Give the mesh of a file another name, as one undo step."""
        with self._step():
            self.opening.rename(number, name)

    @contextmanager
    def _step_on_stage(self) -> Iterator[None]:
        """Return a context that records one undo step. At its end, the stage, if any, is put under all meshes."""
        with self._step():
            yield
            self.staging.fit(self.accuracy.refine)

    def set_stage(self, kind: str) -> str:
        """Draw a stage under the meshes, as one undo step, and switch shadows on with the first one; return a message.

        Parameters
        ----------
        kind : str
            "ground", "backdrop", whose wall is opposite to the present camera, or "plinth"; "" removes the stage.
        """
        with self._step():
            has_shadows = not kind or bool(self.staging.kind) or self._phong.light_model.shadows
            self.staging.put(kind, self.accuracy.refine)
            if not has_shadows:
                self._phong.light_model = replace(self._phong.light_model, shadows=True)
        return "" if has_shadows else "Shadows are on now. To switch them off, open Scene."

    def restore(self, state: DocumentState) -> None:
        """Set all values to an earlier state, as one undo step."""
        with self._step():
            self.revert(self.state, state)
            self.revert(self.state, state)  # materials of meshes that were not shown until now

    # -- cancelling background computations

    def cancel_bounces(self) -> str:
        """Cancel the computation of bounced light, and set the light model's `bounces` to the number of bounces in the
        current picture. If `bounces` has this value already, set it to 0. Return a message.
        """
        gathering, model = self._subplot.lit.gathering, self._phong.light_model
        if gathering.part is None:
            return "Bounced light is not being computed."
        drawn = gathering.bounces
        kept = drawn if drawn != model.bounces else 0  # the same number would start the computation again
        self.edit("model.bounces", kept)
        as_before = ", as before" if kept == drawn else ""
        return f"Bounced light is cancelled: bounces = {kept}{as_before}."

    def go_on_refining(self) -> None:
        """Continue refining that was paused."""
        for refining in self._subplot.lit.refining.values():
            refining.go_on()

    def cancel_refining(self) -> None:
        """Cancel refining until the next edit; the last picture stays."""
        for refining in self._subplot.lit.refining.values():
            refining.cancel()

    # -- edits of one value

    def edit(self, key: str, given: Any, index: Sequence[int] = ()) -> None:
        """Set one field, as one undo step. `given` and `index` are as for `fields.edited`.

        Raises
        ------
        ValueError
            If there is no such field, or the value is not allowed; nothing is changed then.
        """
        with self._step():
            self._set(key, lambda value, name: edited(value, name, given, index))
            self.set_ups.rest()

    def slide(self, key: str, given: Any) -> None:
        """Set a number from its slider, or a colour from its picker. All moves until `settle` are one undo step."""
        if self._sliding is None or self._sliding[0] != key:
            self.history.settle()
            self._sliding = key, self.state
            self.history.begin(self)
        self._set(key, partial(slid, given))

    def settle(self) -> None:
        """Record the movement of a slider or picker as one step."""
        sliding, self._sliding = self._sliding, None
        self.set_ups.rest()
        self.history.end(self)
        if sliding is not None:
            self.history.record(self, sliding[1])

    def _set(self, key: str, change: Callable[[Any, str], Any]) -> None:
        """Change the field that a key names. `change` maps a dataclass and a field's name to the changed dataclass."""
        match check.text("key", key).split("."):
            case "accuracy", name:
                self.accuracy = change(self.accuracy, name)
            case "surfaces", name:
                self.surfaces = change(self.surfaces, name)
            case "model", name:
                self._phong.light_model = change(self._phong.light_model, name)
            case "background", name:
                self.background = change(self.background, name)
            case "display", name:
                self._phong.display = change(self._phong.display, name)
            case "sun", name:
                self.set_ups.move(change(self.set_ups.sun, name))
            case "light", number, name:
                self._set_light(self._light(number), name, change)
            case "place", number, name:
                self._place(self._light(number), name, change)
            case "fader", number, name:
                light = self._light(number)
                self.mix.faders[light] = change(self.mix.fader(light), name)
            case "material", number, name:
                shared = self._material(number)
                shared.material = change(shared.material, name)
            case "reflectance", number, name:
                shared = self._material(number)
                if shared.material.reflectance is None:
                    check.refuse("key", key, "the key of an existing field")
                shared.material = replace(shared.material, reflectance=change(shared.material.reflectance, name))
            case _:
                check.refuse("key", key, "the key of a field")

    def _set_light(self, renderer_light: RendererLight, name: str, change: Callable[[Any, str], Any]) -> None:
        viewer = self._subplot.lights.viewer
        before: Light = renderer_light.light(viewer)
        after: Light = change(before, name)
        if after.frame != before.frame:  # keep its position in the world
            after = before.in_world(viewer).in_frame(after.frame, viewer)
        self._subplot.lights.set(renderer_light, after)

    def _place(self, renderer_light: RendererLight, name: str, change: Callable[[Any, str], Any]) -> None:
        """Change azimuth, elevation or distance of a light about its target."""
        view = self.gizmos.view
        shown = self.gizmos.of(renderer_light).in_scene(view)
        placing = placing_of(shown)
        if placing is None:
            check.refuse("light", called(shown.light), "a light with a place or a direction")
        after = placed(shown, change(placing, name)).in_frame(renderer_light.light(view.viewer).frame, view.viewer)
        self._subplot.lights.set(renderer_light, after)

    # -- lights

    @property
    def gizmos(self) -> Gizmos:
        """The gizmos of the view."""
        assert self._subplot.interaction is not None, "a studio has gizmos"
        return self._subplot.interaction.gizmos

    def number(self, renderer_light: RendererLight) -> int:
        """Return the number that keys use for a light."""
        return self._numbers.setdefault(renderer_light, 1 + len(self._numbers))

    def _light(self, number: Any) -> RendererLight:
        for each in self._subplot.lights.renderer_lights:
            if str(self.number(each)) == str(number):
                return each
        return check.refuse("light", number, "the number of an existing light")

    def add(self, kind: str) -> None:
        """Add a light and select it. `kind` is the name of the light's kind in scene files; see `add_light`."""
        self.add_light(LIGHT_TYPES[check.choice("kind", kind, LIGHT_TYPES)](), kind)

    def add_light(self, made: Light, wanted: str) -> None:
        """Place a new light, select it, and call it by the name `wanted`, or by the first one like it that is free.

        The light shines on the scene from the upper left. If lights are there already, the new light is to the right of
        them, and raises the mean of the picture by a third of a stop.
        """
        white = 2.0**-self._phong.display.exposure
        light = placed_apart(made, self.gizmos, self._subplot.lights.viewer)
        light = replace(light, intensity=white * light.intensity)
        if any(known.on for known in self._subplot.lights.values):
            light = brightened(light, self._subplot.scene, self._subplot.lit.shown, white)
        name = free_name(wanted, {known.name for known in self._subplot.lights.values})
        with self._step():
            self.gizmos.add(replace(light, name=name))

    def set_temperature(self, number: Any, temperature: Any) -> None:
        """Give a light the colour of a black body, as one undo step. The temperature is in kelvin, a number or text."""
        self.edit(f"light.{number}.diffuse", kelvin(number_in("temperature", temperature)))

    def set_up(self, name: str) -> None:
        """Replace all lights by a set-up from `setups`, around the visible meshes, as one undo step."""
        with self._step():
            self.set_ups.choose(name)

    def act(self, what: str, number: Any) -> str:
        """Duplicate, delete or solo a light, move it to the camera, or reset it; return a message."""
        act = _ACTS[check.choice("what", what, _ACTS)]
        gizmos, gizmo = self.gizmos, self.gizmos.of(self._light(number))
        gizmos.select(gizmo)
        gizmos.notice = ""
        with self._step():
            commands.change_light(gizmos, gizmo, act)
        return gizmos.notice

    async def set_image(self, number: Any, image: Any) -> None:
        """Set the image of an environment light. Its spherical harmonics are computed in another thread.

        Parameters
        ----------
        number
            Number of the light.
        image : pyvista.ImageData
            Linear floats, or bytes, which are decoded as sRGB.

        Raises
        ------
        ValueError
            If there is no such light, the light takes no image, or the image is invalid.
        """
        renderer_light = self._light(number)
        before = renderer_light.light(self._subplot.lights.viewer)
        name, given = image_in(image, before)
        changed = await asyncio.to_thread(with_image, before, name, given)
        with self._step():  # on the light's current value
            now, changes = self._light(number), {name: getattr(changed, name)}
            now.set(replace(now.light(self._subplot.lights.viewer), **changes), self._subplot.lights.viewer)

    def highlight_here(self, number: Any) -> None:
        """Let the next click on a lit mesh place the highlight of a light, or no longer, if that was so already."""
        gizmos, gizmo = self.gizmos, self.gizmos.of(self._light(number))
        gizmos.select(gizmo)
        gizmos.awaits_click = None if gizmos.awaits_click is gizmo else gizmo
        gizmos.notice = f"click where the highlight of {called(gizmo.light)} should be" if gizmos.awaits_click else ""

    def point_at(self, number: Any) -> None:
        """Mark the gizmo of a light whose row is pointed at; None marks none."""
        self.gizmos.listed = None if number is None else self.gizmos.of(self._light(number))

    def select(self, number: Any) -> None:
        """Select a light in the list and in the view. None deselects the selected light."""
        self.gizmos.select(None if number is None else self.gizmos.of(self._light(number)))

    def replace_all(self, scene: Scene | None, materials: Mapping[str, Material], default: str) -> None:
        """Set lights, light model and materials from a rig, as one undo step.

        Parameters
        ----------
        scene : Scene or None
            Lights and light model; its viewer is ignored. None to keep lights and light model.
        materials : mapping
            Name of a mesh → material.
        default : str
            Key of the material for meshes without an entry of their own. If there is no such key, these meshes keep
            their materials. A stage without an entry of its own always keeps its material.
        """
        with self._step():
            if scene is not None:
                self.set_ups.leave()
                self._subplot.lights.replace(scene.lights)
                self._phong.light_model = scene.light_model
            stage = self.staging.mesh
            for name, shared in self.materials.items():
                is_of_stage = stage is not None and shared is stage.shared_material  # most rigs are made without one
                found = materials.get(name, None if is_of_stage else materials.get(default))
                if found is not None:
                    shared.material = found

    # -- the mix

    def start_mix(self, on: bool) -> None:
        """Start the mix, or end it without applying it to the lights."""
        with self._step():
            self.mix.start(on=check.flag("on", on))

    def solo_fader(self, number: Any) -> None:
        """Show only one light in the mix, or all lights again."""
        with self._step():
            chosen = self._light(number)
            self.mix.soloed = None if self.mix.soloed is chosen else chosen

    def keep_mix(self) -> None:
        """Apply the mix to the lights, and reset the faders."""
        with self._step():
            for each, light in self.mix.kept().items():
                each.set(light, self._subplot.lights.viewer)
            self.mix.start(on=self.mix.is_on)

    # -- materials

    @property
    def materials(self) -> dict[str, SharedMaterial]:
        """The materials of all visible meshes: name of the first mesh that has the material → the material."""
        found, shown = dict[SharedMaterial, str](), set(self._subplot.lit.shown)
        for mesh, name in sorted(self.names().items(), key=lambda each: each[0].stage is not None):
            if mesh in shown:
                found.setdefault(mesh.shared_material, name)
        return {name: shared for shared, name in found.items()}

    def names(self) -> dict[LitMesh, str]:
        """Return unique names of the meshes; see `Opening.names` and `own_names`."""
        lit = self._subplot.lit
        return own_names(lit, lit.meshes) if self._opening is None else self._opening.names()

    def mesh_name(self, mesh: Any) -> str:
        """Return the unique name of a mesh."""
        return self.names()[mesh]

    def _material(self, number: Any) -> SharedMaterial:
        materials = list(self.materials.values())
        if not str(number).isdecimal() or int(number) >= len(materials):
            check.refuse("material", number, "the number of an existing material")
        return materials[int(number)]

    def choose_material(self, number: Any, name: str) -> None:
        """Set a named material; albedo and tangents are kept."""
        with self._step():
            shared = self._material(number)
            own = shared.material
            shared.material = replace(as_material(name), albedo=own.albedo, tangents=own.tangents)

    def choose_reflectance(self, number: Any, name: str) -> None:
        """Set a material's reflectance by the name of the reflectance's kind in scene files. "" uses the light model's
        `reflection`.
        """
        with self._step():
            shared = self._material(number)
            reflectance = new_reflectance(name) if name else None
            shared.material = replace(shared.material, reflectance=reflectance)

    def set_texture(self, number: Any, field: str, texture: pv.Texture, name: str) -> None:
        """Set a texture for a field of a material, or of its reflectance.

        Parameters
        ----------
        number
            Number of the material.
        field : str
            A field that can be a map.
        texture : pyvista.Texture
            The texture; it is mapped by the meshes' texture coordinates.
        name : str
            Name of the texture's file.

        Raises
        ------
        ValueError
            If there is no such field, the texture does not fit the field, or a mesh has no texture coordinates.
        """
        shared = self._material(number)
        check.choice("field", field, textured(shared.material))
        with self._step():
            shared.material = shared.material.with_values({field: texture})
            self.textures[Map(texture)] = self._file_name(texture, name)

    def set_colormap(self, number: Any, scalars: Any, cmap: Any = None, low: Any = None, high: Any = None) -> str:
        """Use an array of the meshes, with a colormap, as a material's albedo; return a message.

        Parameters
        ----------
        number
            Number of the material.
        scalars : str or None
            Name of a point or cell array; None removes the colormap. A cell array sets the feature angle to 0.
        cmap : str, optional
            Name of the colormap; by default the current colormap, or PyVista's.
        low, high : float or str, optional
            Ends of the range, as numbers or text; by default the ends of the array's range.

        Raises
        ------
        ValueError
            If there is no such array or colormap, or the range is invalid.
        """
        shared = self._material(number)
        if not scalars:
            with self._step():
                shared.material = replace(shared.material, albedo=1.0)
            return ""
        colormap = coloring.chosen(shared.material.albedo, self._colored(shared), scalars, cmap, low, high)
        splits = colormap.preference == "cell" and any(mesh.feature_angle != 0.0 for mesh in self._subplot.lit.meshes)
        with self._step():
            if splits:
                self.surfaces = Surfaces(0.0)
            shared.material = replace(shared.material, albedo=colormap)
        return "All edges are sharp now, because a cell array needs separate points for each face." if splits else ""

    def _colored(self, shared: SharedMaterial) -> list[pv.DataSet]:
        """Return the visible meshes with a material."""
        return [mesh.mesh for mesh in self._subplot.lit.shown if mesh.shared_material is shared]

    def _file_name(self, texture: pv.Texture, name: str) -> str:
        """Return a unique file name for a texture, for scripts. A number is added if another picture has that file
        name.
        """
        path, texels = PurePath(name), texture.to_array()
        others = [known for each, known in self.textures.items() if not np.array_equal(each.source.to_array(), texels)]
        names = itertools.chain([name], (f"{path.stem}-{number}{path.suffix}" for number in itertools.count(2)))
        return next(each for each in names if each not in others)

    # -- values for the page

    def _placing_form(self, renderer_light: RendererLight, number: int) -> list[dict[str, Any]]:
        """Return the entries for the place of a light about its target; empty if it has none."""
        placing = placing_of(self.gizmos.of(renderer_light).in_scene(self.gizmos.view))
        if placing is None:
            return []
        entries = form_of(placing, f"place.{number}", self._middles)
        return [entry for entry in entries if entry["set"]]

    def shown(self) -> dict[str, Any]:
        """Return all values for the page: name in the page's state → value."""
        moving = None if self._sliding is None else self._sliding[0]
        self._middles = {key: middle for key, middle in self._middles.items() if key == moving}
        viewer, gizmos = self._subplot.lights.viewer, self.gizmos
        selected, soloed = gizmos.selected, gizmos.soloed
        lights = []
        for each in self._subplot.lights.renderer_lights:
            light, number = each.light(viewer), self.number(each)
            key = f"light.{number}"
            is_selected = selected is not None and selected.renderer_light is each
            entries = {entry["name"]: entry for entry in in_words(form_of(light, key, self._middles))}
            entries["intensity"]["unit"] = self.set_ups.unit_of(light, entries["intensity"]["unit"])
            lights.append(
                {
                    "number": number,
                    "called": called(light),
                    "kind": (kind := kind_of(light)),
                    "kind_label": LIGHTS.get(kind, kind),
                    "selected": is_selected,
                    "soloed": each is soloed,
                    "fader": form_of(self.mix.fader(each), f"fader.{number}", self._middles) if self.mix.is_on else [],
                    "fader_soloed": each is self.mix.soloed,
                    **{name: entries[name] for name in _IN_ROW},
                    "hovered": gizmos.hovered is not None and gizmos.hovered[0].renderer_light is each,
                    "placing": self._placing_form(each, number) if is_selected else [],
                    "fields": [entry for name, entry in entries.items() if is_selected and name not in _IN_ROW],
                }
            )
        materials = []
        for number, (name, shared) in enumerate(self.materials.items()):
            material, reflectance = shared.material, shared.material.reflectance
            own = [] if reflectance is None else form_of(reflectance, f"reflectance.{number}", self._middles)
            materials.append(
                {
                    "number": number,
                    "name": name,
                    "preset": commands.name_of(material),
                    "textured": textured(material),
                    "colormap": coloring.shown(material.albedo, self._colored(shared)),
                    "fields": form_of(material, f"material.{number}", self._middles, hidden=("reflectance",)),
                    "reflectance": next((k for k, v in REFLECTANCES.items() if type(reflectance) is v), ""),
                    "reflectance_fields": own,
                }
            )
        model = form_of(self._phong.light_model, "model", self._middles)
        return {
            "lights": lights,
            "materials": materials,
            "has_shadows": self._phong.light_model.shadows,
            "surfaces": in_words(form_of(self.surfaces, "surfaces", self._middles)),
            "backing": in_words(form_of(self.background, "background", self._middles)),
            "model": sorted(model, key=lambda entry: entry["name"] not in _FIRST_OF_SCENE),
            "display": {entry["name"]: entry for entry in form_of(self._phong.display, "display", self._middles)},
            "accuracy": {entry["name"]: entry for entry in form_of(self.accuracy, "accuracy", self._middles)},
            "stage": self.staging.kind,
            "sun": self.set_ups.shown(self._middles),
            "aiming": gizmos.awaits_click is not None,
            "mixing": self.mix.is_on,
            "evaluations": sum(mesh.evaluations for mesh in self._subplot.lit.meshes) + self.mix.evaluations,
            "mix_ms": round(1e3 * self.mix.seconds, 1),
            "can_undo": self.history.can_undo or self._sliding is not None,
            "can_redo": self.history.can_redo,
        }
