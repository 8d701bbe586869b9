"""The lights of one renderer as pvphong's values: VTK's light objects followed in both directions.

Not a file: what users call a rig is read in `pvphong/scene/scene.py`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import pyvista as pv

from pvphong.base import check
from pvphong.optics.lights import Light
from pvphong.scene.viewer import Viewer
from pvphong.vtk.lights import from_vtk, write_light


@dataclass(frozen=True)
class LightState:
    """Everything that makes a light what it is, to the bit: VTK's fields, and what only pvphong knows."""

    fields: tuple[Any, ...]
    own: Light | None
    name: str


class LightHandle:
    """One light of a renderer: a value of pvphong's, and the `vtkLight` that lights VTK's own actors with it.

    What only pvphong knows (a name, an exponent above 128) is kept for as long as nobody changes the
    `vtkLight` in code.
    """

    def __init__(self, vtk_light: Any, light: Light | None = None) -> None:
        self.vtk_light = vtk_light
        self._is_guest = light is None
        self._own = light
        self._name = "" if light is None else light.name
        self._echo = _fields(vtk_light)
        self._converted: tuple[Any, Light] | None = None

    def __repr__(self) -> str:
        value = type(self.vtk_light if self._own is None else self._own).__name__
        return f"<LightHandle of a {value}{f' named {self._name!r}' if self._name else ''}>"

    def light(self, viewer: Viewer) -> Light:
        """The light's value now."""
        fields = _fields(self.vtk_light)
        if self._own is not None and fields == self._echo:
            return self._own
        self._own = None
        known = (fields, viewer.distance, self._name)
        if self._converted is None or self._converted[0] != known:
            self._converted = known, replace(from_vtk(self.vtk_light, viewer.distance), name=self._name)
        return self._converted[1]

    def set(self, light: Light, viewer: Viewer) -> None:
        """Give the light a new value, in place."""
        guest, before = self.vtk_light, self.light(viewer)
        position, focal_point, cone = guest.GetPosition(), guest.GetFocalPoint(), guest.GetConeAngle()
        write_light(light, guest, viewer)
        # VTK keeps more of a light than its meaning: leave the user's own object what it need not lose.
        if self._is_guest and light.frame == before.frame == "world" and type(light) is type(before):
            values = light.as_vtk()
            if not values.is_positional:
                guest.SetPosition(position)
                guest.SetFocalPoint(*(p + d for p, d in zip(position, values.direction, strict=True)))
            elif values.cone_angle is None:
                guest.SetConeAngle(cone)
                guest.SetFocalPoint(focal_point)
        self._own, self._name = light, light.name
        self._echo = _fields(self.vtk_light)

    @property
    def state(self) -> LightState:
        """What `restore` brings back."""
        return LightState(_fields(self.vtk_light), self._own, self._name)

    def restore(self, state: LightState) -> None:
        """Make the light again what it was, to the bit."""
        _set_fields(self.vtk_light, state.fields)
        self._own, self._name = state.own, state.name
        self._echo = _fields(self.vtk_light)


RigState = tuple[tuple[LightHandle, LightState], ...]


