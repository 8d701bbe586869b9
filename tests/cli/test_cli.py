import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong import cli
from pvphong.cli.demo import PLASTIC, SCENE
from pvphong.meshes import files as mesh_files
from pvphong.meshes.default_scene import studio_scene


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def sphere():
    """A mesh file without normals."""
    mesh = pv.Sphere(theta_resolution=12, phi_resolution=12)
    mesh.clear_data()
    mesh["tint"] = np.linspace(0, 1, 3 * mesh.n_points).reshape(-1, 3)
    mesh.save("sphere.vtp")
    return mesh


def run(*words):
    return cli.main([str(word) for word in words])


def in_a_process(*words, **environment):
    command = [sys.executable, "-m", "pvphong", *words]
    return subprocess.run(
        command, capture_output=True, text=True, timeout=120, check=False, env=os.environ | environment
    )


def files():
    return sorted(os.listdir())


# -- the command itself


def test_python_dash_m_and_version():
    process = in_a_process("--version")
    assert process.returncode == 0
    assert process.stdout.strip() == cli.version("pvphong")


def test_help_names_the_commands(capsys):
    assert run("--help") == 0
    shown = capsys.readouterr().out
    for command in ("demo", "shade", "view", "plan", "validate", "tradeoff", "diagnose"):
        assert command in shown


