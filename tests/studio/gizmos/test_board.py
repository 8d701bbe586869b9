"""Gizmos in a plotter, moved by events as a window would send them."""

import dataclasses
import gc
import resource
import weakref
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
import vtk
from mouse import Mouse

import pvphong  # noqa: F401 registers plotter.phong wherever PyVista's own discovery is not installed
from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material

LAMP = PointLight(position=(0.8, -0.4, 0.9), attenuation=(1, 0, 1), diffuse=(1, 0.5, 0.2), name="lamp")
SPOT = SpotLight(position=(-0.7, 0.2, 1.0), direction=(0.7, -0.2, -1.0), cone_angle=20, exponent=4, name="spot")
SUN = DirectionalLight(direction=(1, 1, -1), diffuse=(0.3, 0.3, 0.5), name="sun")
SHINY = Material(ambient=0.1, diffuse=0.6, specular=0.5, shininess=30)
LIGHTS = {"lamp": LAMP, "spot": SPOT, "sun": SUN}


@pytest.fixture
def new_plotter():
    made = []

    def make(lights=(LAMP, SPOT, SUN), lighting="none", **options):
        plotter = pv.Plotter(off_screen=True, window_size=(400, 300), lighting=lighting, **options)
        made.append(plotter)
        furnish(plotter, lights)
        return plotter

    yield make
    for each in made:
        each.close()


def furnish(plotter, lights):
    for light in lights:
        plotter.phong.add_light(light)
    plotter.phong.add_mesh(pv.Sphere(theta_resolution=40, phi_resolution=40), SHINY, name="ball")
    plotter.camera_position = [(0, -5, 2.5), (0, 0, 0.2), (0, 0, 1)]
    plotter.show(auto_close=False)


@pytest.fixture
def plotter(new_plotter):
    shown = new_plotter()
    shown.phong.add_gizmos()
    shown.render()
    return shown


def colors(plotter):
    return np.asarray(plotter.renderer.actors["ball"].mapper.dataset["phong"]).copy()


def gizmo(plotter, name):
    return next(each for each in plotter.phong.gizmos if each.light.name == name)


def handle_at(plotter, name, handle):
    return Mouse(plotter).at(gizmo(plotter, name).handles[handle])


EACH = [
    ("lamp", "position"),
    ("lamp", "radius"),
    ("spot", "position"),
    ("spot", "target"),
    ("spot", "cone"),
    ("sun", "target"),
]
CHANGED = {"position": {"position"}, "radius": {"attenuation"}, "target": {"direction"}, "cone": {"cone_angle"}}


# --- dragging ---


@pytest.mark.parametrize(("name", "handle"), EACH)
def test_a_drag_changes_the_light_and_the_colours_and_undo_restores_both(plotter, name, handle):
    mouse, before, lit = Mouse(plotter), plotter.phong.lights, colors(plotter)
    end = mouse.drag(handle_at(plotter, name, handle), (-14, 18))
    light = gizmo(plotter, name).light
    different = {f.name for f in dataclasses.fields(light) if getattr(light, f.name) != getattr(LIGHTS[name], f.name)}
    assert different == (CHANGED[handle] | {"direction"} if (name, handle) == ("spot", "position") else CHANGED[handle])
    assert (colors(plotter) != lit).any()
    if handle in ("position", "target") and name != "sun":
        np.testing.assert_allclose(handle_at(plotter, name, handle), end, atol=1.01)
    after = plotter.phong.lights
    dragged = colors(plotter)
    assert plotter.phong.undo()
    plotter.render()
    assert plotter.phong.lights == before
    np.testing.assert_array_equal(colors(plotter), lit)
    assert not plotter.phong.undo()
    assert plotter.phong.redo()
    plotter.render()
    assert plotter.phong.lights == after
    np.testing.assert_array_equal(colors(plotter), dragged)


