"""One view for clients of different sizes."""

import pytest

pytest.importorskip("trame_pyvista", reason="the studio needs the extra trame")

from pvphong.studio.web.access import view_event
from pvphong.studio.web.sharing import SharedSize

DESKTOP, PHONE = {"w": 1000.0, "h": 500.0, "p": 1}, {"w": 400.0, "h": 800.0, "p": 3}


@pytest.fixture
def shared():
    shared = SharedSize()
    shared.put("desktop", DESKTOP)
    shared.put("phone", PHONE)
    return shared


def press(x, y, size, kind="LeftButtonPress"):
    return view_event({"type": kind, "x": x, "y": y, "w": size["w"], "h": size["h"]})


def test_the_largest_client_sets_the_size(shared):
    assert shared.size == DESKTOP
    shared.put("phone", PHONE | {"h": 1600.0})
    assert shared.size["h"] == 1600.0
    assert shared.remove("phone")
    assert shared.size == DESKTOP
    assert not shared.remove("nobody")
    assert shared.remove("desktop")
    assert shared.size is None


def test_positions_are_those_of_the_shared_view(shared):
    # The phone shows 400 × 200 of its pixels, 300 above its lower edge: 2.5 pixels of the shared view in each.
    at = shared.converted(press(100, 310, PHONE), "phone")
    assert (at["x"], at["y"], at["w"], at["h"]) == (250.0, 25.0, 1000.0, 500.0)
    assert shared.converted(press(0, 0, PHONE), "phone")["y"] == -750.0  # below the picture
    for same in ("desktop", "nobody"):
        assert shared.converted(press(1, 2, DESKTOP), same) == press(1, 2, DESKTOP)


def test_fingers_are_converted_and_idle_events_are_not(shared):
    pan = {"type": "Pan", "translation": [4, -2], "positions": {"1": {"x": 400, "y": 500}}, "x": 200, "y": 400}
    moved = shared.converted(view_event(pan), "phone")
    assert moved["translation"] == [10.0, -5.0]
    assert moved["positions"] == {"0": {"x": 1000.0, "y": 500.0}}
    assert (moved["x"], moved["y"]) == (500.0, 250.0)
    assert shared.converted({"type": "EndInteractionEvent"}, "phone") == {"type": "EndInteractionEvent"}
