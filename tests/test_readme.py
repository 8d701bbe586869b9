"""What the README shows, run. The two commands that set everything up are run by .ci/run, word for word."""

import ast
import re
import shlex
import tomllib
from dataclasses import fields
from pathlib import Path

import pytest
import pyvista as pv
from forked import run_code

import pvphong as ph
from pvphong.meshes.pictures import HEADLESS_PACKAGES
from pvphong.optics.lights import LIGHT_TYPES, Light
from pvphong.optics.maps import FIELDS
from pvphong.shading.equation import assemble
from pvphong.shading.plan.plan import is_worth_loading
from pvphong.studio.gizmos import commands

README = Path(__file__).parent.parent / "README.md"
TEXT = README.read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL)
PYTHON = [code for language, code in BLOCKS if language == "python"]
SHELL = [line for language, code in BLOCKS if language == "sh" for line in code.splitlines()]
SET_UP = 'python3 -m venv .venv && .venv/bin/pip install ".[all]" && .venv/bin/'


def test_one_command_ends_with_the_demo_one_with_the_tests_and_one_prepares_a_headless_server():
    assert {language for language, _ in BLOCKS} == {"python", "sh", "text"}  # diagrams are text
    set_ups = [line for line in SHELL if line.startswith(("python3", "apt-get"))]
    assert set_ups == [
        SET_UP + "pvphong demo",
        SET_UP.replace("install", "install -e") + "python -m pytest -n 2 --dist loadfile",
        f"apt-get install --yes {HEADLESS_PACKAGES}",
    ]


@pytest.mark.parametrize("code", PYTHON, ids=lambda code: f"{len(code.splitlines())} lines")
def test_the_python_blocks_run(code, tmp_path):
    if code is PYTHON[0]:  # the quick start's array is as it says
        code += "colors = lit['phong']\nassert (colors.shape, colors.dtype) == ((lit.n_points, 3), 'float32')\n"
        code += "assert 0 <= colors.min() < colors.max() <= 1\n"
    run_code(code, tmp_path)


def test_the_pvphong_commands_run_one_after_the_other(tmp_path):
    commands = [line.removeprefix(SET_UP) for line in SHELL]
    commands = [shlex.split(command) for command in commands if command.startswith("pvphong ")]
    assert [command[1] for command in commands] == ["demo", "shade", "shade", "plan", "validate", "diagnose"]
    words = [command[1:] for command in commands]  # for what the entry point's process runs; that has its own tests
    run_code(f"from pvphong.cli.app import main\nassert [*map(main, {words})] == {[0] * len(words)}", tmp_path)
    assert (tmp_path / "gold.png").stat().st_size > 5000
    assert "RGB" in pv.read(tmp_path / "lit.ply").point_data


def table(heading):
    """The rows of the first table under a heading, cells as strings."""
    section = TEXT.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    rows = [line for line in section.splitlines() if line.startswith("|")][2:]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]


def test_the_table_of_keys_is_the_windows():
    rows = dict(table("Keys in a window"))
    for keys, what in commands.help_entries({}):
        assert rows[keys].startswith(what) if keys in rows else keys in ("Shift", "Ctrl"), keys
    assert len(rows) == len(commands.help_entries({}))  # Shift and Ctrl share one, `view` has one of its own


def test_the_table_of_lights_names_all_fields():
    rows = {name.strip("`"): re.findall(r"`([a-z_]+)`", text) for name, text in table("Lights")}
    common = {field.name for field in fields(Light)}
    assert set(rows.pop("every light")) == common
    assert set(rows) == {kind.__name__ for kind in LIGHT_TYPES.values()}
    for name, listed in rows.items():
        assert set(listed) == {field.name for field in fields(getattr(ph, name))} - common, name


def test_the_tables_of_viewer_light_model_and_material_have_all_fields_and_their_defaults():
    rows = {name.strip("`"): text for name, text in table("Viewer and light model")}
    assert set(rows) == {"Viewer", "LightModel"}
    literal = ast.literal_eval
    shown = {
        name: {field: literal(default) for field, default in re.findall(r"`([a-z_]+)` (\(.*?\))", text)}
        for name, text in rows.items()
    }
    materials = {name.strip("`"): (default, told) for name, default, _, told in table("Materials")}
    assert {name for name, (_, told) in materials.items() if told} == FIELDS.keys() & materials.keys() | {"tangents"}
    shown["Material"] = {
        name: None if default == "none" else float(default) for name, (default, _) in materials.items()
    }
    shown["Material"] |= {"reflectance": None}  # told in a sentence below
    for name, defaults in shown.items():
        assert defaults == {field.name: field.default for field in fields(getattr(ph, name))}, name


def test_the_table_of_extras_names_all_of_them_and_what_they_bring():
    declared = tomllib.loads((README.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = declared["optional-dependencies"]
    extras.pop("docs")  # the manual's
    rows = {name.strip("`"): brings for name, brings, _ in table("Install")[1:]}
    assert rows.pop("all") == "all six"
    assert set(extras.pop("all")[0].removeprefix("pvphong[").removesuffix("]").split(",")) == set(rows)
    brought = {name: {package.split(">")[0] for package in packages} for name, packages in extras.items()}
    assert brought == {name: set(brings.lower().split(", ")) for name, brings in rows.items()}


def test_large_is_what_the_evaluator_takes_for_large():
    (told,) = re.findall(r"from ([\d ]+) points times lights on", TEXT)
    count = int(told.replace(" ", ""))
    one_light = assemble(ph.Scene([ph.DirectionalLight()], ph.Viewer()), ph.Material(), None)
    assert is_worth_loading(count, one_light)
    assert not is_worth_loading(count - 1, one_light)


def test_the_named_materials_are_all_listed():
    listed = TEXT.split("OpenGL teaching: ")[1].split("\n\n")[0].replace("\n", " ").rstrip(".")
    singles, colored = listed.split(", and ")
    colors = colored.removesuffix(" plastic or rubber").split(", ")
    kinds = [f"{color} {kind}" for kind in ("plastic", "rubber") for color in colors]
    named = {name: ph.Material.named(name) for name in ph.Material.names()}
    assert [*singles.split(", "), *kinds] == [name for name, one in named.items() if one.reflectance is None]
    told = TEXT.split("reflectances of their own: ")[1].split("\n\n")[0].replace("\n", " ")
    assert all(name in told for name, one in named.items() if one.reflectance)


def test_the_map_names_every_folder_and_only_files_that_are_there():
    section = TEXT.split("\n## Where things are\n")[1].split("\n## ")[0]
    package = README.parent / "pvphong"
    rows = [line.split("|") for line in section.splitlines() if line.startswith("| `")]
    named = {folder for row in rows for folder in re.findall(r"`(\w+)/`", row[1])}
    assert named == {path.parent.name for path in package.glob("*/__init__.py")}
    for path in re.findall(r"\b(\w+/[\w/]+\.py)\b", section):
        is_there = (package / path).exists() or any((package / folder / path).exists() for folder in named)
        assert is_there or "NAME" in path, path


def test_links_lead_somewhere():
    for target in re.findall(r"\]\((?!https?:)([^)]+)\)", TEXT):
        assert (README.parent / target).exists(), target
