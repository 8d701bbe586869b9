import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv

EXAMPLES = Path(__file__).parent.parent / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))


def test_there_are_examples():
    assert len(SCRIPTS) >= 4


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_the_example_runs_and_leaves_a_picture(script, tmp_path):
    command = [sys.executable, "-W", "error", str(script), str(tmp_path)]
    process = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    picture = tmp_path / f"{script.stem}.png"
    assert f"wrote {picture}" in process.stdout
    assert [path.name for path in tmp_path.iterdir()] == [picture.name]
    pixels = pv.read(picture).active_scalars[:, :3].astype(int)
    colors, counts = np.unique(pixels, axis=0, return_counts=True)
    assert len(colors) > 500, "shaded surfaces have many colours"
    assert counts.max() < 0.9 * len(pixels), "more than background is seen"
    assert pixels.max() > 150, "it is not black"


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_without_a_folder_the_picture_lands_in_the_current_one(script):
    assert "Path(sys.argv[1]) if len(sys.argv) > 1 else Path()" in script.read_text(encoding="utf-8")
