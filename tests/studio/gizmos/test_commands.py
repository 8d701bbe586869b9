"""Keys: their effects on view, lights and materials, one undo step each, and no conflicts with other keys."""

import colorsys
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from mouse import Mouse, picture, texts
from views import FROM_SOMEWHERE, KINDS, example

from pvphong import LightModel, Material, OrenNayar
from pvphong.base.color import luminance
from pvphong.base.types import rgb
from pvphong.optics.roles import Aim, Place
from pvphong.studio.gizmos import commands

FROM = [(0, -5, 2.5), (0, 0, 0.2), (0, 0, 1)]
LIGHTS = tuple(example(kind, 0.7, name=kind, diffuse=(0.9, 0.6, 0.3)) for kind in ("directional", "point", "spot"))
FIRST, SECOND, _ = LIGHTS
GOLD = Material.named("gold")
LEFT, RIGHT = (-0.7, 0.0, 0.0), (0.7, 0.0, 0.0)


def keys_that_edit(*what):
    return [key for command in commands.COMMANDS if command.edits in what for key in command.keys.split()]


@pytest.fixture
def mouse(new_plotter):
    """The mouse of a plotter with three lights and two golden balls."""
    plotter = new_plotter((400, 300))
    for light in LIGHTS:
        plotter.phong.add_light(light)
    for name, center in (("left", LEFT), ("right", RIGHT)):
        plotter.phong.add_mesh(pv.Sphere(center=center, theta_resolution=16, phi_resolution=16), GOLD, name=name)
    plotter.camera_position = FROM
    plotter.show(auto_close=False)
    plotter.phong.add_gizmos()
    mouse = Mouse(plotter)
    mouse.move((5, 5))
    return mouse


@pytest.fixture
def plotter(mouse):
    return mouse.plotter


def select(plotter, *names):
    for gizmo in plotter.phong.gizmos:
        gizmo.is_selected = gizmo.light.name in names


def selected(plotter):
    return [gizmo.light.name for gizmo in plotter.phong.gizmos if gizmo.is_selected]


def put(plotter, kind, frame="world"):
    """Add a light of a kind with a gizmo, and select it."""
    light = example(kind, 0.7, name="it").in_frame(frame, plotter.phong.scene.viewer)
    plotter.phong.add_light(light)
    plotter.phong.add_gizmos()
    plotter.phong._history.clear()
    select(plotter, "it")
    return light


def notice(plotter):
    return plotter.phong._subplot.interaction.gizmos.notice


def materials(plotter):
    return [plotter.phong.mesh(plotter.renderer.actors[name]).material for name in ("left", "right")]


def colors(plotter):
    plotter.render()
    return [np.asarray(plotter.renderer.actors[name].mapper.dataset["phong"]).tobytes() for name in ("left", "right")]


def state(plotter):
    return colors(plotter), plotter.phong.lights, plotter.phong._subplot.lights.state


# --- the table of keys ---


def test_no_key_is_taken_and_pyvistas_own_are(plotter):
    assert not commands.TAKEN & commands.OURS
    keys = [key for command in commands.COMMANDS for key in command.keys.split()]
    assert len(keys) == len(set(keys))
    assert set(plotter.iren._key_press_event_callbacks) <= commands.TAKEN


def test_the_help_lists_them_all_and_fits_into_a_small_window(plotter, mouse):
    assert [what for _, what in commands.help_entries({})][: len(commands.COMMANDS)] == [
        command.what for command in commands.COMMANDS
    ]
    plotter.window_size = (300, 200)
    before = picture(plotter)
    mouse.key("h")
    assert (picture(plotter)[:120, :120] != before[:120, :120]).mean() > 0.2
    (shown,) = (text for text in texts(plotter) if "these keys" in text.GetInput())
    box = [0.0, 0.0]
    shown.GetSize(plotter.renderer, box)
    assert box[0] <= 300
    assert box[1] <= 200
    mouse.key("h")
    np.testing.assert_array_equal(picture(plotter), before)


def test_other_keys_are_left_to_others(plotter, mouse):
    select(plotter, FIRST.name)
    heard = []
    for key in "xm":
        plotter.add_key_event(key, lambda key=key: heard.append(key))
        mouse.key(key)
    assert heard == ["x", "m"]
    mouse.key("m", control=True)
    assert not plotter.phong.lights[0].on


