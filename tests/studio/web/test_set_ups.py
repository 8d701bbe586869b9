"""The sun by date and place on the page: lights in W/m², their exposure, sliders, undo, and night."""

import importlib.util

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.scene.sun_by_date import SunByDate
from pvphong.studio import lit_actors
from pvphong.studio.web.document import Document
from pvphong.studio.web.downloads import Downloads, Picture

pytest.importorskip("pvlib")


@pytest.fixture
def plotter(new_plotter):
    plotter = new_plotter()
    ground = pv.Plane(i_size=8, j_size=8, i_resolution=12, j_resolution=12).triangulate()
    house = pv.Cube(center=(0, 0, 1), x_length=2, y_length=2, z_length=2).triangulate()
    plotter.phong.add_mesh(ground.append_polydata(house), ph.Material(), feature_angle=30, name="house")
    plotter.camera_position = "iso"
    plotter.phong.add_gizmos()
    return plotter


@pytest.fixture
def document(plotter):
    document = Document(plotter.phong, plotter.phong._subplot, plotter.phong._history)
    document.set_up("sun")
    return document


def picture(plotter):
    """Return the bytes of the lit colours."""
    plotter.phong._subplot.lit.refresh()
    return plotter.phong.mesh(plotter.actors["house"]).drawn["phong"].copy()


def test_lights_are_in_watts_and_the_picture_is_neither_black_nor_white(document, plotter):
    sun, sky = plotter.phong.lights
    assert (sun, sky) == SunByDate().lights()
    assert sun.intensity == pytest.approx(755, abs=10)
    model = plotter.phong.light_model
    assert (model.ambient, model.shadows, model.clamp) == (0.0, True, False)
    for hour in (10, 5, 19.5):
        document.edit("sun.hour", hour)
        drawn = picture(plotter)
        assert 40 < drawn.mean() < 230, hour
        assert 150 < np.percentile(drawn, 99) < 255, hour
        assert np.percentile(drawn, 5) > 5, hour
    lit = plotter.phong.mesh(plotter.actors["house"]).linear
    assert lit.max() == pytest.approx(0.8 * document.set_ups.sun.brightest, rel=0.3)


def test_a_movement_of_a_slider_is_one_step_and_the_sky_follows_when_it_rests(document, plotter):
    before, (_, sky) = document.state, plotter.phong.lights
    drawn = picture(plotter)
    for hour in (11.0, 13.0, 15.0):
        document.slide("sun.hour", hour)
        assert plotter.phong.lights == (SunByDate(hour=hour).sun, sky)
    document.settle()
    assert plotter.phong.lights == SunByDate(hour=15.0).lights()
    assert plotter.phong.display.exposure > before.display.exposure  # the sun is lower
    assert document.undo()
    assert document.state == before
    np.testing.assert_array_equal(picture(plotter), drawn)
    assert document.redo()
    assert plotter.phong.lights == SunByDate(hour=15.0).lights()
    document.edit("sun.hour", 12)  # from the redone state
    assert plotter.phong.lights == SunByDate(hour=12.0).lights()


def test_every_field_moves_the_sun(document, plotter):
    for field, value in {"latitude": "-33.9", "longitude": 151.2, "day": 355, "hour": "7.5", "up": "y"}.items():
        document.edit(f"sun.{field}", value)
    expected = SunByDate(-33.9, 151.2, 355, 7.5, "y")
    assert plotter.phong.lights == expected.lights()
    form = document.shown()["sun"]
    assert form["text"] == expected.words
    hour = form["fields"][3]
    assert (hour["label"], hour["unit"]) == ("hour", "UTC+10")
    document.slide("sun.day", 100.4)  # a slider with Shift
    assert document.set_ups.sun.day == 100
    with pytest.raises(ValueError, match=r"^latitude must be"):
        document.edit("sun.latitude", 95)


def test_a_brighter_exposure_stays_brighter(document, plotter):
    document.edit("display.exposure", plotter.phong.display.exposure + 1.5)
    for hour in (17, 10):
        document.edit("sun.hour", hour)
    alone = Document(plotter.phong, plotter.phong._subplot, plotter.phong._history)
    brighter = plotter.phong.display.exposure
    alone.set_up("sun")
    assert brighter == pytest.approx(plotter.phong.display.exposure + 1.5)


def test_at_night_the_view_keeps_the_last_daylight(document, plotter):
    document.slide("sun.hour", 18.0)
    lights = plotter.phong.lights
    document.slide("sun.hour", 23.0)
    document.settle()
    assert plotter.phong.lights == SunByDate(hour=18.0).lights()
    assert plotter.phong.lights[0] == lights[0]
    form = document.shown()["sun"]
    assert form["night"]
    assert form["text"].startswith("Night: on 21 June, 23:00 UTC+1 the sun is 16° below the horizon. The view keeps")
    document.edit("sun.hour", 9)
    assert plotter.phong.lights == SunByDate(hour=9.0).lights()


