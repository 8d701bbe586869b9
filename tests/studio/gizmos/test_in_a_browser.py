"""Gizmos in a web page: trame sends pictures to the browser, and receives its mouse and key events."""

import numpy as np
import pytest
from browsers import needs_a_browser
from served import ESCAPE, SIZE, VIEWS, Page, Server
from windowed import essence

pytestmark = needs_a_browser
LAMP, SPOT = 0, 1


@pytest.fixture(scope="module", params=VIEWS)
def opened(request, driver):
    server = Server(request.param)
    yield Page(server, driver)
    driver.get("about:blank")
    assert server.close() == 0


@pytest.fixture
def page(opened):
    """The page with its initial lights, the pointer away from them, and the keyboard focus set by a click."""
    opened.click((3, 3))
    return opened


only_area = pytest.mark.parametrize("opened", ["area"], indirect=True)


def around(picture, pixel, reach=12):
    """Return a square around a pixel, with y upwards."""
    x, y = round(pixel[0]), SIZE[1] - round(pixel[1])
    return picture[y - reach : y + reach, x - reach : x + reach]


def test_dragging_moves_the_light_and_a_key_undoes_it(page):
    page.click(page.settled()["handles"][LAMP]["position"])  # a selected light has more lines
    before, shown = page.settled(), page.still()

    def differs(now):
        """Return the ball's change in levels of 255, without the tenth that changed most, where gizmos cover it."""
        parts = (around(picture, before["ball"], 50) for picture in (now, shown))
        return np.percentile(np.abs(np.subtract(*parts)).max(axis=2), 90)

    page.drag(before["handles"][LAMP]["position"], (-60, 20))
    page.picture(lambda now: differs(now) > 15)
    held = page.settled()  # after the last moves have come
    after = page.drop()
    assert held["lights"] == after["lights"]
    assert [a == b for a, b in zip(after["lights"], before["lights"], strict=True)] == [False, True, True]
    assert after["colors"] != before["colors"]
    assert after["camera"] == before["camera"]
    moved = np.subtract(after["handles"][LAMP]["position"], before["handles"][LAMP]["position"])
    np.testing.assert_allclose(moved, (-60, 20), atol=2.6)
    page.picture(lambda now: differs(now) > 15)
    page.key("z")
    page.wait(lambda state: essence(state) == essence(before))
    page.picture(lambda now: differs(now) <= 3)


@pytest.mark.parametrize("opened", ["remote", "area"], indirect=True)
def test_escape_puts_back(page):
    before = page.settled()
    held = page.drag(before["handles"][SPOT]["cone"], (-12, -7))
    assert held["cones"][SPOT] != before["cones"][SPOT]
    page.key(ESCAPE)
    page.wait(lambda state: essence(state) == essence(before))
    assert essence(page.drop()) == essence(before)


@only_area
def test_hovering_shows(page):
    state, away = page.settled(), page.still()
    target = state["handles"][SPOT]["target"]
    page.point(target)
    page.wait(lambda state: state["hovered"] == "target")
    page.picture(lambda now: (around(now, target) != around(away, target)).mean() > 0.2)
    page.point((3, 3))
    page.wait(lambda state: state["hovered"] is None)
    page.picture(lambda now: np.array_equal(around(now, target), around(away, target)))


@only_area
def test_a_key_counts_once(page):
    """Browsers report a letter twice, as `keydown` and `keypress`."""
    before = page.still()
    corner = np.s_[:120, :120]
    page.key("h")
    page.picture(lambda now: (now[corner] != before[corner]).mean() > 0.5)
    page.key("h")
    page.picture(lambda now: np.array_equal(now[corner], before[corner]))


@pytest.mark.parametrize("opened", ["remote", "area"], indirect=True)
def test_a_spot_is_dragged_brighter(page):
    """The space bar lets a drag on a mesh ask for light."""
    before = page.settled()
    x, y = before["ball"]
    page.key(" ")
    page.press((x, y))
    for step in (15, 30, 45, 60):
        page.point((x, y + step))
    page.wait(lambda state: state["lights"] != before["lights"])
    after = page.drop()
    assert after["camera"] == before["camera"]
    assert after["colors"] != before["colors"]
    page.key("z")
    page.wait(lambda state: essence(state) == essence(before))
    page.key(" ")
