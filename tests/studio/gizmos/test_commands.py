"""Keys: what they do, and that they are nobody else's."""

import dataclasses

import numpy as np
import pytest
import pyvista as pv
from mouse import Mouse

import pvphong  # noqa: F401 registers plotter.phong wherever PyVista's own discovery is not installed
from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.studio.gizmos import commands

LAMP = PointLight(position=(0.8, -0.4, 0.9), name="lamp")
SPOT = SpotLight(position=(-0.7, 0.2, 1.0), direction=(0.7, -0.2, -1.0), name="spot")
SUN = DirectionalLight(direction=(1, 1, -1), name="sun")
KEYS = {**commands._SHOWING, **commands._CHANGING}


@pytest.fixture
def plotter():
    shown = pv.Plotter(off_screen=True, window_size=(300, 200), lighting="none")
    for light in (LAMP, SPOT, SUN):
        shown.phong.add_light(light)
    shown.phong.add_mesh(pv.Sphere())
    shown.camera_position = [(0, -5, 2.5), (0, 0, 0.2), (0, 0, 1)]
    shown.show(auto_close=False)
    shown.phong.add_gizmos()
    Mouse(shown).move((5, 5))
    yield shown
    shown.close()


def select(plotter, name):
    for gizmo in plotter.phong.gizmos:
        gizmo.is_selected = gizmo.light.name == name


def light(plotter, name):
    return next(each for each in plotter.phong.lights if each.name == name)


def image(plotter):
    plotter.render()
    return plotter.image.astype(int)


def test_no_key_is_taken():
    assert not commands.TAKEN & set(KEYS)


def test_pyvistas_own_keys_are_among_the_taken(plotter):
    assert set(plotter.iren._key_press_event_callbacks) <= commands.TAKEN


def test_the_help_lists_them_all(plotter):
    for key, (what, _) in KEYS.items():
        assert f"{key:6}{what}" in commands.help_text({}).splitlines()
    before = image(plotter)
    Mouse(plotter).key("h")
    helping = image(plotter)
    assert (helping[:120, :120] != before[:120, :120]).mean() > 0.2
    Mouse(plotter).key("h")
    np.testing.assert_array_equal(image(plotter), before)


def test_all_gizmos_hide(plotter):
    with_gizmos = image(plotter)
    Mouse(plotter).key("g")
    without = image(plotter)
    assert (without != with_gizmos).any()
    at = Mouse(plotter).at(plotter.phong.gizmos[0].handles["position"])
    Mouse(plotter).drag(at, (9, 9))
    assert plotter.phong.lights == (LAMP, SPOT, SUN)
    plotter.camera_position = [(0, -5, 2.5), (0, 0, 0.2), (0, 0, 1)]
    Mouse(plotter).move((5, 5))
    Mouse(plotter).key("g")
    np.testing.assert_array_equal(image(plotter), with_gizmos)


def test_the_next_light_is_selected(plotter):
    chosen = []
    for _ in range(5):
        Mouse(plotter).key("n")
        chosen.append([gizmo.light.name for gizmo in plotter.phong.gizmos if gizmo.is_selected])
    assert chosen == [["lamp"], ["spot"], ["sun"], [], ["lamp"]]


def test_mute(plotter):
    select(plotter, "spot")
    Mouse(plotter).key("m")
    assert plotter.phong.lights == (LAMP, dataclasses.replace(SPOT, on=False), SUN)
    Mouse(plotter).key("m")
    assert plotter.phong.lights == (LAMP, SPOT, SUN)


def test_solo(plotter):
    select(plotter, "sun")
    Mouse(plotter).key("o")
    assert [each.on for each in plotter.phong.lights] == [False, False, True]
    Mouse(plotter).key("o")
    assert plotter.phong.lights == (LAMP, SPOT, SUN)