@pytest.mark.parametrize("command", ["demo", "shade", "view", "plan", "validate", "tradeoff", "diagnose"])
def test_every_parameter_has_a_help_text(command, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    assert run(command, "--help") == 0
    parameters = [line for line in capsys.readouterr().out.splitlines() if re.match(r"│ (\* )? *(--|MESH)", line)]
    assert parameters
    for line in parameters:
        assert re.match(r"│ (\* )? *(--[a-z]+|MESH)( -[a-z])?( [A-Z]+)*  +\S", line), line


def test_importing_the_package_loads_no_command_line():
    code = "import sys, pvphong; sys.exit(bool({'cyclopts', 'rich'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["shado"], 'Unknown command "shado". Did you mean "shade"?'),
        (["shade"], "MESH requires an argument"),
        (["shade", "m.vtp"], "--output requires an argument"),
        (["shade", "m.vtp", "-o", "o.vtp", "--colour", "red"], "Unknown option: --colour"),
        (["shade", "m.vtp", "-o", "o.vtp", "--precision", "half"], 'Choose from: "float32", "float64"'),
        (["shade", "m.vtp", "-o", "o.vtp", "--size", "ten", "10"], "--size"),
    ],
)
def test_a_wrong_call_is_one_line_and_status_2(capsys, words, message):
    assert run(*words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert message in err


# -- shade


def test_shade_without_a_scene_uses_the_studio(sphere, capsys):
    assert run("shade", "sphere.vtp", "-o", "lit.vtp") == 0
    lit = pv.read("lit.vtp")
    np.testing.assert_array_equal(lit["phong"], sphere.phong.shade(studio_scene(sphere))["phong"])
    assert lit["phong"].dtype == np.float32
    assert lit.active_scalars_name == "phong"
    assert capsys.readouterr().out == "lit.vtp\n"
    assert files() == ["lit.vtp", "sphere.vtp"]


def test_shade_with_a_rig_and_all_options(sphere):
    SCENE.save("rig.json")
    words = "--scene rig.json --material gold --specular 1,0.5,0.25 --emission tomato --shininess 3.5 --albedo tint"
    options = "--array lit --components --precision float64"
    assert run("shade", "sphere.vtp", "-o", "lit.vtp", *words.split(), *options.split()) == 0
    gold = ph.Material.named("gold")
    material = ph.Material(gold.ambient, gold.diffuse, (1, 0.5, 0.25), 3.5, "tomato")
    expected = sphere.phong.shade(SCENE, material, name="lit", albedo="tint", components=True, precision="float64")
    lit = pv.read("lit.vtp")
    assert set(lit.array_names) == set(expected.array_names)
    for name in expected.array_names:
        np.testing.assert_array_equal(lit[name], expected[name])


def test_numbers_names_and_triples_are_reflectances():
    look = cli.Look(ambient="0.25", diffuse="#ff0000", specular="0.1,0.2,0.3")
    material = ph.Material(ambient=0.25, diffuse="red", specular=(0.1, 0.2, 0.3))
    assert look.to_material() == material


@pytest.mark.parametrize("suffix", [".vtk", ".vtkhdf", ".ply"])
def test_shade_writes_the_format_of_the_suffix(sphere, suffix):
    assert run("shade", "sphere.vtp", "-o", f"lit{suffix}") == 0
    expected = sphere.phong.shade(studio_scene(sphere))["phong"]
    lit = pv.read(f"lit{suffix}")
    if suffix == ".ply":
        np.testing.assert_array_equal(lit["RGB"], np.rint(expected * 255))
    else:
        np.testing.assert_array_equal(lit["phong"], expected)


@pytest.mark.usefixtures("sphere")
def test_a_picture_of_the_size_and_background_asked_for():
    words = "shade sphere.vtp -o lit.png --size 120 60 --background navy --material jade"
    assert run(*words.split()) == 0
    picture = pv.read("lit.png")
    assert picture.dimensions == (120, 60, 1)
    pixels = picture.active_scalars.reshape(60, 120, 3)
    np.testing.assert_array_equal(pixels[0, 0], (0, 0, 128))
    middle = pixels[30, 60].astype(int)
    assert middle[1] > max(middle[0], middle[2]) > 30  # jade is green


@pytest.mark.usefixtures("sphere")
def test_a_viewer_that_looks_elsewhere_gets_its_picture_and_a_note(capsys):
    ph.Scene(viewer=ph.Viewer(position=(0, 0, 5), focal_point=(0, 0, 9))).save("away.json")
    assert run("shade", "sphere.vtp", "-o", "lit.png", "--scene", "away.json") == 0
    out, err = capsys.readouterr()
    assert (out, err) == ("lit.png\n", "note: the scene's viewer sees nothing of the mesh.\n")


def test_blocks_are_shaded_block_by_block(sphere):
    blocks = pv.MultiBlock({"one": sphere, "gap": None, "deep": pv.MultiBlock({"two": pv.Cube(center=(2, 0, 0))})})
    blocks.save("blocks.vtm")
    assert run("shade", "blocks.vtm", "-o", "lit.vtm") == 0
    lit, scene = pv.read("lit.vtm"), studio_scene(blocks)
    assert lit.keys() == ["one", "gap", "deep"]
    np.testing.assert_array_equal(lit["one"]["phong"], sphere.phong.shade(scene)["phong"])
    np.testing.assert_array_equal(lit["deep"]["two"]["phong"], blocks["deep"]["two"].phong.shade(scene)["phong"])
    assert run("shade", "blocks.vtm", "-o", "lit.png") == 0


def test_a_volume_is_lit_on_its_surface():
    pv.ImageData(dimensions=(4, 4, 4)).save("box.vti")
    assert run("shade", "box.vti", "-o", "lit.vtp") == 0
    assert pv.read("lit.vtp")["phong"].shape == (4**3 - 2**3, 3)


BAD = {
    "missing.vtp -o o.vtp": "mesh must be a mesh file that PyVista can read",
    "garbage.vtp -o o.vtp": "mesh must be a mesh file that PyVista can read",
    "garbage.xyz -o o.vtp": "mesh must be a mesh file that PyVista can read",
    "cloud.vtp -o o.vtp": "mesh must be a mesh with faces, or points with normals",
    "beyond.vtp -o o.vtp": "index 9 in face 0",
    "blocks.vtm -o o.vtm": "block ['cloud']: mesh must be a mesh with faces",
    "blocks.vtm -o o.vtp": "mesh must be a mesh with faces",
    "sphere.vtp -o o.stl": "output must be a file that holds the colours of a mesh: one of .vtp,",
    "sphere.vtp -o o": "output must be a file that holds the colours of a mesh: one of .vtp,",
    "sphere.vtp -o o.vtm": "output must be a file that holds the colours of a single mesh",
    "sphere.vtp -o no/o.vtp": "path must be in a folder that exists",
    "sphere.vtp -o no/o.png": "path must be in a folder that exists",
    "sphere.vtp -o o.vtp --material golt": "Did you mean 'gold'?",
    "sphere.vtp -o o.vtp --diffuse blu": "diffuse must be a number",
    "sphere.vtp -o o.vtp --diffuse 1,2": "diffuse must be a number",
    "sphere.vtp -o o.vtp --shininess=-1": "shininess must be a finite number >= 0",
    "sphere.vtp -o o.vtp --tolerance=-1": "tolerance must be a finite number >= 0",
    "sphere.vtp -o o.vtp --albedo hue": "albedo must be one of 'tint'; got hue",
    "sphere.vtp -o o.vtp --scene missing.json": "path must be a scene file that can be read",
    "sphere.vtp -o o.vtp --scene garbage.json": "path must be a scene file in JSON",
    "sphere.vtp -o o.vtp --scene other.json": 'format must be a JSON object with "format": "pvphong scene"',
    "sphere.vtp -o o.png --size 0 10": "width must be a finite number >= 1",
    "sphere.vtp -o o.png --background whyte": "background must be a number",
}


@pytest.mark.usefixtures("sphere")
@pytest.mark.parametrize(("words", "message"), BAD.items(), ids=BAD)
def test_bad_input_is_one_line_status_2_and_no_file(capfd, words, message):
    cloud = pv.PolyData(np.eye(3))
    cloud.save("cloud.vtp")
    pv.PolyData(np.eye(3), faces=[3, 0, 1, 9]).save("beyond.vtp")
    pv.MultiBlock({"cloud": cloud}).save("blocks.vtm")
    for name in ("garbage.vtp", "garbage.xyz", "garbage.json"):
        with open(name, "w") as file:
            file.write("garbage")
    with open("other.json", "w") as file:
        json.dump({"format": "other"}, file)
    capfd.readouterr()
    before = files()
    assert run("shade", *words.split()) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert message in err
    assert files() == before


@pytest.mark.usefixtures("sphere")
@pytest.mark.parametrize("words", [("diagnose", "half.ply"), ("shade", "half.ply", "-o", "o.vtp")])
def test_a_ply_file_cut_short_does_not_end_the_process(words):
    """As VTK's reader would, by a signal."""
    pv.Sphere().save("whole.ply")
    with open("whole.ply", "rb") as whole, open("half.ply", "wb") as half:
        half.write(whole.read()[:20_000])
    process = in_a_process(*words)
    assert process.returncode == 2
    assert process.stderr.startswith("error: mesh must be a mesh file that PyVista can read")
    assert process.stderr.count("\n") == 1


@pytest.mark.usefixtures("sphere")
def test_an_old_result_survives_a_failure(monkeypatch):
    with open("lit.vtp", "w") as file:
        file.write("old")

    def failing(*_arguments):
        raise OSError("no space left on device")

    monkeypatch.setattr(mesh_files, "_save", failing)
    assert run("shade", "sphere.vtp", "-o", "lit.vtp") == 2
    with open("lit.vtp") as file:
        assert file.read() == "old"
    assert files() == ["lit.vtp", "sphere.vtp"]


@pytest.mark.usefixtures("sphere")
def test_an_interruption_is_no_traceback(monkeypatch, capsys):
    def interrupted(_path):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "read_mesh", interrupted)
    assert run("shade", "sphere.vtp", "-o", "lit.vtp") == 130
    assert capsys.readouterr().err == ""


