"""Options that several commands share: the scene, and how the surface reflects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from pvphong.base import check
from pvphong.base.processes import reading
from pvphong.base.types import ColorLike
from pvphong.meshes.blocks import DEFAULT, single_material
from pvphong.meshes.files import read_mesh, read_texture
from pvphong.meshes.surfaces import FeatureAngle
from pvphong.optics.material import Material
from pvphong.optics.reflectance import Reflectance
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.scene.scene import Scene, load_materials


@dataclass(frozen=True)
class Look:
    """How the surface reflects.

    Parameters
    ----------
    material
        A named material such as "gold" or "car paint"; the rig's if not given, or else a dull grey.
    reflectance
        How it reflects, in place of the material's: a name, and fields of it after colons, as in oren-nayar:sigma=20
        or ggx:roughness=0.3:f0=1,0.78,0.34.
    ambient
        Reflectance of ambient light, in place of the material's: a number, three as in 1,0.5,0.2, or a colour's name.
    diffuse
        Reflectance of scattered light, likewise.
    specular
        Reflectance of the highlight, likewise.
    emission
        Light that the surface gives off, likewise.
    shininess
        Exponent of the highlight, in place of the material's.
    """

    material: str | None = None
    reflectance: str | None = None
    ambient: str | None = None
    diffuse: str | None = None
    specular: str | None = None
    emission: str | None = None
    shininess: float | None = None

    def to_materials(self, file: Path | None) -> dict[str, Material]:
        """The materials that the options describe, by the names of their blocks: the rig's if none is named."""
        if self.material is not None:
            begun = {DEFAULT: _named(self.material)}
        else:
            begun = ({} if file is None else load_materials(file)) or {DEFAULT: Material()}
        colors = {term: getattr(self, term) for term in ("ambient", "diffuse", "specular", "emission")}
        changes: dict[str, Any] = {term: _color(text) for term, text in colors.items() if text is not None}
        if self.shininess is not None:
            changes["shininess"] = self.shininess
        if self.reflectance is not None:
            changes["reflectance"] = _reflectance(self.reflectance)
        return {name: replace(material, **changes) for name, material in begun.items()}

    def to_material(self, file: Path | None) -> Material:
        """The material of a single mesh."""
        return single_material(self.to_materials(file))


def _named(name: str) -> Material:
    try:
        return Material.named(name)
    except ValueError as error:
        raise ValueError(f"material {error}") from error


def _reflectance(text: str) -> Reflectance:
    name, *parts = text.split(":")
    kind = REFLECTANCES[check.choice("--reflectance", name, REFLECTANCES)]
    known, given = [each.name for each in fields(kind)], dict[str, ColorLike]()
    for part in parts:
        field, separator, value = part.partition("=")
        given[check.choice(f"--reflectance {name}", field, known)] = _color(value)
        if not separator:
            check.refuse(f"--reflectance {name}", part, "followed by fields as in name:field=value")
    missing = [each.name for each in fields(kind) if each.default is MISSING and each.name not in given]
    if missing:
        check.refuse("--reflectance", text, f"given its {missing[0]} too", f"{name}:{missing[0]}=... does that.")
    return kind(**given)


def _color(text: str) -> ColorLike:
    """A number, numbers with commas between them, or the text itself, for `Material` to judge."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else numbers


SceneFile = Annotated[
    Path | None, Parameter(help="Lights, viewer, light model, materials, as Scene.save writes them (JSON).")
]
LookOptions = Annotated[Look, Parameter(name="*")]
Verbose = Annotated[
    bool, Parameter(name=["--verbose", "-v"], negative="", show_default=False, help="Tell all of it, not a few lines.")
]
PLAIN = Look()
"""None of its options given."""


@dataclass(frozen=True)
class Blockers:
    """What stands before lights and sky.

    Parameters
    ----------
    shadows
        Multiply what lights add by the part of them that each vertex sees; blocks shadow each other.
    ambient_occlusion
        Multiply ambient light by the open part of the sky.
    occluder
        A file with a mesh that casts shadows too; may be given several times.
    """

    shadows: Annotated[bool, Parameter(negative="", show_default=False)] = False
    ambient_occlusion: Annotated[bool, Parameter(negative="", show_default=False)] = False
    occluder: Annotated[tuple[str, ...], Parameter(negative="", show_default=False)] = ()

    def to_scene(self, scene: Scene) -> Scene:
        """A scene with what is asked for beside its own."""
        model = scene.light_model
        if self.shadows:
            model = replace(model, shadows=True)
        if self.ambient_occlusion and not model.ambient_occlusion:
            model = replace(model, ambient_occlusion=True)
        if self.occluder and not model.needs_rays:
            remedy = "Give --shadows, --ambient-occlusion or a rig with them too."
            check.refuse("--occluder", self.occluder[0], "left out where nothing casts shadows", remedy)
        return replace(scene, light_model=model)

    def to_meshes(self) -> list[Any]:
        """The meshes that cast shadows too."""
        return [read_mesh(path) for path in self.occluder]


BlockerOptions = Annotated[Blockers, Parameter(name="*")]
NONE = Blockers()
"""None of its options given."""


_IMAGES = (".bmp", ".jpeg", ".jpg", ".png", ".tif", ".tiff")


def albedo_of(given: str | None) -> Any:
    """What the command line's word for it means: a texture from an image file, or the name of a point array."""
    if given is None or Path(given).suffix.lower() not in _IMAGES:
        return given
    with reading(given):
        return read_texture(given)


FeatureAngleOption = float | Literal["auto", "none"]
"""Degrees between two faces from which their common edge is sharp."""


def feature_angle_of(given: FeatureAngleOption) -> FeatureAngle:
    """What the command line's word for it means."""
    return None if given == "none" else given


def refuse_given(options: Mapping[str, Any], allowed: str) -> None:
    """Raise ``ValueError`` for the first option that is given."""
    for option, given in options.items():
        if given not in (None, False, ()):
            check.refuse(option, given, allowed)
