"""Gizmos in a plotter, driven by the events that a window would send."""

from dataclasses import fields, replace

import numpy as np
import pytest
import pyvista as pv
import vtk
from mouse import Mouse, picture, texts
from views import FROM_SOMEWHERE, KINDS, Glow, example, role_of

from pvphong import DirectionalLight, Material, PointLight, SpotLight
from pvphong.optics.photometry import Photometry
from pvphong.optics.roles import Aim, Place
from pvphong.studio.lit_actors import LightingWarning

LAMP = PointLight(position=(0.8, -0.4, 0.9), attenuation=(1, 0, 1), diffuse=(1, 0.5, 0.2), name="lamp")
SPOT = SpotLight(position=(-0.7, 0.2, 1.0), direction=(0.7, -0.2, -1.0), cone_angle=20, exponent=4, name="spot")
SUN = DirectionalLight(direction=(1, 1, -1), diffuse=(0.3, 0.3, 0.5), name="sun")
SHINY = Material(ambient=0.1, diffuse=0.6, specular=0.5, shininess=30)
FROM = [(0, -5, 2.5), (0, 0, 0.2), (0, 0, 1)]


@pytest.fixture
def new_mouse(new_plotter):
    """A function that makes a plotter with a ball, lights, and gizmos unless `gizmos` is None; it returns a mouse."""

    def make(*lights, gizmos=(), **options):
        plotter = new_plotter((400, 300), **options)
        furnish(plotter, lights)
        if gizmos is not None:
            plotter.phong.add_gizmos(**dict(gizmos))
        return Mouse(plotter)

    return make


def furnish(plotter, lights):
    for light in lights:
        plotter.phong.add_light(light)
    plotter.phong.add_mesh(ball(), SHINY, name="ball")
    plotter.camera_position = FROM
    plotter.show(auto_close=False)


def ball(resolution=40):
    return pv.Sphere(theta_resolution=resolution, phi_resolution=resolution)


@pytest.fixture
def mouse(new_mouse):
    return new_mouse(LAMP, SPOT, SUN)


@pytest.fixture
def plotter(mouse):
    return mouse.plotter


def seen(plotter):
    """Return the lights and the drawn colours of the ball."""
    plotter.render()
    return plotter.phong.lights, np.asarray(plotter.renderer.actors["ball"].mapper.dataset["phong"]).tobytes()


def said(plotter):
    """Return the text in the lower right corner."""
    return next((text.GetInput() for text in texts(plotter) if text.GetTextProperty().GetJustification() == 2), "")


def interaction_of(mouse):
    return mouse.plotter.phong._subplot.interaction


# --- dragging ---


@pytest.mark.parametrize(("frame", "projection"), [("world", "parallel"), ("camera", "perspective")])
@pytest.mark.parametrize("kind", KINDS)
def test_a_drag_changes_light_and_colours_and_escape_and_undo_restore_both(new_mouse, kind, frame, projection):
    mouse = new_mouse(gizmos=None)
    plotter = mouse.plotter
    plotter.camera.parallel_projection, plotter.camera.parallel_scale = projection == "parallel", 1.6
    uneven = {"image": np.linspace(0.0, 1.0, 24).reshape(2, 4, 3)} if kind == "environment" else {}
    if kind == "photometric":
        uneven = {"photometry": Photometry("C", "0 30 90", "0 90", ("9 4 0", "9 8 1"))}
    light = example(kind, 0.8, falloff=(1, 0, 4), name="it", **uneven).in_frame(frame, plotter.phong.scene.viewer)
    plotter.phong.add_light(light)
    (only,) = plotter.phong.add_gizmos()
    before, places = seen(plotter), {handle: mouse.at("it", handle) for handle in only.handles}
    for handle in only.handles:
        mouse.pull(mouse.at("it", handle), (25, -9))
        held = seen(plotter)
        assert held[0] != before[0]
        assert held[1] != before[1]
        mouse.key("Escape")
        assert seen(plotter) == before
        mouse.move((30, 30))
        mouse.release((30, 30))
        assert seen(plotter) == before
        assert not plotter.phong.undo()

        role, field = role_of(kind, handle)
        own = {field, *(name for name, of in light.roles.items() if role is Place and isinstance(of, Aim))}
        end = mouse.drag(mouse.at("it", handle), (-14, 18))
        after = seen(plotter)
        of = [(each.name, getattr(light, each.name), getattr(only.light, each.name)) for each in fields(light)]
        assert {name for name, was, now in of if was != now} == own
        assert after[1] != before[1]
        if role is Place or (role is Aim and light.values(Place)):
            np.testing.assert_allclose(mouse.at("it", handle), end, atol=1.01)
        assert plotter.phong.undo()
        assert seen(plotter) == before
        np.testing.assert_allclose([mouse.at("it", name) for name in places], list(places.values()), atol=1e-6)
        assert not plotter.phong.undo()
        assert plotter.phong.redo()
        assert seen(plotter) == after
        assert plotter.phong.undo()


