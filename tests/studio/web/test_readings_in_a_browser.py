"""Histogram, probe and snapshots in a real Chromium."""

import pytest
from browsers import needs_a_browser

pytestmark = needs_a_browser


def test_the_histogram_follows_the_exposure(page):
    def said():
        return page.all("histogram")[0].text.split("\n")

    page.until(lambda: page.state("histogram")["path"])
    before = page.settled(lambda: page.state("histogram"))
    page.type("exposure", "3")
    page.until(lambda: page.state("histogram")["path"] != before["path"])
    page.until(lambda: said()[2].endswith("% clipped"))
    assert float(said()[2].split()[0]) > 20
    page.type("exposure", "-10")
    page.until(lambda: float(said()[0].split()[0]) > 20)  # black
    page.click("undo")
    page.click("undo")
    page.until(lambda: page.state("histogram") == before)
    page.driver.save_screenshot("/tmp/histogram.png")
    shown = page.all("histogram")[0].find_element("css selector", "svg")
    assert shown.get_attribute("aria-label").startswith("Histogram of luminance: ")
    assert shown.rect["height"] == pytest.approx(72)


def point_at(page, right, up, *, click=False):
    """Move the pointer to a place in the view, in pixels from its centre, in two steps; press and release there."""
    from selenium.webdriver.common.actions.action_builder import ActionBuilder

    view = page.all("view")[0].rect
    actions = ActionBuilder(page.driver, duration=30)
    mouse = actions.pointer_action
    at = round(view["x"] + view["width"] / 2 + right), round(view["y"] + view["height"] / 2 - up)
    mouse.move_to_location(at[0] + 2, at[1])
    mouse.pause(0.2)
    mouse.move_to_location(*at)
    mouse.pause(0.2)
    if click:
        mouse.pointer_down()
        mouse.pause(0.1)
        mouse.pointer_up()
    actions.perform()


def test_the_probe_reads_under_the_cursor_and_pins_follow_edits(page):
    page.click("probe")
    page.until(lambda: page.state("probe")["on"])
    point_at(page, -30, -40)
    under = page.until(lambda: page.state("probe")["under"])
    assert [bar["name"] for bar in under["bars"]] == ["ambient", "key", "fill", "rim"]
    assert sum(int(bar["share"].removesuffix("%")) for bar in under["bars"]) == pytest.approx(100, abs=2)
    point_at(page, -30, -40, click=True)
    (pin,) = page.until(lambda: page.state("probe")["pins"])
    assert pin["title"] == under["title"]
    point_at(page, -200, 200)
    page.until(lambda: page.state("probe")["under"] is None and page.all("probe-hint"))

    def key():
        return float(next(bar for bar in page.state("probe")["pins"][0]["bars"] if bar["name"] == "key")["value"])

    before = key()
    page.type("intensity", "0.5", page.row("key"))
    page.until(lambda: key() == pytest.approx(before / 2, rel=0.02))
    page.driver.execute_script("arguments[0].scrollIntoView()", page.all("probe")[0])
    point_at(page, 10, 60)
    page.until(lambda: page.all("probe-reading"))
    page.driver.save_screenshot("/tmp/probe.png")
    assert len(page.all("probe-bar", page.all("probe-pin")[0])) == 4
    page.driver.refresh()
    page.until(lambda: page.all("probe-pin") and page.picture().std() > 5)
    page.settled(lambda: page.all("unpin")[0].rect)
    page.click("unpin")
    page.until(lambda: not page.state("probe")["pins"])
    page.click("probe")
    page.until(lambda: not page.state("probe")["on"])


def test_snapshots_are_compared_by_a_wipe_and_restored_as_one_step(page):
    def intensity():
        return page.light("key")["intensity"]["value"]

    def is_loaded():
        script = "return [...document.querySelectorAll('.studio-compare img')].every((each) => each.naturalWidth > 0)"
        return page.driver.execute_script(script)

    page.trigger("gizmos")
    page.click("snapshot")
    page.until(lambda: page.state("snapshots")["pairs"] == ["A | now"])
    bright = page.settled(lambda: page.middle().tolist())
    page.type("intensity", "0", page.row("key"))
    page.type("light-name", "sun", page.row("key"))
    page.until(lambda: page.light("sun"))
    page.type("exposure", "-1")
    page.until(lambda: page.state("display")["exposure"]["value"] == -1)
    dark = page.until(lambda: (middle := page.middle())[0] < bright[0] - 60 and middle.tolist())
    page.click("snapshot")
    page.until(lambda: page.state("snapshots")["pairs"][0] == "A | B")
    page.click("compare")
    page.until(lambda: page.all("comparison") and is_loaded())
    for wipe, expected in ((100, bright), (0, dark)):
        page.driver.execute_script("window.trame.state.set('wipe', arguments[0])", wipe)
        page.until(lambda expected=expected: page.middle() == pytest.approx(expected, abs=8))
    page.driver.execute_script("window.trame.state.set('wipe', 50)")
    page.driver.execute_script("arguments[0].scrollIntoView()", page.all("snapshot")[0])
    page.settled(lambda: page.picture().tolist())
    page.driver.save_screenshot("/tmp/compare.png")
    picture = page.picture()
    middle, width = picture.shape[0] // 2, picture.shape[1]
    left, right = (picture[middle, int(part * width)].mean() for part in (0.42, 0.56))
    assert left > right + 40
    page.click("compare")
    page.until(lambda: not page.all("comparison"))

    page.click("snapshot-restore", page.all("snapshot-row")[0])
    page.until(lambda: page.light("key") and intensity() == 1.0 and page.state("display")["exposure"]["value"] == 0)
    page.until(lambda: page.middle() == pytest.approx(bright, abs=8))
    page.click("undo")
    page.until(lambda: page.light("sun") and page.state("display")["exposure"]["value"] == -1)
    page.click("redo")
    page.until(lambda: page.light("key"))
    page.trigger("gizmos")
    for _ in "AB":
        page.click("forget", page.all("snapshot-row")[0])
        page.settled(lambda: len(page.all("snapshot-row")))
    page.until(lambda: not page.state("snapshots")["pairs"])
