"""Several meshes, dropped files and measured lamps, in a real Chromium."""

import numpy as np
import pytest
import pyvista as pv
from browsers import needs_a_browser
from pages import bring
from photometric_files import ies

import pvphong as ph

pytestmark = needs_a_browser


@pytest.fixture(autouse=True)
def no_errors(page):
    """After each test, the browser's console has no error."""
    page.driver.get_log("browser")
    yield
    assert [each for each in page.driver.get_log("browser") if each["level"] == "SEVERE"] == []


@pytest.fixture(scope="module")
def files(folder):
    """Files of meshes, a lamp, a rig, and of no use."""
    found = {name: folder / name for name in ("post.stl", "lamp.ies", "rig.json", "notes.txt")}
    pv.Cube(center=(0, 0.75, 0), x_length=0.3, y_length=0.3).save(found["post.stl"])
    ies(found["lamp.ies"], np.arange(0.0, 91.0, 15.0), [0.0], [1000.0 * np.cos(np.radians(np.arange(0.0, 91.0, 15.0)))])
    ph.Scene([ph.PointLight((1, 1, 1), name="bulb")]).save(found["rig.json"])
    found["notes.txt"].write_text("notes")
    return found


def drop(page, *paths, onto="view", shift=False):
    """Drag files from a file manager over an element of the page, and drop them there."""
    target = page.all(onto)[0]
    page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", target)
    rect = page.settled(lambda: target.rect)
    top = page.driver.execute_script("return arguments[0].getBoundingClientRect().top", target)
    where = {"x": round(rect["x"] + rect["width"] / 2), "y": round(top + rect["height"] / 2)}
    data = {"items": [], "files": [str(path) for path in paths], "dragOperationsMask": 1}
    for kind in ("dragEnter", "dragOver", "drop"):
        if kind == "drop":
            page.until(lambda: page.all("drop-hint"))
            said = page.all("drop-hint")[0].text
        event = {"type": kind, "data": data, "modifiers": 8 if shift else 0} | where
        page.driver.execute_cdp_cmd("Input.dispatchDragEvent", event)
    page.until(lambda: not page.all("drop-hint"))
    return said


def names(page):
    return [part["name"] for part in page.state("parts")]


def test_a_mesh_is_added_named_given_a_material_and_removed(page, files):
    lights, middle = page.state("lights"), page.middle()
    page.all("add-mesh")[0].find_element("css selector", "input[type=file]").send_keys(str(files["post.stl"]))
    page.until(lambda: names(page) == ["ball", "post"])
    assert page.state("lights") == lights
    assert len(page.all("mesh-row")) == 2
    page.until(lambda: page.all("download-vtkhdf") and not page.all("download-vtp"))
    page.until(lambda: "'post': ph.read('post.stl')" in page.state("script"))
    page.type("mesh-name", "mast", page.all("mesh-row")[1])
    page.until(lambda: names(page) == ["ball", "mast"])
    page.type("mesh-name", "ball", page.all("mesh-row")[1])
    page.until(lambda: "Name must be different" in page.state("notice"))
    page.until(lambda: page.typed("mesh-name", page.all("mesh-row")[1]) == "mast")
    assert len(page.all("material")) == 2
    page.driver.execute_script("window.trame.state.set('chosen_mesh', 'mast')")
    page.until(lambda: len(page.all("material")) == 1)
    page.trigger("choose_material", 1, "gold")
    page.until(lambda: page.state("materials")[1]["preset"] == "gold")
    assert page.state("materials")[0]["preset"] != "gold"
    page.click("remove-mesh", page.all("mesh-row")[0])
    page.until(lambda: not page.all("mesh-row") and page.state("title").startswith("mast: "))
    page.until(lambda: np.abs(page.middle() - middle).max() > 20)
    page.click("undo")
    page.until(lambda: names(page) == ["ball", "mast"])
    page.until(lambda: np.abs(page.middle() - middle).max() < 20)


def test_the_list_chooses_the_mesh_whose_material_is_shown(page, files):
    page.all("add-mesh")[0].find_element("css selector", "input[type=file]").send_keys(str(files["post.stl"]))
    page.until(lambda: len(page.all("material")) == 2)
    field = page.all("material-of")[0]
    page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", field)
    page.settled(lambda: field.rect)
    field.click()
    item = "//div[contains(@class, 'v-overlay--active')]//div[normalize-space(.)='post']"
    page.until(lambda: page.driver.find_element("xpath", item).click() is None)
    page.until(lambda: len(page.all("material")) == 1)
    page.click("undo")
    page.until(lambda: not page.all("material-of") and len(page.all("material")) == 1)


def test_a_dropped_mesh_is_opened_or_with_shift_added(page, files):
    assert "hold Shift" in drop(page, files["post.stl"])
    page.until(lambda: names(page) == ["post"])
    page.click("undo")
    page.until(lambda: names(page) == ["ball"])
    assert "beside the others" in drop(page, files["post.stl"], shift=True)
    page.until(lambda: names(page) == ["ball", "post"])


def test_other_files_are_dropped_as_what_they_are_or_refused(page, files):
    drop(page, files["post.stl"], onto="add-mesh")
    page.until(lambda: names(page) == ["ball", "post"])
    drop(page, files["rig.json"], files["lamp.ies"])
    page.until(lambda: [light["called"] for light in page.state("lights")] == ["bulb", "lamp"])
    drop(page, files["notes.txt"])
    page.until(lambda: "not notes.txt" in page.state("notice") and ".ldt" in page.state("notice"))
    assert names(page) == ["ball", "post"]


def test_the_first_mesh_that_is_dropped_is_opened_also_after_a_rig(page, files):
    drop(page, files["rig.json"], files["post.stl"])
    page.until(lambda: names(page) == ["post"])


def test_a_measured_lamp_is_brought_with_its_gizmo_and_undone(page, files):
    before = [light["called"] for light in page.state("lights")]
    bring(page, "lamp", files["lamp.ies"])
    page.until(lambda: page.light("lamp"))
    assert page.light("lamp")["selected"]
    assert "times its measured brightness" in page.state("notice")
    chip = next(field for field in page.light("lamp")["fields"] if field["name"] == "photometry")
    assert "7 x 1 angles" in chip["map"]
    fields = page.light("lamp")["fields"]
    page.drag((60, -40))  # its target is the centre of the mesh
    page.until(lambda: page.light("lamp")["fields"] != fields)
    for _ in range(2):
        page.click("undo")
    page.until(lambda: [light["called"] for light in page.state("lights")] == before)
