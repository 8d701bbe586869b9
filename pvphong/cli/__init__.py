"""The command line: `pvphong`, or `python -m pvphong`.

Exit status 0 is success, 1 is a mesh that `diagnose` finds fault with, or colours that `validate` finds too far from
VTK's, 2 is bad input: one line on the error output says which.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import pyvista as pv
from cyclopts import App, CycloptsError, Parameter
from rich.console import Console
from rich.markdown import Markdown

from pvphong.base import check
from pvphong.base.types import ColorLike, Precision
from pvphong.cli.demo import run_demo
from pvphong.cli.window import show
from pvphong.meshes import pictures
from pvphong.meshes.default_scene import studio_scene
from pvphong.meshes.files import BLOCK_FORMATS, MESH_FORMATS, read_mesh, refuse_suffix, save_lit
from pvphong.meshes.lit import datasets, map_blocks, shade_mesh
from pvphong.meshes.lit import plan as plan_mesh
from pvphong.meshes.surfaces import surface
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.studies.accuracy import tradeoff as measure_tradeoff
from pvphong.studies.accuracy.figure import refuse_format
from pvphong.studies.diagnose.diagnosis import diagnose as diagnose_mesh

app = App(
    name="pvphong",
    help="Phong lighting of meshes as data: lit colours as arrays, in files and in pictures.",
    version=version("pvphong"),
    suppress_keyboard_interrupt=False,
)


def main(tokens: Sequence[str] | None = None) -> int:
    """Run the command line and give the exit status."""
    try:
        return app(tokens, exit_on_error=False, print_error=False, result_action="return_value") or 0
    except (CycloptsError, ValueError, OSError) as error:
        print("error:", " ".join(str(error).split()), file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


@dataclass(frozen=True)
class Look:
    """How the surface reflects.

    Parameters
    ----------
    material
        A classic material such as "gold" or "red plastic"; a dull grey if not given.
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
    ambient: str | None = None
    diffuse: str | None = None
    specular: str | None = None
    emission: str | None = None
    shininess: float | None = None

    def to_material(self) -> Material:
        """The material that the options describe."""
        named = Material() if self.material is None else _named(self.material)
        colors = {term: getattr(self, term) for term in ("ambient", "diffuse", "specular", "emission")}
        changes: dict[str, Any] = {term: _color(text) for term, text in colors.items() if text is not None}
        if self.shininess is not None:
            changes["shininess"] = self.shininess
        return replace(named, **changes)


def _named(name: str) -> Material:
    try:
        return Material.named(name)
    except ValueError as error:
        raise ValueError(f"material {error}") from error


