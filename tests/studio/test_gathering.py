"""Bounced light in windows with slow rays: it is gathered in the background while everything else stays live."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from waiting import endless, until

import pvphong as ph
from pvphong.base import text, threads
from pvphong.rays.transport import HemisphereTracer, Transport
from pvphong.studio.lit_actors import LightingWarning
from pvphong.studio.web.document import Document

LAMP = ph.PointLight(position=(0.5, 0.2, 2.0), name="lamp")
WHITE = ph.Material(ambient=0.5, diffuse=0.9)


class Rays:
    """Rays that stop after a tenth until they are allowed to continue."""

    def __init__(self, monkeypatch):
        self.may, self.begun, self.stopped = threading.Event(), 0, 0
        cast = HemisphereTracer.cast

        def slow(tracer, *args):
            if threading.current_thread() is threading.main_thread():  # for expected values
                return cast(tracer, *args)
            self.begun += 1
            with text.about("rays"):
                text.counting(10)(1)
            try:
                while not self.may.is_set():
                    threads.go_on()
                    time.sleep(0.001)
            except threads.StoppedError:
                self.stopped += 1
                raise
            return cast(tracer, *args)

        monkeypatch.setattr(HemisphereTracer, "cast", slow)
        monkeypatch.setattr(Transport, "takes_long", property(lambda self: self._kept is None))


class Window:
    """A floor, a bowl over it, and gizmos; like a web page, it polls for background results."""

    def __init__(self, plotter):
        self.plotter, self.phong = plotter, plotter.phong
        self.phong.light_model = ph.LightModel(ambient=0.0)
        self.phong.add_light(LAMP)
        self.floor = pv.Plane(center=(0, 0, -0.6), i_size=3, j_size=3, i_resolution=8, j_resolution=8)
        self.bowl = pv.Sphere(start_phi=90, theta_resolution=16, phi_resolution=8).flip_faces()
        self.bowl.point_data.active_normals = self.bowl.phong.normals("angle")
        self.actors = [self.phong.add_mesh(mesh, WHITE) for mesh in (self.floor, self.bowl)]
        self.phong.add_gizmos()
        self.plotter.show(auto_close=False)
        self.lit = self.phong._subplot.lit
        self.lit.is_in_a_page = True
        self.document = Document(self.phong, self.phong._subplot, self.phong._history)

    def bounce(self, count):
        self.document.edit("model.bounces", count)
        self.plotter.render()

    def until_final(self):
        """Poll like a page."""
        until(lambda: self.lit.refresh() or not self.lit.is_awaiting)
        assert not self.lit.is_awaiting

    @property
    def shown(self):
        return [np.asarray(mesh.drawn["phong"]).astype(int) for mesh in self.lit.meshes]

    def check(self, material=WHITE, **model):
        """Check that the drawn colours equal those computed directly."""
        scene = replace(self.phong.scene, light_model=replace(self.phong.light_model, **model))
        lit = pv.MultiBlock([self.floor, self.bowl]).phong.shade(scene, material, feature_angle="auto")
        for shown, expected in zip(self.shown, lit, strict=True):
            np.testing.assert_allclose(shown, np.rint(255.0 * np.asarray(expected["phong"])), atol=1.0)


@pytest.fixture
def window(new_plotter):
    return Window(new_plotter((120, 90)))


@pytest.fixture
def rays(window, monkeypatch):  # after a frame without bounces
    assert window.shown
    return Rays(monkeypatch)


def test_all_is_live_while_rays_are_cast_once_and_then_light_bounces(window, rays):
    window.bounce(2)
    until(lambda: window.lit.gathering.part == 0.1)
    assert window.lit.is_awaiting
    window.plotter.render()
    assert window.lit.note == "computing bounced light: 10%"
    window.document.edit("light.1.intensity", 0.5)
    window.document.edit("model.bounces", 3)
    window.plotter.render()
    window.check(bounces=0)
    assert not window.lit.refresh()
    rays.may.set()
    window.until_final()
    assert not window.lit.is_awaiting
    assert window.lit.note == ""
    assert rays.begun == 1
    window.check()
    window.bounce(1)  # uses the cached rays
    window.check()
    assert not window.lit.is_awaiting


@pytest.mark.parametrize(
    ("light", "material"),
    [(ph.PointLight(position=(0.5, 0.2, 2.0), frame="camera"), WHITE), (LAMP, replace(WHITE, reflectance=ph.PBR()))],
    ids=["a light that moves with the camera", "a diffuse reflection that depends on the viewer"],
)
def test_light_bounces_for_where_the_camera_is(window, light, material):
    window.phong.set_light("lamp", replace(light, name="lamp"))
    for mesh in window.lit.meshes:
        mesh.material = material
    window.bounce(1)
    window.until_final()
    before = window.shown
    window.plotter.camera.azimuth = 100
    window.plotter.render()
    window.until_final()
    assert np.abs(window.shown[0] - before[0]).max() > 2
    window.check(material=material)


def test_cancelled_bounces_are_as_many_as_before(window, rays):
    before = window.shown
    assert window.document.cancel_bounces() == "Bounced light is not being computed."
    window.bounce(2)
    until(lambda: rays.begun)
    assert window.document.cancel_bounces() == "Bounced light is cancelled: bounces = 0, as before."
    until(lambda: rays.stopped)
    window.plotter.render()
    assert not window.lit.is_awaiting
    assert window.phong.light_model.bounces == 0
    for shown, own in zip(window.shown, before, strict=True):
        np.testing.assert_array_equal(shown, own)
    window.document.undo()  # the cancelling, then the edit
    window.document.undo()
    assert window.phong.light_model.bounces == 0
    assert not window.document.history.can_undo


def test_where_rays_are_not_kept_the_last_light_is_shown_until_there_is_another(window, rays, monkeypatch):
    monkeypatch.setattr(Transport, "is_kept", property(lambda _: False))
    rays.may.set()
    window.bounce(1)
    window.until_final()
    window.check()
    rays.may.clear()
    window.document.edit("light.1.intensity", 0.5)
    window.plotter.render()
    assert window.lit.is_awaiting
    window.check()  # scaling is exact for a single dimmed light
    window.bounce(4)
    assert "bounces = 1, as before" in window.document.cancel_bounces()
    window.plotter.render()
    assert window.phong.light_model.bounces == 1


def test_what_is_moved_meanwhile_is_gathered_again_and_what_is_hidden_is_not(window, rays):
    window.bounce(1)
    until(lambda: rays.begun == 1)
    window.actors[1].position = (0, 0, 0.5)
    window.plotter.render()
    until(lambda: rays.begun == 2 and rays.stopped == 1)
    for actor in window.actors:
        actor.visibility = False
    window.plotter.render()
    until(lambda: rays.stopped == 2)
    assert not window.lit.is_awaiting


@pytest.mark.parametrize("end", ["close", "stop"])
def test_the_end_of_a_window_is_that_of_its_rays(window, rays, end):
    window.bounce(1)
    until(lambda: rays.begun)
    window.plotter.close() if end == "close" else window.lit.stop()
    until(lambda: rays.stopped)


def test_pictures_and_windows_that_nobody_asks_again_wait(window, rays):
    window.bounce(2)
    assert window.lit.is_awaiting
    threading.Timer(0.2, rays.may.set).start()
    window.plotter.screenshot(return_img=True)
    window.check()
    window.lit.is_in_a_page = False
    window.actors[1].position = (0, 0, 0.1)
    window.plotter.render()
    assert not window.lit.is_awaiting


def test_refined_pictures_come_after_the_light(window, rays):
    window.document.edit("accuracy.refine", 0.05)
    window.bounce(1)
    until(lambda: rays.begun)
    assert not any(each.is_awaited for each in window.lit.refining.values())
    rays.may.set()
    window.plotter.screenshot(return_img=True)
    window.check()
    assert [bool(each.pictures) for each in window.lit.refining.values()] == [True, True]


def test_of_many_vertices_it_follows_when_a_drag_ends_in_the_lights_colours_meanwhile(window, monkeypatch):
    window.lit.is_in_a_page = False
    window.bounce(2)
    window.check()
    before = [mesh.evaluations for mesh in window.lit.meshes]
    window.plotter.render()
    assert [mesh.evaluations for mesh in window.lit.meshes] == before
    monkeypatch.setattr("pvphong.studio.gathering._LIVE", 10)
    window.lit.uses_preview_rays = True
    window.phong.set_light("lamp", replace(LAMP, intensity=0.5))
    window.plotter.render()
    assert window.lit.note == "bounced light is updated after the drag"
    window.check()  # scaling is exact for a single dimmed light
    window.lit.uses_preview_rays = False
    window.phong.set_light("lamp", replace(LAMP, position=(0, 1, 3)))
    window.plotter.render()
    assert window.lit.note == ""
    window.check()
    with pytest.raises(AssertionError):
        window.check(bounces=0)
    window.phong.mesh(window.actors[0]).material = ph.Material(diffuse=1.5)
    with pytest.warns(LightingWarning, match=r"got a material with a total reflectance of 1\.5\."):
        window.plotter.render()


@pytest.mark.usefixtures("rays")
def test_why_nothing_is_gathered_is_said(window, monkeypatch):
    def fail(*_):
        raise MemoryError("no room for rays")

    monkeypatch.setattr(HemisphereTracer, "cast", fail)

    def frames():
        window.bounce(1)
        window.until_final()
        window.plotter.render()

    with pytest.warns(LightingWarning, match="Bounced light could not be computed: no room for rays") as warned:
        frames()
    assert len(warned) == 1


def test_lights_are_not_mixed_where_light_bounces(window):
    window.document.start_mix(True)
    with pytest.raises(ValueError, match="bounces must be 0 in a mix; got 2"):
        window.document.edit("model.bounces", 2)
    assert window.phong.light_model.bounces == 0
    window.document.start_mix(False)
    window.bounce(1)
    with pytest.raises(ValueError, match="bounces must be 0 in a mix; got 1"):
        window.document.start_mix(True)
    assert not window.document.mix.is_on


# --- refining in a page


def test_refining_is_an_edit_that_is_undone_and_can_be_cancelled(window, monkeypatch):
    begun = []
    monkeypatch.setattr("pvphong.studio.refining._AFTER", 0.0)
    monkeypatch.setattr("pvphong.studio.refining.refine", endless(begun, []))
    window.document.edit("accuracy.refine", "0.02")
    assert [each.tolerance for each in window.lit.refining.values()] == [0.02, 0.02]
    window.plotter.render()
    until(lambda: len(begun) == 2)
    assert window.lit.is_awaiting
    window.document.cancel_refining()
    assert not window.lit.is_awaiting
    window.plotter.render()
    assert not window.lit.is_awaiting
    assert {each.reason for each in window.lit.refining.values()} == {"cancelled"}
    assert all(mesh.actor.mapper.dataset is mesh.drawn for mesh in window.lit.meshes)
    window.document.edit("light.1.intensity", 0.5)
    window.plotter.render()
    until(lambda: len(begun) == 4)
    window.document.start_mix(True)  # a mix has colours at the mesh's own vertices
    window.plotter.render()
    assert not window.lit.is_awaiting
    for _ in range(3):
        window.document.undo()
    assert not window.lit.refining


def test_a_studio_of_refined_meshes_says_so(new_plotter):
    plotter = new_plotter()
    plotter.phong.add_mesh(pv.Sphere(), refine=0.5)
    document = Document(plotter.phong, plotter.phong._subplot, plotter.phong._history)
    assert document.accuracy.refine == 0.5
    document.mix.release()
