"""Live handles: objects for a light or a drawn mesh in a window. Fields are read and set as the objects' attributes.

Each assignment creates a new light or material, with the usual checks. The next frame shows it.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from typing import Any

from pvphong.base import check
from pvphong.base.handles import Handle, declared, unknown_attribute
from pvphong.optics.light import Light
from pvphong.optics.material import Material
from pvphong.scene.viewer import Viewer
from pvphong.studio.lit_mesh import LitMesh
from pvphong.studio.subplot import Subplot
from pvphong.studio.window_lights import RendererLight

_OF_LIGHTS = {
    "color": "diffuse",
    "colour": "diffuse",
    "diffuse_color": "diffuse",
    "specular_color": "specular",
    "ambient_color": "ambient",
    "brightness": "intensity",
    "attenuation_values": "attenuation",
    "focal_point": "direction",
    "target": "direction",
    "light_type": "frame",
    "angle": "cone_angle",
    "switch": "on",
    "visible": "on",
    "shadow_attenuation": "casts_shadows",
}
"""Names of light fields in other libraries → names in pvphong."""

_OF_MATERIALS = {
    "color": "diffuse",
    "colour": "diffuse",
    "diffuse_color": "diffuse",
    "specular_color": "specular",
    "ambient_color": "ambient",
    "specular_power": "shininess",
    "emissive": "emission",
    "texture": "albedo",
    "scalars": "albedo",
    "roughness": "reflectance",
    "metallic": "reflectance",
}
"""Names of material fields in other libraries → names in pvphong."""


class LightHandle(Handle):
    """A light of a window. Its fields, such as `position` or `intensity`, can be read and set.

    Parameters
    ----------
    renderer_light : RendererLight
        The light.
    subplot : Subplot
        The subplot of the light; kept by weak reference.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> plotter = pv.Plotter(off_screen=True)
    >>> lamp = plotter.phong.add_light(ph.PointLight(position=(0, 0, 2), name="lamp"))
    >>> lamp.position = (1, 0, 2)
    >>> lamp.intensity *= 2
    >>> lamp
    <LightHandle of a PointLight named 'lamp'>
    >>> plotter.close()
    """

    def __init__(self, renderer_light: RendererLight, subplot: Subplot) -> None:
        self._renderer_light = renderer_light
        self._place = weakref.ref(subplot)

    def __repr__(self) -> str:
        return repr(self._renderer_light).replace("RendererLight", "LightHandle")

    @property
    def vtk_light(self) -> Any:
        """The `pyvista.Light` or `vtkLight` that lights VTK's own actors."""
        return self._renderer_light.vtk_light

    def light(self, viewer: Viewer | None = None) -> Light:
        """Return the current light. VTK's camera lights are placed for `viewer`; by default, the window's camera."""
        return self._renderer_light.light(viewer or self._subplot.lights.viewer)

    def set(self, light: Light, viewer: Viewer | None = None) -> None:  # noqa: ARG002 kept for compatibility
        """Replace the light by `light`. If it has been removed from the window, raise ``ValueError``.

        `viewer` has no effect; other code calls this method with it.
        """
        lights = self._subplot.lights
        if not any(each.vtk_light is self.vtk_light for each in lights.renderer_lights):
            remedy = "The light has been removed; add it again with plotter.phong.add_light(lamp.light())."
            check.refuse("light", self, "a light of the plotter", remedy)
        with self._subplot.assigning(lights):
            lights.set(self._renderer_light, light)

    @property
    def _subplot(self) -> Subplot:
        subplot = self._place()
        return subplot or check.refuse("plotter", "a closed plotter", "open")

    def __getattr__(self, name: str) -> Any:
        light = self._with_field(name)
        return getattr(light, name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name.startswith("_"):
            super().__setattr__(name, value)
        elif name in declared(LightHandle):
            raise AttributeError(f"{name!r} is read-only. Replace the light with plotter.phong.set_light(lamp, light).")
        else:
            self.set(replace(self._with_field(name), **{name: value}))

    def _with_field(self, name: str) -> Light:
        """Return the current light; raise ``AttributeError`` if it has no field `name`."""
        if name.startswith("_"):
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}.")
        light = self.light()
        known = _names(light)
        if name not in known:
            raise unknown_attribute(type(light).__name__, name, known, _OF_LIGHTS)
        return light

    def __dir__(self) -> Iterable[str]:
        return [*super().__dir__(), *_names(self.light())]