def test_the_icon_of_a_directional_light_stays_where_it_is(plotter):
    def icon():
        chosen = gizmo(plotter, "sun")
        along = np.array(chosen.light.direction) / np.linalg.norm(chosen.light.direction)
        size = 0.6 * 0.95 * 0.5 * np.linalg.norm([1, 1, 1])  # the arrow's length, by the ball's bounds
        return chosen.handles["target"] - size * along

    before = icon()
    end = Mouse(plotter).drag(handle_at(plotter, "sun", "target"), (22, -9))
    np.testing.assert_allclose(icon(), before, atol=2e-3)
    start, tip = Mouse(plotter).at(icon()), handle_at(plotter, "sun", "target")
    assert np.cross([*(tip - start), 0], [*(end - start), 0])[2] / np.hypot(*(end - start)) == pytest.approx(0, abs=1)


def test_the_mesh_follows_while_the_button_is_down(plotter):
    mouse, lit = Mouse(plotter), colors(plotter)
    start = handle_at(plotter, "lamp", "position")
    mouse.press(start)
    np.testing.assert_array_equal(colors(plotter), lit)
    mouse.move(start + np.array((20, 5)))
    assert (colors(plotter) != lit).any()
    assert not plotter.phong.undo()  # it is not finished
    mouse.release(start + np.array((20, 5)))
    assert plotter.phong.undo()


def test_a_window_that_was_resized_without_a_frame(plotter):
    """As trame does it at each press, when fewer pixels are to be drawn while the button is down."""
    mouse, scale = Mouse(plotter), 0.5
    where = handle_at(plotter, "lamp", "position")
    plotter.render_window.SetSize(200, 150)
    mouse.move(scale * where)
    assert gizmo(plotter, "lamp").hovered == "position"
    plotter.render_window.SetSize(400, 300)
    end = mouse.drag(where, (20, 5))
    assert gizmo(plotter, "lamp").light != LAMP
    np.testing.assert_allclose(handle_at(plotter, "lamp", "position"), end, atol=1.01)


def test_views_of_the_plotter_are_told_of_every_new_picture(plotter):
    """PyVista's views in a browser know a new picture by the plotter's render callbacks."""
    drawn, mouse = [], Mouse(plotter)
    plotter.add_on_render_callback(lambda _: drawn.append(plotter.image))
    mouse.move(handle_at(plotter, "lamp", "position"))
    assert len(drawn) == 1
    mouse.key("h")
    assert len(drawn) == 2
    assert (drawn[0] != drawn[1]).any()


def test_a_drag_is_no_movement_of_the_camera(plotter):
    before = plotter.camera.position
    Mouse(plotter).drag(handle_at(plotter, "lamp", "position"), (20, 5))
    assert plotter.camera.position == before
    Mouse(plotter).drag((5, 5), (20, 30))
    assert plotter.camera.position != before


def test_a_click_is_no_step_and_selects(plotter):
    mouse, start = Mouse(plotter), handle_at(plotter, "spot", "target")
    mouse.press(start)
    mouse.release(start)
    assert gizmo(plotter, "spot").is_selected
    assert not gizmo(plotter, "lamp").is_selected
    assert not plotter.phong.undo()


@pytest.mark.parametrize(("name", "handle"), EACH)
def test_escape_puts_everything_back(plotter, name, handle):
    mouse, before, lit = Mouse(plotter), plotter.phong.lights, colors(plotter)
    start = handle_at(plotter, name, handle)
    mouse.press(start)
    mouse.move(start + np.array((25, -9)))
    assert plotter.phong.lights != before
    mouse.key("Escape")
    assert plotter.phong.lights == before
    np.testing.assert_array_equal(colors(plotter), lit)
    mouse.move(start + np.array((30, -9)))
    mouse.release(start + np.array((30, -9)))
    assert plotter.phong.lights == before
    assert not plotter.phong.undo()


