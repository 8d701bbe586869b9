"""Shadows in windows follow lights, meshes and their matrices; rays are traced again only for changes."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from mouse import Mouse

import pvphong as ph
from pvphong.rays import visibility
from pvphong.rays.casting import Caster
from pvphong.rays.visibility import Tracer

SUN = ph.DirectionalLight(direction=(0, 0, -1), name="sun")
LAMP = ph.PointLight(position=(1, 0, 4), name="lamp")
BALL = ph.SphereLight(position=(0, 1, 4), radius=0.6, intensity=16, name="ball")
WHITE = ph.Material(ambient=0.5, diffuse=0.9)


def hat():
    return pv.Disc(center=(0, 0, 2), inner=0, outer=0.7, r_res=2, c_res=30)


class Window:
    """A floor and another mesh over it."""

    def __init__(self, plotter, *lights, **model):
        self.plotter, self.phong = plotter, plotter.phong
        self.phong.light_model = ph.LightModel(**({"shadows": True} | model))
        for light in lights:
            self.phong.add_light(light)
        self.ground, self.over = pv.Plane(i_size=4, j_size=4, i_resolution=30, j_resolution=30), hat()
        self.floor = self.phong.add_mesh(self.ground, WHITE)
        self.hat = self.phong.add_mesh(self.over, WHITE)
        self.plotter.camera_position = [(0, -8, 5), (0, 0, 0), (0, 0, 1)]
        self.plotter.show(auto_close=False)

    @property
    def shown(self):
        return np.asarray(self.phong.mesh(self.floor).drawn["phong"])

    def check(self, *occluders, **options):
        self.plotter.render()
        lit = self.ground.phong.shade(self.phong.scene, WHITE, occluders=occluders, **options)
        assert np.abs(self.shown - 255.0 * lit["phong"]).max() <= 0.51


@pytest.fixture
def window(new_plotter):
    return lambda *lights, **model: Window(new_plotter((200, 200)), *lights, **model)


@pytest.fixture
def counted(monkeypatch):
    """Counts of traced lights, sampled skies and built casters."""
    counts = {"lights": [], "skies": [], "casters": []}

    def count(owner, name, key, what):
        original = getattr(owner, name)
        monkeypatch.setattr(owner, name, lambda *a, **how: counts[key].append(what(*a)) or original(*a, **how))

    count(Tracer, "light", "lights", lambda _, which: which.name)
    count(Tracer, "sky", "skies", lambda _: None)
    count(Caster, "__init__", "casters", lambda *_: None)
    return counts


def moved(x):
    matrix = np.eye(4)
    matrix[0, 3] = x
    return matrix


def test_shadows_follow_lights_meshes_and_matrices(window):
    w = window(SUN, LAMP, ambient_occlusion=True)
    w.check(hat())
    assert np.ptp(w.shown[:, 0]) > 100
    w.phong.set_light("lamp", replace(LAMP, position=(-1, 1, 3)))
    w.check(hat())
    w.hat.user_matrix = moved(0.5)
    w.check((hat(), moved(0.5)))
    w.floor.user_matrix = moved(0.2)
    w.check((hat(), moved(0.5)), matrix=moved(0.2))
    w.floor.user_matrix = np.eye(4)
    w.over.points = w.over.points * [2, 2, 1]
    bigger = hat()
    bigger.points = bigger.points * [2, 2, 1]
    w.check((bigger, moved(0.5)))


def test_hidden_and_removed_meshes_cast_none_nor_those_that_are_not_to(window):
    w = window(SUN)
    w.hat.visibility = False
    w.check()
    w.hat.visibility = True
    w.check(hat())
    w.plotter.remove_actor(w.hat)
    w.check()
    w.phong.add_mesh(hat(), WHITE, casts_shadows=False)
    w.check()
    with pytest.raises(ValueError, match="casts_shadows must be True or False"):
        w.phong.add_mesh(hat(), WHITE, casts_shadows="no")


def test_without_shadows_no_ray_is_cast_and_a_light_that_rides_along_takes_its_shadows_with_it(window, counted):
    w = window(ph.PointLight(frame="headlight", name="head"), shadows=False)
    w.check()
    assert not counted["lights"]
    w.phong.light_model = ph.LightModel(shadows=True)
    w.plotter.render()
    assert counted["lights"]
    w.check(hat())
    w.plotter.camera_position = [(2, -3, 9), (0, 0, 0), (0, 0, 1)]
    w.check(hat())
    for actor in (w.floor, w.hat):
        w.plotter.remove_actor(actor)
    counted["lights"].clear()
    w.phong.add_mesh(pv.Sphere(), WHITE)
    w.plotter.render()
    assert not counted["lights"]  # a single convex mesh does not shadow itself


def test_a_light_stops_casting_shadows_without_rays_and_begins_again(window, counted):
    w = window(SUN)
    lamp = w.phong.add_light(LAMP)
    w.check(hat())
    shadowed = w.shown.copy()
    counted["lights"].clear()
    lamp.casts_shadows = False
    w.plotter.render()
    assert not counted["lights"]
    assert (w.shown > shadowed).any()
    assert (w.shown >= shadowed).all()
    w.check(hat())
    counted["lights"].clear()
    lamp.casts_shadows = True
    w.plotter.render()
    assert counted["lights"] == ["lamp"] * 2
    np.testing.assert_array_equal(w.shown, shadowed)
    w.plotter.renderer.lights[1].shadow_attenuation = 0.0  # PyVista's name for it
    w.check(hat())
    assert not lamp.casts_shadows
    with pytest.raises(AttributeError, match="casts_shadows"):
        lamp.shadow_attenuation = 1.0


def test_only_what_moved_is_traced_again(window, counted):
    w = window(SUN, LAMP, ambient_occlusion=1.0)
    assert set(counted["lights"]) == {"lamp", "sun"}
    casters, skies = len(counted["casters"]), len(counted["skies"])
    counted["lights"].clear()
    for step in range(3):
        w.phong.set_light("lamp", replace(LAMP, position=(step, 1, 3)))
        w.plotter.render()
    assert counted["lights"] == ["lamp"] * 6
    counted["lights"].clear()
    w.phong.set_light("sun", replace(SUN, diffuse="red", intensity=0.4))
    w.phong.mesh(w.floor).material = replace(WHITE, diffuse=0.2)
    w.plotter.render()
    w.plotter.camera.azimuth = 30
    w.plotter.render()
    evaluations = w.phong.mesh(w.floor).evaluations
    w.plotter.render()
    assert w.phong.mesh(w.floor).evaluations == evaluations
    assert counted["lights"] == []
    assert (len(counted["casters"]), len(counted["skies"])) == (casters, skies)


def test_a_drag_has_hard_shadows_and_its_end_soft_ones(window, monkeypatch):
    w = window(BALL, SUN)
    efforts, look = [], visibility.look
    monkeypatch.setattr(visibility, "look", lambda *what, samples, **how: (
        efforts.append(samples) or look(*what, samples=samples, **how)))  # fmt: skip
    w.phong.add_gizmos()
    mouse = Mouse(w.plotter)
    end = mouse.pull(mouse.at("ball", "position"), (3, 1))
    w.plotter.render()
    assert efforts == []
    lit_mesh = w.phong.mesh(w.floor)._lit
    place = next(light.position for light in w.phong.lights if light.name == "ball")
    scene = replace(w.phong.scene, lights=[ph.PointLight(position=place), SUN])
    hard = w.ground.phong.visibility(scene, occluders=[hat()]).per_light
    np.testing.assert_array_equal(lit_mesh._visibility[1].per_light, hard)
    assert "hard shadows until the drag ends" in w.phong._subplot.lit.note
    rough = w.shown.copy()
    efforts.clear()
    mouse.release(end)
    assert set(efforts) == {None}
    assert w.phong._subplot.lit.note == ""
    w.check(hat())
    assert (rough != w.shown).any()


def test_polygons_of_a_file_are_added_while_shadows_are_on_and_not_modified(new_plotter, tmp_path):
    pv.Cylinder().save(tmp_path / "rod.vtp")
    plotter = new_plotter((64, 48))
    plotter.phong.light_model = ph.LightModel(shadows=True)
    plotter.phong.add_light(LAMP)
    rod = ph.read(tmp_path / "rod.vtp")
    modified = rod.GetPoints().GetMTime()
    plotter.phong.add_mesh(rod, WHITE)
    plotter.show(auto_close=False)
    assert rod.GetPoints().GetMTime() == modified
    assert plotter.phong._subplot.lit.meshes[0].drawn["phong"].any()
