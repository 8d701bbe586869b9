"""The lights of one renderer as pvphong's values: VTK's light objects followed in both directions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import pyvista as pv
from vtkmodules.vtkRenderingCore import VTK_LIGHT_TYPE_HEADLIGHT, VTK_LIGHT_TYPE_SCENE_LIGHT, vtkLight

from pvphong.base import check
from pvphong.optics.lights import Light
from pvphong.scene.viewer import Viewer
from pvphong.vtk.lights import from_vtk, write_light

LightState = tuple[dict[str, Any], Light | None, str]
"""Everything that makes a light what it is, to the bit: VTK's fields, and what only pvphong knows."""


class RendererLight:
    """One light of a renderer: a value of pvphong's, and the `vtkLight` that lights VTK's own actors with it.

    What only pvphong knows (a name, an exponent above 128) is kept for as long as nobody changes the
    `vtkLight` in code.
    """

    def __init__(self, vtk_light: Any, light: Light | None = None) -> None:
        self.vtk_light = vtk_light
        self._is_users = light is None
        self._own = light
        self._name = "" if light is None else light.name
        self._written = _fields(vtk_light)
        self._converted: tuple[Any, Light] | None = None

    def __repr__(self) -> str:
        value = type(self.vtk_light if self._own is None else self._own).__name__
        return f"<RendererLight of a {value}{f' named {self._name!r}' if self._name else ''}>"

    def light(self, viewer: Viewer) -> Light:
        """The light's value now."""
        fields = _fields(self.vtk_light)
        if self._own is not None and fields == self._written:
            return self._own
        self._own = None
        known = (fields, viewer.distance, self._name)
        if self._converted is None or self._converted[0] != known:
            self._converted = known, replace(from_vtk(self.vtk_light, viewer.distance), name=self._name)
        return self._converted[1]

    def set(self, light: Light, viewer: Viewer) -> None:
        """Give the light a new value, in place."""
        vtk_light, before = self.vtk_light, self.light(viewer)
        position, focal_point, cone = vtk_light.GetPosition(), vtk_light.GetFocalPoint(), vtk_light.GetConeAngle()
        write_light(light, vtk_light, viewer)
        # VTK keeps more of a light than its meaning: leave the user's own object what it need not lose.
        if self._is_users and light.frame == before.frame == "world" and type(light) is type(before):
            values = light.as_vtk()
            if not values.is_positional:
                vtk_light.SetPosition(position)
                vtk_light.SetFocalPoint(*(p + d for p, d in zip(position, values.direction, strict=True)))
            elif values.cone_angle is None:
                vtk_light.SetConeAngle(cone)
                vtk_light.SetFocalPoint(focal_point)
        self._own, self._name = light, light.name
        self._written = _fields(vtk_light)

    @property
    def state(self) -> LightState:
        """What `restore` brings back."""
        return _fields(self.vtk_light), self._own, self._name

    def restore(self, state: LightState) -> None:
        """Make the light again what it was, to the bit."""
        fields, self._own, self._name = state
        for field, value in fields.items():
            if field != _ELEMENTS:
                getattr(self.vtk_light, f"Set{field}")(value)
        self._written = _fields(self.vtk_light)


LightStates = dict[RendererLight, LightState]