def test_a_drag_that_is_given_up_puts_the_light_back_and_is_no_step(mouse, plotter):
    before = seen(plotter)
    end = mouse.pull(mouse.at("lamp", "position"), (25, -9))
    assert seen(plotter) != before
    interaction_of(mouse).give_up()
    assert seen(plotter) == before
    mouse.release(end)
    assert seen(plotter) == before
    assert not plotter.phong.undo()


def test_a_window_that_was_resized_without_a_frame(mouse, plotter):
    """Trame resizes the window at each press, to draw fewer pixels while the button is down."""
    where = mouse.at("lamp", "position")
    plotter.render_window.SetSize(200, 150)
    mouse.move(0.5 * where)
    assert mouse.gizmo("lamp").hovered == "position"
    plotter.render_window.SetSize(400, 300)
    end = mouse.drag(where, (20, 5))
    assert mouse.gizmo("lamp").light != LAMP
    np.testing.assert_allclose(mouse.at("lamp", "position"), end, atol=1.01)


def test_views_of_the_plotter_are_told_of_every_new_picture(mouse, plotter):
    """PyVista's views in a browser update in the plotter's render callbacks."""
    drawn = []
    plotter.add_on_render_callback(lambda _: drawn.append(plotter.image))
    mouse.move(mouse.at("lamp", "position"))
    assert len(drawn) == 1
    mouse.key("h")
    assert len(drawn) == 2
    assert (drawn[0] != drawn[1]).any()


def test_modifiers_constrain_and_snap_in_steps_that_can_be_chosen(new_mouse):
    mouse = new_mouse(LAMP, SPOT, gizmos={"angle_step": 7.5, "length_step": 0.125})
    mouse.drag(mouse.at("lamp", "position"), (-31, 2), shift=True)
    assert np.count_nonzero(np.abs(np.subtract(mouse.gizmo("lamp").light.position, LAMP.position)) > 1e-9) == 1
    mouse.drag(mouse.at("spot", "cone"), (-9, 0), control=True)
    assert mouse.gizmo("spot").light.cone_angle % 7.5 == 0
    mouse.drag(mouse.at("lamp", "position"), (-31, 12), control=True)
    np.testing.assert_array_equal(np.mod(mouse.gizmo("lamp").light.position, 0.125), 0.0)
    with pytest.raises(ValueError, match=r"^angle_step must be a finite number > 0 and <= 90; got 0"):
        mouse.plotter.phong.add_gizmos(angle_step=0)
    assert len(mouse.plotter.phong.gizmos) == 2


@pytest.mark.parametrize(("others", "moves_on"), [((SPOT, SUN), True), ((SPOT, SUN), False), ((), False)])
def test_a_light_removed_during_a_drag(new_mouse, others, moves_on):
    mouse = new_mouse(LAMP, *others)
    plotter = mouse.plotter
    end = mouse.pull(mouse.at("lamp", "position"), (20, 5))
    removed = mouse.gizmo("lamp").renderer_light
    plotter.phong.remove_light("lamp")
    left = removed.state
    if moves_on:
        mouse.move(end + 5)
    plotter.render()
    mouse.release(end + 5)
    assert removed.state == left
    assert plotter.phong.lights == tuple(gizmo.light for gizmo in plotter.phong.gizmos) == others
    before = plotter.camera.position
    for light in others[:1]:
        mouse.drag(mouse.at(light.name, "position"), (20, 5))
        assert plotter.camera.position == before
        assert plotter.phong.undo()
    mouse.drag((5, 5), (20, 30))  # the mouse is released
    assert plotter.camera.position != before
    assert plotter.phong.undo()
    assert len(plotter.phong.lights) == 1 + len(others)
    assert not plotter.phong.undo()  # the drag was not finished