# -- view


@pytest.mark.usefixtures("sphere")
@pytest.mark.parametrize(
    ("environment", "message"),
    [({"PYVISTA_OFF_SCREEN": "true"}, "PYVISTA_OFF_SCREEN must be unset"), ({"DISPLAY": ":97"}, "DISPLAY must be")],
)
def test_view_without_a_display_is_an_error_and_no_crash(environment, message):
    process = in_a_process("view", "sphere.vtp", **environment)
    assert process.returncode == 2
    assert process.stderr.startswith(f"error: {message}")
    assert "pvphong shade MESH -o picture.png" in process.stderr


def test_view_shows_the_surface_in_the_rig(sphere, monkeypatch):
    calls = []
    monkeypatch.setattr(cli, "show", lambda *args, **options: calls.append((args, options)))
    SCENE.save("rig.json")
    assert run("view", "sphere.vtp", "--scene", "rig.json", "--material", "ruby") == 0
    ((mesh, scene, material), options) = calls[0]
    assert mesh.n_points == sphere.n_points
    assert scene == SCENE
    assert material == ph.Material.named("ruby")
    assert options == {"title": "pvphong: sphere.vtp", "stem": "sphere"}


# -- diagnose


@pytest.mark.usefixtures("sphere")
def test_diagnose_a_good_mesh(capsys):
    assert run("diagnose", "sphere.vtp") == 0
    assert ": ok" in capsys.readouterr().out


def test_diagnose_a_face_index_out_of_range_in_a_process_of_its_own():
    pv.PolyData(np.eye(3), faces=[3, 0, 1, 9]).save("beyond.vtp")
    process = in_a_process("diagnose", "beyond.vtp")
    assert process.returncode == 1
    assert "invalid_cells" in process.stdout
    assert process.stderr == ""


