"""Scenes: lights, viewer and light model as one value, and scene files.

Scene files, also called rigs, may contain materials too. Only this module reads and writes them.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self

from pvphong.base import check, documents, host
from pvphong.base.files import write_json
from pvphong.base.text import changed_fields, html_table
from pvphong.base.types import VectorLike
from pvphong.optics.lights import LIGHT_TYPES, Light
from pvphong.optics.maps import is_image_path
from pvphong.optics.material import Material, as_material
from pvphong.optics.reflectances.pbr import is_physical
from pvphong.scene.light_model import LightModel
from pvphong.scene.viewer import Viewer

_FORMAT = "pvphong scene"
_VERSION = 1


@dataclass(frozen=True)
class Scene:
    """Lights, viewer and light model: all inputs except the mesh and its material.

    Parameters
    ----------
    lights : iterable of lights
        pvphong's lights, or `pyvista.Light` and `vtkLight` objects, which are converted. VTK's camera lights then still
        move with the viewer.
    viewer : Viewer or camera, optional
        The viewer; a `pyvista.Camera` or `vtkCamera` is converted. If None, the default, the viewer is where PyVista
        places its camera to frame the mesh; see `framed`.
    light_model : LightModel
        The model that combines the contributions of the lights.

    Raises
    ------
    ValueError
        If a field has the wrong type, or two lights have the same name.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> scene = ph.Scene([ph.DirectionalLight()], ph.Viewer(position=(0, 0, 5)), ph.LightModel(ambient=0.1))
    >>> lit = pv.Sphere().phong.shade(scene)
    """

    lights: Iterable[Any] = ()
    viewer: Any = None
    light_model: LightModel = field(default_factory=LightModel)

    def __post_init__(self) -> None:
        if hasattr(self.viewer, "GetParallelProjection"):
            object.__setattr__(self, "viewer", Viewer.from_camera(self.viewer))
        if not isinstance(self.viewer, Viewer | None):
            check.refuse("viewer", self.viewer, "a Viewer, a camera, or None for a viewer that frames the mesh")
        if not isinstance(self.light_model, LightModel):
            check.refuse("light_model", self.light_model, "a LightModel")
        if not isinstance(self.lights, Iterable) or isinstance(self.lights, (str, dict)):
            check.refuse("lights", self.lights, "a sequence of lights", "Put a single light into a list.")
        converted = tuple(light if isinstance(light, Light) else self._converted(light) for light in self.lights)
        object.__setattr__(self, "lights", converted)
        names = Counter(light.name for light in converted if light.name)
        for name, count in names.items():
            if count > 1:
                check.refuse("lights", f"{count} lights named {name!r}", "lights whose names differ", "Rename one.")

    def _converted(self, light: Any) -> Light:
        """Convert a VTK light to a pvphong light; a pvphong light is returned unchanged.

        VTK stores the position of a camera light as a multiple of the viewer's distance from its focal point. So the
        conversion of a camera light needs the scene's viewer. Without a viewer, ValueError is raised.
        """
        if self.viewer is not None:
            return host.answers().from_vtk(light, self.viewer.distance)
        converted = host.answers().from_vtk(light, 1.0)
        if converted != host.answers().from_vtk(light, 2.0):
            remedy = "Pass viewer=plotter.camera."
            check.refuse("viewer", None, "a Viewer if a VTK camera light has a position", remedy)
        return converted

    @cached_property
    def world_lights(self) -> tuple[Light, ...]:
        """The lights in world coordinates, in the order of `lights`, including lights that are off.

        Raises
        ------
        ValueError
            If a light moves with the viewer, and the scene has no viewer.
        """
        if self.viewer is None and any(light.frame != "world" for light in self.lights):
            check.refuse("viewer", None, "a Viewer if lights move with it", "Use scene.framed(mesh.bounds).")
        return tuple(light.in_world(self.viewer) for light in self.lights)

    def framed(self, bounds: VectorLike) -> Self:
        """Return this scene with a viewer. If the scene has none, the viewer frames the box `bounds`.

        Parameters
        ----------
        bounds : sequence of float
            x_min, x_max, y_min, y_max, z_min, z_max in the world; see `Viewer.framing`.
        """
        return self if self.viewer is not None else replace(self, viewer=Viewer.framing(bounds))

    @classmethod
    def from_plotter(cls, plotter: Any) -> Self:
        """Take a snapshot of a plotter's active renderer: its camera, and its lights at their positions in the world.

        Camera lights keep their current positions and no longer move with the viewer. The light model is pvphong's
        standard one; `dataclasses.replace(scene, light_model=LightModel.vtk())` follows VTK's shader.

        Parameters
        ----------
        plotter : pyvista.Plotter
            The plotter; it is not modified.

        Raises
        ------
        ValueError
            If `plotter` is not a plotter, or an environment texture also lights meshes with `pbr=True`.
        """
        renderer = getattr(plotter, "renderer", None)
        if renderer is None or not hasattr(renderer, "GetLights"):
            check.refuse("plotter", plotter, "a pyvista.Plotter")
        if renderer.GetUseImageBasedLighting() and any(
            is_physical(actor.GetProperty()) for actor in renderer.GetActors()
        ):
            remedy = "No light matches an environment texture; call plotter.remove_environment_texture()."
            check.refuse("plotter", "image-based light on meshes with pbr=True", "lit by its lights alone", remedy)
        # Reading plotter.camera would count as setting the view, and PyVista would not fit it to the meshes.
        viewer = Viewer.from_camera(renderer.camera)
        lights = tuple(host.answers().as_light(light, viewer) for light in renderer.GetLights())
        return cls(lights=lights, viewer=viewer)

    def _repr_html_(self) -> str:
        parts = [*zip(light_labels(self, "light "), self.lights, strict=True), ("light model", self.light_model)]
        rows = [(name, type(part).__name__, changed_fields(part, without=("name",))) for name, part in parts]
        viewer = "frames the mesh" if self.viewer is None else changed_fields(self.viewer)
        title = f"Scene of {len(rows) - 1} lights: values that differ from the defaults"
        return html_table(title, (), [*rows, ("viewer", "Viewer", viewer)])

    def save(self, path: str | os.PathLike[str], *, materials: Mapping[str, Material | str] | None = None) -> None:
        """Write the scene to a JSON file, from which `Scene.load` restores it bit for bit.

        Parameters
        ----------
        path : path
            The file.
        materials : mapping, optional
            Materials to store with the scene, by name. `load_materials` returns them. For each block of a mesh,
            `pvphong shade --scene` uses the material that has the block's name, or else the material "default". Maps in
            materials must be names of point arrays or paths of image files; paths are stored relative to the file's
            folder.

        Raises
        ------
        ValueError
            If the file cannot be written, or a light has a user-defined type. An existing file is then left unchanged.
        """
        lights = [documents.with_type(f"lights[{k}]", light, LIGHT_TYPES) for k, light in enumerate(self.lights)]
        document = {
            "format": _FORMAT,
            "version": _VERSION,
            "lights": lights,
            "viewer": None if self.viewer is None else asdict(self.viewer),
            "light_model": asdict(self.light_model),
        }
        if materials:
            folder = Path(path).absolute().parent
            document["materials"] = {
                name: _with_paths(as_material(material), lambda image: _seen_from(folder, image)).to_dict()
                for name, material in materials.items()
            }
        write_json(document, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a scene that `save` wrote.

        Raises
        ------
        ValueError
            If the file cannot be read, is not JSON, has a newer version, or has an unknown field.
        """
        document = _document(path)
        lights = document.get("lights", [])
        if not isinstance(lights, list):
            check.refuse("lights", lights, "a list")
        viewer = document.get("viewer")
        return cls(
            lights=[documents.value_of_type(f"lights[{k}]", entry, LIGHT_TYPES) for k, entry in enumerate(lights)],
            viewer=None if viewer is None else documents.value("viewer", Viewer, viewer),
            light_model=documents.value("light_model", LightModel, document.get("light_model", {})),
        )


