"""Downloads from a studio: rig, lit mesh, glTF, picture, and a Python script that reproduces them exactly."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path, PurePath
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.display import Display
from pvphong.meshes.blocks import DEFAULT, common_or_named, leaves, nested
from pvphong.meshes.saving import save
from pvphong.optics.colormap import Colormap
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.maps import Map
from pvphong.optics.material import DEFAULT_MATERIAL, Material
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading import kernel
from pvphong.studio.lit_mesh import LitMesh

EXAMPLES: Mapping[str, str] = {
    "airplane": "load_airplane",
    "ant": "load_ant",
    "nut": "load_nut",
    "hills": "load_random_hills",
    "beam": "load_hexbeam",
    "sphere": "load_sphere",
}
"""Name of an example mesh → its function in `pyvista.examples`; PyVista contains their files."""

FILES = ("rig", "vtp", "ply", "vtkhdf", "glb", "png", "py")
"""The downloads, named by their suffix. The exception is "rig", a .json file."""

STAGE = "stage"
"""Name of the stage among the meshes' names."""

LIT = ("vtp", "ply", "vtkhdf", "glb", "png")
"""The downloads that contain the lit mesh."""


_PLAIN = Display()


@dataclass(frozen=True)
class Picture:
    """Options of a picture.

    Parameters
    ----------
    size : (int, int), default (1920, 1080)
        Width and height in pixels.
    background : color, default "white"
        Its background, or "transparent".
    display : Display, optional
        Transform that shows the colours.
    """

    size: tuple[int, int] = (1920, 1080)
    background: str = "white"
    display: Display = _PLAIN


_PICTURE = Picture()