@pytest.mark.parametrize("light_type", ["scene light", "camera light"])
@pytest.mark.parametrize("positional", [True, False])
def test_a_light_of_pyvista_is_changed_in_place(new_mouse, light_type, positional):
    light = pv.Light(position=(0.6, -0.3, 0.9), light_type=light_type, positional=positional, cone_angle=30)
    mouse, kind = new_mouse(light), light.GetLightType()
    (only,) = mouse.plotter.phong.gizmos
    before = light.position, light.focal_point, light.cone_angle
    mouse.drag(mouse.at(only.handles["target"]), (16, 12))
    assert (light.position, light.focal_point, light.cone_angle) != before
    assert light.GetLightType() == kind
    mouse.plotter.phong.undo()
    assert (light.position, light.focal_point, light.cone_angle) == before
    light.position = (0.5, 0.25, 1.5)  # in code: the gizmo follows
    mouse.plotter.render()
    if positional and light_type == "scene light":
        assert only.light.position == only.handles["position"] == (0.5, 0.25, 1.5)


# --- the highlight ---


@pytest.mark.parametrize("kind", FROM_SOMEWHERE)
def test_the_highlight_is_dragged_on_the_surface_and_waits_off_it(new_mouse, kind):
    light = example(kind, place=(-1.2, -0.6, 0.4), aim=(1.2, 0.6, -0.4), falloff=(1, 0, 1))
    mouse = new_mouse(light)
    (only,) = mouse.plotter.phong.gizmos
    assert only.highlight is None  # not selected
    mouse.click(mouse.at(next(iter(only.handles.values()))))
    start = mouse.at(only.highlight)
    mouse.move(start)
    assert only.hovered == "highlight"
    end = mouse.pull(start, (12, -15))
    ring = interaction_of(mouse).edit.over.point
    np.testing.assert_allclose(mouse.at(ring), end, atol=1.01)  # under the cursor
    np.testing.assert_allclose(mouse.at(only.highlight), end, atol=5)  # at the nearest vertex
    on_surface = only.light
    assert on_surface != light
    mouse.move((399, 299))
    assert only.light == on_surface
    mouse.release()
    assert mouse.plotter.phong.undo()
    assert mouse.plotter.phong.lights == (light,)
    mouse.key("m")
    assert only.highlight is None


@pytest.fixture
def unlit(mouse, plotter):
    """The mouse of a window with a selected light and a mesh that can no longer be lit."""
    mouse.gizmo("lamp").is_selected = True
    plotter.phong.mesh(plotter.actors["ball"]).material = replace(SHINY, albedo="gone")
    with pytest.warns(LightingWarning):
        plotter.render()
    return mouse


def test_handles_stay_where_a_mesh_cannot_be_lit(unlit):
    before = unlit.plotter.phong.lights
    unlit.drag(unlit.at("spot", "position"), (20, 5))
    assert unlit.plotter.phong.lights != before


@pytest.mark.parametrize("key", ["M", "N"])
def test_a_mesh_that_cannot_be_lit_is_not_under_the_cursor(unlit, key, caplog):
    unlit.move((200, 150))
    unlit.key(key)
    assert caplog.records == []  # no VTK errors


@pytest.mark.parametrize("change", ["edited", "removed", "replaced"])
def test_the_mesh_changes_while_its_highlight_is_dragged(new_mouse, change):
    mesh, mouse = ball(), new_mouse(LAMP)
    plotter = mouse.plotter
    plotter.phong.add_mesh(mesh, SHINY, name="ball")
    mouse.click(mouse.at("lamp", "position"))
    end = mouse.pull(mouse.at(mouse.gizmo("lamp").highlight), (5, -5))
    if change == "edited":
        mesh.points *= 0.5
        mesh.copy_from(ball(9))
    elif change == "removed":
        plotter.remove_actor("ball")
    else:
        plotter.phong.add_mesh(pv.Cube(), SHINY, name="ball")
    mouse.move(end + np.array((4, -4)))
    plotter.render()
    mouse.release(end + np.array((7, -7)))
    assert plotter.phong.undo()
    assert plotter.phong.lights == (LAMP,)


