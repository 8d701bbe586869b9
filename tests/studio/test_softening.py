"""Soft shadows in a page: a few rays at once, as many as accuracy needs from a thread, none again for other edits."""

import threading

import numpy as np
import pytest
import pyvista as pv
from waiting import until

import pvphong as ph
from pvphong.rays import visibility
from pvphong.studio import softening

BALL = ph.SphereLight(position=(0, 1, 4), radius=0.8, intensity=16, name="ball")
WHITE = ph.Material(ambient=0.5, diffuse=0.9)
FEW = 16


@pytest.fixture
def efforts(monkeypatch, finer):
    """Numbers of samples of all lights and skies that are sampled, in order."""
    found, cast = [], visibility.look

    def look(*what, samples, **how):
        if samples is None:
            assert finer.wait(60.0)
        found.append(samples)
        return cast(*what, samples=samples, **how)

    monkeypatch.setattr(visibility, "look", look)
    return found


@pytest.fixture
def finer():
    """An event without which no more than a few rays are cast."""
    event = threading.Event()
    event.set()
    return event


@pytest.fixture
def page(new_plotter, monkeypatch):
    """A plotter as in a page, with a disc over a floor. The floor's shadows are drawn in steps, though it is small."""
    monkeypatch.setattr(softening, "_AT_ONCE", 100)
    plotter = new_plotter((100, 80))
    plotter.phong.light_model = ph.LightModel(shadows=True)
    plotter.phong.add_light(BALL)
    plotter.phong._subplot.lit.is_in_a_page = True
    plotter.phong.add_mesh(FLOOR.copy(), WHITE, name="floor")
    plotter.phong.add_mesh(HAT, WHITE, name="hat")
    return plotter


FLOOR = pv.Plane(i_size=4, j_size=4, i_resolution=30, j_resolution=30)
HAT = pv.Disc(center=(0, 0, 2), inner=0, outer=0.7, r_res=2, c_res=30)


def lit_of(plotter):
    return plotter.phong._subplot.lit


def floor(plotter):
    return np.asarray(lit_of(plotter).meshes[0].drawn["phong"]).astype(int)


def settle(plotter):
    """Poll as a page does, until no result is awaited."""
    lit = lit_of(plotter)

    def is_final():
        lit.refresh()
        return not lit.is_awaiting

    until(is_final)


def exact(plotter):
    lit = FLOOR.phong.shade(plotter.phong.scene, WHITE, occluders=[HAT])
    return np.rint(255.0 * lit["phong"]).astype(int)


def test_few_rays_at_once_and_all_of_them_later(page, efforts, finer):
    finer.clear()
    page.show(auto_close=False)
    assert set(efforts) == {FEW}
    assert lit_of(page).is_awaiting
    assert lit_of(page).note == "soft shadows grow finer"
    rough = floor(page)
    efforts.clear()
    finer.set()
    settle(page)
    assert set(efforts) == {None}
    assert lit_of(page).note == ""
    final = exact(page)
    assert np.abs(floor(page) - final).max() <= 1
    assert np.abs(rough - final).max() > 1
    assert np.abs(rough - final).mean() < 6.0


def test_brightness_and_colours_need_no_new_rays(page, efforts):
    page.show(auto_close=False)
    page.phong.set_light("ball", intensity=12.0)  # while the rays are cast
    page.render()
    settle(page)
    efforts.clear()
    page.phong.set_light("ball", intensity=8.0, diffuse="orange")
    page.render()
    assert efforts == []
    assert not lit_of(page).is_awaiting
    assert np.abs(floor(page) - exact(page)).max() <= 4  # rays for another brightness


def test_a_light_without_shadows_needs_no_rays(page, efforts):
    page.phong.set_light("ball", casts_shadows=False)
    lit_of(page).refresh()
    assert not lit_of(page).is_awaiting
    assert lit_of(page).note == ""
    assert not efforts
    page.phong.set_light("ball", casts_shadows=True)
    lit_of(page).refresh()
    assert lit_of(page).note == "soft shadows grow finer"
    settle(page)
    assert efforts.count(None) >= 1


def test_a_light_that_moves_again_starts_anew(page, efforts):
    page.show(auto_close=False)
    for x in (0.3, 0.6, 0.9):
        page.phong.set_light("ball", position=(x, 1, 4))
        page.render()
        assert lit_of(page).is_awaiting
    settle(page)
    assert np.abs(floor(page) - exact(page)).max() <= 1
    page.phong.add_light(ph.SphereLight(position=(-1, -1, 3), radius=0.3, intensity=3, name="other"))
    efforts.clear()
    page.render()
    assert efforts.count(FEW) == 2  # of the new light, from both meshes
    settle(page)
    assert efforts.count(None) == 2
    assert np.abs(floor(page) - exact(page)).max() <= 1


def test_pictures_are_final(page, efforts):
    page.show(auto_close=False)
    lit_of(page).is_in_a_page = False
    page.render()
    assert efforts[-1] is None
    assert not lit_of(page).is_awaiting
    lit_of(page).is_in_a_page = True
    page.phong.set_light("ball", position=(1, 1, 4))
    efforts.clear()
    page.screenshot(return_img=True)
    assert not lit_of(page).is_awaiting
    assert np.abs(floor(page) - exact(page)).max() <= 1


def test_a_mesh_that_cannot_be_lit_is_no_obstacle(page):
    page.show(auto_close=False)
    mesh = lit_of(page).meshes[1].mesh
    mesh.points[0] = np.nan
    mesh.clear_data()
    page.phong.set_light("ball", position=(1, 1, 4))
    page.render()
    settle(page)
    assert np.ptp(floor(page)) > 50