@pytest.mark.parametrize("name", ["lamp", "spot", "sun"])
def test_to_the_camera_and_reset(plotter, name):
    select(plotter, name)
    viewer = plotter.phong.scene.viewer
    Mouse(plotter).key("k")
    moved = light(plotter, name)
    if name != "sun":
        assert moved.position == viewer.position
    if name != "lamp":
        aim = np.array(moved.direction) / np.linalg.norm(moved.direction)
        np.testing.assert_allclose(aim, viewer.view_direction, atol=1e-12)
    Mouse(plotter).key("0")
    assert plotter.phong.lights == (LAMP, SPOT, SUN)


@pytest.mark.parametrize("control", [False, True])
def test_each_change_is_one_step(plotter, control):
    select(plotter, "lamp")
    mouse = Mouse(plotter)
    mouse.key("m")
    mouse.key("o")
    states = [(LAMP, SPOT, SUN), (dataclasses.replace(LAMP, on=False), SPOT, SUN)]
    mouse.key("z", control=control)
    assert plotter.phong.lights == states[1]
    mouse.key("z", control=control)
    assert plotter.phong.lights == states[0]
    mouse.key("y", control=control)
    assert plotter.phong.lights == states[1]


def send(plotter, key, *events):
    interactor = plotter.iren.interactor
    interactor.SetKeySym(key)
    for event in events:
        interactor.InvokeEvent(event)


def test_a_press_that_is_reported_twice_counts_once(plotter):
    """As trame's remote area reports a letter."""
    select(plotter, "lamp")
    for is_on in (False, True):
        send(plotter, "m", "KeyPressEvent", "KeyPressEvent", "CharEvent", "KeyReleaseEvent")
        assert light(plotter, "lamp").on == is_on


def test_a_key_that_is_held_repeats(plotter):
    select(plotter, "lamp")
    mouse = Mouse(plotter)
    for key in "mom":
        mouse.key(key)
    send(plotter, "z", *(3 * ["KeyPressEvent", "CharEvent"]), "KeyReleaseEvent")
    assert plotter.phong.lights == (LAMP, SPOT, SUN)


def test_of_two_keys_that_are_held_each_counts(plotter):
    select(plotter, "lamp")
    send(plotter, "m", "KeyPressEvent")
    send(plotter, "n", "KeyPressEvent")
    assert not light(plotter, "lamp").on
    assert [gizmo.is_selected for gizmo in plotter.phong.gizmos] == [False, True, False]


@pytest.mark.parametrize("key", ["m", "o", "k", "0"])
def test_without_a_selected_light_nothing_changes(plotter, key):
    select(plotter, None)
    Mouse(plotter).key(key)
    assert plotter.phong.lights == (LAMP, SPOT, SUN)
    assert not plotter.phong.undo()


def test_other_keys_are_left_to_others(plotter):
    select(plotter, "lamp")
    heard = []
    plotter.add_key_event("x", lambda: heard.append("x"))
    plotter.add_key_event("m", lambda: heard.append("m"))
    Mouse(plotter).key("x")
    Mouse(plotter).key("m")
    assert heard == ["x", "m"]
    Mouse(plotter).key("m", control=True)
    assert not light(plotter, "lamp").on


def test_more_keys_can_be_added(plotter):
    saved = []
    plotter.phong.add_gizmos(keys={"d": ("save the rig", lambda: saved.append(plotter.phong.scene))})
    Mouse(plotter).key("d")
    assert saved == [plotter.phong.scene]
    assert "d     save the rig" in commands.help_text(plotter.phong._pane.board.options.keys)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"q": ("quit", print)}, r"^keys must be keys that are free; got q\. x, d and"),
        ({"m": ("mine", print)}, r"^keys must be keys that are free; got m"),
        ({"d": ("save", None)}, r"^keys\['d'\]\[1\] must be a function without arguments; got None"),
        ({"d": (7, print)}, r"^keys\['d'\]\[0\] must be a string; got 7"),
    ],
)
def test_keys_that_cannot_be_added(plotter, keys, message):
    with pytest.raises(ValueError, match=message):
        plotter.phong.add_gizmos(keys=keys)
    assert len(plotter.phong.gizmos) == 3
