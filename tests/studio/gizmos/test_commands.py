"""Keys: what they do, and that they are nobody else's."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from mouse import Mouse
from views import KINDS, example

import pvphong  # noqa: F401 registers plotter.phong wherever PyVista's own discovery is not installed
from pvphong.optics.roles import Aim, Place
from pvphong.studio.gizmos import commands

FROM = [(0, -5, 2.5), (0, 0, 0.2), (0, 0, 1)]
LIGHTS = tuple(example(kind, 0.7, name=kind) for kind in KINDS)
FIRST, SECOND, *REST = LIGHTS


@pytest.fixture
def plotter():
    shown = pv.Plotter(off_screen=True, window_size=(300, 200), lighting="none")
    for light in LIGHTS:
        shown.phong.add_light(light)
    shown.phong.add_mesh(pv.Sphere())
    shown.camera_position = FROM
    shown.show(auto_close=False)
    shown.phong.add_gizmos()
    yield shown
    shown.close()


@pytest.fixture
def mouse(plotter):
    mouse = Mouse(plotter)
    mouse.move((5, 5))
    return mouse


def select(plotter, chosen):
    for gizmo in plotter.phong.gizmos:
        gizmo.is_selected = chosen is not None and gizmo.light.name == chosen.name


def image(plotter):
    plotter.render()
    return plotter.image.astype(int)


def test_no_key_is_taken_and_pyvistas_own_are(plotter):
    assert not commands.TAKEN & commands.OURS
    assert len(commands._ACTS) == sum(len(command.keys) for command in commands.COMMANDS)
    assert set(plotter.iren._key_press_event_callbacks) <= commands.TAKEN


def test_the_help_lists_them_all(plotter, mouse):
    lines = commands.help_text({}).splitlines()
    for command in commands.COMMANDS:
        assert any(line.endswith(command.what) and len(line.split(command.what)[0].split()) >= 1 for line in lines)
    before = image(plotter)
    mouse.key("h")
    assert (image(plotter)[:120, :120] != before[:120, :120]).mean() > 0.2
    help_texts = [each for each in plotter.renderer.GetViewProps() if each.IsA("vtkTextActor") and each.GetVisibility()]
    (shown,) = (each for each in help_texts if "these keys" in each.GetInput())
    box = [0.0, 0.0]
    shown.GetSize(plotter.renderer, box)
    assert box[0] <= 300  # all of it, however small the window
    assert box[1] <= 200
    mouse.key("h")
    np.testing.assert_array_equal(image(plotter), before)


def test_all_gizmos_hide(plotter, mouse):
    with_gizmos, where = image(plotter), mouse.at("point", "position")
    mouse.key("g")
    assert (image(plotter) != with_gizmos).any()
    mouse.drag(where, (9, 9))
    assert plotter.phong.lights == LIGHTS
    plotter.camera_position = FROM
    mouse.move((5, 5))
    mouse.key("g")
    np.testing.assert_array_equal(image(plotter), with_gizmos)


def test_the_next_light_is_selected(plotter, mouse):
    def next_one():
        mouse.key("n")
        return [gizmo.light for gizmo in plotter.phong.gizmos if gizmo.is_selected]

    assert [next_one() for _ in range(len(LIGHTS) + 2)] == [*([light] for light in LIGHTS), [], [FIRST]]


@pytest.mark.parametrize("light", LIGHTS, ids=list(KINDS))
@pytest.mark.parametrize("frame", ["world", "camera"])
def test_each_change_can_be_taken_back(plotter, mouse, light, frame):
    viewer = plotter.phong.scene.viewer
    light = light.in_frame(frame, viewer)
    plotter.phong.set_light(light.name, light)
    mouse.plotter.phong.add_gizmos()  # first is what is there then
    before = plotter.phong.lights
    select(plotter, light)
    others = [each for each in before if each != light]
    mouse.key("m")
    assert plotter.phong.lights == tuple(replace(each, on=each != light) for each in before)
    mouse.key("m")
    assert plotter.phong.lights == before
    mouse.key("o")
    assert plotter.phong.lights == tuple(replace(each, on=each not in others) for each in before)
    mouse.key("o")
    assert plotter.phong.lights == before
    mouse.key("k")
    moved = mouse.gizmo(light.name).light
    assert moved.frame == frame
    for place in moved.in_world(viewer).values(Place):
        np.testing.assert_allclose(place, viewer.position, atol=1e-12)
    for aim in moved.in_world(viewer).values(Aim):
        np.testing.assert_allclose(np.array(aim) / viewer.distance, viewer.view_direction, atol=1e-12)
    mouse.key("0")
    assert plotter.phong.lights == before


@pytest.mark.parametrize("control", [False, True])
def test_each_change_is_one_step(plotter, mouse, control):
    select(plotter, FIRST)
    mouse.key("m")
    mouse.key("o")
    muted = (replace(FIRST, on=False), *LIGHTS[1:])
    for key, lights in (("z", muted), ("z", LIGHTS), ("y", muted)):
        mouse.key(key, control=control)
        assert plotter.phong.lights == lights


def send(plotter, key, *events):
    interactor = plotter.iren.interactor
    interactor.SetKeySym(key)
    for event in events:
        interactor.InvokeEvent(event)


def test_a_press_that_is_reported_twice_counts_once(plotter):
    """As trame's remote area reports a letter."""
    select(plotter, FIRST)
    for is_on in (False, True):
        send(plotter, "m", "KeyPressEvent", "KeyPressEvent", "CharEvent", "KeyReleaseEvent")
        assert plotter.phong.lights[0].on == is_on