def test_more_keys_can_be_added(plotter, mouse):
    plotter.phong.add_gizmos(keys={"d": ("save the rig", lambda: "saved"), "x": ("beep", lambda: None)})
    for key, said in (("d", "saved"), ("x", ""), ("h", "")):
        mouse.key(key)
        assert notice(plotter) == said
    assert any("save the rig" in text.GetInput() for text in texts(plotter))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"q": ("quit", print)}, r"^keys must be keys that are not used already; got q\. For example, x"),
        ({"m": ("mine", print)}, r"^keys must be keys that are not used already; got m"),
        ({"d": ("save", None)}, r"^keys\['d'\]\[1\] must be a function without arguments; got None"),
        ({"d": (7, print)}, r"^keys\['d'\]\[0\] must be a string; got 7"),
        ({"d": 1}, r"^keys\['d'\] must be a tuple \(help text, function without arguments\); got 1"),
        ({1: ("one", print)}, r"^keys must be a string; got 1"),
        (5, r"^keys must be a mapping"),
    ],
)
def test_keys_that_cannot_be_added(plotter, keys, message):
    with pytest.raises(ValueError, match=message):
        plotter.phong.add_gizmos(keys=keys)


def send(plotter, key, *events):
    interactor = plotter.iren.interactor
    interactor.SetKeySym(key)
    for event in events:
        interactor.InvokeEvent(event)


def test_a_press_that_is_reported_twice_counts_once_and_a_key_that_is_held_repeats(plotter, mouse):
    """Trame's remote area reports a letter twice; VTK sends a character for each repetition."""
    select(plotter, FIRST.name)
    for is_on in (False, True):
        send(plotter, "m", "KeyPressEvent", "KeyPressEvent", "CharEvent", "KeyReleaseEvent")
        assert plotter.phong.lights[0].on == is_on
    mouse.key("m")
    send(plotter, "z", *(3 * ["KeyPressEvent", "CharEvent"]), "KeyReleaseEvent")
    assert plotter.phong.lights == LIGHTS
    send(plotter, "m", "KeyPressEvent")  # a held key repeats
    send(plotter, "n", "KeyPressEvent")
    assert not plotter.phong.lights[0].on
    assert selected(plotter) == [SECOND.name]


def test_all_gizmos_hide(plotter, mouse):
    with_gizmos, where = picture(plotter), mouse.at("point", "position")
    mouse.key("g")
    assert (picture(plotter) != with_gizmos).any()
    mouse.drag(where, (9, 9))
    assert plotter.phong.lights == LIGHTS
    plotter.camera_position = FROM
    mouse.move((5, 5))
    mouse.key("g")
    np.testing.assert_array_equal(picture(plotter), with_gizmos)


# --- the selected light ---


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("frame", ["world", "camera"])
def test_a_light_is_muted_soloed_put_at_the_camera_and_reset(plotter, mouse, kind, frame):
    light = put(plotter, kind, frame)
    viewer, before = plotter.phong.scene.viewer, plotter.phong.lights
    others = [each for each in before if each != light]
    mouse.key("m")
    assert plotter.phong.lights == tuple(replace(each, on=each != light) for each in before)
    mouse.key("m")
    mouse.key("o")
    assert plotter.phong.lights == tuple(replace(each, on=each not in others) for each in before)
    mouse.key("o")
    assert plotter.phong.lights == before
    mouse.key("k")
    moved = plotter.phong.lights[-1]
    assert moved.frame == frame
    for place in moved.in_world(viewer).values(Place):
        np.testing.assert_allclose(place, viewer.position, atol=1e-12)
    for aim in moved.in_world(viewer).values(Aim):
        np.testing.assert_allclose(np.array(aim) / viewer.distance, viewer.view_direction, atol=1e-12)
    mouse.key("0")
    assert plotter.phong.lights == before


