"""A scene: lights, viewer and light model, as one value that can be saved."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any, Self

from pvphong.base import check, host
from pvphong.base.files import written_aside
from pvphong.optics.lights import LIGHT_TYPES, Light, type_name
from pvphong.scene.light_model import LightModel
from pvphong.scene.viewer import Viewer

_FORMAT = "pvphong scene"
_VERSION = 1


@dataclass(frozen=True)
class Scene:
    """Everything but the mesh and its material.

    Parameters
    ----------
    lights : iterable of lights
        pvphong's own, or `pyvista.Light` and `vtkLight` objects, which are converted by `as_light`; their
        camera lights keep riding along with the viewer.
    viewer : Viewer
        Where it is seen from.
    light_model : LightModel
        How contributions are put together.

    Raises
    ------
    ValueError
        If a field is not of its type.
    """

    lights: Iterable[Any] = ()
    viewer: Viewer = field(default_factory=Viewer)
    light_model: LightModel = field(default_factory=LightModel)

    def __post_init__(self) -> None:
        if not isinstance(self.viewer, Viewer):
            check.refuse("viewer", self.viewer, "a Viewer", "Viewer.from_camera makes one of a camera.")
        if not isinstance(self.light_model, LightModel):
            check.refuse("light_model", self.light_model, "a LightModel")
        if not isinstance(self.lights, Iterable) or isinstance(self.lights, (str, dict)):
            check.refuse("lights", self.lights, "a sequence of lights", "Put a single light into a list.")
        distance = self.viewer.distance
        converted = tuple(
            light if isinstance(light, Light) else host.light_from_vtk(light, distance) for light in self.lights
        )
        object.__setattr__(self, "lights", converted)

    @cached_property
    def world_lights(self) -> tuple[Light, ...]:
        """The lights with world coordinates, as the viewer makes them: the order of `lights`, the off ones too."""
        return tuple(light.in_world(self.viewer) for light in self.lights)

    @classmethod
    def from_plotter(cls, plotter: Any) -> Self:
        """A snapshot of a plotter's active renderer: its lights at their true world positions, its camera.

        Camera lights are placed where the camera has them now. The light model is pvphong's standard one;
        `dataclasses.replace(scene, light_model=LightModel.vtk())` follows VTK's shader.

        Parameters
        ----------
        plotter : pyvista.Plotter
            The plotter; it is not modified.

        Raises
        ------
        ValueError
            If `plotter` is not a plotter.
        """
        renderer = getattr(plotter, "renderer", None)
        if renderer is None or not hasattr(renderer, "GetLights"):
            check.refuse("plotter", plotter, "a pyvista.Plotter")
        # plotter.camera would count as a choice of view, and keep PyVista from fitting it to the meshes.
        viewer = Viewer.from_camera(renderer.camera)
        lights = tuple(host.light_placed(light, viewer) for light in renderer.GetLights())
        return cls(lights=lights, viewer=viewer)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the scene to a JSON file; `Scene.load` gives it back to the last bit.

        Raises
        ------
        ValueError
            If the file cannot be written, or a light is of a kind that files do not know. A file that was there
            before is then still there.
        """
        document = {
            "format": _FORMAT,
            "version": _VERSION,
            "lights": [
                {"type": type_name(f"lights[{index}]", light)} | asdict(light)
                for index, light in enumerate(self.lights)
            ],
            "viewer": asdict(self.viewer),
            "light_model": asdict(self.light_model),
        }
        with written_aside(path) as aside:
            aside.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a scene that `save` wrote.

        Raises
        ------
        ValueError
            If the file cannot be read, is not JSON, is of a newer version, or has an unknown field.
        """
        try:
            document = json.loads(Path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise ValueError(f"path must be a scene file that can be read; got {path} ({error}).") from error
        except ValueError as error:  # not UTF-8, or not JSON
            raise ValueError(f"path must be a scene file in JSON; got {path} ({error}).") from error
        return cls._from_document(document)

    @classmethod
    def _from_document(cls, document: Any) -> Self:
        if not isinstance(document, dict) or document.get("format") != _FORMAT:
            check.refuse("format", document, f'a JSON object with "format": "{_FORMAT}"', "Scene.save writes one.")
        if document.get("version") != _VERSION:
            remedy = "A newer pvphong may have written it."
            check.refuse("version", document.get("version"), f"{_VERSION}", remedy)
        _check_keys("scene", document, {"format", "version", *(f.name for f in fields(cls))})
        lights = document.get("lights", [])
        if not isinstance(lights, list):
            check.refuse("lights", lights, "a list")
        return cls(
            lights=tuple(_light(f"lights[{index}]", entry) for index, entry in enumerate(lights)),
            viewer=_value("viewer", Viewer, document.get("viewer", {})),
            light_model=_value("light_model", LightModel, document.get("light_model", {})),
        )


def light_labels(scene: Scene, numbered: str = "") -> tuple[str, ...]:
    """What names each of a scene's lights, no two alike: its name, or its index where it has none or shares it.

    Parameters
    ----------
    scene : Scene
        Its lights are named in their order, the off ones too.
    numbered : str, default ""
        Stands before an index.
    """
    names = [light.name for light in scene.lights]
    indices = [f"{numbered}{index}" for index in range(len(names))]
    counts = Counter(names + indices)
    return tuple(name if name and counts[name] == 1 else index for name, index in zip(names, indices, strict=True))


def _light(place: str, entry: Any) -> Any:
    if not isinstance(entry, dict):
        check.refuse(place, entry, "a JSON object")
    kind = LIGHT_TYPES[check.choice(f"{place}.type", entry.get("type"), LIGHT_TYPES)]
    return _value(place, kind, {key: value for key, value in entry.items() if key != "type"})


def _value(place: str, kind: Any, entry: Any) -> Any:
    if not isinstance(entry, dict):
        check.refuse(place, entry, "a JSON object")
    _check_keys(place, entry, {f.name for f in fields(kind)})
    try:
        return kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in entry.items()})
    except ValueError as error:
        raise ValueError(f"{place}.{error}") from error


def _check_keys(place: str, entry: dict[str, Any], allowed: set[str]) -> None:
    for key in entry:
        if key not in allowed:
            check.refuse(f"field of {place}", key, "one of " + ", ".join(sorted(allowed)))
