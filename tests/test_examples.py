from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from forked import run_script

EXAMPLES = Path(__file__).parent.parent / "examples"
SCRIPTS = sorted(script for script in EXAMPLES.glob("*.py") if script.stem != "arguments")

CAPTION = 40
"""Rows of pixels at the bottom of a panel of `hard_cases` that its caption may take."""


MEASURED = ("accuracy_costs_time", "only_what_it_needs", "phong_and_the_truth")
"""Those whose pictures show times, which no two runs share."""


def test_the_gallery_shows_every_example_and_links_to_it():
    gallery = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    assert len(SCRIPTS) >= 4
    for script in SCRIPTS:
        assert f"![]({script.stem}.png) | **[" in gallery
        assert f"]({script.name})" in gallery
        assert (EXAMPLES / f"{script.stem}.png").stat().st_size < 800_000
    assert gallery.count(".py)") == len(SCRIPTS)


def run(script, *options, folder, off_screen=False):
    told = run_script(script, folder, *options, folder=folder, off_screen=off_screen)
    (picture,) = folder.iterdir()
    assert picture.name == f"{script.stem}.png"
    return picture, told


@pytest.mark.parametrize("name", ["lit_airplane", "live_window", "place_lights"])
def test_its_window_leaves_a_picture_too(name, tmp_path):
    run(EXAMPLES / f"{name}.py", "--window", folder=tmp_path, off_screen=True)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_the_example_runs_and_leaves_a_picture(script, tmp_path):
    picture, told = run(script, folder=tmp_path)
    assert f"wrote {picture}" in told
    image, shown = pv.read(picture), pv.read(EXAMPLES / picture.name)
    assert image.dimensions == shown.dimensions, "the gallery's picture is an old one"
    if script.stem not in MEASURED:
        off = abs(image.active_scalars[:, :3].astype(float) - shown.active_scalars[:, :3]).mean()
        assert off < 2, "the gallery's picture is an old one"  # drivers differ along edges
    pixels = image.active_scalars[:, :3].astype(int)
    colors, counts = np.unique(pixels, axis=0, return_counts=True)
    assert len(colors) > 500, "shaded surfaces have many colours"
    assert counts.max() < 0.9 * len(pixels), "more than background is seen"
    assert pixels.max() > 150, "it is not black"
    if script.stem == "hard_cases":
        width, height, _ = image.dimensions
        every_pair_differs(pixels.reshape(2, height // 2, width, 3)[:, CAPTION:], told.count("off by up to"))


def every_pair_differs(panels, count):
    """A pair of the same colours differs in no pixel; those of the gallery in 2 % of the surface or more."""
    assert count >= 5
    for number, (ours, usual) in enumerate(np.array_split(panels, count, axis=2)):
        differ = (np.abs(ours - usual) > 10).any(axis=2)
        drawn = (ours < 250).any(axis=2)
        assert differ.sum() > 0.02 * drawn.sum() > 0, f"pair {number} is one picture twice"