# --- typed values ---


def type_keys(mouse, text):
    names = {".": "period", "-": "minus", " ": "space", ",": "comma"}
    for character in text:
        mouse.key(names.get(character, character))


def assert_one_step(plotter, before):
    after = seen(plotter)
    assert after != before
    assert plotter.phong.undo()
    assert seen(plotter) == before
    assert not plotter.phong.undo()
    assert plotter.phong.redo()
    assert seen(plotter) == after


@pytest.fixture
def chosen(new_mouse):
    """The mouse of a window with a selected spot light and another light."""
    mouse = new_mouse(replace(SPOT, name="it"), PointLight(position=(-1, 1, 0.3), name="other"))
    mouse.move((5, 5))
    mouse.gizmo("it").is_selected = True
    return mouse


@pytest.mark.parametrize("kind", KINDS)
def test_a_typed_value_is_one_step(new_mouse, kind):
    light = example(kind, 0.8, name="it", diffuse=(0.9, 0.6, 0.3))
    mouse = new_mouse(light)
    mouse.move((5, 5))
    mouse.gizmo("it").is_selected = True
    for handle in [*mouse.gizmo("it").handles, "intensity"]:
        before = seen(mouse.plotter)
        interaction_of(mouse).grabbed_last = handle
        mouse.key("Return")
        type_keys(mouse, "3.5")
        assert seen(mouse.plotter) != before  # the light follows
        mouse.key("Return")
        assert_one_step(mouse.plotter, before)
        mouse.plotter.phong.undo()
        mouse.plotter.phong._history.clear()
    if light.values(Place):
        interaction_of(mouse).grabbed_last = "position"
        mouse.key("Return")
        type_keys(mouse, "1 -0,5 z2.25")
        mouse.key("KP_Enter")
        assert mouse.gizmo("it").light.values(Place) == [(1.0, -0.5, 2.25)]


def test_what_is_given_up_or_empty_or_no_value_is_no_step(chosen):
    def enter(*texts):
        chosen.key("Return")
        for text in texts:
            type_keys(chosen, text)
        return interaction.edit

    before, interaction = seen(chosen.plotter), interaction_of(chosen)
    enter("2")
    chosen.key("BackSpace")
    assert seen(chosen.plotter) == before
    chosen.key("Return")
    enter("2")
    chosen.key("Escape")
    assert seen(chosen.plotter) == before
    enter()
    names = [*chosen.gizmo("it").handles, "intensity"]
    for name in [*names, *names]:  # Tab accepts and selects the next
        assert interaction.edit.handle == name
        chosen.key("Tab")
    chosen.key("Escape")
    interaction.grabbed_last = "intensity"
    edit = enter("-1")
    chosen.key("Return")
    assert "intensity must be a finite number >= 0; got -1.0." in " ".join(edit.readout.split())
    assert seen(chosen.plotter) == before
    chosen.key("Escape")
    assert not chosen.plotter.phong.undo()
    chosen.key("m")  # keys are commands again
    assert not chosen.gizmo("it").light.on
    enter("2")
    chosen.plotter.phong.remove_light("it")
    chosen.key("3")
    chosen.key("Return")
    assert [light.name for light in chosen.plotter.phong.lights] == ["other"]


def test_while_typing_nobody_else_hears_the_keys(chosen):
    """3 is VTK's key for stereo, and minus PyVista's for thinner lines."""
    heard = []
    for key in ("3", "minus", "q"):
        chosen.plotter.add_key_event(key, lambda key=key: heard.append(key))
    chosen.key("Return")
    for key in ("3", "minus", "q"):
        chosen.key(key)
    assert heard == []
    chosen.key("Escape")
    chosen.key("minus")
    assert heard == ["minus"]