def test_modifiers_constrain_and_snap(plotter):
    mouse = Mouse(plotter)
    mouse.drag(handle_at(plotter, "lamp", "position"), (-31, 2), shift=True)
    moved = np.array(gizmo(plotter, "lamp").light.position) - LAMP.position
    assert np.count_nonzero(np.abs(moved) > 1e-9) == 1
    mouse.drag(handle_at(plotter, "spot", "cone"), (-9, 0), control=True)
    assert gizmo(plotter, "spot").light.cone_angle % 5 == 0


def test_steps_can_be_chosen(new_plotter):
    shown = new_plotter()
    shown.phong.add_gizmos(angle_step=7.5, length_step=0.125)
    shown.render()
    Mouse(shown).drag(handle_at(shown, "lamp", "position"), (-31, 12), control=True)
    steps = np.array(gizmo(shown, "lamp").light.position) / 0.125
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    with pytest.raises(ValueError, match=r"^angle_step must be a finite number > 0 and <= 90; got 0"):
        shown.phong.add_gizmos(angle_step=0)
    assert len(shown.phong.gizmos) == 3


@pytest.mark.parametrize("moves_on", [True, False])
def test_a_light_removed_during_a_drag(plotter, moves_on):
    mouse, start = Mouse(plotter), handle_at(plotter, "lamp", "position")
    mouse.press(start)
    mouse.move(start + np.array((20, 5)))
    plotter.phong.remove_light("lamp")
    if moves_on:
        mouse.move(start + np.array((25, 5)))
        plotter.render()
    mouse.release(start + np.array((30, 5)))
    assert [light.name for light in plotter.phong.lights] == ["spot", "sun"]
    assert [each.light.name for each in plotter.phong.gizmos] == ["spot", "sun"]
    assert plotter.phong.undo()
    assert len(plotter.phong.lights) == 3
    assert not plotter.phong.undo()  # the drag was not finished
    before = plotter.camera.position
    mouse.drag((5, 5), (20, 30))  # the mouse is everybody's again
    assert plotter.camera.position != before
    camera = plotter.camera.position
    mouse.drag(handle_at(plotter, "spot", "target"), (9, 9))
    assert gizmo(plotter, "spot").light != SPOT
    assert plotter.camera.position == camera


@pytest.mark.parametrize("light_type", ["scene light", "camera light"])
@pytest.mark.parametrize("positional", [True, False])
def test_a_light_of_pyvista_is_changed_in_place(new_plotter, light_type, positional):
    light = pv.Light(position=(0.6, -0.3, 0.9), light_type=light_type, positional=positional, cone_angle=30)
    shown = new_plotter(lights=())
    shown.add_light(light)
    (only,) = shown.phong.add_gizmos()
    shown.render()
    state = light.position, light.focal_point, light.cone_angle
    lit = colors(shown)
    Mouse(shown).drag(Mouse(shown).at(only.handles["target"]), (16, 12))
    assert (light.position, light.focal_point, light.cone_angle) != state
    assert light.GetLightType() == pv.Light(light_type=light_type).GetLightType()
    assert (colors(shown) != lit).any()
    shown.phong.undo()
    shown.render()
    assert (light.position, light.focal_point, light.cone_angle) == state
    np.testing.assert_array_equal(colors(shown), lit)


def test_code_moves_the_gizmo(new_plotter):
    shown = new_plotter(lights=())
    light = pv.Light(position=(0.6, -0.3, 0.9), positional=True, cone_angle=30, light_type="scene light")
    shown.add_light(light)
    (only,) = shown.phong.add_gizmos()
    light.position = (0.5, 0.25, 1.5)
    shown.render()
    assert only.light.position == (0.5, 0.25, 1.5)
    assert only.handles["position"] == (0.5, 0.25, 1.5)
    Mouse(shown).drag(Mouse(shown).at((0.5, 0.25, 1.5)), (10, 4))
    assert light.position != (0.5, 0.25, 1.5)


