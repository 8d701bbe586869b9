"""A plotter in a web page with server-side rendering, for tests that move the mouse in a browser.

Run as a program it serves the page and answers commands, one a line, with one line of JSON each. The module also
has the test's side.
"""

import json
import sys
import time
from functools import partial
from io import BytesIO

import numpy as np
from windowed import SIZE, Program, end_at_errors, furnish, told

ESCAPE = "\ue00c"
"""WebDriver's name of the key."""


class Server(Program):
    """Start the program; yield it and the address of its page."""

    def __init__(self, view):
        super().__init__(__file__, view)
        self.address = self.answer()


class Page:
    """The page in a browser: sends mouse events and reads pictures."""

    def __init__(self, server, browser):
        self.ask, self.wait = server.ask, server.wait
        self._browser = browser
        browser.set_window_rect(width=SIZE[0], height=SIZE[1])
        browser.get(server.address)
        for _ in range(2):  # what the window's frame takes is known only afterwards
            inside, outside = browser.execute_script("return [[innerWidth, innerHeight], [outerWidth, outerHeight]]")
            width, height = np.add(outside, SIZE) - inside
            browser.set_window_rect(width=int(width), height=int(height))
        self.wait(lambda state: state["size"] == list(SIZE))
        self.picture(lambda shown: shown[-1, -1].max() < 128)  # the plotter's background, no longer the empty page

    def _mouse(self, act):
        from selenium.webdriver.common.actions.action_builder import ActionBuilder

        actions = ActionBuilder(self._browser, duration=20)
        act(actions.pointer_action)
        actions.perform()

    def point(self, pixel):
        """Move the pointer to a pixel, counted from below as in VTK."""
        x, y = round(pixel[0]), SIZE[1] - round(pixel[1])
        self._mouse(lambda mouse: mouse.move_to_location(x, y))

    def press(self, pixel):
        """Press the button at a pixel."""
        self.point(pixel)
        self._mouse(lambda mouse: mouse.pointer_down())

    def click(self, pixel):
        """Press and release the button at a pixel."""
        self.press(pixel)
        self._mouse(lambda mouse: mouse.pointer_up())
        self.settled()

    def drag(self, start, by):
        """Press and move in steps, without releasing. Return the plotter's state before `drop`."""
        self.press(start)
        self.wait(lambda state: state["dragging"])
        for part in (0.25, 0.5, 0.75, 1.0):
            end = [round(s) + part * b for s, b in zip(start, by, strict=True)]
            self.point(end)
            time.sleep(0.1)
        for _ in range(20):  # trame leaves out moves that come faster than 30 a second, the last one too
            if self._is_at(end):
                return self.settled()
            for pixel in ((end[0] + 1, end[1]), end):
                self.point(pixel)
                time.sleep(0.2)
        raise AssertionError("the pointer did not arrive")

    def _is_at(self, pixel):
        """Return True if the plotter's pointer is at a pixel. The plotter may draw fewer pixels than the page has."""
        state = self.ask()
        scaled = [at * shown / size for at, shown, size in zip(state["cursor"], SIZE, state["size"], strict=True)]
        return max(abs(at - wanted) for at, wanted in zip(scaled, pixel, strict=True)) < 2

    def drop(self):
        """Release the button."""
        self._mouse(lambda mouse: mouse.pointer_up())
        self.wait(lambda state: not state["dragging"])
        return self.settled()

    def key(self, key):
        """Press and release a key."""
        from selenium.webdriver.common.action_chains import ActionChains

        ActionChains(self._browser).send_keys(key).perform()

    def settled(self):
        """Return the plotter's state after it has handled all events."""
        last = None
        while (state := self.ask()) != last:
            last = state
            time.sleep(0.2)
        return state

    def picture(self, until=None):
        """Wait for a condition; return the browser's picture, shape (height, width, 3)."""
        from PIL import Image

        for _ in range(100):
            shown = np.asarray(Image.open(BytesIO(self._browser.get_screenshot_as_png())).convert("RGB")).astype(int)
            if until is None or until(shown):
                return shown
            time.sleep(0.05)
        raise AssertionError("the browser did not show it")

    def still(self):
        """Return the browser's picture once it no longer changes: a fine picture follows a coarse one."""
        shown = self.picture()
        while True:
            time.sleep(0.4)
            last, shown = shown, self.picture()
            if (last == shown).all():
                return shown


def main(view):
    """The plotter's side."""
    import asyncio

    import pyvista as pv
    from trame.app import get_server
    from trame.ui.vuetify3 import VAppLayout
    from trame.widgets import html

    end_at_errors()
    pv.global_theme.multi_samples = 1  # eight take a processor four times as long
    plotter = pv.Plotter(off_screen=True, window_size=SIZE, lighting="none")
    actor, guest = furnish(plotter)
    server = get_server("served", client_type="vue3")
    with VAppLayout(server), html.Div(style="position: fixed; inset: 0"):
        VIEWS[view](plotter, server)

    def answer():
        line = sys.stdin.readline()
        if not line:
            asyncio.get_running_loop().remove_reader(sys.stdin)
            ending.append(asyncio.ensure_future(server.stop()))
            return
        command, *words = line.split()
        if command == "export":
            plotter.trame.export_html(f"{words[0]}/ball.html")
            plotter.trame.export_vtksz(f"{words[0]}/ball.vtksz")
        print(json.dumps(told(plotter, actor, guest)), flush=True)

    def ready(**_):
        asyncio.get_running_loop().add_reader(sys.stdin, answer)
        print(json.dumps(f"http://127.0.0.1:{server.port}/index.html"), flush=True)

    ending = []  # asyncio itself does not hold on to what it runs
    pv.global_theme.trame.jupyter_server_name = server.name  # else an export starts a server of its own
    server.controller.on_server_ready.add(ready)
    server.start(host="127.0.0.1", port=0, open_browser=False, show_connection_info=False, timeout=0)
    plotter.close()


def _remote(plotter, server, **options):
    """The view of `plotter.show(jupyter_backend="server")`. By default it sends neither keys nor pointer moves."""
    from trame_pyvista.ui import plotter_ui

    def pass_on(key):
        interactor = plotter.iren.interactor
        interactor.SetKeySym(key)
        interactor.KeyPressEvent()
        interactor.KeyReleaseEvent()

    keys = {"interactor_events": ("events", ["KeyDown"]), "KeyDown": (pass_on, "[$event.key]")}
    plotter_ui(plotter, mode="server", server=server, add_menu=False, **keys, **options)


def _area(plotter, server):  # noqa: ARG001 the layout that it is made in knows the server
    """The view of `plotter.trame.app()` with remote rendering."""
    from trame_pyvista.widgets import PyVistaRCAView

    PyVistaRCAView(plotter, send_mouse_move=True)


VIEWS = {"remote": _remote, "coarse": partial(_remote, interactive_ratio=0.5), "area": _area}
"""PyVista's views with server-side rendering; a coarse one has fewer pixels while a button is down."""

if __name__ == "__main__":
    main(sys.argv[1])
