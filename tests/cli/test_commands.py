"""Commands give the accessors' results, as files, pictures and text."""

import json
import re
import subprocess
import sys
from dataclasses import fields, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from apart import run_apart

import pvphong as ph
from pvphong.cli.app import app, main
from pvphong.cli.demo import PLASTIC, SCENE
from pvphong.cli.options import Lighting
from pvphong.meshes.blocks import leaves
from pvphong.meshes.default_scene import default_scene

COMMANDS = [
    *("demo", "shade", "irradiance", "view", "fit", "plan", "validate", "tradeoff", "diagnose", "daylight"),
    "compile",
]
COLUMNS = 80


def run(words):
    return main(words.split())


def ask(what, file, rig=None, material=None, model=None, **options):
    """Call a method of `mesh.phong` for a mesh file and a rig file."""
    mesh = pv.read(file)
    scene = default_scene(mesh) if rig is None else ph.Scene.load(rig)
    scene = replace(scene, light_model=model or scene.light_model)
    return getattr(mesh.phong, what)(scene, material or ph.Material(), **options)


shaded, planned = (partial(ask, what, feature_angle="auto") for what in ("shade", "plan"))
validated = partial(ask, "validate")


def test_python_dash_m_and_version():
    command = [sys.executable, "-m", "pvphong", "--version"]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip() == version("pvphong")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_parameter_has_a_help_text(command, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    assert run(f"{command} --help") == 0
    parameters = [line for line in capsys.readouterr().out.splitlines() if re.match(r"│ (\* )? {0,8}(--|MESH)", line)]
    assert parameters or command == "compile"
    for line in parameters:
        assert re.match(r"│ (\* )? *(--[a-z-]+|MESH)( -[a-z])?( [A-Z|]+(\.\.\.)?)*  +\S", line), line


@pytest.mark.parametrize("command", ["shade", "view", "plan", "validate", "tradeoff", "fit"])
def test_what_lights_takes_all_options_of_the_one_record(command):
    given = {each.name: "9" for each in fields(Lighting)}
    given |= {"scene": Path("rig.json"), "shadows": True, "ambient_occlusion": True, "occluder": ("9",), "bounces": 9}
    words = [command, "cube.vtp"]
    for name, value in given.items():
        text = [] if value is True else [*value] if isinstance(value, tuple) else [str(value)]
        words += [f"--{name.replace('_', '-')}", *text]
    needed = {"shade": ["-o", "lit.vtp"], "fit": ["-o", "rig.json", "--target", "9", "--vary", "intensity"]}
    _, found, _ = app.parse_args([*words, *needed.get(command, ())], exit_on_error=False)
    assert found.arguments["lighting"] == Lighting(**given | {"feature_angle": 9.0})


# --- fit ---


def wanted(name="wanted.vtp"):
    """Write a mesh with the colours that two of the default lights give, and return the lights."""
    mesh = pv.read("sphere.vtp")
    scene = default_scene(mesh)
    key, fill, rim = scene.lights
    lights = [replace(key, intensity=0.5), replace(fill, intensity=1.5), replace(rim, on=False)]
    lit = mesh.phong.shade(replace(scene, lights=lights), RED, feature_angle="auto")
    target = np.full((mesh.n_points, 3), np.nan)
    target[lit["pvphong_original_point"] if "pvphong_original_point" in lit.point_data else ...] = lit["phong"]
    mesh["wanted"], mesh["heavy"] = target, np.where(mesh.points[:, 2] > 0, 2.0, 1.0)
    mesh.save(name)
    return lights


def test_fit_writes_the_rig_with_the_lights_that_it_found(capsys):
    key, fill, _ = wanted()
    how = "--vary key:intensity --vary fill:intensity,diffuse --vary rim:intensity --diffuse red --shininess 3"
    assert run(f"fit wanted.vtp --target wanted -o rig.json --plot fit.png --weights heavy {how}") == 0
    out = capsys.readouterr().out
    assert "Fit of 3 lights" in out
    assert out.splitlines()[-2:] == ["rig.json", "fit.png"]
    found = {light.name: light for light in ph.Scene.load("rig.json").lights}
    assert replace(found["key"], intensity=0.5) == key
    assert found["key"].intensity == pytest.approx(0.5, abs=1e-5)
    assert found["fill"].intensity == pytest.approx(1.5, abs=1e-5)
    assert found["fill"].diffuse == pytest.approx(fill.diffuse)  # a red surface shows nothing of the other channels
    assert found["rim"].intensity == pytest.approx(0.0, abs=1e-5)
    assert ph.load_materials("rig.json")["default"] == RED
    assert len(np.unique(pv.read_texture("fit.png").to_array().reshape(-1, 3), axis=0)) > 50
    assert run("shade wanted.vtp -o lit.vtp --scene rig.json") == 0
    lit = pv.read("lit.vtp")
    np.testing.assert_allclose(lit["phong"], lit["wanted"], atol=2e-5)


def test_fit_joins_the_fields_of_a_light_that_is_named_twice():
    from pvphong.cli.fit import _fields

    found = _fields(("key:intensity", "fill:diffuse", "key:direction"))
    assert found == {"key": "intensity,direction", "fill": "diffuse"}


def test_fit_chooses_lights_of_blocks_and_reports_a_missed_tolerance(capsys):
    wanted("ball.vtp")
    pv.MultiBlock({"ball": pv.read("ball.vtp"), "box": pv.Cube(center=(2, 0, 0))}).save("two.vtm")
    options = "two.vtm --target wanted --vary intensity --diffuse red --max-lights 2 -o two.json"
    assert run(f"fit {options} --tolerance 0.5") == 0
    assert sum(light.on for light in ph.Scene.load("two.json").lights) == 1
    assert run(f"fit {options} --tolerance 1e-9") == 1
    assert "Fit of 2 of 3 lights" in capsys.readouterr().out
    assert run("fit sphere.vtp --target 0.5 --vary key:intensity,direction --tries 1 --seed 3 -o one.json") == 0


# --- shade; formats and failing disks are in meshes/test_files ---

LOOK = "--material gold --ambient 0.25 --specular 1,0.5,0.25 --emission #ff6347 --shininess 3.5 --diffuse tomato"
MATERIAL = ph.Material(
    ambient=0.25, diffuse="tomato", specular=(1, 0.5, 0.25), shininess=3.5, emission="tomato",
    albedo="tint", reflectance=ph.Metal((1.0, 0.7, 0.3)),
)  # fmt: skip
ALL = f"{LOOK} --reflectance metal:color=1,0.7,0.3 --albedo tint --array lit --components --precision float64"
RED = ph.Material(diffuse="red", shininess=3)
SHADOWS, OCCLUSION = ph.LightModel(shadows=True), ph.LightModel(ambient_occlusion=True)


def by_names(change):
    gold = replace(ph.Material.named("gold"), **change)
    return {"default": replace(RED, **change), "deep/a box": gold}


SHADED = {
    "sphere.vtp --scene away.json --tolerance 0.1": lambda: shaded("sphere.vtp", "away.json", tolerance=0.1),
    f"sphere.vtp --scene rig.json {ALL}": lambda: shaded(
        "sphere.vtp", "rig.json", MATERIAL, name="lit", components=True, precision="float64"
    ),
    "sphere.vtp --scene red.json": lambda: shaded("sphere.vtp", "red.json", RED),
    "sphere.vtp --scene red.json --material jade": lambda: shaded("sphere.vtp", "red.json", ph.Material.named("jade")),
    "blocks.vtm": lambda: shaded("blocks.vtm"),
    "blocks.vtm --scene red.json --specular 0.5": lambda: shaded("blocks.vtm", "red.json", by_names({"specular": 0.5})),
    "tile.vtp --scene rig.json --albedo oak.png": lambda: shaded(
        "tile.vtp", "rig.json", ph.Material(albedo=pv.read_texture("oak.png"))
    ),
    "sphere.vtp --scalars height --cmap terrain --clim=-0.4,0.4": lambda: shaded(
        "sphere.vtp", material=ph.Material(albedo=ph.Colormap("height", "terrain", (-0.4, 0.4)))
    ),
    "box.vti --scalars deep --cmap red,#00ff00,blue --scene rig.json": lambda: shaded(
        "box.vti", "rig.json", ph.Material(albedo=ph.Colormap("deep", ["red", "#00ff00", "blue"]))
    ),
    "box.vti --feature-angle none": lambda: shaded("box.vti", feature_angle=None),
    "cube.vtp": lambda: shaded("cube.vtp"),
    "cube.vtp --feature-angle 100": lambda: shaded("cube.vtp", feature_angle=100),
    "sphere.vtp --scene sun.json --shadows --occluder roof.vtp --components": lambda: shaded(
        "sphere.vtp", "sun.json", model=SHADOWS, occluders=[pv.read("roof.vtp")], components=True
    ),
    "sphere.vtp --scene sun.json --ambient-occlusion --occluder roof.vtp": lambda: shaded(
        "sphere.vtp", "sun.json", model=OCCLUSION, occluders=[pv.read("roof.vtp")]
    ),
    "sphere.vtp --scene dark.json --ambient-occlusion --occluder roof.vtp": lambda: shaded(
        "sphere.vtp", "dark.json", occluders=[pv.read("roof.vtp")]
    ),
}


@pytest.mark.parametrize(("words", "expected"), SHADED.items(), ids=SHADED)
def test_shade_writes_what_mesh_phong_shade_gives(words, expected, capsys):
    output = "lit.vtm" if "blocks" in words else "lit.vtp"
    assert run(f"shade {words} -o {output}") == 0
    assert capsys.readouterr() == (f"{output}\n", "")
    found, wanted = pv.read(output), expected()
    if output == "lit.vtm":
        assert found.keys() == wanted.keys()
    for one, other in zip(leaves(found), leaves(wanted), strict=True):
        assert set(one.array_names) == set(other.array_names)
        assert one.active_scalars_name == other.active_scalars_name
        np.testing.assert_array_equal(one.points, other.points)
        for name in other.point_data:
            assert one[name].dtype == other[name].dtype
            np.testing.assert_array_equal(one[name], other[name])


def test_the_bounces_of_a_rig_can_be_changed_and_left_out():
    rig = ph.Scene(light_model=ph.LightModel(bounces=2))
    found = [Lighting(bounces=given).with_rays(rig).light_model.bounces for given in (None, 0, 1)]
    assert found == [2, 0, 1]


def test_the_table_above_tells_its_options_apart():
    assert shaded("cube.vtp").n_points == 24 > shaded("cube.vtp", feature_angle=100).n_points == 8
    by_roof = SHADED["sphere.vtp --scene sun.json --shadows --occluder roof.vtp --components"]()
    assert not by_roof["phong_visibility_sun"].any()
    exact = shaded("sphere.vtp", "away.json")["phong"]
    assert abs(exact - SHADED["sphere.vtp --scene away.json --tolerance 0.1"]()["phong"]).max() > 0
    near, anywhere = (
        shaded("sphere.vtp", "dark.json", model=model, occluders=[pv.read("roof.vtp")])["phong"]
        for model in (None, ph.LightModel(shadows=True, ambient_occlusion=True))
    )
    assert (near != anywhere).any(), "what hides the sky from far away does not count in the rig"


@pytest.mark.parametrize("words", ["sphere.vtp --scene sun.json --shadows --occluder roof.vtp", "cube.vtp"])
def test_refine_writes_what_mesh_phong_refine_gives(words, capsys):
    assert run(f"shade {words} -o fine.vtp --refine 0.1 --max-points 2000 --array lit") == 0
    written, said = capsys.readouterr()
    shadowed = {"rig": "sun.json", "model": SHADOWS, "occluders": [pv.read("roof.vtp")]} if "roof" in words else {}
    options = {"tolerance": 0.1, "max_points": 2000, "name": "lit", "feature_angle": "auto"}
    found, wanted = pv.read("fine.vtp"), ask("refine", words.split()[0], **shadowed, **options)
    assert written == "fine.vtp\n"
    assert said.strip() == wanted.field_data["lit_refinement_summary"]
    np.testing.assert_array_equal(found["lit"], wanted["lit"])
    np.testing.assert_array_equal(found.points, wanted.points)


@pytest.mark.parametrize("compress", ["lz4", "zlib", "none"])
def test_arrays_are_compressed_as_asked_for(compress):
    assert run(f"shade sphere.vtp -o lit.vtp --compress {compress}") == 0
    text = Path("lit.vtp").read_bytes()
    assert (b"LZ4" in text, b"ZLib" in text) == (compress == "lz4", compress == "zlib")


def test_a_picture_of_the_size_and_background_asked_for():
    assert run("shade sphere.vtp -o lit.png --size 120 60 --background navy --material jade") == 0
    picture = pv.read("lit.png")
    assert picture.dimensions == (120, 60, 1)
    pixels = picture.active_scalars.reshape(60, 120, 3)
    np.testing.assert_array_equal(pixels[0, 0], (0, 0, 128))
    assert 30 < (pixels != (0, 0, 128)).any(axis=(1, 2)).sum() < 50  # rows: the mesh fills a picture of that shape
    middle = pixels[30, 60].astype(int)
    assert middle[1] > max(middle[0], middle[2]) > 30  # jade is green
    assert run("shade blocks.vtm -o lit.png") == 0


def test_a_picture_has_the_exposure_and_tone_curve_that_are_asked_for():
    """Colours are not clamped before, so that half the exposure shows more than half of a clamped white."""
    viewer = ph.Viewer(position=(0, 0, 3))
    ph.Scene([ph.DirectionalLight(frame="headlight", intensity=2.0)], viewer).save("bright.json")
    middle = {}
    for words in ("", "--exposure -1", "--exposure -1 --tone filmic"):
        dull = "--scene bright.json --size 60 60 --ambient 0 --diffuse 0.8 --specular 0"
        assert run(f"shade sphere.vtp -o lit.png {dull} {words}") == 0
        middle[words] = int(pv.read("lit.png").active_scalars.reshape(60, 60, 3)[30, 30, 0])
    assert middle[""] == 255
    assert middle["--exposure -1"] == pytest.approx(0.8 * 255, abs=3)
    assert middle["--exposure -1 --tone filmic"] == pytest.approx((0.6 + 0.4 * (1 - np.exp(-0.5))) * 255, abs=3)


def test_a_picture_has_the_shadows_that_are_asked_for():
    brightness = []
    for words in ("", "--shadows --occluder roof.vtp"):
        assert run(f"shade sphere.vtp -o lit.png --scene sun.json --background black --size 60 60 {words}") == 0
        brightness.append(pv.read("lit.png").active_scalars.mean())
    assert 0 < brightness[1] < 0.8 * brightness[0]


def test_a_viewer_that_looks_elsewhere_is_moved_to_see_the_mesh_and_that_is_said(capsys):
    note = "note: the scene's viewer does not see this mesh, and was moved to frame it.\n"
    for position, said in (((0, 0, 5), note), ((0, 0, -5), "")):
        viewer = ph.Viewer(position=position, focal_point=(0, 0, 9))
        ph.Scene([ph.DirectionalLight(frame="headlight")], viewer).save("up.json")
        assert run("shade sphere.vtp -o lit.png --scene up.json --size 90 60") == 0
        assert capsys.readouterr() == ("lit.png\n", said)
        assert (pv.read("lit.png").active_scalars != 255).mean() > 0.01


def test_a_mesh_that_shows_its_backs_is_lit_and_that_is_noted_once(capsys):
    ball = pv.Sphere().flip_faces()
    ball.save("stored.vtp")
    ball.clear_data()
    ball.save("inwards.vtp")
    for name, said in (("stored", "stored normals do not fit"), ("inwards", "faces look inwards"), ("sphere", "")):
        assert run(f"shade {name}.vtp -o lit.vtp") == 0
        output, notes = capsys.readouterr()
        assert output == "lit.vtp\n"
        assert said in notes
        assert notes.count("note: ") == bool(said)


REPORTED = {
    "plan sphere.vtp --feature-angle none": (0, lambda: planned("sphere.vtp", feature_angle=None)),
    "plan sphere.vtp --scene away.json --tolerance 0.1": (0, lambda: planned("sphere.vtp", "away.json", tolerance=0.1)),
    "plan cube.vtp --scene red.json": (0, lambda: planned("cube.vtp", "red.json", RED)),
    "plan blocks.vtm --scene red.json": (0, lambda: planned("blocks.vtm", "red.json", by_names({}))),
    "plan sphere.vtp --scene sun.json --shadows": (0, lambda: planned("sphere.vtp", "sun.json", model=SHADOWS)),
    "plan sphere.vtp --scene sun.json --shadows --occluder roof.vtp": (
        0, lambda: planned("sphere.vtp", "sun.json", model=SHADOWS, occluders=[pv.read("roof.vtp")])
    ),
    "diagnose sphere.vtp": (0, lambda: pv.read("sphere.vtp").phong.diagnose()),
    "diagnose faulty.vtp": (1, lambda: pv.read("faulty.vtp").phong.diagnose()),
    "diagnose beyond.vtp": (1, lambda: pv.read("beyond.vtp").phong.diagnose()),
    "diagnose faulty.vtm": (1, lambda: pv.read("faulty.vtm").phong.diagnose()),
    "validate sphere.vtp --scene red.json": (0, lambda: validated("sphere.vtp", "red.json", RED)),
    "validate blocks.vtm": (0, lambda: validated("blocks.vtm")),
}  # fmt: skip


@pytest.mark.parametrize("verbose", [False, True])
@pytest.mark.parametrize(("words", "status", "expected"), [(key, *row) for key, row in REPORTED.items()], ids=REPORTED)
def test_reports_are_those_of_mesh_phong_and_fit_80_columns(words, status, expected, verbose, capsys):
    found = expected()
    reports = found if isinstance(found, dict) else {"": found}
    lines = []
    for block, report in reports.items():
        lines += ([f"{block}:"] if block else []) + [report.explain().rstrip() if verbose else str(report)]
    words += " --verbose" * verbose
    assert run(words) == status
    shown = capsys.readouterr()
    assert shown == ("\n".join(lines) + "\n", "")
    assert max(map(len, shown.out.splitlines())) <= COLUMNS
    assert verbose or len(shown.out.splitlines()) <= 6 * len(reports)


@pytest.mark.parametrize(("command", "status"), [("diagnose", 1), ("plan", 0), ("validate", 1)])
def test_blocks_without_a_mesh_are_said_to_have_none(command, status, capsys):
    assert run(f"{command} empty.vtm") == status
    assert "nothing to light" in capsys.readouterr().out


def test_on_a_terminal_it_is_said_how_to_see_more(monkeypatch, capsys):
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    assert run("diagnose sphere.vtp") == 0
    assert capsys.readouterr().err == "(--verbose shows the whole report.)\n"
    assert run("diagnose sphere.vtp --verbose") == 0
    assert capsys.readouterr().err == ""


def test_validate_fails_where_the_colours_are_wrong(monkeypatch, capsys):
    from pvphong.studies.validate import validation

    right = validation.evaluate
    monkeypatch.setattr(validation, "evaluate", lambda p, n, *args, **how: right(p, -np.asarray(n), *args, **how))
    assert run("validate sphere.vtp --scene sun.json") == 1
    assert capsys.readouterr().out.startswith("Failed: ")


@pytest.mark.parametrize("file", ["sphere.vtp", "blocks.vtm"])
def test_validate_writes_numbers_and_errors(file):
    errors = f"errors{Path(file).suffix}"
    assert run(f"validate {file} --json numbers.json --output {errors}") == 0
    expected, numbers = validated(file), json.loads(Path("numbers.json").read_text())
    if file == "sphere.vtp":
        expected, numbers = {"": expected}, {"": numbers}
    found = zip(numbers.items(), leaves(pv.read(errors)), strict=True)
    assert [(name, part["passed"], part["n"], mesh.n_points) for (name, part), mesh in found] == [
        (name, True, part.n, part.n) for name, part in expected.items()
    ]
    assert all("phong_error" in mesh.point_data for mesh in leaves(pv.read(errors)))


def test_validate_all_writes_a_report_and_fails_with_its_scenes(monkeypatch, capsys):
    from pvphong.studies.validate import report as vtk_report

    monkeypatch.setattr(vtk_report, "CASES", vtk_report.CASES[:2])
    assert run("validate --all --report all.md") == 0
    assert "All 2 scenes passed" in capsys.readouterr().out
    assert sorted(path.name for path in Path().glob("all*")) == ["all-pictures", "all.md"]
    monkeypatch.setattr(vtk_report.Comparison, "passed", False)
    assert run("validate --all") == 1
    assert "2 of 2 scenes failed" in capsys.readouterr().out


def test_tradeoff_prints_the_report_and_writes_figure_and_numbers(capsys):
    options = "--seconds 2 --tolerance 0.01 --plot a.png --csv a.csv --json a.json"
    assert run(f"tradeoff sphere.vtp --scene sun.json --shadows --occluder roof.vtp {options}") == 0
    shown = capsys.readouterr().out
    assert len(shown.splitlines()) <= 5 + 3
    assert shown.splitlines()[-3:] == ["a.png", "a.csv", "a.json"]
    numbers = json.loads(Path("a.json").read_text())
    assert numbers["tolerance"] == 0.01
    assert next(entry["runs"] for entry in numbers["ledger"] if entry["effect"] == "shadow")  # the roof casts it
    assert f"at the vertices: {numbers['chosen']['at the vertices']}, " in shown
    assert len(Path("a.csv").read_text().splitlines()) == 1 + len(numbers["rows"])
    assert pv.read("a.png").dimensions[0] > 100
    assert run("tradeoff blocks.vtm --seconds 1 --json blocks.json") == 0
    assert json.loads(Path("blocks.json").read_text())["tolerance"] == pytest.approx(1 / 255)
    count = sum(block.n_points for block in leaves(pv.read("blocks.vtm")))
    assert f"ways to light {count} points:" in capsys.readouterr().out


def test_demo_leaves_a_lit_mesh_a_picture_the_rig_and_a_report_and_can_be_repeated(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(COLUMNS))
    assert run("demo --folder new/demo") == 0
    out, folder = capsys.readouterr().out, Path("new/demo")
    lit, report = pv.read(folder / "airplane.vtp"), (folder / "report.md").read_text()
    expected = pv.examples.load_airplane().phong.shade(SCENE, PLASTIC)
    np.testing.assert_array_equal(lit["phong"], expected["phong"])
    assert ph.Scene.load(folder / "rig.json") == SCENE
    pixels = pv.read(folder / "airplane.png").active_scalars
    assert 0.05 < (pixels[:, 2] > pixels[:, 0].astype(int) + 50).mean() < 0.9  # blue
    words = re.compile(r"[A-Za-z]{5,}")
    assert set(words.findall(report)) <= set(words.findall(out))  # no word is broken across lines
    assert max(map(len, out.splitlines())) <= COLUMNS
    for said in ("1335 points, 2452 faces", "sun: DirectionalLight", lit.phong.diagnose().explain()):
        assert said in report
    assert all(str(path) in out for path in folder.iterdir())
    assert run("demo --folder new/demo") == run("demo") == 0
    assert len(list(Path("pvphong-demo").iterdir())) == 4


def test_help_names_all_commands_as_they_name_themselves_and_loads_none_of_them():
    code = """
import sys
from pvphong.cli.app import _COMMANDS, _function, main
assert main(["--help"]) == 0
heavy = [name for name in ("numpy", "pyvista", "vtkmodules", "matplotlib") if name in sys.modules]
assert not heavy, heavy
for name, (_, does) in _COMMANDS.items():
    assert " ".join(_function(name).__doc__.split("\\n\\n")[0].split()) == does, name
"""
    assert "Light a mesh and write it with its colours" in run_apart(code)


def test_help_of_a_command_is_all_that_it_says(capsys):
    assert main(["shade", "--help"]) == 0
    assert "Many files are lit by several processes" in " ".join(capsys.readouterr().out.split())
