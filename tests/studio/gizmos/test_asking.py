"""A spot is dragged brighter or darker, and the intensities of lights follow."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from mouse import Mouse, texts

import pvphong as ph
from pvphong.studio.gizmos.asking import PIXELS_PER_STOP
from pvphong.studio.gizmos.gizmo import SPOT_SIZE

LEFT = ph.DirectionalLight(direction=(1, 0.6, -0.3), intensity=0.3, name="left")
RIGHT = ph.DirectionalLight(direction=(-1, 0.6, -0.3), intensity=0.3, name="right")
MATTE = ph.Material(ambient=0.0, diffuse=0.8)
BALL = pv.Sphere(theta_resolution=40, phi_resolution=40)
SPOT = (-0.35, -0.357, 0.0)  # on the left, where only the left light arrives


def window(new_plotter, *lights, model=None, mesh=BALL, scale=1):
    plotter = new_plotter((400 * scale, 300 * scale))
    plotter.render_window.SetDPI(72 * scale)
    for light in lights:
        plotter.phong.add_light(light)
    plotter.phong.add_mesh(mesh, MATTE)
    plotter.phong.light_model = model or ph.LightModel(ambient=0.0)
    plotter.camera_position = [(0, -4, 0.5), (0, 0, 0), (0, 0, 1)]
    plotter.show(auto_close=False)
    plotter.phong.add_gizmos()
    return Mouse(plotter)


def luminance(plotter, place):
    """Return the luminance of the lit ball at its point nearest to a place."""
    lit = BALL.phong.shade(plotter.phong.scene, MATTE, feature_angle="auto")
    nearest = np.argmin(np.square(lit.points - place).sum(axis=1))
    return float(lit["phong"][nearest] @ [0.2126, 0.7152, 0.0722])


def stops(mouse, amount):
    """Drag the spot by a number of stops; the next step begins with the button up."""
    return mouse.drag(mouse.at(SPOT), (0, amount * PIXELS_PER_STOP))


def test_the_light_that_reaches_the_spot_follows_and_one_undo_takes_it_back(new_plotter):
    mouse = window(new_plotter, LEFT, RIGHT)
    phong, camera = mouse.plotter.phong, mouse.plotter.camera_position
    before = luminance(mouse.plotter, SPOT)
    mouse.key("space")
    stops(mouse, 1.0)
    left, right = phong.lights
    assert luminance(mouse.plotter, SPOT) == pytest.approx(2 * before, rel=0.1)
    assert left.intensity == pytest.approx(0.6, rel=0.1)
    assert right.intensity == pytest.approx(0.3, rel=0.2)
    assert replace(left, intensity=0.3) == LEFT
    assert mouse.plotter.camera_position == camera
    assert phong.undo()
    assert phong.lights == (LEFT, RIGHT)
    assert not phong.undo()
    assert phong.redo()
    stops(mouse, -2.0)
    assert luminance(mouse.plotter, SPOT) == pytest.approx(before / 2, rel=0.2)


def test_the_selected_light_alone_follows(new_plotter):
    mouse = window(new_plotter, LEFT, replace(RIGHT, direction=(-0.2, 1, -0.2)))
    mouse.key("n")
    mouse.key("n")
    mouse.key("space")
    stops(mouse, 1.0)
    left, right = mouse.plotter.phong.lights
    assert left == LEFT
    assert right.intensity > 0.4


def test_escape_restores_the_lights_and_space_turns_the_view_again(new_plotter):
    mouse = window(new_plotter, LEFT, RIGHT)
    mouse.key("space")
    mouse.pull(mouse.at(SPOT), (0, 60))
    assert mouse.plotter.phong.lights != (LEFT, RIGHT)
    assert any("+1.00 stops: luminance" in text.GetInput() for text in texts(mouse.plotter))
    mouse.key("Escape")
    assert mouse.plotter.phong.lights == (LEFT, RIGHT)
    mouse.release()
    assert not mouse.plotter.phong.undo()
    mouse.key("space")
    camera = mouse.plotter.camera_position
    mouse.drag(mouse.at(SPOT), (40, 20))
    assert mouse.plotter.camera_position != camera
    assert mouse.plotter.phong.lights == (LEFT, RIGHT)


def test_a_press_beside_the_mesh_turns_the_view_and_the_wheel_sets_the_size(new_plotter):
    mouse = window(new_plotter, LEFT, RIGHT)
    mouse.key("space")
    camera = mouse.plotter.camera_position
    mouse.send("MouseWheelForwardEvent", mouse.at(SPOT))
    assert mouse.plotter.camera_position == camera
    assert any("spot: 0.19" in text.GetInput() for text in texts(mouse.plotter))
    mouse.drag((10, 290), (20, -10))
    assert mouse.plotter.camera_position != camera
    assert mouse.plotter.phong.lights == (LEFT, RIGHT)


def test_a_larger_spot_asks_for_more(new_plotter):
    found = []
    for wheel in ("MouseWheelBackwardEvent", "MouseWheelForwardEvent"):
        mouse = window(new_plotter, LEFT, RIGHT)
        mouse.key("space")
        for _ in range(6):
            mouse.send(wheel, mouse.at(SPOT))
        stops(mouse, 1.0)
        found.append(mouse.plotter.phong.lights[1].intensity)
    assert found[1] > found[0]  # the right light arrives in the larger spot


def test_a_dark_spot_becomes_darker(new_plotter):
    mouse = window(new_plotter, replace(LEFT, intensity=0.01))
    mouse.key("space")
    stops(mouse, -0.5)
    assert mouse.plotter.phong.lights[0].intensity == pytest.approx(0.01 / np.sqrt(2), rel=0.05)


def test_a_press_without_a_move_before_it_finds_what_is_there(new_plotter):
    lamp = ph.PointLight(position=(0.1, -1.2, 0.2), name="lamp")  # before the ball
    mouse = window(new_plotter, LEFT, lamp)
    mouse.key("space")
    pixel = mouse.at("lamp", "position")
    mouse.move((3, 3))
    mouse.send("LeftButtonPressEvent", pixel)
    mouse.move(np.add(pixel, (0, 30)))
    mouse.release()
    left, moved = mouse.plotter.phong.lights
    assert left == LEFT
    assert moved.position != lamp.position


def test_a_spot_between_vertices_is_the_nearest_one_with_an_area(new_plotter):
    found = []
    for points in (BALL.points, np.append(BALL.points, [SPOT], axis=0)):  # a point that no triangle uses
        mouse = window(new_plotter, LEFT, RIGHT, mesh=pv.PolyData(points, BALL.faces))
        mouse.key("space")
        for _ in range(20):
            mouse.send("MouseWheelBackwardEvent", mouse.at(SPOT))
        stops(mouse, 1.0)
        found.append(mouse.plotter.phong.lights[0].intensity)
    assert found[1] == pytest.approx(found[0], rel=1e-6)
    assert found[0] > 0.5


def test_a_screen_with_twice_the_pixels_takes_twice_as_many(new_plotter):
    mouse = window(new_plotter, LEFT, scale=2)
    mouse.key("space")
    stops(mouse, 1.0)
    assert mouse.plotter.phong.lights[0].intensity == pytest.approx(0.3 * np.sqrt(2), rel=0.05)


def test_shadows_count_and_what_no_light_reaches_is_said(new_plotter):
    mouse = window(new_plotter, RIGHT, model=ph.LightModel(ambient=0.0, shadows=True))
    mouse.key("space")
    mouse.pull(mouse.at(SPOT), (0, 60))
    assert any("none of these lights reaches the spot" in text.GetInput() for text in texts(mouse.plotter))
    assert mouse.plotter.phong.lights[0].intensity == pytest.approx(0.3, rel=1e-6)
    mouse.release()
    dark = window(new_plotter, replace(LEFT, on=False))
    dark.key("space")
    stops(dark, 1.0)
    assert any("no light follows" in text.GetInput() for text in texts(dark.plotter))


def test_where_light_does_not_add_up_that_is_said(new_plotter):
    mouse = window(new_plotter, LEFT, model=ph.LightModel.vtk())
    shiny = ph.Material(reflectance=ph.PBR(metallic=0.5, roughness=0.4))
    mouse.plotter.phong.add_mesh(BALL.translate((2, 0, 0)), shiny, reset_camera=False)
    mouse.key("space")
    stops(mouse, 1.0)
    assert any("light does not add up" in text.GetInput() for text in texts(mouse.plotter))
    assert mouse.plotter.phong.lights[0].intensity == LEFT.intensity


FLOOR = pv.Plane(center=(0, -1, 0), i_size=2, j_size=2, i_resolution=12, j_resolution=12).triangulate()
WALL = pv.Plane(center=(0, 0, 1), direction=(0, -1, 0), i_size=2, j_size=2, i_resolution=12, j_resolution=12)
PARTS = {"floor": FLOOR, "wall": WALL.triangulate()}
ROOM = pv.MultiBlock(PARTS)
ON_WALL = (0.1, 0.0, 0.5)
# The sun grazes the wall, which has its light from the floor alone.
SUN, FRONT = ph.DirectionalLight((0, 0, -1), intensity=0.6, name="sun"), replace(LEFT, direction=(0, 1, -0.1))


def room(new_plotter, *lights, bounces=2):
    plotter = new_plotter((400, 300))
    for light in lights:
        plotter.phong.add_light(light)
    for name, mesh in PARTS.items():
        plotter.phong.add_mesh(mesh, MATTE, name=name)
    plotter.phong.light_model = ph.LightModel(ambient=0.0, bounces=bounces)
    plotter.camera_position = [(0, -6, 1.5), (0, 0, 0.8), (0, 0, 1)]
    plotter.show(auto_close=False)
    plotter.phong.add_gizmos()
    return Mouse(plotter)


def areas(mesh):
    """Return a third of the area of the triangles around each point."""
    corners = mesh.regular_faces
    a, b, c = mesh.points[corners].transpose(1, 0, 2).astype(float)
    each = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    return np.bincount(corners.ravel(), np.repeat(each, 3), mesh.n_points)


def test_bounced_light_counts_as_in_a_fit_with_bounces(new_plotter):
    """The fit's target and weights are computed here from the description of what is asked for."""
    mouse = room(new_plotter, SUN, FRONT)
    scene = mouse.plotter.phong.scene
    mouse.key("space")
    mouse.drag(mouse.at(ON_WALL), (0, PIXELS_PER_STOP))
    found = [light.intensity for light in mouse.plotter.phong.lights]
    (spot, radius) = mouse.plotter.phong._subplot.interaction.gizmos.spot
    assert np.linalg.norm(np.subtract(spot.point, ON_WALL)) < 0.02
    assert radius == pytest.approx(SPOT_SIZE * np.sqrt(3.0), rel=0.01)  # of half the diagonal of a box of 2 × 2 × 2
    shown = ROOM.phong.shade(scene, MATTE, precision="float64")
    points, area = (np.concatenate([of(mesh) for mesh in PARTS.values()]) for of in (lambda m: m.points, areas))
    seen = np.concatenate([shown[name]["phong"] for name in PARTS]) @ [0.2126390, 0.7151687, 0.0721923]
    falls = np.maximum(1.0 - (np.linalg.norm(points - spot.point, axis=1) / radius) ** 2, 0.0)
    own = area * falls
    target, weights = np.where(falls > 0.0, 2.0 * seen, seen), 10.0 * own / own.sum() + area / area.sum()
    parts = dict(zip(PARTS, (slice(0, FLOOR.n_points), slice(FLOOR.n_points, None)), strict=True))
    how = {
        "target": {name: target[rows] for name, rows in parts.items()},
        "weights": {name: (weights / area)[rows] for name, rows in parts.items()},
        "vary": "intensity",
    }

    def fitted(bounces):
        model = replace(scene.light_model, bounces=bounces, clamp=False)
        return [
            light.intensity for light in ROOM.phong.fit(replace(scene, light_model=model), MATTE, **how).scene.lights
        ]

    np.testing.assert_allclose(found, fitted(2), rtol=1e-4)
    assert abs(fitted(0)[1] / found[1] - 1.0) > 0.05