def test_digits_during_a_drag_take_its_place(chosen):
    before = seen(chosen.plotter)
    handle = next(iter(chosen.gizmo("it").handles))
    end = chosen.pull(chosen.at("it", handle), (20, 10))
    type_keys(chosen, "2")
    typed = seen(chosen.plotter)
    chosen.move(end + 9)
    chosen.release(end + 9)
    assert seen(chosen.plotter) == typed
    chosen.key("Return")
    assert_one_step(chosen.plotter, before)
    chosen.plotter.phong.undo()
    end = chosen.pull(chosen.at("it", handle), (20, 10))
    type_keys(chosen, "2")
    chosen.key("Escape")
    chosen.release(end)
    assert seen(chosen.plotter) == before


# --- looks ---


def test_hovering_shows_and_ends_where_the_handle_is_taken_away(mouse, plotter):
    assert [each.hovered for each in plotter.phong.gizmos] == [None, None, None]  # before the first move of the cursor
    away, where = picture(plotter), mouse.at("spot", "target")
    mouse.move(where)
    assert mouse.gizmo("spot").hovered == "target"
    x, y = where.astype(int)
    part = np.s_[300 - y - 12 : 300 - y + 12, x - 12 : x + 12]
    assert (picture(plotter)[part] != away[part]).any()
    mouse.move((3, 3))
    assert mouse.gizmo("spot").hovered is None
    np.testing.assert_array_equal(picture(plotter), away)
    mouse.drag(where, (40, 25))
    assert mouse.gizmo("spot").hovered == "target"
    plotter.phong.undo()
    assert mouse.gizmo("spot").hovered is None


def test_numbers_stand_beside_the_cursor_during_a_drag(mouse, plotter):
    def shown():
        return [text for text in texts(plotter) if "arriving" in text.GetInput()]

    start = mouse.at("lamp", "position")
    mouse.move(start)
    assert shown() == []
    mouse.press(start)
    for by in ((10, 6), (-30, 20)):
        mouse.move(start + by)
        plotter.render()
        (text,) = shown()
        x, y, z = mouse.gizmo("lamp").light.position
        assert text.GetInput().splitlines()[:2] == ["lamp: position", f"position ({x:.4g}, {y:.4g}, {z:.4g})"]
        assert np.abs(np.subtract(text.GetPosition(), start + by)).max() <= 20
    mouse.release()
    assert shown() == []


def test_handles_are_easier_to_hit_than_they_look_and_of_two_the_nearer_is_grabbed(new_mouse):
    mouse = new_mouse(*(PointLight(position=(x, -1, 1), name=name) for x, name in ((0, "left"), (0.1, "right"))))
    left, right = mouse.at("left", "position"), mouse.at("right", "position")
    across = right - left
    assert 4 < np.hypot(*across) < 20
    for at, hit in (
        *((left + part * across, "left") for part in (0.0, 0.3)),
        *((right - part * across, "right") for part in (0.0, 0.3)),
        *((left + off, "left") for off in ((-9, 0), (0, -9), (-6, 6))),
        (left - (20, 0), None),
    ):
        mouse.move(at)
        assert [gizmo.light.name for gizmo in mouse.plotter.phong.gizmos if gizmo.hovered] == [hit] * bool(hit)


@pytest.mark.parametrize("chosen", ["lamp", "double"])
def test_of_two_handles_in_one_place_the_selected_lights_is_grabbed(new_mouse, chosen):
    mouse = new_mouse(LAMP, replace(LAMP, name="double"))
    for gizmo in mouse.plotter.phong.gizmos:
        gizmo.is_selected = gizmo.light.name == chosen
    at = mouse.at("lamp", "position")
    mouse.press(at)
    mouse.move(np.add(at, (30, 0)))
    mouse.release()
    moved = [light.name for light in mouse.plotter.phong.lights if light.position != LAMP.position]
    assert moved == [chosen]


