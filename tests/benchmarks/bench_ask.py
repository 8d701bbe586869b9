"""Updates of the picture in a second while a spot is dragged with *Ask*, in Chromium: `python bench_ask.py`."""

import sys
import tempfile
import time
from pathlib import Path

import psutil
import pyvista as pv
from common import CONSOLE, show

sys.path.append(str(Path(__file__).parents[1]))
from browsers import MISSING, new_browser
from pages import Page, Served

WANTED = 15.0
"""Updates in a second at 50,000 points."""

SECONDS = 4.0

_COUNT = """
window.asked = 0;
document.addEventListener('load', (event) => { if (event.target.closest?.('.studio-view')) window.asked += 1 }, true);
"""


def seconds_of(served):
    """Return the processor time of a studio, which runs in a child of the served process."""
    process = psutil.Process(served._process.pid)
    times = [each.cpu_times() for each in (process, *process.children(recursive=True))]
    return sum(each.user + each.system for each in times)


def drag(page, seconds):
    """Drag the middle of the view up and down, and release; return the number of pictures and the time it took."""
    from selenium.webdriver.common.actions.action_builder import ActionBuilder

    view = page.all("view")[0].rect
    x, y = round(view["x"] + view["width"] / 2), round(view["y"] + view["height"] / 2)
    press = ActionBuilder(page.driver, duration=0)
    press.pointer_action.move_to_location(x, y).pause(0.5).pointer_down().pause(0.5)
    press.perform()
    page.driver.execute_script("window.asked = 0")
    start = time.perf_counter()
    while time.perf_counter() - start < seconds:
        moves = ActionBuilder(page.driver, duration=0)
        for step in (*range(0, 60, 3), *range(60, 0, -3)):
            moves.pointer_action.move_to_location(x, y - step).pause(0.02)
        moves.perform()
    count = page.driver.execute_script("return window.asked")
    took = time.perf_counter() - start
    release = ActionBuilder(page.driver, duration=0)
    release.pointer_action.pointer_up()
    release.perform()
    return count, took


def main() -> int:
    """Print the table; return 1 if there are fewer updates than wanted."""
    if MISSING:
        CONSOLE.print(f"This needs {', '.join(MISSING)}.")
        return 1
    rows, ok = [], True
    with tempfile.TemporaryDirectory() as folder:
        browser = new_browser(f"{folder}/profile")
        for side in (100, 225):
            ball = pv.Sphere(theta_resolution=side, phi_resolution=side)
            ball.save(f"{folder}/ball.ply")
            served = Served(f"{folder}/ball.ply")
            try:
                page = Page(browser, served.address)
                page.driver.execute_script(_COUNT)
                page.trigger("look", "front")
                page.trigger("ask", True)
                page.until(lambda page=page: page.state("ask")["on"])
                drag(page, 1.0)  # compiled code is loaded
                page.settled(lambda page=page: [light["intensity"]["value"] for light in page.state("lights")])
                before = seconds_of(served)
                count, took = drag(page, SECONDS)
                used = seconds_of(served) - before
            finally:
                browser.get("about:blank")
                served.close()
            rate = count / took
            ok &= rate >= WANTED
            each = f"{1e3 * used / max(count, 1):.0f}"
            rows.append((f"{ball.n_points:,}", f"{count}", f"{rate:.1f}", f"{WANTED:g}", each))
        browser.quit()
    show("Ask with three lights, in a browser", ("points", "pictures", "per second", "wanted", "CPU ms each"), rows)
    if not ok:
        CONSOLE.print("[red]There are fewer updates than wanted.")
    return 0 if ok else 1


if __name__ == "__main__":
    sys.exit(main())
