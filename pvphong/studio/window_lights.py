"""The lights of one renderer as pvphong's lights, kept in sync with VTK's light objects in both directions."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import pyvista as pv
from vtkmodules.vtkRenderingCore import VTK_LIGHT_TYPE_HEADLIGHT, VTK_LIGHT_TYPE_SCENE_LIGHT, vtkLight

from pvphong.base import check
from pvphong.optics.lights import Light, vtk_values
from pvphong.scene.viewer import Viewer
from pvphong.vtk.lights import from_vtk, write_light

LightState = tuple[dict[str, Any], Light | None, str]
"""The exact state of a light: VTK's fields, and pvphong's light and name."""


class RendererLight:
    """One light of a renderer: as pvphong's light, and as the `vtkLight` that lights VTK's own actors.

    Properties that only pvphong has, such as a name or an exponent above 128, are kept until code changes the
    `vtkLight`.
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

    @property
    def name(self) -> str:
        """The light's name; "" if it has none."""
        return self._name

    def rename(self, name: str) -> None:
        """Rename the light and change nothing else."""
        self._own, self._name = self._own and replace(self._own, name=name), name

    def light(self, viewer: Viewer) -> Light:
        """Return the current light.

        If code has changed the `vtkLight`, the result is converted from it. `viewer` is the current camera. Its
        distance is the unit in which VTK stores the position of a light that moves with the camera.
        """
        fields = _fields(self.vtk_light)
        if self._own is not None and fields == self._written:
            return self._own
        self._own = None
        known = (fields, viewer.distance, self._name)
        if self._converted is None or self._converted[0] != known:
            self._converted = known, replace(from_vtk(self.vtk_light, viewer.distance), name=self._name)
        return self._converted[1]

    def set(self, light: Light, viewer: Viewer) -> None:
        """Replace the light by `light`, and update its `vtkLight`.

        `viewer` is the current camera; it places lights that move with the viewer.
        """
        vtk_light, before = self.vtk_light, self.light(viewer)
        position, focal_point, cone = vtk_light.GetPosition(), vtk_light.GetFocalPoint(), vtk_light.GetConeAngle()
        write_light(light, vtk_light, viewer)
        # Some fields of a vtkLight have no effect, such as the position of a directional light. Keep the user's values.
        if self._is_users and light.frame == before.frame == "world" and type(light) is type(before):
            values = vtk_values(light)
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
        """All values of the light, exactly, for `restore`."""
        return _fields(self.vtk_light), self._own, self._name

    def restore(self, state: LightState) -> None:
        """Set the light back to a state that was read from the property `state`."""
        fields, self._own, self._name = state
        for field, value in fields.items():
            if field != _ELEMENTS:
                getattr(self.vtk_light, f"Set{field}")(value)
        self._written = _fields(self.vtk_light)


LightStates = dict[RendererLight, LightState]