def test_a_spot_that_only_bounced_light_reaches_is_dragged_brighter(new_plotter):
    mouse = room(new_plotter, SUN)
    mouse.key("space")
    mouse.pull(mouse.at(ON_WALL), (0, PIXELS_PER_STOP))
    assert not any("none of these lights reaches the spot" in text.GetInput() for text in texts(mouse.plotter))
    assert mouse.plotter.phong.lights[0].intensity > 0.7
    mouse.key("Escape")
    assert mouse.plotter.phong.lights == (SUN,)
    mouse.release()
    direct = room(new_plotter, SUN, bounces=0)
    direct.key("space")
    direct.pull(direct.at(ON_WALL), (0, PIXELS_PER_STOP))
    assert any("none of these lights reaches the spot" in text.GetInput() for text in texts(direct.plotter))


def test_until_bounced_light_is_shown_nothing_can_be_asked(new_plotter, monkeypatch):
    mouse = room(new_plotter, SUN)
    gathering = mouse.plotter.phong._subplot.lit.gathering
    monkeypatch.setattr(gathering, "transport", lambda _: None)
    mouse.key("space")
    stops(mouse, 1.0)
    assert any("bounced light is still being computed" in text.GetInput() for text in texts(mouse.plotter))
    assert mouse.plotter.phong.lights == (SUN,)


def test_escape_ends_asking_and_forgets_the_chosen_lights(new_plotter):
    mouse = window(new_plotter, LEFT, RIGHT)
    gizmos = mouse.plotter.phong._subplot.interaction.gizmos
    mouse.key("space")
    gizmos.followers = [gizmos.all[1].renderer_light]
    stops(mouse, 1.0)
    assert mouse.plotter.phong.lights[0] == LEFT
    mouse.key("Escape")
    assert not gizmos.asks
    assert gizmos.followers is None
    camera = mouse.plotter.camera_position
    mouse.drag(mouse.at(SPOT), (40, 20))
    assert mouse.plotter.camera_position != camera


def test_while_the_mix_is_shown_nothing_can_be_asked(new_plotter):
    mouse = window(new_plotter, LEFT, RIGHT)
    mouse.key("space")
    mouse.plotter.phong._subplot.lit.is_mixed = True
    stops(mouse, 1.0)
    assert any("the mix is shown" in text.GetInput() for text in texts(mouse.plotter))
    assert mouse.plotter.phong.lights == (LEFT, RIGHT)
