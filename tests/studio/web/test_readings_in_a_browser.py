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
