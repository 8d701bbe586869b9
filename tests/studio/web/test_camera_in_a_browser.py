"""Views, the axis cross and the turntable, in a real Chromium."""

import io

import numpy as np
import pyvista as pv
from browsers import needs_a_browser
from pages import bring, switch

pytestmark = needs_a_browser


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
    switch(page, "axes")
    page.until(lambda: np.abs(corner() - before).max() < 3)


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
    page.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(folder)})
    page.click("download-turntable")
    page.until(lambda: (folder / "ball-1.gif").exists())
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
