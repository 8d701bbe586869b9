"""The stage on the page, in a real Chromium."""

import json
import subprocess
import sys

import numpy as np
import pyvista as pv
from browsers import needs_a_browser

pytestmark = needs_a_browser


def is_dark_at_the_foot(page):
    """Return whether the middle of the lower part of the view, where the floor is, differs from the view's corner."""
    picture = page.picture()
    height, width, _ = picture.shape
    return np.abs(picture[int(0.9 * height), width // 2] - picture[2, 2]).max() > 25


def test_each_stage_is_drawn_by_a_click_and_undone(page):
    title, rows = page.state("title"), page.all("plan-row")
    assert rows
    for kind in ("ground", "backdrop", "plinth"):
        page.click(f"stage-{kind}")
        page.until(lambda kind=kind: page.state("stage") == kind)
        page.until(lambda: is_dark_at_the_foot(page))
        assert page.state("title") == title
        assert [each["name"] for each in page.state("materials")] == ["mesh 1", "stage"]
    page.until(lambda: "'plinth'" in page.state("script"))
    for kind in ("backdrop", "ground", ""):
        page.click("undo")
        page.until(lambda kind=kind: page.state("stage") == kind)
    assert len(page.state("materials")) == 1
    page.until(lambda: not is_dark_at_the_foot(page))
    page.click("redo")
    page.until(lambda: page.state("stage") == "ground")
    page.click("stage-ground")  # a second click removes it
    page.until(lambda: page.state("stage") == "")


def test_a_stage_has_a_material_stays_under_another_mesh_and_is_in_the_script(page, folder):
    page.click("stage-backdrop")
    page.until(lambda: page.state("stage") == "backdrop")
    page.trigger("edit", page.state("materials")[1]["fields"][1]["key"], "#ff0000")
    name = page.state("materials")[1]["fields"][1]["name"]
    page.until(lambda: page.state("materials")[1]["fields"][1]["hex"] == "#ff0000")
    page.until(lambda: page.picture()[2, 2, 0] > page.picture()[2, 2, 2] + 40)
    page.trigger("open_example", "nut")
    page.until(lambda: page.state("title").startswith("nut") and "load_nut" in page.state("script"))
    assert page.state("stage") == "backdrop"
    assert page.state("materials")[1]["fields"][1]["hex"] == "#ff0000", name
    page.trigger("type_number", "width", 160)
    page.trigger("type_number", "height", 120)
    page.trigger("edit", "display.exposure", -1)
    page.until(lambda: "Display(exposure=-1.0)" in page.state("script") and "(160, 120)" in page.state("script"))
    home = folder / "staged"
    home.mkdir()
    page.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(home)})
    for what, name in (("png", "nut.png"), ("vtp", "nut-lit.vtp"), ("rig", "nut-rig.json"), ("py", "nut-lit.py")):
        page.click(f"download-{what}")
        page.until(lambda name=name: (home / name).exists())
    drawn = pv.read(home / "nut.png").active_scalars.astype(int)
    assert drawn[:, 0].mean() > drawn[:, 2].mean() + 20  # the red wall
    assert pv.read(home / "nut-lit.vtp").n_points == int(page.state("title").split()[1].replace(",", ""))
    assert json.loads((home / "nut-rig.json").read_text())["materials"].keys() == {"default"}
    again = home / "again"
    again.mkdir()
    (again / "script.py").write_text((home / "nut-lit.py").read_text())
    done = subprocess.run([sys.executable, "script.py"], cwd=again, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    np.testing.assert_array_equal(pv.read(again / "nut-lit.vtp")["phong"], pv.read(home / "nut-lit.vtp")["phong"])
    assert np.abs(pv.read(again / "nut.png").active_scalars.astype(int) - drawn).max() <= 1
    page.driver.save_screenshot(str(folder / "stage.png"))