def test_rig_and_script_carry_the_sun_and_the_exposure(document, plotter, tmp_path):
    document.edit("sun.hour", 17)
    mesh = plotter.phong._subplot.lit.subjects[0]
    picture = Picture(display=plotter.phong.display)
    tolerance = document.set_ups.tolerance
    assert tolerance == pytest.approx(SunByDate(hour=17.0).brightest / 500.0, rel=0.05)
    downloads = Downloads({"house": mesh}, plotter.phong.scene, tolerance, "mesh", "house", {}, picture=picture)
    downloads.save_rig(tmp_path / "house-rig.json")
    scene = ph.Scene.load(tmp_path / "house-rig.json")
    assert scene.lights == SunByDate(hour=17.0).lights()
    assert scene.light_model == plotter.phong.light_model
    assert f"display=ph.Display(exposure={plotter.phong.display.exposure}, tone='filmic')" in downloads.script()
    assert document.shown()["lights"][0]["intensity"]["unit"] == "W/m²"


def test_a_deleted_sun_or_another_set_up_ends_it(document, plotter):
    plotter.phong.set_light("sky", on=False)
    document.edit("sun.hour", 15)
    assert [light.on for light in plotter.phong.lights] == [True, False]
    document.act("delete", document.shown()["lights"][0]["number"])
    assert document.shown()["sun"] is None
    with pytest.raises(ValueError, match=r'^sun must be that of the set-up "sun by date and place"; got none\.'):
        document.edit("sun.hour", 11)
    document.undo()
    assert document.shown()["sun"]["text"] == SunByDate(hour=15.0).words


def test_other_lights_get_their_exposure_back(document, plotter):
    """Lights of other set-ups and of rigs are not in W/m²."""
    with_sun = document.state
    for choose in (
        lambda: document.set_up("product"),
        lambda: document.replace_all(ph.Scene([ph.PointLight((0, 0, 9))]), {}, "default"),
    ):
        choose()
        assert document.shown()["sun"] is None
        assert plotter.phong.display == ph.Display()
        assert plotter.phong.light_model == ph.LightModel()
        document.undo()
        assert document.state == with_sun
    document.set_up("sun")
    document.edit("model.bounces", 2)
    document.set_up("rim")
    assert plotter.phong.display == ph.Display()
    assert plotter.phong.light_model == ph.LightModel(bounces=2)


def test_materials_of_a_rig_leave_the_sun(document, plotter):
    display = plotter.phong.display
    document.replace_all(None, {"default": ph.Material.named("gold")}, "default")
    assert plotter.phong.display == display
    assert document.shown()["sun"] is not None


def test_a_lamp_in_place_of_sun_and_sky_is_seen(document, plotter):
    for _ in range(2):
        document.act("delete", document.shown()["lights"][0]["number"])
    document.add("point")
    assert picture(plotter).max() > 100


def test_a_switch_of_the_suns_shadows_stays(document, plotter):
    plotter.phong.set_light("sun", casts_shadows=False)
    document.edit("sun.hour", 15)
    assert not plotter.phong.lights[0].casts_shadows


def test_a_new_lamp_is_as_bright_as_the_sun_needs(document, plotter):
    before = picture(plotter).mean()
    document.add("point")
    assert plotter.phong.lights[-1].intensity > 20
    assert picture(plotter).mean() > before + 3


def test_shadows_are_hard_only_while_a_slider_moves(document, plotter):
    lit = plotter.phong._subplot.lit
    for hour in (12.0, 10.0):  # and back
        document.slide("sun.hour", hour)
        assert lit.uses_preview_rays
    document.settle()
    assert not lit.uses_preview_rays


def test_without_pvlib_the_extra_is_named_and_nothing_changes(document, monkeypatch):
    document.undo()
    before, find = document.state, importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name == "pvlib" else find(name, *more))
    with pytest.raises(ValueError, match=r'^The set-up "sun" needs the extra "sun"\. Run: pip install pvlib\.$'):
        document.set_up("sun")
    assert document.state == before


def test_lights_in_watts_get_as_many_rays_as_a_picture_needs(document, plotter):
    """The error of a ray is judged after the exposure: 0.0039 of white, not 0.0039 W/m²."""
    picture(plotter)
    mesh = plotter.phong._subplot.lit.subjects[0]
    tolerances = [lit_actors._ray_tolerance(ph.Display(exposure=stops)) for stops in (2.0, 0.0, -1.9, -2.0, -9.0)]
    assert [255.0 * each for each in tolerances] == pytest.approx([1, 1, 1, 4, 256])
    assert mesh.ray_tolerance == lit_actors._ray_tolerance(plotter.phong.display) > 0.25
    document.edit("display.exposure", 0.0)
    picture(plotter)
    assert mesh.ray_tolerance == pytest.approx(1.0 / 255.0)
    expected = mesh.mesh.phong.shade(plotter.phong.scene, mesh.material, feature_angle=30)["phong"]
    np.testing.assert_allclose(mesh.linear, expected, atol=1e-3)  # 3 W/m² off without new rays