def test_a_headlight_has_no_handles(new_plotter):
    shown = new_plotter(lights=[dataclasses.replace(LAMP, frame="headlight")])
    (only,) = shown.phong.add_gizmos()
    shown.render()
    assert only.handles == {}
    assert only.light.frame == "headlight"


def test_a_light_in_the_cameras_frame_stays_in_it(new_plotter):
    shown = new_plotter(lights=[PointLight(position=(0.5, 0.4, -4.0), frame="camera", name="torch")])
    shown.phong.add_gizmos()
    shown.render()
    end = Mouse(shown).drag(handle_at(shown, "torch", "position"), (18, 9))
    light = shown.phong.lights[0]
    assert light.frame == "camera"
    assert light.position[2] == pytest.approx(-4.0)
    np.testing.assert_allclose(handle_at(shown, "torch", "position"), end, atol=1.01)
    shown.camera.azimuth = 40
    shown.render()
    np.testing.assert_allclose(handle_at(shown, "torch", "position"), end, atol=1.01)


# --- the highlight ---


@pytest.mark.parametrize("light", [LAMP, SPOT, dataclasses.replace(SUN, direction=(1, 0.5, -0.3))])
def test_the_highlight_is_dragged_on_the_surface(new_plotter, light):
    shown = new_plotter(lights=[light])
    (only,) = shown.phong.add_gizmos()
    assert only.highlight is None  # not selected
    mouse = Mouse(shown)
    handle = mouse.at(next(iter(only.handles.values())))
    mouse.press(handle)
    mouse.release(handle)
    start = mouse.at(only.highlight)
    mouse.move(start)
    assert only.hovered == "highlight"
    end = mouse.drag(start, (12, -15))
    assert only.light != light
    np.testing.assert_allclose(mouse.at(only.highlight), end, atol=5)  # to the nearest vertex
    assert shown.phong.undo()
    assert shown.phong.lights == (light,)


def test_off_the_surface_the_highlight_waits(plotter):
    mouse, chosen = Mouse(plotter), gizmo(plotter, "lamp")
    mouse.press(handle_at(plotter, "lamp", "position"))
    mouse.release(mouse.interactor.GetEventPosition())
    plotter.render()
    start = mouse.at(chosen.highlight)
    mouse.press(start)
    mouse.move(start + np.array((5, -5)))
    on_surface = chosen.light
    mouse.move((399, 299))
    assert chosen.light == on_surface
    mouse.release((399, 299))


# --- looks ---


def picture(plotter):
    plotter.render()
    return plotter.image.astype(int)


def test_hovering_shows(plotter):
    away = picture(plotter)
    Mouse(plotter).move(handle_at(plotter, "spot", "target"))
    assert gizmo(plotter, "spot").hovered == "target"
    over = picture(plotter)
    x, y = handle_at(plotter, "spot", "target").astype(int)
    rows = slice(300 - y - 12, 300 - y + 12)
    assert (over[rows, x - 12 : x + 12] != away[rows, x - 12 : x + 12]).any()
    Mouse(plotter).move((3, 3))
    assert gizmo(plotter, "spot").hovered is None
    np.testing.assert_array_equal(picture(plotter), away)


def test_nothing_is_hovered_before_the_cursor_has_come(plotter):
    assert [each.hovered for each in plotter.phong.gizmos] == [None, None, None]


def test_a_handle_that_is_taken_away_from_under_the_cursor_is_not_hovered_any_more(plotter):
    start = handle_at(plotter, "lamp", "position")
    end = Mouse(plotter).drag(start, (40, 25))
    assert gizmo(plotter, "lamp").hovered == "position"
    plotter.phong.undo()
    assert gizmo(plotter, "lamp").hovered is None
    away = picture(plotter)
    Mouse(plotter).move(end + 1)
    np.testing.assert_array_equal(picture(plotter), away)
    Mouse(plotter).move(start)
    plotter.phong.redo()
    assert gizmo(plotter, "lamp").hovered is None