@pytest.mark.parametrize("key", keys_that_edit("lights", "light"))
def test_each_key_for_lights_is_one_step_which_is_undone_to_the_bit(plotter, mouse, key):
    mouse.move(mouse.at((*RIGHT[:1], -0.4, 0.3)))
    select(plotter)
    before = state(plotter)
    if key != "N":  # the other keys need a selected light
        mouse.key(key)
        assert state(plotter) == before
        assert notice(plotter).startswith("no light is selected")
        assert not plotter.phong.undo()
    select(plotter, "spot")
    if key == "0":
        mouse.key("m")
        plotter.phong._history.clear()
        before = state(plotter)
    mouse.key(key)
    after = state(plotter)
    assert after != before
    for again, control, expected in (("z", False, before), ("y", True, after), ("z", True, before)):
        mouse.key(again, control=control)
        assert state(plotter)[:2] == expected[:2]
    assert state(plotter) == before
    assert not plotter.phong.undo()


@pytest.mark.parametrize("has_shadows", [False, True])
def test_shadows_of_a_light_are_switched_off_and_on(plotter, mouse, has_shadows):
    plotter.phong.light_model = LightModel(shadows=has_shadows)
    select(plotter, "point")
    later = "" if has_shadows else "; shadows are off in the light model"
    for casts, said in ((False, "point: casts no shadows"), (True, "point: casts shadows")):
        mouse.key("X")
        assert [light.casts_shadows for light in plotter.phong.lights] == [True, casts, True]
        assert notice(plotter) == said + later


# --- colours ---


def test_brightness_and_colours_change_in_steps_that_lead_back(plotter, mouse):
    light = replace(FIRST, diffuse=(0.5, 0.5, 0.2), specular=(0.2, 0.5, 0.7))
    plotter.phong.set_light(0, light)
    select(plotter, FIRST.name)
    for keys, brightness, turn, warmth in (
        (3 * ["Right"], 2.0, 0.0, 1.0),
        (3 * ["Left"], 1.0, 0.0, 1.0),
        (["period"], 1.0, 15.0, None),
        (["comma", "comma"], 1.0, -15.0, None),
        (["period", "2"], 1.0, None, np.sqrt(2)),
        (["1", "1"], 1.0, None, np.sqrt(0.5)),
        (["2"], 1.0, 0.0, 1.0),
    ):
        for key in keys:
            mouse.key(key)
        now = plotter.phong.lights[0]
        assert (now.intensity, now.ambient) == (brightness, light.ambient)
        for before, after in ((light.diffuse, now.diffuse), (light.specular, now.specular)):
            (hue, *rest), (turned, *same) = colorsys.rgb_to_hsv(*before), colorsys.rgb_to_hsv(*after)
            if turn is None:
                assert luminance(after) == pytest.approx(luminance(before))
            else:
                assert same == pytest.approx(rest)
                assert (turned - hue - turn / 360.0 + 0.5) % 1.0 == pytest.approx(0.5)
            if warmth is not None:
                assert after[0] / after[2] / (before[0] / before[2]) == pytest.approx(warmth)


@pytest.mark.parametrize("key", ["comma", "period"])
def test_grey_gets_a_hue_and_what_is_not_there_stays_away(plotter, mouse, key):
    plotter.phong.set_light(0, replace(FIRST, diffuse=0.8, specular=None, intensity=0.0))
    select(plotter, FIRST.name)
    mouse.key(key)
    mouse.key("Right")
    light = plotter.phong.lights[0]
    assert (light.specular, light.intensity) == (None, 0.0)
    assert min(light.diffuse) < 0.5 < max(light.diffuse) == 0.8


# --- adding and deleting lights ---


def test_a_new_light_stands_above_the_place_under_the_cursor_and_half_of_it_arrives_there(plotter, mouse):
    offset = np.array((0, -0.4, 0.3))
    mouse.move(mouse.at(RIGHT + offset))
    mouse.key("N")
    light = plotter.phong.lights[-1]
    assert light.name == "point 2"
    out = np.array(light.position) - RIGHT
    np.testing.assert_allclose(np.cross(out, offset / 0.5), 0, atol=0.05)  # along the ball's normal
    assert 0.5 < np.linalg.norm(out) < 2.0
    below = RIGHT + 0.5 * out / np.linalg.norm(out)
    assert light.arrival(below[:, None]).strength == pytest.approx(0.5, rel=0.02)
    assert selected(plotter) == ["point 2"]
    mouse.key("N")
    assert plotter.phong.lights[-1].name == "point 3"


