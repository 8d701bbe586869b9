"""Several browsers of different sizes and resolutions on one studio."""

import numpy as np
import pytest
from browsers import needs_a_browser
from pages import Page

pytestmark = needs_a_browser

SIZES = {"desktop": (1100, 700), "laptop": (900, 600), "phone": (390, 760)}


@pytest.fixture
def pages(page, served):
    """A page in each of three windows of different sizes: name → page and its window."""
    first = page.driver.current_window_handle
    found = {}
    for name, size in SIZES.items():
        page.driver.switch_to.new_window("window")
        found[name] = Page(page.driver, served.address), page.driver.current_window_handle
        found[name][0].resize(*size)
        found[name][0].until(lambda size=size: page.driver.execute_script("return innerWidth") == size[0])
    yield found
    for _, window in found.values():
        page.driver.switch_to.window(window)
        page.driver.close()
    page.driver.switch_to.window(first)


def drawn(page):
    """Return size and fit of the view's picture, and the size of the element that shows it."""
    return page.driver.execute_script("""
        const image = document.querySelector('.studio-view img'), box = image.getBoundingClientRect();
        return [[image.naturalWidth, image.naturalHeight], [box.width, box.height], getComputedStyle(image).objectFit];
    """)


def extent(found):
    """Return left, lower, right and upper end of the True entries of a picture."""
    rows, columns = np.nonzero(found)
    return columns.min(), rows.min(), columns.max() + 1, rows.max() + 1


def test_three_browsers_show_the_whole_picture_and_end_with_the_same_state(pages, page):
    def use(name):
        own, window = pages[name]
        page.driver.switch_to.window(window)
        return own

    use("phone").click("drawer")
    for number in range(10):
        own = use(list(pages)[number % 3])
        own.trigger("edit", own.light("key")["intensity"]["key"], 0.5 + number / 10)
        own.until(lambda own=own, number=number: own.light("key")["intensity"]["value"] == 0.5 + number / 10)
        if number % 3 == 2:
            own.drag((9, 4))  # turns the camera, in a view of another shape
    use("desktop").trigger("gizmos")
    states, sizes = [], []
    for name in pages:
        own = use(name)
        own.until(lambda own=own: own.light("key")["intensity"]["value"] == pytest.approx(1.4))
        own.settled(lambda own=own: own.picture().tolist())
        states.append([own.state(part) for part in ("lights", "model", "materials", "display", "can_undo")])
        view, picture = own.all("view")[0].rect, own.picture()
        size, box, fit = drawn(own)
        sizes.append(size)
        assert fit == "contain"
        assert box == pytest.approx([view["width"], view["height"]], abs=2)
        is_ball = picture.min(axis=2) > 70
        is_ball[2 * len(picture) // 3 :, 2 * picture.shape[1] // 3 :] = False  # the hint
        left, low, right, high = extent(is_ball)
        assert (right - left) / (high - low) == pytest.approx(1.0, abs=0.15)
        assert min(left, low, picture.shape[1] - right, picture.shape[0] - high) > 20
    use("desktop").trigger("gizmos")
    assert states[0] == states[1] == states[2]
    largest = use("desktop").all("view")[0].rect
    assert sizes == [pytest.approx([largest["width"], largest["height"]], abs=2)] * 3


def test_gizmos_and_texts_are_as_large_at_scale_two(page):
    def load(scale):
        metrics = {"width": 900, "height": 600, "deviceScaleFactor": scale, "mobile": False}
        page.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        page.driver.refresh()
        page.until(lambda: page.all("light-row") and page.picture().std() > 5)

    def measured(scale):
        """Return width and height of the text in the lower right corner, and the icons' area, in CSS pixels."""
        load(scale)
        wanted = [round(scale * page.all("view")[0].rect[side]) for side in ("width", "height")]
        page.until(lambda: drawn(page)[0] == pytest.approx(wanted, abs=2))
        page.settled(lambda: page.picture().tolist())
        picture = page.picture()
        assert picture.shape[1] == pytest.approx(wanted[0], abs=2)
        white = picture.min(axis=2) > 200
        corner = white.copy()
        corner[: -30 * scale] = corner[:, : -70 * scale] = False
        left, low, right, high = extent(corner)
        icons = white & ~corner & (np.arange(white.shape[0]) < white.shape[0] // 3)[:, None]
        return (right - left) / scale, (high - low) / scale, icons.sum() / scale**2

    try:
        once, twice = measured(1), measured(2)
    finally:
        load(1)
    assert twice[:2] == pytest.approx(once[:2], abs=2.5)
    assert twice[2] == pytest.approx(once[2], rel=0.25)