def test_numbers_stand_beside_the_cursor_during_a_drag(plotter):
    def shown():
        return [prop for prop in plotter.renderer.GetViewProps() if prop.IsA("vtkTextActor") and prop.GetVisibility()]

    mouse, start = Mouse(plotter), handle_at(plotter, "lamp", "position")
    mouse.move(start)
    assert shown() == []
    mouse.press(start)
    for by in ((10, 6), (-30, 20)):
        mouse.move(start + by)
        plotter.render()
        (text,) = shown()
        x, y, z = gizmo(plotter, "lamp").light.position
        assert text.GetInput().splitlines()[:2] == ["lamp: position", f"position ({x:.4g}, {y:.4g}, {z:.4g})"]
        assert np.abs(np.subtract(text.GetPosition(), start + by)).max() <= 20
    mouse.release(start + by)
    assert shown() == []


def test_handles_are_easier_to_hit_than_they_look(plotter):
    for offset in ((9, 0), (0, -9), (6, 6)):
        Mouse(plotter).move(handle_at(plotter, "lamp", "position") + offset)
        assert gizmo(plotter, "lamp").hovered == "position"
    Mouse(plotter).move(handle_at(plotter, "lamp", "position") + np.array((20, 0)))
    assert gizmo(plotter, "lamp").hovered is None


def test_of_two_handles_the_nearer_is_grabbed(new_plotter):
    near = dataclasses.replace(LAMP, attenuation=(1, 0, 0))
    pair = [dataclasses.replace(near, position=(x, -1, 1), name=name) for x, name in ((0, "left"), (0.1, "right"))]
    shown = new_plotter(lights=pair)
    shown.phong.add_gizmos()
    left, right = (handle_at(shown, name, "position") for name in ("left", "right"))
    assert 4 < np.hypot(*(left - right)) < 20
    for at, other, name in ((left, right, "left"), (right, left, "right")):
        for part in (0.0, 0.3):
            Mouse(shown).move(at + part * (other - at))
            hovered = [gizmo.light.name for gizmo in shown.phong.gizmos if gizmo.hovered]
            assert hovered == [name]


def test_a_handle_inside_the_mesh_can_be_grabbed(new_plotter):
    shown = new_plotter(lights=[dataclasses.replace(LAMP, position=(0, 0, 0))])
    shown.phong.add_gizmos()
    shown.render()
    Mouse(shown).drag(handle_at(shown, "lamp", "position"), (30, 0))
    assert shown.phong.lights[0].position != (0, 0, 0)


def test_gizmos_are_no_part_of_the_scene(new_plotter):
    shown = new_plotter()
    bounds = shown.bounds
    solid = [prop for prop in shown.renderer.GetViewProps() if prop.IsA("vtkProp3D")]
    shown.reset_camera()
    position = shown.camera.position
    evaluations = shown.phong.evaluations
    shown.phong.add_gizmos()
    shown.render()
    assert shown.bounds == bounds
    assert [prop for prop in shown.renderer.GetViewProps() if prop.IsA("vtkProp3D")] == solid
    shown.reset_camera()
    np.testing.assert_allclose(shown.camera.position, position)
    picker = vtk.vtkPropPicker()
    x, y = handle_at(shown, "lamp", "position")
    assert not picker.Pick(x, y, 0, shown.renderer)
    assert shown.phong.evaluations - evaluations <= 1


def test_behind_the_camera_a_handle_cannot_be_grabbed(plotter):
    plotter.camera_position = [(0.8, -0.4, 0.4), (0.8, 5, 0.4), (0, 0, 1)]
    plotter.phong.set_light("lamp", dataclasses.replace(LAMP, position=(0.8, -5, 0.4)))
    plotter.render()
    before = plotter.phong.lights
    Mouse(plotter).drag((200, 150), (11, 0))
    assert plotter.phong.lights == before


