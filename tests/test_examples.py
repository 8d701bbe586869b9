import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv

EXAMPLES = Path(__file__).parent.parent / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))

CAPTION = 40
"""Rows of pixels at the bottom of a panel of `hard_cases` that its caption may take."""


def test_there_are_examples():
    assert len(SCRIPTS) >= 4


def run(script, folder):
    """What an example prints, and where it leaves its picture."""
    command = [sys.executable, "-W", "error", str(script), str(folder)]
    process = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, cwd=folder)
    assert process.returncode == 0, process.stderr
    picture = folder / f"{script.stem}.png"
    assert f"wrote {picture}" in process.stdout
    return process.stdout, picture


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_the_example_runs_and_leaves_a_picture(script, tmp_path):
    _, picture = run(script, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [picture.name]
    pixels = pv.read(picture).active_scalars[:, :3].astype(int)
    colors, counts = np.unique(pixels, axis=0, return_counts=True)
    assert len(colors) > 500, "shaded surfaces have many colours"
    assert counts.max() < 0.9 * len(pixels), "more than background is seen"
    assert pixels.max() > 150, "it is not black"


def test_every_hard_case_is_seen_to_differ_from_the_usual_formula(tmp_path):
    """A pair of the same colours differs in no pixel; those of the gallery in 2 % of the surface or more."""
    printed, picture = run(EXAMPLES / "hard_cases.py", tmp_path)
    image = pv.read(picture)
    width, height, _ = image.dimensions
    pixels = image.active_scalars[:, :3].astype(int).reshape(2, height // 2, width, 3)[:, CAPTION:]
    pairs = np.array_split(pixels, printed.count("off by up to"), axis=2)
    assert len(pairs) >= 5
    for number, (ours, usual) in enumerate(pairs):
        differ = (np.abs(ours - usual) > 10).any(axis=2)
        drawn = (ours < 250).any(axis=2)
        assert differ.sum() > 0.02 * drawn.sum() > 0, f"pair {number} is one picture twice"


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_without_a_folder_the_picture_lands_in_the_current_one(script):
    assert "Path(sys.argv[1]) if len(sys.argv) > 1 else Path()" in script.read_text(encoding="utf-8")
