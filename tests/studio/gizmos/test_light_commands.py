"""Keys for the selected light: intensity, colour, lights that come and go; each one step, undone to the bit."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from mouse import Mouse
from views import FROM_SOMEWHERE, KINDS, example

import pvphong  # noqa: F401 registers plotter.phong wherever PyVista's own discovery is not installed
from pvphong.optics.lights import PointLight
from pvphong.optics.material import Material
from pvphong.optics.roles import Place
from pvphong.studio.gizmos import commands
from pvphong.studio.gizmos.light_commands import by_thirds

SHINY = Material(ambient=0.1, diffuse=0.6, specular=0.5, shininess=30)
FROM = [(0, -5, 2.5), (0, 0, 0.2), (0, 0, 1)]


each_kind = pytest.mark.parametrize("light", KINDS, indirect=True)


@pytest.fixture
def light(request):
    return example(getattr(request, "param", "spot"), 0.8, name="it", diffuse=(0.9, 0.6, 0.3))


@pytest.fixture
def mouse(light):
    plotter = pv.Plotter(off_screen=True, window_size=(400, 300), lighting="none")
    plotter.phong.add_light(light)
    plotter.phong.add_light(PointLight(position=(-1, 1, 0.3), name="other"))
    plotter.phong.add_mesh(pv.Sphere(theta_resolution=40, phi_resolution=40), SHINY, name="ball")
    plotter.camera_position = FROM
    plotter.show(auto_close=False)
    plotter.phong.add_gizmos()
    mouse = Mouse(plotter)
    mouse.move((5, 5))
    mouse.gizmo("it").is_selected = True
    yield mouse
    plotter.close()


def state(plotter):
    plotter.render()
    colors = np.asarray(plotter.renderer.actors["ball"].mapper.dataset["phong"]).tobytes()
    return plotter.phong.lights, plotter.phong._pane.rig.state, colors


def assert_one_step(plotter, before):
    after = state(plotter)
    assert after != before
    assert plotter.phong.undo()
    assert state(plotter) == before
    assert not plotter.phong.undo()
    assert plotter.phong.redo()
    assert state(plotter)[::2] == after[::2]


@pytest.mark.parametrize("key", [key for command in commands._OF_LIGHTS[4:] for key in command.keys])
def test_each_key_is_one_step_which_is_undone_to_the_bit(mouse, key):
    mouse.move(mouse.at((0, -0.4, 0.3)))
    before = state(mouse.plotter)
    mouse.key(key)
    assert_one_step(mouse.plotter, before)


def test_three_thirds_make_it_twice_as_bright_and_as_many_back_restore_it():
    assert by_thirds(by_thirds(by_thirds(1.0, 1), 1), 1) == 2.0
    up = by_thirds(0.7, 1)
    assert by_thirds(by_thirds(up, 1), 1) == pytest.approx(1.4, rel=1e-15)
    assert by_thirds(up, -1) == pytest.approx(0.7, rel=1e-15)
    assert by_thirds(0.0, 1) == 0.0


def test_the_intensity_is_said(mouse):
    mouse.key("Right")
    assert mouse.gizmo("it").light.intensity == 2 ** (1 / 3)
    assert mouse.plotter.phong._pane.board.notice == "it: intensity 1.26 = +0.33 stops"


def test_a_new_light_stands_above_the_place_under_the_cursor_and_half_of_it_arrives_there(mouse):
    place = np.array((0, -0.4, 0.3))
    mouse.move(mouse.at(place))
    mouse.key("N")
    light = mouse.plotter.phong.lights[-1]
    assert light.name == "point"
    np.testing.assert_allclose(np.cross(light.position, place / 0.5), 0, atol=0.03)  # along the ball's normal
    assert 0.5 < np.linalg.norm(light.position) < 2.0
    assert light.arrival(0.5 * np.array(light.position)[:, None] / np.linalg.norm(light.position)).strength == (
        pytest.approx(0.5, rel=0.01)
    )
    assert [gizmo.light.name for gizmo in mouse.plotter.phong.gizmos if gizmo.is_selected] == ["point"]
    mouse.key("N")
    assert mouse.plotter.phong.lights[-1].name == "point 2"


def test_beside_the_mesh_no_light_is_added_and_that_is_said(mouse):
    before = state(mouse.plotter)
    mouse.key("N")
    assert state(mouse.plotter) == before
    assert mouse.plotter.phong._pane.board.notice == "new light: point at a lit mesh"
    assert not mouse.plotter.phong.undo()


@pytest.mark.parametrize("light", FROM_SOMEWHERE, indirect=True)
def test_a_double_differs_by_name_and_stands_beside(mouse, light):
    mouse.key("D")
    double = mouse.plotter.phong.lights[-1]
    assert double.name == "it 2"
    assert replace(double, name="it", **{field: getattr(light, field) for field in light.roles}) == light
    assert {type(light.roles[field]) for field in light.roles if getattr(double, field) != getattr(light, field)}
    mouse.plotter.phong.scene  # noqa: B018 refuses lights that share a name
    mouse.key("D")
    assert mouse.plotter.phong.lights[-1].name == "it 3"


@pytest.mark.parametrize("light", ["environment"], indirect=True)
def test_what_comes_from_all_around_has_no_double(mouse, light):
    mouse.key("D")
    assert mouse.plotter.phong.lights == (light, mouse.plotter.phong.lights[1])
    assert mouse.plotter.phong._pane.board.notice == "it: a light that comes from all around has no double"


def test_where_only_some_lights_have_gizmos_a_new_one_has(mouse):
    mouse.plotter.phong.add_gizmos(["it"])
    mouse.gizmo("it").is_selected = True
    mouse.key("D")
    assert [gizmo.light.name for gizmo in mouse.plotter.phong.gizmos] == ["it", "it 2"]


def test_a_deleted_light_is_gone_and_nothing_is_selected(mouse):
    mouse.key("Delete")
    assert [light.name for light in mouse.plotter.phong.lights] == ["other"]
    assert not any(gizmo.is_selected for gizmo in mouse.plotter.phong.gizmos)


# --- typed values ---


def type_keys(mouse, text):
    names = {".": "period", "-": "minus", " ": "space", ",": "comma"}
    for character in text:
        mouse.key(names.get(character, character))


@each_kind
def test_a_typed_value_is_one_step(mouse, light):
    for handle in [*mouse.gizmo("it").handles, "intensity"]:
        before = state(mouse.plotter)
        mouse.plotter.phong._pane.board.interaction.grabbed_last = handle
        mouse.key("Return")
        type_keys(mouse, "3.5")
        assert state(mouse.plotter) != before  # the light follows
        mouse.key("Return")
        assert_one_step(mouse.plotter, before)
        mouse.plotter.phong.undo()
        mouse.plotter.phong._pane.board.history.clear()
    if light.values(Place):
        mouse.plotter.phong._pane.board.interaction.grabbed_last = "position"
        mouse.key("Return")
        type_keys(mouse, "1 -0,5 z2.25")
        mouse.key("KP_Enter")
        assert mouse.gizmo("it").light.values(Place) == [(1.0, -0.5, 2.25)]


def test_escape_gives_up_what_is_typed_and_an_empty_text_is_no_step(mouse):
    before = state(mouse.plotter)
    mouse.key("Return")
    type_keys(mouse, "2")
    mouse.key("BackSpace")
    assert state(mouse.plotter) == before
    mouse.key("Return")
    mouse.key("Return")
    type_keys(mouse, "2")
    mouse.key("Escape")
    assert state(mouse.plotter) == before
    assert not mouse.plotter.phong.undo()
    mouse.key("m")  # keys are commands again
    assert not mouse.gizmo("it").light.on


@each_kind
def test_tab_takes_and_goes_on(mouse):
    board = mouse.plotter.phong._pane.board
    mouse.key("Return")
    names = [*mouse.gizmo("it").handles, "intensity"]
    for name in [*names, names[0]]:
        assert board.interaction.entry.handle == name
        mouse.key("Tab")
    assert not mouse.plotter.phong.undo()


def test_a_text_that_is_no_value_cannot_be_taken_and_says_why(mouse):
    before = state(mouse.plotter)
    board = mouse.plotter.phong._pane.board
    board.interaction.grabbed_last = "intensity"
    mouse.key("Return")
    type_keys(mouse, "-1")
    mouse.key("Return")
    assert "intensity must be a finite number >= 0; got -1.0." in " ".join(board.interaction.readout.split())
    assert state(mouse.plotter) == before
    mouse.key("Escape")
    assert not mouse.plotter.phong.undo()


def test_while_typing_nobody_else_hears_the_keys(mouse):
    """3 is VTK's key for stereo, minus PyVista's for thinner lines."""
    heard = []
    for key in ("3", "minus", "q"):
        mouse.plotter.add_key_event(key, lambda key=key: heard.append(key))
    mouse.key("Return")
    for key in ("3", "minus", "q"):
        mouse.key(key)
    assert heard == []
    mouse.key("Escape")
    mouse.key("minus")
    assert heard == ["minus"]


def test_digits_during_a_drag_take_its_place(mouse):
    before = state(mouse.plotter)
    handle = next(iter(mouse.gizmo("it").handles))
    end = mouse.pull(mouse.at("it", handle), (20, 10))
    type_keys(mouse, "2")
    typed = state(mouse.plotter)
    mouse.move(end + 9)
    mouse.release(end + 9)
    assert state(mouse.plotter) == typed
    mouse.key("Return")
    assert_one_step(mouse.plotter, before)
    mouse.plotter.phong.undo()
    end = mouse.pull(mouse.at("it", handle), (20, 10))
    type_keys(mouse, "2")
    mouse.key("Escape")
    mouse.release(end)
    assert state(mouse.plotter) == before


def test_a_light_removed_while_a_value_is_typed(mouse):
    mouse.key("Return")
    type_keys(mouse, "2")
    mouse.plotter.phong.remove_light("it")
    mouse.key("3")
    mouse.key("Return")
    assert [light.name for light in mouse.plotter.phong.lights] == ["other"]