def _color(text: str) -> ColorLike:
    """A number, numbers with commas between them, or the text itself, for `Material` to judge."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else numbers


Rig = Annotated[Path | None, Parameter(help="Lights, viewer and light model, as Scene.save writes them (JSON).")]
LookOptions = Annotated[Look, Parameter(name="*")]
_PLAIN = Look()
_SIZE = (1024, 768)
_NOTHING = "nothing to light: no block of the file holds a mesh"
_OUTPUTS = (*dict.fromkeys(MESH_FORMATS + BLOCK_FORMATS), ".png")


@app.command
def demo(*, folder: Path = Path("pvphong-demo")) -> None:
    """Light PyVista's bundled airplane; leave the mesh, a picture, the rig and a report in a folder.

    Parameters
    ----------
    folder
        Where the four files go; it is made if it does not exist.
    """
    with _busy("Lighting the airplane"):
        report, files = run_demo(folder)
    console = Console()
    console.print(Markdown(report))
    console.print()
    for what, path in files.items():
        print(f"{what:8}{path}")


@app.command
def shade(
    mesh: str,
    /,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    scene: Rig = None,
    look: LookOptions = _PLAIN,
    albedo: str | None = None,
    array: str = "phong",
    components: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    precision: Precision = "float32",
    tolerance: float = 0.0,
    size: Annotated[tuple[int, int], Parameter(negative="", show_default="{} {}".format(*_SIZE))] = _SIZE,
    background: str = "white",
) -> None:
    """Light a mesh; write it with its colours, or write a picture of it.

    Without --scene it is lit by a key, a fill and a rim light and seen as PyVista would show it.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    output
        .vtp, .vtk, .vtkhdf or .ply (8-bit vertex colours) for a mesh; .vtm, .vtmb or .vtkhdf for several
        blocks; .png for a picture.
    albedo
        Name of a point array of colours that multiply the material's ambient and diffuse.
    array
        Name of the array of lit colours.
    components
        Add the ambient, diffuse, specular, emission and per-light arrays.
    precision
        Of the arrays and the arithmetic.
    tolerance
        Largest absolute colour error that may be traded for time.
    size
        Width and height of a picture in pixels.
    background
        Colour of a picture's background.
    """
    pictures.refuse_size(size)
    refuse_suffix(output, "a mesh", _OUTPUTS)
    how = {"albedo": albedo, "components": components, "precision": precision, "tolerance": tolerance}
    with _busy(f"Lighting {mesh}"):
        outside, rig = _surface_and_scene(mesh, scene, size)
        lit = _shaded(outside, rig, look.to_material(), name=array, **how)
        if output.suffix.lower() == ".png":
            image = pictures.draw(lit, rig.viewer, name=array, size=size, background=background)
            pictures.save_picture(image, output)
            if (image == image[0, 0]).all():
                print("note: the scene's viewer sees nothing of the mesh.", file=sys.stderr)
        else:
            save_lit(lit, output, array)
    print(output)


@app.command
def view(mesh: str, /, *, scene: Rig = None, look: LookOptions = _PLAIN) -> None:
    """Show a lit mesh in a window, with gizmos to place its lights; the key h lists the keys.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    """
    outside, rig = _surface_and_scene(mesh, scene, _SIZE)
    show(outside, rig, look.to_material(), title=f"pvphong: {mesh}", stem=Path(mesh).stem)


@app.command
def plan(mesh: str, /, *, scene: Rig = None, look: LookOptions = _PLAIN, tolerance: float = 0.0) -> None:
    """Say which effects a scene calls for on a mesh, which are left out, and why.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    tolerance
        Largest absolute colour error that may be traded for time; 1/255 = 0.0039 is one step of a display.
    """
    outside, rig = _surface_and_scene(mesh, scene, _SIZE)
    material = look.to_material()
    plans = [
        (block, plan_mesh(single, rig, material, tolerance=tolerance)) for block, single in _single_meshes(outside)
    ]
    for block, found in plans:
        if block:
            print(f"{block}:")
        print(found.explain())
    if not plans:
        print(_NOTHING)


@app.command
def validate(
    mesh: str | None = None,
    /,
    *,
    scene: Rig = None,
    look: LookOptions = _PLAIN,
    json: Path | None = None,
    output: Path | None = None,
    every: Annotated[bool, Parameter(name="--all", negative="", show_default=False)] = False,
    report: Path | None = None,
) -> int:
    """Compare the lit colours with those of VTK's own shader; the exit status is 1 if they are too far apart.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    json
        A file for the comparison as JSON.
    output
        .vtp, .vtk or .vtkhdf for the mesh with the signed errors.
    every
        In place of a mesh: a standing list of scenes, on meshes that come with PyVista.
    report
        .md for what came of --all, with pictures in a folder beside it.
    """
    if every:
        if mesh is not None or look != _PLAIN or any(given is not None for given in (scene, json, output)):
            check.refuse("--all", "a mesh, a scene, a look, --json or --output beside it", "alone or with --report")
        return _validate_all(report)
    if report is not None:
        check.refuse("--report", str(report), "given together with --all")
    if mesh is None:
        check.refuse("MESH", "none", "given, or --all in its place")
    return _validate_mesh(mesh, scene, look.to_material(), json, output)


def _validate_all(report: Path | None) -> int:
    from pvphong.studies.validate.report import refuse_path, standing_report  # it loads VTK's rendering

    if report is not None:
        refuse_path(report)
    with _busy("Drawing a list of scenes with VTK"):
        found = standing_report()
    Console().print(found.table())
    print(found.summary())
    if report is not None:
        found.save(report)
        print(report)
    return 0 if found.passed else 1


def _validate_mesh(mesh: str, scene: Path | None, material: Material, json: Path | None, output: Path | None) -> int:
    if output is not None:
        refuse_suffix(output, "signed errors", tuple(suffix for suffix in MESH_FORMATS if suffix != ".ply"))
    outside, rig = _surface_and_scene(mesh, scene, _SIZE)
    if isinstance(outside, pv.MultiBlock):
        check.refuse("mesh", f"{mesh}, several blocks", "a single mesh", "Validate each block by itself.")
    with _busy(f"Drawing {mesh} with VTK"):
        from pvphong.studies.validate.validation import validate as validate_mesh  # it loads VTK's rendering

        comparison = validate_mesh(outside, rig, material)
    print(comparison)
    if json is not None:
        comparison.to_json(json)
    if output is not None:
        save_lit(comparison.to_mesh(), output, "")
    return 0 if comparison.passed else 1


@app.command
def tradeoff(
    mesh: str,
    /,
    *,
    scene: Rig = None,
    look: LookOptions = _PLAIN,
    tolerance: float = 1.0 / 255.0,
    seconds: float = 20.0,
    plot: Path | None = None,
    csv: Path | None = None,
    json: Path | None = None,
) -> None:
    """Measure what accuracy costs in time on a mesh: evaluators, simpler light models, refined meshes, VTK.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    tolerance
        Largest absolute colour error that is to be allowed; 1/255 = 0.0039 is one step of a display.
    seconds
        What the measuring may take; compiling the kernel, once per installation, is not counted.
    plot
        A figure: .png, .pdf or .svg.
    csv
        The rows as a table.
    json
        All numbers.
    """
    if plot is not None:
        refuse_format(plot)
    for output in (plot, csv, json):
        if output is not None and not output.resolve().parent.is_dir():
            check.refuse("path", output, "in a folder that exists", f"Create {output.parent} first.")
    outside, rig = _surface_and_scene(mesh, scene, _SIZE)
    if isinstance(outside, pv.MultiBlock):
        check.refuse("mesh", mesh, "a file with a single mesh", "Save one of its blocks by itself.")
    result = measure_tradeoff(outside, rig, look.to_material(), tolerance=tolerance, seconds=seconds)
    print(result)
    for path, save in ((plot, result.plot), (csv, result.to_csv), (json, result.to_json)):
        if path is not None:
            save(path)
            print(path)


@app.command
def diagnose(mesh: str, /) -> int:
    """Say what in a mesh will not light as it should; the exit status is 1 if there is anything.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    """
    named = {block: diagnose_mesh(single) for block, single in _single_meshes(read_mesh(mesh))}
    console = Console()
    for block, diagnosis in named.items():
        if block:
            print(f"{block}:")
        if console.is_terminal and diagnosis.findings:
            console.print(diagnosis.table())
        else:  # into a file or another program: unwrapped lines
            print(diagnosis)
    if not named:
        print(_NOTHING)
    return 0 if named and all(diagnosis.ok for diagnosis in named.values()) else 1


def _surface_and_scene(path: str, rig: Path | None, size: tuple[int, int]) -> tuple[Any, Scene]:
    """What is lit of a mesh file, and the scene: the rig's, or one made for a picture of this size."""
    scene = None if rig is None else Scene.load(rig)
    mesh = read_mesh(path)
    outside = map_blocks(mesh, surface) if isinstance(mesh, pv.MultiBlock) else surface(mesh)
    return outside, studio_scene(outside, size[0] / size[1]) if scene is None else scene


def _single_meshes(mesh: Any) -> Iterator[tuple[str, pv.DataSet]]:
    """A mesh alone, or each dataset of a MultiBlock with the path of its names."""
    return datasets(mesh) if isinstance(mesh, pv.MultiBlock) else iter([("", mesh)])


def _shaded(mesh: Any, scene: Scene, material: Material, **how: Any) -> Any:
    if isinstance(mesh, pv.MultiBlock):
        return map_blocks(mesh, lambda block: shade_mesh(block, scene, material, **how))
    return shade_mesh(mesh, scene, material, **how)


@contextmanager
def _busy(what: str) -> Iterator[None]:
    """A spinner on the error output, if that is a terminal."""
    with Console(stderr=True).status(what):
        yield
