"""Parts that several commands share: common options, reading of inputs, and progress.

Inputs are a mesh file, its scene and its materials.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import MISSING, dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any

import pyvista as pv
from cyclopts import Parameter
from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeRemainingColumn

from pvphong.base import check
from pvphong.base.processes import reading
from pvphong.base.text import listening
from pvphong.base.types import ColorLike
from pvphong.meshes.blocks import DEFAULT, leaves, map_blocks, single_material
from pvphong.meshes.colormaps import over_all
from pvphong.meshes.default_scene import default_scene, scene_for
from pvphong.meshes.files import read_mesh
from pvphong.meshes.glance import complaint
from pvphong.meshes.surfaces import FeatureAngle, surface
from pvphong.optics.colormap import Colormap
from pvphong.optics.lights import DirectionalLight
from pvphong.optics.maps import COLORS, is_color_name
from pvphong.optics.material import Material, as_material
from pvphong.optics.reflectance import Reflectance
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.scene.scene import Scene, load_materials

SIZE = (1024, 768)
"""Default width and height, in pixels, of a picture or window."""

_LONG = 1.0
"""Time in seconds after which a progress bar is shown."""

Flag = Annotated[bool, Parameter(negative="", show_default=False)]


def _number(_type: Any, tokens: Sequence[Any]) -> float:
    """Parse the text of an option as a float, or as a quotient such as 1/255.

    The command-line parser calls this function with the option's type and its words.
    """
    above, slash, below = tokens[0].value.partition("/")
    if slash and not float(below):
        raise ValueError(f'unable to convert "{tokens[0].value}" into a number')
    return float(above) / float(below) if slash else float(above)


Number = Annotated[float, Parameter(converter=_number)]
"""A number such as 0.004, or a quotient such as 1/255."""
Verbose = Annotated[
    bool,
    Parameter(
        name=["--verbose", "-v"], negative="", show_default=False, help="Print everything instead of a few lines."
    ),
]


@dataclass(frozen=True)
class Lighting:
    """Options that commands share, for lights, material and occluders.

    Parameters
    ----------
    scene
        Rig file (JSON) with lights, viewer, light model and materials, as Scene.save writes it.
    material
        Name of a material, such as "gold" or "car paint". Default: the material of the rig, or a dull grey.
    reflectance
        Kind of reflectance, instead of the material's: a name, followed by fields after colons, as in
        oren-nayar:sigma=20, ggx:roughness=0.3:f0=1,0.78,0.34 or pbr:roughness=worn.png.
    ambient
        Ambient reflectance, instead of the material's: a number, three numbers as in 1,0.5,0.2, or the name of a
        colour.
    diffuse
        Diffuse reflectance: as for --ambient, or the name of a point array, or an image file. An image is mapped by the
        mesh's texture coordinates.
    specular
        Specular reflectance, given as for --diffuse.
    emission
        Emitted light, given as for --diffuse.
    albedo
        Factor of ambient and diffuse, given as for --diffuse.
    scalars
        Name of a point or cell array whose numbers become the albedo through a colormap. Cell arrays need
        --feature-angle 0.
    cmap
        Colormap of --scalars: a name such as terrain, or colours separated by commas. Default: PyVista's default.
    clim
        Range of the colormap, as in 0,8. Default: the range of the array in all blocks.
    shininess
        Shininess exponent: a number, the name of a point array, or a grey image file in which white is 128.
    tangents
        Name of a point array of vectors along the surface, for reflectances that need them.
    sun
        A sun, instead of the scene's lights: its azimuth, in degrees clockwise from north, and its elevation above the
        horizon in degrees, as in 315,20. North is +y, up is +z.
    shadows
        Add shadows: multiply each light by its visible fraction. Blocks shadow each other.
    ambient_occlusion
        Multiply ambient light by the visible fraction of the sky. To see this fraction alone, add --diffuse 0
        --ambient 5.
    bounces
        Number of bounces of light from surface to surface, 0 for none. Default: that of the rig. Ambient light stands
        for further bounces.
    occluder
        File with another mesh that casts shadows; may be repeated.
    feature_angle
        An edge is sharp if the normals of its two faces differ by more than this angle, in degrees. "auto": 30 if the
        mesh has no point normals, otherwise no sharp edges. "none": no sharp edges.
    """

    scene: Path | None = None
    material: str | None = None
    reflectance: str | None = None
    ambient: str | None = None
    diffuse: str | None = None
    specular: str | None = None
    emission: str | None = None
    albedo: str | None = None
    scalars: str | None = None
    cmap: str | None = None
    clim: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    shininess: str | None = None
    tangents: str | None = None
    sun: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    shadows: Flag = False
    ambient_occlusion: Flag = False
    bounces: int | None = None
    occluder: Annotated[tuple[str, ...], Parameter(negative="", show_default=False)] = ()
    feature_angle: Annotated[FeatureAngle, Parameter(show_choices=False)] = "auto"

    def materials(self) -> dict[str, Material]:
        """Return the materials as block → material: the material of --material, or else the materials of the rig.

        Other options, such as --diffuse, then replace fields of these materials.
        """
        if self.material is not None:
            if is_color_name(self.material) and self.material.lower() not in Material.names():
                remedy = f"For a colour use --diffuse {self.material}."
                check.refuse("--material", self.material, "the name of a material", remedy)
            found = {DEFAULT: as_material(self.material)}
        else:
            found = ({} if self.scene is None else load_materials(self.scene)) or {DEFAULT: Material()}
        given = {name: getattr(self, name) for name in ("ambient", *COLORS, "shininess")}
        changes: dict[str, Any] = {name: parsed(text) for name, text in given.items() if text is not None}
        if self.scalars is not None:
            if self.albedo is not None:
                check.refuse("--albedo", self.albedo, "omitted with --scalars, because --scalars sets the albedo")
            clim = None if self.clim is None else parsed(self.clim)
            cmap: Any = self.cmap.split(",") if self.cmap is not None and "," in self.cmap else self.cmap
            changes["albedo"] = Colormap(self.scalars, cmap, clim)
        for option, text in {"--cmap": self.cmap, "--clim": self.clim}.items():
            if text is not None and self.scalars is None:
                check.refuse(option, text, "used together with --scalars, the name of the array")
        if self.tangents is not None:
            changes["tangents"] = self.tangents
        if self.reflectance is not None:
            changes["reflectance"] = _reflectance(self.reflectance)
        return {name: replace(material, **changes) for name, material in found.items()}

    def read(self, path: str, size: tuple[int, int] = SIZE) -> tuple[Any, Scene, Any]:
        """Read a mesh file, and the scene and materials that light it.

        Parameters
        ----------
        path
            The file.
        size
            Width and height of the picture in pixels. In the default scene, the mesh fills the picture.

        Returns
        -------
        mesh : pyvista.PolyData or pyvista.MultiBlock
            The surface, or the surfaces of all blocks.
        scene : Scene
            Scene with a viewer.
        material : Material or dict
            Material of a single mesh, or a dictionary block → material.
        """
        materials = self.materials()
        given = None if self.scene is None else Scene.load(self.scene)
        with reading(path):
            mesh = read_mesh(path)
            has_blocks = isinstance(mesh, pv.MultiBlock)
            outside = map_blocks(mesh, surface) if has_blocks else surface(mesh)
        materials = {name: over_all(each, leaves(mesh)) for name, each in materials.items()}
        scene = default_scene(outside, size[0] / size[1]) if given is None else scene_for(outside, given)
        complaints = [complaint(*parts, scene) for parts in zip(leaves(mesh), leaves(outside), strict=True)]
        for text in dict.fromkeys(filter(None, complaints)):
            print(f"note: {text}", file=sys.stderr)
        return outside, self.with_rays(self.with_sun(scene)), materials if has_blocks else single_material(materials)

    def with_sun(self, scene: Scene) -> Scene:
        """Return a scene whose only light is the sun of the option --sun; without the option, `scene` unchanged."""
        if self.sun is None:
            return scene
        try:
            azimuth, elevation = (float(part) for part in self.sun.split(","))
        except ValueError:
            remedy = "For example, --sun 315,20 puts the sun low in the north-west."
            check.refuse("--sun", self.sun, "two numbers separated by a comma", remedy)
        return replace(scene, lights=[DirectionalLight.from_angles(azimuth, elevation, name="sun")])

    def with_rays(self, scene: Scene) -> Scene:
        """Return a scene with the effects of the options --shadows, --ambient-occlusion and --bounces.

        Shadows and ambient occlusion are added to those of the scene. The option --bounces replaces the scene's number.
        """
        model = scene.light_model
        occlusion = model.ambient_occlusion or self.ambient_occlusion  # in the rig it may be a distance
        shadows, bounces = model.shadows or self.shadows, model.bounces if self.bounces is None else self.bounces
        model = replace(model, shadows=shadows, ambient_occlusion=occlusion, bounces=bounces)
        if self.occluder and not model.is_global:
            remedy = "Add --shadows, --ambient-occlusion or --bounces, or use a rig that has them."
            allowed = "used with shadows, ambient occlusion or bounces"
            check.refuse("--occluder", self.occluder[0], allowed, remedy)
        return replace(scene, light_model=model)

    def occluders(self) -> list[Any]:
        """Read and return the meshes of the options --occluder. These meshes cast shadows too."""
        return [read_mesh(path) for path in self.occluder]


LightingOptions = Annotated[Lighting, Parameter(name="*")]
DEFAULT_LIGHTING = Lighting()
"""The options if none is given on the command line."""


def seeing(scene: Scene, mesh: Any, size: tuple[int, int]) -> Scene:
    """Return the scene for a picture of a mesh. `size` is the picture's width and height in pixels.

    A viewer that cannot see the mesh is moved to frame the mesh, and a note is printed.
    """
    if scene.viewer.sees(mesh.bounds, size[0] / size[1]):
        return scene
    print("note: the scene's viewer does not see this mesh, and was moved to frame it.", file=sys.stderr)
    return replace(scene, viewer=scene.viewer.moved_to_see(mesh.bounds))


def _reflectance(text: str) -> Reflectance:
    """Parse the option --reflectance, such as ggx:roughness=0.3:f0=1,0.78,0.34, and return the reflectance."""
    name, *parts = text.split(":")
    kind = REFLECTANCES[check.choice("--reflectance", name, REFLECTANCES)]
    known, given = [each.name for each in fields(kind)], dict[str, ColorLike]()
    for part in parts:
        field, separator, value = part.partition("=")
        given[check.choice(f"--reflectance {name}", field, known)] = parsed(value)
        if not separator:
            check.refuse(f"--reflectance {name}", part, "followed by fields, as in name:field=value")
    missing = [each.name for each in fields(kind) if each.default is MISSING and each.name not in given]
    if missing:
        check.refuse("--reflectance", text, f"given with its {missing[0]}", f"Write {name}:{missing[0]}=... .")
    return kind(**given)


def parsed(text: str) -> ColorLike:
    """Parse a number, or numbers separated by commas. Any other text is returned unchanged; `Material` checks it."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else numbers


@contextmanager
def busy(what: str) -> Iterator[None]:
    """Within the block, show on standard error that the command is busy with `what`.

    It shows a spinner, or a progress bar if long work reports its progress. Nothing is shown if standard error is not a
    terminal.
    """
    console, begun = Console(stderr=True), time.perf_counter()
    columns = SpinnerColumn(), TextColumn("{task.description}")
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as shown:
        task = shown.add_task(what, total=None)

        def update(doing: str, part: float) -> None:
            if time.perf_counter() - begun > _LONG:
                shown.columns = (*columns, BarColumn(), TimeRemainingColumn())
                shown.update(task, description=f"{what}: {doing}", completed=part, total=1.0)

        with listening(update):
            yield


def refuse_given(options: Mapping[str, Any], allowed: str) -> None:
    """Raise ``ValueError`` for the first of some options that is given; None, False and () mean that it is not.

    Parameters
    ----------
    options : mapping
        Name → value of options that are not allowed here.
    allowed : str
        The allowed use, which completes the sentence "<option> must be …".
    """
    for option, given in options.items():
        if given is not None and given is not False and given != ():  # 0 counts as given, although it equals False
            check.refuse(option, given, allowed)