@dataclass
class Downloads:
    """A snapshot of the data from which a studio's downloads are made.

    Parameters
    ----------
    meshes : mapping
        Path of a block, or name → lit mesh.
    scene : Scene
        Lights, viewer and light model.
    tolerance : float
        Allowed colour error.
    reading : str
        Python code of an expression for the mesh or the blocks. It may use `pv` and `ph`.
    stem : str
        Prefix of the file names.
    textures : mapping
        Texture → file name, for textures from files. Rig and script refer to textures by these names.
    is_as_shown : bool, default False
        True to take the colours that the view shows, 8 bits per channel, instead of computing them.
    stage : LitMesh, optional
        The stage under the meshes. Pictures and the script include it. Downloads of meshes leave it out, but their
        colours include its shadows and the light that it reflects.
    picture : Picture, optional
        Options of the picture.
    refined : mapping, optional
        Name → refined mesh with its colours, for the picture, if the view shows the meshes refined. With a display
        transform, the colours must not be clamped.
    refine : float, optional
        Tolerance of the refined meshes.
    """

    meshes: Mapping[str, LitMesh]
    scene: Scene
    tolerance: float
    reading: str
    stem: str
    textures: Mapping[Map, str]
    is_as_shown: bool = False
    stage: LitMesh | None = None
    picture: Picture = _PICTURE
    refined: Mapping[str, pv.PolyData] = field(default_factory=dict)
    refine: float | None = None

    def __post_init__(self) -> None:
        self.stem = re.sub(r"[^\w.-]+", "-", self.stem).strip(".-") or "mesh"

    @property
    def materials(self) -> dict[str, Material]:
        """The materials as in a rig: name of a mesh → material.

        If all meshes have the same, "default" → this material.
        """
        found = common_or_named({name: mesh.material for name, mesh in self.meshes.items()})
        return found or {DEFAULT: DEFAULT_MATERIAL}

    @property
    def _on_stage(self) -> dict[str, Material]:
        """The stage's material, by the stage's name; empty if there is no stage. Rigs leave it out."""
        return {} if self.stage is None else {STAGE: self.stage.material}

    @property
    def _all(self) -> dict[str, LitMesh]:
        """The meshes by name, with the stage at the end."""
        return {**self.meshes} if self.stage is None else {**self.meshes, STAGE: self.stage}

    @property
    def _written(self) -> dict[str, Material]:
        """The materials for the rig and the script, with textures as file names."""

        def named(material: Material) -> Material:
            maps = {name: each for name, each in material.maps.items() if isinstance(each, Map)}
            return material.with_values({name: self.textures.get(each, each) for name, each in maps.items()})

        return {name: named(material) for name, material in self.materials.items()}

    @property
    def options(self) -> dict[str, Any]:
        """Options of `shade`. They include the backend, so that the script reproduces the colours exactly.

        Raises
        ------
        ValueError
            If there is no mesh, or the meshes need different options.
        """
        meshes = list(self._all.values())
        if not self.meshes:
            check.refuse("mesh", "none", "open", "Open a mesh first.")
        angles, matrices = {mesh.feature_angle for mesh in meshes}, [mesh.matrix for mesh in meshes]
        matrix = matrices[0]
        if len(angles) > 1 or len({None if each is None else each.tobytes() for each in matrices}) > 1:
            allowed = "the same for all meshes, so that one call can light them"
            check.refuse("transform and feature angle", "different transforms or feature angles", allowed)
        if self.scene.light_model.needs_rays and not all(mesh.casts_shadows for mesh in meshes):
            check.refuse(
                "casts_shadows",
                "a mesh with casts_shadows=False",
                "True for all meshes, so that one call can light them",
            )
        found: dict[str, Any] = {"feature_angle": meshes[0].feature_angle}
        if matrix is not None:
            found["matrix"] = matrix.tolist()
        if self.tolerance:
            found["tolerance"] = self.tolerance
        return found | {"backend": "numba" if kernel.has_run() else "numpy"}

    @property
    def lit(self) -> Any:
        """The lit mesh or blocks, without the stage. It can be read in any thread, unless `is_as_shown`."""
        blocks = self.pictured
        if self.stage is None:
            return blocks
        alone = blocks.copy(deep=False)
        alone.pop(STAGE)
        return leaves(alone)[0] if len(self.meshes) == 1 else alone

    @cached_property
    def pictured(self) -> Any:
        """The lit mesh or blocks for pictures, computed once. The stage is the last block."""
        return self._lit_in(self.scene)

    def _lit_in(self, scene: Scene) -> Any:
        options, materials = self.options, self.materials | self._on_stage
        if self.is_as_shown:
            shown = {name: mesh.as_shown() for name, mesh in self._all.items()}
            return next(iter(shown.values())) if len(shown) == 1 else nested(shown)
        if len(self._all) == 1:
            mesh = next(iter(self.meshes.values())).mesh
            return mesh.phong.shade(scene, materials[DEFAULT], **options)
        blocks = nested({name: mesh.mesh for name, mesh in self._all.items()})
        return blocks.phong.shade(scene, materials, **options)

    def script(self) -> str:
        """Return a Python script that reads the mesh, lights it as in the studio, and writes it and its picture.

        If lights or materials have images or arrays, which code cannot contain, the script reads them from the rig.
        """
        options, materials, stem = self.options, self._written, self.stem
        is_single = [mesh.block for mesh in self.meshes.values()] == [""]
        rig = f'"{stem}-rig.json"'
        try:
            scene = python_of(self.scene)
            written = {name: python_of(each) for name, each in materials.items()}
        except HasArrays:
            scene = f"ph.Scene.load({rig})  # download the rig too: it contains images, arrays or lamps"
            written = {}
        written_on_stage = {name: python_of(each) for name, each in self._on_stage.items()}
        if list(written) == [DEFAULT] and not written_on_stage:
            material = written[DEFAULT]
        elif written:
            inner = "".join(f"    {name!r}: {each},\n" for name, each in (written | written_on_stage).items())
            material = f"{{\n{inner}}}"
        else:
            material = f"ph.load_materials({rig})"
            if written_on_stage:
                material += f" | {{{STAGE!r}: {written_on_stage[STAGE]}}}"
            elif list(materials) == [DEFAULT]:
                material += f'["{DEFAULT}"]'
        given = ", ".join(["material", *(f"{name}={value!r}" for name, value in options.items())])
        lines = [f"mesh = {self.reading}", f"scene = {scene}", f"material = {material}"]
        if self.stage is not None and self.stage.stage is not None:
            bounds, kind, viewer = self.stage.stage
            stage = f"ph.stage({bounds}, {kind!r}, {python_of(viewer)})"
            blocks = [f"mesh = pv.MultiBlock({{'mesh': mesh, {STAGE!r}: {stage}}})"] if is_single else []
            lines[1:1] = blocks or [f"mesh[{STAGE!r}] = {stage}"]
        lines += [f"lit = mesh.phong.shade(scene, {given})"]
        lines += self._picture_lines(given)
        if self._on_stage:
            lines += [f"lit.pop({STAGE!r})", *(["lit = lit[0]"] if is_single else [])]
        lines += [f'lit.save("{stem}-lit.{"vtp" if is_single else "vtkhdf"}")']
        used = "\n".join(lines)
        modules = {"np.": "import numpy as np", "pv.": "import pyvista as pv", "ph.": "import pvphong as ph"}
        imports = [line for name, line in modules.items() if name in used]
        return "\n".join(
            [*(["from dataclasses import replace", ""] if "replace(" in used else []), *imports, "", used, ""]
        )

    def _picture_lines(self, given: str) -> list[str]:
        """Return the lines of the script that write the picture.

        `given` is the text of the arguments of `shade` after the scene. As in `write`, the light model of a picture
        does not clamp before a display transform.
        """
        look, lines, drawn, scene = self.picture, list[str](), "lit", "scene"
        if look.display != _PLAIN and self.scene.light_model.clamp:
            scene = "replace(scene, light_model=replace(scene.light_model, clamp=False))"
        if self.refined:
            refined = {name: value for name, value in self.options.items() if name in ("feature_angle", "matrix")}
            options = ", ".join(f"{name}={value!r}" for name, value in {"tolerance": self.refine, **refined}.items())
            lines, drawn = [f"shown = mesh.phong.refine({scene}, material, {options})"], "shown"
        elif scene != "scene":
            lines, drawn = [f"shown = mesh.phong.shade({scene}, {given})"], "shown"
        if (matrix := self.options.get("matrix")) is not None:
            drawn = f"{drawn}.transform(np.array({matrix}), inplace=False)"
        how = [f'"{self.stem}.png"', "viewer=scene.viewer", f"size={look.size}", f"background={look.background!r}"]
        how += [f"display={python_of(look.display)}"] if look.display != _PLAIN else []
        return [*lines, f"{drawn}.phong.save({', '.join(how)})"]

    def write(self, what: str, folder: Path) -> Path:
        """Write one of `FILES` into a folder and return its path.

        Parameters
        ----------
        what : str
            One of `FILES`.
        folder : Path
            The folder.

        Raises
        ------
        ValueError
            If the file cannot be made.
        """
        check.choice("file", what, FILES)
        ending = {"rig": "-rig.json", "png": ".png"}.get(what, f"-lit.{what}")
        path = folder / f"{self.stem}{ending}"
        if what == "rig":
            self.save_rig(path)
        elif what == "py":
            path.write_text(self.script(), encoding="utf-8")
        else:
            lit = self._for_picture if what == "png" else self.lit
            matrix = self.options.get("matrix")
            if what in ("png", "glb") and matrix is not None:  # these show the mesh where it is drawn
                lit = lit.transform(np.array(matrix), inplace=False)
            how = {"viewer": self.scene.viewer, **vars(self.picture)} if what == "png" else dict[str, Any]()
            save(lit, path, **how)
        return path

    @property
    def _for_picture(self) -> Any:
        """The lit mesh or blocks for a picture, refined if the view is.

        Before a display transform, nothing is clamped.
        """
        if self.refined and not self.is_as_shown:
            return next(iter(self.refined.values())) if len(self.refined) == 1 else pv.MultiBlock(dict(self.refined))
        if self.picture.display == _PLAIN or self.is_as_shown:
            return self.pictured
        model = self.scene.light_model
        return (
            self._lit_in(replace(self.scene, light_model=replace(model, clamp=False))) if model.clamp else self.pictured
        )

    def save_rig(self, path: Path) -> None:
        """Write scene and materials; raise ``ValueError`` if they cannot be written."""
        self.scene.save(path, materials=self._written)

    def read(self, what: str) -> tuple[str, bytes]:
        """Return the name and the bytes of one of `FILES`; see `write`."""
        with tempfile.TemporaryDirectory() as folder:
            path = self.write(what, Path(folder))
            return path.name, path.read_bytes()


