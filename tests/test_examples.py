"""Form of the gallery's scripts. The build of the manual runs them and checks their pictures."""

import ast
import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest
from forked import run_script
from PIL import Image

import pvphong as ph
from pvphong.accessor import BlocksPhong, MeshPhong
from pvphong.plotter import PlotterPhong

EXAMPLES = Path(__file__).parent.parent / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))
SHADED = EXAMPLES / "lights_as_data.png"


@pytest.fixture(scope="module")
def support():
    spec = importlib.util.spec_from_file_location("gallery_support", EXAMPLES / "guide" / "gallery_support.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_gallery_orders_every_example(support):
    assert sorted(support.ORDER) == [script.stem for script in SCRIPTS]
    assert sorted(SCRIPTS, key=lambda script: support.in_order(str(script)))[0].stem == "lit_airplane"
    index = (EXAMPLES / "guide" / "index.md").read_text(encoding="utf-8")
    assert {"gallery/index", "reference/index"} <= set(index.splitlines())


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_an_example_has_a_title_a_story_and_a_picture(script):
    text = script.read_text(encoding="utf-8")
    title, underline, empty, *story = ast.get_docstring(ast.parse(text)).splitlines()
    assert re.fullmatch("=+", underline)
    assert len(underline) == len(title)
    assert not empty
    assert story
    for heading, line in re.findall(r"^# %%\n# (.+)\n# (-+)$", text, flags=re.MULTILINE):
        assert len(line) == len(heading), heading
    cells = text.split("# %%\n")[1:]
    assert len(cells) >= 2
    assert all(cell.startswith("# ") for cell in cells), "a cell begins with text"
    assert re.search(r"\.show\(|open_gif\(|in_screenshots=True", text), "it draws"
    assert "argparse" not in text


@pytest.mark.parametrize("name", ["lit_airplane", "in_a_browser"])
def test_it_runs_as_a_script_too_and_leaves_no_file(name, tmp_path):
    run_script(EXAMPLES / f"{name}.py", folder=tmp_path, off_screen=True)
    assert not list(tmp_path.iterdir())


def test_the_build_refuses_pictures_that_show_nothing(support, tmp_path):
    shaded = np.asarray(Image.open(SHADED).convert("RGB"))
    noise = np.random.default_rng(1).integers(0, 255, (90, 160, 3), np.uint8)
    small = np.full_like(shaded, 255)
    small[:40, :40] = shaded[200:240, 200:240]
    pictures = {
        "black": (np.zeros_like(shaded), "black"),
        "nearly black": (noise // 8, "black"),
        "one colour": (np.full_like(shaded, 200), "one colour"),
        "background": (small, "one colour"),
        "flat": (shaded // 64 * 64, "colours"),
    }
    for name, (pixels, fault) in pictures.items():
        Image.fromarray(pixels).save(tmp_path / f"{name}.png")
        assert fault in " ".join(support.faults_of(tmp_path / f"{name}.png")), name
    assert support.faults_of(SHADED) == []


@pytest.mark.parametrize(("turns", "faults"), [((0, 4, 8), []), ((0, 0, 0), ["it does not move"])])
def test_the_build_refuses_animations_that_stand_still(support, tmp_path, turns, faults):
    picture = Image.open(SHADED).convert("RGB").resize((240, 160))
    frames = [picture.rotate(turn).quantize(128) for turn in turns]
    frames[0].save(tmp_path / "moving.gif", save_all=True, append_images=frames[1:], duration=100)
    assert support.faults_of(tmp_path / "moving.gif") == faults


@pytest.mark.parametrize("differ", [True, False])
def test_the_build_compares_the_halves_of_hard_cases(support, tmp_path, differ):
    pixels = np.asarray(Image.open(SHADED).convert("RGB"))[:, :400]
    other = pixels[::-1] if differ else pixels
    Image.fromarray(np.hstack([other, pixels])).save(tmp_path / "pair.png")
    assert support.has_two_halves(tmp_path / "pair.png") == differ


def test_the_reference_lists_every_public_name_once():
    text = (EXAMPLES / "guide" / "reference" / "index.rst").read_text(encoding="utf-8")
    listed, module = [], ""
    for line in text.splitlines():
        if line.startswith(".. currentmodule:: "):
            module = line.removeprefix(".. currentmodule:: ")
        elif re.fullmatch(r"   [A-Za-z_][\w.]*", line):
            listed.append(f"{module}.{line.strip()}")
    accessors = "MeshPhong", "BlocksPhong", "PlotterPhong"  # listed in their modules, below
    public = [f"pvphong.{name}" for name in ph.__all__ if name not in ("pipeline", *accessors)]
    public += [f"pvphong.pipeline.{name}" for name in ph.pipeline.__all__]
    for kind in (MeshPhong, BlocksPhong, PlotterPhong):
        of_kind = f"{kind.__module__}.{kind.__name__}"
        public += [of_kind, *(f"{of_kind}.{name}" for name in dir(kind) if not name.startswith("_"))]
    assert sorted(listed) == sorted(public)