class WindowLights:
    """The lights of one renderer, in the order in which the renderer has them.

    Parameters
    ----------
    renderer : pyvista.Renderer
        Lights added to it, changed or removed by anybody are followed.
    """

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._renderer_lights: list[RendererLight] = []

    @property
    def viewer(self) -> Viewer:
        """The renderer's camera as it is now."""
        return Viewer.from_camera(self._renderer.camera)

    @property
    def renderer_lights(self) -> tuple[RendererLight, ...]:
        """The lights that the renderer has now."""
        known = {id(renderer_light.vtk_light): renderer_light for renderer_light in self._renderer_lights}
        self._renderer_lights = [known.get(id(light)) or RendererLight(light) for light in self._renderer.GetLights()]
        return tuple(self._renderer_lights)

    @property
    def values(self) -> tuple[Light, ...]:
        """The values of all lights."""
        viewer = self.viewer
        return tuple(renderer_light.light(viewer) for renderer_light in self.renderer_lights)

    def add(self, light: Any) -> RendererLight:
        """Add a light of pvphong's, of PyVista's or of VTK's."""
        if isinstance(light, Light):
            renderer_light = RendererLight(light.to_pyvista(self.viewer), light)
        else:
            from_vtk(light, 1.0)  # refuses what is no light before anything changes
            renderer_light = RendererLight(light)
        if any(other is renderer_light.vtk_light for other in self._renderer.GetLights()):
            check.refuse("light", light, "a light that the plotter does not have yet", "set_light changes a light.")
        self._append(renderer_light)
        return renderer_light

    def replace(self, lights: Iterable[Any]) -> None:
        """Take all lights out, and add others."""
        for renderer_light in self.renderer_lights:
            self.remove(renderer_light)
        for light in lights:
            self.add(light)

    def _append(self, renderer_light: RendererLight) -> None:
        is_pyvistas = isinstance(renderer_light.vtk_light, pv.Light)
        (self._renderer.add_light if is_pyvistas else self._renderer.AddLight)(renderer_light.vtk_light)
        self._renderer_lights.append(renderer_light)

    def find(self, which: Any) -> RendererLight:
        """A light: by itself, by index, by name, or by its PyVista light."""
        present = self.renderer_lights
        if isinstance(which, int) and not isinstance(which, bool) and -len(present) <= which < len(present):
            return present[which]
        lights = self.values
        for renderer_light, light in zip(present, lights, strict=True):
            named = isinstance(which, str) and which != "" and light.name == which
            if named or renderer_light is which or renderer_light.vtk_light is which:
                return renderer_light
        names = ", ".join(repr(light.name) for light in lights if light.name)
        allowed = f"a light of this renderer: what `add_light` gave, its pyvista.Light, an index below {len(present)}"
        return check.refuse("which", which, allowed + (f", or one of {names}" if names else ""))

    def remove(self, which: Any) -> None:
        """Take a light out, of PyVista's own list and with its actor too."""
        renderer_light = self.find(which)
        light = renderer_light.vtk_light
        self._renderer.RemoveLight(light)
        self._renderer._lights[:] = [other for other in self._renderer._lights if other is not light]
        actor = getattr(light, "actor", None)
        if actor is not None:
            self._renderer.RemoveActor(actor)
        self._renderer_lights.remove(renderer_light)

    @property
    def state(self) -> LightStates:
        """All lights and what they are, for `revert`."""
        return {renderer_light: renderer_light.state for renderer_light in self.renderer_lights}

    def revert(self, now: LightStates, then: LightStates) -> None:
        """Undo what changed from `then` to `now`; what else has changed since is left as it is."""
        for renderer_light, state in now.items():
            if renderer_light not in then and renderer_light in self.renderer_lights:
                self.remove(renderer_light)
            elif then.get(renderer_light, state) != state:
                renderer_light.restore(then[renderer_light])
        shining = {id(renderer_light.vtk_light) for renderer_light in self.renderer_lights}
        returning = {
            renderer_light: state
            for renderer_light, state in then.items()
            if renderer_light not in now and id(renderer_light.vtk_light) not in shining  # put in again by somebody
        }
        if not returning:
            return
        # Removed lights return, each into its old place: all are taken out and put in again in that order.
        present = self.renderer_lights
        for renderer_light in present:
            self.remove(renderer_light)
        old = [renderer_light for renderer_light in then if renderer_light in returning or renderer_light in present]
        for renderer_light in [*old, *(each for each in present if each not in then)]:
            self._append(renderer_light)
        for renderer_light, state in returning.items():
            renderer_light.restore(state)


_ELEMENTS = "elements of the transform matrix"
_PLACES = ("Position", "FocalPoint")
_FIELDS = (
    "LightType",
    "DiffuseColor",
    "SpecularColor",
    "AmbientColor",
    "Intensity",
    "Switch",
    "Positional",
    "ConeAngle",
    "Exponent",
    "AttenuationValues",
    *_PLACES,
)
# Functions, not methods: PyVista's lights look at each attribute before they give it, which takes longer than VTK.
_GETTERS = {field: getattr(vtkLight, f"Get{field}") for field in _FIELDS}


def _fields(light: Any) -> dict[str, Any]:
    """A VTK light's own fields; without what VTK itself overwrites at every frame."""
    fields = {field: get(light) for field, get in _GETTERS.items()}
    if fields["LightType"] == VTK_LIGHT_TYPE_HEADLIGHT:
        for field in _PLACES:
            del fields[field]
    is_placed = fields["LightType"] == VTK_LIGHT_TYPE_SCENE_LIGHT
    matrix = vtkLight.GetTransformMatrix(light) if is_placed else None
    return fields | {"TransformMatrix": matrix, _ELEMENTS: None if matrix is None else tuple(matrix.GetData())}
