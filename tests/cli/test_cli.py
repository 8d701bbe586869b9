import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.cli.app import main
from pvphong.cli.demo import PLASTIC, SCENE
from pvphong.meshes.default_scene import default_scene

COMMANDS = ["demo", "shade", "view", "plan", "validate", "tradeoff", "diagnose"]


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


CLOUD = pv.PolyData(np.eye(3))
BEYOND = pv.PolyData(np.eye(3), faces=[3, 0, 1, 9])


def run(words):
    return main(words.split())


def in_a_process(words, **environment):
    command = [sys.executable, "-m", "pvphong", *words.split()]
    return subprocess.run(
        command, capture_output=True, text=True, timeout=120, check=False, env=os.environ | environment
    )


def files():
    return sorted(os.listdir())


def save_blocks(**blocks):
    pv.MultiBlock(blocks).save("blocks.vtm")


def one_line(text):
    """A table's or a report's words, however it is wrapped."""
    return " ".join(text.split())


# --- the command itself ---


def test_python_dash_m_and_version():
    process = in_a_process("--version")
    assert (process.returncode, process.stdout.strip()) == (0, version("pvphong"))


@pytest.mark.parametrize("command", COMMANDS)
def test_every_parameter_has_a_help_text(command, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    assert run(f"{command} --help") == 0
    parameters = [line for line in capsys.readouterr().out.splitlines() if re.match(r"│ (\* )? *(--|MESH)", line)]
    assert parameters
    for line in parameters:
        assert re.match(r"│ (\* )? *(--[a-z-]+|MESH)( -[a-z])?( [A-Z|]+(\.\.\.)?)*  +\S", line), line


def test_importing_the_package_loads_no_command_line():
    code = "import sys, pvphong; sys.exit(bool({'cyclopts', 'rich'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# --- what is refused ---

NO_MESH, NO_FACES = "mesh must be a mesh file that PyVista can read", "mesh must be a mesh with faces, or points with"
NO_FOLDER, NO_OUTPUT = "path must be in a folder that exists", "output must be a file that holds the colours of "
REFUSED = {
    "shado": 'Unknown command "shado". Did you mean "shade"?',
    "shade": "MESH requires an argument",
    "shade m.vtp": "--output requires an argument",
    "shade m.vtp -o o.vtp --colour red": "Unknown option: --colour",
    "shade m.vtp -o o.vtp --precision half": 'Choose from: "float32", "float64"',
    "shade m.vtp -o o.vtp --size ten 10": "--size",
    "shade missing.vtp -o o.vtp": "mesh must be a file that exists; got missing.vtp.",
    "shade spere.vtp -o o.vtp": "got spere.vtp. Did you mean 'sphere.vtp'?",
    "shade no/sphere.vtp -o o.vtp": "got no/sphere.vtp. There is no folder no.",
    "shade parts.json -o o.vtp": "got parts.json. It is a scene file: use it with --scene.",
    "shade other.json -o o.vtp": NO_MESH,
    "shade half.ply -o o.vtp": NO_MESH,  # VTK's reader would end the process
    "shade cloud.vtp -o o.vtp": NO_FACES,
    "shade beyond.vtp -o o.vtp": "index 9 in face 0",
    "shade blocks.vtm -o o.vtm": f"block ['cloud']: {NO_FACES}",
    "shade sphere.vtp -o o.stl": NO_OUTPUT + "a mesh: one of .vtp,",
    "shade sphere.vtp -o o.jpg": ", .vtmb, or .png for a picture; got o.jpg.",
    "shade sphere.vtp -o o": NO_OUTPUT + "a mesh: one of .vtp,",
    "shade sphere.vtp -o o.vtm": NO_OUTPUT + "a single mesh",
    "shade sphere.vtp -o no/o.vtp": NO_FOLDER,
    "shade sphere.vtp -o no/o.png": NO_FOLDER,
    "shade sphere.vtp -o o.vtp --material golt": "Did you mean 'gold'?",
    "shade sphere.vtp -o o.vtp --diffuse blu": "diffuse must be a number",
    "shade sphere.vtp -o o.vtp --diffuse 1,2": "diffuse must be a number",
    "shade sphere.vtp -o o.vtp --shininess=-1": "shininess must be a finite number >= 0",
    "shade sphere.vtp -o o.vtp --reflectance ggxx": "Did you mean 'ggx'?",
    "shade sphere.vtp -o o.vtp --reflectance ggx:rough=1": "Did you mean 'roughness'?",
    "shade sphere.vtp -o o.vtp --reflectance ggx": "--reflectance must be given its roughness too; got ggx.",
    "shade sphere.vtp -o o.vtp --reflectance ggx:roughness": "--reflectance ggx must be followed by fields as in",
    "shade sphere.vtp -o o.vtp --reflectance ggx:roughness=0": "roughness must be a finite number > 0 and <= 1",
    "shade sphere.vtp -o o.vtp --reflectance ggx:roughness=0.5:f0=2": "f0 must be a part of the light",
    "shade sphere.vtp -o o.vtp --reflectance retro:shininess=-1": "shininess must be a finite number >= 0",
    "shade sphere.vtp -o o.vtp --reflectance ward:alpha_x=1:alpha_y=1": "tangents must be known for this reflectance",
    "shade sphere.vtp -o o.vtp --tolerance=-1": "tolerance must be a finite number >= 0",
    "shade sphere.vtp -o o.vtp --albedo hue": "albedo must be one of 'tint'; got hue",
    "shade sphere.vtp -o o.vtp --albedo oak.png": "albedo must be a point array, or an image file that exists; got oak",
    "shade sphere.vtp -o o.vtp --albedo half.png": "albedo must be an image file that Pillow can read; got half.png.",
    "shade sphere.vtp -o o.vtp --albedo grey.png": "albedo must be an array, its name, or a texture for a mesh with",
    "shade sphere.vtp -o o.vtp --scene missing.json": "path must be a scene file that can be read",
    "shade sphere.vtp -o o.vtp --scene garbage.json": "path must be a scene file in JSON",
    "shade sphere.vtp -o o.vtp --scene other.json": 'format must be a JSON object with "format": "pvphong scene"',
    "shade sphere.vtp -o o.png --size 0 10": "width must be a finite number >= 1",
    "shade sphere.vtp -o o.png --background whyte": "background must be a number",
    "shade sphere.vtp -o o.vtp --size 20 10": "--size must be left out, for a mesh has none",
    "shade sphere.vtp -o o.vtp --background red": "--background must be left out",
    "shade sphere.vtp -o o.png --components": "--components must be left out, for a .png holds no arrays",
    "shade sphere.vtp -o o.ply --array lit": "--array must be left out, for a .ply holds no arrays",
    "shade sphere.vtp -o o.vtp --scene parts.json": "material must be one, or one of them named 'default'",
    "plan blocks.vtm --scene parts.json": "material must be a mapping with the names of all blocks",
    "diagnose half.ply": NO_MESH,
    "plan sphere.vtp --tolerance=-1": "tolerance must be a finite number >= 0",
    "validate": "MESH must be given, or --all in its place",
    "validate sphere.vtp --output errors.ply": NO_OUTPUT + "signed errors",
    "validate sphere.vtp --scene opengl.json --specular 0.5": "scene must be one that VTK can draw",
    "validate blocks.vtm --output errors.vtp": NO_OUTPUT + "signed errors: one of .vtm,",
    "validate sphere.vtp --report told.md": "--report must be given together with --all",
    "validate sphere.vtp --all": "--all must be alone or with --report",
    "validate --all --json told.json": "--all must be alone or with --report",
    "validate --all --shininess 4": "--all must be alone or with --report",
    "validate --all --report told.pdf": ".md",
    "validate --all --report no/told.md": NO_FOLDER,
    "tradeoff sphere.vtp --tolerance 0": "tolerance must be a finite number > 0",
    "tradeoff sphere.vtp --seconds=-1": "seconds must be a finite number > 0",
    "tradeoff sphere.vtp --plot no/a.png": NO_FOLDER,
    "tradeoff sphere.vtp --plot a.bmp": "suffix of path must be one of",
    "tradeoff blocks.vtm": f"block ['cloud']: {NO_FACES}",
    "demo --folder garbage.json": "folder must be one that can be made; got garbage.json",
}


@pytest.mark.usefixtures("sphere")
@pytest.mark.parametrize(("words", "message"), REFUSED.items(), ids=REFUSED)
def test_a_wrong_call_or_input_is_one_line_status_2_and_no_file(capfd, monkeypatch, words, message):
    monkeypatch.setattr("pvphong.studies.accuracy.measure.interleaved", lambda *_: pytest.fail("it measured"))
    CLOUD.save("cloud.vtp")
    BEYOND.save("beyond.vtp")
    save_blocks(**({"cloud": CLOUD} if words.startswith(("shade", "tradeoff")) else {"one": pv.Sphere()}))
    pv.Sphere().save("half.ply")
    os.truncate("half.ply", 20_000)
    for name in ("grey.png", "half.png"):
        pv.Texture(np.random.default_rng(0).integers(0, 255, (40, 40, 3)).astype(np.uint8)).to_image().save(name)
    os.truncate("half.png", 1000)
    Path("garbage.json").write_text("garbage")
    parts = dict.fromkeys(("lid", "box"), ph.Material())
    ph.Scene([ph.DirectionalLight()]).save("parts.json", materials=parts)
    Path("other.json").write_text('{"format": "other"}')
    ph.Scene([ph.PointLight(position=(1, 2, 3))], light_model=ph.LightModel.opengl()).save("opengl.json")
    capfd.readouterr()
    before = files()
    assert run(words) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert message in err
    assert files() == before


@pytest.mark.usefixtures("sphere")
@pytest.mark.parametrize(
    ("error", "status", "said"), [(KeyboardInterrupt, 130, ""), (OSError("disk\n full"), 2, "error: disk full\n")]
)
def test_an_interruption_and_a_failing_machine_are_no_traceback(monkeypatch, capsys, error, status, said):
    def fail(_path):
        raise error

    monkeypatch.setattr("pvphong.cli.options.read_mesh", fail)
    assert run("shade sphere.vtp -o lit.vtp") == status
    assert capsys.readouterr().err == said


# --- shade; formats and failing disks are in meshes/test_files ---


def test_shade_without_a_scene_uses_the_default_scene(sphere, capsys):
    assert run("shade sphere.vtp -o lit.vtp") == 0
    lit = pv.read("lit.vtp")
    np.testing.assert_array_equal(lit["phong"], sphere.phong.shade(default_scene(sphere))["phong"])
    assert lit["phong"].dtype == np.float32
    assert lit.active_scalars_name == "phong"
    assert capsys.readouterr().out == "lit.vtp\n"
    assert files() == ["lit.vtp", "sphere.vtp"]


def test_shade_with_a_rig_and_all_options(sphere):
    SCENE.save("rig.json")
    shape = "--reflectance metal:color=1,0.7,0.3"
    look = (
        f"{shape} --material gold --ambient 0.25 --specular 1,0.5,0.25 --emission #ff6347 --shininess 3.5 --albedo tint"
    )
    how = "--array lit --components --precision float64"
    assert run(f"shade sphere.vtp -o lit.vtp --scene rig.json {look} {how}") == 0
    material = ph.Material(
        ambient=0.25,
        diffuse=ph.Material.named("gold").diffuse,
        specular=(1, 0.5, 0.25),
        shininess=3.5,
        emission="tomato",
        reflectance=ph.Metal((1.0, 0.7, 0.3)),
    )
    expected = sphere.phong.shade(SCENE, material, name="lit", albedo="tint", components=True, precision="float64")
    lit = pv.read("lit.vtp")
    assert set(lit.array_names) == set(expected.array_names)
    for name in expected.array_names:
        np.testing.assert_array_equal(lit[name], expected[name])


@pytest.mark.usefixtures("sphere")
def test_a_picture_of_the_size_and_background_asked_for():
    assert run("shade sphere.vtp -o lit.png --size 120 60 --background navy --material jade") == 0
    picture = pv.read("lit.png")
    assert picture.dimensions == (120, 60, 1)
    pixels = picture.active_scalars.reshape(60, 120, 3)
    np.testing.assert_array_equal(pixels[0, 0], (0, 0, 128))
    middle = pixels[30, 60].astype(int)
    assert middle[1] > max(middle[0], middle[2]) > 30  # jade is green


@pytest.mark.usefixtures("sphere")
def test_a_viewer_that_looks_elsewhere_is_moved_to_see_the_mesh_and_that_is_said(capsys):
    light = ph.DirectionalLight(frame="headlight")
    for name, position in {"away.json": (0, 0, 5), "before.json": (0, 0, -5)}.items():
        ph.Scene([light], ph.Viewer(position=position, focal_point=(0, 0, 9))).save(name)
    note = "note: the scene's viewer sees nothing of this mesh, and was moved to see all of it.\n"
    pictures = []
    for name, said in (("away.json", note), ("before.json", "")):
        assert run(f"shade sphere.vtp -o lit.png --scene {name} --size 90 60") == 0
        assert capsys.readouterr() == ("lit.png\n", said)
        pictures.append(pv.read("lit.png").active_scalars.reshape(60, 90, 3))
    assert (pictures[0] != 255).mean() > (pictures[1] != 255).mean() > 0.01
    np.testing.assert_allclose(*(picture[30, 45].astype(int) for picture in pictures), atol=4)  # from the same side


def test_materials_of_a_rig_are_applied_and_options_change_them(sphere):
    scene, red = ph.Scene([ph.DirectionalLight()], ph.Viewer()), ph.Material(diffuse="red", shininess=3)
    scene.save("rig.json", materials={"default": red, "deep/two": ph.Material.named("gold")})
    save_blocks(one=sphere, deep=pv.MultiBlock({"two": sphere}))
    for options, change in {"": {}, "--specular 0.5": {"specular": 0.5}}.items():
        assert run(f"shade sphere.vtp -o lit.vtp --scene rig.json {options}") == 0
        assert run(f"shade blocks.vtm -o lit.vtm --scene rig.json {options}") == 0
        blocks = pv.read("lit.vtm")
        gold = ph.Material.named("gold")
        for lit, material in [(pv.read("lit.vtp"), red), (blocks["one"], red), (blocks["deep"]["two"], gold)]:
            expected = sphere.phong.shade(scene, replace(material, **change))
            np.testing.assert_array_equal(lit["phong"], expected["phong"])
    assert run("shade sphere.vtp -o lit.vtp --scene rig.json --material jade") == 0
    np.testing.assert_array_equal(
        pv.read("lit.vtp")["phong"], sphere.phong.shade(scene, ph.Material.named("jade"))["phong"]
    )


def test_a_picture_is_laid_on_by_texture_coordinates():
    sheet = pv.Plane(i_resolution=4, j_resolution=4)
    sheet.save("sheet.vtp")
    image = np.random.default_rng(0).integers(0, 255, (3, 4, 3)).astype(np.uint8)
    pv.Texture(image).to_image().save("oak.png")
    SCENE.save("rig.json")
    assert run("shade sheet.vtp -o lit.vtp --scene rig.json --albedo oak.png") == 0
    expected = sheet.phong.shade(SCENE, albedo=pv.Texture(image))
    np.testing.assert_array_equal(pv.read("lit.vtp")["phong"], expected["phong"])


def test_blocks_are_shaded_block_by_block(sphere):
    cube = pv.Cube(center=(2, 0, 0))
    save_blocks(one=sphere, gap=None, deep=pv.MultiBlock({"two": cube}))
    assert run("shade blocks.vtm -o lit.vtm") == 0
    lit, scene = pv.read("lit.vtm"), default_scene(pv.MultiBlock([sphere, cube]))
    assert lit.keys() == ["one", "gap", "deep"]
    np.testing.assert_array_equal(lit["one"]["phong"], sphere.phong.shade(scene)["phong"])
    np.testing.assert_array_equal(lit["deep"]["two"]["phong"], cube.phong.shade(scene)["phong"])
    assert run("shade blocks.vtm -o lit.png") == 0


def test_a_volume_is_lit_on_its_surface():
    pv.ImageData(dimensions=(4, 4, 4)).save("box.vti")
    assert run("shade box.vti -o lit.vtp --feature-angle none") == 0
    assert pv.read("lit.vtp")["phong"].shape == (4**3 - 2**3, 3)


def test_edges_are_sharp_unless_the_command_says_otherwise():
    cube = pv.Cube(clean=True)
    cube.clear_data()
    cube.save("cube.vtp")
    for given, count in {"": 24, "auto": 24, "100": 8, "none": 8}.items():
        assert run(f"shade cube.vtp -o lit.vtp {given and '--feature-angle ' + given}") == 0
        assert pv.read("lit.vtp").n_points == count


# --- view ---


@pytest.mark.usefixtures("sphere")
@pytest.mark.parametrize(
    ("environment", "message"),
    [({"PYVISTA_OFF_SCREEN": "true"}, "PYVISTA_OFF_SCREEN must be unset"), ({"DISPLAY": ":97"}, "DISPLAY must be")],
)
def test_view_without_a_display_is_an_error_and_no_crash(environment, message):
    process = in_a_process("view sphere.vtp", **environment)
    assert process.returncode == 2
    assert process.stderr.startswith(f"error: {message}")
    assert "pvphong shade MESH -o picture.png" in process.stderr


def test_view_shows_the_surface_in_the_rig(sphere, monkeypatch):
    calls = []
    monkeypatch.setattr("pvphong.cli.view.show", lambda *args, **options: calls.append((args, options)))
    scene = replace(SCENE, viewer=ph.Viewer(position=(3, 2, 1)))
    scene.save("rig.json")
    assert run("view sphere.vtp --scene rig.json --material ruby") == 0
    (((mesh, *rest), options),) = calls
    assert mesh.n_points == sphere.n_points
    assert rest == [scene, {"default": ph.Material.named("ruby")}]
    assert options["title"] == "pvphong: sphere.vtp"
    assert (options["stem"], options["feature_angle"]) == ("sphere", "auto")
    assert run("view sphere.vtp --feature-angle none --background navy") == 0
    assert (calls[1][1]["feature_angle"], calls[1][1]["background"]) == (None, "navy")
    assert run("view sphere.vtp --albedo tint") == 0
    assert [options["albedo"] for _, options in calls] == [None, None, "tint"]
    assert run("view sphere.vtp --shadows --occluder sphere.vtp") == 0
    (_, rig, _), options = calls[3]
    assert rig.light_model.shadows
    assert [occluder.n_points for occluder in options["occluders"]] == [sphere.n_points]


# --- diagnose and plan ---


def test_diagnose_says_ok_with_status_0_and_faults_with_status_1(sphere, capsys):
    BEYOND.save("beyond.vtp")
    save_blocks(good=sphere, bad=CLOUD)
    for file, status, said in [
        ("sphere.vtp", 0, [": ok"]),
        ("beyond.vtp", 1, ["invalid_cells"]),
        ("blocks.vtm", 1, ["good:", "ok", "bad:", "nothing_to_light"]),
    ]:
        assert run(f"diagnose {file}") == status
        out, err = capsys.readouterr()
        assert re.search(".*".join(said), out, re.DOTALL)
        assert err == ""


@pytest.mark.parametrize(("command", "status"), [("diagnose", 1), ("plan", 0), ("validate", 1)])
def test_blocks_without_a_mesh_are_said_to_have_none(command, status, capsys):
    save_blocks(none=None, nested=pv.MultiBlock())
    assert run(f"{command} blocks.vtm") == status
    assert "nothing to light" in capsys.readouterr().out


def test_plan_shows_what_the_rig_calls_for(sphere, capsys):
    away = ph.SpotLight(position=(0, 0, 5), direction=(0, 0, 1), cone_angle=20, name="away")
    ph.Scene(lights=[away, ph.DirectionalLight(name="sun")]).save("rig.json")
    ph.Scene(lights=[ph.PointLight(position=(0, 0, 1e6))]).save("far.json")
    save_blocks(one=sphere, two=sphere)
    for words, said in [
        ("sphere.vtp --scene rig.json", ["lies outside the cone", "It reads normals; the colours do not change when"]),
        ("sphere.vtp --scene far.json --tolerance 0.01", ["It reads normals;"]),
        ("blocks.vtm", ["one:", "two:"]),
    ]:
        assert run(f"plan {words} --verbose") == 0
        shown = one_line(capsys.readouterr().out)
        assert all(part in shown for part in said)


# --- validate ---


@pytest.mark.usefixtures("sphere")
def test_validate_agrees_with_vtk_and_fails_where_the_colours_are_wrong(monkeypatch, capsys):
    from pvphong.studies.validate import validation

    ph.Scene(lights=[ph.PointLight(position=(1, 2, 3))]).save("rig.json")
    assert run("validate sphere.vtp --scene rig.json --json told.json --output errors.vtp") == 0
    assert capsys.readouterr().out.startswith("Passed: ")
    assert json.loads(Path("told.json").read_text())["passed"] is True
    assert pv.read("errors.vtp").n_points == pv.read("sphere.vtp").n_points
    right = validation.evaluate
    monkeypatch.setattr(validation, "evaluate", lambda p, n, *args, **how: right(p, -np.asarray(n), *args, **how))
    assert run("validate sphere.vtp --scene rig.json") == 1
    assert capsys.readouterr().out.startswith("Failed: ")


def test_validate_all_writes_a_report_and_fails_with_its_scenes(monkeypatch, capsys):
    from pvphong.studies.validate import report as vtk_report

    monkeypatch.setattr(vtk_report, "CASES", vtk_report.CASES[:2])
    assert run("validate --all --report told.md") == 0
    assert "All 2 scenes passed" in capsys.readouterr().out
    assert files() == ["told-pictures", "told.md"]
    monkeypatch.setattr(vtk_report.Comparison, "passed", False)
    monkeypatch.setattr(vtk_report, "_pictures", list)
    assert run("validate --all") == 1
    assert "2 of 2 scenes failed" in capsys.readouterr().out


# --- tradeoff ---


@pytest.mark.usefixtures("sphere")
def test_tradeoff_prints_the_report_and_writes_figure_and_numbers(capsys):
    options = "--seconds 2 --tolerance 0.01 --plot a.png --csv a.csv --json a.json"
    assert run(f"tradeoff sphere.vtp {options}") == 0
    shown = capsys.readouterr().out
    assert len(shown.splitlines()) <= 5 + 3
    assert shown.splitlines()[-3:] == ["a.png", "a.csv", "a.json"]
    numbers = json.loads(Path("a.json").read_text())
    assert numbers["tolerance"] == 0.01
    assert f"at the vertices: {numbers['chosen']}, " in shown
    assert len(Path("a.csv").read_text().splitlines()) == 1 + len(numbers["rows"])
    assert files() == ["a.csv", "a.json", "a.png", "sphere.vtp"]


@pytest.mark.usefixtures("sphere")
def test_blocks_are_validated_by_themselves_and_traded_off_together(sphere, capsys):
    save_blocks(ball=sphere, gap=None, deep=pv.MultiBlock({"box": pv.Box((2, 3, 2, 3, 2, 3)).triangulate()}))
    assert run("validate blocks.vtm --json told.json --output errors.vtm") == 0
    told = json.loads(Path("told.json").read_text())
    assert list(told) == ["ball", "deep/box"]
    assert [part["n"] for part in told.values()] == [sphere.n_points, 8]
    errors = pv.read("errors.vtm")
    assert [block.n_points for block in errors] == [sphere.n_points, 8]
    assert "phong_error" in errors[0].point_data
    out = capsys.readouterr().out
    assert re.search(r"^ball:\nPassed: all .*^deep/box:\nPassed: all 8", out, re.DOTALL | re.MULTILINE)
    assert run("tradeoff blocks.vtm --seconds 1") == 0
    assert f"ways to light {sphere.n_points + 8} points:" in capsys.readouterr().out


@pytest.mark.usefixtures("sphere")
def test_on_a_terminal_it_is_said_how_to_be_told_more(monkeypatch, capsys):
    assert run("diagnose sphere.vtp") == 0
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    assert run("diagnose sphere.vtp") == 0
    assert capsys.readouterr().err == "(--verbose tells all of it.)\n"
    assert run("diagnose sphere.vtp --verbose") == 0
    assert capsys.readouterr().err == ""


# --- what fits a terminal ---

COLUMNS = 80
TOLD = {
    "plan sphere.vtp --scene rig.json --tolerance 0.004 --feature-angle none": 0,
    "plan blocks.vtm --scene rig.json": 0,
    "diagnose sphere.vtp": 0,
    "diagnose faulty.vtp": 1,
    "diagnose blocks.vtm": 0,
    "validate sphere.vtp": 0,
    "validate blocks.vtm": 0,
}


@pytest.mark.parametrize("verbose", ["", " --verbose"])
@pytest.mark.parametrize(("words", "status"), TOLD.items(), ids=TOLD)
def test_what_is_told_fits_80_columns_and_breaks_no_word(sphere, words, status, verbose, monkeypatch, capsys):
    """`tradeoff`, which never says the same twice, and `validate --all` have it in the tests of their reports."""
    monkeypatch.setenv("COLUMNS", str(COLUMNS))
    names = {"name": "the lamp over the long table in the hall"}
    ph.Scene([ph.PointLight(position=(0, 0, 5), **names), ph.DirectionalLight(name="sun")]).save("rig.json")
    faulty = sphere.copy()
    faulty.point_data.active_normals = np.zeros((faulty.n_points, 3))
    faulty.points[4] = np.nan
    faulty.save("faulty.vtp")
    save_blocks(ball=sphere, **{"a box": pv.Box().triangulate()})
    assert run(words + verbose) == status
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= COLUMNS
    if not verbose:
        blocks = max(len(re.findall(r"^(?:ball|a box):$", shown, re.MULTILINE)), 1)
        assert len(shown.splitlines()) <= blocks * 6
    monkeypatch.setattr("pvphong.base.text.WIDTH", 1000)
    assert run(words + verbose) == status
    wide = capsys.readouterr().out
    assert sorted(shown.replace("─", "").split()) == sorted(wide.replace("─", "").split())


# --- demo ---


def test_demo_leaves_a_lit_mesh_a_picture_the_rig_and_a_report_and_can_be_repeated(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(COLUMNS))
    assert run("demo --folder new/demo") == 0
    out, folder = capsys.readouterr().out, Path("new/demo")
    lit = pv.read(folder / "airplane.vtp")
    expected = pv.examples.load_airplane().phong.shade(SCENE, PLASTIC)
    np.testing.assert_array_equal(lit["phong"], expected["phong"])
    assert ph.Scene.load(folder / "rig.json") == SCENE
    pixels = pv.read(folder / "airplane.png").active_scalars
    assert 0.05 < (pixels[:, 2] > pixels[:, 0].astype(int) + 50).mean() < 0.9  # blue
    report = (folder / "report.md").read_text()
    words = re.compile(r"[A-Za-z]{5,}")
    assert set(words.findall(report)) <= set(words.findall(out))  # none is broken
    assert max(map(len, out.splitlines())) <= COLUMNS
    for said in ("1335 points, 2452 faces", "sun: DirectionalLight", ph.diagnose(lit).explain()):
        assert said in report
    for name in ("airplane.vtp", "airplane.png", "rig.json", "report.md"):
        assert str(folder / name) in out
    assert "1335 points, 2452 faces" in out
    assert run("demo --folder new/demo") == 0
    assert run("demo") == 0
    assert files() == ["new", "pvphong-demo"]


# --- shadows ---


@pytest.fixture
def hat():
    """A file with a roof over the sphere, and a rig with a light above."""
    pv.Plane(center=(0, 0, 2), i_size=9, j_size=9).save("hat.vtp")
    viewer = ph.Viewer(position=(0, -3, 1))
    ph.Scene([ph.DirectionalLight(name="sun")], viewer).save("rig.json")


@pytest.mark.usefixtures("hat")
def test_shadows_of_other_files(sphere, capsys):
    assert run("shade sphere.vtp -o lit.vtp --scene rig.json --shadows --occluder hat.vtp --components") == 0
    lit = pv.read("lit.vtp")
    assert not lit["phong_visibility_sun"].any()
    rig = ph.Scene.load("rig.json")
    dark = replace(rig, light_model=ph.LightModel(shadows=True))
    expected = sphere.phong.shade(dark, occluders=[pv.read("hat.vtp")])["phong"]
    np.testing.assert_allclose(lit["phong"], expected, atol=1e-6)
    assert run("shade sphere.vtp -o lit.vtp --scene rig.json --ambient-occlusion --occluder hat.vtp --components") == 0
    assert pv.read("lit.vtp")["phong_sky"].min() < 0.5
    capsys.readouterr()
    assert run("plan sphere.vtp --scene rig.json --shadows --occluder hat.vtp --verbose") == 0
    assert re.search(r"shadow +on +sun", capsys.readouterr().out)
    assert run("plan sphere.vtp --scene rig.json --shadows --verbose") == 0
    assert re.search(r"shadow +off +sun: the mesh is", capsys.readouterr().out)


@pytest.mark.usefixtures("sphere", "hat")
def test_a_rigs_own_shadows_are_kept(capsys):
    model = ph.LightModel(shadows=True, ambient_occlusion=0.5)
    replace(ph.Scene.load("rig.json"), light_model=model).save("dark.json")
    assert run("plan sphere.vtp --scene dark.json --occluder hat.vtp --ambient-occlusion --verbose") == 0
    assert re.search(r"shadow +on", capsys.readouterr().out)


@pytest.mark.usefixtures("sphere", "hat")
def test_an_occluder_that_does_nothing_is_refused(capsys):
    assert run("shade sphere.vtp -o lit.vtp --occluder hat.vtp") != 0
    assert "--occluder must be left out where nothing casts shadows" in one_line(capsys.readouterr().err)
