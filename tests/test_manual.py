"""Run the snippets of the README and the guide, and compare their tables with the code.

`.ci/run` runs the README's two setup commands verbatim.
"""

import re
import shlex
import tomllib
from pathlib import Path

import pytest
import pyvista as pv
from forked import run_code

import pvphong as ph
from pvphong.meshes.pictures import HEADLESS_PACKAGES
from pvphong.shading.equation import assemble
from pvphong.shading.plan.plan import is_worth_loading
from pvphong.studio.gizmos import commands

ROOT = Path(__file__).parent.parent
GUIDE = ROOT / "examples" / "guide"
PAGES = {path.stem: path.read_text("utf-8") for path in [ROOT / "README.md", *sorted(GUIDE.glob("*.md"))]}
README = PAGES["README"]


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)


SNIPPETS = [
    pytest.param(code, id=f"{page}-{number}")
    for page, text in PAGES.items()
    for number, code in enumerate(blocks(text, "python"))
]
SHELL = {page: [line for code in blocks(text, "sh") for line in code.splitlines()] for page, text in PAGES.items()}
SET_UP = 'python3 -m venv .venv && .venv/bin/pip install ".[all]" && .venv/bin/'


@pytest.mark.parametrize("code", SNIPPETS)
def test_a_snippet_runs(code, tmp_path):
    run_code(code, tmp_path)


def test_the_first_snippet_gives_the_array_that_the_readme_describes(tmp_path):
    code = blocks(README, "python")[0]
    code += "colors = lit['phong']\nassert (colors.shape, colors.dtype) == ((lit.n_points, 3), 'float32')\n"
    run_code(code + "assert 0 <= colors.min() < colors.max() <= 1\n", tmp_path)


def test_the_readme_is_short_and_has_the_commands_that_ci_runs():
    assert len(README.splitlines()) <= 150
    assert [line for line in SHELL["README"] if line.startswith(("python3", "apt-get"))] == [
        SET_UP + "pvphong demo",
        SET_UP.replace("install", "install -e") + "python -m pytest -n 3 --dist loadfile",
        f"apt-get install --yes {HEADLESS_PACKAGES}",
    ]
    assert f"apt-get install --yes {HEADLESS_PACKAGES}" in SHELL["install"]


def test_the_commands_run_one_after_the_other(tmp_path):
    words = [shlex.split(command)[1:] for command in SHELL["command-line"]]
    assert [command[0] for command in words] == ["demo", "shade", "shade", "plan", "validate", "diagnose"]
    # the function in the entry point's child process; the entry point has its own tests
    run_code(f"from pvphong.cli.app import main\nassert [*map(main, {words})] == {[0] * len(words)}", tmp_path)
    assert (tmp_path / "gold.png").stat().st_size > 5000
    assert "RGB" in pv.read(tmp_path / "lit.ply").point_data


def rows_of(page, header):
    """Return the cells of the table with a header, as strings."""
    lines = PAGES[page].split(f"\n{header}\n")[1].split("\n\n")[0].splitlines()[1:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_the_table_of_keys_is_the_windows():
    rows = dict(rows_of("window", "| key | action |"))
    for keys, what in commands.help_entries({}):
        assert rows[keys].startswith(what) if keys in rows else keys in ("Shift", "Ctrl"), keys
    assert len(rows) == len(commands.help_entries({}))  # Shift and Ctrl share one, `view` has one of its own


def test_the_table_of_extras_names_all_of_them_and_what_they_bring():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    extras = declared["optional-dependencies"]
    rows = {name.strip("`"): brings for name, brings, _ in rows_of("install", "| extra | brings | for |")[1:]}
    assert rows.pop("all") == "all of these but `docs`"
    in_all = set(extras.pop("all")[0].removeprefix("pvphong[").removesuffix("]").split(","))
    assert in_all | {"docs"} == set(rows)
    names = {name: {re.split("[>; ]", package)[0] for package in packages} for name, packages in extras.items()}
    assert names == {name: set(brings.lower().split(", ")) for name, brings in rows.items()}


def test_large_is_what_the_evaluator_takes_for_large():
    (told,) = re.findall(r"\(([\d ]+) points times lights or more\)", PAGES["install"])
    count = int(told.replace(" ", ""))
    one_light = assemble(ph.Scene([ph.DirectionalLight()], ph.Viewer()), ph.Material(), None)
    assert is_worth_loading(count, one_light)
    assert not is_worth_loading(count - 1, one_light)


def test_the_named_materials_are_all_listed():
    text = PAGES["materials"].replace("\n", " ")
    listed = text.split("OpenGL teaching: ")[1].split(".  ")[0]
    singles, colored = listed.split(", and ")
    colors = colored.removesuffix(" plastic or rubber").split(", ")
    kinds = [f"{color} {kind}" for kind in ("plastic", "rubber") for color in colors]
    named = {name: ph.Material.named(name) for name in ph.Material.names()}
    assert [*singles.split(", "), *kinds] == [name for name, one in named.items() if one.reflectance is None]
    told = text.split("reflectances of their own: ")[1].split(".  ")[0]
    assert all(name in told for name, one in named.items() if one.reflectance)


def test_the_map_names_every_folder_and_only_files_that_are_there():
    package = ROOT / "pvphong"
    text = PAGES["how-it-works"]
    folders = " ".join(row[0] for row in rows_of("how-it-works", "| folder | contents |"))
    named = set(re.findall(r"`(\w+)/`", folders))
    assert named == {path.parent.name for path in package.glob("*/__init__.py")}
    for path in re.findall(r"\b(\w+/[\w/]+\.py)\b", text):
        is_there = (package / path).exists() or any((package / folder / path).exists() for folder in named)
        assert is_there or "NAME" in path, path


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    folder = ROOT if page == "README" else GUIDE
    for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", PAGES[page]):
        assert (folder / target).exists(), target
    for benchmark in re.findall(r"bench_\w+\.py", PAGES[page]):
        assert (ROOT / "tests" / "benchmarks" / benchmark).exists(), benchmark