# --- which, and where ---


def test_only_some_lights(new_plotter):
    shown = new_plotter()
    some = shown.phong.add_gizmos(["spot", 0])
    assert sorted(each.light.name for each in some) == ["lamp", "spot"]
    shown.phong.add_light(PointLight(name="late"))
    assert len(shown.phong.gizmos) == 2
    shown.phong.add_gizmos()
    assert len(shown.phong.gizmos) == 4
    with pytest.raises(ValueError, match=r"^which must be a light of this renderer"):
        shown.phong.add_gizmos(["moon"])
    assert len(shown.phong.gizmos) == 4


def test_lights_added_later_get_one_and_removed_ones_lose_it(plotter):
    plotter.phong.add_light(PointLight(name="late", position=(0, 0, 1)))
    assert [each.light.name for each in plotter.phong.gizmos] == ["lamp", "spot", "sun", "late"]
    plotter.phong.remove_light("spot")
    assert [each.light.name for each in plotter.phong.gizmos] == ["lamp", "sun", "late"]


def test_each_subplot_has_its_own(new_plotter):
    shown = new_plotter(shape=(1, 2))
    shown.subplot(0, 1)
    furnish(shown, [LAMP])
    for column in (0, 1):
        shown.subplot(0, column)
        shown.phong.add_gizmos()
        shown.render()
    assert len(shown.phong.gizmos) == 1
    end = Mouse(shown).drag(handle_at(shown, "lamp", "position"), (17, 8))
    np.testing.assert_allclose(handle_at(shown, "lamp", "position"), end, atol=1.01)
    shown.subplot(0, 0)
    assert shown.phong.lights == (LAMP, SPOT, SUN)
    Mouse(shown).drag(handle_at(shown, "lamp", "position"), (9, 8))
    assert shown.phong.lights[0] != LAMP
    shown.subplot(0, 1)
    shown.phong.remove_gizmos()
    assert shown.phong.gizmos == ()
    shown.subplot(0, 0)
    assert len(shown.phong.gizmos) == 3


# --- the end ---


def test_removed_gizmos_leave_nothing(new_plotter):
    shown = new_plotter()
    props = shown.renderer.GetViewProps().GetNumberOfItems()
    clean = picture(shown)
    shown.phong.add_gizmos()
    spot = handle_at(shown, "lamp", "position")
    assert (picture(shown) != clean).any()
    shown.phong.remove_gizmos()
    shown.phong.remove_gizmos()
    assert shown.phong.gizmos == ()
    assert shown.renderer.GetViewProps().GetNumberOfItems() == props
    np.testing.assert_array_equal(picture(shown), clean)
    Mouse(shown).move(spot)
    Mouse(shown).drag(spot, (9, 9))
    assert shown.phong.lights == (LAMP, SPOT, SUN)


def test_closed_with_gizmos_up():
    shown = pv.Plotter(off_screen=True, window_size=(200, 150))
    furnish(shown, [LAMP])
    watched = [weakref.ref(each) for each in shown.phong.add_gizmos()]
    interactor = shown.iren.interactor
    shown.close()
    interactor.InvokeEvent("MouseMoveEvent")
    interactor.InvokeEvent("KeyPressEvent")
    shown.close()
    del shown
    gc.collect()
    assert [ref() for ref in watched] == [None] * len(watched)


def test_closed_during_a_drag():
    shown = pv.Plotter(off_screen=True, window_size=(200, 150), lighting="none")
    furnish(shown, [LAMP])
    shown.phong.add_gizmos()
    shown.render()
    mouse = Mouse(shown)
    start = handle_at(shown, "lamp", "position")
    mouse.press(start)
    mouse.move(start + np.array((9, 9)))
    shown.close()
    mouse.move(start + np.array((12, 9)))
    mouse.release(start + np.array((12, 9)))


