"""Sliders, and messages with buttons, in the page."""

import pytest
from browsers import needs_a_browser

pytestmark = needs_a_browser


def thumb_of(page, name):
    return page.all("intensity", page.row(name))[0].find_element("css selector", "[role=slider]")


def intensity(page, name="key"):
    return page.light(name)["intensity"]["value"]


def slid(page, by, *, shift=False):
    """Drag the slider of the key light, and return its intensity."""
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.keys import Keys

    before, moves = intensity(page), ActionChains(page.driver, duration=20)
    moves = moves.key_down(Keys.SHIFT) if shift else moves
    moves = moves.click_and_hold(thumb_of(page, "key"))
    for _ in range(7):
        moves = moves.move_by_offset(by // 7, 0)
    moves = moves.release()
    (moves.key_up(Keys.SHIFT) if shift else moves).perform()
    page.until(lambda: intensity(page) != before and page.state("local") == {})
    return intensity(page)


def test_a_slider_spans_four_stops_to_either_side_of_its_value(page):
    for value in (1.0, 40.0):
        page.type("intensity", str(value), page.row("key"))
        page.until(lambda value=value: intensity(page) == value)
        entry = page.light("key")["intensity"]
        assert 2.0 ** entry["from"] == pytest.approx(value / 16)
        assert 2.0 ** entry["to"] == pytest.approx(value * 16)
        assert entry["slide"] == pytest.approx((entry["from"] + entry["to"]) / 2)
    assert 1.2 < slid(page, 14) / 40.0 < 1.7
    page.click("undo")
    page.until(lambda: intensity(page) == 40.0)


def test_a_slider_is_fine_with_shift(page):
    assert 1.0 < slid(page, 35, shift=True) < 1.2
    page.click("undo")
    page.until(lambda: intensity(page) == 1.0)
    assert slid(page, 35) > 1.8


def test_a_double_click_on_a_slider_sets_the_default(page):
    from selenium.webdriver.common.action_chains import ActionChains

    page.type("intensity", "0.2", page.row("key"))
    page.until(lambda: intensity(page) == 0.2)
    ActionChains(page.driver).double_click(thumb_of(page, "key")).perform()
    page.until(lambda: intensity(page) == 1.0)
    assert page.typed("intensity", page.row("key")) == "1"


def test_a_message_has_a_button_that_does_what_it_proposes(page):
    page.type("intensity", "2,000", page.row("key"))
    page.until(lambda: "“2,000” is ambiguous" in page.all("notice")[0].text)
    page.until(lambda: [each.text for each in page.all("remedy")] == ["Use 2000", "Use 2"])
    first, second = page.all("remedy")
    page.settled(lambda: first.rect)
    second.click()
    page.until(lambda: intensity(page) == 2.0)
    page.until(lambda: not page.all("remedy") and page.state("notice") == "")
    page.trigger("edit", "model.bounces", 1)
    page.until(lambda: next(each for each in page.state("model") if each["name"] == "bounces")["value"] == 1)
    page.trigger("start_mix", True)
    (button,) = page.until(lambda: page.all("remedy"))
    page.until(lambda: button.text == "Set bounces to 0")
    page.settled(lambda: button.rect)
    button.click()
    page.until(lambda: page.state("mixing"))
