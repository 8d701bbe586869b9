"""Background and words of the page, in a real Chromium."""

import numpy as np
import pyvista as pv
from browsers import needs_a_browser

pytestmark = needs_a_browser


def downloaded(page, home, name):
    page.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(home)})
    page.click("download-png")
    page.until(lambda: (home / name).exists())
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


def test_lights_and_fields_have_a_photographers_names(page):
    (button,) = page.all("add-rectangle")
    assert button.text == "+ softbox"
    assert button.get_attribute("title").startswith("Rectangle light: ")
    page.click("add-point")
    fields = page.until(lambda: page.light("point")["fields"])
    frame = next(each for each in fields if each["name"] == "frame")
    assert (frame["label"], [each["title"] for each in frame["items"]][:2]) == ("fixed to", ["world", "camera"])
    (brightness,) = page.all("intensity", page.row("point"))
    assert "brightness, × white" in brightness.text
