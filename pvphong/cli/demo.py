"""`pvphong demo`: light PyVista's bundled airplane and write a report."""

from __future__ import annotations

import time
from pathlib import Path

import pyvista as pv
from pyvista import examples
from rich.console import Console
from rich.markdown import Markdown

from pvphong.base.files import written_aside
from pvphong.base.text import changed_fields
from pvphong.cli.options import busy
from pvphong.meshes.saving import save
from pvphong.optics.lights import DirectionalLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer

SCENE = Scene(
    lights=[
        DirectionalLight(direction=(-1, -1, -2), diffuse="white", name="sun"),
        SpotLight(
            position=(900, 600, 900),
            direction=(0, 0, -1),
            cone_angle=25,
            exponent=8,
            attenuation=(1, 0, 1e-7),
            diffuse=(1.0, 0.8, 0.5),
            name="lamp",
        ),
    ],
    viewer=Viewer(position=(2500, -900, 1200), focal_point=(900, 650, 150), up=(0, 0, 1)),
    light_model=LightModel(ambient=0.1, reflection="blinn-phong"),
)

PLASTIC = Material(ambient=0.1, diffuse=(0.2, 0.3, 0.8), specular=0.5, shininess=40)


def demo(*, folder: Path = Path("pvphong-demo")) -> None:
    """Light PyVista's bundled airplane; write the mesh, a picture, the rig and a report into a folder.

    Parameters
    ----------
    folder
        Folder for the four files, created if missing.
    """
    files = {
        "mesh": folder / "airplane.vtp",
        "picture": folder / "airplane.png",
        "rig": folder / "rig.json",
        "report": folder / "report.md",
    }
    with busy("Lighting the airplane"):
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ValueError(f"folder must be a folder that can be created; got {folder} ({error}).") from error
        mesh = examples.load_airplane()
        started = time.perf_counter()
        lit = mesh.phong.shade(SCENE, PLASTIC)
        report = _report(lit, time.perf_counter() - started)
        save(lit, files["picture"], viewer=SCENE.viewer)
        save(lit, files["mesh"])
        SCENE.save(files["rig"])
        with written_aside(files["report"]) as aside:
            aside.write_text(report, encoding="utf-8")
    console = Console()
    console.print(Markdown(report))
    console.print()
    for what, path in files.items():
        print(f"{what:8}{path}")


def _report(lit: pv.PolyData, seconds: float) -> str:
    """Return a report in Markdown about a lit mesh: its size, its lights and its diagnosis.

    `seconds` is the time that lighting took.
    """
    darkest, brightest = (", ".join(f"{c:.3f}" for c in end(axis=0)) for end in (lit["phong"].min, lit["phong"].max))
    rows = [
        ("mesh", f"{lit.n_points} points, {lit.n_cells} faces"),
        *(
            ("light", f"{light.name}: {type(light).__name__}, {changed_fields(light, without=('name', 'on', 'frame'))}")
            for light in SCENE.world_lights
        ),
        ("material", changed_fields(PLASTIC)),
        ("light model", changed_fields(SCENE.light_model)),
        ("lit in", f"{1e3 * seconds:.1f} ms, normals included"),
        ("darkest red, green, blue", darkest),
        ("brightest red, green, blue", brightest),
    ]
    table = "\n".join(f"| {name} | {value} |" for name, value in rows)
    diagnosis = lit.phong.diagnose().explain()
    return f"# Lit airplane\n\n| | |\n|---|---|\n{table}\n\n## Diagnosis of the mesh\n\n```text\n{diagnosis}\n```\n"
