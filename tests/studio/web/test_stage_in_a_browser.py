"""Stage, background, camera views and turntable, in a real Chromium."""

import io
import json
import subprocess
import sys

import numpy as np
import pyvista as pv
from browsers import needs_a_browser
from pages import bring, switch

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
    for what, name in (("png", "nut.png"), ("vtp", "nut-lit.vtp"), ("rig", "nut-rig.json"), ("py", "nut-lit.py")):
        page.download(what, home / name)
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


# --- the background


def downloaded(page, home, name):
    page.download("png", home / name)
    return pv.read(home / name)


def test_the_background_is_set_in_view_and_picture_or_left_out(page, folder):
    home = folder / "background"
    home.mkdir()
    (row,) = page.driver.find_elements("css selector", '#panel-picture [data-field="background"]')
    field = row.find_element("css selector", ".studio-hex input")
    page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", field)
    field.send_keys("\ue009a\ue000", "#2060a0", "\ue007")
    page.until(lambda: np.abs(page.picture()[2, 2] - (0x20, 0x60, 0xA0)).max() < 8)
    for name, pixels in (("width", 64), ("height", 48)):
        page.trigger("type_number", name, pixels)
    page.until(lambda: "background='#2060a0'" in page.state("script") and "(64, 48)" in page.state("script"))
    image = downloaded(page, home, "ball.png").active_scalars
    np.testing.assert_array_equal(image[0], (0x20, 0x60, 0xA0))
    (home / "ball.png").unlink()
    page.trigger("edit", "background.transparent", True)
    page.until(lambda: "background='transparent'" in page.state("script"))
    image = downloaded(page, home, "ball.png").active_scalars.reshape(48, 64, 4)
    assert image[0, 0, 3] == 0
    assert image[24, 32, 3] == 255
    page.click("undo")
    page.click("undo")
    page.until(lambda: not page.state("can_undo"))
    page.until(lambda: np.abs(page.picture()[2, 2] - (0x20, 0x60, 0xA0)).max() > 30)


# --- the camera


def width_and_height(page):
    """Return the extent of the model in the view, in pixels."""
    picture = page.picture()
    is_model = np.abs(picture - picture[2, 2]).max(axis=2) > 30
    is_model[-60:] = False  # the hint at the bottom
    rows, columns = np.nonzero(is_model.any(axis=1))[0], np.nonzero(is_model.any(axis=0))[0]
    return np.ptp(columns) + 1, np.ptp(rows) + 1


def test_views_show_the_model_from_each_side_and_are_kept(page, folder):
    sides = dict(zip("xyz", (4.0, 2.0, 1.0), strict=True))
    pv.Box((-2, 2, -1, 1, -0.5, 0.5), level=6).save(folder / "box.ply")
    bring(page, "mesh", folder / "box.ply")
    page.until(lambda: page.state("title").startswith("box"))
    page.click("gizmos")  # hides them
    for name, across, up in (("front", "x", "z"), ("right", "y", "z"), ("top", "x", "y")):
        page.click(f"view-{name}")
        page.settled(lambda: page.picture().tolist())
        width, height = width_and_height(page)
        assert abs(width / height - sides[across] / sides[up]) < 0.12 * sides[across] / sides[up], name
    page.click("keep-view")
    page.until(lambda: len(page.all("kept-view")) == 1)
    page.click("view-isometric")
    page.until(lambda: width_and_height(page)[1] > 1.1 * height)
    page.all("kept-view")[0].click()
    page.until(lambda: width_and_height(page) == (width, height))
    page.all("kept-view")[0].find_element("css selector", ".v-chip__close").click()
    page.until(lambda: not page.all("kept-view"))
    page.click("gizmos")
    page.trigger("look", "from nowhere")
    page.until(lambda: "front" in page.state("notice"))


def test_the_axis_cross_is_shown_and_hidden(page):
    def corner():
        picture = page.picture()
        return picture[int(0.8 * len(picture)) : -4, 4:100]

    before = np.array(page.settled(lambda: corner().tolist()))
    switch(page, "axes")
    page.until(lambda: np.abs(corner() - before).max() > 100)
    shown = np.array(page.settled(lambda: corner().tolist()))
    switch(page, "axes")
    page.until(lambda: np.abs(corner() - shown).max() > 100)


def test_a_turntable_is_made_with_progress_and_can_be_cancelled(page, folder):
    from PIL import Image

    for name, pixels in (("width", 160), ("height", 120)):
        page.trigger("type_number", name, pixels)
    page.trigger("set_up", "three-point")
    page.until(lambda: page.light("key")["kind"] == "point")
    page.type("turntable-pictures", "120")
    page.click("turntable")
    page.until(lambda: (page.state("turntable") or 0) > 2)
    page.click("cancel-turntable")
    page.until(lambda: "The turntable is cancelled." in page.all("notice")[0].text)
    page.until(lambda: page.state("turntable") is None)
    assert not page.state("turntable_file")
    page.type("turntable-pictures", "8")
    page.click("turntable")
    page.until(lambda: page.state("turntable_file"))
    page.until(lambda: page.all("turntable-picture")[0].get_property("naturalWidth") == 160)
    page.download("turntable", folder / "ball-1.gif")
    with Image.open(io.BytesIO((folder / "ball-1.gif").read_bytes())) as gif:
        assert (gif.n_frames, gif.size) == (8, (160, 120))
        brightest = []
        for number in range(8):
            gif.seek(number)
            levels = np.asarray(gif.convert("L")).astype(float)
            brightest.append(levels[:, :80].mean() - levels[:, 80:].mean())
    assert brightest[0] > 2  # the key light is to the left of the camera, and of the one on the other side
    assert max(brightest) > 5 > -5 > min(brightest)
    page.type("turntable-pictures", "4")
    page.until(lambda: "Pictures: 4 is out of range" in page.state("notice"))


def test_a_light_of_a_stage_stops_casting_shadows_by_a_switch_in_its_row(page):
    assert not page.all("light-shadows")
    page.click("stage-ground")
    page.until(lambda: len(page.all("light-shadows")) == len(page.state("lights")))
    page.until(lambda: is_dark_at_the_foot(page))
    page.settled(lambda: page.row("key").rect)
    shadowed, evaluations = page.settled(lambda: page.picture().sum()), page.state("evaluations")
    switch(page, "light-shadows", page.row("key"))
    page.until(lambda: not page.light("key")["casts_shadows"]["value"])
    page.until(lambda: page.picture().sum() > 1.01 * shadowed)
    assert page.state("evaluations") > evaluations
    assert all(page.light(other)["casts_shadows"]["value"] for other in ("fill", "rim"))
    page.until(lambda: "casts_shadows=False" in page.state("script"))
    for _ in range(2):
        page.click("undo")
    page.until(lambda: not page.all("light-shadows"))