def test_gizmos_are_no_part_of_the_scene_and_removed_leave_nothing(new_mouse):
    def scene():
        shown.reset_camera()
        solid = [prop for prop in shown.renderer.GetViewProps() if prop.IsA("vtkProp3D")]
        return shown.bounds, solid, np.round(shown.camera.position, 9).tolist()

    mouse = new_mouse(LAMP, SPOT, SUN, gizmos=None)
    shown = mouse.plotter
    lit = shown.phong.mesh(shown.renderer.actors["ball"])
    before, evaluations = scene(), lit.evaluations
    clean, props = picture(shown), shown.renderer.GetViewProps().GetNumberOfItems()
    shown.phong.add_gizmos()
    assert scene() == before
    at = mouse.at("lamp", "position")
    assert not vtk.vtkPropPicker().Pick(*at, 0, shown.renderer)
    assert lit.evaluations - evaluations <= 1
    assert (picture(shown) != clean).any()
    for _ in range(2):
        shown.phong.remove_gizmos()
    assert shown.phong.gizmos == ()
    assert shown.renderer.GetViewProps().GetNumberOfItems() == props
    np.testing.assert_array_equal(picture(shown), clean)
    mouse.drag(at, (9, 9))
    assert shown.phong.lights == (LAMP, SPOT, SUN)


# --- status text ---


def test_the_selected_light_its_state_and_what_was_done_are_said(mouse, plotter):
    assert said(plotter) == "h: keys"
    mouse.key("n")
    assert said(plotter).split() == ["lamp:", "PointLight,", "intensity", "1,", "luminance", "0.585"]
    mouse.key("m")
    assert said(plotter).split()[-1] == "off"
    mouse.key("o")
    assert said(plotter).split()[-1] == "solo"
    marks = [text.GetInput() for text in texts(plotter) if text.GetInput() in ("off", "solo")]
    assert sorted(marks) == ["off", "off", "solo"]
    mouse.key("o")
    assert "solo" not in said(plotter)
    for key in ("z", "z", "z", "Right"):
        mouse.key(key)
    assert said(plotter).startswith("lamp: intensity 1.26")
    mouse.key("z")
    assert said(plotter).startswith("undone")
    mouse.key("z")
    assert said(plotter).startswith("nothing to undo")
    mouse.click(mouse.at("spot", "target"))
    assert said(plotter).startswith("spot: SpotLight")
    assert not plotter.phong.undo()  # a click is not recorded


def test_the_next_light_may_have_no_handles(new_mouse):
    mouse = new_mouse(replace(LAMP, frame="headlight", name="head"), LAMP, Glow(name="glow"), SPOT)
    assert [len(each.handles) for each in mouse.plotter.phong.gizmos] == [0, 2, 0, 3]
    selected = []
    for _ in range(6):
        mouse.key("n")
        selected += [each.light.name for each in mouse.plotter.phong.gizmos if each.is_selected] or [None]
        assert ("no light selected" in said(mouse.plotter)) == (selected[-1] is None)
    assert selected == ["head", "lamp", "glow", "spot", None, "head"]
    assert mouse.gizmo("head").highlight is None
    mouse.key("Right")
    assert said(mouse.plotter).startswith("head: intensity 1.26")


# --- selected lights and subplots ---


def test_only_some_lights(new_mouse):
    phong = new_mouse(LAMP, SPOT, SUN, gizmos=None).plotter.phong
    some = phong.add_gizmos(["spot", 0])
    assert sorted(each.light.name for each in some) == ["lamp", "spot"]
    phong.add_light(PointLight(name="late"))
    assert len(phong.gizmos) == 2
    phong.add_gizmos()
    phong.remove_light("sun")
    phong.add_light(PointLight(name="later"))
    assert [each.light.name for each in phong.gizmos] == ["lamp", "spot", "late", "later"]
    with pytest.raises(ValueError, match=r"^which must be a light of this renderer"):
        phong.add_gizmos(["moon"])
    assert len(phong.gizmos) == 4


