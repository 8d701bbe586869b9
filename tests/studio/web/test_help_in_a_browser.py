"""The welcome and the sheet of keys, in a real Chromium."""

from browsers import needs_a_browser
from pages import Page

pytestmark = needs_a_browser


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
            == [["D", "in", "the", "view", "duplicate", "the", "light"]]
        )
    )
    page.input("search-keys").send_keys(Keys.CONTROL, "a")
    page.input("search-keys").send_keys("nothing", Keys.ESCAPE)
    page.until(lambda: not page.all("keys"))
