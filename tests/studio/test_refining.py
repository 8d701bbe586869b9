"""Refined pictures in windows: shown while nothing changes; otherwise the mesh's own vertices are drawn."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from mouse import Mouse
from waiting import endless, until

import pvphong as ph
from pvphong.base import threads
from pvphong.studio import refining
from pvphong.studio.lit_actors import LightingWarning

LAMP = ph.PointLight(position=(0.3, 0.2, 3), name="lamp")
WHITE = ph.Material(ambient=0.3, diffuse=0.7)
SHINY = replace(WHITE, specular=0.3, shininess=30)
TOLERANCE = 0.02


class Window:
    """A floor under a ball, both refined."""

    def __init__(self, plotter, refine=TOLERANCE, **model):
        self.plotter, self.phong = plotter, plotter.phong
        self.phong.light_model = ph.LightModel(ambient=1.0, shadows=True, **model)
        self.phong.add_light(LAMP)
        self.ground = pv.Plane(i_size=4, j_size=4, i_resolution=12, j_resolution=12)
        self.ball = pv.Icosphere(radius=0.5, center=(0, 0, 1), nsub=3)
        self.floor = self.phong.add_mesh(self.ground, WHITE, refine=refine)
        self.over = self.phong.add_mesh(self.ball, SHINY, refine=refine)
        self.plotter.camera_position = [(0, -6, 5), (0, 0, 0.7), (0, 0, 1)]
        self.plotter.show(auto_close=False)

    def shows_own(self):
        meshes = {self.floor: self.ground, self.over: self.ball}
        shown = {actor: actor.mapper.dataset for actor in meshes}
        own = all(shown[actor] is self.phong.mesh(actor).drawn for actor in meshes)
        return own and all(shown[actor].n_points == mesh.n_points for actor, mesh in meshes.items())

    def wait(self):
        """Draw frames until the refined pictures are shown."""
        for _ in range(1000):
            self.plotter.render()
            if not self.shows_own():
                return
            time.sleep(0.01)
        raise AssertionError("no picture came")


@pytest.fixture
def window(new_plotter, monkeypatch):
    monkeypatch.setattr(refining, "_AFTER", 0.0)
    return lambda **options: Window(new_plotter((200, 200)), **options)


def test_a_picture_waits_for_what_refine_gives_and_own_vertices_are_lit_as_soon_as_something_moves(window):
    w = window()
    given = w.ground.copy()
    for light in (LAMP, replace(LAMP, position=(-0.5, 0.2, 3))):
        w.phong.set_light("lamp", light)
        w.plotter.render()
        assert (light is LAMP) or w.shows_own()
        image = w.plotter.screenshot(return_img=True)
        expected = w.ground.phong.refine(w.phong.scene, WHITE, tolerance=TOLERANCE, occluders=[w.ball])
        shown = w.floor.mapper.dataset
        np.testing.assert_array_equal(shown.points, expected.points)
        assert np.abs(shown["phong"] - 255 * expected["phong"]).max() <= 0.51
        assert expected.field_data["phong_refinement_cut"][0] > 20
        lit = w.ground.phong.shade(w.phong.scene, WHITE, occluders=[w.ball])
        assert np.abs(np.asarray(w.phong.mesh(w.floor).drawn["phong"]) - 255 * lit["phong"]).max() <= 0.51
    again = w.plotter.screenshot(return_img=True)
    np.testing.assert_array_equal(again, image)
    assert w.ground == given


def test_a_drag_shows_own_vertices_and_its_end_the_refined_ones(window):
    w = window()
    w.phong.add_gizmos()
    w.wait()
    mouse = Mouse(w.plotter)
    end = mouse.pull(mouse.at("lamp", "position"), (12, 5))
    w.plotter.render()
    assert w.shows_own()
    time.sleep(0.05)
    w.plotter.render()
    assert w.shows_own()
    mouse.release(end)
    w.wait()
    assert w.phong.lights[0].position != LAMP.position


def test_a_highlight_is_dragged_over_the_users_mesh(window):
    ends = []
    for refine in (TOLERANCE, None):
        w = window(refine=refine)
        w.phong.add_gizmos()
        mouse = Mouse(w.plotter)
        mouse.click(mouse.at("lamp", "position"))
        if refine:
            w.wait()
        place = mouse.at(mouse.gizmo("lamp").highlight)
        mouse.drag(place, (6, -4))
        ends.append(w.phong.lights[0].position)
    np.testing.assert_allclose(*ends, atol=1e-6)
    assert np.abs(np.array(ends[0]) - LAMP.position).max() > 0.01


def test_what_is_outdated_is_stopped_and_never_shown(window, monkeypatch):
    begun, stopped = [], []
    monkeypatch.setattr(refining, "refine", endless(begun, stopped))
    w = window()
    w.plotter.render()
    until(lambda: len(begun) == 2)
    w.phong.set_light("lamp", replace(LAMP, position=(1, 0, 3)))
    w.plotter.render()
    until(lambda: len(stopped) == 2)
    w.plotter.render()
    until(lambda: len(begun) == 4)
    assert w.shows_own()
    w.plotter.close()
    until(lambda: len(stopped) == 4)


@pytest.mark.parametrize("end", [pv.Plotter.close, pv.Plotter.render], ids=["close", "render"])
def test_nothing_is_refined_of_a_mesh_that_is_removed(window, monkeypatch, end):
    begun, stopped = [], []
    monkeypatch.setattr(refining, "refine", endless(begun, stopped))
    w = window()
    w.plotter.render()
    until(lambda: len(begun) == 2)
    w.plotter.remove_actor([w.floor, w.over])
    end(w.plotter)
    until(lambda: len(stopped) == len(begun))  # the second one may have started again after a frame


def test_coarse_pictures_come_first_and_a_paused_one_goes_on(new_plotter, monkeypatch):
    asked, may_go_on, refine = [], threading.Event(), refining.refine

    def slowly(surface, *args, **options):
        asked.append(options["tolerance"])
        while len(asked) == 3 and not may_go_on.is_set():
            threads.go_on()
            time.sleep(0.001)
        return refine(surface, *args, **options)

    plotter = new_plotter((200, 200))
    plotter.show(auto_close=False)
    monkeypatch.setattr(refining, "_AFTER", 0.0)
    monkeypatch.setattr(refining, "refine", slowly)
    plotter.phong.add_light(LAMP)
    floor = plotter.phong.add_mesh(
        pv.Plane(i_size=6, j_size=6, i_resolution=4, j_resolution=4), SHINY, refine=TOLERANCE / 4
    )
    (job,) = plotter.phong._subplot.lit.refining.values()
    until(lambda: plotter.render() or len(asked) == 3)
    plotter.render()
    np.testing.assert_allclose(asked, np.array([4, 1, 1 / 4]) * TOLERANCE)
    assert (job.is_awaited, job.reached) == (True, TOLERANCE)
    assert 0.2 < job.part < 0.5
    coarse = floor.mapper.dataset
    job.pause()
    may_go_on.set()
    time.sleep(0.05)
    plotter.render()
    assert (job.is_paused, job.seconds) == (True, 0.0)
    assert floor.mapper.dataset is coarse
    job.go_on()
    until(lambda: plotter.render() or not job.is_awaited)
    assert (job.reached, job.reason) == (TOLERANCE / 4, "")
    assert floor.mapper.dataset.n_points > coarse.n_points


def test_a_cancelled_picture_stays_as_it_is(window, monkeypatch):
    begun, stopped, refine = [], [], refining.refine

    def work(surface, *args, **options):
        return (refine if options["tolerance"] > 5 * TOLERANCE else endless(begun, stopped))(surface, *args, **options)

    w = window()
    monkeypatch.setattr(refining, "refine", work)
    w.phong.set_light("lamp", replace(LAMP, position=(-0.5, 0.2, 3)))
    w.wait()
    until(lambda: w.plotter.render() or len(begun) == 2)
    w.plotter.render()
    shown = w.floor.mapper.dataset
    for each in w.phong._subplot.lit.refining.values():
        each.pause()
        each.cancel()
    until(lambda: len(stopped) == 2)
    w.plotter.render()
    assert w.floor.mapper.dataset is shown
    assert not w.shows_own()


def test_what_cannot_be_refined_is_said_once_and_drawn_as_it_is(window, monkeypatch):
    def failing(*_, **__):
        raise ValueError("no light in this one")

    monkeypatch.setattr(refining, "refine", failing)
    with pytest.warns(LightingWarning, match="A mesh could not be refined: no light in this one") as warned:
        w = window()
    assert len(warned) == 2  # for the floor and the ball
    w.plotter.screenshot(return_img=True)  # a repeated warning would be an error
    assert w.shows_own()


def test_light_that_bounces_is_in_refined_pictures(window):
    w = window(bounces=1)
    w.plotter.screenshot(return_img=True)
    own, shown = w.phong.mesh(w.floor).drawn, w.floor.mapper.dataset
    assert shown.n_points > own.n_points
    np.testing.assert_allclose(shown["phong"][: own.n_points].astype(int), own["phong"], atol=1)
    direct = w.ground.phong.shade(replace(w.phong.scene, light_model=ph.LightModel(ambient=0.0, shadows=True)), WHITE)
    assert np.abs(own["phong"] - 255.0 * direct["phong"]).max() > 5.0


@pytest.mark.parametrize("given", [0, -1.0, "fine", True, float("nan")])
def test_another_tolerance_is_refused_and_nothing_is_drawn(new_plotter, given):
    plotter = new_plotter()
    with pytest.raises(ValueError, match="refine must be"):
        plotter.phong.add_mesh(pv.Sphere(), refine=given)
    assert not plotter.actors
