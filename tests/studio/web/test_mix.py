"""Faders: a mix is a sum of shares, needs no new lighting, and can be applied to the lights."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.studio.web.document import Document
from pvphong.studio.web.mix import Fader, colors_of


@pytest.fixture
def plotter(new_plotter):
    plotter = new_plotter()
    plotter.phong.add_light(ph.DirectionalLight((0, 0.3, -1), diffuse=(0.9, 0.5, 0.2), ambient=(0.1, 0, 0), name="sun"))
    plotter.phong.add_light(ph.SphereLight(position=(2, 0, 0), radius=0.4, intensity=3, specular="blue", name="ball"))
    plotter.phong.add_light(ph.EnvironmentLight(image=(0.1, 0.2, 0.3), on=False, name="sky"))
    material = ph.Material(ambient=0.3, diffuse=(0.7, 0.6, 0.5), specular=0.4, shininess=12, emission=(0, 0.05, 0))
    plotter.phong.add_mesh(pv.Sphere(theta_resolution=20, phi_resolution=20), material, name="mesh")
    plotter.phong.add_gizmos()
    return plotter


@pytest.fixture
def document(plotter):
    document = Document(plotter.phong, plotter.phong._subplot, plotter.phong._history)
    frame(document, plotter)
    yield document
    document.mix.release()


def frame(document, plotter):
    """Update the lit colours and the mix, and return the colours of the next frame."""
    plotter.phong._subplot.lit.refresh()
    document.mix.refresh()
    return colors_of(plotter.phong._subplot.lit.meshes[0]).astype(int)


def evaluations(document, plotter):
    return document.mix.evaluations + plotter.phong._subplot.lit.meshes[0].evaluations


def assert_alike(colors, others):
    """Compare colours up to one 8-bit level, because of float32 rounding."""
    assert np.abs(colors - others).max() <= 1


@pytest.mark.parametrize("shadows", [False, True])
def test_a_mix_that_changes_nothing_shows_the_same(document, plotter, shadows):
    plotter.phong.light_model = ph.LightModel(shadows=shadows)
    plotter.phong.add_mesh(pv.Plane(center=(0, 0, -0.7), i_size=3, j_size=3, i_resolution=20, j_resolution=20))
    plain = frame(document, plotter)
    document.start_mix(True)
    assert_alike(frame(document, plotter), plain)
    document.edit("fader.1.gain", 0.0)
    assert np.abs(frame(document, plotter) - plain).max() > 30
    document.start_mix(False)
    np.testing.assert_array_equal(frame(document, plotter), plain)


def test_a_mesh_that_casts_no_shadows_casts_none_in_a_mix(document, plotter):
    plotter.phong.light_model = ph.LightModel(shadows=True)
    plate = pv.Plane(center=(0, -0.3, 0.9), i_resolution=9, j_resolution=9)
    plotter.phong.mesh(plotter.actors["mesh"]).mesh.copy_from(plotter.phong.mesh(plotter.actors["mesh"]).mesh + plate)
    plotter.phong._subplot.lit.meshes[0].casts_shadows = False
    plain = frame(document, plotter)
    document.start_mix(True)
    assert_alike(frame(document, plotter), plain)


def test_faders_evaluate_no_light_and_the_kept_mix_has_the_same_colours(document, plotter):
    plain = frame(document, plotter)
    document.start_mix(True)
    frame(document, plotter)
    begun = evaluations(document, plotter)
    document.slide("fader.1.gain", 1.5)
    for stops in (-1.0, 0.5, 0.25):
        document.slide("fader.2.gain", stops)
        frame(document, plotter)
    document.edit("fader.1.tint", "#8040ff")
    document.edit("fader.2.tint", 0.5, [0])
    document.edit("fader.3.muted", False)
    mixed = frame(document, plotter)
    assert evaluations(document, plotter) == begun
    assert np.abs(mixed - plain).max() > 30
    document.keep_mix()
    assert_alike(frame(document, plotter), mixed)
    sun, ball, sky = plotter.phong.lights
    assert sun.intensity == pytest.approx(2**1.5)
    assert sky.on
    assert ball.specular == (0.0, 0.0, 1.0)
    assert document.mix.faders == {}
    document.start_mix(False)
    assert_alike(frame(document, plotter), mixed)
    while document.undo():
        pass
    np.testing.assert_array_equal(frame(document, plotter), plain)


def test_each_fader_is_what_the_light_would_do(document, plotter):
    """Solo, mute and gain, each compared with a plotter that has such lights."""
    document.start_mix(True)
    document.edit("fader.2.gain", 0.5)
    document.solo_fader(2)
    alone = frame(document, plotter)
    document.solo_fader(2)
    document.edit("fader.1.muted", True)
    document.edit("fader.3.muted", True)
    assert_alike(frame(document, plotter), alone)
    document.start_mix(False)
    sun, ball, sky = plotter.phong.lights
    for number, light in enumerate((replace(sun, on=False), replace(ball, intensity=1.5), sky)):
        plotter.phong.set_light(number, light)
    assert_alike(frame(document, plotter), alone)


def test_what_changes_the_scene_evaluates_the_shares_again(document, plotter):
    document.start_mix(True)
    document.edit("fader.1.gain", 0.2)
    frame(document, plotter)
    begun = document.mix.evaluations
    plotter.camera.azimuth = 70  # moves the highlights
    moved = frame(document, plotter)
    assert document.mix.evaluations == begun + 1
    document.edit("material.0.diffuse", 0.1, [0])
    document.keep_mix()
    document.undo()
    document.undo()
    np.testing.assert_array_equal(frame(document, plotter), moved)


def test_mixing_is_undone_with_everything_else(document):
    document.start_mix(True)
    document.edit("fader.1.gain", 0.2)
    document.edit("light.1.intensity", 2.0)
    document.undo()
    assert next(iter(document.mix.faders.values())) == Fader(gain=0.2)
    document.undo()
    assert document.mix.faders == {}
    document.undo()
    assert not document.mix.is_on
    assert not document.history.can_undo


def test_a_soloed_light_that_goes_silences_no_other(document, plotter):
    document.start_mix(True)
    document.act("delete", 2)
    without = frame(document, plotter)
    assert document.undo()
    document.solo_fader(2)
    document.act("delete", 2)
    np.testing.assert_array_equal(frame(document, plotter), without)


def test_the_end_leaves_what_is_drawn_as_its_lights_light_it(document, plotter):
    plain = frame(document, plotter)
    document.start_mix(True)
    document.edit("fader.1.muted", True)
    frame(document, plotter)
    document.mix.release()
    np.testing.assert_array_equal(colors_of(plotter.phong._subplot.lit.meshes[0]), plain)


def test_what_is_no_sum_of_shares_is_refused(document, plotter):
    plotter.phong.light_model = ph.LightModel.vtk()
    plotter.phong.mesh(plotter.actors["mesh"]).material = ph.Material(reflectance=ph.PBR())
    for number in (2, 3):
        document.act("delete", number)
    with pytest.raises(ValueError, match="contributions add up"):
        document.start_mix(True)
    assert not document.mix.is_on


def test_a_mix_is_shown_with_the_exposure(document, plotter):
    document.start_mix(True)
    document.edit("fader.1.gain", 0.5)
    before = frame(document, plotter)
    document.edit("display.exposure", -1.0)
    darker = frame(document, plotter)
    dim = before < 250
    assert np.abs(darker - before / 2.0)[dim].max() <= 1.5
    document.start_mix(False)
    exposed = frame(document, plotter)
    document.edit("display.exposure", -2.0)
    assert (frame(document, plotter) < exposed).any()
    document.undo()
    np.testing.assert_array_equal(frame(document, plotter), exposed)
    document.undo()  # the end of the mix
    document.undo()  # the first exposure
    np.testing.assert_array_equal(frame(document, plotter), before)