@pytest.mark.parametrize("kind", FROM_SOMEWHERE)
def test_a_double_differs_by_name_and_stands_beside(plotter, mouse, kind):
    light = put(plotter, kind)
    mouse.key("D")
    double = plotter.phong.lights[-1]
    assert double.name == "it 2"
    assert replace(double, name="it", **{field: getattr(light, field) for field in light.roles}) == light
    assert {type(light.roles[field]) for field in light.roles if getattr(double, field) != getattr(light, field)}
    mouse.key("D")
    assert plotter.phong.lights[-1].name == "it 3"


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("N", "to add a light, point at a lit mesh"),
        ("D", "it: a light from all around cannot be duplicated"),
        ("M", "no lit mesh"),
    ],
)
def test_what_a_key_cannot_do_is_said_and_is_no_step(plotter, mouse, key, said):
    light = put(plotter, "environment")
    if key == "M":
        plotter.remove_actor(["left", "right"])
    mouse.key(key)
    assert plotter.phong.lights == (*LIGHTS, light)
    assert notice(plotter) == said
    assert not plotter.phong.undo()


def test_where_only_some_lights_have_gizmos_a_new_one_has_and_a_deleted_one_is_gone(plotter, mouse):
    plotter.phong.add_gizmos(["spot"])
    select(plotter, "spot")
    mouse.key("D")
    assert [gizmo.light.name for gizmo in plotter.phong.gizmos] == ["spot", "spot 2"]
    mouse.key("Delete")
    assert plotter.phong.lights == LIGHTS
    assert selected(plotter) == []


# --- materials ---


@pytest.mark.parametrize("key", keys_that_edit("material"))
def test_a_key_changes_the_material_under_the_cursor_or_all_in_one_step(plotter, mouse, key):
    before = colors(plotter)
    for place, changed in ((LEFT, [True, False]), (RIGHT, [False, True]), ((0, 0, 1.2), [True, True])):
        mouse.move(mouse.at(place))
        mouse.key(key)
        assert [material != GOLD for material in materials(plotter)] == changed
        assert [a != b for a, b in zip(colors(plotter), before, strict=True)] == changed
        mouse.key("z")
        assert materials(plotter) == [GOLD, GOLD]
        assert colors(plotter) == before
        mouse.key("y")
        assert [material != GOLD for material in materials(plotter)] == changed
        mouse.key("z")


NAMES = [name for name in Material.names() if name != "brushed steel"]  # it needs tangents
OWN = [name for name in NAMES if Material.named(name).reflectance]


def test_presets_come_in_turn_and_keep_a_reflectance_unless_they_have_one(plotter, mouse):
    actor = plotter.renderer.actors["left"]
    plotter.phong.mesh(actor).material = Material(diffuse=0.3, reflectance=OrenNayar(20))
    mouse.move(mouse.at(LEFT))
    seen = []
    for name in (*NAMES, NAMES[0]):
        mouse.key("M")
        seen.append(materials(plotter)[0])
        assert notice(plotter) == f"material: {name}"
    assert len(set(map(repr, seen))) == len(NAMES) + 1
    plain = len(NAMES) - len(OWN)
    assert {material.reflectance for material in seen[:plain]} == {OrenNayar(20)}
    assert seen[plain:-1] == [Material.named(name) for name in OWN]
    assert seen[-1].reflectance is None
    mouse.key("K")
    assert notice(plotter) == f"material: {NAMES[-1]}"


def test_shininess_and_highlight_go_down_to_nothing_and_up_again(plotter, mouse):
    mouse.move(mouse.at(LEFT))
    for key in "57":
        for _ in range(20):
            mouse.key(key)
    (dull, _) = materials(plotter)
    assert (dull.shininess, rgb(dull.specular)) == (0.0, (0.0, 0.0, 0.0))
    for _ in range(20):
        mouse.key("8")
    for key, shininess in (("6", 1.0), ("6", 2**0.5), ("6", 2.0), ("5", 2**0.5)):
        mouse.key(key)
        assert materials(plotter)[0].shininess == shininess
    assert rgb(materials(plotter)[0].specular) == (1.0, 1.0, 1.0)
