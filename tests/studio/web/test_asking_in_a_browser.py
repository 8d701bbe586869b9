"""*Ask* in a real Chromium: a spot of the model is dragged brighter or darker, and the chosen lights follow."""

import base64

import numpy as np
import pytest
import pyvista as pv
from browsers import needs_a_browser

pytestmark = needs_a_browser

_LIT = """
return fetch('take/vtp').then((answer) => answer.arrayBuffer()).then((found) =>
  btoa(Array.from(new Uint8Array(found), (byte) => String.fromCharCode(byte)).join('')))
"""


def lit(page, folder):
    """Download the lit mesh."""
    path = folder / "lit.vtp"
    path.write_bytes(base64.b64decode(page.driver.execute_script(_LIT)))
    return pv.read(path)


def spot(mesh):
    """Return the mean of the colours in the middle of the view, on the ball from the front."""
    away = np.linalg.norm(mesh.points - (0.0, -0.5, 0.0), axis=1)
    return mesh["phong"][away < 0.08].mean()


def brightness(page):
    return {light["called"]: light["intensity"]["value"] for light in page.state("lights")}


@pytest.fixture
def asking(page):
    """The page from the front, with *Ask* switched on by its button."""
    page.trigger("look", "front")
    page.trigger("select", None)
    page.click("ask")
    page.until(lambda: page.state("ask")["on"] and page.all("ask-hint"))
    page.until(lambda: "studio-aiming" in page.all("view")[0].get_attribute("class"))
    yield page
    if page.state("ask")["on"]:
        page.click("ask")
        page.until(lambda: not page.state("ask")["on"])


def test_a_drag_brightens_the_spot_and_undo_restores_all(asking, folder):
    for light in asking.state("lights"):
        asking.trigger("edit", light["intensity"]["key"], 0.3 * light["intensity"]["value"])
    asking.until(lambda: brightness(asking)["rim"] < 0.5 and lit(asking, folder)["phong"].max() < 0.7)
    before, lights = lit(asking, folder), brightness(asking)
    asking.drag((0, -60))
    asking.until(lambda: brightness(asking) != lights)
    asking.driver.save_screenshot(str(folder / "asked.png"))
    after = lit(asking, folder)
    assert 1.4 * spot(before) < spot(after) < 2.1 * spot(before)  # one stop was asked for
    asking.click("undo")
    asking.until(lambda: brightness(asking) == lights)
    np.testing.assert_array_equal(lit(asking, folder)["phong"], before["phong"])


def test_checked_lights_alone_follow_and_escape_cancels(asking):
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.keys import Keys

    lights = brightness(asking)
    assert [light["follows"] for light in asking.state("ask")["lights"]] == [True] * len(lights)
    for box in asking.all("ask-light")[1:]:
        asking.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", box)
        box.click()
    asking.until(lambda: sum(light["follows"] for light in asking.state("ask")["lights"]) == 1)
    asking.type("ask-spot", "25")
    asking.until(lambda: asking.state("ask")["spot"] == 25)
    asking.drag((0, 60), release=False)
    asking.until(lambda: brightness(asking) != lights)
    now = brightness(asking)
    (key,) = (name for name in lights if now[name] != lights[name])
    assert key == "key"
    assert now[key] < lights[key]
    ActionChains(asking.driver).send_keys(Keys.ESCAPE).perform()
    asking.until(lambda: brightness(asking) == lights)
    ActionChains(asking.driver).release().perform()
    assert not asking.state("can_undo")
    asking.type("ask-spot", "0")
    asking.until(lambda: "spot" in asking.all("notice")[0].text.lower() and asking.state("ask")["spot"] == 25)


def test_without_a_light_the_page_says_why_nothing_follows(asking):
    for light in asking.state("lights"):
        asking.trigger("edit", light["on"]["key"], False)
    asking.until(lambda: "switch one on" in asking.all("ask-none")[0].text)


def test_the_probe_and_asking_end_each_other(asking):
    asking.trigger("probe", True)
    asking.until(lambda: asking.state("probe")["on"] and not asking.state("ask")["on"])
    asking.click("ask")
    asking.until(lambda: asking.state("ask")["on"] and not asking.state("probe")["on"])
