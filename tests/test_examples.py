import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from forked import run_script
from PIL import Image, ImageSequence

EXAMPLES = Path(__file__).parent.parent / "examples"
SCRIPTS = sorted(script for script in EXAMPLES.glob("*.py") if script.stem != "arguments")

CAPTION = 40
"""Rows of pixels at the bottom of a panel of `hard_cases` that its caption may take."""


MEASURED = ("accuracy_costs_time", "only_what_it_needs", "phong_and_the_truth")
"""Those whose pictures show times, which no two runs share."""


GIFS = ("moving_light",)
"""Those whose pictures move."""


def picture_of(script):
    return f"{script.stem}.{'gif' if script.stem in GIFS else 'png'}"


def frames(picture):
    """Pixels of all frames, shape (frames, rows, columns, 3), rows from below to above."""
    with Image.open(picture) as image:
        return np.stack([np.asarray(frame.convert("RGB"))[::-1] for frame in ImageSequence.Iterator(image)]).astype(int)


def test_the_gallery_shows_every_example_and_links_to_it():
    gallery = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    assert len(SCRIPTS) >= 4
    for script in SCRIPTS:
        picture = picture_of(script)
        assert f"![]({picture}) | **[" in gallery
        assert f"]({script.name})" in gallery
        assert (EXAMPLES / picture).stat().st_size < (1_500_000 if script.stem in GIFS else 800_000)
    assert gallery.count(".py)") == len(SCRIPTS)


def run(script, *options, folder, off_screen=False):
    told = run_script(script, folder, *options, folder=folder, off_screen=off_screen)
    (picture,) = folder.iterdir()
    assert picture.name == picture_of(script)
    return picture, told


@pytest.mark.parametrize("name", ["lit_airplane", "live_window", "place_lights"])
def test_its_window_leaves_a_picture_too(name, tmp_path):
    run(EXAMPLES / f"{name}.py", "--window", folder=tmp_path, off_screen=True)


def test_without_what_writes_gifs_one_line_says_so(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "imageio", None)
    monkeypatch.setattr(sys, "argv", ["moving_light.py", str(tmp_path)])
    monkeypatch.syspath_prepend(EXAMPLES)
    with pytest.raises(SystemExit, match=r"^A GIF needs imageio: pip install imageio\.$"):
        runpy.run_path(str(EXAMPLES / "moving_light.py"))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_the_example_runs_and_leaves_a_picture(script, tmp_path):
    picture, told = run(script, folder=tmp_path)
    assert f"wrote {picture}" in told
    image, shown = frames(picture), frames(EXAMPLES / picture.name)
    assert image.shape == shown.shape, "the gallery's picture is an old one"
    if script.stem not in MEASURED:
        assert abs(image - shown).mean() < 2, "the gallery's picture is an old one"  # drivers differ along edges
    if script.stem in GIFS:
        assert abs(np.diff(image, axis=0)).mean(axis=(1, 2, 3)).min() > 1, "every frame shows another light"
    pixels = image.reshape(-1, 3)
    colors, counts = np.unique(pixels @ (2**16, 2**8, 1), return_counts=True)
    assert len(colors) > 500, "shaded surfaces have many colours"
    assert counts.max() < 0.9 * len(pixels), "more than background is seen"
    assert pixels.max() > 150, "it is not black"
    if script.stem == "hard_cases":
        _, height, width, _ = image.shape
        every_pair_differs(pixels.reshape(2, height // 2, width, 3)[:, CAPTION:], told.count("off by up to"))


def every_pair_differs(panels, count):
    """A pair of the same colours differs in no pixel; those of the gallery in 2 % of the surface or more."""
    assert count >= 5
    for number, (ours, usual) in enumerate(np.array_split(panels, count, axis=2)):
        differ = (np.abs(ours - usual) > 10).any(axis=2)
        drawn = (ours < 250).any(axis=2)
        assert differ.sum() > 0.02 * drawn.sum() > 0, f"pair {number} is one picture twice"
