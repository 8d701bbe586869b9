"""A studio's page in a browser: its server, its elements, and what a user does with them."""

import subprocess
import sys
import time
from contextlib import suppress
from io import BytesIO

import numpy as np


class Served:
    """`pvphong studio` in a separate process, and its address."""

    def __init__(self, *words):
        command = [sys.executable, "-m", "pvphong", "studio", *map(str, words), "--no-browser"]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.address = self._process.stdout.readline().strip()
        assert self.address.startswith("http://"), self._process.communicate()

    def close(self):
        self._process.terminate()
        _, complaints = self._process.communicate(timeout=20)
        assert complaints == ""


class Page:
    """A studio in a browser, or in a frame of another page."""

    def __init__(self, driver, address, *, in_frame=False, is_unfolded=True, is_new=False):
        self.driver = driver
        self.resize(900, 600)
        if not is_new:
            seen = "try { localStorage.setItem('pvphong studio welcome', '1') } catch { }"
            driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": seen})
        driver.get(address)
        if in_frame:
            driver.switch_to.frame(0)
        self.until(lambda: self.all("light-row") and self.picture().std() > 5)
        self.until(lambda: driver.execute_script("return document.fonts.status") == "loaded")
        if in_frame:  # its storage is another one
            self.until(lambda: self.all("welcome-skip")[0].click() is None)
            self.until(lambda: not self.all("welcome"))
        if is_unfolded:
            self.unfold()
        self.settled(lambda: [each.rect for each in self.all("light-row")])  # else clicks miss rows that still move

    def unfold(self):
        """Open all panels, also those that are folded at first."""
        self.driver.execute_script("window.trame.state.set('open_panels', [...Array(20).keys()])")

    def resize(self, width, height):
        """Set the size of the window's inside, in pixels."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)

    def all(self, name, inside=None):
        """Return elements by their `data-test`."""
        return (inside or self.driver).find_elements("css selector", f'[data-test="{name}"]')

    def row(self, called):
        """Return the row of a light."""
        return next(row for row in self.all("light-row") if row.get_attribute("aria-label") == f"Light {called}")

    def click(self, name, inside=None):
        self.all(name, inside)[0].click()

    def download(self, what, path):
        """Click on a download, and wait for its file. Where the panel moved under the click, click again."""
        how = {"behavior": "allow", "downloadPath": str(path.parent)}
        self.driver.execute_cdp_cmd("Browser.setDownloadBehavior", how)
        for _ in range(4):
            self.click(f"download-{what}")
            with suppress(AssertionError):
                return self.until(path.exists, seconds=20.0)
        raise AssertionError(f"{path.name} was not downloaded")

    def input(self, name, inside=None):
        return self.all(name, inside)[0].find_element("css selector", "input")

    def typed(self, name, inside=None):
        """Return the text of a field."""
        return self.input(name, inside).get_property("value")

    def type(self, name, text, inside=None):
        """Replace the text of a field, and press Enter."""
        from selenium.webdriver.common.keys import Keys

        field = self.input(name, inside)
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(text, Keys.ENTER)

    def state(self, name):
        """Return a value of the page's state."""
        return self.driver.execute_script("return window.trame.state.get(arguments[0])", name)

    def light(self, called):
        return next((light for light in self.state("lights") if light["called"] == called), None)

    def trigger(self, name, *args):
        self.driver.execute_script("window.trame.trigger(arguments[0], arguments[1])", name, list(args))

    def until(self, is_so, seconds=60.0):
        """Wait until a condition is true, and return its value."""
        end = time.monotonic() + seconds
        while True:
            try:
                if found := is_so():
                    return found
            except Exception:  # the element is being replaced
                if time.monotonic() > end:
                    raise
            assert time.monotonic() < end, "it did not come"
            time.sleep(0.05)

    def settled(self, of):
        """Return a value after it has not changed for a while."""
        last, now = None, of()
        while last != now:
            time.sleep(0.5)
            last, now = now, of()
        return now

    def middle(self):
        """Return the colour at the centre of the view."""
        picture = self.picture()
        height, width, _ = picture.shape
        return picture[height // 2 - 20 : height // 2 + 20, width // 2 - 20 : width // 2 + 20].mean(axis=(0, 1))

    def picture(self):
        """Return the picture of the view, (h, w, 3)."""
        from PIL import Image

        shown = self.all("view")[0].screenshot_as_png
        return np.asarray(Image.open(BytesIO(shown)).convert("RGB")).astype(int)

    def drag(self, by, *, release=True):
        """Press at the centre of the view, move in steps, and release."""
        from selenium.webdriver.common.actions.action_builder import ActionBuilder

        view = self.all("view")[0].rect
        actions = ActionBuilder(self.driver, duration=40)
        mouse = actions.pointer_action
        at = round(view["x"] + view["width"] / 2), round(view["y"] + view["height"] / 2)
        mouse.move_to_location(*at)
        mouse.pause(0.3)
        mouse.pointer_down()
        for part in (0.2, 0.4, 0.6, 0.8, 1.0, 1.0):
            mouse.move_to_location(round(at[0] + part * by[0]), round(at[1] + part * by[1]))
            mouse.pause(0.08)
        if release:
            mouse.pointer_up()
        actions.perform()
        return actions


def bring(page, what, path):
    page.all(f"upload-{what}")[0].find_element("css selector", "input[type=file]").send_keys(str(path))


def switch(page, name, inside=None):
    page.all(name, inside)[0].find_element("css selector", "input").click()