def load_materials(path: str | os.PathLike[str]) -> dict[str, Material]:
    """Return the materials that `Scene.save` stored with a scene, as name → material; empty if there are none.

    Raises
    ------
    ValueError
        If the file cannot be read, is not JSON, has a newer version, or has an unknown field.

    Examples
    --------
    >>> import tempfile, pathlib, pvphong as ph
    >>> rig = pathlib.Path(tempfile.mkdtemp()) / "rig.json"
    >>> ph.Scene([ph.DirectionalLight()]).save(rig, materials={"default": ph.Material.named("gold")})
    >>> ph.load_materials(rig)["default"] == ph.Material.named("gold")
    True
    """
    kept, folder = documents.entries("materials", _document(path).get("materials", {})), Path(path).parent
    found = {name: _material_of(f"materials.{name}", entry) for name, entry in kept.items()}

    def seen_from_here(image: str) -> str:
        return os.path.normpath(folder / image)

    return {name: _with_paths(material, seen_from_here) for name, material in found.items()}


def _material_of(place: str, entry: Any) -> Material:
    """Return the material that an entry of a scene file describes.

    The entry is a mapping of the material's fields or, in files written by hand, the material's name. `place` is the
    position of the entry in the file; error messages contain it.
    """
    if isinstance(entry, str):
        return Material.named(check.choice(place, entry.lower(), Material.names()))
    return Material.from_dict(entry, place)