def test_diagnose_prints_a_table_on_a_terminal(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    pv.PolyData(np.eye(3)).save("cloud.vtp")
    assert run("diagnose", "cloud.vtp") == 1
    assert "\x1b[31mspoils" in capsys.readouterr().out


def test_diagnose_blocks_by_name(sphere, capsys):
    pv.MultiBlock({"good": sphere, "bad": pv.PolyData(np.eye(3))}).save("blocks.vtm")
    assert run("diagnose", "blocks.vtm") == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "good:"
    assert "ok" in lines[1]
    assert lines[2] == "bad:"


def test_blocks_without_a_mesh_are_said_to_have_none(capsys):
    pv.MultiBlock({"none": None, "nested": pv.MultiBlock()}).save("blocks.vtm")
    assert run("diagnose", "blocks.vtm") == 1
    assert "nothing to light" in capsys.readouterr().out
    assert run("plan", "blocks.vtm") == 0
    assert "nothing to light" in capsys.readouterr().out


# -- plan


@pytest.mark.usefixtures("sphere")
def test_plan_shows_what_the_rig_calls_for(capsys):
    away = ph.SpotLight(position=(0, 0, 5), direction=(0, 0, 1), cone_angle=20, name="away")
    ph.Scene(lights=[away, ph.DirectionalLight(name="sun")]).save("rig.json")
    assert run("plan", "sphere.vtp", "--scene", "rig.json") == 0
    shown = capsys.readouterr().out
    assert "lies outside the cone" in " ".join(shown.split())
    assert "It reads normals; the colours do not change when the viewer moves." in shown


@pytest.mark.usefixtures("sphere")
def test_plan_takes_a_tolerance(capsys):
    ph.Scene(lights=[ph.PointLight(position=(0, 0, 1e6))]).save("rig.json")
    assert run("plan", "sphere.vtp", "--scene", "rig.json", "--tolerance", "0.01") == 0
    assert "It reads normals;" in capsys.readouterr().out
    assert run("plan", "sphere.vtp", "--tolerance", "-1") == 2
    assert "error: tolerance must be" in capsys.readouterr().err


def test_plan_of_blocks_by_name(sphere, capsys):
    pv.MultiBlock({"one": sphere, "two": sphere}).save("blocks.vtm")
    assert run("plan", "blocks.vtm") == 0
    shown = capsys.readouterr().out
    assert "one:" in shown
    assert "two:" in shown


# -- validate


@pytest.mark.usefixtures("sphere")
def test_validate_agrees_with_vtk(capsys):
    ph.Scene(lights=[ph.PointLight(position=(1, 2, 3))]).save("rig.json")
    arguments = ("--scene", "rig.json", "--json", "told.json", "--output", "errors.vtp")
    assert run("validate", "sphere.vtp", *arguments) == 0
    assert "passed" in capsys.readouterr().out
    assert json.loads(Path("told.json").read_text())["passed"] is True
    assert pv.read("errors.vtp").n_points == pv.read("sphere.vtp").n_points


@pytest.mark.usefixtures("sphere")
def test_validate_fails_where_the_colours_are_wrong(monkeypatch, capsys):
    from pvphong.studies.validate import validation

    right = validation.evaluate

    def wrong(points, normals, *arguments, **options):
        return right(points, -np.asarray(normals), *arguments, **options)

    monkeypatch.setattr(validation, "evaluate", wrong)
    ph.Scene(lights=[ph.PointLight(position=(1, 2, 3))]).save("rig.json")
    assert run("validate", "sphere.vtp", "--scene", "rig.json") == 1
    assert "failed" in capsys.readouterr().out


@pytest.mark.usefixtures("sphere")
def test_validate_refuses_what_it_cannot_do(capsys):
    ph.Scene(light_model=ph.LightModel.opengl(), lights=[ph.PointLight(position=(1, 2, 3))]).save("rig.json")
    assert run("validate", "sphere.vtp", "--scene", "rig.json", "--specular", "0.5") == 2
    assert "error:" in capsys.readouterr().err
    assert run("validate", "sphere.vtp", "--output", "errors.ply") == 2
    assert "error:" in capsys.readouterr().err


def test_validate_all_writes_a_report_and_fails_with_its_scenes(monkeypatch, capsys):
    from pvphong.studies.validate import report as vtk_report

    monkeypatch.setattr(vtk_report, "CASES", vtk_report.CASES[:2])
    assert run("validate", "--all", "--report", "told.md") == 0
    assert "All 2 scenes passed" in capsys.readouterr().out
    assert files() == ["told-pictures", "told.md"]
    monkeypatch.setattr(vtk_report.Comparison, "passed", False)
    monkeypatch.setattr(vtk_report, "_pictures", list)
    assert run("validate", "--all") == 1
    assert "2 of 2 scenes failed" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "MESH must be given, or --all in its place"),
        ("sphere.vtp --report told.md", "--report must be given together with --all"),
        ("sphere.vtp --all", "--all must be alone or with --report"),
        ("--all --json told.json", "--all must be alone or with --report"),
        ("--all --shininess 4", "--all must be alone or with --report"),
        ("--all --report told.pdf", ".md"),
        ("--all --report no/told.md", "path must be in a folder that exists"),
    ],
)
def test_validate_refuses_calls_that_make_no_sense(words, message, capsys):
    assert run("validate", *words.split()) == 2
    assert message in capsys.readouterr().err
    assert files() == []