class Rig:
    """The lights of one renderer, in the order in which the renderer has them.

    Parameters
    ----------
    renderer : pyvista.Renderer
        Lights added to it, changed or removed by anybody are followed.
    """

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._handles: list[LightHandle] = []

    @property
    def viewer(self) -> Viewer:
        """The renderer's camera as it is now."""
        return Viewer.from_camera(self._renderer.camera)

    @property
    def handles(self) -> tuple[LightHandle, ...]:
        """A handle for each light that the renderer has now."""
        known = {id(handle.vtk_light): handle for handle in self._handles}
        present = list(self._renderer.GetLights())
        self._handles = [known.get(id(light)) or LightHandle(light) for light in present]
        return tuple(self._handles)

    @property
    def lights(self) -> tuple[Light, ...]:
        """The values of all lights."""
        viewer = self.viewer
        return tuple(handle.light(viewer) for handle in self.handles)

    def add(self, light: Any) -> LightHandle:
        """Add a light of pvphong's, of PyVista's or of VTK's."""
        if isinstance(light, Light):
            vtk_light = light.to_pyvista(self.viewer)
            handle = LightHandle(vtk_light, light)
        else:
            from_vtk(light, 1.0)  # refuses what is no light before anything changes
            vtk_light = light
            handle = LightHandle(vtk_light)
        if any(other is vtk_light for other in self._renderer.GetLights()):
            check.refuse("light", light, "a light that the plotter does not have yet", "set_light changes a light.")
        self._put(vtk_light)
        self._handles.append(handle)
        return handle

    def _put(self, vtk_light: Any) -> None:
        if isinstance(vtk_light, pv.Light):
            self._renderer.add_light(vtk_light)
        else:
            self._renderer.AddLight(vtk_light)

    def find(self, which: Any) -> LightHandle:
        """The handle of a light: by handle, by index, by name, or by its PyVista light."""
        handles = self.handles
        if isinstance(which, int) and not isinstance(which, bool) and -len(handles) <= which < len(handles):
            return handles[which]
        lights = self.lights
        for handle, light in zip(handles, lights, strict=True):
            named = isinstance(which, str) and which != "" and light.name == which
            if named or handle is which or handle.vtk_light is which:
                return handle
        names = ", ".join(repr(light.name) for light in lights if light.name)
        allowed = f"a light of this renderer: its handle, its pyvista.Light, an index below {len(handles)}"
        return check.refuse("which", which, allowed + (f", or one of {names}" if names else ""))

    def remove(self, which: Any) -> None:
        """Take a light out, of PyVista's own list and with its actor too."""
        handle = self.find(which)
        light = handle.vtk_light
        self._renderer.RemoveLight(light)
        self._renderer._lights[:] = [other for other in self._renderer._lights if other is not light]
        actor = getattr(light, "actor", None)
        if actor is not None:
            self._renderer.RemoveActor(actor)
        self._handles.remove(handle)

    @property
    def state(self) -> RigState:
        """All lights and what they are, for `turn`."""
        return tuple((handle, handle.state) for handle in self.handles)

    def turn(self, now: RigState, then: RigState) -> None:
        """Undo what changed from `then` to `now`; what else has changed since is left as it is."""
        was = dict(then)
        for handle, state in now:
            if handle not in was and handle in self.handles:
                self.remove(handle)
            elif handle in was and was[handle] != state:
                handle.restore(was[handle])
        if any(handle not in dict(now) for handle in was):
            self._return(then)

    def _return(self, then: RigState) -> None:
        """Put removed lights back, each into its old place."""
        others = [handle for handle in self.handles if handle not in dict(then)]
        for handle in self.handles:
            self.remove(handle)
        for handle in [*(handle for handle, _ in then), *others]:
            self._put(handle.vtk_light)
            self._handles.append(handle)
        for handle, state in then:
            if handle not in others:
                handle.restore(state)


def _fields(light: Any) -> tuple[Any, ...]:
    """A VTK light's own fields; what VTK itself overwrites at every frame is left out."""
    in_world = light.LightTypeIsSceneLight()
    moves = light.LightTypeIsHeadlight()
    matrix = light.GetTransformMatrix() if in_world else None
    return (
        light.GetLightType(),
        None if moves else light.GetPosition(),
        None if moves else light.GetFocalPoint(),
        matrix,
        None if matrix is None else tuple(matrix.GetData()),
        light.GetDiffuseColor(),
        light.GetSpecularColor(),
        light.GetAmbientColor(),
        light.GetIntensity(),
        light.GetSwitch(),
        light.GetPositional(),
        light.GetConeAngle(),
        light.GetExponent(),
        light.GetAttenuationValues(),
    )


def _set_fields(light: Any, fields: tuple[Any, ...]) -> None:
    kind, position, focal_point, matrix, _, *colors, intensity, switch, positional, cone, exponent, falloff = fields
    light.SetLightType(kind)
    if position is not None:
        light.SetPosition(position)
        light.SetFocalPoint(focal_point)
    light.SetTransformMatrix(matrix)
    for put, color in zip((light.SetDiffuseColor, light.SetSpecularColor, light.SetAmbientColor), colors, strict=True):
        put(color)
    light.SetIntensity(intensity)
    light.SetSwitch(switch)
    light.SetPositional(positional)
    light.SetConeAngle(cone)
    light.SetExponent(exponent)
    light.SetAttenuationValues(falloff)