def reading_file(name: str) -> str:
    """Return the Python code of an expression that reads the file `name`."""
    return f"ph.read({PurePath(name).name!r})"


class HasArrays(Exception):
    """Raised for a value that contains images or arrays, because Python code cannot contain them."""


_CODED = (Scene, Viewer, LightModel, Display, Material, Colormap, *LIGHT_TYPES.values(), *REFLECTANCES.values())
"""Classes whose instances the script creates by calling `ph.<name of the class>`."""


def python_of(value: Any, indent: str = "") -> str:
    """Return Python code for `value`, a scene, light, material or similar, with `pvphong` as `ph`.

    `indent` are the spaces before the code's last line.
    """
    kind: Any = type(value)
    inside = f"{indent}    "

    def listed(parts: Iterable[str]) -> str:
        """Return the text of all parts, each on its own line, for use between brackets."""
        return "\n" + "".join(f"{inside}{part},\n" for part in parts) + indent

    if isinstance(value, Scene):
        names = "lights", "viewer", "light_model"
        return f"ph.Scene({listed(f'{name}={python_of(getattr(value, name), inside)}' for name in names)})"
    if isinstance(value, tuple) and isinstance(value[0] if value else None, _CODED):
        return f"[{listed(python_of(each, inside) for each in value)}]"
    if isinstance(value, float | int | str | tuple | None):
        return repr(value)
    if kind not in _CODED:
        raise HasArrays
    given = [
        f"{each.name}={python_of(getattr(value, each.name), inside)}"
        for each in fields(kind)
        if each.default is MISSING or getattr(value, each.name) != each.default
    ]
    return f"ph.{kind.__name__}({', '.join(given)})"