class MeshHandle(Handle):
    """An actor drawn by `plotter.phong.add_mesh`. The fields of its material can be read and set.

    If blocks share a material, a change applies to all of them. The attributes of the lit mesh are available too.
    `feature_angle` and `casts_shadows` can be set. `mesh` and `actor` can be read, and so can `evaluations`, the number
    of times the colours have been computed.

    Parameters
    ----------
    lit : LitMesh
        The drawn mesh.
    subplot : Subplot
        The subplot of the mesh; kept by weak reference.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> plotter = pv.Plotter(off_screen=True)
    >>> ball = plotter.phong.mesh(plotter.phong.add_mesh(pv.Sphere()))
    >>> ball.diffuse = (0.8, 0.1, 0.1)
    >>> ball.material.diffuse
    (0.8, 0.1, 0.1)
    >>> plotter.close()
    """

    def __init__(self, lit: LitMesh, subplot: Subplot) -> None:
        self._lit = lit
        self._place = weakref.ref(subplot)

    def __repr__(self) -> str:
        return repr(self._lit)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, MeshHandle) and other._lit is self._lit

    def __hash__(self) -> int:
        return hash(self._lit)

    @property
    def material(self) -> Material:
        """The surface's material. Setting it affects all blocks that share it."""
        return self._lit.material

    @material.setter
    def material(self, material: Material) -> None:
        subplot = self._place() or check.refuse("plotter", "a closed plotter", "open")
        with subplot.assigning(subplot.lit):
            self._lit.material = material

    def __getattr__(self, name: str) -> Any:
        if name in _names(Material):
            return getattr(self.material, name)
        if name.startswith("_") or not hasattr(self._lit, name):
            raise self._unknown(name)
        return getattr(self._lit, name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _names(Material):
            self.material = replace(self.material, **{name: value})
        elif name.startswith("_") or name == "material":
            super().__setattr__(name, value)
        elif name in vars(self._lit):
            setattr(self._lit, name, value)
        elif hasattr(self._lit, name):
            raise AttributeError(f"{name!r} of a drawn mesh is read-only.")
        else:
            raise self._unknown(name)

    def _unknown(self, name: str) -> AttributeError:
        return unknown_attribute("The mesh", name, [*_names(Material), *_SETTABLE], _OF_MATERIALS)

    def __dir__(self) -> Iterable[str]:
        return [*super().__dir__(), *_names(Material), *(name for name in dir(self._lit) if not name.startswith("_"))]


def changed_light(light: Light, given: Light | None, changes: Mapping[str, Any]) -> Light:
    """Return the changed light: either another light, or `light` with new values in some fields.

    Parameters
    ----------
    light : Light
        The light to change.
    given : Light or None
        The light that replaces `light`; None if fields are given.
    changes : mapping
        Field → new value; empty if a light is given.

    Raises
    ------
    ValueError
        If the light has no field of a given name, if both a light and fields are given, or if neither is given.
    """
    if given is not None:
        check.refuse("light", given, "omitted when fields are given", "Set the fields in the light instead.")
    if not changes:
        check.refuse("light", None, "a light if no fields are given", 'Example: set_light("lamp", intensity=2).')
    known = _names(light)
    for name in changes:
        if name not in known:
            raise ValueError(str(unknown_attribute(type(light).__name__, name, known, _OF_LIGHTS)))
    return replace(light, **changes)


_SETTABLE = ("material", "feature_angle", "casts_shadows")


def _names(value: Any) -> list[str]:
    """Return the names of the fields of a dataclass instance."""
    return [field.name for field in fields(value)]
