"""Layout and accessibility of the page: small windows, headings, alternative texts, and a console without errors."""

import numpy as np
import pytest
from browsers import needs_a_browser
from pages import Page

pytestmark = needs_a_browser


def background_at_edges(picture):
    """Return True if the columns at both sides of the view show only the background."""
    sides = np.concatenate([picture[:, :3], picture[:, -3:]], axis=1)
    return np.ptp(sides.astype(int), axis=1).max() < 12


def test_nothing_fails_while_the_page_loads(page):
    page.driver.get_log("browser")
    page.driver.refresh()
    page.until(lambda: page.all("light-row") and page.picture().std() > 5)
    failed = [each for each in page.driver.get_log("browser") if each["level"] == "SEVERE"]
    assert failed == []
    failed = "return performance.getEntriesByType('resource').filter((each) => each.responseStatus >= 400)"
    assert page.driver.execute_script(failed) == []


def test_the_picture_has_an_alternative_text_and_panels_have_headings(page):
    def image():
        return page.all("view")[0].find_element("css selector", "img")

    page.until(lambda: image().get_attribute("alt") == "ball: 530 points; lit by key, fill, rim")
    page.trigger("edit", page.light("fill")["on"]["key"], False)
    page.until(lambda: image().get_attribute("alt") == "ball: 530 points; lit by key, rim")
    found = [each.text.split("\n")[0] for each in page.driver.find_elements("css selector", "h2 button")]
    expected = "Lights", "Mix", "Material", "Scene", "Camera", "Picture", "Probe", "Compare", "Files", "Advanced"
    assert tuple(found) == expected
    (title,) = page.driver.find_elements("css selector", "h1")
    assert title.text == "ball: 530 points"


@pytest.mark.parametrize(("width", "height"), [(700, 900), (700, 480), (390, 844)])
def test_panels_never_cover_the_view_and_the_model_is_not_cropped(page, folder, width, height):
    def rect(name):
        return page.all(name)[0].rect

    def is_apart():
        view, panels = rect("view"), rect("panels")
        beside = view["x"] + view["width"] <= panels["x"] + 1
        return beside or view["y"] + view["height"] <= panels["y"] + 1

    try:
        page.resize(width, height)
        page.until(lambda: rect("view")["width"] == width)
        for is_open in (False, True):
            if is_open:
                page.click("drawer")
                page.until(is_apart)
            view = page.settled(lambda: (rect("view"), rect("panels")))[0]
            assert view["width"] >= 0.45 * width
            assert view["height"] >= 0.4 * height
            shown = page.until(lambda: page.settled(lambda: page.picture().tolist()))
            picture = np.array(shown)
            page.driver.save_screenshot(str(folder / f"{width}x{height}-{'open' if is_open else 'closed'}.png"))
            assert picture.std() > 5
            assert background_at_edges(picture[60:-20])
        page.click("drawer")
        page.until(lambda: rect("view")["width"] == width and rect("view")["height"] > 0.8 * height)
    finally:
        page.driver.execute_script("window.trame.state.set('drawer', null)")
        page.resize(900, 600)
        page.until(lambda: rect("view")["width"] == 500)


def test_advanced_is_folded_and_its_first_sentence_has_the_button_that_improves_the_picture(driver, served, page):
    first = page.driver.current_window_handle
    page.driver.switch_to.new_window("tab")
    try:
        fresh = Page(driver, served.address, is_unfolded=False)
        assert not fresh.all("exactness")[0].is_displayed()
        assert not fresh.all("plan-row")[0].is_displayed()
        fresh.click("go-advanced")
        bottom = fresh.all("panels")[0].rect
        fresh.until(lambda: fresh.all("improve")[0].rect["y"] < bottom["y"] + bottom["height"] - 40)
        fresh.until(lambda: "blended" in fresh.all("exactness")[0].text)
        assert fresh.all("improve")[0].text == "Refine between the points"
        fresh.settled(lambda: fresh.all("improve")[0].rect)
        fresh.click("improve")
        fresh.until(lambda: fresh.state("accuracy")["refine"]["set"])
        fresh.until(lambda: "at most one step of a screen between them" in fresh.all("exactness")[0].text)
        assert fresh.all("improve")[0].text == "Check it by a measurement"
        fresh.trigger("edit", fresh.light("fill")["intensity"]["key"], 0.001)
        fresh.trigger("edit", "accuracy.tolerance", 0.05)
        fresh.until(lambda: "Left out: fill (too weak to be seen" in fresh.all("exactness")[0].text)
        fresh.click("improve")
        fresh.until(lambda: fresh.all("exactness")[0].text.endswith("Nothing is left out."))
    finally:
        page.driver.close()
        page.driver.switch_to.window(first)