class WindowLights:
    """The lights of one renderer, in the renderer's order.

    Parameters
    ----------
    renderer : pyvista.Renderer
        The renderer. Its lights are read at every access, so other code may add, change or remove them.
    """

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._renderer_lights: list[RendererLight] = []

    @property
    def viewer(self) -> Viewer:
        """The renderer's current camera, as a viewer."""
        return Viewer.from_camera(self._renderer.camera)

    @property
    def renderer_lights(self) -> tuple[RendererLight, ...]:
        """The renderer's current lights, each with its `vtkLight`."""
        known = {id(renderer_light.vtk_light): renderer_light for renderer_light in self._renderer_lights}
        self._renderer_lights = [known.get(id(light)) or RendererLight(light) for light in self._renderer.GetLights()]
        return tuple(self._renderer_lights)

    @property
    def values(self) -> tuple[Light, ...]:
        """The renderer's current lights, as pvphong's lights."""
        viewer = self.viewer
        return tuple(renderer_light.light(viewer) for renderer_light in self.renderer_lights)

    def add(self, light: Any) -> RendererLight:
        """Add a light of pvphong, PyVista or VTK to the renderer, and return it."""
        if isinstance(light, Light):
            renderer_light = RendererLight(light.to_pyvista(self.viewer), light)
        else:
            from_vtk(light, 1.0)  # raises for other objects before anything changes
            renderer_light = RendererLight(light)
        if any(other is renderer_light.vtk_light for other in self._renderer.GetLights()):
            check.refuse("light", light, "a light that is not in the plotter yet", "Change it with set_light.")
        self._refuse_taken(renderer_light.name)
        self._append(renderer_light)
        return renderer_light

    def set(self, which: Any, light: Light) -> None:
        """Replace a light of the renderer by another.

        `which` selects the light to replace: a handle, an index, a name or a PyVista light.
        """
        vtk_values(light)  # raises for a light without a counterpart in VTK
        renderer_light = self.find(which)
        if light.name != renderer_light.name:
            self._refuse_taken(light.name)
        renderer_light.set(light, self.viewer)

    def _refuse_taken(self, name: str) -> None:
        """Raise ``ValueError`` if a light of the renderer has the name `name`: results are looked up by name."""
        if name and name in (other.name for other in self.renderer_lights):
            check.refuse("name", name, "unique among the lights of the plotter", "Change a light with set_light.")

    def replace(self, lights: Iterable[Any]) -> None:
        """Replace all lights of the renderer by the given ones."""
        for renderer_light in self.renderer_lights:
            self.remove(renderer_light)
        for light in lights:
            self.add(light)

    def _append(self, renderer_light: RendererLight) -> None:
        is_pyvistas = isinstance(renderer_light.vtk_light, pv.Light)
        (self._renderer.add_light if is_pyvistas else self._renderer.AddLight)(renderer_light.vtk_light)
        self._renderer_lights.append(renderer_light)

    def find(self, which: Any) -> RendererLight:
        """Return the light that `which` selects: a handle, an index, a name or a PyVista light."""
        present = self.renderer_lights
        vtk_light = getattr(which, "vtk_light", which)
        if isinstance(which, int) and not isinstance(which, bool) and -len(present) <= which < len(present):
            return present[which]
        lights = self.values
        for renderer_light, light in zip(present, lights, strict=True):
            named = isinstance(which, str) and which != "" and light.name == which
            if named or renderer_light.vtk_light is vtk_light:
                return renderer_light
        names = ", ".join(repr(light.name) for light in lights if light.name)
        allowed = f"a light of this renderer: its handle, its pyvista.Light, an index below {len(present)}"
        return check.refuse("which", which, allowed + (f", or one of the names {names}" if names else ""))

    def remove(self, which: Any) -> None:
        """Remove a light, its actor, and its entry in PyVista's list of lights.

        `which` selects the light: a handle, an index, a name or a PyVista light.
        """
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
        """All values of each light, exactly, for `revert`."""
        return {renderer_light: renderer_light.state for renderer_light in self.renderer_lights}

    def revert(self, now: LightStates, then: LightStates) -> None:
        """Restore the lights of the state `then` that differ in the state `now`, and keep all other changes.

        Both arguments are values of the property `state`. If another light has taken the name of a restored light, the
        restored light gets a free name.
        """
        for renderer_light, state in now.items():
            if renderer_light not in then and renderer_light in self.renderer_lights:
                self.remove(renderer_light)
            elif then.get(renderer_light, state) != state:
                renderer_light.restore(then[renderer_light])
        self._bring_back(now, then)
        reverted = [each for each in self.renderer_lights if each in then and now.get(each) != then[each]]
        taken = {each.name for each in self.renderer_lights if each not in reverted}
        for renderer_light in reverted:
            if renderer_light.name in taken and renderer_light.name:
                renderer_light.rename(free_name(renderer_light.name, taken))
            taken.add(renderer_light.name)

    def _bring_back(self, now: LightStates, then: LightStates) -> None:
        """Add the lights that are in the state `then` but not in `now`, at their old positions in the list."""
        shining = {id(renderer_light.vtk_light) for renderer_light in self.renderer_lights}
        returning = {
            renderer_light: state
            for renderer_light, state in then.items()
            if renderer_light not in now and id(renderer_light.vtk_light) not in shining  # not added by other code
        }
        if not returning:
            return
        # Remove all lights and add them in the old order.
        present = self.renderer_lights
        for renderer_light in present:
            self.remove(renderer_light)
        old = [renderer_light for renderer_light in then if renderer_light in returning or renderer_light in present]
        for renderer_light in [*old, *(each for each in present if each not in then)]:
            self._append(renderer_light)
        for renderer_light, state in returning.items():
            renderer_light.restore(state)


def free_name(wanted: str, taken: set[str]) -> str:
    """Return `wanted` if this name is not in `taken`.

    If it is, return the name, without a number at its end, followed by the lowest number, from 2, for which the result
    is not in `taken`: "lamp 2" becomes "lamp 3" if "lamp" and "lamp 2" are taken.
    """
    stem, number, name = re.sub(r" \d+$", "", wanted), 1, wanted
    while name in taken:
        number += 1
        name = f"{stem} {number}"
    return name


_ELEMENTS = "elements of the transform matrix"
_PLACES = ("Position", "FocalPoint")
_FIELDS = (
    "LightType",
    "DiffuseColor",
    "SpecularColor",
    "AmbientColor",
    "Intensity",
    "Switch",
    "ShadowAttenuation",
    "Positional",
    "ConeAngle",
    "Exponent",
    "AttenuationValues",
    *_PLACES,
)
# Unbound methods of vtkLight, because attribute access on a pyvista.Light runs Python code, which is slower.
_GETTERS = {field: getattr(vtkLight, f"Get{field}") for field in _FIELDS}


def _fields(light: Any) -> dict[str, Any]:
    """Return the fields of a VTK light, as name → value, except those that VTK overwrites in every frame."""
    fields = {field: get(light) for field, get in _GETTERS.items()}
    if fields["LightType"] == VTK_LIGHT_TYPE_HEADLIGHT:
        for field in _PLACES:
            del fields[field]
    is_placed = fields["LightType"] == VTK_LIGHT_TYPE_SCENE_LIGHT
    matrix = vtkLight.GetTransformMatrix(light) if is_placed else None
    return fields | {"TransformMatrix": matrix, _ELEMENTS: None if matrix is None else tuple(matrix.GetData())}