def test_a_key_that_is_held_repeats(plotter, mouse):
    select(plotter, FIRST)
    for key in "mom":
        mouse.key(key)
    send(plotter, "z", *(3 * ["KeyPressEvent", "CharEvent"]), "KeyReleaseEvent")
    assert plotter.phong.lights == LIGHTS


def test_of_two_keys_that_are_held_each_counts(plotter):
    select(plotter, FIRST)
    send(plotter, "m", "KeyPressEvent")
    send(plotter, "n", "KeyPressEvent")
    assert not plotter.phong.lights[0].on
    assert [gizmo.is_selected for gizmo in plotter.phong.gizmos] == [False, True, *(False for _ in REST)]


@pytest.mark.parametrize("key", [key for command in commands._OF_LIGHTS for key in command.keys])
def test_without_a_selected_light_nothing_changes(plotter, mouse, key):
    select(plotter, None)
    mouse.key(key)
    assert plotter.phong.lights == LIGHTS
    assert not plotter.phong.undo()


def test_other_keys_are_left_to_others(plotter, mouse):
    select(plotter, FIRST)
    heard = []
    for key in "xm":
        plotter.add_key_event(key, lambda key=key: heard.append(key))
        mouse.key(key)
    assert heard == ["x", "m"]
    mouse.key("m", control=True)
    assert not plotter.phong.lights[0].on


def test_more_keys_can_be_added(plotter, mouse):
    saved = []
    plotter.phong.add_gizmos(keys={"d": ("save the rig", lambda: saved.append(plotter.phong.scene))})
    mouse.key("d")
    assert saved == [plotter.phong.scene]
    assert ("d", "save the rig") in commands.entries(plotter.phong._pane.board.options.keys)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"q": ("quit", print)}, r"^keys must be keys that are free; got q\. x, d, 4 and"),
        ({"m": ("mine", print)}, r"^keys must be keys that are free; got m"),
        ({"d": ("save", None)}, r"^keys\['d'\]\[1\] must be a function without arguments; got None"),
        ({"d": (7, print)}, r"^keys\['d'\]\[0\] must be a string; got 7"),
        ({"d": 1}, r"^keys\['d'\] must be what the help says, and a function without arguments; got 1"),
        ({1: ("one", print)}, r"^keys must be a string; got 1"),
        (5, r"^keys must be a mapping"),
    ],
)
def test_keys_that_cannot_be_added(plotter, keys, message):
    with pytest.raises(ValueError, match=message):
        plotter.phong.add_gizmos(keys=keys)


@pytest.mark.parametrize("lights", [5, "sun"])
def test_lights_that_are_no_sequence(plotter, lights):
    with pytest.raises(ValueError, match=r"^lights must be a sequence of lights, or None for all"):
        plotter.phong.add_gizmos(lights)
    assert len(plotter.phong.gizmos) == len(LIGHTS)