def test_cleaned_during_a_drag():
    shown = pv.Plotter(off_screen=True, window_size=(200, 150), lighting="none")
    furnish(shown, [LAMP])
    shown.phong.add_gizmos()
    mouse = Mouse(shown)
    mouse.press(handle_at(shown, "lamp", "position"))
    shown.deep_clean()
    mouse.move((100, 70))
    shown.close()
    mouse.move((110, 70))
    mouse.release((110, 70))


def test_the_subplot_is_switched_during_a_drag(new_plotter):
    shown = new_plotter(shape=(1, 2))
    shown.phong.add_gizmos()
    start = handle_at(shown, "lamp", "position")
    Mouse(shown).press(start)
    shown.subplot(0, 1)
    Mouse(shown).move(start + np.array((12, 8)))
    Mouse(shown).release(start + np.array((12, 8)))
    assert shown.phong.lights == ()
    shown.subplot(0, 0)
    np.testing.assert_allclose(handle_at(shown, "lamp", "position"), np.round(start + np.array((12, 8))), atol=1.01)
    shown.subplot(0, 1)
    assert shown.phong.undo()
    shown.subplot(0, 0)
    assert shown.phong.lights == (LAMP, SPOT, SUN)


@pytest.mark.parametrize("change", ["edited", "removed", "replaced"])
def test_the_mesh_changes_while_its_highlight_is_dragged(new_plotter, change):
    mesh = pv.Sphere(theta_resolution=40, phi_resolution=40)
    shown = new_plotter(lights=[LAMP])
    shown.phong.add_mesh(mesh, SHINY, name="ball")
    (only,) = shown.phong.add_gizmos()
    mouse = Mouse(shown)
    mouse.press(handle_at(shown, "lamp", "position"))
    mouse.release(mouse.interactor.GetEventPosition())
    start = mouse.at(only.highlight)
    mouse.press(start)
    mouse.move(start + np.array((5, -5)))
    if change == "edited":
        mesh.points *= 0.5
        mesh.copy_from(pv.Sphere(theta_resolution=9, phi_resolution=7))
    elif change == "removed":
        shown.remove_actor("ball")
    else:
        shown.phong.add_mesh(pv.Cube(), SHINY, name="ball")
    mouse.move(start + np.array((9, -9)))
    shown.render()
    mouse.release(start + np.array((12, -12)))
    assert shown.phong.undo()
    assert shown.phong.lights == (LAMP,)


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the process's memory is read as Linux tells it")
def test_neither_memory_nor_objects_pile_up_over_a_thousand_updates(new_plotter):
    """VTK's memory is not Python's to trace. Colours of this mesh that were kept at each update would be 67 MB."""
    shown = new_plotter(lights=[LAMP])
    shown.phong.add_mesh(pv.Sphere(theta_resolution=150, phi_resolution=150), SHINY, name="ball")
    shown.phong.add_gizmos()

    def used():
        gc.collect()
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize() / 1e6, len(gc.get_objects())

    def updates(count):
        for step in range(count):
            shown.phong.set_light("lamp", dataclasses.replace(LAMP, position=(0.8, -0.4, 0.9 + 1e-4 * step)))
            shown.phong._pane.refresh()  # as before each frame

    updates(300)  # `undo` keeps so many steps and no more
    (megabytes, objects), evaluated = used(), shown.phong.evaluations
    updates(1000)
    assert shown.phong.evaluations == evaluated + 1000
    assert used()[0] < megabytes + 10
    assert used()[1] < objects + 500


def test_a_cleared_plotter_keeps_its_gizmos_of_new_lights(plotter):
    plotter.clear()
    plotter.render()
    assert plotter.phong.gizmos == ()
    furnish(plotter, [LAMP])
    plotter.render()
    Mouse(plotter).drag(handle_at(plotter, "lamp", "position"), (9, 9))
    assert plotter.phong.lights[0].position != LAMP.position
