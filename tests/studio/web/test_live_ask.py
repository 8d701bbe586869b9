"""*Ask* of the page, without a browser: its spot, and the lights that follow."""

import pytest
import pyvista as pv

import pvphong as ph
from pvphong.studio.web.document import Document
from pvphong.studio.web.live_ask import LiveAsk


@pytest.fixture
def ask(new_plotter):
    plotter = new_plotter((200, 150))
    for name, on in (("key", True), ("fill", True), ("off", False)):
        plotter.phong.add_light(ph.DirectionalLight(direction=(0, 0, -1), name=name, on=on))
    plotter.phong.add_mesh(pv.Sphere(), "white plastic")
    plotter.phong.add_gizmos()
    return LiveAsk(Document(plotter.phong, plotter.phong._subplot, plotter.phong._history))


def follows(ask):
    return {light["called"]: light["follows"] for light in ask.shown()["lights"]}


def test_the_selected_light_follows_until_others_are_checked(ask):
    assert follows(ask) == {"key": True, "fill": True}
    ask._document.select(ask.shown()["lights"][1]["number"])
    ask.switch(True)
    assert ask.shown()["on"]
    assert follows(ask) == {"key": False, "fill": True}
    key, fill = (light["number"] for light in ask.shown()["lights"])
    ask.follow(key, True)
    assert follows(ask) == {"key": True, "fill": True}
    ask.follow(str(fill), False)
    assert follows(ask) == {"key": True, "fill": False}
    ask.follow(key, False)
    assert follows(ask) == {"key": False, "fill": False}
    ask.switch(False)
    assert follows(ask) == {"key": False, "fill": True}
    with pytest.raises(ValueError, match="light must be the number of an existing light; got 99"):
        ask.follow(99, True)


def test_the_spot_is_a_part_of_the_scene(ask):
    ask.resize("25")
    assert ask.shown()["spot"] == 25.0
    assert ask._gizmos.spot_size == 0.25
    for given, message in (("0", "spot must be .* >= 1"), ("101", "<= 100"), ("large", "spot must be a number")):
        with pytest.raises(ValueError, match=message):
            ask.resize(given)
    assert ask.shown()["spot"] == 25.0
