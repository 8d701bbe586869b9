"""Gizmos in a real window, with the mouse moved from outside."""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
from windowed import Window, essence

MISSING = [program for program in ("Xvfb", "xdotool") if shutil.which(program) is None]
pytestmark = [
    pytest.mark.skipif(bool(MISSING), reason=f"a real window needs {' and '.join(MISSING)} (Debian: xvfb, xdotool)"),
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Xvfb is X's"),
]
LAMP, SPOT, GUEST = 0, 1, 2


@pytest.fixture(scope="module")
def opened():
    ready, tell = os.pipe()
    # VTK first opens a test connection. A server that resets after its only client has gone may then refuse the
    # window.
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(tell), "-screen", "0", "1024x768x24", "-nolisten", "tcp", "-noreset"],
        pass_fds=[tell],
        stderr=subprocess.DEVNULL,
    )
    os.close(tell)
    with os.fdopen(ready) as pipe:
        number = pipe.readline().strip()
    environment = {**os.environ, "DISPLAY": f":{number}", "PYVISTA_OFF_SCREEN": "false"}
    environment.pop("VTK_DEFAULT_OPENGL_WINDOW", None)
    window = Window(environment)
    yield window
    assert window.close() == 0
    server.terminate()
    server.wait(10)


@pytest.fixture
def window(opened):
    """The window with its initial lights."""
    opened.point((3, 3))
    opened.wait(lambda state: state["hovered"] is None)
    return opened


MOTIONS = {
    LAMP: {"position": (-60, 25), "radius": (30, 0)},
    SPOT: {"position": (20, 30), "target": (40, -15), "cone": (-9, -6)},
    GUEST: {"position": (35, 10), "target": (-25, 20), "cone": (14, 3)},
}


@pytest.mark.parametrize(("which", "handle"), [(which, handle) for which in MOTIONS for handle in MOTIONS[which]])
def test_dragging_moves_the_light_and_undo_restores_it_to_the_bit(window, which, handle):
    by = MOTIONS[which][handle]
    before = window.ask()
    held, after = window.drag(before["handles"][which][handle], by)
    assert after["lights"][which] != before["lights"][which]
    assert [a == b for a, b in zip(after["lights"], before["lights"], strict=True)].count(False) == 1
    assert after["colors"] != before["colors"]
    assert essence(held) == essence(after)
    assert after["camera"] == before["camera"]
    assert (after["guest"] != before["guest"]) == (which == GUEST)
    if handle in ("position", "target"):
        moved = np.array(after["handles"][which][handle]) - before["handles"][which][handle]
        np.testing.assert_allclose(moved, by, atol=1.6)
    assert essence(window.ask("undo")) == essence(before)
    assert essence(window.ask("redo")) == essence(after)
    assert essence(window.ask("undo")) == essence(before)


def test_modifiers_and_keys_of_a_real_keyboard(window):
    before = window.ask()
    _, after = window.drag(before["handles"][SPOT]["cone"], (-12, -7), modifier="ctrl")
    assert after["cones"][SPOT] % 5 == 0
    assert essence(window.ask("undo")) == essence(before)
    _, after = window.drag(before["handles"][LAMP]["position"], (-40, 2), modifier="shift")
    assert after["lights"][LAMP] != before["lights"][LAMP]
    window.do("key", "ctrl+z", until=lambda state: essence(state) == essence(before))
    window.point((20, 20))
    while not window.do("key", "n")["selected"][SPOT]:
        pass
    window.do("key", "m", until=lambda state: "on=False" in state["lights"][SPOT])
    window.do("key", "z", until=lambda state: essence(state) == essence(before))


def test_escape_during_a_drag(window):
    before = window.ask()
    start = before["handles"][LAMP]["position"]
    window.point(start)
    window.do("mousedown", "1")
    window.point(np.add(start, (30, 30)))
    window.wait(lambda state: state["colors"] != before["colors"])
    window.do("key", "Escape", until=lambda state: essence(state) == essence(before))
    window.point(np.add(start, (40, 30)))
    assert essence(window.do("mouseup", "1")) == essence(before)


def test_a_value_is_typed(window):
    typed = ("3", "1", "period", "5")
    before = window.ask()
    window.point(before["handles"][SPOT]["cone"])
    window.wait(lambda state: state["hovered"])
    window.do("mousedown", "1")
    window.do("mouseup", "1")
    window.do("key", "Return")
    window.do("key", *typed, until=lambda state: state["typing"] == "31.5")
    window.do("key", "Escape", until=lambda state: essence(state) == essence(before))
    window.do(
        "key", "Return", *typed, "Return", until=lambda state: (state["cones"][SPOT], state["typing"]) == (31.5, "")
    )
    window.do("key", "z", until=lambda state: essence(state) == essence(before))
