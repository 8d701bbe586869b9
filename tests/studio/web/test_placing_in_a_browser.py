"""Placing of lights, the words of the page, the welcome and the list of keys, in a real Chromium."""

import numpy as np
from browsers import needs_a_browser
from pages import Page

pytestmark = needs_a_browser


def field_of(page, name):
    css = f'[data-field="{name}"] input[inputmode=decimal]'
    (field,) = page.row("spot").find_elements("css selector", css)
    page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", field)
    return field


def value(page, form, name):
    return next(entry["value"] for entry in page.light("spot")[form] if entry["name"] == name)


def test_a_light_is_placed_by_angles_and_distance_about_its_target(page):
    page.click("add-spot")
    page.until(lambda: page.light("spot")["placing"])
    target = np.add(value(page, "fields", "position"), value(page, "fields", "direction"))
    for name, typed in (("azimuth", "90"), ("elevation", "0"), ("distance", "3")):
        field_of(page, name).send_keys("\ue009a\ue000", typed, "\ue007")
        page.until(lambda name=name, typed=typed: abs(value(page, "placing", name) - float(typed)) < 1e-9)
    np.testing.assert_allclose(value(page, "fields", "position"), target + np.array((3, 0, 0)), atol=1e-6)
    np.testing.assert_allclose(value(page, "fields", "direction"), (-3, 0, 0), atol=1e-6)
    for _ in range(3):
        page.click("undo")
    page.until(lambda: abs(value(page, "placing", "distance") - 3) > 0.1)


def test_the_highlight_is_put_where_the_view_is_clicked(page):
    from selenium.webdriver.common.action_chains import ActionChains

    page.trigger("choose_material", 0, "gold")
    page.click("add-spot")
    before = page.until(lambda: page.light("spot")["fields"])
    page.trigger("look", "front")
    (view,) = page.all("view")
    page.until(lambda: page.all("highlight-here"))
    page.click("highlight-here")
    page.until(lambda: "studio-aiming" in view.get_attribute("class"))
    ActionChains(page.driver).move_to_element_with_offset(view, 40, -30).pause(0.3).click().perform()
    page.until(lambda: page.light("spot")["fields"] != before)
    page.until(lambda: "studio-aiming" not in view.get_attribute("class"))
    position, direction = (np.array(value(page, "fields", name)) for name in ("position", "direction"))
    at = position + direction  # the light aims at the point of its highlight
    assert abs(np.linalg.norm(at) - 0.5) < 0.01  # on the ball
    assert at[0] > 0.05
    assert at[2] > 0.05
    page.click("undo")
    page.until(lambda: page.light("spot")["fields"] == before)
    page.click("shine-from-here")
    page.until(lambda: value(page, "fields", "position")[1] < -1)  # the camera is in front


def test_the_gizmo_under_the_cursor_lights_up_its_row_and_the_other_way_round(page, folder):
    from selenium.webdriver.common.action_chains import ActionChains

    page.click("add-point")
    page.until(lambda: page.light("point")["selected"])
    page.trigger("look", "front")
    (view,) = page.all("view")
    ActionChains(page.driver).move_to_element(page.all("undo")[0]).perform()
    before = np.array(page.settled(lambda: page.picture().tolist()))
    ActionChains(page.driver).move_to_element(page.row("fill")).perform()
    page.until(lambda: (np.abs(page.picture() - before).max(axis=2) > 60).sum() > 50)  # its name and arrows
    pointed = page.picture()
    page.driver.save_screenshot(str(folder / "pointed.png"))
    ActionChains(page.driver).move_to_element(page.all("undo")[0]).perform()
    page.until(lambda: (np.abs(page.picture() - pointed).max(axis=2) > 60).sum() > 50)
    assert not any(light["hovered"] for light in page.state("lights"))
    for index, coordinate in enumerate((0, -1, 0)):
        page.trigger("edit", f"light.{page.light('point')['number']}.position", coordinate, [index])
    page.settled(lambda: page.picture().tolist())
    ActionChains(page.driver).move_to_element_with_offset(view, 3, 0).move_to_element(view).perform()
    page.until(lambda: page.light("point")["hovered"])
    (row,) = page.driver.find_elements("css selector", ".studio-hovered")
    assert row.get_attribute("aria-label") == "Light point"


# --- words and help


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


def test_the_welcome_is_shown_once_in_a_browser_and_can_be_called_back(driver, served, folder):
    first = driver.current_window_handle
    driver.switch_to.new_window("tab")
    try:
        driver.get(served.address)
        driver.execute_script("localStorage.clear()")
        fresh = Page(driver, served.address, is_new=True)
        titles = []
        for _ in range(3):
            fresh.until(lambda: fresh.all("welcome")[0].is_displayed())
            titles.append(fresh.all("welcome")[0].text.split("\n")[0])
            fresh.settled(lambda: fresh.all("welcome-next")[0].rect)
            driver.save_screenshot(str(folder / f"welcome {len(titles)}.png"))
            fresh.click("welcome-next")
        assert titles == ["1. Look around", "2. Light it", "3. Take the picture"]
        fresh.until(lambda: not fresh.all("welcome"))
        driver.refresh()
        fresh.until(lambda: fresh.all("light-row"))
        fresh.settled(lambda: len(fresh.all("welcome")))
        assert not fresh.all("welcome")
        fresh.click("help")
        fresh.until(lambda: fresh.all("show-welcome")[0].click() is None)
        fresh.until(lambda: fresh.all("welcome")[0].is_displayed())
        fresh.settled(lambda: fresh.all("welcome-skip")[0].rect)
        fresh.click("welcome-skip")
        fresh.until(lambda: not fresh.all("welcome"))
    finally:
        driver.close()
        driver.switch_to.window(first)


def test_the_key_of_an_action_is_found_by_a_word(page, folder):
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.keys import Keys

    page.all("view")[0].find_element("css selector", "img, canvas, div").click()
    ActionChains(page.driver).send_keys("?").perform()
    page.until(lambda: len(page.all("key-row")) > 20)
    page.settled(lambda: page.all("search-keys")[0].rect)
    page.driver.save_screenshot(str(folder / "keys.png"))
    page.input("search-keys").send_keys("Duplicate")
    page.until(
        lambda: (
            [row.text.split() for row in page.all("key-row")]
            == [["D", "duplicate", "the", "light,", "in", "the", "view"]]
        )
    )
    page.input("search-keys").send_keys(Keys.CONTROL, "a")
    page.input("search-keys").send_keys("nothing", Keys.ESCAPE)
    page.until(lambda: not page.all("keys"))