def test_each_subplot_has_its_own(new_mouse):
    mouse = new_mouse(LAMP, SPOT, SUN, shape=(1, 2))
    shown = mouse.plotter
    shown.subplot(0, 1)
    furnish(shown, [LAMP])
    shown.phong.add_gizmos()
    assert [each.light for each in shown.phong.gizmos] == [LAMP]
    end = mouse.drag(mouse.at("lamp", "position"), (17, 8))
    np.testing.assert_allclose(mouse.at("lamp", "position"), end, atol=1.01)
    shown.subplot(0, 0)
    assert shown.phong.lights == (LAMP, SPOT, SUN)
    mouse.drag(mouse.at("lamp", "position"), (9, 8))
    assert shown.phong.lights[0] != LAMP
    shown.subplot(0, 1)
    shown.phong.remove_gizmos()
    assert shown.phong.gizmos == ()
    shown.subplot(0, 0)
    assert len(shown.phong.gizmos) == 3


@pytest.fixture
def two(new_mouse):
    """The mouse of two subplots with a selected light each, the second one active, and their interactions."""
    mouse = new_mouse(LAMP, shape=(1, 2))
    mouse.plotter.subplot(0, 1)
    furnish(mouse.plotter, [LAMP])
    mouse.plotter.phong.add_gizmos()
    interactions = [subplot.interaction for subplot in mouse.plotter.phong._subplots]
    for interaction in interactions:
        interaction.gizmos.select(interaction.gizmos.all[0])
    return mouse, interactions


LEFT, RIGHT = (20, 20), (220, 20)


def test_a_press_beside_a_handle_of_another_subplot_grabs_nothing_there(two):
    mouse, (first, _) = two
    at = first.gizmos.view.facing(LAMP.position, (198, 30))
    first.gizmos.all[0].renderer_light.set(replace(LAMP, position=tuple(at)), first.gizmos.lights.viewer)
    mouse.plotter.render()
    before = first.gizmos.lights.values
    mouse.drag((204, 30), (20, 5))
    assert first.gizmos.lights.values == before


def test_what_is_typed_in_one_subplot_is_no_command_in_another(two):
    mouse, (first, second) = two
    mouse.move(RIGHT)
    mouse.key("Return")
    type_keys(mouse, "12")
    mouse.move(LEFT)
    mouse.key("BackSpace")
    assert second.edit.text == "1"
    assert first.gizmos.lights.values == (LAMP,)


def test_a_digit_during_a_drag_is_no_command_in_the_subplot_under_the_cursor(two):
    mouse, (first, second) = two
    before = first.gizmos.lit.state
    mouse.pull(mouse.at("lamp", "position"), (9, 9))
    mouse.move(LEFT)
    mouse.key("5")
    assert second.edit.text == "5"
    assert first.gizmos.lit.state == before


def test_what_is_typed_is_taken_when_a_drag_begins_in_another_subplot(two):
    mouse, (first, second) = two
    mouse.move(LEFT)
    first.grabbed_last = "intensity"
    mouse.key("Return")
    type_keys(mouse, "3")
    mouse.drag(mouse.at("lamp", "position"), (9, 9))
    assert first.edit is None
    assert mouse.plotter.phong.undo()
    assert (first.gizmos.lights.values[0].intensity, second.gizmos.lights.values) == (3.0, (LAMP,))
    assert mouse.plotter.phong.undo()
    assert first.gizmos.lights.values == (LAMP,)


# --- removal ---


def test_what_is_typed_is_one_step_where_gizmos_are_taken_down(chosen):
    before = seen(chosen.plotter)
    chosen.key("Return")
    type_keys(chosen, "1.5")
    chosen.plotter.phong.remove_gizmos()
    assert_one_step(chosen.plotter, before)


@pytest.mark.parametrize("end", [pv.Plotter.close, pv.Plotter.deep_clean, pv.Plotter.clear])
def test_ended_during_a_drag(new_mouse, end):
    mouse = new_mouse(LAMP)
    plotter, at = mouse.plotter, mouse.pull(mouse.at("lamp", "position"), (9, 9))
    end(plotter)
    mouse.move(at + 3)
    if end is pv.Plotter.clear:  # gizmos of new lights work
        plotter.render()
        assert plotter.phong.gizmos == ()
        mouse.release(at + 3)
        furnish(plotter, [LAMP])
        mouse.drag(mouse.at("lamp", "position"), (9, 9))
        assert plotter.phong.lights[0].position != LAMP.position
    plotter.close()
    mouse.move(at + 6)
    mouse.release(at + 6)
    mouse.key("h")