# -- tradeoff


@pytest.mark.usefixtures("sphere")
def test_tradeoff_prints_the_report_and_writes_figure_and_numbers(capsys):
    options = ["--seconds", 2, "--tolerance", 0.01, "--plot", "a.png", "--csv", "a.csv", "--json", "a.json"]
    assert run("tradeoff", "sphere.vtp", *options) == 0
    shown = capsys.readouterr().out
    assert "float64 reference" in shown
    assert shown.splitlines()[-3:] == ["a.png", "a.csv", "a.json"]
    with open("a.json") as file:
        numbers = json.load(file)
    assert numbers["tolerance"] == 0.01
    assert f"{numbers['chosen']} is the cheapest within 0.01" in " ".join(shown.split())
    with open("a.csv") as file:
        assert len(file.readlines()) == 1 + len(numbers["rows"])
    assert files() == ["a.csv", "a.json", "a.png", "sphere.vtp"]


@pytest.mark.usefixtures("sphere")
@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("sphere.vtp --tolerance 0", "tolerance must be a finite number > 0"),
        ("sphere.vtp --seconds=-1", "seconds must be a finite number > 0"),
        ("blocks.vtm", "mesh must be a file with a single mesh"),
        ("sphere.vtp --plot no/a.png", "path must be in a folder that exists"),
        ("sphere.vtp --plot a.bmp", "suffix of path must be one of"),
    ],
)
def test_tradeoff_of_bad_input_is_refused_before_it_measures(words, message, capsys, monkeypatch):
    monkeypatch.setattr("pvphong.studies.accuracy.measurement.interleaved", lambda *_: pytest.fail("it measured"))
    pv.MultiBlock({"one": pv.Sphere()}).save("blocks.vtm")
    assert run("tradeoff", *words.split()) == 2
    assert message in capsys.readouterr().err


# -- demo


def test_demo_leaves_a_lit_mesh_a_picture_the_rig_and_a_report(capsys):
    assert run("demo", "--folder", "new/demo") == 0
    out = capsys.readouterr().out
    mesh = pv.examples.load_airplane()
    lit = pv.read("new/demo/airplane.vtp")
    np.testing.assert_array_equal(lit["phong"], mesh.phong.shade(SCENE, PLASTIC)["phong"])
    assert ph.Scene.load("new/demo/rig.json") == SCENE
    pixels = pv.read("new/demo/airplane.png").active_scalars
    blue = (pixels[:, 2] > pixels[:, 0].astype(int) + 50).mean()
    assert 0.05 < blue < 0.9
    with open("new/demo/report.md") as file:
        report = file.read()
    assert "1335 points, 2452 faces" in report
    assert "sun: DirectionalLight" in report
    assert str(ph.diagnose(lit)) in report
    for name in ("airplane.vtp", "airplane.png", "rig.json", "report.md"):
        assert os.path.join("new", "demo", name) in out
    assert "1335 points, 2452 faces" in out


def test_demo_can_be_repeated():
    assert run("demo") == 0
    assert run("demo") == 0
    assert files() == ["pvphong-demo"]


def test_demo_in_a_folder_that_cannot_be_made(capsys):
    with open("taken", "w") as file:
        file.write("a file")
    assert run("demo", "--folder", "taken") == 2
    assert "error: folder must be one that can be made; got taken" in capsys.readouterr().err