def _seen_from(folder: Path, image: str) -> str:
    try:
        return os.path.relpath(image, folder)
    except ValueError:  # on another drive of Windows
        return os.path.abspath(image)


def _with_paths(material: Material, change: Callable[[str], str]) -> Material:
    """Return a copy of a material with changed paths of its image files.

    `change` is a function that takes a path and returns its replacement.
    """
    maps = {name: value for name, value in material.maps.items() if is_image_path(value)}
    return material.with_values({name: change(str(value)) for name, value in maps.items()})


def is_scene_file(path: str | os.PathLike[str]) -> bool:
    """Return True if a file is a scene file, as `Scene.save` writes it; its fields are not checked."""
    try:
        _document(path)
    except ValueError:
        return False
    return True


def _document(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read a scene file, check its format, version and keys, and return its content as a dictionary."""
    document = documents.read(path, "a scene file")
    if not isinstance(document, dict) or document.get("format") != _FORMAT:
        allowed = f'a scene file, a JSON object with "format": "{_FORMAT}"'
        check.refuse("path", Path(path), allowed, "Scene.save writes such files.")
    version = document.get("version")
    if type(version) is not int or version != _VERSION:
        is_number = isinstance(version, int)
        remedy = "A newer pvphong may have written it." if is_number else "Give a number, without quotes."
        check.refuse("version", json.dumps(version), str(_VERSION), remedy)
    documents.check_keys("scene", document, {"format", "version", "materials", *(f.name for f in fields(Scene))})
    return document


SceneLike = Scene | Light | Iterable[Any]
"""A scene, a single light, or a sequence of lights."""


def as_scene(given: SceneLike | None, bounds: Callable[[], VectorLike] | None = None) -> Scene:
    """Return a scene unchanged, or make a scene with the standard light model from a light or lights.

    Parameters
    ----------
    given : Scene, light, or sequence of lights
        The argument that was passed as a scene.
    bounds : callable, optional
        Function that returns the bounds for `Scene.framed`; it is called if the scene has no viewer. By default no
        viewer is added.

    Raises
    ------
    ValueError
        If `given` has another type.
    """
    if isinstance(given, Scene):
        scene = given
    elif isinstance(given, Light) or hasattr(given, "GetLightType"):
        scene = Scene([given])
    elif isinstance(given, Iterable) and not isinstance(given, (str, dict)):
        scene = Scene(given)
    else:
        remedy = "Did you mean material=?" if isinstance(given, Material) else ""
        if hasattr(given, "renderer"):
            remedy = "Use Scene.from_plotter(plotter)."
        if hasattr(given, "GetParallelProjection"):
            remedy = "Use Scene(lights, viewer=camera)."
        if isinstance(given, str):
            remedy = "Did you mean material=Material.named(...), or Scene.load(...)?"
        check.refuse("scene", given, "a Scene, a light, or a sequence of lights", remedy)
    return scene if bounds is None or scene.viewer is not None else scene.framed(bounds())


def light_labels(scene: Scene, numbered: str = "") -> tuple[str, ...]:
    """Return a unique label for each light: its name, or its index if it has none.

    If its name equals the index of a light, a light is labelled by its own index, so that labels differ.

    Parameters
    ----------
    scene : Scene
        The scene; labels are in the order of its lights, including lights that are off.
    numbered : str, default ""
        Prefix of labels that are indices.
    """
    names = [light.name for light in scene.lights]
    indices = [f"{numbered}{index}" for index in range(len(names))]
    return tuple(name if name and name not in indices else index for name, index in zip(names, indices, strict=True))
